//! What must hold whatever the bytes are. The test suites hold the same on mutations of a few files
//! (`bad_input.rs` of chladni-mesh, `decoding.rs` of chladni-sound); here libFuzzer looks for the bytes.

use chladni_mesh::{Format, HealthReport, read_mesh, weld, write_mesh};
use chladni_sound::{Song, SongOptions, SongReader};
use chladni_task::Task;

/// Reads a mesh, and where that works checks what the types promise.
pub fn mesh(bytes: &[u8], format: Format) {
    let Ok(loaded) = read_mesh(bytes, format) else { return };
    let mesh = loaded.mesh;
    let n = mesh.positions.len();
    assert!(mesh.positions.iter().flatten().all(|x| x.is_finite()));
    assert!(mesh.triangles.iter().flatten().all(|&v| (v as usize) < n));
    assert!(!mesh.triangles.is_empty());
    assert!(HealthReport::of(&mesh).area.is_finite());
    assert_eq!(weld(&mesh).operator_vertex.len(), n);
    assert_eq!(mesh.triangle_materials().len(), mesh.triangles.len());
    write_mesh(&mesh, Format::Obj).expect("what was read can be written");
}

/// Decodes a song of any container, at most 4 MiB of it, from the start and from a place within.
pub fn song(bytes: &[u8]) {
    let options = SongOptions { max_bytes: 1 << 22, ..SongOptions::default() };
    let Ok(mut reader) = SongReader::from_bytes("fuzz", bytes.to_vec()) else { return };
    if let Ok(song) = Song::read(&mut reader, &options, &Task::new()) {
        assert!(song.frames() > 0 && song.left.len() == song.right.len());
        assert!(song.left.iter().chain(&song.right).all(|x| x.is_finite()));
    }
    let from_within = SongOptions { start_secs: 0.1, duration_secs: Some(0.2), ..options };
    if let Ok(mut reader) = SongReader::from_bytes("fuzz", bytes.to_vec()) {
        let _ = Song::read(&mut reader, &from_within, &Task::new());
    }
}
