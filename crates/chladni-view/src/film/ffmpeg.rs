//! How ffmpeg is started: with an environment of its own, and files that can lead to no others.

use std::ffi::OsString;
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};

use chladni_task::{Needs, advice_in, other_program};

use crate::ViewError;

/// A command for ffmpeg.
pub fn ffmpeg() -> Command {
    other_program("ffmpeg", Needs::Files)
}

/// Whether ffmpeg is on the PATH. Once it has run, it is not asked again: that takes a while.
pub fn ffmpeg_is_there() -> bool {
    static HAS_RUN: AtomicBool = AtomicBool::new(false);
    if HAS_RUN.load(Ordering::Relaxed) {
        return true;
    }
    let mut command = ffmpeg();
    command.arg("-version").stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    let runs = command.status().is_ok_and(|status| status.success());
    if runs {
        HAS_RUN.store(true, Ordering::Relaxed);
    }
    runs
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

/// That ffmpeg did not write the film at `path`, in its words, or with advice where the disk is the reason.
pub(super) fn unwritten_by_ffmpeg(said: String, path: &Path) -> ViewError {
    match advice_in(&said) {
        Some(why) => ViewError::at(path)(why),
        None => ViewError::Ffmpeg(said),
    }
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use std::os::unix::fs::PermissionsExt;
    use std::path::PathBuf;

    /// The folder of an ffmpeg that counts its runs.
    const COUNTED: &str = "CHLADNI_TEST_COUNTED_FFMPEG";

    #[test]
    #[ignore = "run by an_ffmpeg_that_is_there_is_asked_once"]
    fn asks_again_and_again() {
        let Some(folder) = std::env::var_os(COUNTED).map(PathBuf::from) else { return };
        assert!(!ffmpeg_is_there());
        // It is installed meanwhile.
        std::fs::rename(folder.join("away"), folder.join("ffmpeg")).unwrap();
        assert!((0..3).all(|_| ffmpeg_is_there()));
    }

    #[test]
    fn an_ffmpeg_that_is_there_is_asked_once() {
        let folder = tempfile::tempdir().unwrap();
        let away = folder.path().join("away");
        std::fs::write(&away, "#!/bin/sh\necho run >> \"${0%/*}/runs\"\n").unwrap();
        std::fs::set_permissions(&away, std::fs::Permissions::from_mode(0o755)).unwrap();
        let mut child = Command::new(std::env::current_exe().unwrap());
        child.args(["--exact", "film::ffmpeg::tests::asks_again_and_again", "--ignored"]);
        let output = child.env("PATH", folder.path()).env(COUNTED, folder.path()).output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stdout));
        assert_eq!(std::fs::read_to_string(folder.path().join("runs")).unwrap(), "run\n");
    }
}
