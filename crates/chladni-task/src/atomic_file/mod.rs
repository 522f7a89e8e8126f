//! Files that are written whole or not at all.

mod advice;
#[cfg(test)]
mod faults;
mod leftovers;
mod permissions;
mod system;

use std::fs::{File, Metadata};
use std::io::{self, BufWriter, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

pub use advice::{advice_in, advised};
pub use permissions::private_folder;

use permissions::{PRIVATE, Readers};
use system::{Disk, System};
use tempfile::NamedTempFile;

/// Writes `bytes` to `path`. At any moment, readers find either the old file or the complete new one.
///
/// # Errors
/// As [`write_atomic_with`].
pub fn write_atomic(path: &Path, bytes: &[u8]) -> io::Result<()> {
    write_atomic_with(path, |file| file.write_all(bytes))
}

/// Creates a temporary file beside `path`, lets `write` fill it, flushes it to the disk, renames it to
/// `path`, and flushes the folder. Once this function has returned, the file survives a power cut, except on a volume of
/// macOS that cannot be flushed.
///
/// If `write` fails or the process dies, `path` is unchanged; a temporary file that a killed process left is removed by
/// a later one that saves in the same folder. If `path` is a link, its target is replaced, unless [another user put it
/// there](where_it_leads).
/// On Unix, only its owner can read the temporary file; in the end it takes the permissions of the file that it replaces, or those
/// that the system gives new files. The folder of `path` must exist.
///
/// # Errors
/// An error of `write`, or of creating, writing or renaming the file. Those that a user can do something about come with
/// [advice](advised). [`io::ErrorKind::InvalidInput`] if `path` exists but is not a
/// regular file (a folder, a device, a pipe). If only flushing the folder fails, the new file is already in
/// place.
pub fn write_atomic_with(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<Draft<'_>>) -> io::Result<()>,
) -> io::Result<()> {
    replace(&Disk, path, Readers::Usual, write)
}

/// As [`write_atomic`], but a file that was not there before stays readable by its owner alone (on Unix).
///
/// # Errors
/// As [`write_atomic_with`].
pub fn write_atomic_private(path: &Path, bytes: &[u8]) -> io::Result<()> {
    replace(&Disk, path, Readers::Owner, |file| file.write_all(bytes))
}

/// As [`write_atomic`], but only where nothing is at `path`: of several programs that write there at once, one does.
///
/// # Errors
/// As [`write_atomic_with`]; [`io::ErrorKind::AlreadyExists`] where something is there, a link included.
pub fn write_new(path: &Path, bytes: &[u8]) -> io::Result<()> {
    add(&Disk, path, bytes)
}

/// Flushes a complete file from [`temporary_beside`] to the disk and renames it to `path`, as
/// [`write_atomic_with`] does.
///
/// # Errors
/// An error of flushing or renaming the file.
pub fn persist(file: NamedTempFile, path: &Path) -> io::Result<()> {
    finish(&Disk, file, &where_it_leads(path), Readers::Usual)
}

/// As [`persist`], but under the first of `names`, all in the file's folder, at which nothing is; returns that one. At each moment
/// the whole file is there or nothing.
///
/// # Errors
/// As [`persist`]; [`io::ErrorKind::AlreadyExists`] where something is at each of them, a link included.
pub fn persist_new(file: NamedTempFile, names: impl Iterator<Item = PathBuf>) -> io::Result<PathBuf> {
    finish_new(&Disk, file, names)
}

fn replace(
    system: &dyn System,
    path: &Path,
    readers: Readers,
    write: impl FnOnce(&mut BufWriter<Draft<'_>>) -> io::Result<()>,
) -> io::Result<()> {
    let path = &where_it_leads(path);
    let file = filled(system, path, write).map_err(advised)?;
    finish(system, file, path, readers)
}

fn add(system: &dyn System, path: &Path, bytes: &[u8]) -> io::Result<()> {
    let file = filled(system, path, |file| file.write_all(bytes)).map_err(advised)?;
    finish_new(system, file, std::iter::once(path.to_owned())).map(drop)
}

/// A draft of `path` with all that `write` gives it.
fn filled(
    system: &dyn System,
    path: &Path,
    write: impl FnOnce(&mut BufWriter<Draft<'_>>) -> io::Result<()>,
) -> io::Result<NamedTempFile> {
    let mut file = create(system, path, "")?;
    let mut buffered = BufWriter::with_capacity(1 << 16, Draft { file: file.as_file_mut(), system });
    write(&mut buffered)?;
    buffered.flush()?;
    drop(buffered);
    Ok(file)
}

fn finish(system: &dyn System, file: NamedTempFile, path: &Path, readers: Readers) -> io::Result<()> {
    settle_and_rename(system, file, path, readers).map_err(advised)?;
    flush_name(system, path)
}

fn settle_and_rename(
    system: &dyn System,
    file: NamedTempFile,
    path: &Path,
    readers: Readers,
) -> io::Result<()> {
    // A link that is still here is not followed.
    let replaced = std::fs::symlink_metadata(path).ok().filter(|known| !known.is_symlink());
    // Without this check, the rename would replace a device by a regular file.
    if replaced.as_ref().is_some_and(|known| !known.is_file()) {
        let why = "it is a folder, a device or a pipe, which no file takes the place of";
        return Err(io::Error::new(io::ErrorKind::InvalidInput, why));
    }
    settle(system, &file, replaced.as_ref(), readers)?;
    system.rename(file, path)
}

fn finish_new(
    system: &dyn System,
    file: NamedTempFile,
    names: impl Iterator<Item = PathBuf>,
) -> io::Result<PathBuf> {
    let name = settle_and_name(system, file, names).map_err(advised)?;
    flush_name(system, &name)?;
    Ok(name)
}

fn settle_and_name(
    system: &dyn System,
    mut file: NamedTempFile,
    names: impl Iterator<Item = PathBuf>,
) -> io::Result<PathBuf> {
    settle(system, &file, None, Readers::Usual)?;
    for name in names {
        match system.rename_new(file, &name) {
            Ok(()) => return Ok(name),
            Err(taken) if taken.error.kind() == io::ErrorKind::AlreadyExists => file = taken.file,
            Err(failure) => return Err(failure.error),
        }
    }
    Err(io::ErrorKind::AlreadyExists.into())
}

/// Gives a complete draft its permissions and flushes it. The order matters: a name that is on the disk before the file's
/// bytes would survive a power cut without them.
fn settle(
    system: &dyn System,
    file: &NamedTempFile,
    replaced: Option<&Metadata>,
    readers: Readers,
) -> io::Result<()> {
    permissions::give(system, file, replaced, readers)?;
    system.sync(file.as_file())
}

/// Flushes the folder of a file that has just got its name `path`.
fn flush_name(system: &dyn System, path: &Path) -> io::Result<()> {
    system.sync_folder(folder_of(path)).map_err(|why| {
        let said = format!(
            "the new file is in place, but a power cut could lose it, since its folder cannot be flushed to the disk \
             ({why}): save to another disk, too"
        );
        io::Error::new(why.kind(), said)
    })
}

/// A file that is being written.
#[derive(Debug)]
pub struct Draft<'a> {
    file: &'a mut File,
    system: &'a dyn System,
}

impl Write for Draft<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.system.write(self.file, bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

impl Seek for Draft<'_> {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.file.seek(to)
    }
}

/// The final target of the links at `path`; `path` itself if it is not a link or the links form a loop. On Unix, a link that
/// another user put into a folder like `/tmp`, where everybody may write, is not followed.
pub fn where_it_leads(path: &Path) -> PathBuf {
    let mut end = path.to_owned();
    for _ in 0..40 {
        match std::fs::read_link(&end) {
            Ok(target) if permissions::may_follow(&end, folder_of(&end)) => {
                end = end.parent().unwrap_or(Path::new("")).join(target);
            }
            _ => return end,
        }
    }
    path.to_owned()
}

/// Makes the folder `path`, and those above it that are missing. Those that are new survive a power cut once this function has
/// returned; one that was there stays as it is.
///
/// # Errors
/// A folder cannot be made; see [`write_atomic_with`] for the advice. [`io::ErrorKind::AlreadyExists`] if `path` is something else.
pub fn create_folder(path: &Path) -> io::Result<()> {
    make_folders(&Disk, path).map_err(advised)
}

/// As [`create_folder`], but on Unix only its owner can enter the folder from then on, also where it was there. On a file
/// system that cannot do this, it stays open.
///
/// # Errors
/// As [`create_folder`].
pub fn create_private_folder(path: &Path) -> io::Result<()> {
    create_folder(path)?;
    permissions::shut_others_out(path);
    Ok(())
}

fn make_folders(system: &dyn System, path: &Path) -> io::Result<()> {
    let is_missing = |folder: &&Path| !folder.as_os_str().is_empty() && !folder.exists();
    let missing: Vec<&Path> = path.ancestors().take_while(is_missing).collect();
    if missing.is_empty() && !path.as_os_str().is_empty() && !path.is_dir() {
        return Err(io::ErrorKind::AlreadyExists.into());
    }
    // The uppermost first, as the others would not be found without it.
    missing.into_iter().rev().try_for_each(|folder| {
        match system.make_folder(folder) {
            // Another program was quicker, or it is a name for one that was just made (`a/..`).
            Err(_) if folder.is_dir() => {}
            made => made?,
        }
        system.sync_folder(folder_of(folder))
    })
}

/// The folder of `path`: its parent, or `.` for a bare name.
pub fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    }
}

/// A temporary file in the folder of `path`, or of what that links to, with a name that ends in `ending`. On Unix, only its
/// owner can read it. When it is complete, [`persist`] renames it to `path`.
///
/// # Errors
/// The file cannot be created.
pub fn temporary_beside(path: &Path, ending: &str) -> io::Result<NamedTempFile> {
    let file = create(&Disk, &where_it_leads(path), ending).map_err(advised)?;
    leftovers::let_others_write(&file);
    Ok(file)
}

fn create(system: &dyn System, path: &Path, ending: &str) -> io::Result<NamedTempFile> {
    leftovers::sweep_once(folder_of(path));
    let file = draft_in(system, folder_of(path), ending, PRIVATE).map_err(|why| match why.kind() {
        io::ErrorKind::NotFound => io::Error::new(why.kind(), "its folder does not exist"),
        _ => why,
    })?;
    leftovers::claim(file.as_file());
    Ok(file)
}

/// A temporary file with a name of ours that ends in `ending`. Its mode on Unix is `mode`, less what the process's mask takes.
fn draft_in(system: &dyn System, folder: &Path, ending: &str, mode: u32) -> io::Result<NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(leftovers::PREFIX).rand_bytes(leftovers::RANDOM).suffix(ending);
    // The library's own way to open it would put the temporary file's name, which nobody knows, into errors.
    builder.make_in(folder, |path| system.create(path, mode))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_several_that_write_a_new_file_one_does() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("new");
        let start = std::sync::Barrier::new(8);
        let write = |i: u8| {
            start.wait();
            write_new(&path, &[i; 1 << 16]).map(|()| i)
        };
        let written: Vec<io::Result<u8>> = std::thread::scope(|scope| {
            let threads: Vec<_> = (0..8).map(|i| scope.spawn(move || write(i))).collect();
            threads.into_iter().map(|thread| thread.join().unwrap()).collect()
        });
        let (done, refused): (Vec<_>, Vec<_>) = written.into_iter().partition(Result::is_ok);
        let kinds: Vec<io::ErrorKind> = refused.into_iter().map(|error| error.unwrap_err().kind()).collect();
        assert_eq!(kinds, [io::ErrorKind::AlreadyExists; 7]);
        assert_eq!(std::fs::read(&path).unwrap(), [done.into_iter().next().unwrap().unwrap(); 1 << 16]);
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1, "drafts are gone");
    }

    #[test]
    fn a_folder_that_is_not_there_is_named_without_the_temporary_file() {
        let folder = tempfile::tempdir().unwrap();
        let error = write_atomic(&folder.path().join("no/shape.obj"), b"").unwrap_err();
        assert_eq!(error.kind(), io::ErrorKind::NotFound);
        assert!(!error.to_string().contains(".chladni-"), "{error}");
    }

    #[test]
    fn a_failed_write_keeps_the_old_file_and_leaves_nothing_beside_it() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("shape.obj");
        write_atomic(&path, b"old").unwrap();
        let failed = write_atomic_with(&path, |file| {
            file.write_all(b"half")?;
            Err(io::Error::other("disk on fire"))
        });
        assert!(failed.is_err());
        assert_eq!(std::fs::read(&path).unwrap(), b"old");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[cfg(unix)]
    #[test]
    fn what_is_no_file_is_never_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let (socket, link) = (folder.path().join("socket"), folder.path().join("link"));
        let _bound = std::os::unix::net::UnixListener::bind(&socket).unwrap();
        std::os::unix::fs::symlink("socket", &link).unwrap();
        std::fs::create_dir(folder.path().join("folder")).unwrap();
        for name in ["socket", "link", "folder"] {
            let error = write_atomic(&folder.path().join(name), b"new").unwrap_err();
            assert_eq!(error.kind(), io::ErrorKind::InvalidInput, "{name}");
        }
        assert!(!socket.metadata().unwrap().is_file());
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 3);
    }

    #[cfg(unix)]
    #[test]
    fn a_link_stays_a_link_and_what_was_private_stays_private() {
        use std::fs::Permissions;
        use std::os::unix::fs::{PermissionsExt, symlink};
        let folder = tempfile::tempdir().unwrap();
        std::fs::create_dir(folder.path().join("elsewhere")).unwrap();
        let (file, link) = (folder.path().join("elsewhere/p.chladni"), folder.path().join("p.chladni"));
        std::fs::write(&file, "old").unwrap();
        std::fs::set_permissions(&file, Permissions::from_mode(0o600)).unwrap();
        symlink("elsewhere/p.chladni", &link).unwrap();
        write_atomic(&link, b"new").unwrap();
        assert!(std::fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(std::fs::read(&file).unwrap(), b"new");
        assert_eq!(std::fs::metadata(&file).unwrap().permissions().mode() & 0o777, 0o600);
        // The file is created at the missing target of a link.
        symlink("elsewhere/q.chladni", folder.path().join("q")).unwrap();
        write_atomic(&folder.path().join("q"), b"first").unwrap();
        assert_eq!(std::fs::read(folder.path().join("q")).unwrap(), b"first");
    }

    #[cfg(unix)]
    #[test]
    fn a_link_of_another_user_in_a_shared_folder_is_replaced_and_not_followed() {
        use std::fs::Permissions;
        use std::os::unix::fs::{MetadataExt, PermissionsExt, lchown, symlink};
        let home = tempfile::tempdir().unwrap();
        let (shared, target) = (home.path().join("shared"), home.path().join("target"));
        let link = shared.join("link");
        std::fs::create_dir(&shared).unwrap();
        std::fs::set_permissions(&shared, Permissions::from_mode(0o1777)).unwrap();
        symlink("../target", &link).unwrap();
        write_atomic(&link, b"own").unwrap();
        assert_eq!(std::fs::read(&target).unwrap(), b"own");
        // Only root can give a link away.
        if lchown(&link, Some(4321), None).is_ok() {
            let (plain, mode) = (shared.join("plain"), |path: &Path| path.metadata().unwrap().mode());
            std::fs::write(&plain, "").unwrap();
            std::fs::set_permissions(&target, Permissions::from_mode(0o606)).unwrap();
            write_atomic(&link, b"new").unwrap();
            assert_eq!(std::fs::read(&target).unwrap(), b"own");
            assert_eq!(std::fs::read(&link).unwrap(), b"new");
            assert_eq!(mode(&link), mode(&plain));
        }
    }
}
