//! The floors of the program: what may name what.

#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

use std::path::{Path, PathBuf};

/// All source files below a folder of `src`.
fn files(folder: &str) -> Vec<PathBuf> {
    files_below(Path::new(env!("CARGO_MANIFEST_DIR")).join("src").join(folder))
}

fn files_below(folder: PathBuf) -> Vec<PathBuf> {
    let mut folders = vec![folder];
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
    let tools = [
        "egui::",
        "egui as",
        "egui_winit",
        "egui_wgpu",
        "eframe",
        "rfd::",
        "clap",
        "indicatif",
        "println!",
        "eprintln!",
    ];
    never_names("work", &[&above[..], &tools].concat());
}

#[test]
fn every_file_is_saved_by_the_one_function_that_faults_are_tried_on() {
    // A lock, which holds nothing; the sound and the note of a film that is being made, what ranks read, and how a test's own sound
    // server is set up, in folders of their own.
    let others = [
        "chladni-caricature/src/recovery.rs",
        "chladni-view/src/film/cut_off.rs",
        "chladni-view/src/film/live.rs",
        "chladni-harmonics/src/ranks/mod.rs",
        "chladni-testdata/src/sound_server.rs",
    ];
    let words = [
        "fs::write(",
        "File::create(",
        "File::create_new(",
        "OpenOptions",
        "File::options()",
        "fs::rename(",
        "create_dir",
    ];
    only_the_task_crate_names(&words, &others);
}

#[test]
fn every_program_is_started_by_the_one_function_that_gives_it_its_environment() {
    // Only tests run it.
    let others = ["chladni-testdata/src/sound_server.rs", "chladni-testdata/src/lib.rs"];
    only_the_task_crate_names(&["Command::new("], &others);
}

/// Fails where what is shipped of a crate above `chladni-task` holds one of `words`, except in the files `others`.
fn only_the_task_crate_names(words: &[&str], others: &[&str]) {
    let crates = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    for path in files_below(crates.to_owned()) {
        let is_source = path.extension().is_some_and(|ending| ending == "rs");
        let folders = path.strip_prefix(crates).unwrap().to_string_lossy().replace('\\', "/");
        let is_ours = folders.starts_with("chladni-task/") || others.contains(&folders.as_str());
        if !is_source || is_ours || !folders.contains("/src/") || folders.ends_with("tests.rs") {
            continue;
        }
        let text = std::fs::read_to_string(&path).unwrap();
        let shipped = text.split("\nmod tests {").next().unwrap();
        for word in words {
            assert!(!shipped.contains(word), "{folders}: {word}");
        }
    }
}

#[test]
fn commands_and_window_meet_at_one_door() {
    never_names("cli", &["crate::studio", "egui", "eframe"]);
    never_names("studio", &["crate::cli", "crate::window", "clap"]);
}

#[test]
fn every_checkbox_is_the_one_whose_empty_box_is_seen() {
    for path in files("studio").into_iter().filter(|path| !path.ends_with("theme.rs")) {
        let text = std::fs::read_to_string(&path).unwrap();
        assert!(!text.contains("ui.checkbox("), "{}", path.display());
    }
}

#[test]
fn unsafe_code_stands_only_in_the_files_that_the_rules_list() {
    let crates = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    let mut unsafe_files = Vec::new();
    for path in files_below(crates.to_owned()) {
        let file = path.strip_prefix(crates).unwrap().to_string_lossy().replace('\\', "/");
        let is_shipped = file.contains("/src/") && file.ends_with(".rs");
        if is_shipped && std::fs::read_to_string(&path).unwrap().contains("unsafe_code") {
            unsafe_files.push(file);
        }
    }
    unsafe_files.sort();
    let rules = std::fs::read_to_string(crates.join("../CONTRIBUTING.md")).unwrap();
    let is_file = |word: &&str| word.starts_with("chladni-") && word.ends_with(".rs");
    let mut listed: Vec<&str> = rules.split('`').filter(is_file).collect();
    listed.sort_unstable();
    assert_eq!(unsafe_files, listed);
}
