//! Writes small good files for the fuzzer to start from: `seeds CORPUS_FOLDER`.

use std::error::Error;
use std::fs;
use std::path::Path;

use chladni_mesh::{Format, samples, write_mesh};
use chladni_sound::{Song, WavSample, wav_bytes};

const OFF: &str = "OFF\n4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n";
const MEDIT: &str = "MeshVersionFormatted 1\nDimension 3\nVertices 4\n0 0 0 0\n1 0 0 0\n0 1 0 0\n0 0 1 0\n\
    Tetrahedra 1\n1 2 3 4 0\nTriangles 4\n1 3 2 0\n1 2 4 0\n1 4 3 0\n2 3 4 0\nEnd\n";
const GLTF: &str = r#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],
    "meshes":[{"primitives":[{"attributes":{"POSITION":0},"mode":6}]}],
    "accessors":[{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3"}],"bufferViews":[{"buffer":0,"byteLength":48}],
    "buffers":[{"byteLength":48,"uri":"data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAACAPwAAAAAAAAAA"}]}"#;

fn main() -> Result<(), Box<dyn Error>> {
    let corpus = std::env::args().nth(1).ok_or("usage: seeds CORPUS_FOLDER")?;
    let save = |target: &str, name: &str, bytes: &[u8]| {
        let folder = Path::new(&corpus).join(target);
        fs::create_dir_all(&folder)?;
        fs::write(folder.join(name), bytes)
    };
    let mesh = samples::icosphere(0);
    for (target, format) in
        [("obj", Format::Obj), ("ply", Format::Ply), ("stl", Format::Stl), ("glb", Format::Glb)]
    {
        save(target, "icosphere", &write_mesh(&mesh, format)?)?;
    }
    save("off", "tetrahedron", OFF.as_bytes())?;
    save("medit", "tetrahedron", MEDIT.as_bytes())?;
    save("gltf", "strip", GLTF.as_bytes())?;
    let wave = |hz: f32| (0..8000).map(|n| (n as f32 * hz / 8000.0 * std::f32::consts::TAU).sin()).collect();
    let song = Song { rate_hz: 8000, left: wave(300.0), right: wave(500.0) };
    save("song", "int.wav", &wav_bytes(&song, WavSample::Int16)?)?;
    save("song", "float.wav", &wav_bytes(&song, WavSample::Float32)?)?;
    Ok(())
}
