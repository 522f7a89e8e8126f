//! Numbers that are typed.

use chladni_caricature::Project;
use egui::accesskit::Role;
use egui::{Event, Key};
use egui_kittest::kittest::{NodeT, Queryable};

use crate::CTRL;
use crate::driving;
use crate::driving::person::{Desk, Person};

/// The μ of the chosen layer, as its number says.
fn mu(person: &Person) -> Option<f64> {
    person.0.get_by_role_and_label(Role::SpinButton, "μ").accesskit_node().numeric_value()
}

/// Types `text` letter by letter in place of that μ, and stays in its field.
fn type_mu(person: &mut Person, text: &str) {
    person.0.get_by_role_and_label(Role::SpinButton, "μ").click();
    person.0.run_steps(2);
    person.press_with(CTRL, Key::A);
    type_on(person, text);
}

/// Types `text` letter by letter where the focus is.
fn type_on(person: &mut Person, text: &str) {
    for letter in text.chars() {
        person.0.event(Event::Text(letter.into()));
        person.0.run_steps(2);
    }
}

#[test]
fn a_number_counts_while_it_is_typed_and_what_is_none_keeps_the_last_one() {
    let desk = Desk::new();
    let mut person = desk.with_layers(&["ellipsoid"]);
    person.wait_to_see("Strength");
    for (typed, key, becomes) in [
        ("-0,8", Key::Enter, -0.8),
        ("-", Key::Tab, -0.8),
        ("-1x", Key::Enter, -1.0),
        ("-0.85", Key::Tab, -0.85),
        ("-0.9", Key::Escape, -0.9),
    ] {
        type_mu(&mut person, typed);
        assert_eq!(mu(&person), Some(becomes), "{typed}, in its field");
        person.press(key);
        person.0.run_steps(2);
        assert_eq!(mu(&person), Some(becomes), "{typed}, after it");
    }
    person.press_with(CTRL, Key::Z);
    person.0.run_steps(2);
    assert_eq!(mu(&person), Some(-0.85), "a number is one step");
}

#[test]
fn what_is_typed_is_saved_and_stays_with_its_layer() {
    let desk = Desk::new();
    let mut person = desk.with_layers(&["ellipsoid", "ellipsoid"]);
    person.wait_to_see("Strength");
    let saved = desk.path("kept.chladni");
    desk.answers.add(&saved);
    let save = |person: &mut Person| {
        person.press_with(CTRL, Key::S);
        Project::load(&saved).unwrap().layers().iter().map(|(_, layer)| layer.mu).collect::<Vec<f64>>()
    };
    type_mu(&mut person, "-0,7");
    let before = save(&mut person);
    assert_eq!(before.last(), Some(&-0.7));
    assert_ne!(before.first(), Some(&-0.7));
    // As a screen reader does, which leaves the focus where it is.
    driving::control(&person.0, "layer/1").click_accesskit();
    person.0.run_steps(3);
    type_on(&mut person, "5");
    person.press(Key::Enter);
    assert_eq!((mu(&person), save(&mut person)), (Some(before[0]), before));
}

#[test]
fn a_number_is_typed_with_its_unit() {
    let desk = Desk::new();
    let mut person = desk.sit_down(&["shape.obj"]);
    person.wait_to_see("Layers");
    person.press_with(CTRL, Key::E);
    person.click("export/gif");
    person.click_at(person.place_of("length").center());
    person.press_with(CTRL, Key::A);
    person.0.event(Event::Text("3,5 s".into()));
    person.0.run_steps(2);
    let length = driving::control(&person.0, "length");
    assert_eq!(length.accesskit_node().numeric_value(), Some(3.5));
}
