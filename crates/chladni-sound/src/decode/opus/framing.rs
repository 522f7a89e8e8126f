//! Splits a packet of several Opus streams, in which all but the last state their own length.

/// Copies the first packet of `data`, which is self-delimited (RFC 6716, appendix B), as a stand-alone
/// packet into `packet`, and returns the rest of `data`. `None` if `data` is damaged.
pub(super) fn split_off<'a>(data: &'a [u8], packet: &mut Vec<u8>) -> Option<&'a [u8]> {
    packet.clear();
    let (&toc, mut rest) = data.split_first()?;
    packet.push(toc);
    let payload = match toc & 3 {
        // One frame, or two of the same length: only the length is removed, because a stand-alone packet
        // omits it.
        0 => length(&mut rest)?.0,
        1 => 2 * length(&mut rest)?.0,
        2 => {
            let (first, written) = length(&mut rest)?;
            packet.extend_from_slice(written);
            first + length(&mut rest)?.0
        }
        _ => return split_off_many(rest, packet),
    };
    packet.extend_from_slice(rest.get(..payload)?);
    rest.get(payload..)
}

/// The same for any number of frames. Padding is dropped. `packet` already holds the first byte.
fn split_off_many<'a>(data: &'a [u8], packet: &mut Vec<u8>) -> Option<&'a [u8]> {
    const VARIABLE: u8 = 0x80;
    const PADDED: u8 = 0x40;
    let (&kind, mut rest) = data.split_first()?;
    packet.push(kind & !PADDED);
    let mut padding = 0;
    let mut more = if kind & PADDED == 0 { 0 } else { 255 };
    while more == 255 {
        (more, rest) = rest.split_first().map(|(&more, after)| (more, after))?;
        padding += usize::from(more.min(254));
    }
    let frames = usize::from(kind & 0x3f);
    let mut payload = 0;
    if kind & VARIABLE == 0 {
        payload = frames * length(&mut rest)?.0;
    } else {
        for frame in 0..frames {
            let (len, written) = length(&mut rest)?;
            payload += len;
            if frame + 1 < frames {
                packet.extend_from_slice(written);
            }
        }
    }
    packet.extend_from_slice(rest.get(..payload)?);
    rest.get(payload..)?.get(padding..)
}

/// The length of a frame (RFC 6716 §3.2.1). The bytes that state it are removed from `rest`.
fn length<'a>(rest: &mut &'a [u8]) -> Option<(usize, &'a [u8])> {
    let first = usize::from(*rest.first()?);
    let (len, size) = if first < 252 { (first, 1) } else { (first + 4 * usize::from(*rest.get(1)?), 2) };
    let (written, after) = rest.split_at(size);
    *rest = after;
    Some((len, written))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn split(data: &[u8]) -> Option<(Vec<u8>, Vec<u8>)> {
        let mut packet = Vec::new();
        let rest = split_off(data, &mut packet)?.to_vec();
        Some((packet, rest))
    }

    #[test]
    fn only_the_last_length_goes() {
        let cases: [(&[u8], &[u8], &[u8]); 5] = [
            (&[0b100, 2, 7, 8, 99], &[0b100, 7, 8], &[99]),
            (&[0b101, 1, 7, 8, 99], &[0b101, 7, 8], &[99]),
            (&[0b110, 1, 2, 7, 8, 9, 99], &[0b110, 1, 7, 8, 9], &[99]),
            // Two frames of one length with three bytes of padding.
            (&[0b111, 0x42, 3, 1, 7, 8, 0, 0, 0, 99], &[0b111, 0x02, 7, 8], &[99]),
            // Three frames of lengths 1, 0 and 2.
            (&[0b111, 0x83, 1, 0, 2, 7, 8, 9], &[0b111, 0x83, 1, 0, 7, 8, 9], &[]),
        ];
        for (data, packet, rest) in cases {
            assert_eq!(split(data), Some((packet.to_vec(), rest.to_vec())));
        }
        let long = [&[0b100, 252, 1][..], &[5; 256]].concat();
        assert_eq!(split(&long), Some(([&[0b100][..], &[5; 256]].concat(), Vec::new())));
        assert_eq!(split(&long[..200]), None);
    }

    proptest! {
        #[test]
        fn no_bytes_make_it_panic(data in proptest::collection::vec(any::<u8>(), 0..400)) {
            let _ = split(&data);
        }
    }
}
