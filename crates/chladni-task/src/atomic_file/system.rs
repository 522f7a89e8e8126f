//! The system calls that writing a file needs, as a trait, which lets a test make any of them fail.

use std::fs::File;
use std::io::{self, Write};
use std::path::Path;

use tempfile::NamedTempFile;

pub(super) trait System: std::fmt::Debug {
    fn create(&self, builder: &tempfile::Builder<'_, '_>, folder: &Path) -> io::Result<NamedTempFile> {
        builder.tempfile_in(folder)
    }

    fn write(&self, file: &mut File, bytes: &[u8]) -> io::Result<usize> {
        file.write(bytes)
    }

    fn sync(&self, file: &File) -> io::Result<()> {
        file.sync_all()
    }

    fn rename(&self, file: NamedTempFile, path: &Path) -> io::Result<()> {
        file.persist(path).map_err(|failure| failure.error)?;
        Ok(())
    }

    /// As [`rename`](Self::rename), but only where nothing is at `path`.
    fn rename_new(&self, file: NamedTempFile, path: &Path) -> io::Result<()> {
        match file.persist_noclobber(path) {
            Ok(_) => Ok(()),
            Err(failure) if failure.error.kind() == io::ErrorKind::AlreadyExists => Err(failure.error),
            // A file system that knows no way to do both at once.
            Err(_) if path.symlink_metadata().is_ok() => Err(io::ErrorKind::AlreadyExists.into()),
            Err(failure) => self.rename(failure.file, path),
        }
    }

    /// Flushes a folder, which makes a new name in it permanent.
    fn sync_folder(&self, folder: &Path) -> io::Result<()> {
        if !cfg!(unix) {
            return Ok(());
        }
        use io::ErrorKind::{InvalidInput, PermissionDenied, Unsupported};
        match File::open(folder).and_then(|folder| folder.sync_all()) {
            // Some file systems cannot flush a folder, and some folders may be written but not read.
            Err(why) if matches!(why.kind(), InvalidInput | PermissionDenied | Unsupported) => Ok(()),
            done => done,
        }
    }
}

/// The real system.
#[derive(Debug)]
pub(super) struct Disk;

impl System for Disk {}
