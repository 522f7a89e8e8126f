//! Writes the small good files that the fuzzer starts from: `cargo run --bin seeds -- seeds` in this folder. Songs are
//! written by `scripts/fuzz_songs`; lists, messages, bindings and preferences of many kinds, and pictures of other programs
//! lie there as they are.

mod command_lines;
mod meshes;

use std::error::Error;
use std::fs;
use std::path::Path;

use chladni_caricature::{Layer, Painted, Project, ShapeSource, Template};
use chladni_fuzz::STORED;
use chladni_harmonics::npz::{npy_of, write_basis_folder, write_npz};
use chladni_harmonics::{BasisCache, BasisSettings, Body};
use chladni_mesh::{Format, samples, write_mesh};
use chladni_music::{Action, Form, GalleryShape, Instrument, Moment, Parameter, Show, repertoire};
use chladni_program::studio::Settings;
use chladni_program::work::{Subject, mask};
use chladni_sound::{Song, WavSample, wav_bytes};
use chladni_task::Task;
use chladni_view::Picture;
use command_lines::COMMAND_LINES;
use meshes::NamedSeed;

const OFF: &str = "OFF\n4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n";
const MEDIT: &str = "MeshVersionFormatted 1\nDimension 3\nVertices 4\n0 0 0 0\n1 0 0 0\n0 1 0 0\n0 0 1 0\n\
    Tetrahedra 1\n1 2 3 4 0\nTriangles 4\n1 3 2 0\n1 2 4 0\n1 4 3 0\n2 3 4 0\nEnd\n";
const GLTF: &str = r#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],
    "meshes":[{"primitives":[{"attributes":{"POSITION":0},"mode":6}]}],
    "accessors":[{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3"}],"bufferViews":[{"buffer":0,"byteLength":48}],
    "buffers":[{"byteLength":48,"uri":"data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAACAPwAAAAAAAAAA"}]}"#;

fn main() -> Result<(), Box<dyn Error>> {
    let corpus = std::env::args().nth(1).ok_or("usage: seeds FOLDER")?;
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
    // Small files are mutated more thoroughly.
    let wave = |hz: f32| (0..300).map(|n| (n as f32 * hz / 8000.0 * std::f32::consts::TAU).sin()).collect();
    let song = Song { rate_hz: 8000, left: wave(300.0), right: wave(500.0) };
    for (name, bytes) in documents()? {
        save(name, "good", &bytes)?;
    }
    let archive = Path::new(&corpus).join("numbers/mask.npz");
    save("numbers", "mask.npz", b"")?;
    write_npz(&archive, |npz| npz.array("mask", &[3], [0.0f32, 0.25, 1.0]))?;
    save("song_wav", "int.wav", &wav_bytes(&song, WavSample::Int16)?)?;
    save("song_wav", "float.wav", &wav_bytes(&song, WavSample::Float32)?)?;
    // The header alone of an AIFF file of 9114 channels.
    let header = b"FORM\0\0\0\x1eAIFFCOMM\0\0\0\x12\x23\x9a\0\0\0\0\0\x10\x40\x0b\xfa\0\0\0\0\0\0\0";
    save("song_aiff", "channels.aiff", header)?;
    save("numbers", "mask.npy", &npy_of(&[0.0, 0.25, 1.0])?)?;
    for (target, name, bytes) in of_the_program()?.into_iter().chain(meshes::meshes()?) {
        save(target, name, &bytes)?;
    }
    whole(Path::new(&corpus))
}

/// The seeds of meshes again, after the byte that says which format follows, for the targets that hand on what was read.
fn whole(corpus: &Path) -> Result<(), Box<dyn Error>> {
    /// The length of the names that libFuzzer gives to what it finds.
    const FOUND: usize = 40;
    // In the order of `chladni_fuzz::FORMATS`.
    for (format, target) in (0_u8..).zip(["obj", "ply", "off", "stl", "gltf", "glb", "medit"]) {
        for seed in fs::read_dir(corpus.join(target))? {
            let seed = seed?;
            let name = seed.file_name().into_string().map_err(|name| format!("{}", name.display()))?;
            if name.len() == FOUND {
                continue;
            }
            let bytes = [&[format][..], &fs::read(seed.path())?].concat();
            for whole in ["whole", "whole_dance"] {
                fs::create_dir_all(corpus.join(whole))?;
                fs::write(corpus.join(whole).join(format!("{target}_{name}")), &bytes)?;
            }
        }
    }
    Ok(())
}

/// A picture of four colors, or of steps of gray.
fn painted(width: u32, height: u32, color: impl Fn(u32) -> [u8; 4]) -> Picture {
    Picture { width, height, rgba: (0..width * height).flat_map(color).collect() }
}

/// Pictures, a mask, preferences, command lines, an entry of the cache and a basis in a folder: each with its target and name.
fn of_the_program() -> Result<Vec<NamedSeed>, Box<dyn Error>> {
    let colors =
        painted(4, 2, |i| [(60 * i) as u8, 200, (255 - 30 * i) as u8, if i % 3 == 0 { 90 } else { 255 }]);
    let hdr =
        [&b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 4\n"[..], &[128, 64, 32, 129].repeat(8)].concat();
    let shape = Subject::from(samples::icosphere(0));
    let painted_half = Painted::Vertices((0..12).map(|i| i as f32 / 11.0).collect());
    let folder = tempfile::tempdir()?;
    let basis = BasisSettings { threads: Some(1), ..BasisSettings::new(3) };
    let cache = BasisCache::new(folder.path());
    let (body, _) = Body::load_or_build(&samples::icosphere(0), &basis, Some(&cache), &Task::new())?;
    let entry = fs::read_dir(folder.path())?.next().ok_or("an entry was made")??.path();
    let parts = tempfile::tempdir()?;
    write_basis_folder(parts.path(), &body, &Task::new())?;
    let arrays = STORED.map(|name| fs::read(parts.path().join(format!("{name}.npy"))));
    let arrays = arrays.into_iter().collect::<Result<Vec<_>, _>>()?;
    let mut settings = Settings { zoom: 1.25, ..Settings::default() };
    settings.remember(Path::new("/somewhere/head.chladni"));
    let lines = COMMAND_LINES.map(|(name, line)| ("arguments", name, line.replace(' ', "\n").into_bytes()));
    // The first byte chooses the ending, in the order of `mask::READ`.
    let masks = ["npy", "npz", "ply", "obj"].into_iter().zip(0_u8..).map(|(ending, first)| {
        let bytes = mask::to_bytes(ending, &painted_half, &shape)?.0;
        Ok::<_, chladni_program::work::Error>(("mask_mesh", ending, [&[first][..], &bytes].concat()))
    });
    let masks = masks.collect::<Result<Vec<_>, _>>()?;
    let others = vec![
        ("picture", "colors.png", colors.to_png()?),
        ("panorama", "colors.png", colors.to_png()?),
        ("panorama", "light.hdr", hdr),
        ("settings", "good", settings.to_text()?.into_bytes()),
        ("cache", "good", fs::read(entry)?),
        ("stored", "good", arrays.join(&b"\n----\n"[..])),
    ];
    Ok(others.into_iter().chain(lines).chain(masks).collect())
}

/// A target and what it starts from.
type Seed = (&'static str, Vec<u8>);

/// One of each kind of document, by its target.
fn documents() -> Result<Vec<Seed>, Box<dyn Error>> {
    let mut layer = Layer::new("nose", Template::Ellipsoid);
    layer.region.painted = Painted::Vertices([0.0, 1.0, 1.0, 0.5].into());
    let mut project = Project::new(ShapeSource::File("/somewhere/head.obj".into()), 64);
    project.push(layer)?;
    let shape = GalleryShape { eigenvalues: (0..16).map(f64::from).collect(), bands: 8 };
    let mut instrument = Instrument::new(7, 6, shape)?;
    for action in [
        Action::Set { parameter: Parameter::StereoMu, value: 0.5 },
        Action::Choose { item: 1, on: true },
        Action::Choose { item: 2, on: true },
        Action::Breed,
        Action::Lock { item: 0, on: true },
        Action::Rename { item: 3, name: "tide".into() },
        Action::SetForm { form: Form::Modal },
        Action::SetHarmonics { harmonics: 8 },
        Action::Mutate { item: 4, amount: 0.5 },
        Action::Perform { item: 3 },
    ] {
        instrument.apply(Moment::default(), action)?;
    }
    let presets = repertoire()?;
    let preset = presets.first().ok_or("there is a repertoire")?;
    let obj = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl m\nf 1 2 3\n----\nnewmtl m\nKd 1 0 0\nmap_Kd a.png\n";
    let packet = [&[16][..], b"/beat\0\0\0,f\0\0\x3f\x80\0\0"].concat();
    let midi: [&[u8]; 5] = [&[3, 0xb0, 7, 64], &[3, 0x90, 36, 100], &[1, 0xf8], &[3, 0xf2, 1, 2], &packet];
    let buffer = GLTF.replace("data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAACAPwAAAAAAAAAA", "a.bin");
    let triangle =
        [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0].map(f32::to_le_bytes).concat();
    Ok(vec![
        ("project", project.to_text(Path::new("/somewhere/file"), None)?.into_bytes()),
        ("show", Show::of(&instrument).to_text()?.into_bytes()),
        ("preset", preset.to_text()?.into_bytes()),
        ("landmarks", b"# shape template\n0 1\n5 7\n".to_vec()),
        ("messages", midi.concat()),
        ("obj_mtl", obj.into()),
        ("gltf_buffer", [buffer.as_bytes(), b"\n----\n", &triangle].concat()),
    ])
}
