//! Reading takes a bounded number of bytes of memory for each byte of a file, however much the file says in few bytes.

#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

use chladni_mesh::{Format, read_mesh};
use peak_alloc::PeakAlloc;

#[global_allocator]
static MEMORY: PeakAlloc = PeakAlloc;

/// What `read_mesh` promises for each byte of a file.
fn promised(format: Format) -> usize {
    if matches!(format, Format::Gltf | Format::Glb) { 256 } else { 64 }
}

/// The most bytes that were in use at once while a file was read, the file left aside.
fn peak(bytes: &[u8], format: Format) -> usize {
    MEMORY.reset_peak_usage();
    let before = MEMORY.current_usage();
    let read = read_mesh(bytes, format);
    let peak = MEMORY.peak_usage() - before;
    drop(read.expect("a dense file is a good one"));
    peak
}

/// Rows of a file.
const COUNT: usize = 60_000;

/// The name of a file, and its bytes.
type File = (&'static str, Vec<u8>);

fn obj_files() -> Vec<File> {
    let triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    let rows = |row: &str| format!("{triangle}{}f 1 2 3\n", row.repeat(COUNT)).into_bytes();
    let numbered = |row: &str| {
        let rows: String = (0..COUNT).map(|i| row.replace('#', &i.to_string())).collect();
        format!("{triangle}{rows}f 1 2 3\n").into_bytes()
    };
    let colored = triangle.replace('\n', " 1 1 1\n");
    vec![
        ("vertices", rows("v 0 0 0\n")),
        ("colored vertices", format!("{}f 1 2 3\n", colored.repeat(COUNT / 3)).into_bytes()),
        ("triangles", rows("f 1 2 3\n")),
        ("a polygon", format!("{triangle}f{}\n", " 1 2 3".repeat(COUNT)).into_bytes()),
        ("texture coordinates", rows("vt 0 0\n")),
        ("materials", numbered("usemtl #\n")),
        ("faces of materials", numbered("usemtl #\nf 1 2 3\n")),
        ("groups", rows("g a\n")),
        (
            "libraries",
            format!("mtllib{}\n{triangle}f 1 2 3\n", (0..COUNT).map(|i| format!(" {i}")).collect::<String>())
                .into_bytes(),
        ),
        ("broken faces", rows("f 1 2\n")),
    ]
}

fn off_files() -> Vec<File> {
    let corners = "0 0 0\n1 0 0\n0 1 0\n";
    let (vertices, triangles) = ("0 0 0\n".repeat(COUNT), "3 0 1 2\n".repeat(COUNT));
    vec![
        ("vertices", format!("OFF\n{} 1 0\n{corners}{vertices}3 0 1 2\n", COUNT + 3).into_bytes()),
        ("triangles", format!("OFF\n3 {COUNT} 0\n{corners}{triangles}").into_bytes()),
    ]
}

fn medit_files() -> Vec<File> {
    let file = |vertices: usize, triangles: usize| {
        let corners = "0 0 0 0\n1 0 0 0\n0 1 0 0\n".repeat(vertices);
        let faces = "1 2 3 0\n".repeat(triangles);
        let vertices = 3 * vertices;
        format!("Dimension 3\nVertices {vertices}\n{corners}Triangles {triangles}\n{faces}").into_bytes()
    };
    vec![("vertices", file(COUNT / 3, 1)), ("triangles", file(1, COUNT))]
}

fn stl_files() -> Vec<File> {
    let facet = "facet\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n";
    let numbers = [0_f32, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    let binary: Vec<u8> = numbers.iter().flat_map(|x| x.to_le_bytes()).chain([0; 2]).collect();
    vec![
        ("text", format!("solid\n{}endsolid\n", facet.repeat(COUNT)).into_bytes()),
        ("binary", [&[0; 80][..], &(COUNT as u32).to_le_bytes(), &binary.repeat(COUNT)].concat()),
    ]
}

/// A PLY file whose numbers have one byte each: coordinates, then further numbers, then lists of corners.
fn ply_of_bytes(vertices: usize, further: usize, lists: &str, count: usize, list: &[u8]) -> Vec<u8> {
    let properties: String = (0..further).map(|i| format!("property uchar a{i}\n")).collect();
    let header = format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty uchar x\nproperty uchar y\n\
         property uchar z\n{properties}element {lists} {count}\nproperty list uchar uchar vertex_indices\nend_header\n",
        3 * vertices
    );
    let corners = [[0, 0, 0], [1, 0, 0], [0, 1, 0]].map(|corner| [&corner[..], &vec![1; further]].concat());
    [header.into_bytes(), corners.concat().repeat(vertices), list.repeat(count)].concat()
}

fn ply_files() -> Vec<File> {
    let triangle = [3, 0, 1, 2];
    let long = [vec![255], [0, 1, 2].repeat(85)].concat();
    let text = format!(
        "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n\
         element face 1\nproperty list uchar int vertex_indices\nend_header\n{}3 0 1 2\n",
        3 * COUNT,
        "0 0 0\n1 0 0\n0 1 0\n".repeat(COUNT)
    );
    vec![
        ("text", text.into_bytes()),
        ("vertices", ply_of_bytes(COUNT, 0, "face", 1, &triangle)),
        ("attributes", ply_of_bytes(COUNT / 3, 40, "face", 1, &triangle)),
        ("triangles", ply_of_bytes(1, 0, "face", COUNT, &triangle)),
        ("polygons", ply_of_bytes(1, 0, "face", COUNT / 100, &long)),
        ("strips", ply_of_bytes(1, 0, "tristrips", COUNT / 100, &long)),
    ]
}

/// A square with long lists.
fn gltf_files() -> Vec<File> {
    let file = |name: &str, first: &str, row: &str| {
        let rows = row.repeat(COUNT);
        format!(
            r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],
            "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"mode":6}}]}}],
            "accessors":[{{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3"}}],
            "bufferViews":[{{"buffer":0,"byteLength":48}}],"buffers":[{{"byteLength":48,
            "uri":"data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAAAAAAAgD8AAAAA"}}],"{name}":[{first}{rows}{{}}]}}"#
        )
    };
    let with_node = |name: &str, row: &str| {
        file(name, "", row).replacen('{', r#"{"nodes":[{"mesh":0}],"#, 1).into_bytes()
    };
    vec![
        ("nodes", file("nodes", r#"{"mesh":0},"#, "{},").into_bytes()),
        ("extras", with_node("extras", "0,")),
        ("materials", with_node("materials", "{},")),
        ("images", with_node("images", "{},")),
        ("images of one picture", images_of_one_picture()),
        ("views of one picture", overlapping_pictures(|_| 0)),
        ("overlapping pictures", overlapping_pictures(|i| 8 * i)),
    ]
}

/// A triangle, and as many images as materials, all with the bytes of the same bufferView.
fn images_of_one_picture() -> Vec<u8> {
    let (count, bytes) = (2000, 99_999);
    // The first bytes of a PNG, then zeros.
    let picture = format!("iVBORw0KGgoA{}", "A".repeat(bytes / 3 * 4 - 12));
    let rows = |row: &str| (0..count).map(|i| row.replace('#', &i.to_string())).collect::<Vec<_>>().join(",");
    let images = rows(r#"{"bufferView":0}"#);
    let textures = rows(r##"{"source":#}"##);
    let materials = rows(r##"{"pbrMetallicRoughness":{"baseColorTexture":{"index":#}}}"##);
    format!(
        r#"{{"asset":{{"version":"2.0"}},"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}}],
        "accessors":[{{"componentType":5126,"count":3,"type":"VEC3"}}],
        "bufferViews":[{{"buffer":0,"byteLength":{bytes}}}],"buffers":[{{"byteLength":{bytes},
        "uri":"data:application/octet-stream;base64,{picture}"}}],
        "images":[{images}],"textures":[{textures}],"materials":[{materials}]}}"#
    )
    .into_bytes()
}

/// A triangle, and materials with images of their own, each from its place of a buffer of beginnings of a PNG on.
fn overlapping_pictures(place: impl Fn(usize) -> usize) -> Vec<u8> {
    let (count, bytes) = (2000, 99_984);
    // Three beginnings of a PNG.
    let buffer = "iVBORw0KGgqJUE5HDQoaColQTkcNChoK".repeat(bytes / 24);
    let rows = |row: &dyn Fn(usize) -> String| (0..count).map(row).collect::<Vec<_>>().join(",");
    let views = rows(&|i| {
        let place = place(i);
        format!(r#"{{"buffer":0,"byteOffset":{place},"byteLength":{}}}"#, bytes - place)
    });
    let images = rows(&|i| format!(r#"{{"bufferView":{i}}}"#));
    let textures = rows(&|i| format!(r#"{{"source":{i}}}"#));
    let materials =
        rows(&|i| format!(r#"{{"pbrMetallicRoughness":{{"baseColorTexture":{{"index":{i}}}}}}}"#));
    format!(
        r#"{{"asset":{{"version":"2.0"}},"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}}],
        "accessors":[{{"componentType":5126,"count":3,"type":"VEC3"}}],
        "bufferViews":[{views}],"buffers":[{{"byteLength":{bytes},
        "uri":"data:application/octet-stream;base64,{buffer}"}}],
        "images":[{images}],"textures":[{textures}],"materials":[{materials}]}}"#
    )
    .into_bytes()
}

#[test]
fn memory_is_bounded_by_the_length_of_the_file() {
    let kinds = [
        (Format::Obj, obj_files()),
        (Format::Off, off_files()),
        (Format::Medit, medit_files()),
        (Format::Stl, stl_files()),
        (Format::Ply, ply_files()),
        (Format::Gltf, gltf_files()),
    ];
    for (format, files) in kinds {
        for (what, bytes) in files {
            let (peak, length) = (peak(&bytes, format), bytes.len());
            println!("{format}, {what}: {:.1} bytes for each", peak as f64 / length as f64);
            assert!(peak <= promised(format) * length, "{format}, {what}: {peak} bytes for {length}");
        }
    }
}
