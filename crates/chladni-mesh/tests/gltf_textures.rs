//! Materials of glTF files: where textures lie on a mesh, which are read, and what alpha does.

#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

use chladni_mesh::{AlphaMode, Format, Mended, TriMesh, read_mesh, write_mesh};

/// The corners of a square, then its texture coordinates, each 0 or 4095, as two bytes.
const IN_4095THS: &str =
    "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAACAPwAAgD8AAAAAAAAAAAAAgD8AAAAAAAAAAP8PAAD/D/8PAAD/Dw==";
/// The same, each 0 or 1.
const IN_ONES: &str =
    "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAACAPwAAgD8AAAAAAAAAAAAAgD8AAAAAAAAAAAEAAAABAAEAAAABAA==";

/// A square with two materials, whose textures say this.
fn square(data: &str, textures: [&str; 2]) -> TriMesh {
    let [first, second] = textures.map(|texture| {
        format!(r#"{{"pbrMetallicRoughness": {{"baseColorTexture": {{"index": 0{texture}}}}}}}"#)
    });
    let primitive = |material| {
        format!(r#"{{"mode": 6, "material": {material}, "attributes": {{"POSITION": 0, "TEXCOORD_1": 1}}}}"#)
    };
    let document = format!(
        r#"{{"asset": {{"version": "2.0"}}, "meshes": [{{"primitives": [{}, {}]}}],
        "accessors": [{{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"}},
            {{"bufferView": 1, "componentType": 5123, "count": 4, "type": "VEC2"}}],
        "bufferViews": [{{"buffer": 0, "byteLength": 48}}, {{"buffer": 0, "byteOffset": 48, "byteLength": 16}}],
        "buffers": [{{"byteLength": 64, "uri": "data:application/octet-stream;base64,{data}"}}],
        "materials": [{first}, {second}], "textures": [{{"source": 0}}], "images": [{{"uri": "a.png"}}]}}"#,
        primitive(0),
        primitive(1)
    );
    read_mesh(document.as_bytes(), Format::Gltf).unwrap().mesh
}

#[test]
fn texture_coordinates_lie_where_a_material_moves_them() {
    let set = r#", "texCoord": 1"#;
    let plain = square(IN_ONES, [set, set]).triangle_uvs().unwrap();
    assert_eq!(plain[0], [[0.0, 1.0], [1.0, 1.0], [1.0, 0.0]]);
    let scale = 1.0 / 4095.0;
    let scaled = format!(r#""scale": [{scale}, {scale}], "texCoord": 1"#);
    let quarter =
        format!(r#""offset": [0.5, 0], "scale": [{}, {}], "texCoord": 1"#, scale / 2.0, scale / 2.0);
    let [scaled, quarter] = [scaled, quarter]
        .map(|transform| format!(r#", "extensions": {{"KHR_texture_transform": {{{transform}}}}}"#));
    let moved = square(IN_4095THS, [&scaled, &quarter]).triangle_uvs().unwrap();
    for (moved, plain) in moved[..2].as_flattened().iter().zip(plain.as_flattened()) {
        assert!((0..2).all(|i| (moved[i] - plain[i]).abs() < 1e-6), "{moved:?}, not {plain:?}");
    }
    // The upper right quarter of the picture, by the same accessor.
    for (moved, plain) in moved[2..].as_flattened().iter().zip(plain.as_flattened()) {
        let expected = [0.5 + plain[0] / 2.0, 0.5 + plain[1] / 2.0];
        assert!((0..2).all(|i| (moved[i] - expected[i]).abs() < 1e-6), "{moved:?}, not {expected:?}");
    }
}

#[test]
fn a_picture_of_another_kind_is_named() {
    for extension in ["EXT_texture_webp", "EXT_texture_avif", "KHR_texture_basisu"] {
        let document = format!(
            r#"{{"asset": {{"version": "2.0"}}, "meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0}}}}]}}],
            "accessors": [{{"componentType": 5126, "count": 3, "type": "VEC3"}}],
            "materials": [{{"pbrMetallicRoughness": {{"baseColorTexture": {{"index": 0}}}}}}],
            "textures": [{{"extensions": {{"{extension}": {{"source": 0}}}}}}],
            "bufferViews": [{{"buffer": 0, "byteLength": 3}}],
            "buffers": [{{"byteLength": 3, "uri": "data:application/octet-stream;base64,UklG"}}],
            "images": [{{"bufferView": 0}}]}}"#
        );
        let mended = read_mesh(document.as_bytes(), Format::Gltf).unwrap().mended;
        let expected = Mended::MissingFile("image 0".into(), "it is neither PNG nor JPEG".into());
        assert_eq!(mended, [expected], "{extension}");
    }
}

#[test]
fn a_material_is_as_opaque_as_its_mode_says() {
    for (mode, alpha_mode, alpha) in [
        ("", AlphaMode::Usual, 1.0),
        (r#""alphaMode": "OPAQUE","#, AlphaMode::Usual, 1.0),
        (r#""alphaMode": 7, "alphaCutoff": "x","#, AlphaMode::Usual, 1.0),
        (r#""alphaMode": "MASK","#, AlphaMode::Mask { cutoff: 0.5 }, 0.25),
        (r#""alphaMode": "MASK", "alphaCutoff": 0.125,"#, AlphaMode::Mask { cutoff: 0.125 }, 0.25),
        (r#""alphaMode": "BLEND","#, AlphaMode::Blend, 0.25),
    ] {
        let document = format!(
            r#"{{"asset": {{"version": "2.0"}},
            "meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0}}, "material": 0}}]}}],
            "accessors": [{{"componentType": 5126, "count": 3, "type": "VEC3"}}],
            "materials": [{{{mode} "pbrMetallicRoughness": {{"baseColorFactor": [1, 1, 1, 0.25]}}}}]}}"#
        );
        let mesh = read_mesh(document.as_bytes(), Format::Gltf).unwrap().mesh;
        let again = read_mesh(&write_mesh(&mesh, Format::Glb).unwrap(), Format::Glb).unwrap().mesh;
        for mesh in [mesh, again] {
            let material = &mesh.appearance.materials[0];
            assert_eq!((material.alpha_mode, material.base_color[3]), (alpha_mode, alpha), "{mode}");
        }
    }
}
