//! Texts that name files: playlists, lists of meshes, and the notes of recordings that were cut off.

use std::path::Path;

use chladni_program::cli::meshes_listed;
use chladni_program::work::playlist::{names_in, songs_of};
use chladni_view::film::CutOff;
use tempfile::TempDir;

use crate::{MIB, within};

/// The most memory that each byte of a list takes: a path a line, in the folder of the list.
const EACH: usize = 128;

/// A folder in which one song and one mesh lie.
struct Place {
    folder: TempDir,
}

impl Place {
    fn new() -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        for name in ["a.mp3", "a.obj"] {
            std::fs::write(folder.path().join(name), b"").expect("room for a file");
        }
        std::fs::create_dir(folder.path().join(".chladni-1")).expect("room for a folder");
        Self { folder }
    }

    fn write(&self, name: &str, bytes: &[u8]) -> std::path::PathBuf {
        let path = self.folder.path().join(name);
        std::fs::write(&path, bytes).expect("room for a list");
        path
    }
}

/// The bytes as each of them.
pub fn lists(bytes: &[u8]) {
    thread_local! {
        static PLACE: Place = Place::new();
    }
    PLACE.with(|place| {
        songs(bytes, &place.write("list.m3u", bytes));
        meshes(bytes, &place.write("list.txt", bytes));
        recording(bytes, &place.write(".chladni-1/recording.txt", bytes));
    });
}

fn songs(bytes: &[u8], list: &Path) {
    let names = within(bytes.len(), EACH, MIB, || names_in(bytes));
    assert!(names.iter().all(|name| !name.contains(['/', '\\'])));
    match within(bytes.len(), EACH, MIB, || songs_of(list)) {
        Ok(found) => assert!(!found.songs.is_empty() && found.songs.iter().all(|song| song.is_file())),
        Err(why) => assert!(why.is_of_input() && !why.to_string().is_empty()),
    }
}

fn meshes(bytes: &[u8], list: &Path) {
    match within(bytes.len(), EACH, MIB, || meshes_listed(list)) {
        Ok(found) => assert!(!found.is_empty() && found.iter().all(|mesh| !mesh.as_os_str().is_empty())),
        Err(why) => assert!(why.is_of_input() && !why.to_string().is_empty()),
    }
}

/// Whatever a note says, the film lies beside its folder.
fn recording(bytes: &[u8], note: &Path) {
    let folder = note.parent().expect("it lies in a folder");
    if let Some(cut_off) = within(bytes.len(), EACH, MIB, || CutOff::find(folder)) {
        assert_eq!((cut_off.folder(), cut_off.film().parent()), (folder, folder.parent()));
        assert!(cut_off.is_empty());
    }
}
