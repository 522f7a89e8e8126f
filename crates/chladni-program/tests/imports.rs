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
    let others = ["lib", "process", "sound_server"].map(|name| format!("chladni-testdata/src/{name}.rs"));
    only_the_task_crate_names(&["Command::new("], &others.each_ref().map(String::as_str));
}

#[test]
fn sockets_are_those_of_osc() {
    let osc = ["osc", "beat_out"].map(|name| format!("chladni-program/src/studio/music/remote/{name}.rs"));
    let words = [
        "UdpSocket",
        "TcpStream",
        "TcpListener",
        "UnixStream",
        "UnixListener",
        "UnixDatagram",
        "ToSocketAddrs",
    ];
    only_some_files_name(&words, |file| osc.iter().any(|osc| osc == file));
}

/// Fails where what is shipped of a crate above `chladni-task` holds one of `words`, except in the files `others`.
fn only_the_task_crate_names(words: &[&str], others: &[&str]) {
    only_some_files_name(words, |file| file.starts_with("chladni-task/") || others.contains(&file));
}

/// Fails where what is shipped of a crate holds one of `words`, except in files that may.
fn only_some_files_name(words: &[&str], may: impl Fn(&str) -> bool) {
    for (file, shipped, _) in sources().into_iter().filter(|(file, ..)| !may(file)) {
        for word in words {
            assert!(!shipped.contains(word), "{file}: {word}");
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

/// All Rust sources of the workspace: the name below `crates`, what is shipped of it, and its tests.
fn sources() -> Vec<(String, String, String)> {
    let crates = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    let mut sources = Vec::new();
    for path in files_below(crates.to_owned()) {
        if path.extension().is_some_and(|ending| ending == "rs") {
            let name = path.strip_prefix(crates).unwrap().to_string_lossy().replace('\\', "/");
            let text = std::fs::read_to_string(&path).unwrap();
            let is_test = name.contains("/tests/") || name.ends_with("tests.rs");
            let (shipped, tests) = match text.split_once("\nmod tests {") {
                _ if is_test => ("", &text[..]),
                _ if !name.contains("/src/") => continue,
                Some(parts) => parts,
                None => (&text[..], ""),
            };
            sources.push((name, shipped.to_owned(), tests.to_owned()));
        }
    }
    sources
}

#[test]
fn no_test_fails_or_gives_up_on_a_slow_machine() {
    // Bounds other than `HANGS`, and why a slow machine passes.
    let others = [
        // A manager of PipeWire that does not end is ended; nothing is expected of it.
        ("chladni-view/tests/camera.rs", "ending.elapsed() < Duration::from_secs(10)"),
        // A reader that came too early is followed by another, which is given twice the time.
        ("chladni-view/tests/camera.rs", "recv_timeout(wait)"),
        // It measures how busy the machine is.
        ("chladni-sound/tests/playing/main.rs", "recv_timeout(NAP)"),
        // It goes on until there were enough frames, however late they come.
        ("chladni-program/tests/music_window/main.rs", "start.elapsed().as_secs_f64() < secs ||"),
    ];
    let mut used = Vec::new();
    // The words are here, too.
    for (name, _, tests) in sources().into_iter().filter(|(name, ..)| !name.ends_with("tests/imports.rs")) {
        for line in tests.lines().filter(|line| is_timed(line) && !line.contains("HANGS")) {
            let other = others.iter().position(|(file, part)| *file == name && line.contains(part));
            assert!(other.is_some(), "{name}: {line}: use chladni_testdata::HANGS");
            used.extend(other);
        }
    }
    assert!((0..others.len()).all(|other| used.contains(&other)), "{used:?} of {others:?} are there");
}

/// Whether a line of a test compares a time that has gone by, or waits for a time.
fn is_timed(line: &str) -> bool {
    let is_compared = |after: &str| {
        let after = after.strip_prefix(".as_secs_f64()").unwrap_or(after);
        after.starts_with(" <") || after.starts_with(" >")
    };
    line.contains("recv_timeout(") || line.split("elapsed()").skip(1).any(is_compared)
}

#[test]
fn the_clock_on_the_wall_which_may_jump_decides_nothing_but_this() {
    let files = [
        // Which entries were used last.
        "chladni-harmonics/src/cache.rs",
        // Which of several copies is the newest, and whether a project was written after its copy.
        "chladni-caricature/src/recovery.rs",
        "chladni-program/src/studio/caricature/files.rs",
        "chladni-program/src/studio/music/keepsake.rs",
        // Whether a copy or a draft that cannot be locked may still be at work.
        "chladni-task/src/recovery.rs",
        "chladni-task/src/atomic_file/leftovers.rs",
        // When a file was used.
        "chladni-task/src/read_file.rs",
        // Whether a file has changed.
        "chladni-program/src/work/files.rs",
        "chladni-program/src/studio/caricature/session/files.rs",
        // Ages, as they are shown.
        "chladni-program/src/studio/age.rs",
        // When sound gave out, in a report for other programs, which know no instants.
        "chladni-program/src/studio/measure.rs",
        // Chance, which is another one every evening.
        "chladni-program/src/studio/music/concert/piloted.rs",
    ];
    let names_it =
        |text: &str| ["SystemTime", "UNIX_EPOCH", ".modified()"].iter().any(|word| text.contains(word));
    let mut named: Vec<String> = Vec::new();
    named.extend(sources().into_iter().filter(|(_, shipped, _)| names_it(shipped)).map(|(name, ..)| name));
    named.sort_unstable();
    let mut listed = files.map(str::to_owned);
    listed.sort_unstable();
    assert_eq!(named, listed, "measure what is done when by an Instant");
}
