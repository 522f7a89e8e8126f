//! The caricature room, used as a person would.

#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

mod driving;
mod person;

use std::cell::RefCell;
use std::path::PathBuf;
use std::rc::Rc;

use chladni::studio::{FileWindow, FirstPicture, Opening, Purpose, Request, Settings};
use chladni_caricature::{Model, Painted, Project, ScaleCurve, Stack};
use chladni_harmonics::{BasisSettings, Body};
use chladni_mesh::{load_mesh, save_mesh};
use chladni_task::Task;
use egui::{Key, Modifiers, pos2, vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};
use person::{Desk, HARMONICS, Person};

const CTRL: Modifiers = Modifiers::COMMAND;

#[test]
fn from_two_meshes_to_sliders_in_another_program() {
    let desk = Desk::new();
    let mut person = desk.sit_down(&["shape.obj", "template.obj"]);
    person.wait_to_see("Covered");

    // A region, painted on the shape in the middle of the window.
    person.press(Key::B);
    person.drag(&[pos2(600.0, 380.0), pos2(630.0, 400.0), pos2(660.0, 420.0)]);
    person.screenshot("studio-painted.png");
    // A model, a preset of the curve, and a bend of it.
    person.click("Normal");
    person.click("Broad");
    let curve = person.place_of("Scale curve");
    let at = |u: f32, v: f32| curve.lerp_inside(vec2(u, v));
    person.drag(&[at(0.5, 0.5), at(0.5, 0.3), at(0.5, 0.15)]);
    // Another layer, taken back, and done again.
    person.click_button("Add");
    person.click("Own size");
    assert!(person.sees("Own size 2"));
    person.press_with(CTRL, Key::Z);
    assert!(!person.sees("Own size 2"));
    person.press_with(CTRL | Modifiers::SHIFT, Key::Z);
    assert!(person.sees("Own size 2"));

    desk.answers.add(desk.path("p.chladni"));
    person.press_with(CTRL, Key::S);
    person.wait_to_see("Saved");
    person.screenshot("studio-saved.png");
    drop(person);

    let project = Project::load(&desk.path("p.chladni")).unwrap();
    let layers: Vec<_> = project.layers().iter().map(|(_, layer)| layer.as_ref()).collect();
    assert_eq!(layers.iter().map(|l| l.name.as_str()).collect::<Vec<_>>(), ["template", "Own size 2"]);
    assert_eq!(layers[0].model, Model::Normal);
    assert_ne!(layers[0].curve, ScaleCurve::broad(), "it was bent");
    let Painted::Vertices(painted) = &layers[0].region.painted else { panic!("nothing was painted") };
    let touched = painted.iter().filter(|x| **x > 0.0).count();
    assert!(touched > 3 && touched < painted.len() / 2, "{touched} of {}", painted.len());

    // The next day.
    let mut person = desk.sit_down(&["p.chladni"]);
    person.wait_to_see("Own size 2");
    let row = person.place_of("Layer template");
    person.click_at(row.center());
    person.wait_to_see("Covered");
    person.press_with(CTRL, Key::E);
    person.screenshot("studio-export.png");
    for name in ["out.glb", "out.png"] {
        if name == "out.png" {
            person.press_with(CTRL, Key::E);
            person.click("PNG");
            person.click("Usual sizes");
            person.click_button("640 × 480");
        }
        desk.answers.add(desk.path(name));
        person.click("Export…");
        person.wait("the export", |_| desk.path(name).exists());
    }
    let header = std::fs::read(desk.path("out.png")).unwrap();
    assert_eq!(&header[16..24], &[0, 0, 2, 128, 0, 0, 1, 224], "640 × 480");
    assert_eq!(header[25], 6, "with transparency");
    sliders_reproduce_the_layers(&desk, &project);

    // The same layers on another shape: the region goes along.
    save_mesh(&person::finer_lump(), &desk.path("finer.obj")).unwrap();
    desk.answers.add(desk.path("finer.obj"));
    person.click("Another shape");
    person.wait_to_see("2\u{202f}562 vertices");
    desk.answers.add(desk.path("finer.chladni"));
    person.press_with(CTRL, Key::S);
    let finer = Project::load(&desk.path("finer.chladni")).unwrap();
    assert_eq!(finer.shape, chladni_caricature::ShapeSource::File(desk.path("finer.obj")));
    let Painted::Vertices(carried) = &finer.layers()[0].1.region.painted else { panic!("no region") };
    let share = |values: &[f32]| values.iter().sum::<f32>() / values.len() as f32;
    assert_eq!(carried.len(), 2562);
    assert!((share(carried) / share(painted) - 1.0).abs() < 0.3, "{} {}", share(carried), share(painted));
}

/// In the GLB, the sliders of the lowest layers at 1 and the rest at 0 give each layer's result.
fn sliders_reproduce_the_layers(desk: &Desk, project: &Project) {
    let mesh = load_mesh(&desk.path("shape.obj")).unwrap().mesh;
    let template = load_mesh(&desk.path("template.obj")).unwrap().mesh;
    let body = std::sync::Arc::new(Body::build(&mesh, &BasisSettings::new(HARMONICS), &Task::new()).unwrap());
    let mut stack = Stack::new(body.clone()).unwrap();
    for request in stack.missing(project) {
        let matched = request.run(&mesh, &body, Some(&template), &Task::new());
        stack.install(request, matched);
    }
    let evaluation = stack.evaluate(project);
    let glb = Glb::read(&std::fs::read(desk.path("out.glb")).unwrap());
    let shape = &glb.json["meshes"][0];
    let names: Vec<_> = evaluation.layers.iter().map(|layer| layer.name.clone()).collect();
    assert_eq!(shape["extras"]["targetNames"], serde_json::json!(names));
    let primitive = &shape["primitives"][0];
    let mut moved = glb.vectors(&primitive["attributes"]["POSITION"]);
    let extent = 1.0 / body.frame.scale;
    for (index, layer) in evaluation.layers.iter().enumerate() {
        for (p, d) in moved.iter_mut().zip(glb.vectors(&primitive["targets"][index]["POSITION"])) {
            (0..3).for_each(|i| p[i] += d[i]);
        }
        let above = evaluation.layers.get(index + 1).map_or(&evaluation.result, |above| &above.base);
        let error = moved.iter().zip(&body.operator_vertex).filter_map(|(p, v)| {
            let expected = body.frame.to_file(above.positions[(*v)? as usize]);
            Some((0..3).map(|i| (p[i] - expected[i]).abs()).fold(0.0, f64::max))
        });
        let worst = error.fold(0.0, f64::max);
        assert!(worst < 1e-5 * extent, "{}: {worst:e} of {extent}", layer.name);
    }
    let rest = glb.vectors(&primitive["attributes"]["POSITION"]);
    let farthest =
        rest.iter().zip(&moved).map(|(a, b)| (0..3).map(|i| (a[i] - b[i]).abs()).fold(0.0, f64::max));
    assert!(farthest.fold(0.0, f64::max) > 0.01 * extent, "the sliders do something");
}

/// As much of a GLB as the test needs, read by itself rather than by our own reader.
struct Glb {
    json: serde_json::Value,
    data: Vec<u8>,
}

impl Glb {
    fn read(bytes: &[u8]) -> Self {
        let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
        assert_eq!((&bytes[..4], word(4), word(8)), (&b"glTF"[..], 2, bytes.len()));
        let json_end = 20 + word(12);
        assert_eq!((&bytes[16..20], &bytes[json_end + 4..json_end + 8]), (&b"JSON"[..], &b"BIN\0"[..]));
        let json = serde_json::from_slice(&bytes[20..json_end]).unwrap();
        Self { json, data: bytes[json_end + 8..].to_vec() }
    }

    fn vectors(&self, accessor: &serde_json::Value) -> Vec<[f64; 3]> {
        let accessor = &self.json["accessors"][accessor.as_u64().unwrap() as usize];
        assert_eq!((&accessor["componentType"], &accessor["type"]), (&5126.into(), &"VEC3".into()));
        let view = &self.json["bufferViews"][accessor["bufferView"].as_u64().unwrap() as usize];
        let start = view["byteOffset"].as_u64().unwrap_or(0) as usize;
        let count = accessor["count"].as_u64().unwrap() as usize;
        let float = |at: usize| f64::from(f32::from_le_bytes(self.data[at..at + 4].try_into().unwrap()));
        (0..count).map(|v| std::array::from_fn(|i| float(start + 12 * v + 4 * i))).collect()
    }
}

#[test]
fn work_survives_a_crash_and_is_asked_about_on_closing() {
    let desk = Desk::new();
    let mut person = desk.sit_down(&["shape.obj"]);
    person.wait_to_see("Layers");
    person.click_button("Add");
    person.click("Own size");
    let copies = || std::fs::read_dir(desk.path("recovery")).into_iter().flatten().flatten();
    let kept = || copies().any(|entry| entry.path().extension().is_some_and(|e| e == "chladni"));
    person.wait("the recovery copy", |_| kept());
    // Nobody tells the window that it ends: a crash.
    drop(person);

    let mut person = desk.sit_down(&[]);
    assert!(person.sees("did not end well"));
    person.wait("the picture of the recent shape", |_| desk.path("pictures").exists());
    person.0.run_steps(20);
    person.screenshot("studio-recover.png");
    person.click("Recover");
    person.wait_to_see("Own size 1");
    person.wait("the old copy's end", |_| {
        copies().filter(|entry| entry.path().extension().is_some_and(|e| e == "chladni")).count() == 1
    });

    person.close();
    assert!(person.sees("Save before closing?"));
    person.screenshot("studio-close.png");
    person.click("Keep working");
    assert!(!person.sees("Save before closing?"));
    person.close();
    desk.answers.add(desk.path("kept.chladni"));
    person.click("Save and close");
    assert_eq!(Project::load(&desk.path("kept.chladni")).unwrap().layers().len(), 1);
    person.wait("the copy's end", |_| !kept());
}

#[test]
fn opening_another_project_asks_about_unsaved_work() {
    let desk = Desk::new();
    let mut person = desk.sit_down(&["shape.obj"]);
    person.wait_to_see("Layers");
    person.click_button("Add");
    person.click("Own size");
    let empty = Project::new(chladni_caricature::ShapeSource::File(desk.path("template.obj")), HARMONICS);
    empty.save(&desk.path("other.chladni")).unwrap();
    desk.answers.add(desk.path("other.chladni"));
    person.press_with(CTRL, Key::O);
    assert!(person.sees("Save before opening another?"));
    person.click("Keep working");
    assert!(person.sees("Own size 1"));
    desk.answers.add(desk.path("other.chladni"));
    person.press_with(CTRL, Key::O);
    person.click("Lose changes");
    person.wait_until_gone("Own size 1");
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
    // What cannot be opened leaves the open shape as it is.
    choose(&mut person, &["missing.obj", "template.obj"]);
    person.wait_to_see("missing.obj");
    person.wait_until_gone("Opening missing.obj");
    person.0.run_steps(4);
    assert!(!person.sees("Layer template"));
    std::fs::write(desk.path("broken.chladni"), "no project").unwrap();
    choose(&mut person, &["broken.chladni", "template.obj"]);
    assert!(person.sees("broken.chladni") && !person.sees("Layer template"));

    // Nor does what waits until it is known what becomes of unsaved work.
    person.click_button("Add");
    person.click("Own size");
    save_mesh(&person::finer_lump(), &desk.path("finer.obj")).unwrap();
    choose(&mut person, &["finer.obj", "template.obj"]);
    assert!(person.sees("Save before opening another?") && !person.sees("Layer template"));
    person.click("Keep working");
    person.0.run_steps(4);
    assert!(person.sees("Own size 1") && !person.sees("Layer template"));
    choose(&mut person, &["finer.obj", "template.obj"]);
    person.click("Lose changes");
    person.wait_to_see("2\u{202f}562 vertices");
    person.wait_to_see("Layer template");
    assert!(!person.sees("Own size 1"));

    // A project is the shape, wherever it stands among the files.
    let project = Project::new(chladni_caricature::ShapeSource::File(desk.path("shape.obj")), HARMONICS);
    project.save(&desk.path("z.chladni")).unwrap();
    choose(&mut person, &["template.obj", "z.chladni"]);
    person.click("Lose changes");
    person.wait_to_see("642 vertices");
    person.wait_to_see("Layer template");
}

#[test]
fn landmarks_are_picked_moved_removed_saved_and_read() {
    let desk = Desk::new();
    let mut person = desk.sit_down(&["shape.obj", "template.obj"]);
    person.wait_to_see("Covered");
    person.press(Key::L);
    person.wait_to_see("Landmarks on the template");
    let (left, right) =
        (person.place_of("Landmarks on the shape"), person.place_of("Landmarks on the template"));
    person.wait_to_see("Click a place on the shape");
    person.wait_until_gone("Reading the template");
    let places = [(0.0, 0.0), (0.1, -0.15), (-0.1, 0.15), (0.12, 0.1)];
    for (x, y) in places {
        for side in [left, right] {
            person.click_at(side.center() + vec2(x * side.width(), y * side.height()));
        }
    }
    person.wait_to_see("The match follows");
    person.wait("the new match", |window| !driving::shows(window, "Matching"));
    person.screenshot("studio-landmarks.png");

    let landmarks = |name: &str| {
        let project = Project::load(&desk.path(name)).unwrap();
        project.layers()[0].1.matching.landmarks.clone()
    };
    desk.answers.add(desk.path("picked.chladni"));
    person.press_with(CTRL, Key::S);
    let picked = landmarks("picked.chladni");
    assert_eq!(picked.len(), places.len());

    // The first is dragged along the shape, the second removed, and both undone by one step each.
    // Its vertex is drawn a little above where the click was.
    let dot = left.center() + vec2(1.0, -15.0);
    person.drag(&[dot, dot + vec2(20.0, 10.0), dot + vec2(60.0, 40.0)]);
    person.screenshot("studio-dragged.png");
    person.click("Remove landmark 2");
    person.screenshot("studio-removed.png");
    desk.answers.add(desk.path("changed.chladni"));
    person.press_with(CTRL | Modifiers::SHIFT, Key::S);
    let changed = landmarks("changed.chladni");
    assert_eq!(changed.len(), places.len() - 1);
    assert_ne!(changed[0].shape, picked[0].shape);
    assert_eq!((changed[0].template, &changed[1..]), (picked[0].template, &picked[2..]));

    desk.answers.add(desk.path("landmarks.txt"));
    person.click("Write the landmarks to a text file");
    let text = std::fs::read_to_string(desk.path("landmarks.txt")).unwrap();
    assert_eq!(chladni_match::read_landmarks(&text).unwrap(), changed);
    person.press_with(CTRL, Key::Z);
    person.press_with(CTRL, Key::Z);
    person.press_with(CTRL, Key::S);
    assert_eq!(landmarks("changed.chladni"), picked);
    desk.answers.add(desk.path("landmarks.txt"));
    person.click("Read landmarks from a text file");
    person.press_with(CTRL, Key::S);
    assert_eq!(landmarks("changed.chladni"), changed);
    person.press(Key::Escape);
    assert!(!person.sees("Landmarks on the template"));
}

#[test]
fn layers_are_named_hidden_soloed_and_moved_by_hand() {
    let desk = Desk::new();
    let mut person = desk.sit_down(&["shape.obj"]);
    person.wait_to_see("Layers");
    for template in ["Own size", "Ellipsoid"] {
        person.click_button("Add");
        person.click(template);
    }
    person.wait("the match", |window| !driving::shows(window, "Matching"));
    person.press(Key::F2);
    person.0.run_steps(2);
    person.press_with(CTRL, Key::A);
    person.0.event(egui::Event::Text("Round".into()));
    person.press(Key::Enter);
    assert!(person.sees("Layer Round"));
    let (top, below) = (person.place_of("Layer Round"), person.place_of("Layer Own size 1"));
    assert!(top.top() < below.top());
    let order =
        |person: &Person| person.place_of("Layer Round").top() < person.place_of("Layer Own size 1").top();
    person.drag(&[top.center(), top.center() + vec2(0.0, 20.0), below.center()]);
    assert!(!order(&person), "dragged below the other");
    person.press_with(CTRL, Key::Z);
    assert!(order(&person));

    // The eye and the headphones of the upper row, by the pointer.
    person.click_at(pos2(top.left() + 14.0, top.center().y));
    assert!(person.sees("Show this layer"));
    person.click_at(pos2(top.right() - 14.0, top.center().y));
    assert!(person.sees("Show the other layers again"));
    person.wait("its pictures", |_| true);
    person.0.run_steps(6);
    person.screenshot("studio-layers.png");
    person.press_with(CTRL, Key::D);
    assert!(person.sees("Layer Round copy"));
    person.press(Key::Delete);
    assert!(!person.sees("Layer Round copy"));
}

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
        let start = std::time::Instant::now();
        person.wait("the samples' pictures", |_| start.elapsed().as_secs() > 12);
    }
    person.screenshot("window-start.png");
    person.click("Open Caricature");
    person.wait_to_see("Covered");
    person.0.run_steps(4);
    person.screenshot("window-caricature.png");
    assert!(person.sees("harmonics") && person.sees("vertices"));

    // Around the nose, and a second layer that exaggerates it.
    person.click_button("Add");
    person.click("Own detail");
    person.press(Key::B);
    person.drag(&[pos2(455.0, 520.0), pos2(470.0, 500.0), pos2(490.0, 470.0), pos2(500.0, 440.0)]);
    person.screenshot("window-painting.png");
    person.press(Key::Escape);
    assert!(person.sees("Layer Own detail 2"));
    person.click_at(person.place_of("Layer Character").center());
    person.press(Key::V);
    person.0.run_steps(4);
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
    person.press(Key::L);
    person.wait_to_see("Landmarks on the template");
    person.wait_until_gone("Reading the template");
    let sides = ["Landmarks on the shape", "Landmarks on the template"].map(|name| person.place_of(name));
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

/// Layers are added, chosen, bent and hidden without the mouse, and what passes through itself is
/// counted and shown.
#[test]
fn the_keyboard_reaches_what_is_common_and_crossings_are_counted() {
    let desk = Desk::new();
    let mut person = desk.sit_down(&["shape.obj"]);
    person.wait_to_see("Compare with a mesh");
    desk.answers.add(desk.path("template.obj"));
    person.press_with(CTRL, Key::T);
    person.wait_to_see("Covered");
    person.wait_to_see("Nothing passes through itself");
    person.press(Key::Comma);
    person.press(Key::Comma);
    person.press(Key::Period);
    person.press(Key::M);
    desk.answers.add(desk.path("keys.chladni"));
    person.press_with(CTRL, Key::S);
    let saved = |desk: &Desk| Project::load(&desk.path("keys.chladni")).unwrap().layers()[0].1.clone();
    assert_eq!((saved(&desk).mu, saved(&desk).model), (-0.6, Model::Normal));

    // So far that it goes through itself, and back.
    person.0.get_all_by_role(egui::accesskit::Role::SpinButton).next().unwrap().click();
    person.0.run_steps(2);
    person.press_with(CTRL, Key::A);
    person.0.event(egui::Event::Text("-30".into()));
    person.press(Key::Enter);
    let amount = person.0.get_all_by_role(egui::accesskit::Role::SpinButton).next().unwrap();
    assert_eq!(amount.accesskit_node().numeric_value(), Some(-30.0), "beyond the slider's ends");
    person.wait_to_see("crossing triangles");
    person.click_button("crossing triangles");
    person.0.run_steps(2);
    person.screenshot("studio-crossings.png");
    assert!(person.sees("folded triangles"));
    person.press(Key::F);
    person.wait_to_see("No folds");

    person.press_with(CTRL, Key::D);
    person.press(Key::H);
    person.press(Key::PageDown);
    person.press(Key::I);
    person.press_with(CTRL, Key::S);
    let layers = Project::load(&desk.path("keys.chladni")).unwrap().layers().to_vec();
    assert!(layers[0].1.enabled && !layers[1].1.enabled);
    let nowhere = Painted::Vertices(vec![0.0; 642].into());
    assert_eq!((&layers[0].1.region.painted, &layers[1].1.region.painted), (&nowhere, &Painted::Everywhere));
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

/// The file window on a folder with two meshes and another in a folder of its own, and its answer.
fn file_window(desk: &Desk, purpose: Purpose) -> (Harness<'static, FileWindow>, Rc<RefCell<Vec<PathBuf>>>) {
    std::fs::create_dir(desk.path("sculptures")).unwrap();
    std::fs::copy(desk.path("shape.obj"), desk.path("sculptures/bust.obj")).unwrap();
    let answer = Rc::new(RefCell::new(Vec::new()));
    let given = answer.clone();
    let kinds = vec![("Meshes".to_owned(), vec!["obj".to_owned()])];
    let request = Request { purpose, kinds, start: desk.folder.path().to_owned() };
    let mut window = Harness::builder().with_size([640.0, 520.0]).wgpu().build_eframe(move |creation| {
        FileWindow::new(&creation.egui_ctx, request, &Settings::default(), given)
    });
    window.run_steps(3);
    (window, answer)
}

/// Clicks the line called `name`, after its icon.
fn click_line(window: &mut Harness<'_, FileWindow>, name: &str, modifiers: Modifiers) {
    window.query_all_by_label_contains(name).next().unwrap().click_modifiers(modifiers);
    window.run_steps(6);
}

fn type_text(window: &mut Harness<'_, FileWindow>, text: &str) {
    window.key_press_modifiers(CTRL, Key::A);
    window.event(egui::Event::Text(text.into()));
    window.run_steps(2);
}

/// The file window that comes where the system has none: a path is typed, completed, and chosen.
#[test]
fn a_path_is_typed_where_the_system_has_no_file_dialog() {
    let desk = Desk::new();
    let (mut window, answer) = file_window(&desk, Purpose::Open);
    assert!(window.query_all_by_label_contains("shape.obj").next().is_some());
    assert!(window.query_all_by_label_contains("settings.toml").next().is_none());
    type_text(&mut window, "nothing");
    window.key_press(Key::Enter);
    window.run_steps(2);
    assert!(window.query_all_by_label_contains("is not there").next().is_some());
    type_text(&mut window, "scu");
    window.key_press(Key::Tab);
    window.run_steps(2);
    window.key_press(Key::Enter);
    window.run_steps(3);
    if let Some(folder) = std::env::var_os("CHLADNI_SCREENSHOTS") {
        window.render().unwrap().save(std::path::Path::new(&folder).join("studio-files.png")).unwrap();
    }
    click_line(&mut window, "bust.obj", Modifiers::NONE);
    window.key_press(Key::Enter);
    window.run_steps(2);
    assert_eq!(*answer.borrow(), [desk.path("sculptures/bust.obj")]);
}

#[test]
fn what_is_typed_after_files_were_picked_counts_and_enter_on_cancel_is_no_answer() {
    let desk = Desk::new();
    let (mut window, answer) = file_window(&desk, Purpose::OpenSeveral);
    click_line(&mut window, "shape.obj", Modifiers::NONE);
    click_line(&mut window, "template.obj", CTRL);
    assert_eq!(window.get_by_label("File name or path").value().as_deref(), Some("2 files"));
    window.get_by_label("Cancel").focus();
    window.run_steps(2);
    window.key_press(Key::Enter);
    window.run_steps(2);
    assert!(answer.borrow().is_empty());

    window.get_by_label("File name or path").click();
    window.run_steps(2);
    type_text(&mut window, "sculptures/bust.obj");
    window.key_press(Key::Enter);
    window.run_steps(2);
    assert_eq!(*answer.borrow(), [desk.path("sculptures/bust.obj")]);
}

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
            person.click_button("Add");
            person.click("Own size");
            person.click_button("Add");
            person.click("Ellipsoid");
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
        // What is scrolled away can be scrolled to.
        let scrolled = rect.top() > size[1] - 60.0 && size[1] < 700.0;
        assert!(scrolled || window.contains_rect(rect), "{screen}: “{label}” at {rect:?}");
    }
}
