//! Opening, saving, and never losing work.

use std::rc::Rc;

use chladni_caricature::{Project, ShapeSource};
use chladni_mesh::save_mesh;
use chladni_program::studio::{FirstPicture, Opening};
use egui::{Event, Key, Modifiers};
use egui_kittest::kittest::Queryable;

use crate::driving::person::{self, Desk, HARMONICS, Person};
use crate::driving::{numbers_by_tab, wait_until_left};
use crate::{CTRL, settle_on_screen};

#[test]
fn work_survives_a_crash_and_is_asked_about_on_closing() {
    let desk = Desk::new();
    let mut person = desk.with_layers(&["magnify"]);
    let copies = || std::fs::read_dir(desk.path("recovery")).into_iter().flatten().flatten();
    let kept = || copies().any(|entry| entry.path().extension().is_some_and(|e| e == "chladni"));
    person.wait("the recovery copy", |_| kept());
    // Nobody tells the window that it ends: a crash.
    drop(person);
    wait_until_left(&desk.path("recovery"), "session", "chladni");

    let mut person = desk.sit_down(&[]);
    assert!(person.sees("did not end well"));
    person.wait("the picture of the recent shape", |_| desk.path("pictures").exists());
    person.0.run_steps(20);
    person.screenshot("studio-recover.png");
    person.click("recover");
    person.wait_to_see("Magnify all 1");
    person.wait("the old copy's end", |_| {
        copies().filter(|entry| entry.path().extension().is_some_and(|e| e == "chladni")).count() == 1
    });

    person.close();
    assert!(person.sees("Save before closing?"));
    person.screenshot("studio-close.png");
    person.click("keep-working");
    assert!(!person.sees("Save before closing?"));
    person.close();
    desk.answers.add(desk.path("kept.chladni"));
    person.click("save-and-close");
    assert_eq!(Project::load(&desk.path("kept.chladni")).unwrap().layers().len(), 1);
    person.wait("the copy's end", |_| !kept());
}

/// The system holds back what is pressed while the window waits for its dialog, and hands it over with the next frame.
#[test]
fn a_key_that_is_pressed_beside_a_dialog_changes_nothing() {
    let desk = Desk::new();
    let mut person = desk.with_layers(&["magnify"]);
    person.wait_to_see("Magnify all 1");
    desk.answers.add(desk.path("kept.chladni"));
    for (modifiers, key) in [(CTRL, Key::S), (Modifiers::NONE, Key::Delete)] {
        let event = Event::Key { key, physical_key: None, pressed: true, repeat: false, modifiers };
        person.0.event(event);
    }
    person.0.run_steps(3);
    assert!(desk.path("kept.chladni").exists());
    assert!(person.sees("Magnify all 1"));
    // Whatever is pressed later counts.
    person.press(Key::Delete);
    person.wait_until_gone("Magnify all 1");
}

#[test]
fn a_project_that_is_only_looked_at_has_nothing_to_save() {
    let desk = Desk::new();
    let path = |name: &str| desk.path(name).to_str().unwrap().to_owned();
    let run = |arguments: &[&str]| chladni_program::cli::run(["chladni", "--quiet"].iter().chain(arguments));
    let project = path("fine.chladni");
    let new = ["project", "new", &path("shape.obj"), "-o", &project, "--harmonics", &HARMONICS.to_string()];
    assert_eq!(run(&new), 0);
    // Values that no slider would have given.
    let region = ["--region", "0,0,0,3", "--cutoff", "3"];
    let layer = ["project", "add-layer", &project, "--template", "ellipsoid", "--mu", "-0.12345"];
    assert_eq!(run(&[&layer[..], &["--strength", "0.54321"], &region].concat()), 0);
    let mut person = desk.sit_down(&[]);
    desk.answers.add(&project);
    person.press_with(CTRL, Key::O);
    person.wait_to_see("Softness");
    person.0.run_steps(5);
    // Through all controls: into each number, and on without a change.
    let numbers = numbers_by_tab(&mut person.0);
    assert!(["Strength", "Softness"].iter().all(|name| numbers.contains(*name)), "{numbers:?}");
    person.close();
    assert!(!person.sees("Save before closing?"));
}

#[test]
fn what_is_chosen_on_the_start_screen_is_opened_and_becomes_no_layer() {
    let desk = Desk::new();
    let mut person = desk.sit_down(&["shape.obj"]);
    person.wait_to_see("642 vertices");
    person.0.get_by_role_and_label(egui::accesskit::Role::Button, "Chladni").click();
    person.0.run_steps(3);
    person.0.get_by_label("Open Ring").click();
    person.0.run_steps(3);
    person.wait_until_gone("642 vertices");
    person.wait_to_see("vertices");
    assert!(person.0.query_all_by_label_contains("Layer ").next().is_none());
}

#[test]
fn a_mesh_that_is_dropped_on_the_start_screen_is_a_shape() {
    let desk = Desk::new();
    let mut person = desk.sit_down(&["shape.obj"]);
    person.wait_to_see("642 vertices");
    person.0.get_by_role_and_label(egui::accesskit::Role::Button, "Chladni").click();
    person.0.run_steps(3);
    save_mesh(&person::finer_lump(), &desk.path("finer.obj")).unwrap();
    person.drop_files(&[desk.path("finer.obj")]);
    person.wait_to_see("2\u{202f}562 vertices");
    assert!(!person.sees("Layer "));
}

#[test]
fn what_lies_beside_a_mesh_is_read_with_it_and_no_layer() {
    let desk = Desk::new();
    let obj = std::fs::read_to_string(desk.path("shape.obj")).unwrap();
    std::fs::write(desk.path("head.obj"), format!("mtllib head.mtl\n{obj}")).unwrap();
    std::fs::write(desk.path("head.mtl"), "newmtl skin\nKd 1 0 0\n").unwrap();
    std::fs::write(desk.path("mask.npy"), "numbers").unwrap();
    let skin = chladni_view::Picture::filled(2, 2, [200, 90, 60, 255]).to_png().unwrap();
    std::fs::write(desk.path("head.png"), skin).unwrap();
    let mut person = desk.sit_down(&[]);
    std::fs::write(desk.path("LICENSE"), "words").unwrap();
    person.drop_files(&["LICENSE", "head.mtl", "head.obj", "head.png"].map(|name| desk.path(name)));
    person.wait_to_see("642 vertices");
    assert!(!person.sees("Layer "));
    person.drop_files(&["template.obj", "template.mtl"].map(|name| desk.path(name)));
    person.wait_to_see("Layer template");
    person.drop_files(&[desk.path("mask.npy")]);
    person.wait_to_see("masks are opened under Region, Mask");
    assert!(!person.sees("Layer mask") && person.sees("642 vertices"));
    eframe::App::on_exit(person.0.state_mut());
    let kept = chladni_program::studio::Settings::load(&desk.path("settings.toml")).unwrap();
    assert_eq!(kept.recent, [desk.path("head.obj")]);
}

#[test]
fn a_project_whose_mesh_has_moved_opens_together_with_it() {
    let desk = Desk::new();
    let project = desk.path("p.chladni");
    Project::new(ShapeSource::File(desk.path("shape.obj")), HARMONICS).save(&project).unwrap();
    std::fs::create_dir(desk.path("elsewhere")).unwrap();
    let moved = desk.path("elsewhere/shape.obj");
    std::fs::rename(desk.path("shape.obj"), &moved).unwrap();
    let mut person = desk.sit_down(&[]);
    person.drop_files(std::slice::from_ref(&project));
    person.wait_to_see("open the project together with its mesh");
    person.drop_files(&[moved.clone(), project.clone()]);
    person.wait_to_see("642 vertices");
    assert!(!person.sees("Layer "));
    // Where it is now is worth being saved.
    person.press_with(CTRL, Key::S);
    assert_eq!(Project::load(&project).unwrap().shape, ShapeSource::File(moved));
}

#[test]
fn keys_do_nothing_beneath_a_question() {
    let desk = Desk::new();
    let mut person = desk.with_layers(&["magnify"]);
    person.close();
    assert!(person.sees("Save before closing?"));
    person.press(Key::Delete);
    person.press_with(CTRL, Key::D);
    desk.answers.add(desk.path("kept.chladni"));
    person.click("save-and-close");
    assert_eq!(Project::load(&desk.path("kept.chladni")).unwrap().layers().len(), 1);
}

#[test]
fn a_number_of_harmonics_is_a_preference_once_it_is_solved() {
    let desk = Desk::new();
    save_mesh(&person::finer_lump(), &desk.path("finer.obj")).unwrap();
    let mut person = desk.sit_down(&["finer.obj"]);
    person.wait_to_see("48 harmonics");
    // What the next window would begin with.
    let preferred = |person: &mut Person| {
        eframe::App::on_exit(person.0.state_mut());
        chladni_program::studio::Settings::load(&desk.path("settings.toml")).unwrap().harmonics
    };
    person.click("harmonics");
    person.click("harmonics/64");
    person.wait_to_see("64 harmonics");
    person.wait_until_gone("Solving");
    assert_eq!(preferred(&mut person), 64);
    person.click("harmonics");
    person.click("harmonics/1024");
    // A very quick machine may have solved it.
    let cancel = person.0.query_by_label("Cancel").map(|cancel| cancel.click());
    person.wait_until_gone("Solving");
    person.0.run_steps(3);
    let expected = if person.sees("64 harmonics") { 64 } else { 1024 };
    assert!(cancel.is_some() || expected == 1024);
    assert_eq!(preferred(&mut person), expected);
}

#[test]
fn opening_another_project_asks_about_unsaved_work() {
    let desk = Desk::new();
    let mut person = desk.with_layers(&["magnify"]);
    let empty = Project::new(ShapeSource::File(desk.path("template.obj")), HARMONICS);
    empty.save(&desk.path("other.chladni")).unwrap();
    desk.answers.add(desk.path("other.chladni"));
    person.press_with(CTRL, Key::O);
    assert!(person.sees("Save before opening another?"));
    person.click("keep-working");
    assert!(person.sees("Magnify all 1"));
    desk.answers.add(desk.path("other.chladni"));
    person.press_with(CTRL, Key::O);
    save_mesh(&person::finer_lump(), &desk.path("finer.obj")).unwrap();
    desk.answers.add(desk.path("finer.obj"));
    person.click("lose-changes");
    // One that is chosen meanwhile follows, and nothing is asked about work that is gone.
    person.press_with(CTRL, Key::O);
    person.wait_to_see("2\u{202f}562 vertices");
    assert!(!person.sees("Magnify all 1") && !person.sees("Save before opening another?"));
}

#[test]
fn meshes_opened_with_a_shape_become_layers_of_that_shape_only() {
    let desk = Desk::new();
    let mut person = desk.sit_down(&["shape.obj"]);
    person.wait_to_see("Layers");
    let choose = |person: &mut Person, names: &[&str]| {
        names.iter().for_each(|name| desk.answers.add(desk.path(name)));
        person.press_with(CTRL, Key::O);
        person.0.run_steps(4);
    };
    // A file that cannot be opened leaves the open shape as it is.
    choose(&mut person, &["missing.obj", "template.obj"]);
    person.wait_to_see("missing.obj");
    person.wait_until_gone("Opening missing.obj");
    person.0.run_steps(4);
    assert!(!person.sees("Layer template"));
    std::fs::write(desk.path("broken.chladni"), "no project").unwrap();
    choose(&mut person, &["broken.chladni", "template.obj"]);
    assert!(person.sees("broken.chladni") && !person.sees("Layer template"));

    // Nor does what waits until it is known what becomes of unsaved work.
    person.add_layer("magnify");
    save_mesh(&person::finer_lump(), &desk.path("finer.obj")).unwrap();
    choose(&mut person, &["finer.obj", "template.obj"]);
    assert!(person.sees("Save before opening another?") && !person.sees("Layer template"));
    person.click("keep-working");
    person.0.run_steps(4);
    assert!(person.sees("Magnify all 1") && !person.sees("Layer template"));
    choose(&mut person, &["finer.obj", "template.obj"]);
    person.click("lose-changes");
    person.wait_to_see("2\u{202f}562 vertices");
    person.wait_to_see("Layer template");
    assert!(!person.sees("Magnify all 1"));

    // A project is the shape, wherever it stands among the files.
    let project = Project::new(ShapeSource::File(desk.path("shape.obj")), HARMONICS);
    project.save(&desk.path("z.chladni")).unwrap();
    choose(&mut person, &["template.obj", "z.chladni"]);
    person.click("lose-changes");
    person.wait_to_see("642 vertices");
    person.wait_to_see("Layer template");
}

#[test]
fn a_project_is_saved_under_a_name_that_opens_again() {
    let desk = Desk::new();
    let mut person = desk.with_layers(&["magnify"]);
    desk.answers.add(desk.path("igea 1.2"));
    person.press_with(CTRL, Key::S);
    assert_eq!(Project::load(&desk.path("igea 1.2.chladni")).unwrap().layers().len(), 1);
    // Saved again, it keeps its name.
    person.add_layer("magnify");
    person.press_with(CTRL, Key::S);
    assert_eq!(Project::load(&desk.path("igea 1.2.chladni")).unwrap().layers().len(), 2);
    assert!(!desk.path("igea 1.2").exists());

    // A dialog asks before it replaces a file, but does not know the names that get their ending here.
    let before = std::fs::read(desk.path("igea 1.2.chladni")).unwrap();
    std::fs::write(desk.path("b 1.3.chladni"), "another").unwrap();
    person.add_layer("magnify");
    for name in ["igea 1.2", "b 1.3", "c 1.4"] {
        desk.answers.add(desk.path(name));
    }
    person.press_with(CTRL | Modifiers::SHIFT, Key::S);
    assert_eq!(Project::load(&desk.path("c 1.4.chladni")).unwrap().layers().len(), 3);
    assert_eq!(std::fs::read(desk.path("b 1.3.chladni")).unwrap(), b"another");
    assert_eq!(std::fs::read(desk.path("igea 1.2.chladni")).unwrap(), before);

    // That all layers of a saved project were removed is worth a question.
    for _ in 0..3 {
        person.press(Key::Delete);
    }
    person.wait_until_gone("Magnify all");
    person.close();
    assert!(person.sees("Save before closing?"));
    person.click("save-and-close");
    assert!(Project::load(&desk.path("c 1.4.chladni")).unwrap().layers().is_empty());
}

#[test]
fn a_project_that_another_program_has_changed_is_not_replaced_without_a_question() {
    let desk = Desk::new();
    let mut person = desk.with_layers(&["magnify"]);
    let path = desk.path("p.chladni");
    desk.answers.add(&path);
    person.press_with(CTRL, Key::S);
    let mut other = Project::load(&path).unwrap();
    other.harmonics = 9;
    other.save(&path).unwrap();
    person.add_layer("magnify");
    person.press_with(CTRL, Key::S);
    assert!(person.sees("another program has changed it"));
    assert_eq!(Project::load(&path).unwrap(), other);
    // Its name is chosen again, and from then on it is known.
    desk.answers.add(&path);
    for layers in [2, 3] {
        person.press_with(CTRL, Key::S);
        assert_eq!(Project::load(&path).unwrap().layers().len(), layers);
        person.add_layer("magnify");
    }
}

/// `chladni open shape.obj template.obj` in a terminal, and the project saved elsewhere.
#[test]
fn files_named_from_the_current_folder_are_found_wherever_the_project_is_saved() {
    let desk = Desk::new();
    let here = std::env::current_dir().unwrap();
    let up: std::path::PathBuf = here.components().skip(1).map(|_| std::path::Component::ParentDir).collect();
    let relative = |name: &str| up.join(desk.path(name).strip_prefix("/").unwrap());
    let files = vec![relative("shape.obj"), relative("template.obj")];
    let mut person = Person::new(Opening { files, ..desk.opening(&[]) });
    person.wait_to_see("Covered");
    // So deep that the way up from here does not lead to the root from there.
    let elsewhere = desk.path(&"elsewhere/".repeat(here.components().count()));
    std::fs::create_dir_all(&elsewhere).unwrap();
    desk.answers.add(elsewhere.join("p.chladni"));
    person.press_with(CTRL, Key::S);
    // Other harmonics are matched anew.
    person.click("harmonics");
    person.click("harmonics/64");
    person.wait("another match", |window| {
        crate::driving::shows(window, "Try again") || crate::driving::shows(window, "64 harmonics")
    });
    person.wait_until_gone("Solving");
    person.wait_until_gone("Matching");
    assert!(!person.sees("Try again"));
    person.wait_to_see("Covered");
}

#[test]
fn whoever_waits_for_the_first_picture_is_told_why_there_is_none() {
    let desk = Desk::new();
    let waits_for = |name: &str| {
        let first_picture = Rc::new(FirstPicture::since(std::time::Instant::now()));
        let opening = Opening { first_picture: Some(first_picture.clone()), ..desk.opening(&[name]) };
        Person::new(opening).wait("an end", |_| first_picture.outcome().is_some());
        first_picture.outcome().unwrap()
    };
    std::fs::write(desk.path("broken.chladni"), "no project").unwrap();
    assert!(waits_for("shape.obj").unwrap() > 0.0);
    for name in ["missing.obj", "broken.chladni"] {
        assert!(waits_for(name).unwrap_err().contains(name));
    }
}

/// The start screen offers what the rooms open, presets and sessions as well.
#[test]
fn the_start_screen_offers_all_that_can_be_opened() {
    let desk = Desk::new();
    let mut person = desk.sit_down(&[]);
    person.press_with(CTRL, Key::O);
    let offered = desk.answers.offered();
    for extension in ["obj", "mesh", "chladni", "wav", "toml"] {
        assert!(offered.iter().any(|known| known == extension), "{extension} is not among {offered:?}");
    }
}

#[test]
fn a_program_that_is_asked_to_end_keeps_what_is_not_saved_for_the_next_time() {
    let desk = Desk::new();
    let ends = chladni_task::Task::new();
    let mut person = Person::new(Opening { ends: Some(ends.clone()), ..desk.opening(&["shape.obj"]) });
    person.wait_to_see("Layers");
    person.add_layer("magnify");
    ends.cancel();
    person.0.run_steps(2);
    drop(person);
    wait_until_left(&desk.path("recovery"), "session", "chladni");
    let person = desk.sit_down(&[]);
    assert!(person.sees("did not end well"));
}

#[test]
fn letters_grow_as_far_as_the_window_has_room() {
    let desk = Desk::new();
    let mut person = desk.sit_down(&["shape.obj"]);
    person.0.set_size(egui::vec2(1000.0, 640.0));
    // Plus stands above the equals sign.
    person.press_with(CTRL, Key::Equals);
    assert!(person.sees("enlarge the window first"));
    person.0.set_size(egui::vec2(2000.0, 1280.0));
    let zoom = |person: &Person| person.0.ctx.zoom_factor();
    for (key, expected) in [(Key::Plus, 1.1), (Key::Equals, 1.21), (Key::Num0, 1.0)] {
        person.press_with(CTRL, key);
        person.0.run_steps(2);
        assert!((zoom(&person) - expected).abs() < 1e-3, "{key:?}: {}", zoom(&person));
    }
}

#[test]
fn letters_shrink_from_the_largest_that_the_screen_has_room_for() {
    let desk = Desk::new();
    let mut person = desk.sit_down(&["shape.obj"]);
    person.0.set_size(egui::vec2(2000.0, 1280.0));
    // Room for the smallest window, 600 points high, at 1.05.
    let screen = egui::vec2(1200.0, 710.0);
    for (key, expected) in [(Key::Plus, 1.05), (Key::Minus, 1.05 / 1.1)] {
        person.0.key_press_modifiers(CTRL, key);
        settle_on_screen(&mut person.0, screen);
        let zoom = person.0.ctx.zoom_factor();
        assert!((zoom - expected).abs() < 1e-3, "{key:?}: {zoom}");
    }
}

#[test]
fn the_first_mesh_takes_the_place_of_the_sample_that_nobody_chose() {
    let desk = Desk::new();
    let mut person = desk.sit_down(&[]);
    // Ctrl on every system: ⌘ with Tab is a Mac's own.
    person.press_with(Modifiers::CTRL, Key::Tab);
    person.0.run_steps(2);
    person.drop_files(&[desk.path("shape.obj")]);
    person.wait_to_see("642 vertices");
    assert!(!person.sees("Layer "));
    person.drop_files(&[desk.path("template.obj")]);
    person.wait_to_see("Layer template");
    assert!(person.sees("642 vertices"));
}

#[test]
fn what_is_shown_in_place_of_a_shape_that_does_not_open_is_said() {
    let desk = Desk::new();
    let mut person = desk.sit_down(&["shape.obj"]);
    person.wait_to_see("Layers");
    std::fs::write(desk.path("broken.obj"), "v 0 0\n").unwrap();
    desk.answers.add(desk.path("broken.obj"));
    person.press_with(CTRL, Key::O);
    person.wait_to_see("is shown as before");
    assert!(person.sees("broken.obj") && person.sees("“shape”"));
}
