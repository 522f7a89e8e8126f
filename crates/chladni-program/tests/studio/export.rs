//! From two meshes to layers, and on into another program.

use chladni_caricature::{Model, Painted, Project, ScaleCurve, ShapeSource, Stack};
use chladni_harmonics::{BasisSettings, Body};
use chladni_mesh::{load_mesh, save_mesh};
use chladni_task::Task;
use egui::{Key, Modifiers, pos2};
use egui_kittest::kittest::Queryable;

use crate::CTRL;
use crate::driving::person::{self, Desk, HARMONICS, Person};

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
    person.click("model/normal");
    person.click("curve/broad");
    person.bend_scale_curve();
    // Another layer, taken back, and done again.
    person.add_layer("magnify");
    assert!(person.sees("Magnify all 2"));
    person.press_with(CTRL, Key::Z);
    assert!(!person.sees("Magnify all 2"));
    person.press_with(CTRL | Modifiers::SHIFT, Key::Z);
    assert!(person.sees("Magnify all 2"));

    desk.answers.add(desk.path("p.chladni"));
    person.press_with(CTRL, Key::S);
    person.wait_to_see("Saved");
    person.screenshot("studio-saved.png");
    drop(person);

    let project = Project::load(&desk.path("p.chladni")).unwrap();
    let layers: Vec<_> = project.layers().iter().map(|(_, layer)| layer.as_ref()).collect();
    assert_eq!(layers.iter().map(|l| l.name.as_str()).collect::<Vec<_>>(), ["template", "Magnify all 2"]);
    assert_eq!(layers[0].model, Model::Normal);
    assert_ne!(layers[0].curve, ScaleCurve::broad(), "it was bent");
    let Painted::Vertices(painted) = &layers[0].region.painted else { panic!("nothing was painted") };
    let touched = painted.iter().filter(|x| **x > 0.0).count();
    assert!(touched > 3 && touched < painted.len() / 2, "{touched} of {}", painted.len());

    // The next day.
    let mut person = desk.sit_down(&["p.chladni"]);
    person.wait_to_see("Magnify all 2");
    let row = person.place_of("layer/1");
    person.click_at(row.center());
    person.wait_to_see("Covered");
    person.press_with(CTRL, Key::E);
    person.screenshot("studio-export.png");
    for name in ["out.glb", "out.png"] {
        if name == "out.png" {
            person.press_with(CTRL, Key::E);
            person.click("export/png");
            person.click("sizes");
            person.click("size/640x480");
        }
        // Where a picture's name does not end as one, the ending is added.
        desk.answers.add(desk.path(if name == "out.png" { "out" } else { name }));
        person.click("export-begin");
        // The file is there a moment before the window lets go of it.
        person.wait_to_see(&format!("Exported {}", desk.path(name).display()));
    }
    let header = std::fs::read(desk.path("out.png")).unwrap();
    assert_eq!(&header[16..24], &[0, 0, 2, 128, 0, 0, 1, 224], "640 × 480");
    assert_eq!(header[25], 6, "with transparency");
    sliders_reproduce_the_layers(&desk, &project);

    // The same layers on another shape: the region goes along.
    save_mesh(&person::finer_lump(), &desk.path("finer.obj")).unwrap();
    desk.answers.add(desk.path("finer.obj"));
    person.click("another-shape");
    // Undo does not lead back: that is said, and where the project is.
    let stays = format!("stays as it was saved in {}", desk.path("p.chladni").display());
    person.wait_to_see(&format!("begin a new history on this shape. The earlier project {stays}"));
    person.wait_to_see("2\u{202f}562 vertices");
    desk.answers.add(desk.path("finer.chladni"));
    person.press_with(CTRL, Key::S);
    let finer = Project::load(&desk.path("finer.chladni")).unwrap();
    assert_eq!(finer.shape, ShapeSource::File(desk.path("finer.obj")));
    let Painted::Vertices(carried) = &finer.layers()[0].1.region.painted else { panic!("no region") };
    let share = |values: &[f32]| values.iter().sum::<f32>() / values.len() as f32;
    assert_eq!(carried.len(), 2562);
    assert!((share(carried) / share(painted) - 1.0).abs() < 0.3, "{} {}", share(carried), share(painted));
}

#[test]
fn an_export_in_ink_offers_no_background_and_none_replaces_a_texture() {
    let desk = Desk::new();
    let mesh = load_mesh(&desk.path("shape.obj")).unwrap().mesh;
    let text = chladni_testdata::textured_obj(&mesh.positions, &mesh.triangles, "skin.mtl", |_| 0.5);
    std::fs::write(desk.path("textured.obj"), text).unwrap();
    std::fs::write(desk.path("skin.mtl"), "newmtl skin\nmap_Kd skin.png\n").unwrap();
    let skin = chladni_view::Picture::filled(2, 2, [200, 90, 60, 255]).to_png().unwrap();
    std::fs::write(desk.path("skin.png"), &skin).unwrap();

    let mut person = desk.sit_down(&["textured.obj"]);
    person.wait_to_see("Layers");
    person.press_with(CTRL, Key::E);
    person.click("export/png");
    assert!(person.sees("As here"));
    desk.answers.add(desk.path("skin.png"));
    person.click("export-begin");
    person.wait_to_see("is read, too");
    assert!(std::fs::read(desk.path("skin.png")).unwrap() == skin);

    person.press(Key::P);
    person.press_with(CTRL, Key::E);
    for kind in ["export/gif", "export/png"] {
        person.click(kind);
        assert!(!person.sees("As here"), "{kind}");
        assert_eq!(crate::driving::is_there(&person.0, "length"), kind == "export/gif");
    }
}

/// Begins a film of the turning shape that takes far longer than a few frames of the window.
fn film(person: &mut Person, to: std::path::PathBuf, desk: &Desk) {
    person.press_with(CTRL, Key::E);
    person.click("export/gif");
    person.click("sizes");
    person.click("size/640x480");
    desk.answers.add(to);
    person.click("export-begin");
}

#[test]
fn a_film_that_ends_while_the_start_screen_is_there_holds_up_no_closing() {
    let desk = Desk::new();
    let mut person = desk.sit_down(&["shape.obj"]);
    person.wait_to_see("Layers");
    film(&mut person, desk.path("turn.gif"), &desk);
    person.0.get_by_role_and_label(egui::accesskit::Role::Button, "Chladni").click();
    person.0.run_steps(3);
    person.wait_to_see("Exported");
    assert!(person.sees("What would you like to play?"));
    person.close();
    assert!(!person.sees("Closing when this is done"));
}

#[test]
fn a_film_that_fails_while_the_window_waits_for_it_keeps_it_open() {
    let desk = Desk::new();
    let mut person = desk.with_layers(&["magnify"]);
    // It cannot take the place of a folder, which is seen at its end.
    std::fs::create_dir(desk.path("turn.gif")).unwrap();
    film(&mut person, desk.path("turn.gif"), &desk);
    person.close();
    assert!(person.sees("Writing turn.gif is not finished"));
    desk.answers.add(desk.path("p.chladni"));
    person.click("save-and-close");
    assert!(person.sees("Closing when this is done"));
    person.wait_until_gone("Closing when this is done");
    assert!(person.sees("turn.gif: "));
    // It is open: what is done now is asked about.
    person.add_layer("magnify");
    person.close();
    assert!(person.sees("Save before closing?"));
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
