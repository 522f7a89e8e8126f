//! From a shape with limbs to a drawing of it.

use chladni_mesh::{samples, save_mesh};
use egui::{Key, pos2};

use crate::CTRL;
use crate::driving;
use crate::driving::person::Desk;

#[test]
fn a_limb_is_taken_by_a_click_and_all_is_drawn_in_ink() {
    let desk = Desk::new();
    save_mesh(&samples::sample("octopus").unwrap(), &desk.path("octopus.obj")).unwrap();
    let mut person = desk.sit_down(&["octopus.obj"]);
    person.wait_to_see("Compare with a mesh");
    person.add_layer("ellipsoid");
    person.wait_until_gone("Matching");
    person.press(Key::B);
    person.click("parts");
    person.wait_to_see("Click a part of the shape");
    // The octopus stands in the middle of the window.
    person.0.hover_at(pos2(620.0, 430.0));
    person.0.run_steps(4);
    person.screenshot("studio-part-pointed.png");
    assert!(!person.sees("Softness"), "a region before the click");
    person.click_at(pos2(620.0, 430.0));
    assert!(person.sees("Softness"));
    person.screenshot("studio-part.png");
    person.press_with(CTRL, Key::Z);
    assert!(!person.sees("Softness"), "the click is one step");

    person.press(Key::Escape);
    person.press(Key::P);
    if driving::takes_pictures() {
        person.wait("the drawing", |window| !driving::is_busy(window));
        person.screenshot("studio-ink.png");
    }
    for name in ["out.svg", "out.png"] {
        person.press_with(CTRL, Key::E);
        person.click(if name == "out.svg" { "export/svg" } else { "export/png" });
        person.click("sizes");
        person.click("size/640x480");
        desk.answers.add(desk.path(name));
        person.click("export-begin");
        person.wait_to_see(&format!("Exported {}", desk.path(name).display()));
    }
    let svg = std::fs::read_to_string(desk.path("out.svg")).unwrap();
    assert!(svg.contains("width=\"640\" height=\"480\"") && svg.matches("<path ").count() > 50);
    let picture = chladni_view::Picture::decode(&std::fs::read(desk.path("out.png")).unwrap()).unwrap();
    let paper = chladni_view::ink::Ink::default().paper;
    assert_eq!(picture.pixel(0, 0).map(|p| [p[0], p[1], p[2]]), Some(paper));
}
