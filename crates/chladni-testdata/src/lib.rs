//! Where tests and benchmarks find real meshes and music, which are not part of the
//! repository because their licenses vary, and whether the programs are there that some of them need. Films
//! and damaged songs they make themselves, and a sound server, a process or a small disk of their own they start. Chance is the
//! same each time. What they compute in doubles they check with numbers of twice the digits.
//!
//! ```
//! // Tests that need real data return early where there is none.
//! let Some(path) = chladni_testdata::shared("meshes/shapes/armadillo.obj") else { return };
//! assert!(path.exists());
//! ```

mod double_double;
mod ogg;
mod process;
mod sound_server;

use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

pub use double_double::{DoubleDouble, TAU};
pub use ogg::{crc, ogg_page, vorbis_of_books};
pub use process::{CHILDS_FOLDER, childs_folder, ignored_test, in_shell, on_a_small_disk};
pub use sound_server::SoundServer;

/// Far longer than whatever a test waits for takes on a loaded machine: something hangs.
pub const HANGS: Duration = Duration::from_secs(1200);

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
    let is_there = Command::new(name).arg("-version").output().is_ok();
    if !is_there {
        eprintln!("skipped: no {name}");
    }
    is_there
}

/// An OBJ with the material `skin` of `library`; `across` says where across its texture, in [0, 1], a vertex is.
pub fn textured_obj(
    positions: &[[f64; 3]],
    triangles: &[[u32; 3]],
    library: &str,
    across: impl Fn(&[f64; 3]) -> f64,
) -> String {
    let vertex = |p: &[f64; 3]| format!("v {} {} {}\nvt {} 0.5\n", p[0], p[1], p[2], across(p));
    let face = |corners: &[u32; 3]| {
        let [a, b, c] = corners.map(|v| v + 1);
        format!("f {a}/{a} {b}/{b} {c}/{c}\n")
    };
    let rows = positions.iter().map(vertex).chain(triangles.iter().map(face));
    std::iter::once(format!("mtllib {library}\nusemtl skin\n")).chain(rows).collect()
}

/// A number from the environment, such as how many cases a campaign tries; `usual` where it is not set.
pub fn setting(name: &str, usual: u64) -> u64 {
    std::env::var(name).ok().and_then(|value| value.parse().ok()).unwrap_or(usual)
}

/// Numbers from Knuth's linear congruential generator. Their upper bits are by far the better ones.
pub fn chance(seed: u64) -> impl FnMut() -> u64 {
    let mut state = seed;
    move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        state
    }
}

/// A film in `folder` of 25 pictures a second, each of one gray, that gets brighter by `step` of 255 from picture to
/// picture; `None`, with a printed line, where ffmpeg is not there.
///
/// # Panics
/// Where ffmpeg cannot make it.
pub fn brightening_film(folder: &Path, [width, height]: [u32; 2], secs: f64, step: u32) -> Option<PathBuf> {
    if !program("ffmpeg") {
        return None;
    }
    let path = folder.join("brightening.mkv");
    let made = Command::new("ffmpeg")
        .args(["-loglevel", "error", "-f", "lavfi", "-i"])
        .arg(format!("color=black:s={width}x{height}:r=25:d={secs}"))
        .args(["-vf", &format!("geq=lum=16+{step}*N:cb=128:cr=128"), "-c:v", "ffv1"])
        .arg(&path)
        .status();
    assert!(made.is_ok_and(|status| status.success()), "ffmpeg does not make {}", path.display());
    Some(path)
}
