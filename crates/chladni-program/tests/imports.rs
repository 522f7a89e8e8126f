//! The floors of the program: what may name what.

#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

use std::path::{Path, PathBuf};

/// All source files below a folder of `src`.
fn files(folder: &str) -> Vec<PathBuf> {
    let mut folders = vec![Path::new(env!("CARGO_MANIFEST_DIR")).join("src").join(folder)];
    let mut files = Vec::new();
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() { folders.push(path) } else { files.push(path) }
        }
    }
    assert!(files.len() > 10, "{files:?}");
    files
}

/// Fails where code of `folder` holds one of `words`.
fn never_names(folder: &str, words: &[&str]) {
    for path in files(folder) {
        let text = std::fs::read_to_string(&path).unwrap();
        for line in text.lines().filter(|line| !line.trim_start().starts_with("//")) {
            let named = words.iter().find(|word| line.contains(**word));
            assert_eq!(named, None, "{}: {line}", path.display());
        }
    }
}

#[test]
fn work_knows_neither_a_window_nor_a_command_line() {
    let above = ["crate::cli", "crate::studio", "crate::window"];
    let tools = ["egui", "eframe", "rfd::", "clap", "indicatif", "println!", "eprintln!"];
    never_names("work", &[&above[..], &tools].concat());
}

#[test]
fn commands_and_window_meet_at_one_door() {
    never_names("cli", &["crate::studio", "egui", "eframe"]);
    never_names("studio", &["crate::cli", "crate::window", "clap"]);
}
