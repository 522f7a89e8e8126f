//! A first-time user's way through the window.

use chladni_program::studio::Opening;
use egui::{Key, Modifiers, pos2, vec2};
use egui_kittest::kittest::Queryable;

use crate::CTRL;
use crate::driving;
use crate::driving::person::{Desk, Person};

/// A first-time user's way: the start screen, the sample head, a nose painted, another layer,
/// landmarks. Its pictures are those of the README.
#[test]
fn the_start_screen_leads_to_a_caricature_of_the_sample_head() {
    // For pictures everything is as a user has it; otherwise fewer harmonics are quicker.
    let desk = Desk::new();
    let mut person =
        if driving::takes_pictures() { Person::new(Opening::default()) } else { desk.sit_down(&[]) };
    if driving::takes_pictures() {
        // The samples' pictures come one after another.
        person.wait("the samples' pictures", |window| !driving::is_busy(window));
    }
    person.screenshot("window-start.png");
    person.click("room/0");
    person.wait_to_see("Covered");
    person.0.run_steps(4);
    person.screenshot("window-caricature.png");
    assert!(person.sees("harmonics") && person.sees("vertices"));

    // Around the nose, and a second layer that exaggerates it.
    person.add_layer("own-detail");
    person.press(Key::B);
    person.drag(&[pos2(455.0, 520.0), pos2(470.0, 500.0), pos2(490.0, 470.0), pos2(500.0, 440.0)]);
    person.screenshot("window-painting.png");
    person.press(Key::Escape);
    assert!(person.sees("Layer Own detail 2"));
    person.click_at(person.place_of("layer/1").center());
    person.press(Key::V);
    person.wait_to_see("Original");
    person.screenshot("window-models.png");
    // The second of the three models is the normal one; a click chooses it.
    person.click_at(pos2(796.0, 260.0));
    person.press_with(CTRL, Key::Z);
    assert_eq!(person.0.query_all_by_label_contains("normal").count(), 0);
    person.press_with(CTRL | Modifiers::SHIFT, Key::Z);
    assert!(person.sees("normal"));
    if !driving::takes_pictures() {
        return;
    }
    person.press_with(CTRL, Key::Z);
    person.press(Key::V);
    person.press(Key::V);
    person.click("colors");
    person.click("colors/place");
    let stage = person.place_of("view");
    // The tip of the nose.
    person.0.hover_at(stage.center() + vec2(-0.425 * stage.width(), 0.11 * stage.height()));
    person.0.run_steps(4);
    person.screenshot("window-template.png");
    person.press(Key::L);
    person.wait_to_see("Landmarks on the template");
    person.wait_until_gone("Reading the template");
    let sides = ["landmarks/shape", "landmarks/template"].map(|id| person.place_of(id));
    for (x, y) in [(0.0, 0.02), (-0.12, -0.05), (0.12, -0.05), (0.0, 0.16)] {
        for side in sides {
            person.click_at(side.center() + vec2(x * side.width(), y * side.height()));
        }
    }
    person.wait_to_see("The match follows");
    person.wait_until_gone("Matching");
    person.wait_to_see("Covered");
    person.screenshot("window-landmarks.png");
    person.press(Key::Escape);
    person.press(Key::F1);
    person.screenshot("studio-keys.png");
    person.press(Key::F1);
    person.click_at(pos2(1217.0, 21.0));
    person.0.set_size(vec2(900.0, 600.0));
    person.screenshot("studio-light.png");
}
