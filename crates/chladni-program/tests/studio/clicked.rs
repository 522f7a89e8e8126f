//! What is switched on by a click: keeping triangles, the sliders of a head, how ink is drawn.

use chladni_caricature::{Layer, Project, Template};
use egui::{Key, Modifiers};
use egui_kittest::kittest::Queryable;

use crate::CTRL;
use crate::driving;
use crate::driving::person::{Desk, Person};

/// The project as it is saved now.
fn saved(desk: &Desk, person: &mut Person) -> Project {
    desk.answers.add(desk.path("saved.chladni"));
    person.press_with(CTRL | Modifiers::SHIFT, Key::S);
    Project::load(&desk.path("saved.chladni")).unwrap()
}

#[test]
fn kept_triangles_do_not_fold_and_are_let_go_in_one_step() {
    let desk = Desk::new();
    let mut person = desk.with_layers(&["ellipsoid"]);
    person.wait_to_see("No folds");
    person.slide("μ", -30.0);
    person.wait_to_see("folded triangles");
    assert!(!saved(&desk, &mut person).keep_triangles && !person.sees("of the movement kept"));
    person.click("keep-triangles");
    person.wait_to_see("of the movement kept");
    person.screenshot("studio-kept.png");
    // One of 2000 may fold: of 1280 triangles none.
    person.wait_to_see("No folds");
    person.wait_to_see("Nothing passes through itself");
    assert!(saved(&desk, &mut person).keep_triangles);
    person.press_with(CTRL, Key::Z);
    person.wait_to_see("folded triangles");
    assert!(!saved(&desk, &mut person).keep_triangles);
}

#[test]
fn the_sliders_of_a_head_change_the_template_and_the_match_follows() {
    let desk = Desk::new();
    let mut person = desk.with_layers(&["sliders"]);
    person.wait_to_see("Covered");
    let layer = |person: &mut Person| -> Layer { (*saved(&desk, person).layers()[0].1).clone() };
    assert_eq!(layer(&mut person).template, Template::Sample("portrait".into()));
    person.slide("Jaw", 0.75);
    person.slide("Nose", -0.5);
    let named = Template::Sample("portrait?nose=-0.50,jaw=0.75".into());
    assert_eq!(layer(&mut person).template, named);
    person.wait_until_gone("Matching");
    person.wait_to_see("Covered");
    person.screenshot("studio-head-sliders.png");
}

#[test]
fn ink_is_drawn_as_its_panel_says_in_pictures_and_drawings() {
    let desk = Desk::new();
    let mut person = desk.with_layers(&["ellipsoid"]);
    person.wait_to_see("No folds");
    person.slide("μ", -2.0);
    assert!(!driving::is_there(&person.0, "ink/detail"));
    person.press(Key::P);
    let export = |person: &mut Person, kind: &str, name: &str| {
        person.press_with(CTRL, Key::E);
        person.click(&format!("export/{kind}"));
        person.click("sizes");
        person.click("size/640x480");
        desk.answers.add(desk.path(name));
        person.click("export-begin");
        person.wait_to_see(&format!("Exported {}", desk.path(name).display()));
    };
    let svg = |name: &str| std::fs::read_to_string(desk.path(name)).unwrap();
    let strokes = |name: &str, group: &str| {
        let text = svg(name);
        let inside =
            text.split(&format!("<g id=\"{group}\"")).nth(1).and_then(|rest| rest.split("</g>").next());
        inside.unwrap().matches("<path ").count()
    };
    export(&mut person, "svg", "usual.svg");
    assert!(strokes("usual.svg", "hatching") > 5);
    person.slide("Hatching", 0.0);
    person.slide("Detail", 0.0);
    export(&mut person, "svg", "plain.svg");
    let left =
        ["contours", "suggestive-contours", "ridges", "hatching"].map(|group| strokes("plain.svg", group));
    assert!(left[0] > 0 && left[1..] == [0; 3], "{left:?}");
    person.click("ink/exaggeration");
    person.screenshot("studio-ink-panel.png");
    export(&mut person, "svg", "weighted.svg");
    assert_ne!(svg("weighted.svg"), svg("plain.svg"), "lines have other widths");
    assert_eq!(svg("weighted.svg").matches("<path ").count(), svg("plain.svg").matches("<path ").count());
    person.click("ink/tones/4");
    export(&mut person, "svg", "toned.svg");
    // The lightest is the paper.
    assert_eq!(svg("toned.svg").matches("evenodd").count(), 3);

    export(&mut person, "png", "toned.png");
    let picture =
        |name: &str| chladni_view::Picture::decode(&std::fs::read(desk.path(name)).unwrap()).unwrap();
    let toned = picture("toned.png");
    person.0.get_by_label("As usual").click();
    person.0.run_steps(3);
    export(&mut person, "png", "usual.png");
    assert_ne!(picture("usual.png").rgba, toned.rgba);
    export(&mut person, "svg", "again.svg");
    assert_eq!(svg("again.svg"), svg("usual.svg"));
}
