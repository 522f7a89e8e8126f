//! What must hold whatever the bytes are. The test suites hold the same on mutations of a few files
//! (`bad_input.rs` of chladni-mesh, `decoding.rs` of chladni-sound); here libFuzzer looks for the bytes.

mod base64;
mod control;
mod dance;
mod documents;
mod export;
mod extreme;
mod gltf_graph;
mod gltf_parts;
mod json;
mod lists;
mod mp4;
mod ogg;
mod pipeline;
mod program;
mod random;
mod riff;
mod stated;
mod whole;

use std::cell::Cell;
use std::panic;
use std::path::Path;
use std::sync::Once;

use chladni_harmonics::npz::numbers_in;
use chladni_mesh::{Format, HealthReport, Loaded, read_mesh, read_mesh_beside, weld, write_mesh};
use chladni_sound::{Song, SongOptions, SongReader};
use chladni_task::Task;
use peak_alloc::PeakAlloc;

pub use base64::base64;
pub use control::messages;
pub use dance::{Dance, dance};
pub use documents::{bindings, landmarks, preset, project, show};
pub use extreme::{ExtremeMesh, extreme_mesh};
pub use gltf_graph::{GltfGraph, gltf_graph};
pub use lists::lists;
pub use mp4::{Mp4, mp4};
pub use ogg::{Ogg, ogg};
pub use pipeline::{Pair, Shape, pair, pipeline};
pub use program::{STORED, arguments, cache, mask_mesh, panorama, picture, settings, stored};
pub use random::Random;
pub use riff::{Riff, riff};
pub use whole::{FORMATS, whole, whole_dance};

#[global_allocator]
static MEMORY: PeakAlloc = PeakAlloc;

const MIB: usize = 1 << 20;

/// Reads `length` bytes, which may take `each` bytes of memory for each of them, and `more` besides.
fn within<T>(length: usize, each: usize, more: usize, read: impl FnOnce() -> T) -> T {
    within_all(each, more, || (read(), length))
}

/// The same, where the number of bytes is known only when they are read.
fn within_all<T>(each: usize, more: usize, read: impl FnOnce() -> (T, usize)) -> T {
    MEMORY.reset_peak_usage();
    let before = MEMORY.current_usage();
    let (result, length) = read();
    let peak = MEMORY.peak_usage().saturating_sub(before);
    assert!(peak <= each * length + more, "{peak} bytes of memory to read {length} bytes");
    result
}

/// Reads a mesh, and where that works checks what the types promise.
pub fn mesh(bytes: &[u8], format: Format) {
    let (each, more) = memory(format);
    mesh_within(bytes, format, each, more);
}

/// The bytes of memory that `read_mesh` promises to take at most for each byte of a file, and besides.
fn memory(format: Format) -> (usize, usize) {
    match format {
        // Instances and accessors of zeros cost the file nothing; only `-rss_limit_mb` bounds them here.
        Format::Gltf | Format::Glb => (256, 1 << 30),
        _ => (64, MIB),
    }
}

fn mesh_within(bytes: &[u8], format: Format, each: usize, more: usize) {
    if let Ok(loaded) = within(bytes.len(), each, more, || read_mesh(bytes, format)) {
        promised(&loaded);
    }
}

/// Reads an OBJ or glTF file, and the file that it names, from one input: what follows the first line of `----` is the
/// content of every file that is named. The bounds of memory are those of a mesh without such files, where a file counts
/// each time that it is asked for.
pub fn mesh_beside(bytes: &[u8], format: Format) {
    let (own, beside) = divided(bytes);
    let (each, more) = memory(format);
    let length = Cell::new(own.len());
    let beside = |_: &str| {
        length.set(length.get() + beside.len());
        Ok(beside.to_vec())
    };
    let read = within_all(each, more, || (read_mesh_beside(own, format, &beside), length.get()));
    if let Ok(loaded) = read {
        promised(&loaded);
    }
}

/// What comes before the first line of `----`, and what follows it; all and nothing where there is none.
fn divided(bytes: &[u8]) -> (&[u8], &[u8]) {
    let cut = bytes.windows(6).position(|window| window == b"\n----\n");
    cut.map_or((bytes, &[][..]), |at| (&bytes[..at], &bytes[at + 6..]))
}

fn promised(loaded: &Loaded) {
    let mesh = &loaded.mesh;
    let n = mesh.positions.len();
    assert!(mesh.positions.iter().flatten().all(|x| x.is_finite()));
    assert!(mesh.triangles.iter().flatten().all(|&v| (v as usize) < n));
    assert!(!mesh.triangles.is_empty());
    assert!(HealthReport::of(mesh).area.is_finite());
    assert_eq!(weld(mesh).operator_vertex.len(), n);
    assert_eq!(mesh.triangle_materials().len(), mesh.triangles.len());
    write_mesh(mesh, Format::Obj).expect("what was read can be written");
}

/// Decodes a song of any container, at most 4 MiB of it, from the start and from a place within.
pub fn song(bytes: &[u8]) {
    catch_decoders();
    let options = SongOptions { max_bytes: 1 << 22, ..SongOptions::default() };
    // What `SongReader` promises; a song in memory grows by doubling. Vorbis lies in Ogg and in Matroska.
    let may_be_vorbis = bytes.starts_with(b"OggS") || bytes.starts_with(b"\x1a\x45\xdf\xa3");
    let (length, each, more) = (bytes.len(), 64, if may_be_vorbis { 48 * MIB } else { 16 * MIB });
    let open = || SongReader::from_bytes("fuzz", bytes.to_vec());
    let Ok(mut reader) = within(length, each, more, open) else { return };
    assert_eq!(reader.tags().title.is_some(), reader.title().is_some());
    assert!(reader.cover().is_none_or(|picture| picture.len() <= 64 * MIB));
    assert!(!reader.kind().is_empty() && reader.channels() > 0);
    let read = || Song::read(&mut reader, &options, &Task::new());
    if let Ok(song) = within(length, each, more + 3 * options.max_bytes, read) {
        assert!(song.frames() > 0 && song.left.len() == song.right.len());
        assert!(song.left.iter().chain(&song.right).all(|x| x.is_finite()));
        assert!(reader.damage().is_none_or(|damage| !damage.is_empty()));
    }
    let from_within = SongOptions { start_secs: 0.1, duration_secs: Some(0.2), ..options };
    if let Ok(mut reader) = SongReader::from_bytes("fuzz", bytes.to_vec()) {
        let _ = Song::read(&mut reader, &from_within, &Task::new());
    }
}

/// What these decoders are known to assert of a file `SongReader` catches; libFuzzer's hook would end the process before that.
fn catch_decoders() {
    static CAUGHT: Once = Once::new();
    CAUGHT.call_once(|| {
        let usual = panic::take_hook();
        panic::set_hook(Box::new(move |panic| {
            let known = ["mappings/vorbis.rs", "codebook.rs"];
            if panic.location().is_none_or(|at| !known.iter().any(|end| at.file().ends_with(end))) {
                usual(panic);
            }
        }));
    });
}

/// Reads the array `mask` of a `.npz` archive, or a `.npy` file: masks and labels.
pub fn numbers(bytes: &[u8]) {
    const MOST: usize = 10_000;
    if let Ok(numbers) = within(bytes.len(), 64, MIB, || numbers_in(bytes, "mask", MOST)) {
        assert!(numbers.len() <= MOST);
    }
}

/// Where a document is thought to lie.
fn place() -> &'static Path {
    Path::new("/somewhere/file")
}
