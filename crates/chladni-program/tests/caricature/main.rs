//! `chladni caricature` and `chladni project`, run as a user would.

#![allow(
    clippy::unwrap_used,
    clippy::print_stderr,
    reason = "a panic is how a test fails, and a skipped one says so"
)]

#[path = "../archive/mod.rs"]
mod archive;
mod formats;
mod pictures;
mod projects;
mod proxies;
mod regions;

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
fn a_recipe_reads_its_own_shape_only_where_a_layer_names_places_of_it() {
    let desk = Desk::new();
    save_mesh(&lump(1.0), &desk.path("lost.obj")).unwrap();
    std::fs::create_dir(desk.path("many")).unwrap();
    save_mesh(&lump(2.0), &desk.path("many/large.ply")).unwrap();
    std::fs::write(desk.path("marks.txt"), "0 0\n").unwrap();
    desk.ok("project new lost.obj -o free.chladni --harmonics 16");
    for template in ["ellipsoid", "shape.obj --match same", "self:lowpass=4"] {
        desk.ok(&format!("project add-layer free.chladni --mu -1 --template {template}"));
    }
    let naming = [
        "sphere --region 13,0,0,2",
        "sphere --curved bumps",
        "sphere:10,0,0,3",
        "shape.obj --landmarks marks.txt",
    ];
    for (number, template) in naming.iter().enumerate() {
        desk.ok(&format!("project new lost.obj -o {number}.chladni --harmonics 16"));
        desk.ok(&format!("project add-layer {number}.chladni --template {template}"));
    }
    std::fs::remove_file(desk.path("lost.obj")).unwrap();
    desk.ok("caricature many/large.ply --recipe free.chladni -o one.ply");
    desk.ok("caricature --recipe free.chladni --batch many -o out");
    let [one, of_batch] = ["one.ply", "out/large.ply"].map(|name| desk.mesh(name).positions);
    assert_eq!(one, of_batch);
    assert!(largest(&one, &lump(2.0).positions) > 0.05);
    assert!(desk.refused("caricature --recipe free.chladni -o own.ply").contains("lost.obj"));
    for (number, template) in naming.iter().enumerate() {
        let said = desk.refused(&format!("caricature shape.obj --recipe {number}.chladni -o other.ply"));
        assert!(said.contains("lost.obj"), "{template}: {said}");
    }
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
    // A texture that is called as its mesh is.
    std::fs::write(desk.path("many/head.v1.png"), "a texture").unwrap();
    let said = desk.refused("caricature --recipe p.chladni --batch many -o out2 --render many");
    assert!(said.contains("pictures there would replace"), "{said}");
    assert_eq!(std::fs::read(desk.path("many/head.v1.png")).unwrap(), b"a texture");
}

#[cfg(unix)]
#[test]
fn a_batch_replaces_no_shape_that_a_link_leads_to() {
    let desk = Desk::new();
    desk.ok("project new shape.obj -o p.chladni -k 16");
    desk.ok("project add-layer p.chladni --template self:scale=0.5");
    for folder in ["many", "out"] {
        std::fs::create_dir(desk.path(folder)).unwrap();
    }
    save_mesh(&lump(1.0), &desk.path("many/a.obj")).unwrap();
    std::os::unix::fs::symlink(desk.path("many/a.obj"), desk.path("out/a.obj")).unwrap();
    let before = std::fs::read(desk.path("many/a.obj")).unwrap();
    assert!(desk.refused("caricature --recipe p.chladni --batch many -o out").contains("one of the shapes"));
    assert_eq!(std::fs::read(desk.path("many/a.obj")).unwrap(), before);
    let said = desk.refused("caricature --recipe p.chladni --batch many -o new --render new");
    assert!(said.contains("textures of the OBJ results"), "{said}");
}

#[test]
fn samples_of_a_batch_have_files_of_their_own() {
    let desk = Desk::new();
    desk.ok("project new shape.obj -o p.chladni -k 16");
    desk.ok("project add-layer p.chladni --template self:scale=0.5");
    let text = std::fs::read_to_string(desk.path("p.chladni")).unwrap();
    // A template that cannot be read: nothing is made.
    std::fs::write(desk.path("broken.obj"), "v 0 0\n").unwrap();
    std::fs::write(desk.path("p.chladni"), text.replace("self:scale=0.5", "broken.obj")).unwrap();
    std::fs::write(desk.path("list.txt"), "sample:portrait?nose=0.3\nsample:portrait?nose=0.6\n").unwrap();
    let said = desk.refused("caricature --recipe p.chladni --batch list.txt -o .");
    assert!(said.contains("2 of 2 shapes failed") && said.contains("broken.obj"), "{said}");
}

#[test]
fn a_batch_whose_results_cannot_be_written_fails_with_code_1() {
    let desk = Desk::new();
    desk.ok("project new shape.obj -o p.chladni --harmonics 16");
    desk.ok("project add-layer p.chladni --template self:scale=0.5");
    std::fs::create_dir_all(desk.path("out/a.obj/new")).unwrap();
    std::fs::create_dir(desk.path("many")).unwrap();
    save_mesh(&lump(1.0), &desk.path("many/a.obj")).unwrap();
    let failed = |out: &str| {
        let run = desk.run(&format!("caricature --recipe p.chladni --batch many -o {out}"));
        assert_eq!(run.status.code(), Some(1));
        String::from_utf8(run.stderr).unwrap()
    };
    let said = failed("out");
    assert!(said.contains("1 of 1 shapes failed"), "{said}");
    // A folder that takes no files is found before the work.
    if cfg!(target_os = "linux") {
        let said = failed("/proc");
        assert!(said.contains("/proc") && !said.contains("shapes failed"), "{said}");
    }
    // A folder in it that is called new is in nobody's way.
    desk.ok("caricature --recipe p.chladni --batch many -o out/a.obj");
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
        ("caricature shape.obj self:layer=1 -o out.obj", "result of layer 1, which has to be below it"),
        ("caricature shape.obj self:layer=1 --gallery -o out.png", "no layers to be compared with"),
        (
            "project add-layer good.chladni --template self:layer=1",
            "result of layer 1, which has to be below it",
        ),
        ("caricature sample:nobody ellipsoid -o out.obj", "nobody"),
        ("caricature shape.obj ellipsoid -o out.obj --mu 1e9", "μ"),
        ("caricature shape.obj ellipsoid -o out.obj --model loud", "loud"),
        ("caricature shape.obj ellipsoid -o out.obj --region 1,2,3", "x,y,z,radius"),
        ("caricature shape.obj ellipsoid -o out.obj --scale-curve 0:9", "scale curve"),
        ("caricature shape.obj ellipsoid -o out.obj --scale-curve 0:1,0.4:2,1:0", "percent of the size"),
        ("caricature shape.obj ellipsoid -o out.obj --cutoff 0", "cut-off"),
        ("caricature shape.obj shape.obj -o out.obj --infill 2", "the infill"),
        (
            "caricature shape.obj ellipsoid -o out.obj --infill 0.5",
            "--infill is for a template that is a mesh",
        ),
        ("caricature shape.obj ellipsoid -o out.obj --cutoff 40", "--cutoff is for the edge of a region"),
        (
            "caricature shape.obj ellipsoid -o out.obj --roll-off sharp",
            "--roll-off is for the edge of a region",
        ),
        ("caricature shape.obj ellipsoid -o out.obj --no-clamp", "--no-clamp is for the edge of a region"),
        ("caricature shape.obj ellipsoid -o out.obj --region 13,0,0,2 --no-clamp", "--roll-off sharp, too"),
        ("project add-layer good.chladni --template sphere --no-clamp", "--roll-off sharp, too"),
        ("caricature shape.obj shape.obj --match same --landmarks marks.txt -o out.obj", "--landmarks lead"),
        ("match shape.obj shape.obj --method same --landmarks marks.txt", "--landmarks lead"),
        (
            "transfer shape.obj shape.obj shape.obj --match same --landmarks marks.txt -o out.obj",
            "--landmarks lead",
        ),
        ("caricature shape.obj ellipsoid --seed 5 -o out.obj", "--seed is for a template that is a mesh"),
        (
            "project add-layer good.chladni --template sphere --seed 5",
            "--seed is for a template that is a mesh",
        ),
        ("caricature shape.obj shape.obj --match same --seed 5 -o out.obj", "--seed is for a match"),
        ("match shape.obj --method ellipsoid --seed 4", "nor --seed"),
        ("match shape.obj shape.obj --method same --seed 4", "--seed is for a match"),
        ("mean shape.obj shape.obj --match same --seed 3 -o out.obj", "--seed is for a match"),
        ("mask shape.obj --curved bumps --as-colors -o out.npy", "--as-colors is for a .ply"),
        ("mask shape.obj --curved bumps --as-colors -o out.glb", "--as-colors is for a .ply"),
        ("caricature shape.obj --gallery --keep-triangles -o out.png", "--variant N or --surprise"),
        ("caricature shape.obj --gallery --show before -o out.png", "--show"),
        ("caricature shape.obj --gallery --sweep=-0.3,-0.6 -o out.png", "--sweep"),
        ("caricature shape.obj --gallery --turn-secs 2 -o out.png", "--turn-secs"),
        ("caricature shape.obj --gallery --resume -o out.png", "--resume"),
        ("caricature shape.obj --gallery --piece 1/2 -o out.png", "--piece"),
        ("caricature shape.obj ellipsoid --resume -o out.obj", "are for --batch"),
        ("caricature shape.obj ellipsoid --piece 1/2 -o out.obj", "are for --batch"),
        ("caricature --recipe good.chladni --batch list.txt --turn-secs 2 -o out", "--turn-secs"),
        ("caricature --recipe good.chladni --choose 3 -o out.obj", "are for --gallery"),
        ("caricature shape.obj ellipsoid --mu -1 --variant 3 -o out.obj", "are for --gallery"),
        ("caricature shape.obj --surprise -o out.obj", "are for --gallery"),
        ("caricature shape.obj --mu=-1,2 ellipsoid -o out.obj", "must be a number, such as -1.2"),
        ("caricature shape.obj ellipsoid --limb ears -o out.obj", "a number that parts --level prints"),
        ("caricature shape.obj elipsoid -o out.obj", "templates that are no files are ellipsoid, sphere"),
        ("caricature good.chladni -o out.obj", "give it as --recipe good.chladni"),
        ("caricature good.chladni ellipsoid -o out.obj", "a caricature project, not a mesh"),
        ("caricature --recipe shape.obj -o out.obj", "chladni project new shape.obj"),
        ("project show shape.obj", "chladni project new shape.obj"),
        ("shape.obj", "is a file, not a command: chladni open shape.obj opens it"),
        ("project good.chladni", "unrecognized subcommand"),
        ("caricature shape.obj self:lowpass=99 -k 16 -o out.obj", "a low-pass keeps is 99"),
        (
            "project add-layer good.chladni --template sphere --seed 9223372036854775808",
            "from 0 to 9223372036854775807",
        ),
        ("caricature shape.obj sphere:0,0,0 -o out.obj", "sphere:x,y,z,radius"),
        ("caricature shape.obj --gallery --lock model -o out.png", "--choose"),
        ("caricature shape.obj --gallery --surprise --lock model -o out.obj", "--lock"),
        ("caricature shape.obj --gallery --match icp -o out.png", "--match"),
        ("caricature shape.obj ellipsoid --gallery --rigid -o out.png", "--rigid"),
        ("caricature shape.obj ellipsoid --landmarks marks.txt -o out.obj", "--landmarks"),
        ("caricature shape.obj --gallery --variant 3 --size 320x240 -o out.obj", "--size"),
        ("caricature shape.obj --gallery --surprise --up y -o out.obj", "--up"),
        ("caricature shape.obj ellipsoid --view 0,0 -o out.obj", "--view"),
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
        ("basis shape.obj --iterative", "belong to --engine slepc"),
        ("basis shape.obj --engine slepc --ranks 0", "0 ranks: from 1 to"),
        ("basis shape.obj --engine slepc --ranks 99999", "99999 ranks: from 1 to"),
        ("basis shape.obj --engine slepc --ranks 4 --groups 3", "3 equal groups"),
        ("basis shape.obj --engine slepc --hosts absent.txt", "absent.txt"),
        ("basis shape.obj --engine slepc --threads 2", "--threads is for"),
        ("basis shape.obj -k 9 --threads 1025", "1025 threads: at most 1024 are possible"),
        ("basis shape.obj -o nowhere/b.npz", "its folder does not exist"),
        ("basis shape.obj -o b.npz --operator ./b.npz", "two results"),
        ("match shape.obj shape.obj --method sphere", "neither a template"),
        ("match shape.obj shape.obj --method nearest", "ellipsoid:x,y,z,a,b,c"),
        ("match shape.obj shape.obj --render out.jpg", ".png"),
        ("spectrum sample:tune --render out.jpg", ".png"),
        ("spectrum sample:tune --fps 1000 --bands 4096 --render out.png", "pixels is too large"),
        ("symmetry shape.obj --render nowhere/out.png", "its folder does not exist"),
        ("dance shape.obj sample:tune -o nowhere/out.gif", "its folder does not exist"),
        ("dance shape.obj sample:tune", "--output <FILM>|--frames <DIR>|--coefficients <C.npz>"),
        (
            "dance shape.obj sample:tune -o out.gif --lights moon",
            "[possible values: studio, soft, dramatic, stage]",
        ),
        ("dance shape.obj sample:tune -o out", "movement in .glb; for a folder use --frames"),
        ("dance shape.obj sample:tune -o out.gif --start 1:30", "a number of seconds, such as 90 or 1.5"),
        ("spectrum sample:tune --json --duration 20s", "a number of seconds, such as 90 or 1.5"),
        ("dance shape.obj sample:tune -o out.gif --preset shape.obj", "is a mesh: give it as MESH"),
        ("dance shape.obj sample:tune -o - --format mp4", "[possible values: rgba, y4m]"),
        // Before anything is read: what is impossible is not refused after minutes.
        ("dance absent.obj sample:tune -o out.gif --gain 99", "[0, 20]"),
        ("dance absent.obj sample:tune -o out.gif --mu 5", "[0, 1]"),
        ("dance absent.obj sample:tune -o out.gif --gallery 7", "6, 9, 12 or 16"),
        ("dance absent.obj sample:tune -o out.gif --draw cpu --synthesis gpu", "--draw cpu cannot see it"),
        ("dance absent.obj sample:tune -o out.gif --yaw inf", "--yaw inf"),
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
fn a_shape_with_few_vertices_dances_with_the_harmonics_it_has() {
    let desk = Desk::new();
    save_mesh(&samples::icosphere(0), &desk.path("few.obj")).unwrap();
    let dance = desk.run("dance few.obj sample:tune --coefficients c.npz --duration 0.1");
    let message = String::from_utf8(dance.stderr).unwrap();
    assert!(dance.status.success() && message.contains("12 harmonics instead of 512"), "{message}");
}

#[test]
fn symmetry_in_paper_mode_says_that_no_mirror_plane_was_looked_for() {
    let desk = Desk::new();
    let said = desk.ok("symmetry shape.obj --paper -k 12");
    assert!(said.contains("no mirror plane was looked for"), "{said}");
    assert!(!desk.ok("symmetry shape.obj -k 12").contains("looked for"));
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
    // A mesh that has no plain cotangent Laplacian is refused at once, with the place.
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
    for line in ["basis fan.obj -k 3", "info fan.obj"] {
        let said = desk.ok(line);
        assert!(said.contains("tufted cover") && said.contains("edge flip"), "{line}: {said}");
    }
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
    // A GLB holds the original with sliders.
    desk.ok("caricature shape.obj ellipsoid -k 64 --mu -0.3 -o much.glb");
    for (expression, is_one) in [("much.glb", true), ("shape.obj", true), ("much.obj", false)] {
        let output = desk.run(&format!("transfer shape.obj {expression} large.obj --match same -o out.obj"));
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(said.contains("are one shape"), is_one, "{expression}: {said}");
        assert_eq!(said.contains("a GLB of"), expression == "much.glb", "{expression}: {said}");
    }
}

#[test]
fn harmonics_say_what_was_left_out_of_the_mesh() {
    let desk = Desk::new();
    let mut text = std::fs::read_to_string(desk.path("shape.obj")).unwrap();
    text.push_str("f 1 2\n");
    std::fs::write(desk.path("short.obj"), text).unwrap();
    let output = desk.run("basis short.obj -k 8");
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success() && said.contains("fewer than three corners: left out"), "{said}");
}

/// Linux has names that are no text.
#[cfg(target_os = "linux")]
#[test]
fn a_batch_takes_names_that_are_no_text() {
    use std::os::unix::ffi::OsStrExt;
    let desk = Desk::new();
    desk.ok("project new shape.obj -o p.chladni --harmonics 16");
    desk.ok("project add-layer p.chladni --template self:scale=0.5");
    std::fs::create_dir(desk.path("many")).unwrap();
    let name = std::ffi::OsStr::from_bytes(b"caf\xe9.obj");
    save_mesh(&lump(1.0), &desk.path("many").join(name)).unwrap();
    desk.ok("caricature --recipe p.chladni --batch many -o out");
    assert!(desk.path("out").join(name).exists());
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
