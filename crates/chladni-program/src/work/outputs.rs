//! Where results go, looked at before the work: a folder that is not there is told at once, and
//! not after minutes of computing.

use std::path::Path;

use super::Error;

/// Can a file be written at `path`?
///
/// # Errors
/// [`Error::Input`] or [`Error::Unwritten`], with the path.
pub fn check_file(path: &Path) -> Result<(), Error> {
    let refused = |why: &str| Err(Error::Input(format!("{}: {why}", path.display())));
    if path.is_dir() {
        return refused("is a folder; the name of a file is needed");
    }
    let folder = match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    if !folder.is_dir() {
        return refused("its folder does not exist");
    }
    tempfile::tempfile_in(folder).map(drop).map_err(|error| Error::unwritten(path, error.kind().to_string()))
}

/// Can a picture be written at `path`? Pictures are PNG, so their names say so.
///
/// # Errors
/// As [`check_file`] does.
pub fn check_picture(path: &Path) -> Result<(), Error> {
    if path.extension().is_none_or(|extension| !extension.eq_ignore_ascii_case("png")) {
        return Err(Error::Input(format!("{}: a picture ends in .png", path.display())));
    }
    check_file(path)
}
