//! Folders and playlists: the songs that a path stands for if it is not a song itself.

use std::borrow::Cow;
use std::fmt::Display;
use std::path::{Path, PathBuf};

use super::formats::{self, Kind};
use super::{Error, is_far};

/// Songs are looked for in folders within folders down to this depth.
const DEEPEST: usize = 8;
/// At most this many are taken.
const MOST_SONGS: usize = 5000;
/// The most bytes in the file of a list.
const MOST_BYTES: u64 = 4 << 20;

/// The songs found in files and folders.
#[derive(Debug, Default, PartialEq, Eq)]
pub struct Songs {
    /// In order: that of the list, or of the names within each folder.
    pub songs: Vec<PathBuf>,
    /// The files and folders left out, in words.
    pub warning: Option<String>,
}

/// Whether `path` stands for several songs.
pub fn is_list(path: &Path) -> bool {
    path.is_dir() || formats::kind(path) == Kind::List
}

/// The songs of a folder and the folders in it, or of an M3U list, whose paths are relative to it.
///
/// # Errors
/// Where the folder or the list cannot be read, and where it has no songs.
pub fn songs_of(path: &Path) -> Result<Songs, Error> {
    let unread = |why: std::io::Error| Error::Input(format!("{}: {why}", path.display()));
    let mut found = Songs::default();
    if path.is_dir() {
        let mut walk = Walk::default();
        walk.folder(path, 0).map_err(unread)?;
        found.warning = walk.first_left.map(|first| match walk.left {
            1 => format!("{}: a folder is left out, {first}", path.display()),
            count => format!("{}: {count} folders are left out, such as {first}", path.display()),
        });
        found.songs = walk.songs;
    } else {
        let bytes = chladni_task::read_file(path, MOST_BYTES).map_err(unread)?;
        let folder = path.parent().unwrap_or(Path::new("."));
        let (there, gone): (Vec<_>, Vec<_>) =
            entries(&text(&bytes), folder).into_iter().partition(|entry| is_there(entry, folder));
        found.songs = there;
        found.warning = left_out(path, &gone, folder);
    }
    if found.songs.len() > MOST_SONGS {
        found.songs.truncate(MOST_SONGS);
        let before = found.warning.map_or_else(|| path.display().to_string() + ":", |warning| warning + ";");
        found.warning = Some(format!("{before} only the first {MOST_SONGS} songs are taken"));
    }
    if found.songs.is_empty() {
        let why = found.warning.unwrap_or_else(|| format!("{}: has no songs", path.display()));
        return Err(Error::Input(why));
    }
    Ok(found)
}

/// A warning of the songs `gone` that the list at `path` names, as seen from its `folder`; none where all are there.
fn left_out(path: &Path, gone: &[PathBuf], folder: &Path) -> Option<String> {
    let first = gone.first()?;
    let (path, shown) = (path.display(), first.display());
    let far = "on another machine than the list, and not looked for there";
    Some(match (gone.len(), is_far(first, Some(folder))) {
        (1, true) => format!("{path}: {shown} is {far}"),
        (1, false) => format!("{path}: {shown} is not there"),
        (count, true) => format!("{path}: {count} songs are left out, such as {shown}, which is {far}"),
        (count, false) => format!("{path}: {count} songs are not there, such as {shown}"),
    })
}

/// The songs that are found in a folder and those within it.
#[derive(Default)]
struct Walk {
    songs: Vec<PathBuf>,
    /// How many folders are left out, and the first of them, with why.
    left: usize,
    first_left: Option<String>,
}

impl Walk {
    fn folder(&mut self, folder: &Path, depth: usize) -> std::io::Result<()> {
        let mut entries: Vec<_> = std::fs::read_dir(folder)?.filter_map(Result::ok).collect();
        entries.sort_by_cached_key(|entry| entry.file_name().to_string_lossy().to_lowercase());
        for entry in entries {
            let is_hidden = entry.file_name().to_string_lossy().starts_with('.');
            let Ok(kind) = entry.file_type() else { continue };
            let path = entry.path();
            // A link to a folder may lead around in a circle.
            if kind.is_dir() && !is_hidden {
                if depth >= DEEPEST {
                    self.leave(&path, format_args!("more than {DEEPEST} folders deep"));
                } else if let Err(why) = self.folder(&path, depth + 1) {
                    self.leave(&path, why);
                }
            } else if !kind.is_dir() && !is_hidden && formats::kind(&path) == Kind::Song {
                self.songs.push(path);
            }
            if self.songs.len() > MOST_SONGS {
                break;
            }
        }
        Ok(())
    }

    /// Leaves out a folder within.
    fn leave(&mut self, folder: &Path, why: impl Display) {
        self.left += 1;
        self.first_left.get_or_insert_with(|| format!("{}: {why}", folder.display()));
    }
}

/// UTF-8, as `.m3u8` is, or else Latin-1, as old lists are.
fn text(bytes: &[u8]) -> String {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    std::str::from_utf8(bytes)
        .map_or_else(|_| bytes.iter().map(|byte| char::from(*byte)).collect(), str::to_owned)
}

/// The names of the songs in an M3U list, without their folders: for a page, which is given files alone.
pub fn names_in(bytes: &[u8]) -> Vec<String> {
    let text = text(bytes);
    lines(&text).filter_map(|line| line.rsplit(['/', '\\']).next().map(str::to_owned)).collect()
}

fn lines(text: &str) -> impl Iterator<Item = Cow<'_, str>> {
    let lines = text.lines().map(str::trim).filter(|line| !line.is_empty() && !line.starts_with('#'));
    lines.map(|line| line.strip_prefix("file://").map_or(Cow::Borrowed(line), |rest| path_in(rest).into()))
}

/// The path in an address, behind its `file://`.
fn path_in(address: &str) -> String {
    // This machine has a name there, or none.
    let named = address.strip_prefix("localhost").filter(|rest| rest.starts_with('/'));
    let path = chladni_task::percent_decoded(named.unwrap_or(address));
    match path.as_bytes() {
        // A path of Windows begins with its drive.
        [b'/', drive, b':', ..] if drive.is_ascii_alphabetic() => path[1..].to_owned(),
        _ => path,
    }
}

fn entries(text: &str, folder: &Path) -> Vec<PathBuf> {
    lines(text)
        .map(|line| {
            let as_written = folder.join(&*line);
            // Lists of other systems, and of VLC, which writes names as in addresses.
            let others = [line.replace('\\', "/"), chladni_task::percent_decoded(&line)];
            let mut paths = [as_written.clone()].into_iter().chain(others.map(|line| folder.join(line)));
            paths.find(|path| is_there(path, folder)).unwrap_or(as_written)
        })
        .collect()
}

/// Whether a list in `folder` names a file that is there; no other machine is asked.
fn is_there(path: &Path, folder: &Path) -> bool {
    !is_far(path, Some(folder)) && path.is_file()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(found: &Songs, folder: &Path) -> Vec<String> {
        let songs = found.songs.iter();
        songs.map(|song| song.strip_prefix(folder).unwrap().to_string_lossy().into_owned()).collect()
    }

    #[test]
    fn a_folder_is_all_songs_in_it_by_name() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::create_dir_all(folder.path().join("b/c")).unwrap();
        std::fs::create_dir_all(folder.path().join(".hidden")).unwrap();
        for name in ["Z.mp3", "a.flac", "cover.png", "b/2.ogg", "b/c/1.wav", ".hidden/x.mp3", ".y.mp3"] {
            std::fs::write(folder.path().join(name), b"").unwrap();
        }
        let found = songs_of(folder.path()).unwrap();
        assert_eq!(names(&found, folder.path()), ["a.flac", "b/2.ogg", "b/c/1.wav", "Z.mp3"]);
        assert!(is_list(folder.path()) && found.warning.is_none());
        assert!(songs_of(&folder.path().join("nowhere")).is_err());
        let empty = tempfile::tempdir().unwrap();
        assert!(songs_of(empty.path()).unwrap_err().to_string().contains("no songs"));
    }

    #[test]
    fn folders_that_are_left_out_are_mentioned() {
        let folder = tempfile::tempdir().unwrap();
        let deep = folder.path().join("1/2/3/4/5/6/7/8/9");
        std::fs::create_dir_all(&deep).unwrap();
        std::fs::write(deep.join("deep.mp3"), b"").unwrap();
        let why = songs_of(folder.path()).unwrap_err().to_string();
        assert!(why.contains("a folder is left out") && why.contains("8 folders deep"), "{why}");
        std::fs::write(deep.with_file_name("there.mp3"), b"").unwrap();
        std::fs::create_dir(deep.with_file_name("10")).unwrap();
        let found = songs_of(folder.path()).unwrap();
        assert_eq!(names(&found, folder.path()), ["1/2/3/4/5/6/7/8/there.mp3"]);
        assert!(found.warning.unwrap().contains("2 folders are left out, such as"));
    }

    #[test]
    fn a_long_list_says_what_it_lacks_too() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("a.mp3"), b"").unwrap();
        let list = folder.path().join("set.m3u");
        std::fs::write(&list, "gone.mp3\n".to_owned() + &"a.mp3\n".repeat(MOST_SONGS)).unwrap();
        let warned = || songs_of(&list).unwrap().warning.unwrap();
        assert!(warned().ends_with("gone.mp3 is not there"), "{}", warned());
        std::fs::write(&list, "gone.mp3\n".to_owned() + &"a.mp3\n".repeat(MOST_SONGS + 1)).unwrap();
        let both = "gone.mp3 is not there; only the first 5000 songs are taken";
        assert!(warned().ends_with(both), "{}", warned());
    }

    #[test]
    fn songs_of_another_machine_are_not_called_missing() {
        let gone = [PathBuf::from(r"\\server\share\a.mp3"), PathBuf::from("b.mp3")];
        let said = |gone: &[PathBuf]| left_out(Path::new("set.m3u"), gone, Path::new("")).unwrap();
        for far in [&gone[..1], &gone[..]] {
            assert!(
                said(far).contains("another machine") && !said(far).contains("not there"),
                "{}",
                said(far)
            );
        }
        assert!(said(&gone).contains("2 songs"), "{}", said(&gone));
        assert!(said(&gone[1..]).ends_with("b.mp3 is not there"), "{}", said(&gone[1..]));
    }

    #[test]
    fn a_list_is_read_from_its_own_place_in_utf_8_or_latin_1() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::create_dir(folder.path().join("sub")).unwrap();
        for name in ["one.mp3", "sub/zw\u{f6}lf.mp3", "sub/two.ogg"] {
            std::fs::write(folder.path().join(name), b"").unwrap();
        }
        let list = folder.path().join("set.m3u");
        let lines = "#EXTM3U\r\n#EXTINF:3,One\r\none.mp3\r\n\r\nsub\\two.ogg\r\nsub/zw\u{f6}lf.mp3\nhttp://radio/x.mp3\n";
        let latin: Vec<u8> = lines.chars().map(|c| c as u8).collect();
        for bytes in [lines.as_bytes().to_vec(), latin, [b"\xef\xbb\xbf", lines.as_bytes()].concat()] {
            std::fs::write(&list, &bytes).unwrap();
            let found = songs_of(&list).unwrap();
            assert_eq!(names(&found, folder.path()), ["one.mp3", "sub/two.ogg", "sub/zw\u{f6}lf.mp3"]);
            assert!(found.warning.unwrap().contains("radio"));
            assert_eq!(names_in(&bytes), ["one.mp3", "two.ogg", "zw\u{f6}lf.mp3", "x.mp3"]);
        }
        assert!(is_list(&list));
        std::fs::write(&list, [0xff; 9]).unwrap();
        assert!(songs_of(&list).is_err());
    }

    #[test]
    fn addresses_in_a_list_are_paths() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["a b.mp3", "c%20d.mp3"] {
            std::fs::write(folder.path().join(name), b"").unwrap();
        }
        let root = folder.path().to_str().unwrap().replace('\\', "/");
        let root = root.trim_start_matches('/');
        let text = format!(
            "file:///{root}/a%20b.mp3\nfile://localhost/{root}/a%20b.mp3\nfile:///{root}/c%2520d.mp3\nc%20d.mp3\na%20b.mp3\n"
        );
        let list = folder.path().join("set.m3u8");
        std::fs::write(&list, &text).unwrap();
        let found = songs_of(&list).unwrap();
        assert_eq!(names(&found, folder.path()), ["a b.mp3", "a b.mp3", "c%20d.mp3", "c%20d.mp3", "a b.mp3"]);
        assert_eq!(found.warning, None);
        let named = ["a b.mp3", "a b.mp3", "c%20d.mp3", "c%20d.mp3", "a%20b.mp3"];
        assert_eq!(names_in(text.as_bytes()), named);
        let of_windows = "file:///C:/My%20Music/zw%C3%B6lf.mp3\nfile://localhost/c:/x.mp3\nfile:///C/x.mp3";
        let paths: Vec<_> = lines(of_windows).collect();
        assert_eq!(paths, ["C:/My Music/zw\u{f6}lf.mp3", "c:/x.mp3", "/C/x.mp3"]);
    }
}
