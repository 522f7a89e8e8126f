//! Matches, exaggerates and lets dance small meshes, as fast as a release build is: what estimates how a shape stands is some hundred
//! times slower under AddressSanitizer. Debug assertions are on:
//!
//! `CARGO_PROFILE_RELEASE_DEBUG_ASSERTIONS=true cargo run --release --manifest-path fuzz/Cargo.toml --bin shapes -- CASES SEED
//! [FOLDER …]`
//!
//! The cases are random; after them come the files of the folders, which are inputs of the target `whole`. A case that
//! fails, or takes longer than a minute, is named; a random one runs alone with `1 CASE`.

use std::fmt;
use std::path::PathBuf;
use std::time::Instant;

use chladni_fuzz::{Dance, Pair, Random, dance, pair, whole, whole_dance};

/// A case that takes longer has failed.
const MOST_SECS: f64 = 60.0;

enum Case {
    Random(u64),
    File(PathBuf),
}

impl Case {
    fn run(&self) {
        match self {
            Self::Random(seed) if seed % 2 == 0 => pair(Pair::random(&mut Random::new(*seed))),
            Self::Random(seed) => dance(Dance::random(&mut Random::new(*seed))),
            Self::File(path) => {
                let bytes = std::fs::read(path).expect("a file that can be read");
                whole(&bytes, true);
                whole_dance(&bytes);
            }
        }
    }
}

impl fmt::Display for Case {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Random(seed) => write!(f, "{seed}"),
            Self::File(path) => write!(f, "{}", path.display()),
        }
    }
}

fn cases() -> Vec<Case> {
    let mut words = std::env::args().skip(1);
    let mut number = |otherwise| words.next().map_or(otherwise, |word| word.parse().expect("a number"));
    let (count, seed): (u64, u64) = (number(1000), number(0));
    let mut cases: Vec<Case> = (seed..seed + count).map(Case::Random).collect();
    for folder in words {
        let entries = std::fs::read_dir(folder).expect("a folder").flatten();
        cases.extend(entries.map(|entry| Case::File(entry.path())));
    }
    cases
}

fn main() {
    if !cfg!(debug_assertions) {
        panic!("this needs CARGO_PROFILE_RELEASE_DEBUG_ASSERTIONS=true");
    }
    let cases = cases();
    let mut slowest = (0.0, String::new());
    let mut failed = 0;
    for case in &cases {
        let began = Instant::now();
        let done = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| case.run()));
        let secs = began.elapsed().as_secs_f64();
        if done.is_err() || secs > MOST_SECS {
            println!("case {case} failed after {secs:.1} s");
            failed += 1;
        }
        if secs > slowest.0 {
            slowest = (secs, case.to_string());
        }
    }
    println!("{} cases, {failed} failed; the slowest, {}, took {:.1} s", cases.len(), slowest.1, slowest.0);
    std::process::exit(i32::from(failed > 0));
}
