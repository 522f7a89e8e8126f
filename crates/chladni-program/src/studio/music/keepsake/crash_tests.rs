//! A process that keeps copies of a show is killed: the last one that was said to be kept is there, whole.
//!
//! A campaign: `CHLADNI_CASES=10000 cargo test --release -p chladni-program --lib keepsake::crash_tests -- --nocapture`
//! (docs/trust.md).

use std::io::{BufRead, BufReader, Write};
use std::process::Stdio;

use chladni_music::{Action, LoggedAction, Moment};
use chladni_task::{Needs, other_program};
use chladni_testdata::{CHILDS_FOLDER, childs_folder, ignored_test};

use super::*;

const KEPT: &str = "kept ";

/// The show as it is after so many turns; longer after some than after others.
fn show(turn: u64) -> Show {
    let mut show = Show::from_text(&format!("format_version = 1\nseed = {turn}\nsize = 6\n")).unwrap();
    let logged = LoggedAction { moment: Moment::default(), action: Action::Breed };
    show.actions = vec![logged; turn as usize * 7 % 500];
    show
}

/// The child of the test below.
#[test]
#[ignore = "run by a_kill_leaves_the_last_copy_or_a_newer_one"]
fn keeps_copies_until_killed() {
    let Some(folder) = childs_folder() else { return };
    let mut keepsake = Keepsake::default();
    for turn in 1.. {
        assert_eq!(keepsake.write(show(turn), Kept::default(), &folder, in_background), None);
        assert_eq!(keepsake.settle(true), None);
        // Past the test's own capture.
        writeln!(std::io::stdout(), "\n{KEPT}{turn}").unwrap();
    }
}

#[test]
fn a_kill_leaves_the_last_copy_or_a_newer_one() {
    let rounds = chladni_testdata::setting("CHLADNI_CASES", 20);
    let mut chance = chladni_testdata::chance(11);
    let mut turns = 0;
    for round in 0..rounds {
        let folder = tempfile::tempdir().unwrap();
        let words = ignored_test("keeps_copies_until_killed");
        let mut child = other_program(&words[0], Needs::Files)
            .args(&words[1..])
            .env(CHILDS_FOLDER, folder.path())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let mut lines = BufReader::new(child.stdout.take().unwrap()).lines().map_while(Result::ok);
        let number = |line: &String| line.strip_prefix(KEPT).and_then(|turn| turn.parse::<u64>().ok());
        let first = lines.by_ref().find_map(|line| number(&line)).expect("it begins");
        std::thread::sleep(Duration::from_micros((chance() >> 33) % 60_000));
        child.kill().unwrap();
        child.wait().unwrap();
        // The last line may be cut off, and its number with it.
        let said = lines.filter_map(|line| number(&line)).fold(first, u64::max);
        let copy = tests::left(folder.path());
        let found = std::fs::read_to_string(copy).unwrap();
        let is_whole = (said..=said + 1).any(|turn| show(turn).to_text().unwrap() == found);
        assert!(is_whole, "round {round}: turn {said} was kept, and there is\n{found}");
        turns += said;
    }
    println!("{rounds} kills, {turns} copies");
}
