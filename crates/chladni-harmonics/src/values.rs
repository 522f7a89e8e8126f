//! Long arrays in memory, or in a file where memory has no room for them.
#![allow(unsafe_code, reason = "mapping a file, for which there is no safe interface")]

#[cfg(not(target_family = "wasm"))]
use std::fs::File;
use std::io;
use std::ops::{Deref, DerefMut};
use std::path::{Path, PathBuf};

use bytemuck::Pod;

use crate::{HarmonicsError, pages};

/// Where large arrays are kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Keep<'a> {
    Memory,
    /// In files without names in this folder.
    Folder(&'a Path),
}

/// A slice of values that is either in memory or in a mapped file without a name, which the system reads
/// and writes piece by piece and which vanishes with the value.
pub struct Values<T = f64>(Place<T>);

enum Place<T> {
    Memory(Vec<T>),
    #[cfg(not(target_family = "wasm"))]
    File {
        map: memmap2::MmapMut,
        /// The number of values in use, at most as many as fit in the file.
        len: usize,
        of: std::marker::PhantomData<T>,
    },
}

impl Keep<'_> {
    /// The error of values that could not be kept here.
    pub(crate) fn refused(self, error: &io::Error) -> HarmonicsError {
        let folder = if let Keep::Folder(folder) = self { folder.to_owned() } else { PathBuf::new() };
        HarmonicsError::NoScratch { folder, reason: error.to_string() }
    }
}

impl<T: Pod> Values<T> {
    /// `len` zeros. A few are kept in memory in any case.
    ///
    /// # Errors
    /// The folder cannot be written to, or its disk has no room for the values.
    pub(crate) fn zeroed(len: usize, keep: Keep) -> io::Result<Self> {
        match keep {
            #[cfg(not(target_family = "wasm"))]
            Keep::Folder(folder) if len.saturating_mul(size_of::<T>()) >= pages::LARGE => {
                let bytes = (len as u64).saturating_mul(size_of::<T>() as u64);
                let file = file_of(folder, bytes)?;
                // SAFETY: the file has no name and its handle ends here, so that no other program and no
                // other part of this one can shorten or change it. All of its blocks have been allocated.
                let map = unsafe { memmap2::MmapMut::map_mut(&file)? };
                Ok(Self(Place::File { map, len, of: std::marker::PhantomData }))
            }
            _ => Ok(Self(Place::Memory(pages::zeroed(len)))),
        }
    }

    /// The same values, moved to where `keep` says.
    pub(crate) fn moved(self, keep: Keep) -> io::Result<Self> {
        if keep == Keep::Memory || !self.is_in_memory() {
            return Ok(self);
        }
        let mut moved = Self::zeroed(self.len(), keep)?;
        moved.copy_from_slice(&self);
        Ok(moved)
    }

    /// Keeps the first `len` values, or all if there are fewer.
    pub fn truncate(&mut self, len: usize) {
        match &mut self.0 {
            Place::Memory(values) => values.truncate(len),
            #[cfg(not(target_family = "wasm"))]
            Place::File { len: used, .. } => *used = len.min(*used),
        }
    }

    /// Whether the values are in memory, rather than in a file.
    pub fn is_in_memory(&self) -> bool {
        matches!(self.0, Place::Memory(_))
    }

    /// The values as a vector, which takes as much memory as they do.
    pub fn into_vec(self) -> Vec<T> {
        match self.0 {
            Place::Memory(values) => values,
            #[cfg(not(target_family = "wasm"))]
            Place::File { .. } => self.to_vec(),
        }
    }
}

/// A nameless file of `bytes` zeros in `folder`, with all of its blocks allocated: if a block were missing, writing
/// to the mapped file would end the program.
#[cfg(not(target_family = "wasm"))]
fn file_of(folder: &Path, bytes: u64) -> io::Result<File> {
    let mut file = tempfile::tempfile_in(folder)?;
    if !allocated(&file, bytes)? {
        io::copy(&mut io::Read::take(io::repeat(0), bytes), &mut file)?;
    }
    Ok(file)
}

/// Allocates `bytes` of a file without writing them; false where the file system cannot, and nothing was done. (The C
/// library's `posix_fallocate` would then write all of them.)
#[cfg(target_os = "linux")]
fn allocated(file: &File, bytes: u64) -> io::Result<bool> {
    use std::os::fd::AsRawFd;
    let length = libc::off_t::try_from(bytes).map_err(io::Error::other)?;
    loop {
        // SAFETY: the descriptor is open, and the call only changes the file.
        if unsafe { libc::fallocate(file.as_raw_fd(), 0, 0, length) } == 0 {
            return Ok(true);
        }
        let error = io::Error::last_os_error();
        match error.raw_os_error() {
            Some(libc::EINTR) => {}
            Some(libc::EOPNOTSUPP | libc::ENOSYS) => return Ok(false),
            _ => return Err(error),
        }
    }
}

#[cfg(not(any(target_os = "linux", target_family = "wasm")))]
fn allocated(_: &File, _: u64) -> io::Result<bool> {
    Ok(false)
}

/// Fails if `folder` cannot take `bytes`, where the system can tell without writing them.
#[cfg(target_os = "linux")]
pub(crate) fn check_folder(folder: &Path, bytes: u64) -> io::Result<()> {
    let file = tempfile::tempfile_in(folder)?;
    if allocated(&file, bytes)? || free_bytes(&file)? >= u128::from(bytes) {
        return Ok(());
    }
    Err(io::ErrorKind::StorageFull.into())
}

/// The bytes that the file system of an open file has for this user.
#[cfg(target_os = "linux")]
fn free_bytes(file: &File) -> io::Result<u128> {
    use std::os::fd::AsRawFd;
    let mut about = std::mem::MaybeUninit::<libc::statvfs>::uninit();
    // SAFETY: the descriptor is open, and the call writes no more than the structure.
    if unsafe { libc::fstatvfs(file.as_raw_fd(), about.as_mut_ptr()) } != 0 {
        return Err(io::Error::last_os_error());
    }
    // SAFETY: the call has succeeded, so that the structure is filled.
    let about = unsafe { about.assume_init() };
    Ok(u128::from(about.f_bavail) * u128::from(about.f_frsize))
}

#[cfg(not(any(target_os = "linux", target_family = "wasm")))]
pub(crate) fn check_folder(_: &Path, _: u64) -> io::Result<()> {
    Ok(())
}

#[cfg(target_family = "wasm")]
pub(crate) fn check_folder(_: &Path, _: u64) -> io::Result<()> {
    Err(io::ErrorKind::Unsupported.into())
}

impl<T: Pod> Deref for Values<T> {
    type Target = [T];

    fn deref(&self) -> &[T] {
        match &self.0 {
            Place::Memory(values) => values,
            #[cfg(not(target_family = "wasm"))]
            Place::File { map, len, .. } => &bytemuck::cast_slice(map)[..*len],
        }
    }
}

impl<T: Pod> DerefMut for Values<T> {
    fn deref_mut(&mut self) -> &mut [T] {
        match &mut self.0 {
            Place::Memory(values) => values,
            #[cfg(not(target_family = "wasm"))]
            Place::File { map, len, .. } => &mut bytemuck::cast_slice_mut(map)[..*len],
        }
    }
}

/// A copy in memory.
impl<T: Pod> Clone for Values<T> {
    fn clone(&self) -> Self {
        self.to_vec().into()
    }
}

impl<T> Default for Values<T> {
    fn default() -> Self {
        Self(Place::Memory(Vec::new()))
    }
}

impl<T> From<Vec<T>> for Values<T> {
    fn from(values: Vec<T>) -> Self {
        Self(Place::Memory(values))
    }
}

impl<T> FromIterator<T> for Values<T> {
    fn from_iter<I: IntoIterator<Item = T>>(values: I) -> Self {
        Vec::from_iter(values).into()
    }
}

impl<'a, T: Pod> IntoIterator for &'a Values<T> {
    type Item = &'a T;
    type IntoIter = std::slice::Iter<'a, T>;

    fn into_iter(self) -> Self::IntoIter {
        self.iter()
    }
}

impl<T: Pod + PartialEq> PartialEq for Values<T> {
    fn eq(&self, other: &Self) -> bool {
        self[..] == other[..]
    }
}

impl<T: Pod + std::fmt::Debug> std::fmt::Debug for Values<T> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self[..].fmt(f)
    }
}

#[cfg(all(test, not(target_family = "wasm")))]
mod tests {
    use super::*;

    #[test]
    fn values_in_a_file_are_those_in_memory_and_leave_nothing_behind() {
        let folder = tempfile::tempdir().unwrap();
        let len = 3 * pages::LARGE / size_of::<f64>() + 5;
        let numbers: Vec<f64> = (0..len).map(|i| i as f64).collect();
        let mut values = Values::from(numbers.clone()).moved(Keep::Folder(folder.path())).unwrap();
        assert!(!values.is_in_memory());
        assert_eq!(values[..], numbers[..]);
        // Elsewhere it has a name until it is closed.
        let named = usize::from(!cfg!(unix));
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), named, "the file has no name");
        values[len - 1] = -1.0;
        assert_eq!(values.clone()[len - 1], -1.0);
        assert!(values.clone().is_in_memory());
        values.truncate(len + 1);
        assert_eq!(values.len(), len);
        values.truncate(7);
        assert_eq!(values.into_vec(), numbers[..7]);
        // Few values stay in memory, and no file is needed for them.
        assert!(Values::<f64>::zeroed(10, Keep::Folder(Path::new("/nowhere"))).unwrap().is_in_memory());
        assert!(Values::<f64>::zeroed(len, Keep::Folder(&folder.path().join("none"))).is_err());
        assert!(check_folder(folder.path(), 1 << 20).is_ok());
        assert!(!cfg!(target_os = "linux") || check_folder(folder.path(), 1 << 60).is_err());
        #[cfg(target_os = "linux")]
        {
            let free = free_bytes(&tempfile::tempfile_in(folder.path()).unwrap()).unwrap();
            assert!(free > 1 << 20 && free < 1 << 60, "{free}");
        }
    }
}
