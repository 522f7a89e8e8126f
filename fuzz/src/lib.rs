//! What must hold whatever the bytes are. The test suites hold the same on mutations of a few files
//! (`bad_input.rs` of chladni-mesh, `decoding.rs` of chladni-sound); here libFuzzer looks for the bytes.

mod dance;
mod documents;
mod pipeline;
mod program;
mod random;

use std::path::Path;

use chladni_harmonics::npz::numbers_in;
use chladni_mesh::{Format, HealthReport, Loaded, read_mesh, read_mesh_beside, weld, write_mesh};
use chladni_sound::{Song, SongOptions, SongReader};
use chladni_task::Task;
use peak_alloc::PeakAlloc;

pub use dance::{Dance, dance};
pub use documents::{bindings, landmarks, messages, preset, project, show};
pub use pipeline::{Pair, Shape, pair, pipeline};
pub use program::{STORED, arguments, cache, mask_mesh, panorama, picture, settings, stored};
pub use random::Random;

#[global_allocator]
static MEMORY: PeakAlloc = PeakAlloc;

const MIB: usize = 1 << 20;

/// Reads `length` bytes, which may take `each` bytes of memory for each of them, and `more` besides.
fn within<T>(length: usize, each: usize, more: usize, read: impl FnOnce() -> T) -> T {
    MEMORY.reset_peak_usage();
    let before = MEMORY.current_usage();
    let result = read();
    let peak = MEMORY.peak_usage().saturating_sub(before);
    assert!(peak <= each * length + more, "{peak} bytes of memory to read {length} bytes");
    result
}

/// Reads a mesh, and where that works checks what the types promise.
pub fn mesh(bytes: &[u8], format: Format) {
    // Of glTF, instances and accessors of zeros cost the file nothing; only `-rss_limit_mb` bounds them here.
    let is_gltf = matches!(format, Format::Gltf | Format::Glb);
    let (each, more) = if is_gltf { (256, 1 << 30) } else { (64, MIB) };
    let read = within(bytes.len(), each, more, || read_mesh(bytes, format));
    if let Ok(loaded) = read {
        promised(&loaded);
    }
}

/// Reads an OBJ or glTF file, and the file that it names, from one input: what follows the first line of `----` is the
/// content of every file that is named.
pub fn mesh_beside(bytes: &[u8], format: Format) {
    let (own, beside) = divided(bytes);
    let beside = |_: &str| Ok(beside.to_vec());
    if let Ok(loaded) = read_mesh_beside(own, format, &beside) {
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
    let options = SongOptions { max_bytes: 1 << 22, ..SongOptions::default() };
    // What `SongReader` promises; a song in memory grows by doubling.
    let (length, each, more) = (bytes.len(), 64, 8 * MIB);
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
