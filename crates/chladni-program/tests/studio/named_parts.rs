//! The parts of a head, taken by their names.

use chladni_caricature::{HEAD_PARTS, Painted, Project};
use chladni_mesh::samples::{head_parts, sample};
use chladni_mesh::save_mesh;
use egui::{Key, Modifiers};
use egui_kittest::kittest::NodeT;

use crate::CTRL;
use crate::driving;
use crate::driving::person::{Desk, Person};

fn at_a_layer_of(desk: &Desk, file: &str) -> Person {
    let mut person = desk.sit_down(&[file]);
    person.wait_to_see("Layers");
    person.add_layer("magnify");
    person.click("head-parts");
    person
}

/// χ01 of the only layer as it is saved now.
fn painted(desk: &Desk, person: &mut Person) -> Vec<f32> {
    desk.answers.add(desk.path("saved.chladni"));
    person.press_with(CTRL | Modifiers::SHIFT, Key::S);
    let project = Project::load(&desk.path("saved.chladni")).unwrap();
    match &project.layers()[0].1.region.painted {
        Painted::Vertices(values) => values.to_vec(),
        other => panic!("{other:?}"),
    }
}

#[test]
fn parts_of_a_head_are_taken_by_name_added_with_shift_and_taken_away_with_ctrl() {
    let desk = Desk::new();
    let head = sample("head").unwrap();
    save_mesh(&head, &desk.path("scan.obj")).unwrap();
    let mut person = at_a_layer_of(&desk, "scan.obj");
    person.wait("the names", |window| driving::is_there(window, "part/nose"));
    // How sure it is, in percent.
    let label = driving::control(&person.0, "part/nose").accesskit_node().label().unwrap();
    let percent: f64 =
        label.strip_prefix("Nose ").and_then(|l| l.strip_suffix(" %")).unwrap().parse().unwrap();
    assert!((50.0..=100.0).contains(&percent), "{label}");
    person.screenshot("studio-head-parts.png");

    // What the head was modeled of, and what is painted: intersection over union.
    let known = head_parts("head", &head.positions).unwrap();
    let number = |name: &str| HEAD_PARTS.iter().position(|part| *part == name).unwrap() as u8;
    let overlap = |values: &[f32], names: &[&str]| {
        let belongs = |part: &u8| names.iter().any(|name| number(name) == *part);
        let pairs = || values.iter().zip(&known).map(|(x, part)| (*x == 1.0, belongs(part)));
        let both = pairs().filter(|(a, b)| *a && *b).count() as f64;
        both / pairs().filter(|(a, b)| *a || *b).count() as f64
    };
    person.click("part/nose");
    let nose = painted(&desk, &mut person);
    assert!(overlap(&nose, &["nose"]) > 0.7, "{}", overlap(&nose, &["nose"]));
    let click_with = |person: &mut Person, id: &str, modifiers: Modifiers| {
        driving::control(&person.0, id).click_modifiers(modifiers);
        person.0.run_steps(3);
    };
    click_with(&mut person, "part/ears", Modifiers::SHIFT);
    let both = painted(&desk, &mut person);
    assert!(overlap(&both, &["nose", "ears"]) > 0.7);
    assert!(both.iter().zip(&nose).all(|(both, nose)| both >= nose));
    click_with(&mut person, "part/nose", Modifiers::CTRL);
    let ears = painted(&desk, &mut person);
    assert!(overlap(&ears, &["ears"]) > 0.7 && overlap(&ears, &["nose"]) < 0.05);
    person.press_with(CTRL, Key::Z);
    assert_eq!(painted(&desk, &mut person), both, "one click is one step");
    person.press_with(CTRL, Key::Y);
    assert_eq!(painted(&desk, &mut person), ears, "Ctrl+Y does it again");
}

#[test]
fn of_what_is_no_head_a_plain_sentence_says_so() {
    let desk = Desk::new();
    let mut person = at_a_layer_of(&desk, "shape.obj");
    person.wait_to_see("does not look like a head");
    assert!(!driving::is_there(&person.0, "part/nose"));
    person.screenshot("studio-no-head.png");
    // The search is not one of the shape that is opened next.
    save_mesh(&sample("head").unwrap(), &desk.path("scan.obj")).unwrap();
    desk.answers.add(desk.path("scan.obj"));
    person.press_with(CTRL, Key::O);
    person.click("lose-changes");
    person.wait_until_gone("does not look like a head");
}

/// The sample that opens by itself was modeled of its parts: there is nothing to be matched.
#[test]
fn the_parts_of_a_sample_head_are_there_at_once() {
    let desk = Desk::new();
    let mut person = desk.sit_down(&[]);
    person.click("room/0");
    person.wait_to_see("Covered");
    person.click("head-parts");
    assert!(driving::is_there(&person.0, "part/chin") && !person.sees("Looking for a head"));
}
