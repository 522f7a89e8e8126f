//! Small good meshes, one or more for each part of the readers: fuzzing changes what is there, and rarely invents a kind of
//! file.

use std::error::Error;

use chladni_fuzz::base64;
use chladni_mesh::{Format, TriMesh, read_mesh_beside, write_mesh};
use chladni_view::Picture;

/// A target, a name, and what it starts from.
pub type NamedSeed = (&'static str, &'static str, Vec<u8>);

const OBJ: &str = "# all that is read\nmtllib a.mtl\no one\nv 0 0 0 1 0 0\nv 1 0 0 .5 .5 1\nv 0 1 0 0 1 0\nv 1 1 .5 0 0 0\n\
    vn 0 0 1\nvt 0 0\nvt 1 \\\n0\nvt 0 1\ng side\ns 1\nusemtl red\nf 1/1/1 2/2/1 3/3/1\nusemtl wood\nf -3/2 -1/3 -2/1\nf 1 2 4 3\nf 1//1 2//1 4//1\n";
const MTL: &str = "newmtl red\nKd 1 0 0\nKa 0 0 0\nNs 10\nd 0.5\nillum 2\nnewmtl wood\nmap_Kd -s 2 2 1 wood.png\nTr 0.25\n\
    Kd spectral a.rfl\n";
const OFF: [(&str, &str); 3] = [
    ("colors", "COFF\n3 1 0\n0 0 0 255 0 0 255\n1 0 0 0 255 0 128\n0 1 0 0 0 255 255\n3 0 1 2 .5 .5 .5 1\n"),
    (
        "all",
        "STCNOFF 4 2 0 # counts\n0 0 0 0 0 1 .1 .2 .3 1 0 0\n1 0 0 0 0 1 .1 .2 .3 1 1 0\n\n1 1 0 0 0 1 0 0 0 1 1 1\n\
         0 1 0 0 0 1 1 1 1 1 0 1\n4 0 1 2 3\n3 0 1 3\n",
    ),
    ("together", "OFF3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"),
];
const PLY: [(&str, &str); 2] = [
    (
        "text",
        "ply\nformat ascii 1.0\ncomment TextureFile a.png\nelement vertex 4\nproperty float x\nproperty float y\nproperty double z\n\
         property uchar red\nproperty uchar green\nproperty uchar blue\nproperty uchar alpha\nproperty float s\nproperty float t\n\
         property float mask\nelement face 2\nproperty list uchar int vertex_indices\nproperty list uchar float texcoord\n\
         property uchar red\nend_header\n0 0 0 255 0 0 255 0 0 .5\n1 0 0 0 255 0 9 1 0 .25\n1 1 0 0 0 255 9 1 1 1\n0 1 0 9 9 9 9 0 nan 0\n\
         3 0 1 2 6 0 0 1 0 1 1 7\n4 0 1 2 3 0 7\n",
    ),
    (
        "strips",
        "ply\nformat ascii 1.0\nobj_info by hand\nelement vertex 4\nproperty short x\nproperty short y\nproperty short z\n\
         element tristrips 1\nproperty list int int vertex_indices\nelement edge 1\nproperty int a\nend_header\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n\
         7 0 1 2 -1 1 2 3\n5 beyond\n",
    ),
];
const STL: &str = "solid a b\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1e0 0\nendloop\nendfacet\n\
    facet normal 1 0 0\nouter loop\nvertex 0 0 0\nvertex 0 1 0\nvertex 0 0 1\nendloop\nendfacet\nendsolid a b\n";
const MEDIT: &str = "MeshVersionFormatted 2 # double\nDimension\n2\nVertices\n4\n0 0 1\n1 0 1\n1 1 1\n0 1 1\nEdges 1\n1 2 0\n\
    Quadrilaterals 1\n1 2 3 4 0\nNormals\nEnd\n";

/// Where the JSON of our own GLB files describes their data.
const BUFFER: &str = r#""buffers":[{"#;

/// One of each, by its target.
pub fn meshes() -> Result<Vec<NamedSeed>, Box<dyn Error>> {
    let picture = Picture { width: 1, height: 1, rgba: vec![200, 100, 50, 255] }.to_png()?;
    let dressed = dressed(&picture)?;
    let mut seeds = vec![
        ("obj", "all", OBJ.into()),
        ("obj", "dressed", write_mesh(&dressed, Format::Obj)?),
        ("obj_mtl", "all", [OBJ, "----\n", MTL].concat().into_bytes()),
        ("obj_mtl", "picture", [OBJ.as_bytes(), b"\n----\n", &picture].concat()),
        ("ply", "big", big_endian_ply()),
        ("ply", "dressed", write_mesh(&dressed, Format::Ply)?),
        ("stl", "text", STL.into()),
        ("medit", "square", MEDIT.into()),
        ("off", "binary", binary_off(u32::to_be_bytes)),
        ("off", "binary_little", binary_off(u32::to_le_bytes)),
    ];
    seeds.extend(OFF.map(|(name, text)| ("off", name, text.into())));
    seeds.extend(PLY.map(|(name, text)| ("ply", name, text.into())));
    let glb = write_mesh(&dressed, Format::Glb)?;
    let (json, data) = chunks(&glb).ok_or("a GLB of two chunks")?;
    let inside = format!(r#""buffers":[{{"uri":"data:application/octet-stream;base64,{}","#, base64(data));
    seeds.push(("gltf", "dressed", json.replace(BUFFER, &inside).into_bytes()));
    let outside = json.replace(BUFFER, r#""buffers":[{"uri":"a.bin","#);
    seeds.push(("gltf_buffer", "dressed", [outside.as_bytes(), b"\n----\n", data].concat()));
    seeds.push(("gltf", "tree", tree().into_bytes()));
    seeds.push(("glb", "dressed", glb));
    Ok(seeds)
}

/// A mesh with colors, texture coordinates and two materials, of which one has a picture.
fn dressed(picture: &[u8]) -> Result<TriMesh, Box<dyn Error>> {
    let beside = |name: &str| match name {
        "a.mtl" => Ok(MTL.into()),
        _ => Ok(picture.to_vec()),
    };
    Ok(read_mesh_beside(OBJ.as_bytes(), Format::Obj, &beside)?.mesh)
}

fn big_endian_ply() -> Vec<u8> {
    let header = "ply\nformat binary_big_endian 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
        element face 1\nproperty list uchar int vertex_indices\nend_header\n";
    let corners = [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0].map(f32::to_be_bytes).concat();
    [header.as_bytes(), &corners, &[3], &[0, 1, 2].map(i32::to_be_bytes).concat()].concat()
}

/// A triangle whose face has a color.
fn binary_off(bytes: impl Fn(u32) -> [u8; 4]) -> Vec<u8> {
    let corners = [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0].map(f32::to_bits);
    let words = [3, 1, 0].into_iter().chain(corners).chain([3, 0, 1, 2, 3, 0, 0, 0]);
    [&b"OFF BINARY\n"[..], &words.flat_map(bytes).collect::<Vec<_>>()].concat()
}

/// Nodes that turn, mirror and repeat a strip and a fan with a sparse accessor, and lists of everything else that is looked at.
fn tree() -> String {
    let strip =
        [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0].map(f32::to_le_bytes).concat();
    // Corners, one index that is moved, and where to.
    let moved =
        [&[0_u8, 1, 2, 3, 2, 0, 0, 0][..], &[2.0_f32, 2.0, 0.5].map(f32::to_le_bytes).concat()].concat();
    let data = base64(&[&strip[..], &moved].concat());
    format!(
        r#"{{"asset":{{"version":"2.0"}},"extensionsUsed":["KHR_texture_transform"],"scene":0,"scenes":[{{"nodes":[0,2]}}],
        "nodes":[{{"children":[1],"scale":[2,2,-2]}},{{"mesh":0,"rotation":[0,0,0.6,0.8],"translation":[1,2,3]}},
        {{"mesh":0,"matrix":[1,0,0,0,0,1,0,0,0,0,1,0,5,6,7,1]}}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"indices":1,"mode":5,"material":0}},
        {{"attributes":{{"POSITION":2}},"mode":6,"targets":[{{"POSITION":0}}]}},{{"attributes":{{"POSITION":0}},"mode":0}}]}}],
        "materials":[{{"name":"m","pbrMetallicRoughness":{{"baseColorFactor":[1,0.5,0,1],"baseColorTexture":{{"index":0}}}}}}],
        "textures":[{{"source":0}}],"images":[{{"uri":"a%20b.png"}},{{"bufferView":1,"mimeType":"image/png"}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3"}},
        {{"bufferView":1,"componentType":5121,"count":4,"type":"SCALAR"}},
        {{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3","sparse":{{"count":1,
        "indices":{{"bufferView":2,"componentType":5121}},"values":{{"bufferView":3}}}}}}],
        "bufferViews":[{{"buffer":0,"byteLength":48}},{{"buffer":0,"byteOffset":48,"byteLength":4}},
        {{"buffer":0,"byteOffset":52,"byteLength":1}},{{"buffer":0,"byteOffset":56,"byteLength":12}}],
        "buffers":[{{"byteLength":68,"uri":"data:application/octet-stream;base64,{data}"}}]}}"#
    )
}

/// The JSON and the data of a GLB file.
fn chunks(glb: &[u8]) -> Option<(&str, &[u8])> {
    let length = |at: usize| Some(u32::from_le_bytes(glb.get(at..at + 4)?.try_into().ok()?) as usize);
    let json = glb.get(20..20 + length(12)?)?;
    let data = 20 + json.len();
    Some((std::str::from_utf8(json).ok()?, glb.get(data + 8..data + 8 + length(data)?)?))
}
