//! Layers and landmarks, by hand and by keys.

use chladni_caricature::{Model, Painted, Project};
use chladni_mesh::save_mesh;
use egui::{Key, Modifiers, Pos2, pos2, vec2};
use egui_kittest::kittest::{NodeT, Queryable};

use crate::CTRL;
use crate::driving;
use crate::driving::person::{Desk, Person, differing, finer_lump};

#[test]
fn landmarks_are_picked_on_a_template_as_its_file_is_now() {
    let desk = Desk::new();
    let mut person = desk.sit_down(&["shape.obj", "template.obj"]);
    person.wait_to_see("Covered");
    save_mesh(&finer_lump(), &desk.path("template.obj")).unwrap();
    person.press(Key::L);
    person.wait_to_see("is another file now");
    person.wait_to_see("Landmarks on the template");
}

#[test]
fn landmarks_are_picked_moved_removed_saved_and_read() {
    let desk = Desk::new();
    let mut person = desk.sit_down(&["shape.obj", "template.obj"]);
    person.wait_to_see("Covered");
    person.press(Key::L);
    person.wait_to_see("Landmarks on the template");
    let (left, right) = (person.place_of("landmarks/shape"), person.place_of("landmarks/template"));
    person.wait_to_see("Click a place on the shape");
    person.wait_until_gone("Reading the template");
    let places = [(0.0, 0.0), (0.1, -0.07), (-0.1, 0.07), (0.12, 0.05)];
    for (x, y) in places {
        for side in [left, right] {
            person.click_at(side.center() + vec2(x * side.width(), y * side.height()));
        }
    }
    person.wait_to_see("The match follows");
    person.wait("the new match", |window| !driving::shows(window, "Matching"));
    // The place under the pointer is marked on the other shape, from either side.
    let away = pos2(left.center().x, 10.0);
    let mut across = |side: egui::Rect, at: Pos2| {
        let mark = person.what_changes(side, away, at);
        assert!((20..250).contains(&mark.len()), "{} pixels", mark.len());
        (mark.iter().fold(vec2(0.0, 0.0), |sum, p| sum + *p) / mark.len() as f32).to_pos2()
    };
    let at = left.center() + vec2(40.0, 30.0);
    let there = across(right, at);
    let back = across(left, there);
    assert!((back - at).length() < 0.05 * left.width(), "{at:?}, {there:?}, {back:?}");
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
    let dot = left.min + drawn_at(&desk.path("shape.obj"), picked[0].shape, left.size());
    person.drag(&[dot, dot + vec2(20.0, 10.0), dot + vec2(60.0, 40.0)]);
    person.screenshot("studio-dragged.png");
    person.click("landmark-remove/2");
    person.screenshot("studio-removed.png");
    desk.answers.add(desk.path("changed.chladni"));
    person.press_with(CTRL | Modifiers::SHIFT, Key::S);
    let changed = landmarks("changed.chladni");
    assert_eq!(changed.len(), places.len() - 1);
    assert_ne!(changed[0].shape, picked[0].shape);
    assert_eq!((changed[0].template, &changed[1..]), (picked[0].template, &picked[2..]));

    desk.answers.add(desk.path("landmarks 1.2"));
    person.click("landmarks-save");
    assert!(desk.path("landmarks 1.2.txt").exists() && !desk.path("landmarks 1.2").exists());
    desk.answers.add(desk.path("landmarks.txt"));
    person.click("landmarks-save");
    let text = std::fs::read_to_string(desk.path("landmarks.txt")).unwrap();
    assert_eq!(chladni_match::read_landmarks(&text).unwrap(), changed);
    person.press_with(CTRL, Key::Z);
    person.press_with(CTRL, Key::Z);
    person.press_with(CTRL, Key::S);
    assert_eq!(landmarks("changed.chladni"), picked);
    desk.answers.add(desk.path("landmarks.txt"));
    person.click("landmarks-open");
    person.press_with(CTRL, Key::S);
    assert_eq!(landmarks("changed.chladni"), changed);
    person.press(Key::Escape);
    assert!(!person.sees("Landmarks on the template"));
}

/// Where a pane of this size draws a vertex of a mesh that fills it, seen from the front.
fn drawn_at(mesh: &std::path::Path, vertex: u32, size: egui::Vec2) -> egui::Vec2 {
    use chladni_mesh::{Estimate, Frame, Known};
    use chladni_view::{Camera, Rect, View};
    let mesh = chladni_mesh::load_mesh(mesh).unwrap().mesh;
    let stands = Estimate::of(&mesh, Known::default(), &chladni_task::Task::new()).unwrap().orientation;
    let frame = Frame::of(&mesh);
    let points: Vec<[f32; 3]> =
        mesh.positions.iter().map(|p| frame.to_working(*p).map(|c| c as f32)).collect();
    let mut camera = Camera::on(stands, View::Front);
    let pane = Rect::of_size(size.x as u32, size.y as u32);
    camera.fit(points.iter().copied(), pane.aspect(), 0.82);
    let ([x, y], _) = camera.project(points[vertex as usize], pane).unwrap();
    vec2(x, y)
}

#[test]
fn picking_ends_where_another_shape_takes_the_place_of_the_one_picked_on() {
    let desk = Desk::new();
    let mut person = desk.sit_down(&["shape.obj", "template.obj"]);
    person.wait_to_see("Covered");
    person.press(Key::L);
    person.wait_to_see("Landmarks on the template");
    save_mesh(&finer_lump(), &desk.path("finer.obj")).unwrap();
    desk.answers.add(desk.path("finer.obj"));
    person.click("another-shape");
    // The layer is not saved anywhere.
    person.click("lose-changes");
    person.wait_to_see("2\u{202f}562 vertices");
    assert!(!person.sees("Landmarks on the shape"), "the old shape is still picked on");
    person.press(Key::L);
    person.wait_to_see("Landmarks on the shape");
}

#[test]
fn half_a_landmark_is_taken_back_before_the_pair_that_is_finished() {
    let desk = Desk::new();
    let mut person = desk.sit_down(&["shape.obj", "template.obj"]);
    person.wait_to_see("Covered");
    person.press(Key::L);
    person.wait_to_see("Landmarks on the template");
    person.wait_until_gone("Reading the template");
    let sides = ["landmarks/shape", "landmarks/template"].map(|id| person.place_of(id).center());
    for side in sides {
        person.click_at(side);
    }
    person.wait_to_see("2 more, and the landmarks lead");
    for by_key in [true, false] {
        person.click_at(sides[0] + vec2(40.0, 30.0));
        person.wait_to_see("Now click the same place on the template");
        if by_key {
            person.press_with(CTRL, Key::Z);
        } else {
            person.click("undo");
        }
        person.wait_to_see("2 more, and the landmarks lead");
    }
    person.press_with(CTRL, Key::Z);
    person.wait_to_see("Click a place on the shape");
}

#[test]
fn what_is_typed_moves_no_camera_of_the_landmarks() {
    let desk = Desk::new();
    let mut person = desk.sit_down(&["shape.obj", "template.obj"]);
    person.wait_to_see("Covered");
    person.press(Key::L);
    person.wait_until_gone("Reading the template");
    let side = person.place_of("landmarks/shape");
    person.0.hover_at(side.center());
    person.0.run_steps(20);
    let seen = |person: &mut Person| person.picture_of(side.shrink2(vec2(0.0, 40.0)));
    let fitted = seen(&mut person);
    person.0.event(egui::Event::MouseWheel {
        unit: egui::MouseWheelUnit::Point,
        source: egui::MouseWheelSource::Wheel,
        delta: vec2(0.0, -400.0),
        phase: egui::TouchPhase::Move,
        modifiers: Modifiers::NONE,
    });
    person.0.run_steps(20);
    person.press(Key::F2);
    person.0.run_steps(2);
    let zoomed = seen(&mut person);
    let far = differing(&zoomed, &fitted);
    assert!(far > 3000, "{far}");
    person.press(Key::F);
    person.press(Key::Home);
    assert!(differing(&seen(&mut person), &zoomed) < 500);
    person.press(Key::Enter);
    person.press(Key::F);
    person.0.run_steps(2);
    person.screenshot("studio-landmarks-fitted.png");
    let near = differing(&seen(&mut person), &fitted);
    assert!(near < 500, "{near}");
}

#[test]
fn the_first_stroke_of_a_brush_is_one_step() {
    let desk = Desk::new();
    let mut person = desk.with_layers(&["magnify"]);
    person.press(Key::B);
    let middle = pos2(620.0, 420.0);
    person.drag(&[middle, middle + vec2(10.0, 0.0), middle + vec2(20.0, 0.0)]);
    desk.answers.add(desk.path("painted.chladni"));
    person.press_with(CTRL, Key::S);
    let painted = || {
        let project = Project::load(&desk.path("painted.chladni")).unwrap();
        project.layers()[0].1.region.painted.clone()
    };
    let Painted::Vertices(values) = painted() else { panic!("nothing was painted") };
    let inside = values.iter().filter(|x| **x > 0.0).count();
    assert!(inside > 3 && inside < 300, "{inside}");
    person.press_with(CTRL, Key::Z);
    person.press_with(CTRL, Key::S);
    assert_eq!(painted(), Painted::Everywhere);
}

/// Begins a stroke that `ends` at this place before it is finished, and paints another where the work `goes_on`: each is a
/// step of its own.
fn check_strokes_are_steps(ends: impl FnOnce(&mut Person, Pos2), goes_on: impl FnOnce(&mut Person)) {
    let desk = Desk::new();
    let mut person = desk.with_layers(&["magnify"]);
    person.press(Key::B);
    let (left, right) = (pos2(580.0, 420.0), pos2(680.0, 420.0));
    let end = left + vec2(10.0, 0.0);
    person.hold(&[left, end]);
    ends(&mut person, end);
    let first = painted(&desk, &mut person);
    assert!(inside(&first) > 3);
    goes_on(&mut person);
    person.drag(&[right, right + vec2(10.0, 0.0)]);
    assert!(inside(&painted(&desk, &mut person)) > inside(&first));
    person.press_with(CTRL, Key::Z);
    assert_eq!(painted(&desk, &mut person), first);
}

#[test]
fn a_stroke_that_a_key_ends_is_a_step_of_its_own() {
    let put_away = |person: &mut Person, at| {
        // Before the button is released.
        person.press(Key::B);
        person.release(at);
    };
    check_strokes_are_steps(put_away, |person| person.press(Key::B));
}

#[test]
fn a_stroke_that_ends_outside_the_room_is_a_step_of_its_own() {
    let left = |person: &mut Person, at| {
        // Without the pointer, whose button is released elsewhere.
        person.0.get_by_role_and_label(egui::accesskit::Role::Button, "Chladni").click_accesskit();
        person.0.run_steps(2);
        person.release(at);
        driving::control(&person.0, "room/0").click_accesskit();
        person.0.run_steps(2);
    };
    check_strokes_are_steps(left, |_| ());
}

#[test]
fn a_soft_brush_leaves_a_soft_edge_and_is_remembered() {
    let desk = Desk::new();
    save_mesh(&finer_lump(), &desk.path("finer.obj")).unwrap();
    let mut person = desk.sit_down(&["finer.obj"]);
    person.wait_to_see("Layers");
    person.add_layer("magnify");
    person.press(Key::B);
    let middle = pos2(620.0, 420.0);
    person.slide("Size", 0.5);
    person.click_at(middle);
    let hard = painted(&desk, &mut person);
    person.press_with(CTRL, Key::Z);
    let hardness = |person: &Person| {
        let slider = person.0.get_by_role_and_label(egui::accesskit::Role::Slider, "Hardness");
        slider.accesskit_node().numeric_value()
    };
    assert_eq!(hardness(&person), Some(1.0));
    person.slide("Hardness", 0.25);
    // Put away and taken again.
    person.press(Key::B);
    person.press(Key::B);
    assert_eq!(hardness(&person), Some(0.25));
    person.click_at(middle);
    person.screenshot("studio-soft-brush.png");
    let soft = painted(&desk, &mut person);
    let (Painted::Vertices(hard), Painted::Vertices(soft)) = (hard, soft) else { panic!("nothing painted") };
    assert!(hard.iter().all(|x| *x == 0.0 || *x == 1.0));
    // Nowhere more, in the middle as much, and in between at the edge.
    assert!(hard.iter().zip(&*soft).all(|(hard, soft)| soft <= hard));
    let between = soft.iter().filter(|x| **x > 0.0 && **x < 1.0).count();
    let full = soft.iter().filter(|x| **x == 1.0).count();
    assert!(between > 10 && full > 3, "{between} between, {full} in full");
}

#[test]
fn a_mirrored_stroke_paints_both_sides_and_says_how_well_they_match() {
    let desk = Desk::new();
    let head = chladni_mesh::samples::sample("head").unwrap();
    save_mesh(&head, &desk.path("head.obj")).unwrap();
    let mut person = desk.sit_down(&["head.obj"]);
    person.wait_to_see("Layers");
    person.add_layer("magnify");
    person.press(Key::B);
    assert!(!person.sees("mirror image misses"));
    person.click("mirror");
    person.wait_to_see("Its mirror image misses the shape by 0.0");
    // Beside the nose, on one side of it.
    let cheek = pos2(560.0, 430.0);
    person.drag(&[cheek, cheek + vec2(10.0, 4.0)]);
    person.screenshot("studio-mirrored.png");
    desk.answers.add(desk.path("painted.chladni"));
    person.press_with(CTRL, Key::S);
    let project = Project::load(&desk.path("painted.chladni")).unwrap();
    let Painted::Vertices(painted) = &project.layers()[0].1.region.painted else { panic!("nothing painted") };
    let painted_x = painted.iter().zip(&head.positions).filter(|(chi, _)| **chi > 0.0).map(|(_, p)| p[0]);
    let (left, right): (Vec<f64>, Vec<f64>) = painted_x.partition(|x| *x < 0.0);
    assert!(left.len() > 5 && left.len().abs_diff(right.len()) <= 1 + left.len() / 5, "{left:?} {right:?}");
    let inner = |x: &[f64]| x.iter().map(|x| x.abs()).sum::<f64>() / x.len() as f64;
    assert!((inner(&left) - inner(&right)).abs() < 0.1 * inner(&left));
}

/// However quick the hand or slow the frames.
#[test]
fn a_quick_stroke_of_a_small_brush_has_no_gaps() {
    let desk = Desk::new();
    save_mesh(&finer_lump(), &desk.path("finer.obj")).unwrap();
    let mut person = desk.sit_down(&["finer.obj"]);
    person.wait_to_see("Layers");
    person.add_layer("magnify");
    person.press(Key::B);
    (0..6).for_each(|_| person.press(Key::OpenBracket));
    let (left, right) = (pos2(540.0, 420.0), pos2(740.0, 430.0));
    person.drag(&[left, right]);
    desk.answers.add(desk.path("painted.chladni"));
    person.press_with(CTRL, Key::S);
    let project = Project::load(&desk.path("painted.chladni")).unwrap();
    let Painted::Vertices(painted) = &project.layers()[0].1.region.painted else { panic!("nothing painted") };
    let neighbors = chladni_mesh::vertex_neighbors(painted.len(), &finer_lump().triangles);
    let mut left_over: Vec<bool> = painted.iter().map(|x| *x > 0.0).collect();
    let mut pieces = Vec::new();
    while let Some(first) = left_over.iter().position(|there| *there) {
        let (mut size, mut next) = (0, vec![first]);
        while let Some(v) = next.pop() {
            if std::mem::take(&mut left_over[v]) {
                size += 1;
                next.extend(neighbors.row(v).iter().map(|w| *w as usize));
            }
        }
        pieces.push(size);
    }
    assert!(pieces.len() == 1 && pieces[0] > 15, "{pieces:?}");
}

#[test]
fn layers_are_named_hidden_soloed_and_moved_by_hand() {
    let desk = Desk::new();
    let mut person = desk.sit_down(&["shape.obj"]);
    person.wait_to_see("Layers");
    for template in ["template/magnify", "template/ellipsoid"] {
        person.click("add");
        person.click(template);
    }
    person.wait("the match", |window| !driving::shows(window, "Matching"));
    person.press(Key::F2);
    person.0.run_steps(2);
    person.0.event(egui::Event::Text("Round".into()));
    person.press(Key::Enter);
    assert!(person.sees("Layer Round"));
    let (top, below) = (person.place_of("layer/2"), person.place_of("layer/1"));
    assert!(top.top() < below.top());
    let order = |person: &Person| person.place_of("layer/2").top() < person.place_of("layer/1").top();
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

#[test]
fn a_click_that_ends_a_name_saves_it_or_takes_it_back() {
    let desk = Desk::new();
    let mut person = desk.with_layers(&["magnify"]);
    rename(&mut person, "Nose");
    person.click("undo");
    assert!(person.sees("Layer Magnify all 1"));
    let path = desk.path("named.chladni");
    desk.answers.add(&path);
    rename(&mut person, "Chin");
    person.click("save");
    assert_eq!(Project::load(&path).unwrap().layers()[0].1.name, "Chin");
}

#[test]
fn what_ends_a_name_by_a_key_or_beside_the_list_has_it() {
    let desk = Desk::new();
    let mut person = desk.with_layers(&["magnify"]);
    let click = |person: &mut Person, tip: &str| {
        let button = person.0.query_all_by_label_contains(tip).next().unwrap();
        button.click();
        person.0.run_steps(3);
    };
    let path = desk.path("named.chladni");
    desk.answers.add(&path);
    rename(&mut person, "Nose");
    person.press_with(CTRL, Key::S);
    assert_eq!(Project::load(&path).unwrap().layers()[0].1.name, "Nose");
    rename(&mut person, "Chin");
    click(&mut person, "Duplicate the layer");
    assert!(person.sees("Layer Chin copy") && !person.sees("Layer Nose"));
    rename(&mut person, "Ear");
    click(&mut person, "Delete the layer");
    assert!(!person.sees("there is no layer") && !person.sees("Layer Ear") && person.sees("Layer Chin"));
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
    person.click("crossings");
    person.0.run_steps(2);
    person.screenshot("studio-crossings.png");
    assert!(person.sees("folded triangles"));
    person.press(Key::E);
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

/// Types another name for the chosen layer, and does not end it yet.
fn rename(person: &mut Person, name: &str) {
    person.press(Key::F2);
    person.0.run_steps(2);
    person.press_with(CTRL, Key::A);
    person.0.event(egui::Event::Text(name.into()));
    person.0.run_steps(2);
}

/// χ01 of the only layer, as the project is saved now.
fn painted(desk: &Desk, person: &mut Person) -> Painted {
    desk.answers.add(desk.path("saved.chladni"));
    person.press_with(CTRL | Modifiers::SHIFT, Key::S);
    let project = Project::load(&desk.path("saved.chladni")).unwrap();
    project.layers()[0].1.region.painted.clone()
}

fn inside(painted: &Painted) -> usize {
    match painted {
        Painted::Vertices(values) => values.iter().filter(|x| **x > 0.0).count(),
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_layer_that_moves_nothing_is_not_said_to_never_fold() {
    let desk = Desk::new();
    let mut person = desk.with_layers(&["magnify"]);
    person.slide("μ", 0.0);
    person.press(Key::E);
    person.wait_to_see("Nothing moves at");
}

#[test]
fn what_is_encircled_is_painted_on_the_side_that_is_seen_and_undone_at_once() {
    let desk = Desk::new();
    let mut person = desk.with_layers(&["magnify"]);
    person.press(Key::B);
    person.click("lasso");
    let middle = pos2(620.0, 420.0);
    let around = |radius: f32| -> Vec<Pos2> {
        (0..24)
            .map(|i| middle + radius * egui::Vec2::angled(i as f32 * std::f32::consts::TAU / 24.0))
            .collect()
    };
    person.drag(&around(90.0));
    person.screenshot("studio-lasso.png");
    let wide = inside(&painted(&desk, &mut person));
    assert!(wide > 10 && wide < 321, "{wide} of 642, not what is behind");
    person.press(Key::X);
    person.drag(&around(45.0));
    let ring = inside(&painted(&desk, &mut person));
    assert!(ring < wide && ring > wide / 3, "{ring} of {wide}");
    person.press_with(CTRL, Key::Z);
    assert_eq!(inside(&painted(&desk, &mut person)), wide);
    person.press_with(CTRL, Key::Z);
    assert_eq!(painted(&desk, &mut person), Painted::Everywhere);
}

#[test]
fn a_region_comes_from_curvature_goes_to_a_file_and_comes_back() {
    let desk = Desk::new();
    let mut person = desk.with_layers(&["magnify"]);
    person.click("curvature");
    person.screenshot("studio-curvature.png");
    person.click("curvature/bumps");
    let bumps = painted(&desk, &mut person);
    assert!((60..200).contains(&inside(&bumps)), "{}", inside(&bumps));
    // A region never replaces the shape that it lies on.
    let shape = std::fs::read(desk.path("shape.obj")).unwrap();
    desk.answers.add(desk.path("shape.obj"));
    person.click("mask");
    person.click("mask/save");
    person.wait_to_see("would be replaced");
    assert!(std::fs::read(desk.path("shape.obj")).unwrap() == shape);
    desk.answers.add(desk.path("bumps 1.2"));
    person.click("mask");
    person.click("mask/save");
    person.wait_to_see("bumps 1.2.npy");
    desk.answers.add(desk.path("bumps.ply"));
    person.click("mask");
    person.screenshot("studio-mask.png");
    person.click("mask/save");
    person.wait_to_see("bumps.ply");
    person.press_with(CTRL, Key::Z);
    assert_eq!(painted(&desk, &mut person), Painted::Everywhere);
    desk.answers.add(desk.path("bumps.ply"));
    person.click("mask");
    person.click("mask/open");
    assert_eq!(painted(&desk, &mut person), bumps);
    // The menu stays open while its slider is set.
    person.click("curvature");
    let share = person.0.get_by_role_and_label(egui::accesskit::Role::Slider, "Share of the surface");
    let middle = share.rect().center();
    person.click_at(middle);
    person.click("curvature/bumps");
    assert!(inside(&painted(&desk, &mut person)) > inside(&bumps));
}

#[test]
fn buttons_of_layers_and_their_verdicts_are_hit_apart() {
    let desk = Desk::new();
    let mut person = desk.sit_down(&["shape.obj"]);
    person.wait_to_see("Compare with a mesh");
    person.add_layer("magnify");
    let verdicts = ["folds", "crossings"];
    person.wait("the verdicts", |window| verdicts.iter().all(|id| driving::is_there(window, id)));
    let labels = ["Delete the layer", "Duplicate the layer", "Hide this layer", "Only this layer"];
    let mut places = labels.map(|label| person.0.get_by_label_contains(label).rect()).to_vec();
    places.extend(verdicts.map(|id| person.place_of(id)));
    assert!(driving::are_hit_apart(&places), "{places:?}");
}
