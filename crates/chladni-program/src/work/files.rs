//! The files that a show needs: named by path and hash, and found again.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, SystemTime};

use chladni_music::{FileRef, Looks};
use chladni_task::asks_another_machine;

use super::source::from_anywhere;
use super::{Error, Warning};
use chladni_mesh::ShapeSource;

/// The length of a file, and when it was changed.
type Stamp = (u64, SystemTime);

/// Files whose content was hashed, with the stamps that they had.
static KNOWN: Mutex<BTreeMap<PathBuf, (Stamp, String)>> = Mutex::new(BTreeMap::new());

/// A file that was changed no longer ago may change again without another stamp.
const SETTLED: Duration = Duration::from_secs(2);

/// The name of a file without its folders, as it is shown.
pub fn shown_name(path: &Path) -> Cow<'_, str> {
    path.file_name().unwrap_or(path.as_os_str()).to_string_lossy()
}

/// How a show in `folder` names `path`: relative if it lies below the folder, else absolute. A sample by its
/// name.
pub fn refer(path: &Path, folder: Option<&Path>) -> FileRef {
    if ShapeSource::sample_name(path).is_some() {
        return FileRef { path: path.to_string_lossy().into_owned(), blake3: None };
    }
    FileRef { path: name_in(path, folder), blake3: known_hash(path) }
}

/// Whether a document in `folder` names a file of another machine, which it is not looked for on. A name without a folder is
/// one that we wrote down ourselves, in a copy against a crash.
pub fn is_far(named: &Path, folder: Option<&Path>) -> bool {
    let whole = |folder: &Path| std::path::absolute(folder.join(".")).unwrap_or_else(|_| folder.to_owned());
    folder.is_some_and(|folder| asks_another_machine(named, &whole(folder)))
}

/// Whether the file at `path` is not found again as `named`: a show is text, which not every name of a file is.
pub fn is_lost(path: &Path, named: &FileRef) -> bool {
    path.to_str().is_none() && named.path.contains(char::REPLACEMENT_CHARACTER)
}

/// `path` relative to `folder` if it lies below it, with slashes on every system, so that a show can move between them;
/// else absolute.
pub fn name_in(path: &Path, folder: Option<&Path>) -> String {
    let whole = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    let folder = folder.and_then(|folder| std::path::absolute(folder).ok());
    match folder.and_then(|folder| whole.strip_prefix(folder).ok()) {
        Some(below) => below.iter().map(|part| part.to_string_lossy()).collect::<Vec<_>>().join("/"),
        None => whole.to_string_lossy().into_owned(),
    }
}

/// How a copy of a show names a file: its whole path, without reading it.
pub fn unread(path: &Path) -> FileRef {
    FileRef { path: from_anywhere(path).to_string_lossy().into_owned(), blake3: None }
}

/// The path of a file that a show in `folder` names, and a warning if it has changed since.
///
/// # Errors
/// [`Error::Input`] where there is no such file.
pub fn resolve(file: &FileRef, folder: Option<&Path>) -> Result<(PathBuf, Option<Warning>), Error> {
    let found = find(file, folder)?;
    let warning = changed_since(&found, file);
    Ok((found, warning))
}

/// The path of a file that a show in `folder` names, without reading it. One of [another machine](is_far) is looked for beside
/// the show only.
///
/// # Errors
/// [`Error::Input`] where there is no such file.
pub fn find(file: &FileRef, folder: Option<&Path>) -> Result<PathBuf, Error> {
    let named = Path::new(&file.path);
    if ShapeSource::sample_name(named).is_some() {
        return Ok(named.to_owned());
    }
    let in_folder = |name: &Path| folder.map(|folder| folder.join(name));
    let beside = named.file_name().and_then(|name| in_folder(Path::new(name)));
    // Elsewhere, a path from Windows is one name.
    let of_windows = file.path.rsplit(['/', '\\']).next().and_then(|name| in_folder(Path::new(name)));
    let is_far = is_far(named, folder);
    let as_named = [in_folder(named), Some(named.to_owned())].into_iter().filter(|_| !is_far);
    let mut places = as_named.chain([beside, of_windows]).flatten();
    places.find(|path| path.is_file()).ok_or_else(|| {
        let why = if is_far {
            "the file of this show is on another machine, where it is not looked for, and not beside the show: connect that \
             share as a drive and choose it there, or keep the file beside the show"
        } else {
            "the file of this show is not there, nor beside the show"
        };
        Error::Input(format!("{}: {why}", file.path))
    })
}

/// A warning where what was found is not the file that a show was made with; reads the file.
pub fn changed_since(found: &Path, named: &FileRef) -> Option<Warning> {
    let other = named.blake3.is_some() && known_hash(found) != named.blake3;
    other.then(|| Warning::of(found.display(), "is not the file that the show was made with"))
}

/// Where a file that a show in `folder` names would lie; of one that is not there now, but may come back. One of
/// [another machine](is_far) would lie beside the show.
pub fn placed(named: &str, folder: Option<&Path>) -> PathBuf {
    let is_far = is_far(Path::new(named), folder);
    let named = named.rsplit(['/', '\\']).next().filter(|_| is_far).unwrap_or(named);
    folder.map_or_else(|| PathBuf::from(named), |folder| folder.join(named))
}

/// `looks` with the picture and the panorama as a show names them, each by `name`.
pub fn refer_looks(looks: Looks, name: impl Fn(&Path) -> String) -> Looks {
    let named = |file: String| if file.is_empty() { file } else { name(Path::new(&file)) };
    Looks { picture: named(looks.picture), panorama: named(looks.panorama), ..looks }
}

/// `looks` of a show in `folder` with the paths of the picture and the panorama that they name; without those that are
/// not there, and a warning for each.
pub fn resolve_looks(looks: Looks, folder: Option<&Path>) -> (Looks, Vec<Warning>) {
    let mut warnings = Vec::new();
    let mut found = |path: String| {
        if path.is_empty() {
            return path;
        }
        match find(&FileRef { path, blake3: None }, folder) {
            Ok(found) => found.to_string_lossy().into_owned(),
            Err(why) => {
                warnings.push(Warning::Plain(format!("{why}: the dance goes on without it")));
                String::new()
            }
        }
    };
    let looks = Looks { picture: found(looks.picture), panorama: found(looks.panorama), ..looks };
    (looks, warnings)
}

/// Whether a file is hidden: a Mac puts one beside each file, of the same ending.
pub fn is_hidden(path: &Path) -> bool {
    path.file_name().is_some_and(|name| name.as_encoded_bytes().starts_with(b"."))
}

/// The BLAKE3 hash of a file in hexadecimal digits; `None` if it cannot be read.
pub fn file_hash(path: &Path) -> Option<String> {
    let file = chladni_task::open_file(path).ok()?;
    let mut hasher = blake3::Hasher::new();
    hasher.update_reader(file).ok()?;
    Some(hasher.finalize().to_hex().to_string())
}

/// The same; a file that has not been changed since it was hashed last is not read again: a show may name many long songs.
pub fn known_hash(path: &Path) -> Option<String> {
    let known = || KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
    let stamp = stamp_of(path);
    if let Some((before, hash)) = known().get(path)
        && stamp == Some(*before)
    {
        return Some(hash.clone());
    }
    let hash = file_hash(path)?;
    let settled = |(_, changed): &Stamp| changed.elapsed().is_ok_and(|age| age > SETTLED);
    if let Some(stamp) = stamp.filter(settled)
        && stamp_of(path) == Some(stamp)
    {
        known().insert(path.to_owned(), (stamp, hash.clone()));
    }
    Some(hash)
}

fn stamp_of(path: &Path) -> Option<Stamp> {
    let about = std::fs::metadata(path).ok()?;
    Some((about.len(), about.modified().ok()?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_shown_without_its_folders() {
        assert_eq!(shown_name(Path::new("/home/ernst/shapes/plate.obj")), "plate.obj");
        assert_eq!(shown_name(Path::new("sample:octopus")), "sample:octopus");
    }

    #[test]
    fn a_file_is_read_again_only_where_it_may_have_changed() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("song.wav");
        let hash_of = |content: &[u8], age_secs: u64| {
            std::fs::write(&path, content).unwrap();
            let changed = SystemTime::UNIX_EPOCH + Duration::from_secs(1_000_000_000 - age_secs);
            std::fs::File::options().write(true).open(&path).unwrap().set_modified(changed).unwrap();
            known_hash(&path)
        };
        let first = hash_of(b"la", 0);
        assert!(first.is_some() && first == file_hash(&path));
        assert_eq!(hash_of(b"lu", 0), first, "of the same length and time");
        assert!(hash_of(b"lu", 10) != first && hash_of(b"la", 20) == first);
        assert_ne!(hash_of(b"lala", 20), first);
        // What was just written may be written again at what looks like the same time.
        for content in [b"do", b"re"] {
            std::fs::write(&path, content).unwrap();
            assert_eq!(known_hash(&path), file_hash(&path));
        }
        std::fs::remove_file(&path).unwrap();
        assert_eq!(known_hash(&path), None);
    }

    #[test]
    fn files_are_found_again_where_the_show_has_moved_with_them() {
        let (old, new) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
        std::fs::create_dir(old.path().join("songs")).unwrap();
        let song = old.path().join("songs/a.wav");
        std::fs::write(&song, b"la").unwrap();
        let named = refer(&song, Some(old.path()));
        assert_eq!(named.path, "songs/a.wav");
        assert_eq!(resolve(&named, Some(old.path())).unwrap(), (song.clone(), None));
        assert!(resolve(&named, Some(new.path())).unwrap_err().to_string().contains("not there"));
        let moved = new.path().join("a.wav");
        std::fs::write(&moved, b"lala").unwrap();
        let (found, warning) = resolve(&named, Some(new.path())).unwrap();
        assert_eq!(found, moved);
        assert!(warning.unwrap().to_string().contains("not the file"));
        let far = refer(&song, Some(new.path()));
        assert_eq!(resolve(&far, Some(new.path())).unwrap(), (song, None));
        let of_windows = FileRef { path: r"D:\Songs\a.wav".into(), blake3: None };
        assert_eq!(resolve(&of_windows, Some(new.path())).unwrap(), (moved, None));
        // Nor is another machine asked; a copy of our own names what was open.
        let far = FileRef { path: r"\\server\share\a.wav".into(), blake3: None };
        assert_eq!(resolve(&far, Some(new.path())).unwrap(), (new.path().join("a.wav"), None));
        let gone = FileRef { path: r"\\server\share\b.wav".into(), blake3: None };
        assert!(find(&gone, Some(new.path())).unwrap_err().to_string().contains("another machine"));
        assert_eq!(placed(&gone.path, Some(new.path())), new.path().join("b.wav"));
        assert!(is_far(Path::new(&gone.path), Some(Path::new(""))) && !is_far(Path::new(&gone.path), None));
        let sample = refer(Path::new("sample:octopus"), None);
        assert_eq!(resolve(&sample, None).unwrap(), ("sample:octopus".into(), None));
    }

    #[cfg(unix)]
    #[test]
    fn a_name_that_is_no_text_is_lost_unless_only_a_folder_above_the_show_has_it() {
        use std::os::unix::ffi::OsStrExt;
        let odd = Path::new("/nowhere").join(std::ffi::OsStr::from_bytes(b"caf\xe9"));
        let lost = |path: &Path, folder: &Path| is_lost(path, &refer(path, Some(folder)));
        assert!(lost(&odd, Path::new("/nowhere")));
        assert!(lost(&odd.join("a.wav"), Path::new("/nowhere")));
        assert!(!lost(&odd.join("a.wav"), &odd));
        assert!(!lost(Path::new("/nowhere/café.wav"), Path::new("/nowhere")));
    }

    #[test]
    fn the_picture_and_the_panorama_of_a_show_move_with_it() {
        let (old, new) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
        let text = |path: PathBuf| path.to_str().unwrap().to_owned();
        for folder in [&old, &new] {
            std::fs::create_dir(folder.path().join("around")).unwrap();
            std::fs::write(folder.path().join("around/wall.png"), b"wall").unwrap();
        }
        let [picture, sky] =
            [old.path().join("around").join("wall.png"), old.path().join("sky.hdr")].map(text);
        std::fs::write(&sky, b"sky").unwrap();
        let chosen = Looks { picture, panorama: sky.clone(), ..Looks::default() };
        let saved = refer_looks(chosen.clone(), |file| name_in(file, Some(old.path())));
        assert_eq!(saved.picture, "around/wall.png");
        assert_eq!(saved.panorama, "sky.hdr");
        let (found, warnings) = resolve_looks(saved.clone(), Some(old.path()));
        assert_eq!([&found.picture, &found.panorama].map(Path::new), [&chosen.picture, &sky].map(Path::new));
        assert_eq!(warnings, []);
        // The picture has moved along, the panorama has not.
        let (found, warnings) = resolve_looks(saved, Some(new.path()));
        assert_eq!(Path::new(&found.picture), new.path().join("around/wall.png"));
        assert_eq!(found.panorama, "");
        assert!(warnings.len() == 1 && warnings[0].to_string().contains("sky.hdr"), "{warnings:?}");
        // An older show has the whole path of what now lies beside it.
        std::fs::rename(&sky, new.path().join("sky.hdr")).unwrap();
        let (found, warnings) = resolve_looks(chosen, Some(new.path()));
        assert_eq!(Path::new(&found.panorama), new.path().join("sky.hdr"));
        assert_eq!(warnings, []);
        assert_eq!(resolve_looks(Looks::default(), None), (Looks::default(), Vec::new()));
    }
}
