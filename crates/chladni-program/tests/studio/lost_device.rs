//! A driver that restarts takes the window's device with it.

use chladni_program::studio::{Handover, Opening};
use egui::Key;

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
    let opening = |files: &[&str]| Opening { handover: handover.clone(), ..desk.opening(files) };
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
