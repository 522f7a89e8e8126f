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
fn every_record_belongs_to_a_command() {
    for name in recorded_names(&records()) {
        assert!(COMMANDS.iter().any(|entry| entry.name == name), "{name} is recorded, but no command");
    }
}
