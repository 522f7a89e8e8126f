//! The room on every screen.

use egui::{Key, pos2, vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};

use crate::CTRL;
use crate::driving;
use crate::driving::person::{Desk, HARMONICS, Person};

/// From a laptop to a 4k screen, with small points and large ones, nothing is cut off at the edges.
#[test]
fn every_control_lies_inside_the_window_at_any_size() {
    let screens = [
        ("laptop", [1366.0, 768.0], 1.0),
        ("4k", [3840.0, 2160.0], 1.0),
        ("4k-double", [1920.0, 1080.0], 2.0),
        ("least", [900.0, 600.0], 1.0),
    ];
    // The large ones take software drawing a minute, and are for pictures.
    let all = driving::takes_pictures();
    for (name, size, pixels_per_point) in screens.into_iter().filter(|s| all || s.1[0] < 1500.0) {
        for light in [false, true].into_iter().filter(|light| all || !light) {
            let desk = Desk::new();
            let settings = format!("harmonics = {}\nlight = {light}\n", HARMONICS);
            std::fs::write(desk.path("settings.toml"), settings).unwrap();
            let open = |files: &[&str]| {
                let screen = Harness::builder().with_size(size).with_pixels_per_point(pixels_per_point);
                Person(driving::open_with(desk.opening(files), screen))
            };
            let looks = if light { format!("{name}-light") } else { name.to_owned() };
            // The start screen's pictures come one after another, too slow for every size.
            let mut start = open(&[]);
            start.0.run_steps(4);
            all_inside(&start, size, &looks);
            start.screenshot(&format!("size-{looks}-start.png"));
            drop(start);
            let mut person = open(&["shape.obj"]);
            person.wait_to_see("Compare with a mesh");
            all_inside(&person, size, &looks);
            person.screenshot(&format!("size-{looks}-empty.png"));
            person.add_layer("magnify");
            person.add_layer("ellipsoid");
            person.wait("the match", |window| !driving::shows(window, "Matching"));
            person.press(Key::B);
            let middle = pos2(size[0] / 2.0, size[1] / 2.0);
            person.drag(&[middle, middle + vec2(10.0, 20.0)]);
            person.0.run_steps(4);
            all_inside(&person, size, &looks);
            person.screenshot(&format!("size-{looks}.png"));
            person.press(Key::Escape);
            person.press(Key::V);
            person.0.run_steps(4);
            person.screenshot(&format!("size-{looks}-models.png"));
            person.press_with(CTRL, Key::E);
            all_inside(&person, size, &looks);
            person.screenshot(&format!("size-{looks}-export.png"));
            person.press(Key::Escape);
            person.press(Key::F1);
            all_inside(&person, size, &looks);
            person.screenshot(&format!("size-{looks}-keys.png"));
        }
    }
}

/// Buttons at least: what cannot be clicked is not there.
fn all_inside(person: &Person, size: [f32; 2], screen: &str) {
    let window = egui::Rect::from_min_size(pos2(0.0, 0.0), size.into()).expand(0.5);
    for button in person.0.get_all_by_role(egui::accesskit::Role::Button) {
        let (rect, label) = (button.rect(), button.accesskit_node().label().unwrap_or_default());
        // Controls beyond the edge can be scrolled to.
        let scrolled = rect.top() > size[1] - 60.0 && size[1] < 700.0;
        assert!(scrolled || window.contains_rect(rect), "{screen}: “{label}” at {rect:?}");
    }
}

#[test]
fn escape_closes_the_keys() {
    let mut person = Desk::new().sit_down(&[]);
    person.press(Key::F1);
    assert!(person.sees("Keyboard and mouse"));
    person.press(Key::Escape);
    person.wait_until_gone("Keyboard and mouse");
}

#[test]
fn the_window_has_a_name_for_screen_readers() {
    let person = Desk::new().sit_down(&[]);
    assert_eq!(person.0.root().accesskit_node().label().as_deref(), Some("Chladni"));
}
