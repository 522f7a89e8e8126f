//! Where tests and benchmarks find real meshes and music, which are not part of the
//! repository because their licenses vary, and whether the programs are there that some of them need.
//!
//! ```
//! // Tests that need real data return early where there is none.
//! let Some(path) = chladni_testdata::shared("meshes/shapes/armadillo.obj") else { return };
//! assert!(path.exists());
//! ```

use std::path::PathBuf;

/// The path of `name` in the shared data folder, or `None`, with a printed line, where it is
/// not there.
///
/// The folder is `$CHLADNI_DATA` where that is set, else `shared/data` beside the repository.
#[allow(clippy::print_stderr, reason = "a skipped test must say so, and only tests call this")]
pub fn shared(name: &str) -> Option<PathBuf> {
    let folder = std::env::var_os("CHLADNI_DATA").map_or_else(
        || PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data")),
        PathBuf::from,
    );
    let path = folder.join(name);
    if path.exists() {
        return Some(path);
    }
    eprintln!("skipped: {} is not there (set CHLADNI_DATA)", path.display());
    None
}

/// Whether a program that says its version with `-version`, such as ffmpeg, is on the PATH; prints a line where it is not.
#[allow(clippy::print_stderr, reason = "a skipped test must say so, and only tests call this")]
pub fn program(name: &str) -> bool {
    let is_there = std::process::Command::new(name).arg("-version").output().is_ok();
    if !is_there {
        eprintln!("skipped: no {name}");
    }
    is_there
}
