//! A driver that restarts takes the window's device with it.

use std::path::PathBuf;

use chladni_program::studio::{Handover, Opening};
use eframe::wgpu;
use egui::{Key, Modifiers};

use crate::CTRL;
use crate::driving;
use crate::driving::person::{Desk, Person};

/// Pixels of the middle of the window.
fn middle(person: &mut Person) -> Vec<[u8; 4]> {
    person.0.run_steps(2);
    let picture = person.0.render().expect("the window can be drawn");
    let pixels =
        picture.enumerate_pixels().filter(|(x, y, _)| (400..900).contains(x) && (100..600).contains(y));
    pixels.map(|(_, _, pixel)| pixel.0).collect()
}

#[test]
fn another_window_goes_on_with_all_that_was_open() {
    let desk = Desk::new();
    let handover = Handover::default();
    // A busy machine may take longer for a few frames than a note lasts.
    let now = driving::no_time;
    let opening = |files: &[&str]| Opening { handover: handover.clone(), now, ..desk.opening(files) };
    let size = [1280.0, 800.0];
    let Some((window, device)) = driving::open_with_device(opening(&["shape.obj", "template.obj"]), size)
    else {
        return;
    };
    let mut person = Person(window);
    person.wait_to_see("Covered");
    person.press_with(CTRL, Key::D);
    assert!(person.sees("copy"));
    person.wait("a rest", |window| !driving::shows(window, "Matching"));
    person.0.run_steps(20);
    let before = middle(&mut person);
    assert!(handover.reason().is_none());

    driving::lose(&device);
    person.0.run_steps(3);
    assert!(handover.reason().is_some(), "it makes room for another window");
    drop(person);

    let mut person = Person(driving::open_with_device(opening(&[]), size).expect("a device").0);
    assert!(handover.reason().is_none());
    person.wait_to_see("The graphics device was lost");
    person.0.run_steps(20);
    person.screenshot("lost-device.png");
    let after = middle(&mut person);
    let differ =
        before.iter().zip(&after).filter(|(a, b)| a.iter().zip(*b).any(|(a, b)| a.abs_diff(*b) > 12));
    let share = differ.count() as f64 / before.len() as f64;
    assert!(share < 0.01, "{:.1} % of the picture differ", 100.0 * share);
    // The history came along, too.
    assert!(person.sees("copy"));
    person.press_with(CTRL, Key::Z);
    assert!(!person.sees("copy"));
}

#[test]
fn where_memory_is_full_the_work_goes_on_elsewhere_and_in_the_end_on_the_processor() {
    let desk = Desk::new();
    let handover = Handover::default();
    let now = driving::no_time;
    let opening = |files: &[&str]| Opening { handover: handover.clone(), now, ..desk.opening(files) };
    let size = [1280.0, 800.0];
    let Some((window, device)) = driving::open_with_device(opening(&["shape.obj", "template.obj"]), size)
    else {
        return;
    };
    let mut person = Person(window);
    person.wait_to_see("Covered");
    person.press_with(CTRL, Key::D);
    assert!(person.sees("copy"));
    let leave = |mut person: Person, device: wgpu::Device| {
        driving::exhaust(&device);
        person.0.run_steps(3);
        assert_eq!(handover.reason().as_deref(), Some("its memory is full"));
    };
    let goes_on = |person: &mut Person| {
        assert!(handover.reason().is_none());
        person.wait_to_see("The graphics device was lost (its memory is full)");
        assert!(person.sees("copy"));
    };
    leave(person, device);
    let (window, device) = driving::open_with_device(opening(&[]), size).expect("a device");
    person = Person(window);
    goes_on(&mut person);
    leave(person, device);
    person = Person(driving::open(opening(&[]), size));
    goes_on(&mut person);
    // The picture and the history came along.
    person.wait("a picture", |window| !driving::shows(window, "Matching"));
    person.0.run_steps(20);
    let colors: std::collections::BTreeSet<[u8; 4]> = middle(&mut person).into_iter().collect();
    assert!(colors.len() > 20, "{} colors", colors.len());
    person.press_with(CTRL, Key::Z);
    assert!(!person.sees("copy"));
}

/// A hand at work, whose device is of no use again and again.
struct Hand {
    person: Person,
    handover: Handover,
    project: PathBuf,
    /// The project when it was saved last.
    saved: Vec<u8>,
}

impl Hand {
    /// Saves; false where the window has to close before that.
    fn save(&mut self) -> bool {
        self.person.press_with(CTRL, Key::S);
        if self.handover.reason().is_some() {
            return false;
        }
        self.saved = std::fs::read(&self.project).unwrap();
        true
    }

    /// Changes the project until the device is gone, and tells by which key what was changed last can be taken back.
    fn work(&mut self, chance: &mut impl FnMut() -> u64) -> Modifiers {
        let (undo, redo) = (CTRL, CTRL | Modifiers::SHIFT);
        loop {
            let back = match (chance() >> 33) % 3 {
                0 => {
                    self.person.press_with(undo, Key::Z);
                    redo
                }
                1 => {
                    self.person.press_with(redo, Key::Z);
                    undo
                }
                _ => {
                    // So that the list stays short.
                    if self.person.sees("copy 4") {
                        self.person.press(Key::Delete);
                    } else {
                        self.person.press_with(CTRL, Key::D);
                    }
                    undo
                }
            };
            if self.handover.reason().is_some() || !self.save() {
                return back;
            }
        }
    }
}

/// A campaign: `CHLADNI_CASES=1000 cargo test --release -p chladni-program --test studio any_moment` (docs/trust.md). The device
/// runs out of memory but goes on: wgpu 30 can come to a standstill where a destroyed one is waited for and written to
/// by two threads, as those that draw thumbnails do here.
#[test]
fn nothing_is_lost_where_memory_is_full_at_any_moment() {
    let cases = chladni_testdata::setting("CHLADNI_CASES", 6);
    let desk = Desk::new();
    let handover = Handover::default();
    let opening = |files: &[&str]| Opening { handover: handover.clone(), ..desk.opening(files) };
    let size = [1280.0, 800.0];
    let Some((window, mut device)) = driving::open_with_device(opening(&["shape.obj", "template.obj"]), size)
    else {
        return;
    };
    let mut hand = Hand {
        person: Person(window),
        handover: handover.clone(),
        project: desk.path("work.chladni"),
        saved: Vec::new(),
    };
    hand.person.wait_to_see("Covered");
    desk.answers.add(&hand.project);
    assert!(hand.save());
    let mut chance = chladni_testdata::chance(2012);
    for case in 0..cases {
        let full = device.clone();
        let driver = driving::meanwhile(&mut chance, move || driving::exhaust(&full));
        let back = hand.work(&mut chance);
        driver.join().unwrap();
        let before = std::mem::take(&mut hand.saved);
        let (window, another) = driving::open_with_device(opening(&[]), size).expect("a device");
        hand.person = Person(window);
        device = another;
        hand.person.0.run_steps(3);
        assert!(hand.save(), "case {case}: the new device is there");
        if hand.saved != before {
            // The last change was made, and is the last of the history.
            hand.person.press_with(back, Key::Z);
            assert!(hand.save());
            assert!(hand.saved == before, "case {case}: something else than the last change differs");
        }
    }
}
