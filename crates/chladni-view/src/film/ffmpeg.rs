//! How ffmpeg is started: with an environment of its own, and files that can lead to no others.

use std::ffi::OsString;
use std::path::Path;
use std::process::{Command, Stdio};

use chladni_task::{Needs, other_program};

/// A command for ffmpeg.
pub fn ffmpeg() -> Command {
    other_program("ffmpeg", Needs::Files)
}

/// Whether ffmpeg is on the PATH.
pub fn ffmpeg_is_there() -> bool {
    ffmpeg()
        .arg("-version")
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .status()
        .is_ok_and(|status| status.success())
}

/// Adds a file that ffmpeg reads, after the options that are for it. It may be of one of `formats` only, as ffmpeg calls them: a
/// playlist or a script would name other files to read.
pub fn add_input(command: &mut Command, path: &Path, formats: &[&str]) {
    command.args(["-protocol_whitelist", "file", "-format_whitelist", &formats.join(",")]);
    command.arg("-i").arg(file_argument(path));
}

/// A path as ffmpeg's argument: a name is a file, never an address or an option.
pub(super) fn file_argument(path: &Path) -> OsString {
    let mut argument = OsString::from("file:");
    argument.push(path);
    argument
}
