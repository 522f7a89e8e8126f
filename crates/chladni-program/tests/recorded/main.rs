//! The recorded output of a list of commands, kept beside this file: a restructuring must change none of it, and a
//! change of behavior shows here and is recorded anew with
//! `CHLADNI_RECORD=1 cargo test --release --test recorded`.
//!
//! Numbers are compared to a tolerance, since processors round differently.

#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

#[path = "../archive/mod.rs"]
mod archive;
mod commands;
mod summary;
mod threads;

use std::path::{Path, PathBuf};
use std::process::Command;

use commands::{COMMANDS, Recorded};
use summary::{Summary, recorded_names};

/// The folder with one file for each command.
fn records() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/recorded/outputs")
}

/// Runs the steps of one entry in a folder of its own and sums up what it printed and wrote.
fn run(entry: &Recorded, cache: &Path) -> Summary {
    let folder = tempfile::tempdir().unwrap();
    let mut summary = Summary::default();
    for (step, line) in entry.steps.iter().enumerate() {
        let output = Command::new(env!("CARGO_BIN_EXE_chladni"))
            .args(line.split_whitespace())
            .arg("--quiet")
            .current_dir(folder.path())
            .env("CHLADNI_CACHE", cache)
            .output()
            .unwrap();
        summary.number(&format!("step {step}: exit code"), f64::from(output.status.code().unwrap_or(-1)));
        summary.printed(&format!("step {step}: stdout"), &String::from_utf8_lossy(&output.stdout));
        summary.printed(&format!("step {step}: stderr"), &String::from_utf8_lossy(&output.stderr));
    }
    summary.files(folder.path());
    summary
}

#[test]
fn commands_give_what_was_recorded() {
    let cache = tempfile::tempdir().unwrap();
    let mut differing = Vec::new();
    for entry in COMMANDS {
        differing.extend(run(entry, cache.path()).differs_from_record(&records(), entry.name));
    }
    assert!(differing.is_empty(), "{} differences:\n{}", differing.len(), differing.join("\n"));
}

#[test]
fn small_numbers_are_compared_and_rounding_errors_and_times_are_not() {
    let of = |text: &str| {
        let mut summary = Summary::default();
        summary.printed("it", text);
        summary
    };
    let differ = |before: &str, now: &str| !of(before).differences(&of(now)).is_empty();
    assert!(differ("[0, 0, 0.001]", "[0, 0, 0.00101]"));
    assert!(differ("[0, 0.001, 0]", "[0, 0, 0.001]"));
    assert!(!differ("[0, 1e-17, 0.001]", "[0, -3e-17, 0.001]"));
    assert!(!differ("[1e-17, 0]", "[3e-17, 0]"));
    assert!(differ("an error of 0.002", "an error of 0.003"));
    assert!(!differ("8 frames in 0.43 s; residual 1e-11", "8 frames in 0.3 s; residual 2e-11"));
    assert!(differ("8 frames in 0.43 s", "9 frames in 0.43 s"));
    let missing = |name: &str, why: &str| format!("chladni: {name}: {why} (os error 2)");
    assert!(!differ(&missing("a.obj", "No such file"), &missing("a.obj", "The file is not there.")));
    assert!(differ(&missing("a.obj", "No such file"), &missing("b.obj", "No such file")));
}

#[test]
fn every_record_belongs_to_a_command() {
    for name in recorded_names(&records()) {
        assert!(COMMANDS.iter().any(|entry| entry.name == name), "{name} is recorded, but no command");
    }
}
