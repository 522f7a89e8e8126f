//! Files and folders that work leaves, with their names in the errors.

use std::path::Path;

use super::Error;

/// Writes a file, completely or not at all.
///
/// # Errors
/// [`Error::Unwritten`] with the file's name.
pub fn write_file(path: &Path, bytes: &[u8]) -> Result<(), Error> {
    chladni_task::write_atomic(path, bytes).map_err(|error| Error::unwritten(path, error))
}

/// Makes a folder, with those around it, where it is not there.
///
/// # Errors
/// [`Error::Unwritten`] with the folder's name.
pub fn make_folder(path: &Path) -> Result<(), Error> {
    chladni_task::create_folder(path).map_err(|error| Error::unwritten(path, error))
}
