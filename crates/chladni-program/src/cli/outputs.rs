//! Where results go, looked at before the work: a folder that is not there is told at once, and
//! not after minutes of computing.

use std::path::Path;

use super::{Failure, Terminal};

/// Can a file be written at `path`?
pub fn check_file(path: &Path) -> Result<(), Failure> {
    let refused = |why: &str| Err(Failure::input(format_args!("{}: {why}", path.display())));
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
    tempfile::tempfile_in(folder).map(drop).map_err(|error| Failure::writing(path, error.kind()))
}

/// Can a picture be written at `path`? Pictures are PNG, so their names say so.
pub fn check_picture(path: &Path) -> Result<(), Failure> {
    if path.extension().is_none_or(|extension| !extension.eq_ignore_ascii_case("png")) {
        return Err(Failure::input(format_args!("{}: a picture ends in .png", path.display())));
    }
    check_file(path)
}

impl Terminal {
    /// Tells of a file that now holds a result.
    pub fn wrote(&self, path: &Path) -> Result<(), Failure> {
        self.result(format_args!("wrote {}", path.display()))
    }
}
