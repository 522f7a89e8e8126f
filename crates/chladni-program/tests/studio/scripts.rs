//! What a person leaves behind who works at the window in a given way, compared with what was recorded beside the
//! commands' outputs: projects, meshes and pictures.

use std::path::{Path, PathBuf};

use chladni_caricature::Project;
use egui::{Key, Modifiers, Pos2, pos2, vec2};

use crate::CTRL;
use crate::driving::person::{Desk, Person};
use crate::summary::{Summary, recorded_names};

/// What a person does, by the name of the record.
type Script = (&'static str, fn(&mut Person, &Desk));

const SCRIPTS: [Script; 5] = [
    ("window-exaggerated", exaggerated),
    ("window-painted", painted),
    ("window-compared", compared),
    ("window-layered", layered),
    ("window-masked", masked),
];

/// Where the middle of the shape is seen.
const MIDDLE: Pos2 = pos2(620.0, 420.0);

/// The folder with one file for each script.
fn records() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/recorded/windows")
}

#[test]
fn scripts_leave_what_was_recorded() {
    let mut differing = Vec::new();
    for (name, script) in SCRIPTS {
        let desk = Desk::new();
        let mut person = desk.sit_down(&["shape.obj"]);
        person.wait_to_see("Layers");
        script(&mut person, &desk);
        save(&mut person, &desk);
        drop(person);
        let mut summary = Summary::default();
        for left in ["kept.chladni", "out.obj", "out.ply", "out.png", "mask.npz"] {
            let path = desk.path(left);
            if path.exists() {
                summary.file(left, &path);
            }
        }
        differing.extend(summary.differs_from_record(&records(), name));
    }
    assert!(differing.is_empty(), "{} differences:\n{}", differing.len(), differing.join("\n"));
}

#[test]
fn every_record_belongs_to_a_script() {
    for name in recorded_names(&records()) {
        assert!(SCRIPTS.iter().any(|(script, _)| *script == name), "{name} is recorded, but no script");
    }
}

/// The whole shape against its ellipsoid, without folds, for another program and as a picture.
fn exaggerated(person: &mut Person, desk: &Desk) {
    person.add_layer("ellipsoid");
    person.wait_to_see("No folds");
    person.slide("μ", -1.5);
    person.click("model/normal");
    person.click("keep-triangles");
    person.wait_to_see("of the movement kept");
    export(person, desk, "out.obj", "obj");
    export(person, desk, "out.png", "png");
}

/// A soft stroke over a magnified shape, one wiped off, one too many.
fn painted(person: &mut Person, desk: &Desk) {
    person.add_layer("magnify");
    person.press(Key::B);
    person.slide("Hardness", 0.25);
    person.drag(&[MIDDLE, MIDDLE + vec2(20.0, 0.0), MIDDLE + vec2(40.0, 20.0)]);
    person.press(Key::X);
    person.drag(&[MIDDLE + vec2(40.0, 20.0), MIDDLE + vec2(50.0, 40.0)]);
    person.press(Key::X);
    person.drag(&[MIDDLE - vec2(60.0, 60.0), MIDDLE - vec2(40.0, 60.0)]);
    person.press_with(CTRL, Key::Z);
    export(person, desk, "out.ply", "ply");
}

/// Beside another mesh, with a bent curve.
fn compared(person: &mut Person, desk: &Desk) {
    desk.answers.add(desk.path("template.obj"));
    person.press_with(CTRL, Key::T);
    person.wait_to_see("Covered");
    person.click("curve/broad");
    person.bend_scale_curve();
    export(person, desk, "out.obj", "obj");
}

/// Two layers, one copied and hidden, one step back and forth.
fn layered(person: &mut Person, _: &Desk) {
    person.add_layer("magnify");
    person.add_layer("ellipsoid");
    person.press_with(CTRL, Key::D);
    person.press(Key::H);
    person.press(Key::Comma);
    person.press_with(CTRL, Key::Z);
    person.press_with(CTRL | Modifiers::SHIFT, Key::Z);
}

/// A region by curvature, written and inverted.
fn masked(person: &mut Person, desk: &Desk) {
    person.add_layer("magnify");
    person.click("curvature");
    person.click("curvature/bumps");
    desk.answers.add(desk.path("mask.npz"));
    person.click("mask");
    person.click("mask/save");
    person.wait_to_see("Wrote");
    person.press(Key::I);
}

fn export(person: &mut Person, desk: &Desk, name: &str, extension: &str) {
    person.press_with(CTRL, Key::E);
    person.click(&format!("export/{extension}"));
    desk.answers.add(desk.path(name));
    person.click("export-begin");
    person.wait_to_see(&format!("Exported {}", desk.path(name).display()));
}

fn save(person: &mut Person, desk: &Desk) {
    desk.answers.add(desk.path("kept.chladni"));
    person.press_with(CTRL, Key::S);
    assert!(Project::load(&desk.path("kept.chladni")).is_ok());
}
