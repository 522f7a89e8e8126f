//! The covers of songs: pictures in their tags, or beside them.

use std::path::{Path, PathBuf};

use chladni_sound::SongReader;
use chladni_task::folder_of;
use chladni_view::Picture;

/// Pixels of the longer side of a cover: those of the largest place where it is shown, on a large screen.
const SIDE: u32 = 256;
/// Usual names of pictures beside songs, without their ending.
const NAMES: [&str; 4] = ["cover", "folder", "front", "album"];
const ENDINGS: [&str; 3] = ["jpg", "jpeg", "png"];
/// Larger files are not taken for covers.
const MOST_BYTES: u64 = 32 << 20;

/// The cover of a song.
#[derive(Clone, Debug, PartialEq)]
pub struct Cover {
    /// As large as it is shown.
    pub picture: Picture,
    /// Where it lies beside the song; `None` where it lies in its tags.
    pub file: Option<PathBuf>,
}

/// The cover of the song at `path`, which `reader` reads: the picture in its tags, else a file such as
/// cover.jpg in its folder. A picture that cannot be read counts as none.
pub fn cover_of(path: &Path, reader: &mut SongReader) -> Option<Cover> {
    let in_tags = reader.cover().and_then(|bytes| Picture::decode_upright(&bytes).ok());
    let (picture, file) = match in_tags {
        Some(picture) => (picture, None),
        None => beside(path).map(|(picture, file)| (picture, Some(file)))?,
    };
    Some(Cover { picture: picture.thumbnail(SIDE), file })
}

fn beside(path: &Path) -> Option<(Picture, PathBuf)> {
    let files = folder_of(path).read_dir().ok()?.flatten().map(|entry| entry.file_name());
    let mut found: Vec<(usize, std::ffi::OsString)> = files
        .filter_map(|file| {
            let (stem, ending) = file.to_str()?.rsplit_once('.')?;
            let is_picture = ENDINGS.iter().any(|known| ending.eq_ignore_ascii_case(known));
            let rank = NAMES.iter().position(|name| stem.eq_ignore_ascii_case(name))?;
            is_picture.then(|| (rank, file.clone()))
        })
        .collect();
    found.sort();
    found.into_iter().find_map(|(_, name)| {
        let file = path.with_file_name(name);
        let bytes = chladni_task::read_file(&file, MOST_BYTES).ok()?;
        Some((Picture::decode_upright(&bytes).ok()?, file))
    })
}

#[cfg(test)]
mod tests {
    use chladni_sound::{WavSample, sample_tune, write_wav};

    use super::*;

    /// The smallest tags with a picture: ID3v2.3 with one APIC frame. Most often an MP3 follows them.
    fn tags_with(picture: &[u8]) -> Vec<u8> {
        let body = [b"\0image/png\0\x03\0", picture].concat();
        let length = u32::try_from(body.len()).unwrap();
        let frame = [b"APIC".as_slice(), &length.to_be_bytes(), &[0, 0], &body].concat();
        let length = u32::try_from(frame.len()).unwrap();
        let seven_bits = [21, 14, 7, 0].map(|shift| (length >> shift & 0x7f) as u8);
        [b"ID3\x03\0\0".as_slice(), &seven_bits, &frame].concat()
    }

    #[test]
    fn a_cover_is_the_picture_in_the_tags_or_else_the_one_beside_the_song() {
        let folder = tempfile::tempdir().unwrap();
        let song = folder.path().join("song.wav");
        write_wav(&song, &sample_tune(), WavSample::Int16).unwrap();
        let cover = || cover_of(&song, &mut SongReader::open(&song).unwrap());
        assert!(cover().is_none());
        std::fs::write(folder.path().join("front.png"), b"no picture").unwrap();
        assert!(cover().is_none());
        std::fs::write(folder.path().join("cover.jpg"), b"no picture").unwrap();
        let small = Picture::filled(8, 8, [0, 0, 255, 255]);
        std::fs::write(folder.path().join("folder.png"), small.to_png().unwrap()).unwrap();
        assert_eq!(cover().map(|cover| cover.picture), Some(small), "the first that can be read");
        let wide = Picture::filled(512, 128, [255, 0, 0, 255]);
        std::fs::write(folder.path().join("Cover.PNG"), wide.to_png().unwrap()).unwrap();
        let Cover { picture: beside, file } = cover().unwrap();
        assert_eq!(file, Some(folder.path().join("Cover.PNG")));
        assert_eq!((beside.width, beside.height, beside.pixel(9, 9)), (256, 64, Some([255, 0, 0, 255])));
        let green = Picture::filled(16, 16, [0, 255, 0, 255]);
        let wav = std::fs::read(&song).unwrap();
        std::fs::write(&song, [tags_with(&green.to_png().unwrap()), wav.clone()].concat()).unwrap();
        assert!(cover() == Some(Cover { picture: green, file: None }), "the one in the tags comes first");
        std::fs::write(&song, [tags_with(b"damaged"), wav].concat()).unwrap();
        assert_eq!(cover().map(|cover| cover.picture.width), Some(256));
    }
}
