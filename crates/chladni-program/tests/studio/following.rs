//! Frames that do not wait for the shape that their edits make.

use std::time::Duration;

use chladni_mesh::save_mesh;
use chladni_program::studio::Opening;
use egui::Key;

use crate::CTRL;
use crate::driving::person::{Desk, Person, finer_lump};

/// Pixels of the stage.
fn stage(person: &mut Person) -> Vec<[u8; 4]> {
    person.0.run_steps(1);
    let picture = person.0.render().expect("the window can be drawn");
    let pixels =
        picture.enumerate_pixels().filter(|(x, y, _)| (400..900).contains(x) && (100..600).contains(y));
    pixels.map(|(_, _, pixel)| pixel.0).collect()
}

/// A window on a lump with two layers, whose frames wait this long.
fn sit_down(desk: &Desk, patience: Duration) -> Person {
    save_mesh(&finer_lump(), &desk.path("finer.obj")).unwrap();
    let mut person = Person::new(Opening { patience, ..desk.opening(&["finer.obj"]) });
    person.wait_to_see("Layers");
    person.add_layer("magnify");
    person.add_layer("own-detail");
    person
}

/// One edit after the other: layers come, change, move and go while earlier ones are still evaluated.
fn edit(person: &mut Person) {
    for _ in 0..6 {
        person.press(Key::Comma);
        person.press(Key::M);
    }
    person.press_with(CTRL, Key::D);
    person.press(Key::Comma);
    person.press(Key::Delete);
    person.press(Key::PageDown);
    person.press(Key::H);
    person.press_with(CTRL, Key::Z);
    person.press(Key::Comma);
}

fn exported(person: &mut Person, desk: &Desk) -> Vec<u8> {
    desk.answers.add(desk.path("out.glb"));
    person.press_with(CTRL, Key::E);
    person.click("export-begin");
    person.wait_to_see("Exported");
    std::fs::read(desk.path("out.glb")).unwrap()
}

#[test]
fn a_window_that_waits_for_nothing_ends_with_the_same_picture_and_writes_the_same_file() {
    let desks = [Desk::new(), Desk::new()];
    let mut patient = sit_down(&desks[0], Duration::MAX);
    let mut hasty = sit_down(&desks[1], Duration::ZERO);
    let before = stage(&mut patient);
    edit(&mut patient);
    edit(&mut hasty);
    let newest = stage(&mut patient);
    assert!(before != newest, "the edits can be seen");
    let start = std::time::Instant::now();
    while stage(&mut hasty) != newest {
        assert!(start.elapsed() < chladni_testdata::HANGS, "the newest picture never came");
    }
    // Written right after an edit: not the shape on screen.
    for person in [&mut patient, &mut hasty] {
        person.press(Key::Comma);
    }
    assert!(exported(&mut patient, &desks[0]) == exported(&mut hasty, &desks[1]));
}

/// The three models are asked for and chosen before they are there.
#[test]
fn models_that_are_not_there_yet_are_not_shown_at_rest() {
    let desks = [Desk::new(), Desk::new()];
    let mut patient = sit_down(&desks[0], Duration::MAX);
    let mut hasty = sit_down(&desks[1], Duration::ZERO);
    for person in [&mut patient, &mut hasty] {
        person.press(Key::V);
        person.press(Key::Comma);
        person.press(Key::PageDown);
    }
    let newest = stage(&mut patient);
    let start = std::time::Instant::now();
    while stage(&mut hasty) != newest {
        assert!(start.elapsed() < chladni_testdata::HANGS, "the models never came");
    }
}
