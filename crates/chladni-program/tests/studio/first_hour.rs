//! From a mesh file to a printed caricature and a turntable, as docs/tutorial-caricature.md walks it.

use std::path::Path;

use chladni_mesh::{samples, save_mesh};
use egui::{Key, Pos2, Rect};

use crate::CTRL;
use crate::driving;
use crate::driving::person::{Desk, Person};

#[test]
fn a_mesh_becomes_a_drawing_and_a_turntable_in_ink() {
    let desk = Desk::new();
    save_mesh(&samples::sample("head").unwrap(), &desk.path("head.obj")).unwrap();
    walk(&desk, &desk.path("head.obj"), "tutorial");
}

#[test]
fn so_does_a_scan() {
    let Some(scan) = chladni_testdata::shared("meshes/heads/decimated-max.obj") else { return };
    walk(&Desk::new(), &scan, "first-hour");
}

fn walk(desk: &Desk, mesh: &Path, pictures: &str) {
    let picture = |person: &mut Person, name: &str| person.screenshot(&format!("{pictures}-{name}.png"));
    let mut opening = desk.opening(&[]);
    opening.files = vec![mesh.to_owned()];
    let mut person = Person::new(opening);
    person.wait_to_see("Compare with a mesh");
    picture(&mut person, "opened");
    person.add_layer("head");
    person.wait_to_see("Covered");
    for _ in 0..5 {
        person.press(Key::Comma);
    }
    picture(&mut person, "exaggerated");

    // The middle of the face alone, by a line around it.
    person.press(Key::B);
    person.click("lasso");
    let stage = Rect::from_min_max(Pos2::new(270.0, 60.0), Pos2::new(940.0, 780.0));
    let around = |i: usize| {
        let angle = i as f32 * std::f32::consts::TAU / 30.0;
        // The nose of a head in a three-quarter view.
        let middle = stage.lerp_inside(egui::vec2(0.34, 0.57));
        middle + egui::vec2(0.11 * stage.width(), 0.17 * stage.height()) * egui::Vec2::angled(angle)
    };
    person.drag(&(0..30).map(around).collect::<Vec<_>>());
    assert!(person.sees("Softness"), "a region");
    // Under a resting brush pictures are drawn for speed.
    person.0.hover_at(Pos2::new(600.0, 10.0));
    person.0.run_steps(4);
    picture(&mut person, "lasso");
    person.press(Key::Escape);
    person.press(Key::Period);

    desk.answers.add(desk.path("me.chladni"));
    person.press_with(CTRL, Key::S);
    person.wait_to_see("Saved");
    person.press(Key::P);
    person.click("look");
    person.click("flat-tones");
    person.press(Key::Escape);
    if driving::takes_pictures() {
        person.wait("the drawing", |window| !driving::is_busy(window));
    }
    picture(&mut person, "ink");
    for (what, name) in [("export/svg", "me.svg"), ("export/gif", "me.gif"), ("export/glb", "me.glb")] {
        person.press_with(CTRL, Key::E);
        person.click(what);
        if what == "export/svg" {
            picture(&mut person, "export");
        }
        if what == "export/gif" {
            // The shortest turn in small pictures.
            person.click("sizes");
            person.click("size/640x480");
            for (field, value) in [("length", "0.5"), ("fps", "4")] {
                type_into(&mut person, field, value);
            }
        }
        desk.answers.add(desk.path(name));
        person.click("export-begin");
        person.wait_to_see(&format!("Exported {}", desk.path(name).display()));
    }
    let svg = std::fs::read_to_string(desk.path("me.svg")).unwrap();
    assert!(svg.contains("<g id=\"tones\"") && svg.matches("<path ").count() > 12);
    assert!(std::fs::read(desk.path("me.gif")).unwrap().starts_with(b"GIF89a"));
    assert!(desk.path("me.glb").is_file() && desk.path("me.chladni").is_file());
}

/// Writes a number into a field that is dragged or typed into.
fn type_into(person: &mut Person, field: &str, value: &str) {
    person.click_at(person.place_of(field).center());
    person.press_with(CTRL, Key::A);
    person.0.event(egui::Event::Text(value.to_owned()));
    person.0.run_steps(1);
    person.press(Key::Enter);
}
