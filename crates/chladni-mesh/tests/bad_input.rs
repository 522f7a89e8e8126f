//! Whatever the bytes: a mesh, or one error line that says where and why. Never a panic.

#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

use std::path::{Path, PathBuf};

use chladni_mesh::{
    Format, HealthReport, MeshError, TriMesh, load_mesh, read_mesh, samples, weld, write_mesh,
};
use proptest::prelude::*;

const FORMATS: [Format; 7] =
    [Format::Obj, Format::Ply, Format::Off, Format::Stl, Format::Gltf, Format::Glb, Format::Medit];

/// Reads, and where that works checks what the types promise.
fn read_soundly(bytes: &[u8], format: Format) -> Result<(), MeshError> {
    let mesh = read_mesh(bytes, format)?.mesh;
    let n = mesh.positions.len();
    assert!(mesh.positions.iter().flatten().all(|x| x.is_finite()));
    assert!(mesh.triangles.iter().flatten().all(|&v| (v as usize) < n));
    assert!(!mesh.triangles.is_empty());
    assert!(HealthReport::of(&mesh).area.is_finite());
    assert_eq!(weld(&mesh).operator_vertex.len(), n);
    assert_eq!(mesh.triangle_materials().len(), mesh.triangles.len());
    let uvs = mesh.appearance.uvs.iter().flat_map(|uvs| &uvs.points);
    assert!(uvs.flatten().all(|x| x.is_finite()));
    // The writers' check is the readers' promise.
    write_mesh(&mesh, Format::Obj).expect("what was read can be written");
    Ok(())
}

/// The message of the error that `bytes` must give.
fn message(bytes: &[u8], format: Format) -> String {
    let error = read_mesh(bytes, format).expect_err("bad input");
    let message = error.to_string();
    assert!(!message.contains('\n') && message.len() < 200, "{message}");
    message
}

const TETRAHEDRON_OFF: &str = "OFF\n4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n";
const TETRAHEDRON_MEDIT: &str = "MeshVersionFormatted 1\nDimension 3\nVertices 4\n0 0 0 0\n1 0 0 0\n0 1 0 0\n0 0 1 0\n\
     Tetrahedra 1\n1 2 3 4 0\nTriangles 4\n1 3 2 0\n1 2 4 0\n1 4 3 0\n2 3 4 0\nEnd\n";

/// Small good files, one or more per format.
fn good_files() -> Vec<(Format, Vec<u8>)> {
    let mesh = samples::icosphere(0);
    let mut files: Vec<(Format, Vec<u8>)> = [Format::Obj, Format::Ply, Format::Stl, Format::Glb]
        .map(|format| (format, write_mesh(&mesh, format).unwrap()))
        .into();
    files.push((Format::Off, TETRAHEDRON_OFF.into()));
    files.push((Format::Medit, TETRAHEDRON_MEDIT.into()));
    let obj = "mtllib a.mtl\nusemtl a b\nv 0 0 0 1 0 0\nv 1 0 0 .5 nan 1\nv 0 1 0 0 1 0\nvt 0 1\nvt 1 \\\n1\nf 1/1 2/2 -1/-1\n";
    files.push((Format::Obj, obj.into()));
    files.push((
        Format::Obj,
        "v 0 0 0\nv 2 0 0\nv 2 1 0\nv 1 1 0\nv 1 2 0\nv 0 2 0\nf 2 3 4 5 6 1\nf 2 3 6 1\n".into(),
    ));
    let ply = "ply\nformat ascii 1.0\ncomment TextureFile a.png\nelement vertex 4\nproperty float x\nproperty float y\n\
         property float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\nelement tristrips 1\n\
         property list int int vertex_indices\nend_header\n0 0 0 9 9 9\n1 0 0 9 9 9\n0 1 0 9 9 9\n1 1 0 9 9 9\n7 0 1 2 -1 1 2 3\n";
    files.push((Format::Ply, ply.into()));
    for faces in [
        "face 2\nproperty list int int vertex_indices\nend_header\n",
        "tristrips 1\nproperty list int int vertex_indices\nend_header\n",
    ] {
        let rows = if faces.starts_with("face") { "3 0 1 2\n3 1 3 2\n" } else { "4 0 1 2 3\n" };
        let ply = format!(
            "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nproperty float s\n\
             property float t\nelement {faces}0 0 0 0 0\n1 0 0 1 nan\n0 1 0 0 1\n1 1 0 inf 1\n{rows}"
        );
        files.push((Format::Ply, ply.into()));
    }
    let stl = "solid a b\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid\n";
    files.push((Format::Stl, stl.into()));
    let gltf = r#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"children":[1],"scale":[2,2,-2]},
        {"mesh":0,"rotation":[0,0,0.6,0.8],"translation":[1,2,3]}],"meshes":[{"primitives":[{"attributes":{"POSITION":0},"mode":6}]}],
        "accessors":[{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3"}],"bufferViews":[{"buffer":0,"byteLength":48}],
        "buffers":[{"byteLength":48,"uri":"data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAACAPwAAgD8AAAAAAAAAAAAAgD8AAAAA"}]}"#;
    files.push((Format::Gltf, gltf.into()));
    files
}

#[test]
fn the_first_of_several_textures_of_a_ply_is_taken_and_said() {
    let ply = "ply\nformat ascii 1.0\ncomment TextureFile a.png\ncomment TextureFile b.png\nelement vertex 3\n\
         property float x\nproperty float y\nproperty float z\nelement face 1\n\
         property list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
    let loaded = read_mesh(ply.as_bytes(), Format::Ply).unwrap();
    let texture = loaded.mesh.appearance.materials[0].base_color_texture.as_ref().unwrap();
    assert_eq!(texture.name, "a.png");
    let is_said = |mended: &chladni_mesh::Mended| matches!(mended, chladni_mesh::Mended::LeftOut(what) if what.contains("but the first"));
    assert!(loaded.mended.iter().any(is_said), "{:?}", loaded.mended);
}

#[test]
fn texture_coordinates_beyond_32_bits_are_left_out() {
    let obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 1\nvt 1e39 0\nvt 1 -1e39\nf 1/1 2/2 3/3\n";
    let header = "element vertex 3\nproperty double x\nproperty double y\nproperty double z\nproperty double s\n\
         property double t\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n";
    let ply = format!("ply\nformat ascii 1.0\n{header}0 0 0 0 1\n1 0 0 1e39 0\n0 1 0 1 -1e39\n3 0 1 2\n");
    for (format, text) in [(Format::Obj, obj), (Format::Ply, &ply)] {
        let loaded = read_mesh(text.as_bytes(), format).unwrap();
        assert_eq!(loaded.mended, [chladni_mesh::Mended::Uvs(2)], "{format}");
        assert!(write_mesh(&loaded.mesh, Format::Glb).is_ok(), "{format}");
    }
    let off = "STOFF\n3 1 0\n0 0 0 0 1\n1 0 0 1e39 0\n0 1 0 1 1\n3 0 1 2\n";
    assert_eq!(read_mesh(off.as_bytes(), Format::Off).unwrap().mended, [chladni_mesh::Mended::Uvs(3)]);
}

#[test]
fn a_face_that_crosses_itself_is_said() {
    let obj = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 3 2 4\nf 1 2 3 4\n";
    let loaded = read_mesh(obj.as_bytes(), Format::Obj).unwrap();
    assert_eq!(loaded.mended, [chladni_mesh::Mended::FoldedFans(1)]);
    let said = loaded.mended[0].to_string();
    assert!(said.starts_with("faces that cross themselves") && said.ends_with(": 1"), "{said}");
    assert_eq!(loaded.mesh.triangles.len(), 4);
}

#[test]
fn what_windows_writes_for_no_number_is_one() {
    let facet = |normal: &str, x: &str| {
        format!(
            "solid\nfacet normal {normal}\nouter loop\nvertex {x} 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid\n"
        )
    };
    for word in ["-nan(ind)", "nan(snan)", "1.#QNAN", "-1.#IND", "1.#INF", "-1.#INF00"] {
        let ignored = facet(&[word; 3].join(" "), "0");
        assert!(read_mesh(ignored.as_bytes(), Format::Stl).is_ok(), "{word}");
        let said = message(facet("0 0 1", word).as_bytes(), Format::Stl);
        let value = if word.contains("INF") { "inf" } else { "NaN" };
        assert!(said.contains("line 4") && said.contains(value), "{word}: {said}");
    }
    let obj = "v 1 0 0\nv 0 0 -1.#IND\nv 0 1 0\nf 1 2 3\n";
    let said = message(obj.as_bytes(), Format::Obj);
    assert!(said.contains("line 2") && said.contains("NaN"), "{said}");
    for comment in ["# a comment", "#Rim", "#"] {
        let commented = format!("v 1 0 0\nv 0 0 1.{comment}\nv 0 1 0\nf 1 2 3\n");
        assert_eq!(read_mesh(commented.as_bytes(), Format::Obj).unwrap().mesh.positions[1][2], 1.0);
    }
    // Written with fewer digits, the names are rounded.
    for word in ["1.#J", "1.#IO", "1.#R", "1.#QO", "1.#QNB", "-1.#IO", "1.#SNB"] {
        let obj = format!("v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 1\nvt {word} 0\nvt 1 {word}\nf 1/1 2/2 3/3\n");
        let loaded = read_mesh(obj.as_bytes(), Format::Obj).unwrap();
        assert_eq!(loaded.mended, [chladni_mesh::Mended::Uvs(2)], "{word}");
    }
    assert!(message(facet("0 0 nan(", "0").as_bytes(), Format::Stl).contains("'nan('"));
}

#[test]
fn words_of_an_stl_may_be_in_capitals_after_a_byte_order_mark_and_end_lines_as_they_like() {
    let usual = "solid a facet\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\n\
         endfacet\nendsolid a facet\n";
    let expected = read_mesh(usual.as_bytes(), Format::Stl).unwrap().mesh;
    for other in [usual.to_uppercase(), format!("\u{feff}{usual}"), usual.replace('\n', "\r")] {
        assert_eq!(Format::from_content(other.as_bytes()), Some(Format::Stl), "{other:?}");
        assert_eq!(read_mesh(other.as_bytes(), Format::Stl).unwrap().mesh, expected, "{other:?}");
    }
}

#[test]
fn float_colors_of_a_ply_may_count_to_255() {
    let colors = |rows: [&str; 3]| {
        let [a, b, c] = rows;
        let text = format!(
            "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
             property float red\nproperty float green\nproperty float blue\nproperty float alpha\nelement face 1\n\
             property list uchar int vertex_indices\nend_header\n0 0 0 {a}\n1 0 0 {b}\n0 1 0 {c}\n3 0 1 2\n"
        );
        read_mesh(text.as_bytes(), Format::Ply).unwrap().mesh.appearance.colors.unwrap()
    };
    let shares = colors(["1 0.2 0 1", "0.4 0.6 0.8 0", "1 1 1 0.2"]);
    assert_eq!(colors(["255 51 0 1", "102 153 204 0", "255 255 255 0.2"]), shares);
    assert_eq!(colors(["255 51 0 255", "102 153 204 0", "255 255 255 51"]), shares);
}

#[test]
fn a_gltf_extension_that_is_required_and_not_read_is_refused() {
    let file = |extension: &str, primitive: &str| {
        format!(
            r#"{{"asset":{{"version":"2.0"}},"extensionsRequired":[{extension}],
            "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}{primitive}}}]}}],
            "accessors":[{{"componentType":5126,"count":3,"type":"VEC3"}}]}}"#
        )
    };
    for name in
        ["EXT_mesh_gpu_instancing", "KHR_draco_mesh_compression", "EXT_meshopt_compression", "ACME_shape"]
    {
        let said = message(file(&format!("{name:?}"), "").as_bytes(), Format::Gltf);
        assert!(said.contains("extensionsRequired") && said.contains(name), "{said}");
    }
    for name in ["KHR_mesh_quantization", "KHR_texture_transform", "KHR_materials_unlit", "VRMC_vrm"] {
        read_soundly(file(&format!("{name:?}"), "").as_bytes(), Format::Gltf).unwrap();
    }
    // Also where it is not required, but all there is.
    let packed = r#","extensions":{"KHR_draco_mesh_compression":{"bufferView":0,"attributes":{}}}"#;
    let said = message(file("", packed).as_bytes(), Format::Gltf);
    assert!(said.contains("primitives[0]") && said.contains("KHR_draco_mesh_compression"), "{said}");
}

#[test]
fn a_color_or_texture_coordinate_without_its_partners_is_an_attribute() {
    let ply = |properties: &str, rows: [&str; 3]| {
        let properties: String =
            properties.split(' ').map(|name| format!("property float {name}\n")).collect();
        let [a, b, c] = rows;
        let text = format!(
            "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
             {properties}element face 1\nproperty list uchar int vertex_indices\nend_header\n\
             0 0 0 {a}\n1 0 0 {b}\n0 1 0 {c}\n3 0 1 2\n"
        );
        read_mesh(text.as_bytes(), Format::Ply).unwrap().mesh
    };
    let again =
        |mesh: &TriMesh| read_mesh(&write_mesh(mesh, Format::Ply).unwrap(), Format::Ply).unwrap().mesh;
    let mesh = ply("t alpha red", ["1 2 3", "4 5 6", "7 8 9"]);
    assert_eq!(mesh.channel("t", Format::Ply), Some(vec![1.0, 4.0, 7.0]));
    assert_eq!(mesh.channel("red", Format::Ply), Some(vec![3.0, 6.0, 9.0]));
    assert_eq!(again(&mesh).appearance, mesh.appearance);
    // Beside colors and texture coordinates of its own, the mesh keeps such numbers under other names.
    let mut dressed = ply("red green blue s t", ["1 0 0 0 1", "0 1 0 1 0", "0 0 1 0 0"]);
    assert!(dressed.appearance.attributes.is_empty());
    dressed.appearance.attributes = mesh.appearance.attributes;
    let back = again(&dressed);
    assert_eq!(back.triangle_uvs(), dressed.triangle_uvs());
    assert!(back.appearance.colors.is_some());
    let names: Vec<&str> = back.appearance.attributes.iter().map(|attribute| &*attribute.name).collect();
    assert_eq!(names, ["_t", "_alpha", "_red"]);
    assert_eq!(back.appearance.attributes[0].values, [1.0, 4.0, 7.0]);
}

#[test]
fn the_small_good_files_are_good() {
    for (format, bytes) in good_files() {
        read_soundly(&bytes, format).unwrap_or_else(|error| panic!("{format}: {error}"));
    }
}

#[test]
fn an_odd_name_of_an_attribute_is_written_as_it_was_read() {
    // A vertical tab separates no words in PLY, though Unicode counts it as white space.
    let ply = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
         property float m\u{b}ask\nelement face 1\nproperty list uchar int vertex_index\nend_header\n\
         0 0 0 .25\n1 0 0 .5\n0 1 0 1\n3 0 1 2\n";
    let mesh = read_mesh(ply.as_bytes(), Format::Ply).unwrap().mesh;
    let again = read_mesh(&write_mesh(&mesh, Format::Ply).unwrap(), Format::Ply).unwrap().mesh;
    assert_eq!(again.appearance.attributes, mesh.appearance.attributes);
    assert_eq!(again.appearance.attributes[0].name, "m\u{b}ask");
}

#[test]
fn every_truncation_of_a_good_file_is_an_error_or_a_mesh() {
    for (format, bytes) in good_files() {
        for length in 0..bytes.len() {
            let read = read_soundly(&bytes[..length], format);
            // Binary files are whole or not.
            if matches!(format, Format::Glb) {
                assert!(read.is_err(), "{format} cut at {length}");
            }
        }
    }
}

#[test]
fn errors_say_where_and_why() {
    let cases: [(Format, &str, &[&str]); 20] = [
        (Format::Obj, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n", &["line 4", "4", "3 vertices"]),
        (Format::Obj, "v 0 0 0\nv 1 0 nan\nv 0 1 0\nf 1 2 3\n", &["line 2", "NaN"]),
        (Format::Obj, "v 0 0 inf\n", &["line 1", "inf"]),
        (Format::Obj, "v 0 0\n", &["line 1", "three coordinates"]),
        (Format::Obj, "v 0 0 zero\n", &["line 1", "'zero'"]),
        (Format::Obj, "v 0 0 0\nf 0 1 1\n", &["line 2", "from 1"]),
        (Format::Obj, "v 0 0 0\nf -2 1 1\n", &["line 2", "-2"]),
        (Format::Obj, "v 0 0 0\nv 1e300 0 0\nf 1 2 1\n", &["line 2", "too large"]),
        (Format::Obj, "# nothing\n", &["without a face"]),
        (Format::Ply, "this is a letter\n", &["line 1", "'ply'"]),
        (
            Format::Ply,
            "ply\nformat ascii 1.0\nelement vertex 99999999999999\nproperty float x\nproperty float y\nproperty float z\nend_header\n0 0 0\n",
            &["line", "ends"],
        ),
        (
            Format::Ply,
            "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n0\n",
            &["header", "property y"],
        ),
        (
            Format::Ply,
            "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement vertex 1\n\
             property float x\nproperty float y\nproperty float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n\
             element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n5 5 5 1 2 3\n3 0 1 2\n",
            &["line 7", "'vertex'"],
        ),
        (
            Format::Ply,
            "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float\nproperty float z\n",
            &["line 6", "name"],
        ),
        (Format::Off, "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 7\n", &["line 6", "7", "3 vertices"]),
        (Format::Off, "OFF\n99999999999 1 0\n0 0 0\n", &["after 1 of 99999999999"]),
        (Format::Stl, "solid a\nvertex 0 0 x\n", &["line 2", "'x'"]),
        (Format::Stl, "no such thing", &["ascii", "binary"]),
        (Format::Medit, "MeshVersionFormatted 1\nDimension 4\n", &["line 2", "dimension"]),
        (Format::Gltf, "{\"meshes\": 3}", &["JSON", "line 1"]),
    ];
    for (format, text, expected) in cases {
        let message = message(text.as_bytes(), format);
        for part in expected {
            assert!(message.contains(part), "{message:?} should say {part:?}");
        }
    }
}

#[test]
fn a_medit_section_that_is_not_known_does_not_take_the_next_one_with_it() {
    let known = medit(TETRAHEDRON_MEDIT);
    for unknown in ["Corners\n", "Corners 2\n1\n2\n", "Geometry\n"] {
        let text = TETRAHEDRON_MEDIT.replacen("Triangles", &format!("{unknown}Triangles"), 1);
        assert!(text != TETRAHEDRON_MEDIT);
        assert_eq!(medit(&text), known, "{unknown}");
    }
}

fn medit(text: &str) -> TriMesh {
    read_mesh(text.as_bytes(), Format::Medit).unwrap().mesh
}

#[test]
fn gltf_nodes_must_form_a_tree_of_any_depth() {
    let file = |nodes: &str| {
        format!(r#"{{"asset":{{"version":"2.0"}},"scenes":[{{"nodes":[0]}}],"nodes":[{nodes}],"meshes":[]}}"#)
    };
    let cycle = file(r#"{"children":[1]},{"children":[0]}"#);
    assert!(message(cycle.as_bytes(), Format::Gltf).contains("reached twice"));
    let deep: Vec<String> = (1..=200_000).map(|i| format!(r#"{{"children":[{i}]}}"#)).collect();
    let deep = file(&format!("{},{{}}", deep.join(",")));
    assert!(message(deep.as_bytes(), Format::Gltf).contains("without a face"));
    let nested = format!(r#"{{"extras":{}{}}}"#, "[".repeat(100_000), "]".repeat(100_000));
    assert!(message(nested.as_bytes(), Format::Gltf).contains("without a face"));
}

#[test]
fn promises_of_a_header_take_no_memory() {
    let huge = u32::MAX.to_le_bytes();
    let stl = [&[b' '; 80][..], &huge, &[0; 100]].concat();
    assert!(message(&stl, Format::Stl).contains("after 2 of 4294967295"));
    let off = [b"OFF BINARY\n", &huge[..], &huge, &huge, &[0; 100]].concat();
    assert!(message(&off, Format::Off).contains("more than the file can hold"));
    let ply = b"ply\nformat binary_little_endian 1.0\nelement vertex 0\nproperty float x\nproperty float y\nproperty float z\n\
        element face 4000000000\nproperty list uint int vertex_indices\nend_header\n\xff\xff\xff\xff";
    assert!(message(ply, Format::Ply).contains("list of length"));
    let empty_rows = b"ply\nformat ascii 1.0\nelement nothing 18446744073709551615\nend_header\n";
    assert!(message(empty_rows, Format::Ply).contains("without a face"));
    let zeros = r#"{"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],"accessors":[{"componentType":5126,"count":9000000000000000000,"type":"VEC3"}]}"#;
    assert!(message(zeros.as_bytes(), Format::Gltf).contains("without data"));
}

#[test]
fn the_content_decides_where_the_name_is_wrong() {
    let folder = tempfile::tempdir().unwrap();
    let save = |name: &str, bytes: &[u8]| -> PathBuf {
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        path
    };
    let loaded = load_mesh(&save("a.ply", TETRAHEDRON_OFF.as_bytes())).unwrap();
    assert!(loaded.mended[0].to_string().contains("OFF"));
    let mut solid = write_mesh(&samples::icosphere(1), Format::Stl).unwrap();
    solid[..6].copy_from_slice(b"solid ");
    assert_eq!(load_mesh(&save("solid.stl", &solid)).unwrap().mesh.triangles.len(), 80);
    assert_eq!(load_mesh(&save("no extension", &solid)).unwrap().mesh.triangles.len(), 80);
    let fails = |path: &Path, parts: &[&str]| {
        let message = load_mesh(path).unwrap_err().to_string();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        for part in parts.iter().copied().chain([name.as_str()]) {
            assert!(message.contains(part), "{message:?} should say {part:?}");
        }
    };
    fails(&save("letter.ply", b"Dear reader,\n"), &["line 1", "'ply'"]);
    fails(&save("cube.vtk", b"# vtk DataFile Version 1.0\nvtk output\n"), &["legacy VTK"]);
    fails(&save("letter.doc", b"Dear reader,\n"), &[".doc"]);
    fails(&save("empty.obj", b""), &["without a face"]);
    fails(&save("empty", b""), &["neither"]);
    let missing = folder.path().join("not there.obj");
    // In the system's words.
    let why = std::fs::read(&missing).unwrap_err().to_string();
    fails(&missing, &[&why]);
    fails(&std::fs::canonicalize(folder.path()).unwrap(), &["directory"]);
}

#[test]
fn shared_files_read_or_fail_by_name_whole_and_cut() {
    for part in ["nasty", "formats", "reference"] {
        let Some(folder) = chladni_testdata::shared(&format!("meshes/{part}")) else { return };
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            let name = path.file_name().unwrap().to_string_lossy().into_owned();
            match load_mesh(&path) {
                Ok(_) => assert!(!name.starts_with("empty")),
                Err(error) => {
                    let message = error.to_string();
                    assert!(message.contains(&name), "{message}");
                    let hopeless = name.starts_with("empty")
                        || name.ends_with("vtk")
                        || name.contains("mtl")
                        || name.ends_with("jpg");
                    assert!(hopeless, "{message}");
                }
            }
            let bytes = std::fs::read(&path).unwrap();
            let Some(format) = path.extension().and_then(|e| Format::from_extension(&e.to_string_lossy()))
            else {
                continue;
            };
            for cut in 1..12 {
                let _ = read_soundly(&bytes[..bytes.len() * cut / 12], format);
            }
        }
    }
}

/// A good file with some bytes replaced, removed or doubled.
fn mutated() -> impl Strategy<Value = (Format, Vec<u8>)> {
    let files = good_files();
    let which = 0..files.len();
    let interesting =
        prop_oneof![any::<u8>(), prop::sample::select(&b"0123456789-+.eE/ \n\\\"[]{},:nf\xff\x00\x7f"[..])];
    let edits = prop::collection::vec((any::<prop::sample::Index>(), interesting, 0..4_u8), 1..8);
    (which, edits).prop_map(move |(which, edits)| {
        let (format, mut bytes) = files[which].clone();
        for (at, value, kind) in edits {
            if bytes.is_empty() {
                break;
            }
            let at = at.index(bytes.len());
            match kind {
                0 | 1 => bytes[at] = value,
                2 => drop(bytes.remove(at)),
                _ => bytes.insert(at, value),
            }
        }
        (format, bytes)
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 6000, ..ProptestConfig::default() })]

    #[test]
    fn mutated_files_never_panic((format, bytes) in mutated()) {
        let _ = read_soundly(&bytes, format);
    }

    #[test]
    fn arbitrary_bytes_never_panic(bytes in prop::collection::vec(any::<u8>(), 0..300), head in 0..8_usize) {
        let heads: [&[u8]; 8] = [b"", b"ply\n", b"OFF BINARY\n", b"OFF\n", b"solid ", b"glTF\x02\0\0\0", b"{", b"MeshVersionFormatted 1\n"];
        let bytes = [heads[head], &bytes].concat();
        for format in FORMATS {
            let _ = read_soundly(&bytes, format);
        }
    }
}

#[test]
fn a_comment_that_ends_in_a_backslash_and_old_line_ends_lose_nothing() {
    let obj = "# from C:\\models\\\nv 0 0 0\nv 1 0 \\\n0\nv 0 1 0 # up\\\nf 1 2 3\n";
    let mesh = read_mesh(obj.as_bytes(), Format::Obj).unwrap().mesh;
    assert_eq!((mesh.positions.len(), mesh.triangles.len()), (3, 1));
    let ply = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
         element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
    let usual = read_mesh(ply.as_bytes(), Format::Ply).unwrap().mesh;
    let old = read_mesh(ply.replace('\n', "\r").as_bytes(), Format::Ply).unwrap().mesh;
    let dos = read_mesh(ply.replace('\n', "\r\n").as_bytes(), Format::Ply).unwrap().mesh;
    assert!(old.positions == usual.positions && old.triangles == usual.triangles);
    assert!(dos.positions == usual.positions && dos.triangles == usual.triangles);
}
