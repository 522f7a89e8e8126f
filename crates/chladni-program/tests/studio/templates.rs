//! Templates set by hand: those without a mesh, and matches that are not trusted everywhere.

use chladni_caricature::{LayerId, Project, ScaleCurve, Template};
use chladni_match::Scaling;
use chladni_mesh::{load_mesh, save_mesh};
use egui::{Key, Pos2, pos2, vec2};
use egui_kittest::kittest::Queryable;

use crate::CTRL;
use crate::driving;
use crate::driving::person::{Desk, Person, differing};

/// The layers as they are saved now.
fn saved(desk: &Desk, person: &mut Person) -> Vec<chladni_caricature::Layer> {
    let path = desk.path("saved.chladni");
    if !path.exists() {
        desk.answers.add(path.clone());
    }
    person.press_with(CTRL, Key::S);
    Project::load(&path).unwrap().layers().iter().map(|(_, layer)| (**layer).clone()).collect()
}

/// Types `text` into the field that is known as `id`.
fn fill(person: &mut Person, id: &str, text: &str) {
    person.click(id);
    person.0.run_steps(2);
    person.press_with(CTRL, Key::A);
    person.0.event(egui::Event::Text(text.into()));
    person.press(Key::Enter);
    person.0.run_steps(2);
}

#[test]
fn a_mesh_that_is_dropped_while_the_shape_still_opens_is_its_template() {
    let desk = Desk::new();
    let mut person = desk.sit_down(&["shape.obj"]);
    person.drop_files(&[desk.path("template.obj")]);
    person.wait_to_see("Covered");
    let layers = saved(&desk, &mut person);
    assert!(layers[0].template.is_mesh() && layers.len() == 1, "{layers:?}");
}

#[test]
fn files_that_are_held_over_the_window_say_what_their_drop_does() {
    let desk = Desk::new();
    let mut person = desk.sit_down(&["shape.obj"]);
    person.wait_to_see("Layers");
    let mut hold = |names: &[&str]| {
        let held = |name: &&str| egui::HoveredFile { path: Some(desk.path(name)), ..Default::default() };
        person.0.input_mut().hovered_files = names.iter().map(held).collect();
        person.0.run_steps(2);
        ["Compare with template.obj", "Open template.obj, and compare it with shape.obj"]
            .map(|text| person.sees(text))
    };
    assert_eq!(hold(&["template.obj"]), [true, false]);
    assert_eq!(hold(&["template.obj", "shape.obj"]), [false, true]);
    assert_eq!(hold(&[]), [false, false]);
}

#[test]
fn ellipsoids_are_given_by_numbers_and_all_is_magnified_against_oneself_scaled_or_smoothed() {
    let desk = Desk::new();
    let mut person = desk.with_layers(&["ellipsoid"]);
    person.wait("the match", |window| !driving::shows(window, "Matching"));
    person.click("ellipsoid-by-hand");
    fill(&mut person, "semi-axes/x", "2.5");
    fill(&mut person, "turn/z", "30");
    person.wait("the match", |window| !driving::shows(window, "Matching"));
    person.0.run_steps(2);
    person.screenshot("studio-given.png");
    let layers = saved(&desk, &mut person);
    let Template::Given(given) = &layers[0].template else { panic!("{:?}", layers[0].template) };
    assert_eq!((given.semi_axes[0], given.turn_deg[2]), (2.5, 30.0));
    assert!(given.semi_axes[1] > 2.0 && given.semi_axes[1] != 2.5);
    person.click("ellipsoid-fit");
    assert_eq!(saved(&desk, &mut person)[0].template, Template::Ellipsoid);

    person.add_layer("magnify");
    assert_eq!(saved(&desk, &mut person)[1].template, Template::Scaled(0.9));
    person.slide("Scale", 0.5);
    assert_eq!(saved(&desk, &mut person)[1].template, Template::Scaled(0.5));
    person.click("itself/smoothed");
    person.slide("Low-pass", 12.0);
    assert_eq!(saved(&desk, &mut person)[1].template, Template::LowPass(12));
    assert!(person.sees("What grows has waves of"));
    person.screenshot("studio-magnify.png");
}

#[test]
fn a_template_is_taken_from_the_shelf_by_its_picture() {
    let desk = Desk::new();
    let mut person = desk.sit_down(&["shape.obj"]);
    person.wait_to_see("Layers");
    // Without a layer it becomes one; then it takes the place of that one's template.
    person.click("shelf");
    person.wait("the first picture", |window| driving::shows(window, "Compare with Ring"));
    person.click("shelf/ring");
    person.wait("the match", |window| !driving::shows(window, "Matching"));
    let layers = saved(&desk, &mut person);
    assert_eq!((layers.len(), &layers[0].name[..]), (1, "Ring"));
    assert_eq!(layers[0].template, Template::Sample("ring".into()));
    person.click("shelf");
    person.screenshot("studio-shelf.png");
    person.click("shelf/bell");
    person.wait("the match", |window| !driving::shows(window, "Matching"));
    let layers = saved(&desk, &mut person);
    assert_eq!(layers.len(), 1);
    assert_eq!(layers[0].template, Template::Sample("bell".into()));
    // Its ghost is bluish, and gone when it is sent away.
    let mut haunt = || {
        person.click("ghost");
        person.0.run_steps(4);
        person.0.render().unwrap().pixels().filter(|p| p[2] > p[0].saturating_add(15)).count()
    };
    let (with, without, again) = (haunt(), haunt(), haunt());
    assert!(with > without + 2000 && again > without + 2000, "{with} {without} {again}");
    person.screenshot("studio-ghost.png");
}

#[test]
fn what_came_after_a_layer_is_magnified_and_the_layer_cannot_be_deleted_meanwhile() {
    let desk = Desk::new();
    let mut person = desk.sit_down(&["shape.obj"]);
    person.wait_to_see("Layers");
    for (add, layers) in [("template/ellipsoid", 1), ("template/own-detail", 2)] {
        person.click("add");
        person.click(add);
        person.wait("the match", |window| !driving::shows(window, "Matching"));
        assert_eq!(saved(&desk, &mut person).len(), layers);
    }
    person.click("add");
    person.click("result");
    person.0.run_steps(4);
    person.screenshot("studio-result-of-layer.png");
    person.click("result/1");
    person.0.run_steps(4);
    let layers = saved(&desk, &mut person);
    assert_eq!(
        (&layers[2].name[..], &layers[2].template),
        ("Since Ellipsoid 1", &Template::Layer(LayerId(1)))
    );
    // The layer below has to stay.
    person.click("layer/1");
    person.press(Key::Delete);
    assert!(person.sees("layer Since Ellipsoid 1 is compared with the result of layer Ellipsoid 1"));
    assert_eq!(saved(&desk, &mut person), layers);
    person.click("layer/3");
    person.click("below");
    person.screenshot("studio-shape-below.png");
    person.click("below/2");
    assert_eq!(saved(&desk, &mut person)[2].template, Template::Layer(LayerId(2)));
}

#[test]
fn the_place_under_the_pointer_is_marked_on_the_template_beside_the_shape_and_back() {
    let desk = Desk::new();
    let mut person = desk.sit_down(&["shape.obj"]);
    person.wait_to_see("Layers");
    for _ in 0..3 {
        person.press(Key::V);
    }
    assert!(!person.sees("Layer "), "no layer, no template: the result stands alone");
    person.add_layer("ellipsoid");
    person.wait("the match", |window| !driving::shows(window, "Matching"));
    person.click("colors");
    person.click("colors/place");
    let stage = person.place_of("view");
    person.press(Key::Home);
    let middle = stage.center().x;
    // The pixels that change in the half of the picture without the pointer: their middle is that of the mark.
    let halves = [stage.with_max_x(middle - 1.0), stage.with_min_x(middle)];
    let mut opposite = |at: Pos2| {
        let mark = person.what_changes(halves[usize::from(at.x < middle)], pos2(middle, 20.0), at);
        assert!((20..250).contains(&mark.len()), "{} pixels", mark.len());
        (mark.iter().fold(vec2(0.0, 0.0), |sum, p| sum + *p) / mark.len() as f32).to_pos2()
    };
    let left = pos2(stage.left() + 0.25 * stage.width(), stage.center().y);
    for on_shape in [left, left + vec2(30.0, -20.0), left + vec2(-60.0, 20.0)] {
        let on_template = opposite(on_shape);
        let back = opposite(on_template);
        assert!((back - on_shape).length() < 2.0, "{on_shape:?}, {on_template:?}, {back:?}");
    }
    person.screenshot("studio-template-beside.png");
}

#[test]
fn a_cut_template_is_filled_in_as_far_as_asked_and_may_keep_its_size() {
    let desk = Desk::new();
    let mut cut = load_mesh(&desk.path("template.obj")).unwrap().mesh;
    let positions = cut.positions.clone();
    cut.triangles.retain(|t| t.iter().all(|v| positions[*v as usize][1] > -2.0));
    save_mesh(&cut, &desk.path("cut.obj")).unwrap();
    let mut person = desk.sit_down(&["shape.obj", "cut.obj"]);
    person.wait_to_see("of it is not trusted");
    person.click("trust");
    person.0.run_steps(3);
    person.screenshot("studio-infill.png");
    assert_eq!(saved(&desk, &mut person)[0].infill, 1.0);
    person.slide("Fill in", 0.25);
    assert_eq!(saved(&desk, &mut person)[0].infill, 0.25);
    person.click("fit-size");
    assert_eq!(saved(&desk, &mut person)[0].matching.scaling, Scaling::Rigid);
    person.wait("the match", |window| !driving::shows(window, "Matching"));
}

#[test]
fn another_number_of_harmonics_leaves_curve_and_match_as_they_are() {
    let desk = Desk::new();
    let mut person = desk.sit_down(&["shape.obj", "template.obj"]);
    person.wait_to_see("Covered");
    person.click("curve/mid");
    let plot = person.place_of("scale-curve");
    person.drag(&[plot.center() + vec2(-30.0, -10.0), plot.center() + vec2(-34.0, -40.0)]);
    let before = saved(&desk, &mut person)[0].clone();
    assert!(before.curve != ScaleCurve::mid() && before.curve.points.len() >= 5, "it was bent");
    person.screenshot("studio-curve.png");
    person.click("harmonics");
    person.click("harmonics/128");
    person.0.run_steps(2);
    person.wait("the harmonics", |window| {
        assert!(!driving::shows(window, "Matching"), "the match is made anew");
        !driving::shows(window, "Solving")
    });
    person.wait_to_see("Covered");
    person.screenshot("studio-curve-128.png");
    assert_eq!(saved(&desk, &mut person)[0], before);
}

#[test]
fn each_click_on_the_curve_is_a_step_and_a_name_is_undone_by_itself() {
    let desk = Desk::new();
    let mut person = desk.sit_down(&["shape.obj", "template.obj"]);
    person.wait_to_see("Covered");
    let points = |person: &mut Person| saved(&desk, person)[0].curve.points.len();
    let before = points(&mut person);
    let plot = person.place_of("scale-curve");
    for x in [-60.0, 20.0] {
        person.click_at(plot.center() + vec2(x, -20.0));
        person.0.run_steps(2);
    }
    assert_eq!(points(&mut person), before + 2);
    person.press_with(CTRL, Key::Z);
    assert_eq!(points(&mut person), before + 1, "one click was taken back");

    // While a name is written, undo is that of its letters.
    person.press(Key::F2);
    person.0.run_steps(2);
    person.0.event(egui::Event::Text("Nose".into()));
    person.0.run_steps(2);
    person.press_with(CTRL, Key::Z);
    person.press(Key::Enter);
    assert_eq!(points(&mut person), before + 1, "the project was left alone");
}

#[test]
fn a_cancelled_solve_is_not_asked_for_again() {
    let desk = Desk::new();
    let mut person = desk.sit_down(&["shape.obj", "template.obj"]);
    person.wait_to_see("Covered");
    let path = desk.path("solved.chladni");
    let harmonics = |person: &mut Person| {
        desk.answers.add(&path);
        person.press_with(CTRL | egui::Modifiers::SHIFT, Key::S);
        Project::load(&path).unwrap().harmonics
    };
    let before = harmonics(&mut person);
    person.click("harmonics");
    // Cancelled in the frame in which it begins.
    person.click("harmonics/512");
    let cancel = person.0.query_by_label("Cancel").map(|button| button.click());
    person.0.run_steps(2);
    person.wait("its end", |window| !driving::shows(window, "Solving"));
    person.0.run_steps(3);
    let solved = driving::shows(&person.0, "512 harmonics");
    assert_eq!(harmonics(&mut person), if solved { 512 } else { before }, "cancelled: {cancel:?}");
}

#[test]
fn the_camera_comes_forward_again_when_an_exaggeration_is_undone() {
    let desk = Desk::new();
    let mut person = desk.with_layers(&["ellipsoid"]);
    person.wait_to_see("No folds");
    person.slide("μ", -0.5);
    person.0.run_steps(5);
    let area = egui::Rect::from_min_size(pos2(500.0, 200.0), vec2(300.0, 400.0));
    let middle = |person: &mut Person| person.picture_of(area);
    let before = middle(&mut person);
    person.slide("μ", -40.0);
    person.0.run_steps(5);
    // Of 120,000 pixels.
    assert!(differing(&middle(&mut person), &before) > 20_000);
    person.press_with(CTRL, Key::Z);
    person.0.run_steps(10);
    let far = differing(&middle(&mut person), &before);
    assert!(far < 1000, "it stays far away: {far}");
}

#[test]
fn nothing_is_said_of_folds_and_crossings_before_the_layer_acts() {
    let desk = Desk::new();
    let mut person = desk.sit_down(&["shape.obj", "template.obj"]);
    person.wait("the match", |window| {
        let counts = ["No folds", "Nothing passes"].map(|text| driving::shows(window, text));
        assert!(!driving::shows(window, "Matching") || counts == [false; 2], "nothing is matched yet");
        driving::shows(window, "Covered")
    });
    person.wait_to_see("No folds");
}

#[test]
fn a_layer_without_its_template_says_so() {
    let desk = Desk::new();
    let mut person = desk.sit_down(&["shape.obj", "missing.obj"]);
    person.wait_to_see("Has no template");
    assert!(!person.sees("No folds"));
    person.screenshot("studio-no-template.png");
}
