//! Matches, exaggerates and lets dance small meshes at random, as fast as a release build is: what estimates how a shape stands is some
//! hundred times slower under AddressSanitizer.
//!
//! `cargo run --release --manifest-path fuzz/Cargo.toml --bin shapes -- CASES SEED`. A failure names its case, which runs
//! alone with `1 CASE`.

use std::time::Instant;

use chladni_fuzz::{Dance, Pair, Random, dance, pair};

fn main() {
    let mut numbers = std::env::args().skip(1).map(|word| word.parse::<u64>().expect("a number"));
    let (cases, seed) = (numbers.next().unwrap_or(1000), numbers.next().unwrap_or(0));
    let mut slowest = (0.0, seed);
    let mut failed = 0;
    for case in seed..seed + cases {
        let began = Instant::now();
        let random = &mut Random::new(case);
        let done = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| {
            if case % 2 == 0 { pair(Pair::random(random)) } else { dance(Dance::random(random)) }
        }));
        if done.is_err() {
            println!("case {case} failed");
            failed += 1;
        }
        let secs = began.elapsed().as_secs_f64();
        if secs > slowest.0 {
            slowest = (secs, case);
        }
    }
    println!("{cases} cases, {failed} failed; the slowest, {}, took {:.1} s", slowest.1, slowest.0);
    std::process::exit(i32::from(failed > 0));
}
