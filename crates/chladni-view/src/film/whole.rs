//! Whether an MP4 is complete. ffmpeg 5 ends without an error where its last bytes found no room.

use std::io::{self, Read, Seek, SeekFrom};

/// What is said where a film is not whole and ffmpeg did not say why.
pub(super) const UNFINISHED: &str = "it ended before the film was complete";

/// Whether the boxes of the MP4 fill it, and its index (`moov`) and pictures (`mdat`) are among them; the last one of a film in
/// pieces (`moof`) is `mfra`.
pub(super) fn is_whole(film: &mut (impl Read + Seek)) -> io::Result<bool> {
    let length = film.seek(SeekFrom::End(0))?;
    let (mut at, mut last) = (0_u64, [0; 4]);
    let [mut has_index, mut has_pictures, mut is_in_pieces] = [false; 3];
    while at < length {
        let (size, name) = match box_at(film, at) {
            Err(why) if why.kind() == io::ErrorKind::UnexpectedEof => return Ok(false),
            found => found?,
        };
        match at.checked_add(size) {
            // One of size 0 reaches to the end, as does each that is still being written.
            Some(end) if size >= 8 && end <= length => at = end,
            _ => return Ok(false),
        }
        has_index |= &name == b"moov";
        has_pictures |= &name == b"mdat";
        is_in_pieces |= &name == b"moof";
        last = name;
    }
    Ok(has_index && has_pictures && (!is_in_pieces || &last == b"mfra"))
}

/// Size and name of the box that begins at `at`.
fn box_at(film: &mut (impl Read + Seek), at: u64) -> io::Result<(u64, [u8; 4])> {
    film.seek(SeekFrom::Start(at))?;
    let (mut size, mut name) = ([0; 4], [0; 4]);
    film.read_exact(&mut size)?;
    film.read_exact(&mut name)?;
    let size = u32::from_be_bytes(size);
    // Where it does not fit here, it stands behind the name.
    if size != 1 {
        return Ok((size.into(), name));
    }
    let mut long = [0; 8];
    film.read_exact(&mut long)?;
    Ok((u64::from_be_bytes(long), name))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn boxes(of: &[(&[u8; 4], u32)]) -> Vec<u8> {
        let one = |&(name, size): &(&[u8; 4], u32)| {
            let rest = vec![0; size as usize - 8];
            [&size.to_be_bytes()[..], name, &rest].concat()
        };
        of.iter().flat_map(one).collect()
    }

    #[test]
    fn a_film_without_its_last_bytes_is_not_whole() {
        let whole = |film: &[u8]| is_whole(&mut io::Cursor::new(film)).unwrap();
        let in_one = boxes(&[(b"ftyp", 32), (b"moov", 90), (b"free", 8), (b"mdat", 700)]);
        let in_pieces = boxes(&[(b"ftyp", 28), (b"moov", 90), (b"moof", 50), (b"mdat", 70), (b"mfra", 20)]);
        for film in [in_one, in_pieces] {
            assert!(whole(&film));
            assert!((0..film.len()).all(|length| !whole(&film[..length])));
        }
        // The index is written last.
        assert!(!whole(&boxes(&[(b"ftyp", 32), (b"free", 8), (b"mdat", 700)])));
        let long = [&[0, 0, 0, 1][..], b"mdat", &24_u64.to_be_bytes(), &[7; 8]].concat();
        let index = boxes(&[(b"moov", 90)]);
        assert!(whole(&[&index[..], &long].concat()) && !whole(&[&index[..], &long[..20]].concat()));
        // Sizes that no file has.
        for size in [0, 1, 7, u64::MAX] {
            let long = [&[0, 0, 0, 1][..], b"mdat", &size.to_be_bytes()].concat();
            assert!(!whole(&[&index[..], &long].concat()));
        }
    }
}
