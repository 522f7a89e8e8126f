//! The system calls that writing a file needs, as a trait, which lets a test make any of them fail.

use std::fs::{File, Permissions};
use std::io::{self, Write};
use std::path::Path;

use tempfile::{NamedTempFile, PersistError};

pub(super) trait System: std::fmt::Debug {
    /// Creates a file where nothing is.
    fn create(&self, path: &Path, mode: u32) -> io::Result<File> {
        let mut options = File::options();
        options.read(true).write(true).create_new(true);
        #[cfg(unix)]
        std::os::unix::fs::OpenOptionsExt::mode(&mut options, mode);
        #[cfg(not(unix))]
        let _ = mode;
        options.open(path)
    }

    fn set_permissions(&self, file: &File, wanted: Permissions) -> io::Result<()> {
        file.set_permissions(wanted)
    }

    fn write(&self, file: &mut File, bytes: &[u8]) -> io::Result<usize> {
        file.write(bytes)
    }

    fn sync(&self, file: &File) -> io::Result<()> {
        match file.sync_all() {
            // It asks for more than other systems do: that the disk empties its cache, too.
            Err(why) if cfg!(target_vendor = "apple") && cannot_flush(&why) => Ok(()),
            done => done,
        }
    }

    fn rename(&self, file: NamedTempFile, path: &Path) -> io::Result<()> {
        file.persist(path).map_err(|failure| failure.error)?;
        Ok(())
    }

    /// As [`rename`](Self::rename), but only where nothing is at `path`.
    fn rename_new(&self, file: NamedTempFile, path: &Path) -> Result<(), PersistError> {
        match file.persist_noclobber(path) {
            Ok(_) => Ok(()),
            Err(failure) if failure.error.kind() == io::ErrorKind::AlreadyExists => Err(failure),
            // A file system that knows no way to do both at once.
            Err(PersistError { file, .. }) if path.symlink_metadata().is_ok() => {
                Err(PersistError { error: io::ErrorKind::AlreadyExists.into(), file })
            }
            Err(failure) => failure.file.persist(path).map(drop),
        }
    }

    fn make_folder(&self, path: &Path) -> io::Result<()> {
        std::fs::create_dir(path)
    }

    /// Flushes a folder, which makes a new name in it permanent.
    fn sync_folder(&self, folder: &Path) -> io::Result<()> {
        if !cfg!(unix) {
            return Ok(());
        }
        match File::open(folder).and_then(|folder| folder.sync_all()) {
            // Some file systems cannot flush a folder, and some folders may be written but not read.
            Err(why) if cannot_flush(&why) || why.kind() == io::ErrorKind::PermissionDenied => Ok(()),
            done => done,
        }
    }
}

/// Whether a flush failed because the file system knows none.
fn cannot_flush(why: &io::Error) -> bool {
    // Apple's ENOTTY and ENOTSUP, which are no kinds of error in the standard library.
    const NOT_SUPPORTED: [i32; 2] = [25, 45];
    matches!(why.kind(), io::ErrorKind::InvalidInput | io::ErrorKind::Unsupported)
        || (cfg!(target_vendor = "apple")
            && why.raw_os_error().is_some_and(|code| NOT_SUPPORTED.contains(&code)))
}

/// The real system.
#[derive(Debug)]
pub(super) struct Disk;

impl System for Disk {}

#[cfg(test)]
mod tests {
    use super::*;
    use io::ErrorKind::{InvalidInput, Other, StorageFull, Unsupported};

    #[test]
    fn a_flush_that_there_is_not_is_told_from_one_that_failed() {
        let found = [InvalidInput, Unsupported, StorageFull, Other].map(|kind| cannot_flush(&kind.into()));
        assert_eq!(found, [true, true, false, false]);
        for code in [25, 45] {
            let of_apple = cannot_flush(&io::Error::from_raw_os_error(code));
            assert_eq!(of_apple, cfg!(target_vendor = "apple"));
        }
    }
}
