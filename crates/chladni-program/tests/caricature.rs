//! `chladni caricature` and `chladni project`, run as a user would.

#![allow(
    clippy::unwrap_used,
    clippy::print_stderr,
    reason = "a panic is how a test fails, and a skipped one says so"
)]

mod archive;

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use chladni_harmonics::npz::write_npz;
use chladni_mesh::{TriMesh, load_mesh, samples, save_mesh};

/// A folder with a lumpy shape, `shape.obj`.
struct Desk(tempfile::TempDir);

impl Desk {
    fn new() -> Self {
        let desk = Self(tempfile::tempdir().unwrap());
        save_mesh(&lump(1.0), &desk.path("shape.obj")).unwrap();
        desk
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn mesh(&self, name: &str) -> TriMesh {
        load_mesh(&self.path(name)).unwrap().mesh
    }

    fn run(&self, line: &str) -> Output {
        Command::new(env!("CARGO_BIN_EXE_chladni"))
            .args(line.split_whitespace())
            .current_dir(self.0.path())
            .env("CHLADNI_CACHE", self.path("cache"))
            .output()
            .unwrap()
    }

    /// Runs a line that must succeed; what it printed.
    fn ok(&self, line: &str) -> String {
        let output = self.run(line);
        assert!(output.status.success(), "{line}: {}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).unwrap()
    }

    /// Runs a line that must fail with exit code 2; what it said.
    fn refused(&self, line: &str) -> String {
        let output = self.run(line);
        assert_eq!(output.status.code(), Some(2), "{line}");
        String::from_utf8(output.stderr).unwrap()
    }
}

fn lump(size: f64) -> TriMesh {
    let mut mesh = samples::icosphere(3);
    for p in &mut mesh.positions {
        let [x, y, z] = *p;
        let r = size * (3.0 + 0.6 * (3.0 * x).sin() + 0.4 * y * z);
        *p = [size * 10.0 + r * x, r * y, 0.7 * r * z];
    }
    mesh
}

fn largest(a: &[[f64; 3]], b: &[[f64; 3]]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().flatten().zip(b.iter().flatten()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

#[test]
fn mu_zero_writes_the_shape_itself_and_others_do_not() {
    let desk = Desk::new();
    let shape = desk.mesh("shape.obj");
    for model in ["coordinate", "normal", "distance"] {
        let line = |mu: f64| {
            format!("caricature shape.obj ellipsoid -o out.ply --harmonics 32 --model {model} --mu {mu}")
        };
        desk.ok(&line(0.0));
        assert_eq!(desk.mesh("out.ply").positions, shape.positions);
        desk.ok(&line(-1.5));
        let moved = desk.mesh("out.ply");
        assert!(largest(&moved.positions, &shape.positions) > 0.1);
        assert_eq!(moved.triangles, shape.triangles);
    }
}

#[test]
fn the_shape_scaled_down_is_scaled_up_and_a_region_stays_where_it_is() {
    let desk = Desk::new();
    let shape = desk.mesh("shape.obj").positions;
    desk.ok("caricature shape.obj self:scale=0.5 -o big.obj --harmonics 16 --mu -1");
    let big = desk.mesh("big.obj").positions;
    let edge = |p: &[[f64; 3]]| largest(&[p[0]], &[p[1]]);
    assert!((edge(&big) / edge(&shape) - 1.5).abs() < 1e-9);
    let region = "--region 13,0,0,2 --cutoff 40";
    desk.ok(&format!("caricature shape.obj self:scale=0.5 -o part.obj --harmonics 64 --mu -1 {region}"));
    let part = desk.mesh("part.obj").positions;
    let moved = |i: usize| largest(&[part[i]], &[shape[i]]);
    let outermost = |side: f64| {
        (0..part.len()).max_by(|a, b| (side * shape[*a][0]).total_cmp(&(side * shape[*b][0]))).unwrap()
    };
    let (inside, outside) = (moved(outermost(1.0)), moved(outermost(-1.0)));
    assert!(inside > 20.0 * outside, "{inside} {outside}");
}

#[test]
fn a_given_sphere_is_reached_and_one_seed_serves_matches_and_layers() {
    let desk = Desk::new();
    desk.ok("caricature shape.obj sphere:1,2,3,5 -o ball.ply --harmonics 16 --mu 1");
    for p in desk.mesh("ball.ply").positions {
        let radius = ((p[0] - 1.0).powi(2) + (p[1] - 2.0).powi(2) + (p[2] - 3.0).powi(2)).sqrt();
        assert!((radius - 5.0).abs() < 1e-5, "{radius}");
    }
    desk.ok("match shape.obj --method ellipsoid:1,2,3,5,4,3,10,20,30");
    let seed = |command: &str| {
        let help = desk.ok(&format!("{command} --help"));
        let at = help.split("--seed").nth(1).and_then(|rest| rest.split("[default: ").nth(1)).unwrap();
        at.split(']').next().unwrap().to_owned()
    };
    assert_eq!(seed("match"), seed("caricature"));
    assert_eq!(seed("match"), seed("project add-layer"));
}

#[test]
fn a_project_is_made_shown_and_exported_with_a_slider_per_layer() {
    let desk = Desk::new();
    desk.ok("project new shape.obj -o p.chladni --harmonics 48");
    let nose = "--model normal --mu -0.8 --name nose --region 12,0,0,2";
    desk.ok(&format!("project add-layer p.chladni --template ellipsoid {nose}"));
    let detail = "--mu -2 --scale-curve 200%:0,90%:2,45%:1,d:0 --rigid --seed 3 --infill 0.5";
    desk.ok(&format!("project add-layer p.chladni --template self:lowpass=12 {detail}"));
    let shown = desk.ok("project show p.chladni --json");
    let shown: serde_json::Value = serde_json::from_str(&shown).unwrap();
    assert_eq!(shown["layers"][0]["name"], "nose");
    assert_eq!(shown["layers"][0]["region"], "spheres");
    assert_eq!(shown["layers"][1]["template"], "self:lowpass=12");
    assert_eq!(shown["layers"][1]["scale_curve"]["points"][1], serde_json::json!([0.9, 2.0]));
    let matching = &shown["layers"][1]["match"];
    assert_eq!((&matching["scaling"], &matching["seed"]), (&"rigid".into(), &3.into()));
    assert_eq!((&shown["layers"][0]["infill"], &shown["layers"][1]["infill"]), (&1.0.into(), &0.5.into()));
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

/// A template is named from where the person stands, and kept relative to the project: whoever
/// reads the project, from wherever, and after its folder has moved, finds the same file.
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
fn morph_sum(path: &Path, vertices: usize) -> (Vec<String>, Vec<[f64; 3]>) {
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
fn a_recipe_is_applied_to_a_folder() {
    let desk = Desk::new();
    desk.ok("project new shape.obj -o p.chladni --harmonics 32");
    desk.ok("project add-layer p.chladni --template self:scale=0.8 --mu -1 --region 13,0,0,2");
    std::fs::create_dir(desk.path("many")).unwrap();
    save_mesh(&lump(1.0), &desk.path("many/a.obj")).unwrap();
    save_mesh(&lump(7.0), &desk.path("many/b.ply")).unwrap();
    desk.ok("caricature --recipe p.chladni --batch many -o out");
    let (a, b) = (desk.mesh("out/a.obj").positions, desk.mesh("out/b.ply").positions);
    let scaled: Vec<[f64; 3]> = a.iter().map(|p| p.map(|c| 7.0 * c)).collect();
    assert!(largest(&scaled, &b) < 1e-3, "the region moved along with the frame");
    assert!(largest(&a, &lump(1.0).positions) > 0.05);
    std::fs::write(desk.path("many/c.obj"), "v 1 2").unwrap();
    let said = desk.refused("caricature --recipe p.chladni --batch many -o out2");
    assert!(said.contains("c.obj") && said.contains("1 of 3"), "{said}");
    assert!(desk.path("out2/b.ply").exists() && !desk.path("out2/c.obj").exists());
}

#[test]
fn a_batch_gives_every_mesh_a_file_of_its_own_and_replaces_none() {
    let desk = Desk::new();
    desk.ok("project new shape.obj -o p.chladni --harmonics 16");
    desk.ok("project add-layer p.chladni --template self:scale=0.5");
    std::fs::create_dir(desk.path("many")).unwrap();
    for name in ["head.v1.obj", "head.v2.obj"] {
        save_mesh(&lump(1.0), &desk.path("many").join(name)).unwrap();
    }
    let written = desk.ok("caricature --recipe p.chladni --batch many -o out");
    for name in ["head.v1.obj", "head.v2.obj"] {
        assert!(desk.path("out").join(name).exists(), "{written}");
    }
    // Both would be written as PLY.
    for (name, text) in [("a.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"), ("a.ply", "")] {
        std::fs::write(desk.path("many").join(name), text).unwrap();
    }
    let said = desk.refused("caricature --recipe p.chladni --batch many -o out2");
    assert!(said.contains("a.off") && said.contains("a.ply"), "{said}");
    assert!(!desk.path("out2").exists());
    std::fs::remove_file(desk.path("many/a.ply")).unwrap();
    let before = std::fs::read(desk.path("many/head.v1.obj")).unwrap();
    let said = desk.refused("caricature --recipe p.chladni --batch many -o ./many");
    assert!(said.contains("many"), "{said}");
    assert_eq!(std::fs::read(desk.path("many/head.v1.obj")).unwrap(), before);
}

#[test]
fn pieces_of_a_batch_are_all_of_it_and_what_is_there_stays() {
    let desk = Desk::new();
    desk.ok("project new shape.obj -o p.chladni --harmonics 16");
    desk.ok("project add-layer p.chladni --template self:scale=0.5");
    std::fs::create_dir(desk.path("many")).unwrap();
    let names = ["a.obj", "b.ply", "c.obj"];
    for (size, name) in names.iter().enumerate() {
        save_mesh(&lump(1.0 + size as f64), &desk.path("many").join(name)).unwrap();
    }
    let list: String =
        names.iter().map(|name| format!("{}\n\n", desk.path("many").join(name).display())).collect();
    std::fs::write(desk.path("list.txt"), list).unwrap();
    desk.ok("caricature --recipe p.chladni --batch many -o whole");
    desk.ok("caricature --recipe p.chladni --batch list.txt -o out --piece 1/2");
    let made = |name: &str| desk.path("out").join(name).exists();
    assert!(made("a.obj") && !made("b.ply") && !made("c.obj"));
    std::fs::write(desk.path("out/b.ply"), "kept").unwrap();
    desk.ok("caricature --recipe p.chladni --batch list.txt -o out --piece 2/2 --resume");
    assert_eq!(std::fs::read(desk.path("out/b.ply")).unwrap(), b"kept");
    for name in ["a.obj", "c.obj"] {
        let read = |folder: &str| std::fs::read(desk.path(folder).join(name)).unwrap();
        assert!(read("out") == read("whole"), "{name}");
    }
    std::fs::write(desk.path("empty.txt"), "\n").unwrap();
    assert!(desk.refused("caricature --recipe p.chladni --batch empty.txt -o out").contains("lists no mesh"));
    assert!(desk.refused("caricature --recipe p.chladni --batch absent -o out").contains("absent"));
}

#[test]
fn bad_arguments_are_told_apart() {
    let desk = Desk::new();
    desk.ok("project new shape.obj -o good.chladni --harmonics 16");
    std::fs::write(desk.path("junk.chladni"), "format_version = 2\nshape = 3").unwrap();
    std::fs::write(desk.path("noise.chladni"), b"\xff\xfe\x00").unwrap();
    std::fs::create_dir_all(desk.path("folder.obj")).unwrap();
    for (line, expected) in [
        ("caricature shape.obj ellipsoid -o out.xyz", "out.xyz"),
        ("caricature absent.obj ellipsoid -o out.obj", "absent.obj"),
        ("caricature shape.obj absent.obj -o out.obj", "absent.obj"),
        ("caricature shape.obj self:loud=3 -o out.obj", "self:loud=3"),
        ("caricature sample:nobody ellipsoid -o out.obj", "nobody"),
        ("caricature shape.obj ellipsoid -o out.obj --mu 1e9", "μ"),
        ("caricature shape.obj ellipsoid -o out.obj --model loud", "loud"),
        ("caricature shape.obj ellipsoid -o out.obj --region 1,2,3", "x,y,z,radius"),
        ("caricature shape.obj ellipsoid -o out.obj --scale-curve 0:9", "scale curve"),
        ("caricature shape.obj ellipsoid -o out.obj --scale-curve 0:1,0.4:2,1:0", "percent of the size"),
        ("caricature shape.obj ellipsoid -o out.obj --cutoff 0", "cut-off"),
        ("caricature shape.obj ellipsoid -o out.obj --infill 2", "the infill"),
        ("caricature shape.obj sphere:0,0,0 -o out.obj", "sphere:x,y,z,radius"),
        ("match shape.obj --method ellipsoid:0,0,0,1,1,-1", "positive and finite"),
        ("match shape.obj --method sphere --rigid", "--rigid"),
        ("caricature shape.obj ellipsoid -o out.obj --harmonics 0", "harmonics"),
        ("caricature --recipe absent.chladni -o out.obj", "absent.chladni"),
        ("caricature --recipe junk.chladni -o out.obj", "junk.chladni"),
        ("caricature --recipe good.chladni --mu -2 -o out.obj", "--mu"),
        ("caricature shape.obj ellipsoid -o nowhere/out.obj", "nowhere/out.obj: its folder does not exist"),
        ("caricature shape.obj ellipsoid -o folder.obj", "is a folder"),
        ("caricature shape.obj ellipsoid -o out.obj --render out.jpg", "out.jpg: a picture ends in .png"),
        ("basis shape.obj --ranks 2", "belong to --engine slepc"),
        ("basis shape.obj --engine slepc --ranks 0", "0 ranks: from 1 to"),
        ("basis shape.obj --engine slepc --ranks 99999", "99999 ranks: from 1 to"),
        ("basis shape.obj --engine slepc --ranks 4 --groups 3", "3 equal groups"),
        ("basis shape.obj --engine slepc --hosts absent.txt", "absent.txt"),
        ("basis shape.obj --engine slepc --threads 2", "--threads is for"),
        ("basis shape.obj -o nowhere/b.npz", "its folder does not exist"),
        ("match shape.obj shape.obj --method sphere", "neither a template"),
        ("match shape.obj shape.obj --render out.jpg", ".png"),
        ("spectrum sample:tune --render out.jpg", ".png"),
        ("symmetry shape.obj --render nowhere/out.png", "its folder does not exist"),
        ("dance shape.obj sample:tune -o nowhere/out.gif", "its folder does not exist"),
        ("dance shape.obj sample:tune", "--output <FILM>|--frames <DIR>|--coefficients <C.npz>"),
        (
            "dance shape.obj sample:tune -o out.gif --lights moon",
            "expected one of studio, soft, dramatic, stage",
        ),
        ("dance shape.obj sample:tune -o out.gif --gain 99 -k 9", "[0, 20]"),
        ("project", "a subcommand is missing"),
        ("project new shape.obj -o p.txt", ".chladni"),
        ("project show junk.chladni", "junk.chladni"),
        ("project show noise.chladni", "noise.chladni: is no text, so it is not a Chladni project"),
    ] {
        let said = desk.refused(line);
        assert!(said.contains(expected), "{line}: {said}");
    }
    let left: Vec<_> = std::fs::read_dir(desk.0.path()).unwrap().map(|e| e.unwrap().file_name()).collect();
    assert!(left.iter().all(|name| name != "out.obj" && name != "p.txt"), "{left:?}");
}

#[test]
fn a_region_beside_the_shape_is_told() {
    let desk = Desk::new();
    let line = "caricature shape.obj ellipsoid --harmonics 16 -o out.obj --region";
    let beside = desk.run(&format!("{line} 0,0,0,0.1"));
    let message = String::from_utf8(beside.stderr).unwrap();
    assert!(beside.status.success() && message.contains("its region holds no vertex"), "{message}");
    let on_it = desk.run(&format!("{line} 10,0,0,20"));
    assert!(!String::from_utf8(on_it.stderr).unwrap().contains("its region"));
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
fn a_shape_with_few_vertices_dances_with_the_harmonics_it_has() {
    let desk = Desk::new();
    save_mesh(&samples::icosphere(0), &desk.path("few.obj")).unwrap();
    let dance = desk.run("dance few.obj sample:tune --coefficients c.npz --duration 0.1");
    let message = String::from_utf8(dance.stderr).unwrap();
    assert!(dance.status.success() && message.contains("12 harmonics instead of 512"), "{message}");
}

/// The picture that `line` writes.
fn drawn(desk: &Desk, line: &str) -> chladni_view::Picture {
    let output = desk.run(&format!("{line} --render out.png"));
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{line}: {said}");
    chladni_view::Picture::decode(&std::fs::read(desk.path("out.png")).unwrap()).unwrap()
}

fn is_red([r, g, b, _]: [u8; 4]) -> bool {
    r > 90 && u16::from(r) > 2 * u16::from(g.max(b))
}

/// Rows and columns of the left half that something red covers.
fn covered(picture: &chladni_view::Picture) -> [usize; 2] {
    let half = picture.width / 2;
    let red = |x: u32, y: u32| is_red(picture.pixel(x, y).unwrap());
    let rows = (0..picture.height).filter(|y| (0..half).any(|x| red(x, *y))).count();
    let columns = (0..half).filter(|x| (0..picture.height).any(|y| red(*x, y))).count();
    [rows, columns]
}

#[test]
fn a_picture_keeps_colours_stands_as_told_and_uses_its_format() {
    let desk = Desk::new();
    // Thin, long along z, and red.
    let mut stick = samples::icosphere(3);
    for p in &mut stick.positions {
        *p = [0.4 * p[0], 0.3 * p[1], 3.0 * p[2] + 0.3 * p[0] * p[0]];
    }
    stick.appearance.colors = Some(vec![[0.8, 0.02, 0.02, 1.0]; stick.positions.len()]);
    save_mesh(&stick, &desk.path("stick.ply")).unwrap();
    let line = "caricature stick.ply self:scale=0.9 -k 8 -o out.ply --view 0,0 --size 640x480";
    let upright = drawn(&desk, &format!("{line} --up z"));
    let [rows, columns] = covered(&upright);
    assert!(rows > 380 && columns < 120, "{rows} rows, {columns} columns");
    let red = (0..640).flat_map(|x| (0..480).map(move |y| (x, y)));
    let red = red.filter(|(x, y)| is_red(upright.pixel(*x, *y).unwrap())).count();
    assert!(red > 5000, "{red} red pixels");
    let exported = std::fs::read(desk.path("out.ply")).unwrap();

    // It lies, so that the format's width is used: above each other.
    let lying = drawn(&desk, &format!("{line} --up y --front x"));
    let [rows, columns] = covered(&lying);
    assert!(rows < 400 && columns > 250, "{rows} rows, {columns} columns");
    assert_eq!(std::fs::read(desk.path("out.ply")).unwrap(), exported, "files keep their axes");

    let refused = desk.refused(&format!("{line} --up y --front -y --render out.png"));
    assert!(refused.contains("--up y and --front -y lie on one line"), "{refused}");
    assert!(desk.refused(&format!("{line} --up w")).contains("is no direction"));
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
fn paper_mode_takes_the_plain_laplacian_and_the_papers_settings() {
    let desk = Desk::new();
    desk.ok("project new shape.obj --paper --harmonics 40 -o p.chladni");
    desk.ok("project add-layer p.chladni --template ellipsoid --model distance --region 13,0,0,2");
    let text = std::fs::read_to_string(desk.path("p.chladni")).unwrap();
    for line in ["laplacian = \"cotangent\"", "mu = -8.0", "roll_off = \"sharp\"", "clamp = false"] {
        assert!(text.contains(line), "{line} in {text}");
    }
    let shown = desk.ok("project show p.chladni --json");
    assert!(shown.contains("\"laplacian\": \"cotangent\""), "{shown}");
    // One switch on the command does the same as the project.
    let line = "caricature shape.obj ellipsoid --harmonics 40 --model distance --region 13,0,0,2";
    desk.ok("caricature --recipe p.chladni -o recipe.ply");
    desk.ok(&format!("{line} --paper -o switch.ply"));
    assert_eq!(desk.mesh("recipe.ply").positions, desk.mesh("switch.ply").positions);
    // The operator is another one, not only the settings: of obtuse triangles it has other harmonics.
    let mut slanted = desk.mesh("shape.obj");
    slanted.positions.iter_mut().for_each(|p| p[0] += 3.0 * p[1]);
    save_mesh(&slanted, &desk.path("slanted.obj")).unwrap();
    let line = "caricature slanted.obj ellipsoid --harmonics 40 --model distance --mu -2";
    desk.ok(&format!("{line} --paper -o paper.ply"));
    desk.ok(&format!("{line} -o usual.ply"));
    assert!(largest(&desk.mesh("paper.ply").positions, &desk.mesh("usual.ply").positions) > 1e-3);
    // What cannot have it is refused at once, with the place.
    let fan = TriMesh {
        positions: vec![[0.0; 3], [0.0, 0.0, 1.0], [1.0, 0.0, 0.5], [-0.5, 0.8, 0.5], [-0.5, -0.8, 0.5]],
        triangles: vec![[0, 1, 2], [0, 1, 3], [0, 1, 4]],
        ..TriMesh::default()
    };
    save_mesh(&fan, &desk.path("fan.obj")).unwrap();
    for line in [
        "caricature fan.obj ellipsoid --paper -o x.ply",
        "project new fan.obj --paper -o x.chladni",
        "basis fan.obj --paper -k 3",
        "symmetry fan.obj --paper -k 3",
        "dance fan.obj sample:tune --paper -k 3 --duration 1 --coefficients c.npz",
    ] {
        let said = desk.refused(line);
        assert!(said.contains("3 triangles meet at the edge of vertices 0 and 1"), "{line}: {said}");
    }
    desk.ok("basis fan.obj -k 3");
}

#[test]
fn a_picture_may_show_the_template_as_a_ghost() {
    let desk = Desk::new();
    let line = "caricature shape.obj ellipsoid --harmonics 32 --mu -1 --render p.png --size 400x200";
    desk.ok(&format!("{line} --show after,ghost"));
    let picture = chladni_view::Picture::decode(&std::fs::read(desk.path("p.png")).unwrap()).unwrap();
    // The ghost is bluish: red gives way to blue, where the shape was warm clay.
    let warm = |column: u32| {
        let pixels = (0..200).flat_map(|y| (0..200).map(move |x| (200 * column + x, y)));
        pixels.map(|(x, y)| picture.pixel(x, y).unwrap()).filter(|p| p[0] > p[2] + 25).count()
    };
    assert!(warm(0) > 4000 && warm(1) < warm(0) / 2, "{} {}", warm(0), warm(1));
    let said = desk.refused("caricature shape.obj ellipsoid --harmonics 32 --render p.svg --show ghost");
    assert!(said.contains("ghost"), "{said}");
}

#[test]
fn a_picture_shows_the_panels_asked_for_in_a_row_for_each_mu() {
    let desk = Desk::new();
    desk.ok(
        "caricature shape.obj ellipsoid -o out.ply --harmonics 32 --region 13,0,0,2 --render p.png --size 600x200 \
         --show painted,region,coordinate,normal,distance,rest --sweep=-0.3,-3",
    );
    let bytes = std::fs::read(desk.path("p.png")).unwrap();
    let picture = chladni_view::Picture::decode(&bytes).unwrap();
    assert_eq!((picture.width, picture.height), (600, 200));
    let panel = |row: u32, column: u32| -> Vec<[u8; 4]> {
        let pixels = (0..100).flat_map(|y| (0..100).map(move |x| (x, y)));
        pixels.map(|(x, y)| picture.pixel(100 * column + x, 100 * row + y).unwrap()).collect()
    };
    // χ01 and χ lie on the shape, which μ does not change; the results differ, from row to row and
    // from model to model.
    for column in 0..2 {
        assert!(panel(0, column) == panel(1, column));
    }
    for column in 2..6 {
        assert!(panel(0, column) != panel(1, column));
    }
    for (a, b) in [(0, 1), (2, 3), (3, 4), (2, 4)] {
        assert!(panel(1, a) != panel(1, b));
    }
    // The shape at rest is there as black dots.
    let black = |panel: Vec<[u8; 4]>| panel.iter().filter(|p| p[..3].iter().all(|c| *c < 40)).count();
    assert!(black(panel(1, 5)) > black(panel(1, 2)) + 30);
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

#[test]
fn a_difference_moves_onto_another_shape() {
    let desk = Desk::new();
    desk.ok("caricature shape.obj ellipsoid -k 64 --mu -0.3 -o much.obj");
    save_mesh(&lump(2.0), &desk.path("large.obj")).unwrap();
    desk.ok("transfer shape.obj much.obj large.obj --match same -o out.obj");
    let (out, much) = (desk.mesh("out.obj").positions, desk.mesh("much.obj").positions);
    // As large as the target, twice the shape.
    assert!(out.iter().zip(&much).all(|(a, b)| (0..3).all(|i| (a[i] - 2.0 * b[i]).abs() < 1e-3)));
    desk.ok("transfer shape.obj much.obj large.obj --match same --amount 0 -o still.obj");
    assert_eq!(desk.mesh("still.obj").positions, desk.mesh("large.obj").positions);
    desk.refused("transfer shape.obj much.obj large.obj --amount inf -o out.obj");
}

#[test]
fn shapes_are_averaged_on_the_triangles_of_the_first() {
    let desk = Desk::new();
    let shape = desk.mesh("shape.obj");
    let larger = TriMesh { positions: lump(2.0).positions, ..shape.clone() };
    save_mesh(&larger, &desk.path("large.ply")).unwrap();
    // Fitted in size, a shape and its double are the same; in one unit the mean of 1, 2 and 2 is 5/3.
    desk.ok("mean shape.obj large.ply --match same -o mean.ply");
    assert!(largest(&desk.mesh("mean.ply").positions, &shape.positions) < 1e-5);
    desk.ok("mean shape.obj large.ply large.ply --match same --rigid -o mean.ply");
    let mean = desk.mesh("mean.ply");
    let extent = |mesh: &TriMesh| {
        let y = || mesh.positions.iter().map(|p| p[1]);
        y().fold(f64::MIN, f64::max) - y().fold(f64::MAX, f64::min)
    };
    assert!((extent(&mean) / extent(&shape) - 5.0 / 3.0).abs() < 1e-4);
    assert_eq!(mean.triangles, shape.triangles);
    assert!(desk.refused("mean shape.obj large.ply --match map -o mean.ply").contains("landmarks"));
    desk.refused("mean shape.obj -o mean.ply");
    let said = desk.refused("mean shape.obj sample:ring --match same -o mean.ply");
    assert!(said.contains("sample:ring") && said.contains("connectivity"), "{said}");
}

#[test]
fn a_part_of_a_head_is_a_region() {
    let desk = Desk::new();
    let parts = desk.ok("parts sample:head --json -o parts.npz");
    assert!(parts.contains("\"nose\"") && parts.contains("confidence"), "{parts}");
    desk.ok("caricature sample:head ellipsoid -k 48 --part nose -o nose.ply");
    let (before, after) = (samples::sample("head").unwrap().positions, desk.mesh("nose.ply").positions);
    let moved = |v: usize| (0..3).map(|i| (after[v][i] - before[v][i]).powi(2)).sum::<f64>().sqrt();
    let back = (0..before.len()).filter(|v| before[*v][2] < -0.3).map(moved).fold(0.0, f64::max);
    let most = (0..before.len()).max_by(|a, b| moved(*a).total_cmp(&moved(*b))).unwrap();
    assert!(before[most][2] > 0.4 && back < 0.02 * moved(most), "{:?}, {back}", before[most]);
    let said = desk.refused("caricature sample:head ellipsoid --part elbow -o nose.ply");
    assert!(said.contains("nose, brow"), "{said}");
}

#[test]
fn the_limbs_of_any_shape_are_its_parts_at_a_level() {
    let desk = Desk::new();
    let printed = desk.ok("parts sample:octopus --level 0.3 --json -o parts.npz --render parts.png");
    let parts: serde_json::Value = serde_json::from_str(&printed).unwrap();
    let parts = parts.as_array().unwrap();
    let arms: Vec<_> = parts.iter().filter(|part| !part["twin"].is_null()).collect();
    assert_eq!(arms.len(), 8, "{printed}");
    assert!(arms.iter().all(|arm| parts[arm["twin"].as_u64().unwrap() as usize]["twin"] == arm["part"]));
    let total: f64 = parts.iter().map(|part| part["share"].as_f64().unwrap()).sum();
    assert!((total - 1.0).abs() < 1e-9);
    assert!(desk.path("parts.npz").exists() && desk.path("parts.png").exists());
    assert!(desk.ok("parts shape.obj --level 0").contains("% of the surface"));
    assert!(desk.refused("parts shape.obj --level 2").contains("from 0 to 1"));
    let line = "caricature sample:octopus ellipsoid -k 64 --mu -1 -o arm.ply --limb";
    let moved = |limb: &str| {
        desk.ok(&format!("{line} {limb}"));
        load_mesh(&desk.path("arm.ply")).unwrap().mesh.positions
    };
    let (one, other) = (moved("1"), moved("2,3"));
    assert!(largest(&one, &other) > 0.01, "limbs are regions");
    assert!(desk.refused(&format!("{line} 99")).contains("there is no 99"));
    assert!(desk.refused("caricature shape.obj ellipsoid -o x.ply --level 0.1").contains("--limb"));
    // The same parts as a mask, whose numbers another program could have written.
    let parts = archive::array(&desk.path("parts.npz"), "part").unwrap().values;
    write_npz(&desk.path("mask.npz"), |npz| {
        npz.array("mask", &[parts.len() as u64], parts.iter().map(|part| f32::from(u8::from(*part == 1.0))))
    })
    .unwrap();
    let line = "caricature sample:octopus ellipsoid -k 64 --mu -1 -o masked.ply --mask";
    desk.ok(&format!("{line} mask.npz"));
    let masked = load_mesh(&desk.path("masked.ply")).unwrap().mesh.positions;
    assert_eq!(masked, one);
    assert!(desk.refused(&format!("{line} parts.npz")).contains("no array \"mask\""));
    assert!(
        desk.refused("caricature shape.obj ellipsoid -o x.ply --mask mask.npz").contains("a number for each")
    );
}

#[test]
fn a_picture_is_drawn_in_ink_as_svg_or_png_and_options_of_ink_are_checked() {
    let desk = Desk::new();
    let line = "caricature shape.obj ellipsoid -o out.ply -k 32 --mu -1 --size 320x160";
    let read = |name: &str| std::fs::read(desk.path(name)).unwrap();
    desk.ok(&format!("{line} --render both.svg"));
    let svg = String::from_utf8(read("both.svg")).unwrap();
    assert!(svg.starts_with("<svg ") && svg.contains("width=\"320\"") && svg.contains("<g id=\"contours\""));
    desk.ok(&format!("{line} --render again.svg --ink"));
    assert_eq!(read("again.svg"), read("both.svg"));
    desk.ok(&format!("{line} --render ink.png --ink --ink-colors #800000,#ffffff --ink-hatching 0"));
    let picture = chladni_view::Picture::decode(&read("ink.png")).unwrap();
    assert_eq!((picture.width, picture.height, picture.pixel(0, 0)), (320, 160, Some([255; 4])));
    // Nothing but shades between the ink and the paper, and both of them.
    assert!(picture.rgba.chunks(4).all(|p| p[1] == p[2] && p[0] >= p[1]));
    assert!(picture.rgba.chunks(4).any(|p| p[1] < 60));
    desk.ok(&format!("{line} --render tones.svg --ink-tones 3"));
    let tones = String::from_utf8(read("tones.svg")).unwrap();
    assert!(tones.contains("<g id=\"tones\"") && !svg.contains("tones"));
    // Before and after, three tones each, of which the lightest is the paper.
    assert_eq!(tones.matches("evenodd").count(), 4);
    desk.ok(&format!("{line} --turntable turn.gif --turn-secs 0.2 --ink-tones 2"));
    desk.ok("caricature shape.obj ellipsoid -k 32 --turntable plain.gif --turn-secs 0.1 --size 64x64");
    assert!(read("turn.gif").starts_with(b"GIF89a") && read("plain.gif").starts_with(b"GIF89a"));
    // Before and after have lines of one width, or of widths that follow the exaggeration.
    desk.ok(&format!("{line} --render wide.svg --show after,coordinate --ink-exaggeration"));
    assert_ne!(read("wide.svg"), read("both.svg"));
    for (options, said) in [
        ("--render x.svg --show painted", "ink draws shapes alone"),
        ("--render x.svg --ink-colors red,blue", "write two colors"),
        ("--render x.png --ink-hatching 2", "from 0 to 1"),
        ("--render x.jpg", "a picture ends in .png or .svg"),
        ("--render x.svg --ink-tones 5", "5"),
        ("--turntable x.jpg", "film"),
        ("--ink", "--render"),
    ] {
        let message = desk.refused(&format!("{line} {options}"));
        assert!(message.contains(said), "{options}: {message}");
        assert!(!desk.path("x.svg").exists());
    }
}

#[test]
fn a_mask_goes_out_and_comes_in_again_by_every_kind_of_file() {
    let desk = Desk::new();
    let moved = |region: &str| {
        desk.ok(&format!("caricature shape.obj ellipsoid -k 32 --mu -1 -o moved.ply {region}"));
        desk.mesh("moved.ply").positions
    };
    let expected = moved("--curved bumps:30%");
    assert!(largest(&expected, &moved("--curved hollows:30%")) > 1e-3);
    for out in ["m.npy", "m.npz", "m.ply", "m.obj", "m.glb", "gray.ply --as-colors"] {
        let said = desk.ok(&format!("mask shape.obj --curved bumps:30% -o {out}"));
        assert!(said.contains("of 642 vertices"), "{said}");
        let file = out.split(' ').next().unwrap();
        assert_eq!(moved(&format!("--mask {file}")), expected, "{out}");
    }
    assert_eq!(moved("--mask gray.ply --mask-channel green"), expected);
    assert!(
        largest(&moved("--mask gray.ply --mask-channel alpha"), &expected) > 1e-3,
        "alpha is 1 everywhere"
    );
    let line = "caricature shape.obj ellipsoid -o x.ply --mask m.ply --mask-channel weight";
    assert!(desk.refused(line).contains("no weight; they have mask"));
    // A project's layer takes a mask, and gives it back.
    desk.ok("project new shape.obj -k 32 -o me.chladni");
    assert!(desk.refused("mask me.chladni -o back.npy").contains("has no layer"));
    desk.ok("project add-layer me.chladni --template ellipsoid --mu -1 --mask m.npy");
    desk.ok("project add-layer me.chladni --template sphere --name all");
    desk.ok("mask me.chladni --layer ellipsoid -o back.npy");
    let read = |name: &str| std::fs::read(desk.path(name)).unwrap();
    assert_eq!(read("back.npy"), read("m.npy"));
    desk.ok("mask me.chladni -o all.npy");
    assert_ne!(read("all.npy"), read("m.npy"));
    for (line, said) in [
        ("mask shape.obj -o x.npy", "say which region"),
        ("mask shape.obj --curved bumps -o x.stl", "ends in one of"),
        ("mask me.chladni --layer none -o x.npy", "no layer called none"),
        ("mask me.chladni --curved bumps -o x.npy", "brings its regions along"),
        ("mask shape.obj --curved bumps:0% -o x.npy", "share of the surface"),
        ("mask shape.obj --mask-channel red -o x.npy", "--mask"),
    ] {
        assert!(desk.refused(line).contains(said), "{line}");
    }
}

#[test]
fn a_gallery_is_drawn_bred_and_one_of_it_becomes_a_mesh() {
    let desk = Desk::new();
    let line = "caricature shape.obj --gallery -k 48 --seed 3 --size 320x240";
    let first = desk.ok(&format!("{line} -o first.png"));
    assert_eq!(first.lines().count(), 13, "{first}");
    assert_eq!(first, desk.ok(&format!("{line} -o other.png")).replace("other", "first"));
    let bred = desk.ok(&format!("{line} --choose 2,5 --lock model -o bred.png"));
    assert_ne!(first.lines().next(), bred.lines().next());
    for name in ["first.png", "bred.png"] {
        let picture = chladni_view::Picture::decode(&std::fs::read(desk.path(name)).unwrap()).unwrap();
        assert_eq!((picture.width, picture.height), (320, 240));
    }
    let single = desk.ok(&format!("{line} --choose 2,5 --lock model --variant 7 -o seventh.ply"));
    assert!(bred.contains(single.lines().next().unwrap()), "{single}");
    assert!(largest(&desk.mesh("seventh.ply").positions, &desk.mesh("shape.obj").positions) > 0.01);
    desk.ok(&format!("{line} --surprise -o surprise.glb"));
    assert!(desk.refused(&format!("{line} --choose 13 -o x.png")).contains("from 1 to 12"));
    assert!(desk.refused(&format!("{line} -o x.obj")).contains(".png"));
    assert!(desk.refused(&format!("{line} --lock nose -o x.png")).contains("templates"));
}
