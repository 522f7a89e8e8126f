//! Which part of an MP4 sound track is audible.
//!
//! AAC encoders put one or two frames of priming before the sound. The container says how
//! many in an edit list (ISO/IEC 14496-12 §8.6.6), and Apple's programs also in a comment
//! named `iTunSMPB`. The demuxer reads neither, so the few boxes needed are read here.

use std::io::{self, Read, Seek, SeekFrom};

use super::mended::header;

/// The audible part of the first sound track.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Audible {
    /// Samples before the first one to be heard.
    pub skip: u64,
    /// The number of audible samples; `None` if the file does not state it.
    pub frames: Option<u64>,
    /// Whether both are ticks of the track's clock in place of decoded samples. Their rates may differ, as where a
    /// decoder leaves out the upper half of the spectrum (HE-AAC).
    pub in_ticks: bool,
}

/// The largest box that is read whole (headers, edit list, comment); these boxes are far smaller in valid
/// files.
const MAX_BOX_BYTES: u64 = 1 << 16;
/// The largest number of boxes that is visited; valid files have a few dozen before the ones sought.
const MAX_BOXES: usize = 4096;

/// Finds the audible part of the first sound track. `None` if the file does not state one that can be read;
/// then all of the track is played.
pub(crate) fn audible_part<R: Read + Seek + ?Sized>(source: &mut R) -> Option<Audible> {
    let len = source.seek(SeekFrom::End(0)).ok()?;
    let mut walk = Walk { source, boxes_left: MAX_BOXES };
    let moov = walk.find(0..len, b"moov")?;
    if let Some(comment) = walk.itunes_gapless(moov.clone()) {
        return Some(comment);
    }
    let movie_scale = {
        let mvhd = walk.find(moov.clone(), b"mvhd").and_then(|b| walk.bytes(b))?;
        header_scale_and_duration(&mvhd)?.0
    };
    let mut from = moov.start;
    while let Some(trak) = walk.find(from..moov.end, b"trak") {
        from = trak.end;
        let mdia = walk.find(trak.clone(), b"mdia")?;
        let hdlr = walk.find(mdia.clone(), b"hdlr").and_then(|b| walk.bytes(b))?;
        if hdlr.get(8..12) != Some(b"soun") {
            continue;
        }
        let mdhd = walk.find(mdia, b"mdhd").and_then(|b| walk.bytes(b))?;
        let (scale, media_duration) = header_scale_and_duration(&mdhd)?;
        let edts = walk.find(trak, b"edts")?;
        let elst = walk.find(edts, b"elst").and_then(|b| walk.bytes(b))?;
        let (skip, edit_duration) = single_edit(&elst)?;
        let Some(media_duration) = media_duration else {
            return Some(Audible { skip, frames: None, in_ticks: true });
        };
        let rest = media_duration.checked_sub(skip)?;
        // The clock of the movie is often coarse (1 ms). If both durations agree to a tick or two, that of
        // the media is the exact one.
        let edit = (u128::from(edit_duration) * u128::from(scale) / u128::from(movie_scale)) as u64;
        let tick = 2 * u64::from(scale).div_ceil(u64::from(movie_scale));
        let frames = if edit == 0 || rest.abs_diff(edit) <= tick { rest } else { edit.min(rest) };
        return Some(Audible { skip, frames: Some(frames), in_ticks: true });
    }
    None
}

/// Timescale and duration of an `mvhd` or `mdhd` box; no duration where it is unknown, as in fragmented files.
fn header_scale_and_duration(body: &[u8]) -> Option<(u32, Option<u64>)> {
    let (scale_at, long) = match body.first()? {
        0 => (12, false),
        _ => (20, true),
    };
    let scale = u32_at(body, scale_at)?;
    let duration = if long { u64_at(body, scale_at + 4)? } else { u64::from(u32_at(body, scale_at + 4)?) };
    // §8.4.2: all bits are 1 if the duration cannot be determined. Fragmented files have 0.
    let unknown = if long { u64::MAX } else { u64::from(u32::MAX) };
    (scale > 0).then_some((scale, Some(duration).filter(|d| *d != 0 && *d != unknown)))
}

/// (media time, duration in the movie's clock) of an edit list with one real edit.
fn single_edit(body: &[u8]) -> Option<(u64, u64)> {
    let long = *body.first()? != 0;
    let count = u32_at(body, 4)? as usize;
    let stride = if long { 20 } else { 12 };
    let mut edit = None;
    for i in 0..count.min(64) {
        let at = 8 + i * stride;
        let (duration, media_time) = if long {
            (u64_at(body, at)?, u64_at(body, at + 8)? as i64)
        } else {
            (u64::from(u32_at(body, at)?), i64::from(u32_at(body, at + 4)? as i32))
        };
        // A media time of −1 is a pause before the sound; music files that have one mean 0.
        if let Ok(media_time) = u64::try_from(media_time) {
            if edit.is_some() {
                return None;
            }
            edit = Some((media_time, duration));
        }
    }
    edit
}

/// The kind of the box at `at`, and how long its header and all of it are; `None` where it reaches to the end.
pub(super) fn box_at<R: Read + Seek + ?Sized>(
    source: &mut R,
    at: u64,
) -> io::Result<([u8; 4], u64, Option<u64>)> {
    let (length, kind) = header(source, at)?;
    Ok(match u32::from_be_bytes(length) {
        0 => (kind, 8, None),
        1 => {
            let mut long = [0; 8];
            source.read_exact(&mut long)?;
            (kind, 16, Some(u64::from_be_bytes(long)))
        }
        length => (kind, 8, Some(length.into())),
    })
}

struct Walk<'a, R: ?Sized> {
    source: &'a mut R,
    boxes_left: usize,
}

impl<R: Read + Seek + ?Sized> Walk<'_, R> {
    /// The body of the first box of this kind in `within`.
    fn find(&mut self, within: std::ops::Range<u64>, kind: &[u8; 4]) -> Option<std::ops::Range<u64>> {
        let mut at = within.start;
        while at + 8 <= within.end {
            self.boxes_left = self.boxes_left.checked_sub(1)?;
            let (found, body, size) = box_at(self.source, at).ok()?;
            let size = size.unwrap_or(within.end - at);
            let end = at.checked_add(size)?;
            if size < body || end > within.end {
                return None;
            }
            if found == *kind {
                return Some(at + body..end);
            }
            at = end;
        }
        None
    }

    fn bytes(&mut self, range: std::ops::Range<u64>) -> Option<Vec<u8>> {
        let len = range.end - range.start;
        if len > MAX_BOX_BYTES {
            return None;
        }
        let mut bytes = vec![0; len as usize];
        self.read_at(range.start, &mut bytes).ok()?;
        Some(bytes)
    }

    fn read_at(&mut self, at: u64, into: &mut [u8]) -> io::Result<()> {
        self.source.seek(SeekFrom::Start(at))?;
        self.source.read_exact(into)
    }

    /// moov/udta/meta/ilst/----[name = iTunSMPB]/data: " 0 priming padding length …" in hex.
    fn itunes_gapless(&mut self, moov: std::ops::Range<u64>) -> Option<Audible> {
        let udta = self.find(moov, b"udta")?;
        let meta = self.find(udta, b"meta")?;
        let ilst = self.find(meta.start + 4..meta.end, b"ilst")?;
        let mut from = ilst.start;
        while let Some(comment) = self.find(from..ilst.end, b"----") {
            from = comment.end;
            let name = self.find(comment.clone(), b"name").and_then(|b| self.bytes(b));
            if name.as_deref().and_then(|n| n.get(4..)) != Some(b"iTunSMPB") {
                continue;
            }
            let data = self.find(comment, b"data").and_then(|b| self.bytes(b))?;
            let text = std::str::from_utf8(data.get(8..)?).ok()?;
            let fields: Vec<u64> =
                text.split_whitespace().map_while(|f| u64::from_str_radix(f, 16).ok()).collect();
            let (&skip, &frames) = (fields.get(1)?, fields.get(3)?);
            return Some(Audible { skip, frames: (frames > 0).then_some(frames), in_ticks: false });
        }
        None
    }
}

fn u32_at(bytes: &[u8], at: usize) -> Option<u32> {
    Some(u32::from_be_bytes(bytes.get(at..at.checked_add(4)?)?.try_into().ok()?))
}

fn u64_at(bytes: &[u8], at: usize) -> Option<u64> {
    Some(u64::from_be_bytes(bytes.get(at..at.checked_add(8)?)?.try_into().ok()?))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::io::Cursor;

    fn boxed(kind: &[u8; 4], body: &[u8]) -> Vec<u8> {
        let mut bytes = (body.len() as u32 + 8).to_be_bytes().to_vec();
        bytes.extend_from_slice(kind);
        bytes.extend_from_slice(body);
        bytes
    }

    fn words(words: &[u32]) -> Vec<u8> {
        words.iter().flat_map(|word| word.to_be_bytes()).collect()
    }

    /// A sound track of 100 000 samples at 44.1 kHz of which the first 1024 are priming.
    fn movie() -> Vec<u8> {
        movie_with(&words(&[0, 0, 0, 44_100, 100_000]), 2244, 1024)
    }

    fn movie_with(media_header: &[u8], edit_duration: u32, skip: u32) -> Vec<u8> {
        let mvhd = boxed(b"mvhd", &words(&[0, 0, 0, 1000, 2244]));
        let hdlr = boxed(b"hdlr", &[&words(&[0, 0])[..], b"soun"].concat());
        let mdhd = boxed(b"mdhd", media_header);
        let mdia = boxed(b"mdia", &[mdhd, hdlr].concat());
        let edts = boxed(b"edts", &boxed(b"elst", &words(&[0, 1, edit_duration, skip, 0x1_0000])));
        let trak = boxed(b"trak", &[edts, mdia].concat());
        let moov = boxed(b"moov", &[mvhd, trak].concat());
        [boxed(b"ftyp", b"M4A "), moov].concat()
    }

    #[test]
    fn an_edit_list_gives_the_exact_length() {
        let audible = audible_part(&mut Cursor::new(movie()));
        assert_eq!(audible, Some(Audible { skip: 1024, frames: Some(98_976), in_ticks: true }));
    }

    #[test]
    fn the_unknown_length_of_a_fragmented_file_is_no_length() {
        let headers = [
            words(&[0, 0, 0, 44_100, 0]),
            words(&[0, 0, 0, 44_100, u32::MAX]),
            words(&[1 << 24, 0, 0, 0, 0, 44_100, u32::MAX, u32::MAX]),
        ];
        for (header, skip) in headers.iter().flat_map(|header| [(header, 0), (header, 1024)]) {
            let audible = audible_part(&mut Cursor::new(movie_with(header, 0, skip)));
            assert_eq!(audible, Some(Audible { skip: skip.into(), frames: None, in_ticks: true }));
        }
    }

    proptest! {
        #[test]
        fn no_bytes_make_it_panic(changes in proptest::collection::vec((any::<u16>(), any::<u8>()), 0..12), keep in any::<u16>()) {
            let mut bytes = movie();
            let len = bytes.len();
            for (at, value) in changes {
                bytes[usize::from(at) % len] = value;
            }
            bytes.truncate(usize::from(keep) % (2 * len) + 1);
            let _ = audible_part(&mut Cursor::new(bytes));
        }
    }
}
