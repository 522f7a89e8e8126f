//! Files that are written whole or not at all.

#[cfg(test)]
mod faults;
mod leftovers;
mod permissions;
mod system;

use std::fs::File;
use std::io::{self, BufWriter, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

pub use permissions::private_folder;

use permissions::Readers;
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
/// An error of `write`, or of creating, writing or renaming the file. A full disk, a read-only one and
/// missing permission come with advice. [`io::ErrorKind::InvalidInput`] if `path` exists but is not a
/// regular file (a folder, a device, a pipe). If only flushing the folder fails, the new file is already in
/// place.
pub fn write_atomic_with(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<Draft<'_>>) -> io::Result<()>,
) -> io::Result<()> {
    replace(&Disk, path, Readers::Usual, write).map_err(advised)
}

/// As [`write_atomic`], but a file that was not there before stays readable by its owner alone (on Unix).
///
/// # Errors
/// As [`write_atomic_with`].
pub fn write_atomic_private(path: &Path, bytes: &[u8]) -> io::Result<()> {
    replace(&Disk, path, Readers::Owner, |file| file.write_all(bytes)).map_err(advised)
}

/// As [`write_atomic`], but only where nothing is at `path`: of several programs that write there at once, one does.
///
/// # Errors
/// As [`write_atomic_with`]; [`io::ErrorKind::AlreadyExists`] where something is there, a link included.
pub fn write_new(path: &Path, bytes: &[u8]) -> io::Result<()> {
    add(&Disk, path, bytes).map_err(advised)
}

/// Flushes a complete file from [`temporary_beside`] to the disk and renames it to `path`, as
/// [`write_atomic_with`] does.
///
/// # Errors
/// An error of flushing or renaming the file.
pub fn persist(file: NamedTempFile, path: &Path) -> io::Result<()> {
    finish(&Disk, file, &where_it_leads(path), Readers::Usual).map_err(advised)
}

fn replace(
    system: &dyn System,
    path: &Path,
    readers: Readers,
    write: impl FnOnce(&mut BufWriter<Draft<'_>>) -> io::Result<()>,
) -> io::Result<()> {
    let path = &where_it_leads(path);
    let mut file = create(system, path, "")?;
    {
        let mut buffered = BufWriter::with_capacity(1 << 16, Draft { file: file.as_file_mut(), system });
        write(&mut buffered)?;
        buffered.flush()?;
    }
    finish(system, file, path, readers)
}

fn add(system: &dyn System, path: &Path, bytes: &[u8]) -> io::Result<()> {
    let mut file = create(system, path, "")?;
    Draft { file: file.as_file_mut(), system }.write_all(bytes)?;
    permissions::give(file.as_file(), None, Readers::Usual, folder_of(path))?;
    system.sync(file.as_file())?;
    system.rename_new(file, path)?;
    system.sync_folder(folder_of(path))
}

fn finish(system: &dyn System, file: NamedTempFile, path: &Path, readers: Readers) -> io::Result<()> {
    // A link that is still here is not followed.
    let replaced = std::fs::symlink_metadata(path).ok().filter(|known| !known.is_symlink());
    // Without this check, the rename would replace a device by a regular file.
    if replaced.as_ref().is_some_and(|known| !known.is_file()) {
        let why = "it is a folder, a device or a pipe, which no file takes the place of";
        return Err(io::Error::new(io::ErrorKind::InvalidInput, why));
    }
    permissions::give(file.as_file(), replaced.as_ref(), readers, folder_of(path))?;
    // The order matters: a name that is on the disk before the file's bytes would survive a power cut
    // without them.
    system.sync(file.as_file())?;
    system.rename(file, path)?;
    system.sync_folder(folder_of(path))
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
    std::fs::create_dir_all(path)?;
    // The uppermost first, as the others would not be found without it.
    missing.into_iter().rev().try_for_each(|made| system.sync_folder(folder_of(made)))
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
    let mut builder = tempfile::Builder::new();
    builder.prefix(leftovers::PREFIX).rand_bytes(leftovers::RANDOM).suffix(ending);
    // It is private (0600) until it is complete.
    leftovers::sweep_once(folder_of(path));
    let file = system.create(&builder, folder_of(path)).map_err(without_path)?;
    leftovers::claim(file.as_file());
    Ok(file)
}

/// Removes the temporary file's name from the usual errors: the caller knows only `path`.
fn without_path(error: io::Error) -> io::Error {
    use io::ErrorKind::{NotADirectory, NotFound, PermissionDenied, ReadOnlyFilesystem, StorageFull};
    match error.kind() {
        NotFound => io::Error::new(NotFound, "its folder does not exist"),
        kind @ (NotADirectory | PermissionDenied | ReadOnlyFilesystem | StorageFull) => kind.into(),
        _ => error,
    }
}

/// Adds advice to the errors that a user can do something about.
fn advised(error: io::Error) -> io::Error {
    use io::ErrorKind::{PermissionDenied, QuotaExceeded, ReadOnlyFilesystem, StorageFull};
    let advice = match error.kind() {
        StorageFull | QuotaExceeded => "the disk is full: make room, or write to another one",
        ReadOnlyFilesystem => "the disk is read-only: write to another one",
        PermissionDenied => "permission denied: write to a folder of your own",
        _ => return error,
    };
    io::Error::new(error.kind(), advice)
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
