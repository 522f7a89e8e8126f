//! Material libraries of OBJ files: what is read from them, and where they are written.

#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

use std::fs;
use std::path::Path;

use chladni_mesh::{Appearance, Format, Material, Mended, Texture, TriMesh, load_mesh, read_mesh, save_mesh};

const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl wood\nf 1 2 3\n";
const PICTURE: &[u8] = b"\x89PNG\r\n\x1a\nnot really";

fn triangle_of(material: Material) -> TriMesh {
    TriMesh {
        positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
        triangles: vec![[0, 1, 2]],
        appearance: Appearance {
            materials: vec![material],
            face_materials: vec![Some(0)],
            ..Appearance::default()
        },
    }
}

fn only_material(path: &Path) -> Material {
    load_mesh(path).unwrap().mesh.appearance.materials.remove(0)
}

#[test]
fn meshes_that_are_saved_at_once_keep_their_own_textures_and_libraries() {
    for _ in 0..5 {
        let folder = tempfile::tempdir().unwrap();
        let start = std::sync::Barrier::new(8);
        let bytes = |i: u8| [&b"\x89PNG\r\n\x1a\n"[..], &[i; 1 << 16]].concat();
        let path = |i: u8| folder.path().join(format!("{i}.obj"));
        let save = |i: u8| {
            let texture = Texture { name: "skin.png".into(), bytes: bytes(i).into() };
            let mesh = triangle_of(Material { base_color_texture: Some(texture), ..Material::named("skin") });
            start.wait();
            save_mesh(&mesh, &path(i)).unwrap();
        };
        std::thread::scope(|scope| {
            for i in 0..8 {
                let save = &save;
                scope.spawn(move || save(i));
            }
        });
        for i in 0..8 {
            assert_eq!(only_material(&path(i)).base_color_texture.unwrap().bytes[..], bytes(i), "{i}");
        }
    }
}

#[test]
fn a_library_of_another_mesh_is_not_replaced() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    fs::write(at("pack.mtl"), "newmtl wood\nKd 1 0 0\n").unwrap();
    fs::write(at("chair.obj"), format!("mtllib pack.mtl\n{TRIANGLE}")).unwrap();
    let [green, blue] = [[0.0, 1.0, 0.0, 1.0], [0.0, 0.0, 1.0, 1.0]]
        .map(|base_color| Material { base_color, ..Material::named("wood") });
    for material in [&green, &blue] {
        // The second time into its own library.
        save_mesh(&triangle_of(material.clone()), &at("pack.obj")).unwrap();
        assert_eq!(only_material(&at("pack.obj")).base_color, material.base_color);
        assert_eq!(only_material(&at("chair.obj")).base_color, [1.0, 0.0, 0.0, 1.0]);
    }
    assert!(at("pack-1.mtl").is_file() && !at("pack-2.mtl").exists());
    // Two names of which the library's makes one.
    save_mesh(&triangle_of(green.clone()), &at("a#1.obj")).unwrap();
    save_mesh(&triangle_of(blue.clone()), &at("a_1.obj")).unwrap();
    assert_eq!(only_material(&at("a#1.obj")).base_color, green.base_color);
    assert_eq!(only_material(&at("a_1.obj")).base_color, blue.base_color);
}

#[test]
fn what_is_no_file_at_a_picture_s_name_is_left_alone() {
    let folder = tempfile::tempdir().unwrap();
    let picture = Texture { name: "wood.png".into(), bytes: PICTURE.into() };
    let path = folder.path().join("out.obj");
    fs::create_dir(folder.path().join("wood.png")).unwrap();
    let material = Material { base_color_texture: Some(picture), ..Material::named("wood") };
    save_mesh(&triangle_of(material), &path).unwrap();
    assert_eq!(only_material(&path).base_color_texture.unwrap().name, "out-1-wood.png");
}

#[cfg(unix)]
#[test]
fn a_library_is_not_written_through_a_link() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    fs::write(at("other"), "not a library").unwrap();
    for (link, target) in [("out.mtl", "other"), ("new.mtl", "nothing")] {
        std::os::unix::fs::symlink(target, at(link)).unwrap();
        let path = at(link).with_extension("obj");
        fs::write(&path, format!("mtllib {link}\n{TRIANGLE}")).unwrap();
        for base_color in [[0.0, 1.0, 0.0, 1.0], [0.0, 0.0, 1.0, 1.0]] {
            let material = Material { base_color, ..Material::named("wood") };
            save_mesh(&triangle_of(material), &path).unwrap();
            assert_eq!(only_material(&path).base_color, base_color, "{link}");
        }
    }
    assert_eq!(fs::read(at("other")).unwrap(), b"not a library");
    assert!(!at("nothing").exists() && at("out-1.mtl").is_file() && !at("out-2.mtl").exists());
}

#[test]
fn a_library_that_is_named_twice_is_read_once() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    fs::write(at("a.mtl"), "newmtl wood\nNs 12\n").unwrap();
    fs::write(at("b.mtl"), "newmtl wood\nNs 15\nKd 0 1 0\n").unwrap();
    fs::write(at("in.obj"), format!("mtllib a.mtl\nmtllib a.mtl\n{TRIANGLE}")).unwrap();
    assert_eq!(only_material(&at("in.obj")).other_statements, ["Ns 12"]);
    fs::write(at("in.obj"), format!("mtllib a.mtl\nmtllib b.mtl\n{TRIANGLE}")).unwrap();
    assert_eq!(only_material(&at("in.obj")).other_statements, ["Ns 15"]);
}

#[test]
fn options_and_statements_that_are_not_understood_are_written_as_they_were_read() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    fs::write(at("wood.png"), PICTURE).unwrap();
    fs::write(at("in.obj"), format!("mtllib in.mtl\n{TRIANGLE}")).unwrap();
    let statements = ["Kd spectral wood.rfl 1", "d -halo 0.66", "map_Kd -s 2 2 1 wood.png", "Ns 12"];
    fs::write(at("in.mtl"), format!("newmtl wood\n{}\n", statements.join("\n"))).unwrap();
    let loaded = load_mesh(&at("in.obj")).unwrap();
    assert_eq!(loaded.mended, []);
    save_mesh(&loaded.mesh, &at("out.obj")).unwrap();
    let text = fs::read_to_string(at("out.mtl")).unwrap();
    for statement in statements {
        assert_eq!(text.lines().filter(|line| *line == statement).count(), 1, "{statement} in {text}");
    }
    assert_eq!(
        text.lines().filter(|line| line.starts_with("Kd") || line.starts_with("d ")).count(),
        2,
        "{text}"
    );
    assert_eq!(load_mesh(&at("out.obj")).unwrap().mesh, loaded.mesh);
}

#[test]
fn a_second_definition_replaces_all_of_the_first() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    fs::write(at("wood.png"), PICTURE).unwrap();
    fs::write(at("in.obj"), format!("mtllib in.mtl\n{TRIANGLE}")).unwrap();
    let first = "newmtl wood\nKd 1 0 0\nd .5\nmap_Kd -s 2 2 2 wood.png\nNs 12\n";
    fs::write(at("in.mtl"), format!("{first}newmtl wood\nNs 15\n")).unwrap();
    let expected = Material { other_statements: vec!["Ns 15".into()], ..Material::named("wood") };
    assert_eq!(only_material(&at("in.obj")), expected);
}

#[test]
fn one_statement_names_several_libraries_or_one_with_blanks() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    fs::write(at("in.obj"), format!("mtllib a.mtl none.mtl b.mtl\nmtllib ./b.mtl\n{TRIANGLE}")).unwrap();
    fs::write(at("b.mtl"), "newmtl wood\nNs 15\n").unwrap();
    fs::write(at("a.mtl"), "newmtl wood\nNs 12\n").unwrap();
    let loaded = load_mesh(&at("in.obj")).unwrap();
    assert_eq!(loaded.mesh.appearance.materials[0].other_statements, ["Ns 15"]);
    let names: Vec<String> = loaded.mended.iter().map(ToString::to_string).collect();
    assert!(names.len() == 1 && names[0].starts_with("none.mtl could not"), "{names:?}");
    fs::write(at("a.mtl none.mtl b.mtl"), "newmtl wood\nNs 7\n").unwrap();
    fs::remove_file(at("b.mtl")).unwrap();
    assert_eq!(only_material(&at("in.obj")).other_statements, ["Ns 7"]);
}

#[test]
fn a_picture_s_name_ends_as_pictures_names_do() {
    let folder = tempfile::tempdir().unwrap();
    for (name, written) in [("albedo.001", "albedo.001.png"), ("a.PNG", "a.PNG"), ("b", "b.png")] {
        let picture = Texture { name: name.into(), bytes: PICTURE.into() };
        let material = Material { base_color_texture: Some(picture), ..Material::named("wood") };
        let path = folder.path().join("out.obj");
        save_mesh(&triangle_of(material), &path).unwrap();
        assert_eq!(only_material(&path).base_color_texture.unwrap().name, written);
    }
}

#[test]
fn a_picture_is_found_again_whatever_it_and_the_mesh_are_called() {
    let long = "\u{e4}".repeat(150);
    let names = [" skin", "\u{a0}skin.png", "\u{3000}skin", "sk\nin", "-clamp on", "sk\0in.png", " ", &long];
    let meshes = ["out.obj", " head.obj", "-head.obj", "\u{3000}.obj"];
    for (name, mesh) in names.iter().flat_map(|name| meshes.map(|mesh| (name, mesh))) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(mesh);
        // The second picture of the name needs a number.
        for last in [b"1", b"2"] {
            let bytes = [PICTURE, last].concat();
            let picture = Texture { name: (*name).into(), bytes: bytes.clone().into() };
            let material = Material { base_color_texture: Some(picture), ..Material::named("wood") };
            save_mesh(&triangle_of(material), &path).unwrap();
            let loaded = load_mesh(&path).unwrap();
            assert_eq!(loaded.mended, [], "{name:?} beside {mesh:?}");
            let found = loaded.mesh.appearance.materials[0].base_color_texture.clone().unwrap();
            assert_eq!(found.bytes[..], bytes, "{name:?} beside {mesh:?}");
        }
    }
}

#[test]
fn where_no_name_would_do_the_reason_is_given() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("file"), "").unwrap();
    let material = Material::named("wood");
    let why = save_mesh(&triangle_of(material), &folder.path().join("file/out.obj")).unwrap_err();
    assert!(!why.to_string().contains("no free name"), "{why}");
}

#[test]
fn a_channel_slightly_above_one_is_no_byte() {
    let obj = |channel: &str| format!("v 0 0 0 {channel} .5 .25\nv 1 0 0 1 1 1\nv 0 1 0 1 1 1\nf 1 2 3\n");
    let off = |channel: &str| {
        format!("COFF\n3 1 0\n0 0 0 {channel} .5 .25 1\n1 0 0 1 1 1 1\n0 1 0 1 1 1 1\n3 0 1 2\n")
    };
    let colors =
        |text: String, format| read_mesh(text.as_bytes(), format).unwrap().mesh.appearance.colors.unwrap();
    for (slightly, full) in [(obj("1.0000001"), obj("1")), (off("1.0000001"), off("1"))] {
        let format = if full.starts_with("COFF") { Format::Off } else { Format::Obj };
        let found = colors(slightly, format);
        assert_eq!(found, colors(full, format));
        assert_eq!(found[1], [1.0; 4]);
    }
    let bytes = colors("v 0 0 0 255 0 0\nv 1 0 0 0 0 0\nv 0 1 0 1 1 1\nf 1 2 3\n".into(), Format::Obj);
    assert!(bytes[0][0] == 1.0 && bytes[2][0] < 0.01);
}

#[test]
fn colors_that_zbrush_keeps_in_comments_are_those_of_the_vertices() {
    let text = "# File\nv 0 0 0\nv 1 0 0\nv 0 1 0\n#MRGB ffFF0000ff00ff00\n#MRGB ff0000ff\nf 1 2 3\n";
    let found = read_mesh(text.as_bytes(), Format::Obj).unwrap();
    let colors = found.mesh.appearance.colors.unwrap();
    assert_eq!(colors, [[1.0, 0.0, 0.0, 1.0], [0.0, 1.0, 0.0, 1.0], [0.0, 0.0, 1.0, 1.0]]);
    // Those of another number of vertices are no colors, and said to be left out.
    let fewer = text.replace("#MRGB ff0000ff\n", "");
    let found = read_mesh(fewer.as_bytes(), Format::Obj).unwrap();
    assert!(found.mesh.appearance.colors.is_none());
    let is_said =
        |mended: &Mended| matches!(mended, Mended::LeftOut(what) if what.contains("painted colors"));
    assert!(found.mended.iter().any(is_said), "{:?}", found.mended);
}

#[test]
fn number_signs_belong_to_names_where_there_is_such_a_file_or_material() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let names = ["Material #1", "Material #2", "red # the red one", "red"];
    let faces = names.map(|name| format!("usemtl {name}\nf 1 2 3\n")).concat();
    fs::write(at("in.obj"), format!("mtllib in#1.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\n{faces}")).unwrap();
    let library = "newmtl Material #1\nmap_Kd wood#2.png\nmap_Bump bump#3.png # bumps\n\
         newmtl Material #2\nmap_Kd -s 2 2 2 wood.png # oak\nnewmtl red # a color\nKd 1 0 0\n";
    fs::write(at("in#1.mtl"), library).unwrap();
    fs::write(at("wood#2.png"), PICTURE).unwrap();
    fs::write(at("wood.png"), PICTURE).unwrap();
    let loaded = load_mesh(&at("in.obj")).unwrap();
    assert_eq!(loaded.mended, []);
    let look = loaded.mesh.appearance;
    let names: Vec<&str> = look.materials.iter().map(|material| material.name.as_str()).collect();
    assert_eq!(names, ["Material #1", "Material #2", "red"]);
    assert_eq!(look.face_materials, [Some(0), Some(1), Some(2), Some(2)]);
    let texture = |i: usize| look.materials[i].base_color_texture.as_ref().map(|texture| &*texture.name);
    assert_eq!([0, 1, 2].map(texture), [Some("wood#2.png"), Some("wood.png"), None]);
    assert_eq!(look.materials[0].other_statements, ["map_Bump bump#3.png"]);
    assert_eq!(look.materials[2].base_color, [1.0, 0.0, 0.0, 1.0]);
    // The name of a library, too, may be followed by a comment.
    fs::write(at("in.obj"), format!("mtllib in.mtl # its look\n{TRIANGLE}")).unwrap();
    fs::write(at("in.mtl"), "newmtl wood\nNs 12\n").unwrap();
    assert_eq!(only_material(&at("in.obj")).other_statements, ["Ns 12"]);
    // Pictures and libraries that cannot be read keep their number signs, too, but not their comments.
    fs::write(at("in.mtl"), "newmtl wood\nmap_Kd wood#2.tga # oak\n").unwrap();
    assert_eq!(only_material(&at("in.obj")).base_color_texture.unwrap().name, "wood#2.tga");
    for (statement, name) in [("none.mtl # its look", "none.mtl"), ("none#2.mtl", "none#2.mtl")] {
        fs::write(at("in.obj"), format!("mtllib {statement}\n{TRIANGLE}")).unwrap();
        let mended = load_mesh(&at("in.obj")).unwrap().mended;
        assert!(mended[0].to_string().starts_with(&format!("{name} could not")), "{mended:?}");
    }
}

#[test]
fn a_texture_is_named_from_the_folder_of_the_mesh() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    fs::create_dir(at("mat")).unwrap();
    fs::write(at("mat/skin.png"), PICTURE).unwrap();
    fs::write(at("mat/skin.tga"), "no picture that is read").unwrap();
    fs::write(at("mat/in.mtl"), "newmtl wood\nmap_Kd skin.png\n").unwrap();
    fs::write(at("in.obj"), format!("mtllib mat/in.mtl\n{TRIANGLE}")).unwrap();
    let texture = only_material(&at("in.obj")).base_color_texture.unwrap();
    assert_eq!((&*texture.name, &*texture.bytes), ("mat/skin.png", PICTURE));
    fs::write(at("mat/in.mtl"), "newmtl wood\nmap_Kd .\\skin.tga\n").unwrap();
    save_mesh(&load_mesh(&at("in.obj")).unwrap().mesh, &at("out.obj")).unwrap();
    let written = fs::read_to_string(at("out.mtl")).unwrap();
    assert!(written.contains("map_Kd mat/skin.tga\n"), "{written}");
}
