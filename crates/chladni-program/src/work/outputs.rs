//! Checks where results go before the work: a missing folder is reported at once, not after minutes of
//! computing.

use std::path::Path;

use chladni_task::folder_of;
use chladni_view::{FilmFormat, ViewError, ffmpeg_is_there};

use super::Error;

/// Checks that a file can be written at `path`.
///
/// # Errors
/// [`Error::Input`] or [`Error::Unwritten`], with the path.
pub fn check_file(path: &Path) -> Result<(), Error> {
    let refused = |why: &str| Err(Error::Input(format!("{}: {why}", path.display())));
    if path.is_dir() {
        return refused("is a folder; the name of a file is needed");
    }
    if path.exists() && !path.is_file() {
        return refused("is a device or a pipe; the name of a file is needed");
    }
    let folder = folder_of(path);
    if !folder.is_dir() {
        return refused("its folder does not exist");
    }
    tempfile::tempfile_in(folder).map(drop).map_err(|error| Error::unwritten(path, error.kind().to_string()))
}

/// Checks that files can be written into the folder `path`, which is created if it does not exist.
///
/// # Errors
/// As [`check_file`] does.
pub fn check_folder(path: &Path) -> Result<(), Error> {
    if path.is_dir() { check_file(&path.join("new")) } else { check_file(path) }
}

/// Checks that a film can be written at `path`: a file, or frames into a folder.
///
/// # Errors
/// As [`check_file`] does, and an MP4 where there is no ffmpeg.
pub fn check_film(path: &Path) -> Result<(), Error> {
    match FilmFormat::of(path).map_err(Error::input)? {
        FilmFormat::Frames => check_folder(path),
        FilmFormat::Mp4 if !ffmpeg_is_there() => {
            Err(Error::Input(format!("{}: {}", path.display(), ViewError::NoFfmpeg)))
        }
        _ => check_file(path),
    }
}

/// Checks that a picture can be written at `path`, whose name must end in `.png`.
///
/// # Errors
/// As [`check_file`] does.
pub fn check_picture(path: &Path) -> Result<(), Error> {
    check_endings(path, &["png"])
}

/// Checks that a picture can be written at `path`, whose name must end in one of `endings`.
///
/// # Errors
/// As [`check_file`] does.
pub fn check_endings(path: &Path, endings: &[&str]) -> Result<(), Error> {
    if !path.extension().is_some_and(|own| endings.iter().any(|ending| own.eq_ignore_ascii_case(ending))) {
        let listed = endings.join(" or .");
        return Err(Error::Input(format!("{}: a picture ends in .{listed}", path.display())));
    }
    check_file(path)
}
