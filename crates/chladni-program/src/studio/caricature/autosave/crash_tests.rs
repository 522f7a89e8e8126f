//! Random edits in a process that is killed: the lost edits are no older than autosave allows.
//!
//! A campaign: `CHLADNI_CASES=10000 cargo test --release -p chladni-program --lib crash_tests -- --nocapture` (docs/trust.md).

use std::collections::VecDeque;
use std::io::{BufRead, BufReader, Write};
use std::process::Stdio;
use std::time::Duration;

use chladni_caricature::{Action, Layer, LayerId, Painted, Property, ShapeSource, Smoothing, Template};
use chladni_task::{Needs, other_program};
use chladni_testdata::{CHILDS_FOLDER, childs_folder, ignored_test};

use super::*;

/// The seed of what the child does.
const SEED: &str = "CHLADNI_TEST_SEED";
/// The program's own rules with a shorter time between two copies, so that many fit between two kills; its own 2 s are
/// `CHLADNI_PERIOD_MS=2000`.
fn period_secs() -> f64 {
    chladni_testdata::setting(PERIOD, 30) as f64 / 1e3
}
const PERIOD: &str = "CHLADNI_PERIOD_MS";

/// A random editor: the same seed makes the same edits.
struct Editor {
    history: History,
    chance: Box<dyn FnMut() -> u64>,
    /// Turns that were taken. The first layer's name says the number.
    turns: usize,
}

fn below(chance: &mut dyn FnMut() -> u64, most: usize) -> usize {
    (chance() >> 33) as usize % most.max(1)
}

impl Editor {
    fn new(seed: u64) -> Self {
        let history = History::new(Project::new(ShapeSource::Sample("head".into()), 8));
        Self { history, chance: Box::new(chladni_testdata::chance(seed)), turns: 0 }
    }

    fn layer(&mut self) -> Box<Layer> {
        let mut layer = Layer::new("layer", Template::Ellipsoid);
        if below(&mut self.chance, 2) == 0 {
            let values = (0..2000).map(|_| below(&mut self.chance, 100) as f32 / 99.0).collect();
            layer.region.painted = Painted::Vertices(values);
        }
        Box::new(layer)
    }

    fn turn(&mut self) {
        self.turns += 1;
        let ids: Vec<LayerId> = self.history.project().layers().iter().map(|(id, _)| *id).collect();
        let index = below(&mut self.chance, ids.len());
        let value = below(&mut self.chance, 1000) as f64 / 500.0 - 1.0;
        let action = match (ids.get(index), below(&mut self.chance, 12)) {
            (None, _) => Some(Action::Add { index: 0, layer: self.layer() }),
            (_, 0 | 1) if ids.len() < 9 => Some(Action::Add { index, layer: self.layer() }),
            (Some(&layer), 2) if ids.len() < 9 => Some(Action::Duplicate(layer)),
            (Some(&layer), 0..3) => Some(Action::Remove(layer)),
            (Some(&layer), 3) => Some(Action::Move { layer, index: below(&mut self.chance, ids.len()) }),
            (Some(&layer), 4) => Some(Action::Set { layer, to: Property::Strength(value.abs()) }),
            (Some(&layer), 5) => Some(Action::Set { layer, to: Property::Enabled(value > 0.0) }),
            (Some(&layer), 6) => {
                let smoothing = Smoothing { clamp: value > 0.0, ..Smoothing::default() };
                Some(Action::Set { layer, to: Property::Smoothing(smoothing) })
            }
            (_, 7) => Some(Action::SetHarmonics(8 + below(&mut self.chance, 100))),
            (_, 8) => Some(Action::KeepTriangles(value > 0.0)),
            (_, 9) => self.history.undo().and(None),
            (_, 10) => self.history.redo().and(None),
            (Some(&layer), _) => Some(Action::Set { layer, to: Property::Mu(value) }),
        };
        if let Some(action) = action {
            self.history.apply(&action, None).unwrap();
        }
        if self.history.project().layers().is_empty() {
            let layer = self.layer();
            self.history.apply(&Action::Add { index: 0, layer }, None).unwrap();
        }
        let layer = self.history.project().layers()[0].0;
        let name = Property::Name(format!("turn {}", self.turns));
        self.history.apply(&Action::Set { layer, to: name }, None).unwrap();
    }
}

/// The child of the test below: edits, saves now and then, and lets autosave keep copies, until it is killed. It says what it has
/// done, with the time.
#[test]
#[ignore = "run by what_is_missing_after_a_kill_is_no_older_than_a_copy_and_a_save"]
fn edits_until_killed() {
    let Some(folder) = childs_folder() else { return };
    let seed = std::env::var(SEED).unwrap().parse().unwrap();
    let (mut editor, mut pauses) = (Editor::new(seed), chladni_testdata::chance(seed + 1));
    let mut autosave = Autosave::every([period_secs(); 2], &folder.join("state")).unwrap();
    let began = Instant::now();
    // The turns of the copies, by the numbers of their orders.
    let mut ordered = Vec::new();
    // Past the test's own capture.
    let say = |what: &str, turn: usize| {
        writeln!(std::io::stdout(), "\n{what} {turn} {}", began.elapsed().as_secs_f64()).unwrap();
    };
    loop {
        editor.turn();
        say("did", editor.turns);
        for report in autosave.reports.try_iter() {
            say("kept", ordered[report.kept.unwrap()]);
        }
        let before = autosave.last_secs;
        assert_eq!(autosave.tick(&editor.history, None, began.elapsed().as_secs_f64()), None);
        if autosave.last_secs > before {
            ordered.push(editor.turns);
            say("ordered", editor.turns);
        }
        if below(&mut pauses, 40) == 0 {
            editor.history.project().save(&folder.join("p.chladni")).unwrap();
            editor.history.mark_saved();
            say("saved", editor.turns);
        }
        std::thread::sleep(Duration::from_micros(below(&mut pauses, 4000) as u64));
    }
}

/// The words of the child, by turns.
#[derive(Default)]
struct Said {
    did: Vec<f64>,
    /// The turns of copies that were ordered and may not be on the disk yet, and when.
    under_way: VecDeque<(usize, f64)>,
    /// The last turn that is on the disk for certain.
    on_disk: usize,
    last_secs: f64,
}

impl Said {
    fn hear(&mut self, line: &str) {
        let words: Vec<&str> = line.split(' ').collect();
        let &[what @ ("did" | "kept" | "ordered" | "saved"), turn, secs] = &words[..] else { return };
        // The last line may be cut off, and a number with it.
        let (Ok(turn), Ok(secs)) = (turn.parse::<usize>(), secs.parse::<f64>()) else { return };
        if secs < self.last_secs {
            return;
        }
        let before_secs = std::mem::replace(&mut self.last_secs, secs);
        match what {
            "did" => self.did.push(secs),
            // It was ordered before that was said, and after the word before.
            "ordered" => self.under_way.push_back((turn, before_secs)),
            _ => {
                self.on_disk = self.on_disk.max(turn);
                // A later copy took the place of those that were not written.
                while self.under_way.pop_front_if(|(ordered, _)| *ordered <= turn).is_some() {}
            }
        }
    }

    /// The age at which a turn may be missing: since the last order the time between two copies, the time between two looks of the
    /// window, and the time of a copy that is being written.
    fn allowed_secs(&self) -> f64 {
        let times = || std::iter::once(&0.0).chain(&self.did).chain([&self.last_secs]);
        let look = times().zip(times().skip(1)).map(|(one, next)| next - one).fold(0.0, f64::max);
        let writing = self.under_way.front().map_or(0.0, |(_, began)| self.last_secs - began);
        period_secs() + look + writing
    }
}

/// The newest turn that the files in `folder` have.
fn newest_in(folder: &Path, states: &[Project]) -> usize {
    let (found, unreadable) = Recovery::find(&folder.join("state"));
    assert!(unreadable.is_empty(), "{unreadable:?}");
    let saved = folder.join("p.chladni");
    let saved = saved.exists().then(|| Project::load(&saved).unwrap());
    // Ids of layers are given anew where a project is read; the text has all else.
    let text = |project: &Project| project.to_text(&folder.join("p.chladni"), None).unwrap();
    let turn_of = |project: &Project| {
        let name = &project.layers()[0].1.name;
        let turn = name.strip_prefix("turn ").and_then(|turn| turn.parse::<usize>().ok()).unwrap();
        assert_eq!(text(project), text(states.get(turn).expect("a turn that was taken")));
        turn
    };
    found.iter().map(|found| &found.project).chain(&saved).map(turn_of).max().unwrap_or(0)
}

#[test]
fn what_is_missing_after_a_kill_is_no_older_than_a_copy_and_a_save() {
    let rounds = chladni_testdata::setting("CHLADNI_CASES", 20);
    let mut chance = chladni_testdata::chance(7);
    let (mut turns, mut oldest_secs) = (0, 0.0_f64);
    for seed in 0..rounds {
        let folder = tempfile::tempdir().unwrap();
        let words = ignored_test("edits_until_killed");
        let mut child = other_program(&words[0], Needs::Files)
            .args(&words[1..])
            .env(CHILDS_FOLDER, folder.path())
            .env(SEED, seed.to_string())
            .env(PERIOD, format!("{:.0}", 1e3 * period_secs()))
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let mut lines = BufReader::new(child.stdout.take().unwrap()).lines().map_while(Result::ok);
        let mut said = Said::default();
        while said.did.is_empty() {
            said.hear(&lines.next().expect("it begins"));
        }
        std::thread::sleep(Duration::from_secs_f64(
            4.0 * period_secs() * below(&mut chance, 1000) as f64 / 1e3,
        ));
        child.kill().unwrap();
        child.wait().unwrap();
        lines.for_each(|line| said.hear(&line));

        let mut editor = Editor::new(seed);
        let mut states = vec![editor.history.project().clone()];
        // It may have been killed before it said its last turn.
        for _ in 0..=said.did.len() {
            editor.turn();
            states.push(editor.history.project().clone());
        }
        let newest = newest_in(folder.path(), &states);
        assert!(
            newest >= said.on_disk,
            "seed {seed}: turn {newest} is there, and {} was said to be",
            said.on_disk
        );
        let missing_secs = said.did.get(newest).map_or(0.0, |since| said.last_secs - since);
        let allowed = said.allowed_secs();
        assert!(missing_secs <= allowed, "seed {seed}: {missing_secs} s are missing, not {allowed}");
        (turns, oldest_secs) = (turns + said.did.len(), oldest_secs.max(missing_secs));
    }
    println!(
        "{rounds} kills, {turns} turns; the oldest one that was missing was {:.0} ms old",
        1e3 * oldest_secs
    );
}
