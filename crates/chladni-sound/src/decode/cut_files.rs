//! Files that were cut: MP4, Matroska and Ogg, whose readers look behind the sound before they play it.

use std::io::{Read, Result, Seek, SeekFrom};

use super::mended::{Ending, Lengths};
use super::mp4_edits::box_at;

/// The most boxes or elements that are visited; fragments of some seconds make hours of sound.
const MAX_PARTS: usize = 1 << 16;
/// Where a file may end that is taken for longer than it is; file systems do not seek much further.
const LAST_END: u64 = 1 << 40;
/// The longest page of Ogg in bytes (RFC 3533 §6).
const LONGEST_PAGE: u64 = 27 + 255 + 255 * 255;
/// The identifier of the element of Matroska that holds the sound, with the marker of its length.
const SEGMENT: u64 = 0x1853_8067;

/// An MP4 file that ends within its sound goes on to where that is stated to end: its reader passes over what does not fit.
/// Only boxes of samples are taken for longer than they are, as their tables say what to read of them.
pub(super) fn mp4<R: Read + Seek + ?Sized>(source: &mut R) -> Result<Lengths> {
    let end = source.seek(SeekFrom::End(0))?;
    let mut at = 0;
    for _ in 0..MAX_PARTS {
        let (kind, _, length) = box_at(source, at)?;
        // One without a length reaches to the end.
        let next = length.filter(|length| *length >= 8).and_then(|length| at.checked_add(length));
        let Some(next) = next.filter(|next| *next <= LAST_END) else { break };
        if next > end {
            return Ok(match &kind {
                b"mdat" => Lengths { end: Some(next), ending: Ending::Cut, ..Lengths::default() },
                b"moof" => Lengths { ending: Ending::Cut, ..Lengths::default() },
                _ => Lengths::default(),
            });
        }
        at = next;
    }
    Ok(Lengths::default())
}

/// A Matroska file that ends within its segment is read as a stream, without the tables that should lie behind the sound.
pub(super) fn matroska<R: Read + Seek + ?Sized>(source: &mut R) -> Result<Lengths> {
    let end = source.seek(SeekFrom::End(0))?;
    let (_, begin, Some(length)) = element(source, 0)? else { return Ok(Lengths::default()) };
    let (SEGMENT, begin, length) = element(source, begin.saturating_add(length))? else {
        return Ok(Lengths::default());
    };
    let is_cut = length.is_some_and(|length| begin.saturating_add(length) > end);
    let ending = match length {
        None if !ends_in_element(source, begin, end) => Ending::Open,
        Some(_) if !is_cut => Ending::Stated,
        _ => Ending::Cut,
    };
    Ok(Lengths { is_stream: is_cut, ending, ..Lengths::default() })
}

/// Whether the last of the elements from `at` on goes on beyond the end. This is not known of one without a length.
fn ends_in_element<R: Read + Seek + ?Sized>(source: &mut R, mut at: u64, end: u64) -> bool {
    for _ in 0..MAX_PARTS {
        if at >= end {
            return at > end;
        }
        match element(source, at) {
            Ok((_, begin, Some(length))) => at = begin.saturating_add(length),
            Ok((_, _, None)) => return false,
            Err(_) => return true,
        }
    }
    false
}

/// The identifier of the element of EBML at `at`, where its content begins, and how long that is, if it states it.
fn element<R: Read + Seek + ?Sized>(source: &mut R, at: u64) -> Result<(u64, u64, Option<u64>)> {
    source.seek(SeekFrom::Start(at))?;
    let (id, _) = number(source)?;
    let (length, marker) = number(source)?;
    // All ones stand for an unknown length.
    let length = Some(length & (marker - 1)).filter(|length| *length != marker - 1);
    Ok((id, source.stream_position()?, length))
}

/// A number of variable length (RFC 8794 §4) with its marker, and that marker.
fn number<R: Read + ?Sized>(source: &mut R) -> Result<(u64, u64)> {
    let mut first = [0];
    source.read_exact(&mut first)?;
    let more = first[0].leading_zeros();
    let mut number = u64::from(first[0]);
    for _ in 0..more {
        let mut next = [0];
        source.read_exact(&mut next)?;
        number = (number << 8) | u64::from(next[0]);
    }
    Ok((number, 1 << (7 * (more + 1))))
}

/// An Ogg file that ends within a page ends before it: its reader looks for the last page in as many bytes as one can have.
pub(super) fn ogg<R: Read + Seek + ?Sized>(source: &mut R) -> Result<Lengths> {
    let end = source.seek(SeekFrom::End(0))?;
    let begin = source.seek(SeekFrom::Start(end.saturating_sub(2 * LONGEST_PAGE)))?;
    let mut tail = Vec::new();
    Read::take(source, 2 * LONGEST_PAGE).read_to_end(&mut tail)?;
    let whole_end = |at: usize| Some(at + page_length(tail.get(at..)?)?);
    let last = (0..tail.len()).rev().find_map(whole_end);
    let rest = last.and_then(|last| tail.get(last..)).unwrap_or_default();
    let is_cut = !rest.is_empty() && rest.iter().zip(b"OggS").all(|(a, b)| a == b);
    let end = last.filter(|_| is_cut).map(|last| begin + last as u64);
    Ok(Lengths { end, ..Lengths::default() })
}

/// The length of the page that these bytes begin with, if all of it is there.
fn page_length(bytes: &[u8]) -> Option<usize> {
    if !bytes.starts_with(b"OggS\0") {
        return None;
    }
    let count = usize::from(*bytes.get(26)?);
    let lengths = bytes.get(27..27 + count)?;
    let length = 27 + count + lengths.iter().map(|length| usize::from(*length)).sum::<usize>();
    (length <= bytes.len()).then_some(length)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Cursor;

    #[test]
    fn an_mp4_goes_on_to_the_end_of_its_samples_only() {
        let sized = |length: u32, kind: &[u8]| [&length.to_be_bytes()[..], kind, &[0; 8]].concat();
        let file = |length: u32, kind: &[u8]| Cursor::new([sized(16, b"ftyp"), sized(length, kind)].concat());
        let found = |length: u32, kind: &[u8]| mp4(&mut file(length, kind)).unwrap_or_default();
        let cut = Lengths { end: Some(16 + 1000), ending: Ending::Cut, ..Lengths::default() };
        assert_eq!(found(1000, b"mdat"), cut);
        assert_eq!(found(1000, b"moof"), Lengths { end: None, ..cut });
        for (length, kind) in [(16, b"mdat"), (0, b"mdat"), (7, b"mdat"), (1000, b"moov")] {
            assert_eq!(found(length, kind), Lengths::default(), "{length}");
        }
    }

    #[test]
    fn an_ogg_file_ends_with_its_last_whole_page() {
        let page = [b"OggS", &[0; 22][..], &[2, 255, 45], &[7; 300]].concat();
        let found = |bytes: Vec<u8>| ogg(&mut Cursor::new(bytes)).unwrap_or_default().end;
        let length = page.len();
        assert_eq!(found(page.repeat(3)), None);
        for cut in [1, 299, 300, 320, length - 1] {
            let mut bytes = page.repeat(3);
            bytes.truncate(3 * length - cut);
            assert_eq!(found(bytes), Some(2 * length as u64), "{cut} bytes less");
        }
        assert_eq!(found([&page[..], b"TAG of ID3v1"].concat()), None);
        assert_eq!(found(page[..length - 1].to_vec()), None);
    }
}
