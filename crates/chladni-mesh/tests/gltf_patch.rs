//! Morph targets in a glTF file that has much else: all of it stays.

#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

use std::path::{Path, PathBuf};

use chladni_mesh::{
    Format, Mended, MorphTarget, TriMesh, add_morph_targets, load_mesh, pictures_beside, read_mesh,
};
use serde_json::{Value, json};

/// A binary buffer in the making.
#[derive(Default)]
struct Data {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl Data {
    fn put(&mut self, bytes: &[u8], component: u32, kind: &str, count: usize) -> usize {
        self.views.push(json!({ "buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len() }));
        self.bytes.extend_from_slice(bytes);
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let view = self.views.len() - 1;
        self.accessors
            .push(json!({ "bufferView": view, "componentType": component, "count": count, "type": kind }));
        self.accessors.len() - 1
    }

    fn floats(&mut self, values: &[f32], kind: &str, width: usize) -> usize {
        let bytes: Vec<u8> = values.iter().flat_map(|x| x.to_le_bytes()).collect();
        self.put(&bytes, 5126, kind, values.len() / width)
    }
}

const POINTS: [f32; 12] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];

/// A tetrahedron with a slider, joints, normals of its own and a line; placed three times: turned and stretched by its
/// joints, mirrored, and alone with an animation of its slider. Besides a skin, a camera, a light, materials, and extras of
/// all kinds.
fn rigged() -> (Value, Vec<u8>) {
    let mut data = Data::default();
    let position = data.floats(&POINTS, "VEC3", 3);
    let slanted = [0.6_f32, 0.8, 0.0].repeat(4);
    let normal = data.floats(&slanted, "VEC3", 3);
    let smile = data.floats(&[0.0, 0.25, 0.0].repeat(4), "VEC3", 3);
    let smile_normal = data.floats(&[0.0; 12], "VEC3", 3);
    let joints = data.put(&[0, 1, 0, 0].repeat(4), 5121, "VEC4", 4);
    let weights = data.floats(&[0.75, 0.25, 0.0, 0.0].repeat(4), "VEC4", 4);
    let indices = data.put(&[0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3], 5121, "SCALAR", 12);
    let line = data.put(&[0, 1], 5121, "SCALAR", 2);
    let doubled = |i: u32| match i % 16 {
        0 | 5 | 10 => 2.0,
        15 => 1.0,
        _ => 0.0,
    };
    let inverse: Vec<f32> = (0..32).map(doubled).collect();
    let inverse = data.floats(&inverse, "MAT4", 16);
    let times = data.floats(&[0.0, 1.0, 2.0], "SCALAR", 1);
    let values = data.floats(&[0.0, 1.0, 0.5], "SCALAR", 1);
    let attributes =
        json!({ "POSITION": position, "NORMAL": normal, "JOINTS_0": joints, "WEIGHTS_0": weights });
    let targets = json!([{ "POSITION": smile, "NORMAL": smile_normal }]);
    let solid = json!({ "attributes": attributes, "indices": indices, "material": 0, "targets": targets });
    let lines = json!({ "attributes": { "POSITION": position }, "indices": line, "mode": 1,
                        "targets": [{ "POSITION": smile }] });
    let root = json!({
        "asset": { "version": "2.0", "generator": "somebody", "extras": { "a": [1, 2.5, "x"] } },
        "scene": 0,
        "scenes": [{ "nodes": [0, 1, 2, 3, 4] }],
        "nodes": [
            { "mesh": 0, "skin": 0, "name": "turned", "translation": [7.0, 7.0, 7.0] },
            { "mesh": 0, "name": "mirrored", "scale": [-1.0, 1.0, 1.0], "translation": [-5.0, 0.0, 0.0], "weights": [0.5] },
            { "mesh": 1, "name": "animated", "extras": { "kept": true } },
            { "camera": 0, "translation": [0.0, 0.0, 9.0] },
            { "name": "bone", "children": [5], "rotation": [0.0, 0.6, 0.0, 0.8], "scale": [1.0, 0.5, 0.25],
              "translation": [5.0, 0.0, 0.0] },
            { "name": "bone end" }
        ],
        "meshes": [
            { "name": "solid", "primitives": [solid.clone(), lines], "weights": [0.0],
              "extras": { "targetNames": ["Smile"], "mine": 7 } },
            { "name": "other", "primitives": [solid] }
        ],
        "skins": [{ "joints": [4, 5], "inverseBindMatrices": inverse }],
        "cameras": [{ "type": "perspective", "perspective": { "yfov": 0.7, "znear": 0.1 } }],
        "materials": [{ "name": "skin", "pbrMetallicRoughness": { "metallicFactor": 0.3, "roughnessFactor": 0.7 },
                        "emissiveFactor": [0.1, 0.2, 0.3], "extensions": { "KHR_materials_ior": { "ior": 1.4 } } }],
        "animations": [{ "name": "laugh", "samplers": [{ "input": times, "output": values }],
                         "channels": [{ "sampler": 0, "target": { "node": 2, "path": "weights" } }] }],
        "extensionsUsed": ["KHR_materials_ior"],
        "extensions": { "ACME_anything": { "x": [1.5, 2] } },
        "accessors": data.accessors,
        "bufferViews": data.views,
        "buffers": [{ "byteLength": data.bytes.len(), "name": "all" }],
    });
    (root, data.bytes)
}

fn glb(root: &Value, data: &[u8]) -> Vec<u8> {
    let mut text = root.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let lengths = [2, (28 + text.len() + data.len()) as u32, text.len() as u32];
    let mut bytes = b"glTF".to_vec();
    bytes.extend(lengths.iter().flat_map(|x| x.to_le_bytes()));
    bytes.extend([b"JSON", &text[..], &(data.len() as u32).to_le_bytes(), b"BIN\0", data].concat());
    bytes
}

/// The document and the data of a GLB.
fn parsed(bytes: &[u8]) -> (Value, Vec<u8>) {
    let length = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
    (serde_json::from_slice(&bytes[20..20 + length]).unwrap(), bytes[28 + length..].to_vec())
}

/// The floats of an accessor.
fn floats((root, data): &(Value, Vec<u8>), accessor: &Value) -> Vec<f32> {
    let accessor = &root["accessors"][accessor.as_u64().unwrap() as usize];
    let width = match accessor["type"].as_str().unwrap() {
        "SCALAR" => 1,
        _ => 3,
    };
    let count = accessor["count"].as_u64().unwrap() as usize * width;
    let Some(view) = accessor.get("bufferView") else { return vec![0.0; count] };
    let start = root["bufferViews"][view.as_u64().unwrap() as usize]["byteOffset"].as_u64().unwrap() as usize;
    data[start..start + 4 * count].as_chunks().0.iter().map(|x| f32::from_le_bytes(*x)).collect()
}

fn targets(mesh: &TriMesh) -> Vec<MorphTarget> {
    let displacements = |s: f64| mesh.positions.iter().map(|[x, y, z]| [s * y, 0.1 * z, s * x * x]).collect();
    [("nose", 0.3), ("chin", -0.2)]
        .map(|(name, s)| MorphTarget { name: name.into(), displacements: displacements(s) })
        .into()
}

/// The document as it was: without what was added.
fn stripped(mut root: Value, before: &Value) -> Value {
    for name in ["accessors", "bufferViews", "meshes"] {
        let count = before[name].as_array().unwrap().len();
        root[name].as_array_mut().unwrap().truncate(count);
    }
    root["buffers"] = before["buffers"].clone();
    for (mesh, old) in
        root["meshes"].as_array_mut().unwrap().iter_mut().zip(before["meshes"].as_array().unwrap())
    {
        for primitive in mesh["primitives"].as_array_mut().unwrap() {
            primitive["targets"].as_array_mut().unwrap().truncate(1);
        }
        mesh["weights"].as_array_mut().unwrap().truncate(1);
        mesh["extras"]["targetNames"].as_array_mut().unwrap().truncate(1);
        if old.get("extras").is_none() {
            mesh.as_object_mut().unwrap().retain(|name, _| name != "extras" && name != "weights");
        }
    }
    root["nodes"][1]["weights"].as_array_mut().unwrap().truncate(1);
    root["nodes"][1]["mesh"] = json!(0);
    root["animations"][0]["samplers"].as_array_mut().unwrap().truncate(1);
    root["animations"][0]["channels"][0]["sampler"] = json!(0);
    root
}

/// The path of such a file, and the mesh that it is read as.
fn written(folder: &Path, root: &Value, data: &[u8]) -> (PathBuf, TriMesh) {
    let path = folder.join("rigged.glb");
    std::fs::write(&path, glb(root, data)).unwrap();
    let mesh = load_mesh(&path).unwrap().mesh;
    (path, mesh)
}

#[test]
fn everything_stays_and_the_sliders_move_each_copy_as_asked() {
    let folder = tempfile::tempdir().unwrap();
    let (root, data) = rigged();
    let (path, mesh) = written(folder.path(), &root, &data);
    assert_eq!(mesh.positions.len(), 12, "three copies");
    let wanted = targets(&mesh);
    let bytes = add_morph_targets(&path, &mesh, &wanted).unwrap();
    let now = parsed(&bytes);
    assert!(now.1.starts_with(&data), "the old data lies where it lay");
    assert_eq!(stripped(now.0.clone(), &root), root);
    assert_eq!(read_mesh(&bytes, Format::Glb).unwrap().mesh, mesh);

    let meshes = now.0["meshes"].as_array().unwrap();
    assert_eq!(meshes.len(), 3, "the mesh that is placed twice became two");
    assert_eq!((&now.0["nodes"][0]["mesh"], &now.0["nodes"][1]["mesh"]), (&json!(0), &json!(2)));
    assert_eq!(meshes[0]["extras"], json!({ "targetNames": ["Smile", "nose", "chin"], "mine": 7 }));
    assert_eq!(meshes[1]["extras"]["targetNames"], json!(["target_0", "nose", "chin"]));
    assert_eq!(now.0["nodes"][1]["weights"], json!([0.5, 0.0, 0.0]));
    for mesh in meshes {
        assert_eq!(mesh["weights"], json!([0.0, 0.0, 0.0]));
        for primitive in mesh["primitives"].as_array().unwrap() {
            assert_eq!(primitive["targets"].as_array().unwrap().len(), 3, "the line, too");
        }
    }
    // The slider's weights in the file, applied in each node's own coordinates, are the displacements in the scene.
    for (node, (copy, place)) in [(0, 0), (2, 1), (1, 2)].into_iter().enumerate() {
        for (k, target) in wanted.iter().enumerate() {
            let mut moved = now.clone();
            let entry = &now.0["meshes"][copy]["primitives"][0]["targets"][1 + k];
            let offset = floats(&now, &entry["POSITION"]);
            let new: Vec<u8> = POINTS.iter().zip(&offset).flat_map(|(p, d)| (p + d).to_le_bytes()).collect();
            moved.1[..48].copy_from_slice(&new);
            let back = read_mesh(&glb(&moved.0, &moved.1), Format::Glb).unwrap().mesh;
            for v in 4 * node..4 * node + 4 {
                for i in 0..3 {
                    let expected = mesh.positions[v][i] + target.displacements[v][i];
                    assert!(
                        (back.positions[v][i] - expected).abs() < 1e-5,
                        "node {node} (mesh {place}), {}",
                        target.name
                    );
                }
            }
            // The file's own normals turn, and stay unit.
            let turned = floats(&now, &entry["NORMAL"]);
            for n in turned.as_chunks::<3>().0 {
                let turned = [n[0] + 0.6, n[1] + 0.8, n[2]];
                assert!((turned.iter().map(|x| x * x).sum::<f32>() - 1.0).abs() < 1e-5);
            }
        }
    }
    // The animation holds the new sliders at 0.
    let sampler = now.0["animations"][0]["channels"][0]["sampler"].as_u64().unwrap() as usize;
    let output = &now.0["animations"][0]["samplers"][sampler]["output"];
    assert_eq!(floats(&now, output), [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.5, 0.0, 0.0]);
}

#[test]
fn sliders_of_one_name_are_numbered_beside_those_of_the_file() {
    let folder = tempfile::tempdir().unwrap();
    let (root, data) = rigged();
    let (path, mesh) = written(folder.path(), &root, &data);
    let still = vec![[0.0; 3]; mesh.positions.len()];
    let named = |name: &str| MorphTarget { name: name.into(), displacements: still.clone() };
    let wanted = ["Smile", "nose", "nose", "nose 2"].map(named);
    // A slider of one mesh of the file is numbered in the other, too: it has one name in both.
    let now = parsed(&add_morph_targets(&path, &mesh, &wanted).unwrap());
    let names = |mesh: usize| &now.0["meshes"][mesh]["extras"]["targetNames"];
    assert_eq!(*names(0), json!(["Smile", "Smile 2", "nose", "nose 3", "nose 2"]));
    assert_eq!(*names(1), json!(["target_0", "Smile 2", "nose", "nose 3", "nose 2"]));
}

#[test]
fn joints_place_a_skinned_mesh_and_a_pose_is_left_out_with_a_warning() {
    let (root, data) = rigged();
    let read = |root: &Value| read_mesh(&glb(root, &data), Format::Glb);
    let mut plain = root.clone();
    let bone = &root["nodes"][4];
    plain["nodes"][0] = json!({ "mesh": 0, "rotation": bone["rotation"], "scale": [2.0, 1.0, 0.5],
                                "translation": bone["translation"] });
    let (placed, expected) = (read(&root).unwrap(), read(&plain).unwrap());
    assert_eq!(placed.mesh.positions, expected.mesh.positions);
    let left_out = |what: &str| Mended::LeftOut(what.into());
    let usual = [
        left_out("primitives of points or lines (2)"),
        left_out("the morph targets of primitives, as if all sliders were at 0 (3)"),
    ];
    assert_eq!(placed.mended, usual);

    let mut posed = root.clone();
    posed["nodes"][5]["rotation"] = json!([0.6, 0.0, 0.0, 0.8]);
    let posed = read(&posed).unwrap();
    assert_eq!(posed.mesh.positions, expected.mesh.positions);
    assert_eq!(posed.mended[2..], [left_out("the pose of skinned meshes (1)")]);
    // Without a joint in the scene, the mesh lies where its node does.
    let mut outside = root.clone();
    outside["scenes"][0]["nodes"] = json!([0, 1, 2, 3]);
    let outside = read(&outside).unwrap();
    assert_eq!(outside.mesh.positions[0], [7.0; 3]);
    assert_eq!(outside.mended.len(), 3);
    let mut missing = root.clone();
    missing["nodes"][0]["skin"] = json!(7);
    assert!(read(&missing).unwrap_err().to_string().contains("skins[7]"));
}

#[test]
fn skins_that_differ_by_rounding_alone_place_meshes_alike() {
    let (mut root, data) = rigged();
    let read = |root: &Value| read_mesh(&glb(root, &data), Format::Glb).unwrap();
    // A joint in the place of the first one, to single precision.
    let mut joint = root["nodes"][4].clone();
    joint["children"] = json!([]);
    joint["translation"] = json!([5.0 + 5e-7, 0.0, 0.0]);
    root["nodes"].as_array_mut().unwrap().push(joint);
    let mut skin = root["skins"][0].clone();
    skin["joints"] = json!([6]);
    root["skins"].as_array_mut().unwrap().push(skin);
    root["nodes"][1] = json!({ "mesh": 0, "skin": 1 });
    root["scenes"][0]["nodes"] = json!([0, 1, 4, 6]);
    let positions = read(&root).mesh.positions;
    assert_eq!(positions.len(), 8);
    assert_eq!(positions[..4], positions[4..]);

    // So near to rest, a mesh stays where its file says.
    root["nodes"][4] = json!({ "children": [5], "translation": [1e-7, 0.0, 0.0] });
    root["skins"][0] = json!({ "joints": [4, 5] });
    root["scenes"][0]["nodes"] = json!([0, 4]);
    let at_rest = read(&root);
    assert_eq!(at_rest.mesh.positions.as_flattened(), POINTS.map(f64::from));
    assert!(at_rest.stored_positions.is_none());
}

#[test]
fn files_beside_come_into_the_glb_and_what_cannot_be_kept_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let (mut root, data) = rigged();
    let picture = b"\x89PNG\r\n\x1a\nnot really";
    std::fs::write(folder.path().join("first.bin"), &data[..48]).unwrap();
    std::fs::write(folder.path().join("all.bin"), &data).unwrap();
    std::fs::write(folder.path().join("wood.png"), picture).unwrap();
    std::fs::write(folder.path().join("skin"), b"RIFF\x08\0\0\0WEBPnot really").unwrap();
    std::fs::write(folder.path().join("rare"), b"something").unwrap();
    std::fs::write(folder.path().join("leaf.avif"), b"\0\0\0\x1cftypavifnot really").unwrap();
    std::fs::write(folder.path().join("old.dds"), b"DDS something").unwrap();
    root["images"] = json!([{ "uri": "wood.png" }, { "uri": "missing.png" }, { "uri": "skin", "mimeType": "image/webp" },
        { "uri": "skin" }, { "uri": "rare", "mimeType": "image/rare" }, { "uri": "leaf.avif" },
        { "uri": "./old%2Edds" }]);
    let all = root["buffers"][0]["byteLength"].clone();
    root["buffers"] =
        json!([{ "byteLength": 48, "uri": "first.bin" }, { "byteLength": all, "uri": "all.bin" }]);
    for view in root["bufferViews"].as_array_mut().unwrap().iter_mut().skip(1) {
        view["buffer"] = json!(1);
    }
    let path = folder.path().join("rigged.gltf");
    let write = |root: &Value| std::fs::write(&path, root.to_string()).unwrap();
    write(&root);
    let mesh = load_mesh(&path).unwrap().mesh;
    let bytes = add_morph_targets(&path, &mesh, &targets(&mesh)).unwrap();
    let now = parsed(&bytes);
    assert_eq!(read_mesh(&bytes, Format::Glb).unwrap().mesh, mesh);
    assert_eq!(now.0["buffers"].as_array().unwrap().len(), 1);
    assert_eq!(now.0["images"][1], json!({ "uri": "missing.png" }));
    let kinds: Vec<_> = (0..7).map(|i| now.0["images"][i]["mimeType"].as_str().unwrap_or_default()).collect();
    assert_eq!(kinds, ["image/png", "", "image/webp", "image/webp", "image/rare", "image/avif", ""]);
    assert_eq!(pictures_beside(root.to_string().as_bytes()).len(), 7);
    assert_eq!(pictures_beside(&bytes), ["missing.png", "old.dds"]);
    let view = &now.0["bufferViews"][now.0["images"][0]["bufferView"].as_u64().unwrap() as usize];
    let start = view["byteOffset"].as_u64().unwrap() as usize;
    assert_eq!(&now.1[start..start + picture.len()], picture);
    // No targets: the same file in one.
    let alone = add_morph_targets(&path, &mesh, &[]).unwrap();
    assert_eq!(parsed(&alone).0["meshes"], root["meshes"]);

    let refused = |mesh: &TriMesh| add_morph_targets(&path, mesh, &targets(mesh)).unwrap_err().to_string();
    let mut other = mesh.clone();
    other.positions[0][0] += 1.0;
    assert!(refused(&other).contains("not what the shape was read from"));
    let mut flat = root.clone();
    flat["nodes"][2]["scale"] = json!([1.0, 0.0, 1.0]);
    write(&flat);
    assert!(refused(&load_mesh(&path).unwrap().mesh).contains("flat"));
    let mut squeezed = root.clone();
    squeezed["extensionsUsed"] = json!(["EXT_meshopt_compression"]);
    write(&squeezed);
    assert!(refused(&mesh).contains("EXT_meshopt_compression"));
    let nowhere = add_morph_targets(Path::new("nowhere.glb"), &mesh, &[]);
    assert!(nowhere.is_err());
}

/// A mesh of several materials has one list of vertices, and its sliders are stored once.
#[test]
fn primitives_that_share_their_vertices_share_the_sliders() {
    let ball = chladni_mesh::samples::icosphere(1);
    let half = ball.face_count() / 2;
    let mut two = ball;
    two.appearance.materials = ["a", "b"].map(chladni_mesh::Material::named).into();
    two.appearance.face_materials = (0..two.face_count()).map(|f| Some(u32::from(f < half))).collect();
    let glb = chladni_mesh::write_mesh(&two, Format::Glb).unwrap();
    let mesh = read_mesh(&glb, Format::Glb).unwrap().mesh;
    let now = parsed(&chladni_mesh::add_morph_targets_in(&glb, &mesh, &targets(&mesh)).unwrap());
    let primitives = now.0["meshes"][0]["primitives"].as_array().unwrap();
    assert_eq!(primitives.len(), 2);
    assert_eq!(primitives[0]["targets"].as_array().unwrap().len(), targets(&mesh).len());
    assert_eq!(primitives[0]["targets"], primitives[1]["targets"]);
}

#[test]
fn sliders_of_another_scene_are_as_many_as_those_of_its_mesh() {
    let folder = tempfile::tempdir().unwrap();
    let (mut root, data) = rigged();
    let node = root["nodes"].as_array().unwrap().len();
    let elsewhere = json!({ "mesh": 0, "name": "elsewhere", "weights": [0.25] });
    root["nodes"].as_array_mut().unwrap().push(elsewhere);
    root["scenes"].as_array_mut().unwrap().push(json!({ "nodes": [node] }));
    let channel = json!({ "sampler": 0, "target": { "node": node, "path": "weights" } });
    root["animations"][0]["channels"].as_array_mut().unwrap().push(channel);
    let (path, mesh) = written(folder.path(), &root, &data);
    assert_eq!(mesh.positions.len(), 12, "the copies of the first scene");
    let now = parsed(&add_morph_targets(&path, &mesh, &targets(&mesh)).unwrap());
    assert_eq!(now.0["nodes"][node]["mesh"], 0);
    assert_eq!(now.0["meshes"][0]["primitives"][0]["targets"].as_array().unwrap().len(), 3);
    assert_eq!(now.0["nodes"][node]["weights"], json!([0.25, 0.0, 0.0]));
    for channel in 0..2 {
        let sampler = now.0["animations"][0]["channels"][channel]["sampler"].as_u64().unwrap() as usize;
        let output = &now.0["animations"][0]["samplers"][sampler]["output"];
        assert_eq!(floats(&now, output), [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.5, 0.0, 0.0]);
    }
}

#[test]
fn what_is_no_animation_stays_as_it_is() {
    let folder = tempfile::tempdir().unwrap();
    let (mut root, data) = rigged();
    let odd = [json!(5), json!("turn"), json!({ "name": "empty" }), json!({ "channels": 7 })];
    root["animations"].as_array_mut().unwrap().extend(odd.clone());
    let (path, mesh) = written(folder.path(), &root, &data);
    let now = parsed(&add_morph_targets(&path, &mesh, &targets(&mesh)).unwrap());
    assert_eq!(now.0["animations"].as_array().unwrap()[1..], odd);
}

/// Paths of all values of a document.
fn pointers(value: &Value, at: &str, all: &mut Vec<String>) {
    all.push(at.into());
    match value {
        Value::Array(list) => (0..).zip(list).for_each(|(i, v)| pointers(v, &format!("{at}/{i}"), all)),
        Value::Object(map) => map.iter().for_each(|(name, v)| pointers(v, &format!("{at}/{name}"), all)),
        _ => {}
    }
}

/// Each value of the document in turn becomes another: what can still be read is written, or refused.
#[test]
fn a_damaged_document_is_refused_or_written_whole() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("rigged.glb");
    let (mut root, data) = rigged();
    root["images"] = json!([{ "uri": "data:image/png;base64,AAAA" }]);
    // A view that nothing uses, in a buffer behind the first.
    root["buffers"].as_array_mut().unwrap().push(json!({ "byteLength": 3, "uri": "data:;base64,AAAA" }));
    root["bufferViews"]
        .as_array_mut()
        .unwrap()
        .push(json!({ "buffer": 1, "byteOffset": 0, "byteLength": 3 }));
    let mut all = Vec::new();
    pointers(&root, "", &mut all);
    let others = [
        json!(null),
        json!([]),
        json!({}),
        json!(-1),
        json!(7),
        json!(u64::MAX),
        json!("turn"),
        json!([0, 0, 0, 0]),
    ];
    let (mut written, mut refused) = (0, 0);
    for pointer in &all {
        let was = root.pointer(pointer).unwrap();
        // An object as the list of its values, in any order that a reader may take.
        let values = was.as_object().map(|map| json!(map.values().collect::<Vec<_>>()));
        let backward = was.as_object().map(|map| json!(map.values().rev().collect::<Vec<_>>()));
        for other in others.iter().cloned().chain(values).chain(backward) {
            let mut damaged = root.clone();
            *damaged.pointer_mut(pointer).unwrap() = other;
            std::fs::write(&path, glb(&damaged, &data)).unwrap();
            let Ok(loaded) = load_mesh(&path) else { continue };
            match add_morph_targets(&path, &loaded.mesh, &targets(&loaded.mesh)) {
                Ok(bytes) => {
                    assert_eq!(read_mesh(&bytes, Format::Glb).unwrap().mesh.positions, loaded.mesh.positions);
                    written += 1;
                }
                Err(_) => refused += 1,
            }
        }
    }
    assert!(written > 100 && refused > 10, "{written} written, {refused} refused");
}
