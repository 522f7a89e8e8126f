//! Menus that open on a click, and how far the keyboard reaches.

use egui::Key;
use egui::accessibility::is_input;
use egui::accesskit::Role;
use egui_kittest::kittest::{NodeT, Queryable};

use crate::CTRL;
use crate::driving::person::Desk;
use crate::driving::{control, is_there};

/// Taking a picture fails where something on it has no name of its own.
#[test]
fn everything_in_a_menu_has_a_name() {
    let desk = Desk::new();
    let mut person = desk.sit_down(&["shape.obj"]);
    person.wait_to_see("Compare with a mesh");
    for (menu, entry) in
        [("add", "template/ellipsoid"), ("colors", "colors/harmonic"), ("look", "material/bronze")]
    {
        person.click(menu);
        person.screenshot(&format!("menu-{}.png", menu));
        person.click(entry);
        person.press(Key::Escape);
    }
    person.wait_until_gone("Matching");
    control(&person.0, "layer/1").click_secondary();
    person.0.run_steps(3);
    person.screenshot("menu-layer.png");
    person.click("rename");
    person.screenshot("menu-rename.png");
    person.press(Key::Escape);
    person.press_with(CTRL, Key::E);
    for what in ["png", "gif"] {
        person.click(&format!("export/{what}"));
        person.click("sizes");
        person.screenshot(&format!("menu-sizes-{what}.png"));
        person.press(Key::Escape);
    }
    person.0.get_by_role_and_label(Role::Dialog, "Export");
}

/// Tab goes through all that can be acted on, in the order of the screen, and scrolls to it.
#[test]
fn the_keyboard_alone_reaches_every_control() {
    let desk = Desk::new();
    let mut person = desk.sit_down(&["shape.obj"]);
    person.wait_to_see("Compare with a mesh");
    person.add_layer("ellipsoid");
    person.wait_until_gone("Matching");
    // A small window, where panels scroll.
    person.0.set_size(egui::vec2(900.0, 600.0));
    person.0.run_steps(3);
    let window = egui::Rect::from_min_size(egui::Pos2::ZERO, egui::vec2(900.0, 600.0)).expand(1.0);
    let mut reached = Vec::new();
    while reached.len() < 100 && (reached.len() < 2 || reached[0] != reached[reached.len() - 1]) {
        person.press(Key::Tab);
        person.0.run_steps(2);
        let focused = person.0.root().children_recursive().find(|node| node.accesskit_node().is_focused());
        let node = focused.expect("something has the focus");
        let place = node.rect();
        let node = node.accesskit_node();
        assert!(window.contains_rect(place), "{:?} has the focus at {place}", node.label());
        reached.push(node.locate());
        if node.label().as_deref() == Some("Finest") {
            person.screenshot("keyboard.png");
        }
    }
    let nodes = person.0.root().children_recursive();
    let controls = nodes.map(|node| node.accesskit_node()).filter(|node| {
        let can_act = is_input(node.role()) || node.role() == Role::Canvas;
        can_act && !node.is_disabled() && !node.is_hidden()
    });
    for control in controls {
        assert!(reached.contains(&control.locate()), "Tab never comes to {:?}", control.label());
    }

    // Arrows turn the view that has the focus; letters still do what they do, and Space what the button says.
    control(&person.0, "view").focus();
    person.0.run_steps(3);
    person.press(Key::ArrowRight);
    person.press(Key::B);
    person.wait_to_see("Painting");
    control(&person.0, "everywhere").focus();
    person.0.run_steps(3);
    person.press(Key::Tab);
    person.press(Key::Space);
    person.wait_to_see("Softness");
    person.press(Key::F1);
    person.wait_to_see("Keyboard and mouse");
    assert!(person.sees("Turn the view that has the focus"));
    person.press(Key::Escape);
    person.wait_until_gone("Keyboard and mouse");
}

#[test]
fn escape_closes_a_menu_before_the_sheet_of_keys() {
    let desk = Desk::new();
    let mut person = desk.sit_down(&["shape.obj"]);
    person.wait_to_see("Compare with a mesh");
    person.click("add");
    person.press(Key::F1);
    person.wait_to_see("Keyboard and mouse");
    assert!(is_there(&person.0, "template/ellipsoid"));
    person.press(Key::Escape);
    assert!(!is_there(&person.0, "template/ellipsoid") && person.sees("Keyboard and mouse"));
    person.press(Key::Escape);
    person.wait_until_gone("Keyboard and mouse");
}

#[test]
fn a_layer_is_moved_by_keys() {
    let desk = Desk::new();
    let mut person = desk.sit_down(&["shape.obj"]);
    person.wait_to_see("Compare with a mesh");
    for layer in ["template/ellipsoid", "template/sphere"] {
        person.click("add");
        person.click(layer);
    }
    let sphere_is_above = |person: &crate::driving::person::Person| {
        person.place_of("layer/2").top() < person.place_of("layer/1").top()
    };
    assert!(sphere_is_above(&person));
    person.press_with(CTRL, Key::PageUp);
    assert!(sphere_is_above(&person));
    person.press_with(CTRL, Key::PageDown);
    assert!(!sphere_is_above(&person));
    person.press_with(CTRL, Key::PageDown);
    assert!(!sphere_is_above(&person));
    person.press_with(CTRL, Key::PageUp);
    assert!(sphere_is_above(&person));
}
