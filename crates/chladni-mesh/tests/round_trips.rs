//! Meshes that are written and read again are the same, as far as the format can hold them.

#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

use chladni_mesh::{
    Appearance, CornerUvs, Format, Material, MeshError, MorphAnimation, MorphTarget, Texture, TriMesh,
    add_morph_targets_in, far_center, load_mesh, read_mesh, samples, save_mesh, write_animated_glb,
    write_glb, write_mesh,
};
use chladni_task::Task;

const FILES: [&str; 12] = [
    "heads/reference.obj",
    "heads/target.obj",
    "animals/spot.obj",
    "shapes/suzanne.obj",
    "nasty/capsule.obj",
    "nasty/platonic_shelf.obj",
    "nasty/featuretype.ply",
    "nasty/truck.obj",
    "formats/fuze.obj",
    "formats/fuze.ply",
    "formats/quadknot.obj",
    "formats/rgb_cube_with_primitives.gltf",
];

fn files() -> impl Iterator<Item = (&'static str, TriMesh)> {
    FILES.into_iter().filter_map(|name| {
        let path = chladni_testdata::shared(&format!("meshes/{name}"))?;
        Some((name, load_mesh(&path).unwrap().mesh))
    })
}

fn round_trip(mesh: &TriMesh, format: Format) -> TriMesh {
    read_mesh(&write_mesh(mesh, format).unwrap(), format).unwrap().mesh
}

fn close_colors(a: &TriMesh, b: &TriMesh, tolerance: f32) -> bool {
    match (&a.appearance.colors, &b.appearance.colors) {
        (None, None) => true,
        (Some(a), Some(b)) => {
            let pairs = a.iter().flatten().zip(b.iter().flatten());
            a.len() == b.len() && pairs.into_iter().all(|(a, b)| (a - b).abs() <= tolerance)
        }
        _ => false,
    }
}

#[test]
fn obj_keeps_everything() {
    for (name, mesh) in files() {
        let back = round_trip(&mesh, Format::Obj);
        assert_eq!(back.positions, mesh.positions, "{name}");
        assert_eq!(back.triangles, mesh.triangles, "{name}");
        assert_eq!(back.appearance.polygons, mesh.appearance.polygons, "{name}");
        assert_eq!(back.appearance.uvs, mesh.appearance.uvs, "{name}");
        assert_eq!(back.triangle_materials(), mesh.triangle_materials(), "{name}");
        assert!(close_colors(&back, &mesh, 2e-6), "{name}");
        // A second trip changes nothing at all.
        assert_eq!(
            write_mesh(&back, Format::Obj).unwrap(),
            write_mesh(&round_trip(&back, Format::Obj), Format::Obj).unwrap()
        );
    }
}

#[test]
fn ply_keeps_polygons_uvs_and_eight_bit_colors() {
    for (name, mesh) in files() {
        let back = round_trip(&mesh, Format::Ply);
        assert_eq!(back.positions, mesh.positions, "{name}");
        assert_eq!(back.triangles, mesh.triangles, "{name}");
        assert_eq!(back.appearance.polygons, mesh.appearance.polygons, "{name}");
        assert_eq!(back.triangle_uvs(), mesh.triangle_uvs(), "{name}");
        assert!(close_colors(&back, &mesh, 6e-3), "{name}");
    }
}

#[test]
fn glb_keeps_vertices_uvs_materials_and_textures() {
    for (name, mesh) in files() {
        let back = round_trip(&mesh, Format::Glb);
        let narrow: Vec<_> = mesh.positions.iter().map(|p| p.map(|x| f64::from(x as f32))).collect();
        assert_eq!(back.positions, narrow, "{name}");
        if picture(&mesh).is_none() || mesh.appearance.colors_tint {
            assert!(close_colors(&back, &mesh, 0.0), "{name}");
        } else {
            assert!(back.appearance.colors.is_none(), "{name}");
        }
        // Primitives sort the triangles by material; within one the order stays.
        let sorted = |mesh: &TriMesh| {
            let uvs = mesh.triangle_uvs().unwrap_or_else(|| vec![[[0.0; 2]; 3]; mesh.triangles.len()]);
            let names: Vec<String> = mesh
                .triangle_materials()
                .iter()
                .map(|m| m.map_or(String::new(), |m| mesh.appearance.materials[m as usize].name.clone()))
                .collect();
            let mut all: Vec<_> = mesh.triangles.iter().copied().zip(uvs).zip(names).collect();
            all.sort_by(|(a, a_name), (b, b_name)| a_name.cmp(b_name).then(a.0.cmp(&b.0)));
            all
        };
        for ((a, a_name), (b, b_name)) in sorted(&back).into_iter().zip(sorted(&mesh)) {
            assert_eq!((a.0, a_name), (b.0, b_name), "{name}");
            for (a, b) in a.1.as_flattened().iter().zip(b.1.as_flattened()) {
                assert!((a - b).abs() < 1e-6, "{name}");
            }
        }
        assert_eq!(picture(&back), picture(&mesh), "{name}");
    }
}

/// The first picture that was found.
fn picture(mesh: &TriMesh) -> Option<&[u8]> {
    mesh.base_color_texture().map(|texture| &*texture.bytes).filter(|bytes| !bytes.is_empty())
}

#[test]
fn stl_keeps_the_triangles() {
    for (name, mesh) in files() {
        let back = round_trip(&mesh, Format::Stl);
        assert_eq!(back.triangles.len(), mesh.triangles.len(), "{name}");
        for (a, b) in back.triangles.iter().flatten().zip(mesh.triangles.iter().flatten()) {
            let narrow = mesh.positions[*b as usize].map(|x| f64::from(x as f32));
            assert_eq!(back.positions[*a as usize], narrow, "{name}");
        }
    }
}

/// A tetrahedron with all that a mesh can have: a seam, two materials, colors, a texture.
fn dressed() -> TriMesh {
    let texture = Texture { name: "wood grain.png".into(), bytes: b"\x89PNG\r\n\x1a\nnot really"[..].into() };
    let wood = Material {
        base_color_texture: Some(texture),
        other_statements: vec!["Ns 12.5".into()],
        ..Material::named("wood panel")
    };
    let glass = Material { base_color: [0.25, 0.5, 1.0, 0.5], ..Material::named("glass") };
    TriMesh {
        positions: vec![[0.1, 1e-7, 1e20], [1.0 / 3.0, 0.0, -0.0], [0.0, 1.0, 0.3], [0.0, 0.1 + 0.2, 1.0]],
        triangles: vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]],
        appearance: Appearance {
            colors: Some(vec![[1.0, 0.0, 0.5, 1.0]; 4]),
            uvs: Some(CornerUvs {
                points: vec![[0.0, 0.25], [1.0, 0.0], [0.5, 0.75], [0.125, 0.5]],
                corners: vec![0, 1, 2, 3, 2, 1, CornerUvs::NONE, CornerUvs::NONE, CornerUvs::NONE, 1, 2, 3],
            }),
            materials: vec![wood, glass],
            face_materials: vec![Some(0), Some(0), Some(1), Some(1)],
            ..Appearance::default()
        },
    }
}

/// A sheet with a notch and an arrowhead, 7 in area, whose fans from the first corner fold over. Texture coordinates are at
/// (x/16, (y + 1)/4).
fn concave() -> TriMesh {
    let places = [[0, 0], [2, 0], [2, 1], [1, 1], [1, 2], [0, 2], [10, 2], [8, -1], [10, 0], [12, -1]];
    let mut obj = String::new();
    for [x, y] in places.map(|place| place.map(f64::from)) {
        obj.push_str(&format!("v {x} {y} 0\nvt {} {}\n", x / 16.0, (y + 1.0) / 4.0));
    }
    obj.push_str("f 2/2 3/3 4/4 5/5 6/6 1/1\nf 8/8 9/9 10/10 7/7\n");
    let loaded = read_mesh(obj.as_bytes(), Format::Obj).unwrap();
    assert_eq!(loaded.mended, []);
    loaded.mesh
}

#[test]
fn concave_faces_have_their_area_and_texture_coordinates_in_every_format() {
    let mesh = concave();
    assert_eq!(round_trip(&mesh, Format::Obj), mesh);
    let from_ply = round_trip(&mesh, Format::Ply);
    assert_eq!(from_ply.triangles, mesh.triangles);
    assert_eq!(from_ply.appearance.polygons, mesh.appearance.polygons);
    assert_eq!(from_ply.appearance.divided, mesh.appearance.divided);
    for back in [&mesh, &from_ply, &round_trip(&mesh, Format::Stl), &round_trip(&mesh, Format::Glb)] {
        assert!((chladni_mesh::surface::total_area(&back.positions, &back.triangles) - 7.0).abs() < 1e-12);
        let Some(uvs) = back.triangle_uvs() else { continue };
        for (triangle, uvs) in back.triangles.iter().zip(uvs) {
            let here = |v: u32| {
                let [x, y, _] = back.positions[v as usize];
                [x / 16.0, (y + 1.0) / 4.0].map(|c| c as f32)
            };
            assert_eq!(uvs, triangle.map(here));
        }
    }
}

#[test]
fn a_corner_without_a_texture_coordinate_takes_none_from_the_others_of_its_face() {
    let places = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 .25\nvt 1 0\nvt .5 .75\n";
    let obj = format!("{places}f 1/3 2/1 3/2 4\nf 4 3 2\n");
    let mesh = read_mesh(obj.as_bytes(), Format::Obj).unwrap().mesh;
    let loaded = read_mesh(&write_mesh(&mesh, Format::Ply).unwrap(), Format::Ply).unwrap();
    assert_eq!(loaded.mended, []);
    let of_corners = |mesh: &TriMesh| {
        let uvs = mesh.appearance.uvs.clone().unwrap();
        let point = |uv: &u32| uvs.points.get(*uv as usize).copied();
        uvs.corners.iter().map(point).collect::<Vec<Option<[f64; 2]>>>()
    };
    let expected = [Some([0.5, 0.75]), Some([0.0, 0.25]), Some([1.0, 0.0]), None, None, None, None];
    assert_eq!(of_corners(&mesh), expected);
    assert_eq!(of_corners(&loaded.mesh), expected);
}

#[test]
fn an_obj_brings_its_library_and_pictures_along() {
    let folder = tempfile::tempdir().unwrap();
    let mesh = dressed();
    std::fs::write(folder.path().join("wood grain.png"), "somebody else's").unwrap();
    let path = folder.path().join("out.obj");
    save_mesh(&mesh, &path).unwrap();
    save_mesh(&mesh, &path).unwrap();
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 4, "obj, mtl, picture, somebody else's");
    let loaded = load_mesh(&path).unwrap();
    assert_eq!(loaded.mended, []);
    let mut expected = mesh;
    expected.appearance.materials[0].base_color_texture.as_mut().unwrap().name =
        "out-1-wood grain.png".into();
    for material in &mut expected.appearance.materials {
        // Through sRGB text with six digits and back.
        for c in &mut material.base_color {
            *c = (*c * 1e5).round() / 1e5;
        }
    }
    let mut back = loaded.mesh;
    for c in back.appearance.materials.iter_mut().flat_map(|m| &mut m.base_color) {
        *c = (*c * 1e5).round() / 1e5;
    }
    let colors = |mesh: &mut TriMesh| mesh.appearance.colors.take();
    assert!(close_colors(&back, &expected, 2e-6));
    colors(&mut back);
    colors(&mut expected);
    assert_eq!(back, expected);
}

#[test]
fn an_obj_named_with_a_comment_sign_finds_its_library_and_pictures() {
    let folder = tempfile::tempdir().unwrap();
    let mut mesh = dressed();
    mesh.appearance.materials[0].base_color_texture.as_mut().unwrap().name = "take #2/oak #7.png".into();
    let path = folder.path().join("scan #3.obj");
    save_mesh(&mesh, &path).unwrap();
    let loaded = load_mesh(&path).unwrap();
    assert_eq!(loaded.mended, []);
    let materials =
        |mesh: &TriMesh| mesh.appearance.materials.iter().map(|m| m.name.clone()).collect::<Vec<_>>();
    assert_eq!(materials(&loaded.mesh), ["wood panel", "glass"]);
    assert_eq!(picture(&loaded.mesh), picture(&mesh));
}

#[test]
fn saving_over_a_folder_fails_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("no such folder/out.ply");
    let message = save_mesh(&dressed(), &path).unwrap_err().to_string();
    assert!(message.contains("out.ply"), "{message}");
    let message = save_mesh(&dressed(), &folder.path().join("out.doc")).unwrap_err().to_string();
    assert!(message.contains(".doc"), "{message}");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[test]
fn a_sliders_glb_reads_as_the_shape_at_rest() {
    let mesh = samples::icosphere(2);
    let displacements = mesh.positions.iter().map(|p| [0.0, 0.0, p[2]]).collect();
    let target = MorphTarget { name: "longer nose".into(), displacements };
    let bytes =
        write_glb(&mesh, &[target.clone(), MorphTarget { name: "b".into(), ..target.clone() }]).unwrap();
    let loaded = read_mesh(&bytes, Format::Glb).unwrap();
    assert_eq!(loaded.mesh.triangles, mesh.triangles);
    let json = String::from_utf8_lossy(&bytes);
    assert!(json.contains(r#""targetNames":["longer nose","b"]"#) && json.contains(r#""weights":[0.0,0.0]"#));
    let both = write_glb(&mesh, &[target.clone(), target]).unwrap();
    let json = String::from_utf8_lossy(&both);
    assert!(json.contains(r#""targetNames":["longer nose","longer nose 2"]"#), "names are distinct");
    let short = MorphTarget { name: "short".into(), displacements: vec![[0.0; 3]] };
    assert!(write_glb(&mesh, &[short]).unwrap_err().to_string().contains("short"));
}

#[test]
fn a_texture_coordinate_beyond_32_bits_is_no_glb() {
    let mut mesh = samples::icosphere(0);
    let corners = vec![0; 3 * mesh.triangles.len()];
    mesh.appearance.uvs = Some(CornerUvs { points: vec![[0.0, 1e39]], corners });
    let refused = write_glb(&mesh, &[]).unwrap_err().to_string();
    assert!(refused.contains("texture coordinate"), "{refused}");
}

#[test]
fn a_shape_too_small_for_32_bits_is_refused_where_there_are_no_more() {
    let sized = |size: f64| {
        let mut mesh = samples::icosphere(1);
        mesh.positions.as_flattened_mut().iter_mut().for_each(|x| *x *= size);
        mesh
    };
    for format in [Format::Stl, Format::Glb] {
        for size in [1e-35, 1e-200] {
            let refused = write_mesh(&sized(size), format).unwrap_err().to_string();
            assert!(refused.contains("too small for 32 bits"), "{refused}");
        }
        // One in a single place has no form to lose.
        assert!(write_mesh(&sized(0.0), format).is_ok());
        let back = round_trip(&sized(1e-29), format);
        let least = back.positions.as_flattened().iter().fold(0.0, |least: f64, x| least.min(*x));
        assert!((least + 1e-29).abs() < 1e-31, "{least}");
    }
    for format in [Format::Obj, Format::Ply] {
        assert_eq!(round_trip(&sized(1e-35), format).positions, sized(1e-35).positions);
    }
}

#[test]
fn a_glb_far_from_the_origin_keeps_its_form() {
    let mut mesh = samples::icosphere(2);
    mesh.positions
        .iter_mut()
        .for_each(|[x, y, z]| [*x, *y, *z] = [*x + 412_345.7, *y + 5_654_321.0, *z + 230.0]);
    let target =
        MorphTarget { name: "up".into(), displacements: vec![[0.0, 0.0, 0.5]; mesh.positions.len()] };
    let bytes = write_glb(&mesh, std::slice::from_ref(&target)).unwrap();
    let back = read_mesh(&bytes, Format::Glb).unwrap().mesh;
    assert_eq!(back.triangles, mesh.triangles);
    let pairs = back.positions.iter().flatten().zip(mesh.positions.iter().flatten());
    assert!(pairs.into_iter().all(|(a, b)| (a - b).abs() < 1e-6));
    let patched = add_morph_targets_in(&bytes, &back, &[target]).unwrap();
    assert_eq!(read_mesh(&patched, Format::Glb).unwrap().mesh.positions, back.positions);
    // Elsewhere coordinates are those of the file.
    assert!(far_center(&samples::icosphere(2).positions).is_none());
}

#[test]
fn an_animated_glb_holds_every_weight_at_its_time() {
    let mesh = samples::icosphere(1);
    let displacements: Vec<[f64; 3]> = mesh.positions.iter().map(|p| [0.0, 0.0, p[2]]).collect();
    let target = |name: &str| MorphTarget { name: name.into(), displacements: displacements.clone() };
    let targets = [target("a"), target("b")];
    let (times_secs, weights) = ([0.0, 0.5, 1.5], [0.0, -1.0, 0.25, 0.5, 1.0, 0.0]);
    let dance = MorphAnimation { name: "dance", times_secs: &times_secs, weights: &weights };
    let bytes = write_animated_glb(&mesh, &targets, dance, &Task::new()).unwrap();
    assert_eq!(read_mesh(&bytes, Format::Glb).unwrap().mesh.triangles, mesh.triangles);
    let json_bytes = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
    let root: serde_json::Value = serde_json::from_slice(&bytes[20..20 + json_bytes]).unwrap();
    let data = &bytes[20 + json_bytes + 8..];
    let series = |accessor: &serde_json::Value| -> Vec<f32> {
        let accessor = &root["accessors"][accessor.as_u64().unwrap() as usize];
        let view = &root["bufferViews"][accessor["bufferView"].as_u64().unwrap() as usize];
        let from = view["byteOffset"].as_u64().unwrap() as usize;
        let count = accessor["count"].as_u64().unwrap() as usize;
        data[from..from + 4 * count].chunks(4).map(|b| f32::from_le_bytes(b.try_into().unwrap())).collect()
    };
    let animation = &root["animations"][0];
    assert_eq!(series(&animation["samplers"][0]["input"]), times_secs);
    assert_eq!(series(&animation["samplers"][0]["output"]), weights);
    assert_eq!(animation["channels"][0]["target"], serde_json::json!({ "node": 0, "path": "weights" }));
    let refused = |times_secs: &[f32], weights: &[f32]| {
        let animation = MorphAnimation { name: "", times_secs, weights };
        write_animated_glb(&mesh, &targets, animation, &Task::new()).unwrap_err().to_string()
    };
    assert!(refused(&[0.0], &[1.0]).contains("1 weights for 1 keys of 2 targets"));
    assert!(refused(&[1.0, 1.0], &[0.0; 4]).contains("ascend"));
    assert!(refused(&[0.0], &[f32::NAN, 0.0]).contains("finite"));
    let task = Task::new();
    task.cancel();
    let stopped = write_animated_glb(&mesh, &targets, dance, &task);
    assert!(matches!(stopped, Err(MeshError::Cancelled(_))));
}

/// The changes of normals of a morph target in a GLB.
fn target_normals(bytes: &[u8], target: usize) -> Vec<f32> {
    let json_bytes = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
    let root: serde_json::Value = serde_json::from_slice(&bytes[20..20 + json_bytes]).unwrap();
    let normal = &root["meshes"][0]["primitives"][0]["targets"][target]["NORMAL"];
    let accessor = &root["accessors"][normal.as_u64().unwrap() as usize];
    let view = &root["bufferViews"][accessor["bufferView"].as_u64().unwrap() as usize];
    let [from, length] = ["byteOffset", "byteLength"].map(|name| view[name].as_u64().unwrap() as usize);
    let data = &bytes[20 + json_bytes + 8..][from..from + length];
    data.chunks(4).map(|b| f32::from_le_bytes(b.try_into().unwrap())).collect()
}

#[test]
fn normals_of_a_dance_cancel_where_displacements_do() {
    let mesh = samples::icosphere(2);
    let target = |scale: f64| {
        let bent = |p: &[f64; 3]| [0.0, 0.5 * p[0] * p[0], 0.3 * p[1]].map(|x| scale * x);
        MorphTarget { name: String::new(), displacements: mesh.positions.iter().map(bent).collect() }
    };
    let animation = MorphAnimation { name: "dance", times_secs: &[0.0], weights: &[0.5, 1.0] };
    let dance = write_animated_glb(&mesh, &[target(1.0), target(-0.5)], animation, &Task::new()).unwrap();
    let [there, back] = [0, 1].map(|i| target_normals(&dance, i));
    assert!(there.iter().any(|x| x.abs() > 0.1));
    assert!(there.iter().zip(&back).all(|(a, b)| (0.5 * a + b).abs() < 1e-6));
    // They begin as those of a slider do.
    let slight = target_normals(&write_glb(&mesh, &[target(1e-4)]).unwrap(), 0);
    assert!(there.iter().zip(&slight).all(|(a, b)| (a - 1e4 * b).abs() < 1e-3));
}

#[test]
fn neither_black_nor_colors_of_vertices_darken_a_picture_in_a_glb() {
    let mut mesh = dressed();
    let black = [0.0, 0.0, 0.0, 1.0];
    mesh.appearance.materials[0].base_color = black;
    mesh.appearance.materials[1].base_color = black;
    let back = round_trip(&mesh, Format::Glb).appearance;
    assert_eq!([back.materials[0].base_color, back.materials[1].base_color], [[1.0; 4], black]);
    assert_eq!(back.colors, None);
    // As those of a glTF file are meant to.
    mesh.appearance.colors_tint = true;
    assert!(close_colors(&round_trip(&mesh, Format::Glb), &mesh, 0.0));
}

#[test]
fn what_does_not_belong_together_is_not_written() {
    let mut mesh = dressed();
    mesh.triangles.pop();
    assert!(write_mesh(&mesh, Format::Obj).is_err());
    for corners in [vec![[0, 1, 2]; 3], vec![[0, 1, 6]; 4]] {
        let mut mesh = concave();
        mesh.appearance.divided.insert(0, corners);
        assert!(write_mesh(&mesh, Format::Glb).is_err());
    }
    let mut mesh = dressed();
    mesh.triangles[0][0] = 4;
    assert!(write_mesh(&mesh, Format::Ply).is_err());
    let mut mesh = dressed();
    for x in [f64::NAN, f64::INFINITY, -1.1e75] {
        mesh.positions[0][0] = x;
        for format in [Format::Obj, Format::Ply, Format::Stl, Format::Glb] {
            let refused = write_mesh(&mesh, format).unwrap_err().to_string();
            assert!(refused.contains("coordinate"), "{format}: {refused}");
        }
    }
    mesh.positions[0][0] = 1e60;
    assert!(write_mesh(&mesh, Format::Obj).is_ok());
    assert!(write_mesh(&mesh, Format::Stl).is_err());
    assert!(write_mesh(&mesh, Format::Glb).is_err());
    assert!(write_mesh(&mesh, Format::Off).is_err());
}

/// Six triangles over one tetrahedron's vertices, each in a look of its own: OBJ tells materials
/// apart by their names alone, and glTF files often have none.
#[test]
fn materials_stay_apart_in_obj_whatever_they_are_called() {
    let names = ["", "", "skin #1", "skin #2", "back\\slash\\"];
    let color = |i: usize| [0.1 + 0.15 * i as f32, 0.5, 1.0 - 0.15 * i as f32, 1.0];
    let material = |(i, name): (usize, &&str)| Material { base_color: color(i), ..Material::named(name) };
    let mut mesh = dressed();
    mesh.triangles.extend([[0, 2, 1], [0, 1, 3]]);
    mesh.appearance = Appearance {
        materials: names.iter().enumerate().map(material).collect(),
        face_materials: vec![Some(0), Some(1), Some(2), Some(3), Some(4), None],
        ..Appearance::default()
    };
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("out.obj");
    save_mesh(&mesh, &path).unwrap();
    let back = load_mesh(&path).unwrap().mesh;
    for (i, material) in back.triangle_materials().into_iter().enumerate() {
        let found = material.map_or([1.0; 4], |m| back.appearance.materials[m as usize].base_color);
        let expected = if i < names.len() { color(i) } else { [1.0; 4] };
        let apart = found.iter().zip(expected).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        assert!(apart < 1e-5, "triangle {i}: {found:?} for {expected:?}");
    }
}

#[test]
fn number_signs_in_names_of_materials_survive_an_obj_with_its_library() {
    let names = ["Material #1", "Material", "Material #2", "#1", "a#b", "Material # 1", "#"];
    let mut mesh = dressed();
    mesh.triangles.extend([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]);
    let color = |i: usize| [0.125 * i as f32, 1.0, 0.0, 1.0];
    let material = |(i, name): (usize, &&str)| Material { base_color: color(i), ..Material::named(name) };
    // A face without a material comes last: its library has one more.
    let face_materials = (0..names.len() as u32).map(Some).chain([None]).collect();
    let materials = names.iter().enumerate().map(material).collect();
    mesh.appearance = Appearance { materials, face_materials, ..Appearance::default() };
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("out.obj");
    save_mesh(&mesh, &path).unwrap();
    let loaded = load_mesh(&path).unwrap();
    assert_eq!(loaded.mended, []);
    let found = loaded.mesh.appearance.materials;
    let found_names: Vec<&str> = found.iter().map(|material| material.name.as_str()).collect();
    assert_eq!(found_names, [&names[..], &["none"]].concat());
    for (i, material) in found[..names.len()].iter().enumerate() {
        assert!((material.base_color[0] - color(i)[0]).abs() < 1e-5, "{material:?}");
    }
    // Without a library they would begin comments, and the materials be one.
    let materials = round_trip(&mesh, Format::Obj).appearance.materials;
    assert_eq!(materials.len(), names.len() + 1);
}

/// Each material's primitive names all vertices; together they are more than a file may have.
#[test]
fn a_glb_of_many_vertices_and_materials_is_read_back() {
    let (n, count) = (100_000, 170);
    let positions = (0..n).map(|v| [f64::from(v), f64::from(v % 2), 0.0]).collect();
    let triangles = (0..count).map(|t| [t, t + 1, t + 2]).collect();
    let materials = (0..count).map(|i| Material::named(&format!("part {i}"))).collect();
    let face_materials = (0..count).map(Some).collect();
    let uvs = CornerUvs { points: vec![[0.25, 0.5]; 3], corners: [0, 1, 2].repeat(count as usize) };
    let appearance = Appearance { materials, face_materials, uvs: Some(uvs), ..Appearance::default() };
    let mesh = TriMesh { positions, triangles, appearance };
    let back = round_trip(&mesh, Format::Glb);
    assert!(back.positions == mesh.positions && back.triangles == mesh.triangles);
    assert_eq!(back.triangle_materials(), mesh.triangle_materials());
    assert_eq!(back.triangle_uvs(), mesh.triangle_uvs());
}

#[test]
fn a_picture_that_materials_share_is_stored_once() {
    let mut mesh = dressed();
    let picture = Texture {
        name: "atlas.png".into(),
        bytes: [&b"\x89PNG\r\n\x1a\n"[..], &[7; 100_000]].concat().into(),
    };
    let material = |i: usize| Material {
        base_color_texture: Some(picture.clone()),
        ..Material::named(&format!("part {i}"))
    };
    mesh.appearance.materials = (0..8).map(material).collect();
    let bytes = write_mesh(&mesh, Format::Glb).unwrap();
    assert!(bytes.len() < 110_000, "{} bytes", bytes.len());
    let back = read_mesh(&bytes, Format::Glb).unwrap().mesh;
    for material in &back.appearance.materials[..8] {
        assert_eq!(material.base_color_texture.as_ref(), Some(&picture));
    }
}

/// Texture coordinates of three vertices, as shares of 65,535, of which only those of the last are given.
#[test]
fn a_sparse_accessor_of_normalized_numbers_changes_the_elements_that_it_names() {
    let document = r#"{"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1}}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]},
            {"componentType": 5123, "normalized": true, "count": 3, "type": "VEC2", "sparse": {"count": 1,
                "indices": {"bufferView": 1, "componentType": 5123}, "values": {"bufferView": 2}}}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}, {"buffer": 0, "byteOffset": 36, "byteLength": 2},
            {"buffer": 0, "byteOffset": 40, "byteLength": 4}],
        "buffers": [{"byteLength": 44, "uri":
            "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAgAAAP//MzM="}]}"#;
    let mesh = read_mesh(document.as_bytes(), Format::Gltf).unwrap().mesh;
    let across = mesh.triangle_uvs().unwrap()[0].map(|uv| uv[0]);
    assert_eq!(across, [0.0, 0.0, 1.0]);
}
