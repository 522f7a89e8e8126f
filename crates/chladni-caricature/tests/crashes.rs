//! A process that saves is killed at any moment: what it has saved is there.
//!
//! A campaign: `CHLADNI_CASES=10000 cargo test --release -p chladni-caricature --test crashes` (docs/trust.md).

#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, SystemTime};

use chladni_caricature::*;

/// The folder in which the child works.
const FOLDER: &str = "CHLADNI_TEST_SAVE_FOREVER";
/// Printed by the child once a project is saved; its number follows.
const SAVED: &str = "saved ";

/// The project of a number: every second one is large.
fn project(number: usize) -> Project {
    // Absolute, also where that takes a drive.
    let shape = std::path::absolute("/somewhere/shape.obj").unwrap();
    let mut project = Project::new(ShapeSource::File(shape), number);
    if number % 2 == 1 {
        let painted = (0..20_000).map(|i| (i % 97) as f32 / 96.0).collect();
        let region = Region { painted: Painted::Vertices(painted), smoothing: Smoothing::default() };
        project.push(Layer { region, ..Layer::new("painted", Template::Ellipsoid) }).unwrap();
    }
    project
}

/// The child of the test below: saves, and keeps a copy for recovery, until it is killed.
#[test]
fn saves_until_killed() {
    let Some(folder) = std::env::var_os(FOLDER) else { return };
    let folder = Path::new(&folder);
    let session = Recovery::start(&folder.join("state"), 7).unwrap();
    for number in 1.. {
        let project = project(number);
        project.save(&folder.join("p.chladni")).unwrap();
        session.keep(&project, None).unwrap();
        // Past the test's own capture.
        writeln!(std::io::stdout(), "\n{SAVED}{number}").unwrap();
    }
}

#[test]
fn what_was_saved_before_a_kill_is_there() {
    let rounds = chladni_testdata::setting("CHLADNI_CASES", 60);
    let program = std::env::current_exe().unwrap();
    for round in 0..rounds {
        let folder = tempfile::tempdir().unwrap();
        let mut child = Command::new(&program)
            .args(["--exact", "saves_until_killed", "--test-threads=1"])
            .env(FOLDER, folder.path())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let said = BufReader::new(child.stdout.take().unwrap()).lines();
        let mut numbers =
            said.map_while(Result::ok).filter_map(|line| line.strip_prefix(SAVED)?.parse().ok());
        let first: usize = numbers.next().unwrap();
        // Different moments of a save that takes about a millisecond.
        std::thread::sleep(Duration::from_micros(137 * (round % 60)));
        child.kill().unwrap();
        child.wait().unwrap();
        let last = numbers.last().unwrap_or(first);
        let is_there = |found: &Project| {
            let number = found.harmonics;
            assert!((last..=last + 1).contains(&number), "{number} after {last}");
            assert_eq!(found, &project(number));
        };
        is_there(&Project::load(&folder.path().join("p.chladni")).unwrap());
        let (found, unreadable) = Recovery::find(&folder.path().join("state"));
        assert!(unreadable.is_empty() && found.len() == 1, "{unreadable:?}");
        is_there(&found[0].project);
        #[cfg(unix)]
        leaves_nothing(folder.path());
    }
}

/// Two hours later somebody saves there: what was begun when the process was killed goes.
#[cfg(unix)]
fn leaves_nothing(folder: &Path) {
    let before = SystemTime::now() - Duration::from_secs(7200);
    let left = || {
        let names = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
        names
            .filter(|path| path.file_name().unwrap().to_string_lossy().starts_with(".chladni-"))
            .collect::<Vec<_>>()
    };
    for path in left() {
        std::fs::File::options().write(true).open(path).unwrap().set_modified(before).unwrap();
    }
    project(1).save(&folder.join("p.chladni")).unwrap();
    assert!(left().is_empty(), "{:?}", left());
}
