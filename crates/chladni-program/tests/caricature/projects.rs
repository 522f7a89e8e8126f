//! Projects: made, moved, shown, exported.

use super::*;

#[test]
fn a_project_is_made_shown_and_exported_with_a_slider_per_layer() {
    let desk = Desk::new();
    desk.ok("project new shape.obj -o p.chladni --harmonics 48");
    let nose = "--model normal --mu -0.8 --name nose --region 12,0,0,2";
    desk.ok(&format!("project add-layer p.chladni --template ellipsoid {nose}"));
    let detail = "--mu -2 --scale-curve 200%:0,90%:2,45%:1,d:0";
    desk.ok(&format!("project add-layer p.chladni --template self:lowpass=12 {detail}"));
    let shown = desk.ok("project show p.chladni --json");
    let shown: serde_json::Value = serde_json::from_str(&shown).unwrap();
    assert_eq!(shown["layers"][0]["name"], "nose");
    assert_eq!(shown["layers"][0]["region"], "spheres");
    assert_eq!(shown["layers"][1]["template"], "self:lowpass=12");
    assert_eq!(shown["layers"][1]["scale_curve"]["points"][1], serde_json::json!([0.9, 2.0]));
    let matching = &shown["layers"][1]["match"];
    assert_eq!((&matching["scaling"], &matching["seed"]), (&"free".into(), &0.into()));
    assert_eq!(shown["layers"][0]["infill"], 1.0);
    assert!(desk.ok("project show p.chladni").contains("2. self:lowpass=12"));

    desk.ok("caricature --recipe p.chladni -o out.glb");
    desk.ok("caricature --recipe p.chladni -o out.ply");
    let rest = desk.mesh("shape.obj").positions;
    let result = desk.mesh("out.ply").positions;
    let (names, mut sum) = morph_sum(&desk.path("out.glb"), rest.len());
    assert_eq!(names, ["nose", "self:lowpass=12"]);
    sum.iter_mut().flatten().zip(rest.iter().flatten()).for_each(|(s, x)| *s += x);
    assert!(largest(&sum, &result) < 1e-5, "{}", largest(&sum, &result));
}

#[test]
fn a_layer_keeps_the_seed_of_its_match() {
    let desk = Desk::new();
    desk.ok("project new shape.obj -o p.chladni --harmonics 48");
    desk.ok("project add-layer p.chladni --template shape.obj --match icp --seed 3");
    let shown: serde_json::Value = serde_json::from_str(&desk.ok("project show p.chladni --json")).unwrap();
    assert_eq!(shown["layers"][0]["match"]["seed"], 3);
}

/// With μ = 1 the shape goes back to what it was after the first layer.
#[test]
fn the_result_of_a_layer_is_the_template_of_another() {
    let desk = Desk::new();
    desk.ok("project new shape.obj -o one.chladni --harmonics 48");
    desk.ok("project add-layer one.chladni --template ellipsoid --mu -0.8 --name plump");
    std::fs::copy(desk.path("one.chladni"), desk.path("three.chladni")).unwrap();
    desk.ok("project add-layer three.chladni --template self:scale=0.5 --mu -0.6");
    desk.ok("project add-layer three.chladni --template self:layer=1 --mu 1");
    assert!(desk.ok("project show three.chladni").contains("3. self:layer=1"));
    for project in ["one", "three"] {
        desk.ok(&format!("caricature --recipe {project}.chladni -o {project}.ply"));
    }
    let [one, three] = ["one.ply", "three.ply"].map(|name| desk.mesh(name).positions);
    assert!(largest(&one, &three) < 1e-5 && largest(&one, &desk.mesh("shape.obj").positions) > 0.01);
}

/// A template is named relative to the current folder and kept relative to the project, so that the project finds the
/// same file from any folder, and after its own folder has moved.
#[test]
fn a_project_finds_its_files_from_anywhere_and_after_a_move() {
    let desk = Desk::new();
    std::fs::create_dir_all(desk.path("work/heads")).unwrap();
    save_mesh(&lump(1.0), &desk.path("work/shape.obj")).unwrap();
    let mut template = lump(1.0);
    template.positions.iter_mut().for_each(|p| p[1] *= 1.3);
    save_mesh(&template, &desk.path("work/heads/template.obj")).unwrap();
    // Another file of the same name where a path taken from the wrong folder would lead.
    std::fs::create_dir(desk.path("heads")).unwrap();
    save_mesh(&samples::icosphere(1), &desk.path("heads/template.obj")).unwrap();

    desk.ok("project new work/shape.obj -o work/p.chladni --harmonics 32");
    desk.ok("project add-layer work/p.chladni --template work/heads/template.obj --match same --mu -0.5");
    let text = std::fs::read_to_string(desk.path("work/p.chladni")).unwrap();
    assert!(text.contains("\"shape.obj\"") && text.contains("\"heads/template.obj\""), "{text}");
    desk.refused("project add-layer work/p.chladni --template template.obj");
    desk.ok("caricature --recipe work/p.chladni -o here.ply");
    let dance = "sample:tune -o film.gif --duration 0.1 --size 32x32 --harmonics 32";
    desk.ok(&format!("dance work/p.chladni {dance}"));

    std::fs::rename(desk.path("work"), desk.path("moved")).unwrap();
    desk.ok("caricature --recipe moved/p.chladni -o there.ply");
    assert_eq!(desk.mesh("here.ply").positions, desk.mesh("there.ply").positions);
    assert!(largest(&desk.mesh("here.ply").positions, &desk.mesh("shape.obj").positions) > 0.1);
    std::fs::remove_file(desk.path("film.gif")).unwrap();
    desk.ok(&format!("dance moved/p.chladni {dance}"));
}

/// The names of a GLB's morph targets and the sum of their displacements.
pub(super) fn morph_sum(path: &Path, vertices: usize) -> (Vec<String>, Vec<[f64; 3]>) {
    let bytes = std::fs::read(path).unwrap();
    let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
    let json_len = word(12);
    let json: serde_json::Value = serde_json::from_slice(&bytes[20..20 + json_len]).unwrap();
    let binary = 20 + json_len + 8;
    let mesh = &json["meshes"][0];
    assert_eq!(json["meshes"].as_array().unwrap().len(), 1);
    let names = mesh["extras"]["targetNames"].as_array().unwrap();
    let names = names.iter().map(|n| n.as_str().unwrap().to_owned()).collect();
    let mut sum = vec![[0.0; 3]; vertices];
    for target in mesh["primitives"][0]["targets"].as_array().unwrap() {
        let accessor = &json["accessors"][target["POSITION"].as_u64().unwrap() as usize];
        let view = &json["bufferViews"][accessor["bufferView"].as_u64().unwrap() as usize];
        let offset = |v: &serde_json::Value| v["byteOffset"].as_u64().unwrap_or(0) as usize;
        let start = binary + offset(accessor) + offset(view);
        for (v, s) in sum.iter_mut().enumerate() {
            for (i, s) in s.iter_mut().enumerate() {
                *s += f64::from(f32::from_bits(word(start + 12 * v + 4 * i) as u32));
            }
        }
    }
    (names, sum)
}

#[test]
fn options_for_matching_are_for_templates_that_are_meshes() {
    let desk = Desk::new();
    desk.ok("project new shape.obj -o p.chladni --harmonics 16");
    std::fs::write(desk.path("marks.txt"), "0 0\n").unwrap();
    let before = std::fs::read(desk.path("p.chladni")).unwrap();
    for (options, option) in [
        ("ellipsoid --match same", "--match"),
        ("self:lowpass=8 --rigid", "--rigid"),
        ("sphere --landmarks marks.txt", "--landmarks"),
        ("self:scale=0.9 --infill 0.5", "--infill"),
    ] {
        let said = desk.refused(&format!("project add-layer p.chladni --template {options}"));
        assert!(said.contains(&format!("{option} is for a template that is a mesh")), "{options}: {said}");
        assert_eq!(std::fs::read(desk.path("p.chladni")).unwrap(), before, "{options}");
    }
    desk.ok("project add-layer p.chladni --template shape.obj --match same --rigid --infill 0.5");
    let shown = desk.ok("project show p.chladni --json");
    let shown: serde_json::Value = serde_json::from_str(&shown).unwrap();
    assert_eq!(shown["layers"][0]["match"]["scaling"], "rigid");
    assert_eq!(shown["layers"][0]["infill"], 0.5);
}

#[test]
fn a_low_pass_that_keeps_more_harmonics_than_there_are_comes_into_no_project() {
    let desk = Desk::new();
    // As many as the project asks for, or as the shape has vertices.
    for (asked, most) in [(8, 8), (2000, 642)] {
        desk.ok(&format!("project new shape.obj -o {asked}.chladni -k {asked}"));
        let add = format!("project add-layer {asked}.chladni --template self:lowpass");
        let said = desk.refused(&format!("{add}={}", most + 1));
        assert!(said.contains(&format!("a low-pass keeps is {}", most + 1)), "{said}");
        desk.ok(&format!("{add}={most}"));
        assert_eq!(desk.ok(&format!("project show {asked}.chladni")).lines().count(), 2);
    }
}

#[test]
fn of_files_outside_its_folder_a_project_warns_where_something_is_made_of_them() {
    let (desk, elsewhere) = (Desk::new(), Desk::new());
    let warnings = |line: &str| {
        let output = desk.run(line);
        let said = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.success(), "{line}: {said}");
        said.matches("outside its own folder").count()
    };
    let begun = format!("project new {} -o p.chladni -k 8", elsewhere.path("shape.obj").display());
    for line in [&*begun, "project add-layer p.chladni --template sphere", "project show p.chladni"] {
        assert_eq!(warnings(line), 0, "{line}");
    }
    assert_eq!(warnings("caricature --recipe p.chladni -o a.ply"), 1);
}

#[cfg(unix)]
#[test]
fn a_result_whose_name_breaks_a_line_is_reported_in_one() {
    let desk = Desk::new();
    let output = Command::new(env!("CARGO_BIN_EXE_chladni"))
        .args(["project", "new", "shape.obj", "-k", "8", "-o", "a\nwrote b.chladni"])
        .current_dir(desk.path(""))
        .env("CHLADNI_CACHE", desk.path("cache"))
        .output()
        .unwrap();
    assert_eq!(String::from_utf8(output.stdout).unwrap(), "wrote a\\u000awrote b.chladni\n");
}

#[test]
fn a_project_is_not_started_over_another() {
    let desk = Desk::new();
    desk.ok("project new shape.obj -o p.chladni -k 16");
    desk.ok("project add-layer p.chladni --template sphere");
    assert!(desk.refused("project new shape.obj -o p.chladni").contains("exists already"));
    assert!(desk.ok("project show p.chladni").contains("sphere"));
}

#[test]
fn a_project_remembers_which_way_is_up() {
    let desk = Desk::new();
    desk.ok("project new shape.obj -o a.chladni -k 8 --up z --front -y");
    let text = std::fs::read_to_string(desk.path("a.chladni")).unwrap();
    assert!(text.contains("stands = \"up z, front -y\""), "{text}");
    let project = chladni_caricature::Project::load(&desk.path("a.chladni")).unwrap();
    assert_eq!(project.stands, Some(chladni_mesh::Orientation::Z_UP));
    desk.ok("project new shape.obj -o b.chladni -k 8");
    assert_eq!(chladni_caricature::Project::load(&desk.path("b.chladni")).unwrap().stands, None);
    std::fs::write(desk.path("c.chladni"), text.replace("up z, front -y", "up z, front z")).unwrap();
    assert!(desk.refused("project show c.chladni").contains("is no direction"));
}

#[test]
fn a_project_shows_which_layers_act_and_how_its_shape_is_taken() {
    let desk = Desk::new();
    desk.ok("project new shape.obj -o p.chladni -k 8 --proxy 200 --up z --front -y");
    for template in ["sphere", "ellipsoid", "self:original"] {
        desk.ok(&format!("project add-layer p.chladni --template {template}"));
    }
    let path = desk.path("p.chladni");
    let text = std::fs::read_to_string(&path).unwrap();
    let [head, first, second, third] = text.splitn(4, "[[layer]]").collect::<Vec<_>>()[..] else { panic!() };
    let soloed = |layer: &str| layer.replace("solo = false", "solo = true");
    let off = soloed(third).replace("enabled = true", "enabled = false");
    std::fs::write(&path, [head, first, &soloed(second), &off].join("[[layer]]")).unwrap();
    let shown = desk.ok("project show p.chladni");
    let lines: Vec<&str> = shown.lines().collect();
    assert!(lines[0].ends_with(", about 200 of its vertices, up z, front -y"), "{shown}");
    for (line, ending) in lines[1..].iter().zip(["everywhere, off", "everywhere, solo", ", solo, off"]) {
        assert!(line.ends_with(ending), "{shown}");
    }
    let shown: serde_json::Value = serde_json::from_str(&desk.ok("project show p.chladni --json")).unwrap();
    assert_eq!((&shown["proxy"], &shown["stands"]), (&200.into(), &"up z, front -y".into()));
    let acts: Vec<bool> = (0..3).map(|i| shown["layers"][i]["acts"].as_bool().unwrap()).collect();
    assert_eq!(acts, [false, true, false]);
}

#[test]
fn a_project_that_keeps_triangles_says_how_much_it_keeps() {
    let desk = Desk::new();
    let line = "caricature shape.obj self:lowpass=6 -k 64 --mu -14 -o";
    let plain = desk.ok(&format!("{line} plain.ply"));
    assert!(!plain.contains("keeps") && !plain.contains(" 0 triangles folded"), "{plain}");
    let kept = desk.ok(&format!("{line} kept.ply --keep-triangles"));
    assert!(kept.contains("% of its movement"), "{kept}");
    assert_ne!(desk.mesh("plain.ply").positions, desk.mesh("kept.ply").positions);
    desk.ok("project new shape.obj -k 64 -o p.chladni --keep-triangles");
    desk.ok("project add-layer p.chladni --template self:lowpass=6 --mu -14");
    assert!(desk.ok("project show p.chladni").contains("keeps triangles"));
    desk.ok("caricature --recipe p.chladni -o again.ply");
    assert_eq!(desk.mesh("again.ply").positions, desk.mesh("kept.ply").positions);
}

/// A solve would be seen by its warning: more harmonics are asked for than there are vertices.
#[test]
fn a_template_that_is_not_there_is_reported_before_any_harmonics_are_solved() {
    let desk = Desk::new();
    std::fs::create_dir(desk.path("many")).unwrap();
    for name in ["gone.obj", "many/a.obj"] {
        std::fs::copy(desk.path("shape.obj"), desk.path(name)).unwrap();
    }
    desk.ok("project new shape.obj -o p.chladni -k 2000");
    desk.ok("project add-layer p.chladni --template gone.obj --match same");
    std::fs::remove_file(desk.path("gone.obj")).unwrap();
    for line in [
        "caricature shape.obj gone.obj -k 2000 -o out.obj",
        "caricature shape.obj gone.obj -k 2000 --gallery -o out.png",
        "caricature --recipe p.chladni -o out.obj",
        "caricature --recipe p.chladni --batch many -o out",
        "dance p.chladni sample:tune -o film.gif --duration 0.1 --size 32x32",
    ] {
        let said = desk.refused(line);
        assert!(said.contains("gone.obj") && !said.contains("instead of"), "{line}: {said}");
    }
    let mean = desk.run("mean shape.obj many/a.obj gone.obj --match same -o mean.obj");
    let said = String::from_utf8(mean.stderr).unwrap();
    assert!(mean.stdout.is_empty() && said.contains("gone.obj"), "{said}");
}

#[test]
fn a_list_for_a_batch_names_what_lies_beside_it_and_is_no_mesh() {
    let desk = Desk::new();
    desk.ok("project new shape.obj -o p.chladni -k 16");
    desk.ok("project add-layer p.chladni --template self:scale=0.5");
    std::fs::create_dir(desk.path("many")).unwrap();
    save_mesh(&lump(1.0), &desk.path("many/a.obj")).unwrap();
    std::fs::write(desk.path("many/list.txt"), "# one lump\na.obj\n").unwrap();
    desk.ok("caricature --recipe p.chladni --batch many/list.txt -o out");
    assert!(desk.path("out/a.obj").exists());
    std::fs::write(desk.path("list.txt"), "many\\a.obj\n").unwrap();
    desk.ok("caricature --recipe p.chladni --batch list.txt -o of-windows");
    assert!(desk.path("of-windows/a.obj").exists());
    let said = desk.refused("caricature --recipe p.chladni --batch shape.obj -o out");
    assert!(said.contains("shape.obj: is a mesh") && said.lines().count() == 1, "{said}");
    let said = desk.refused("caricature --recipe p.chladni --batch p.chladni -o out");
    assert!(said.contains("p.chladni: is a caricature project") && said.lines().count() == 1, "{said}");
    let said = desk.refused("caricature --recipe p.chladni --batch absent.obj -o out");
    assert!(said.contains("absent.obj") && !said.contains("is a mesh"), "{said}");
}
