//! The gallery of caricatures, by hand and by keys.

use chladni_caricature::Project;
use egui::Key;
use egui_kittest::kittest::{NodeT, Queryable};

use crate::CTRL;
use crate::driving;
use crate::driving::person::{Desk, Person, finer_lump};

#[test]
fn caricatures_are_chosen_bred_and_taken_as_layers_in_one_step() {
    let desk = Desk::new();
    let mut person = desk.sit_down(&["shape.obj"]);
    person.wait_to_see("Layers");
    person.press(Key::G);
    person.wait_to_see("Caricature 12");
    person.screenshot("studio-gallery.png");
    let is_lock = |id: &str| id.starts_with("lock/");
    let locks = person.0.query_all_by(move |node| node.author_id().is_some_and(is_lock));
    let heights: Vec<f32> = locks.map(|lock| lock.rect().height()).collect();
    assert!(
        heights.len() > 1 && heights.iter().all(|height| *height < 40.0),
        "a word is broken: {heights:?}"
    );
    person.click("caricature/3");
    person.wait_to_see("Breed 1");
    person.press(Key::ArrowRight);
    person.press(Key::C);
    person.wait_to_see("Breed 2");
    person.press(Key::F);
    person.wait_to_see("Favorites");
    person.wait("the mark in words", |window| {
        let is_cell = |id: &str| id.starts_with("caricature/");
        let mut cells = window.query_all_by(move |node| node.author_id().is_some_and(is_cell));
        cells.any(|cell| cell.accesskit_node().value().is_some_and(|value| value.starts_with("favorite, ")))
    });
    person.click("lock/scales");
    person.press(Key::Enter);
    person.wait("the children", |window| {
        !driving::shows(window, "Breeding") && driving::shows(window, "Breed")
    });
    assert!(!person.sees("Breed 2"));
    person.press_with(CTRL, Key::Z);
    person.wait_to_see("Breed 2");
    person.press(Key::S);
    person.wait_until_gone("Caricature 12");
    desk.answers.add(desk.path("taken.chladni"));
    person.press_with(CTRL, Key::S);
    let layers = Project::load(&desk.path("taken.chladni")).unwrap().layers().len();
    assert!((1..=3).contains(&layers), "{layers}");
    person.press_with(CTRL, Key::Z);
    person.press_with(CTRL, Key::S);
    assert!(Project::load(&desk.path("taken.chladni")).unwrap().layers().is_empty());
    person.press(Key::G);
    person.wait_to_see("Caricature 12");
    person.press(Key::R);
    person.wait_until_gone("Caricature 12");
    person.press_with(CTRL, Key::S);
    assert!(!Project::load(&desk.path("taken.chladni")).unwrap().layers().is_empty());
}

#[test]
fn a_gallery_that_is_closed_is_there_again_until_another_shape_is_opened() {
    let desk = Desk::new();
    let mut person = desk.sit_down(&["shape.obj"]);
    person.wait_to_see("Layers");
    person.press(Key::G);
    person.wait_to_see("Caricature 12");
    assert!(!person.sees("Favorites"));
    person.click("caricature/3");
    person.press(Key::F);
    person.wait_to_see("Favorites");
    person.click("lock/scales");
    person.press(Key::Enter);
    person.wait("the children", |window| {
        !driving::shows(window, "Breeding") && !driving::shows(window, "Breed 1")
    });
    let is_locked = |person: &Person| {
        let node = driving::control(&person.0, "lock/scales").accesskit_node().toggled();
        node == Some(egui::accesskit::Toggled::True)
    };
    assert!(is_locked(&person));
    // A menu that is open has the keys: Escape closes that alone.
    driving::control(&person.0, "caricature/3").click_secondary();
    person.0.run_steps(3);
    assert!(person.sees("Change a little"));
    person.press(Key::Escape);
    assert!(person.sees("Caricature 12") && !person.sees("Change a little"));
    person.press(Key::Escape);
    assert!(!person.sees("Caricature 12"));
    person.press(Key::G);
    // At once, without being prepared again.
    person.0.run_steps(1);
    assert!(person.sees("Caricature 12") && person.sees("Favorites") && is_locked(&person));
    // Taken, and open again: still there, with its parents.
    person.press(Key::S);
    person.wait_until_gone("Caricature 12");
    person.press(Key::G);
    person.0.run_steps(1);
    assert!(person.sees("Caricature 12") && person.sees("Favorites"));
    person.press_with(CTRL, Key::Z);
    person.wait_to_see("Breed 1");
    person.press(Key::Escape);

    // On other harmonics, too.
    person.click("harmonics");
    person.click("harmonics/128");
    person.0.run_steps(2);
    person.wait_until_gone("Solving");
    person.press(Key::G);
    person.wait_to_see("Caricature 12");
    assert!(person.sees("Favorites") && person.sees("Breed 1") && is_locked(&person));
    person.press(Key::Escape);

    chladni_mesh::save_mesh(&finer_lump(), &desk.path("finer.obj")).unwrap();
    desk.answers.add(desk.path("finer.obj"));
    person.press_with(CTRL, Key::O);
    person.click("lose-changes");
    person.wait_to_see("2\u{202f}562 vertices");
    person.press(Key::G);
    person.wait_to_see("Caricature 12");
    assert!(!person.sees("Favorites") && !person.sees("Breed 1") && !is_locked(&person));
}

#[test]
fn what_is_taken_is_seen_alone_and_one_step_back_all_is_as_it_was() {
    let desk = Desk::new();
    let mut person = desk.sit_down(&["shape.obj"]);
    person.wait_to_see("Layers");
    for template in ["template/ellipsoid", "template/sphere"] {
        person.click("add");
        person.click(template);
    }
    desk.answers.add(desk.path("taken.chladni"));
    let seen = |person: &mut Person| -> Vec<bool> {
        person.press_with(CTRL, Key::S);
        let project = Project::load(&desk.path("taken.chladni")).unwrap();
        project.layers().iter().map(|(_, layer)| layer.enabled).collect()
    };
    assert_eq!(seen(&mut person), [true, true]);
    person.press(Key::G);
    person.wait_to_see("Caricature 12");
    person.double_click("caricature/1");
    person.wait_until_gone("Caricature 12");
    let taken = seen(&mut person);
    assert!(taken.len() > 2 && taken[..2] == [false, false] && taken[2..].iter().all(|on| *on), "{taken:?}");
    // The double click has made it no parent.
    person.press(Key::G);
    person.wait_to_see("Caricature 12");
    assert!(!person.sees("Breed 1"));
    person.press(Key::Escape);
    person.press_with(CTRL, Key::Z);
    assert_eq!(seen(&mut person), [true, true]);
}

#[test]
fn the_brush_landmarks_and_the_gallery_end_each_other() {
    let desk = Desk::new();
    let mut person = desk.sit_down(&["shape.obj", "template.obj"]);
    person.wait_to_see("Covered");
    let names = ["Painting", "Landmarks on the shape", "Surprise me"];
    let tools = |person: &Person| names.map(|name| person.sees(name));
    let (paints, picks, breeds) = ([true, false, false], [false, true, false], [false, false, true]);
    for (key, only) in [(Key::L, picks), (Key::B, paints), (Key::L, picks), (Key::G, breeds)] {
        person.press(key);
        person.0.run_steps(2);
        assert_eq!(tools(&person), only, "{key:?}");
    }
    // The gallery has keys of its own, but the panels have their buttons.
    person.0.get_by_label("Paint").click_accesskit();
    person.0.run_steps(3);
    assert_eq!(tools(&person), paints);
    person.press(Key::G);
    person.0.run_steps(2);
    assert_eq!(tools(&person), breeds);
    person.press(Key::Escape);
    person.0.run_steps(2);
    assert_eq!(tools(&person), [false; 3], "the brush was put away");
}
