//! Every count of the shared meshes' manifest.

#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

use chladni_mesh::{HealthReport, TriMesh, load_mesh};

/// One row of the manifest: the path, V, F and the topology column.
struct Row {
    path: String,
    vertices: usize,
    faces: usize,
    topology: String,
}

fn rows(manifest: &str) -> Vec<Row> {
    let mut folder = String::new();
    let mut rows = Vec::new();
    for line in manifest.lines() {
        if let Some(title) = line.strip_prefix("## ") {
            folder = title.trim().to_owned();
        }
        let cells: Vec<&str> = line.split('|').map(str::trim).collect();
        let [_, file, _, _, vertices, faces, topology, ..] = cells[..] else { continue };
        let (Ok(vertices), Some(Ok(faces))) = (vertices.parse(), faces.split(' ').next().map(str::parse))
        else {
            continue;
        };
        rows.push(Row {
            path: format!("meshes/{folder}{file}"),
            vertices,
            faces,
            topology: topology.to_owned(),
        });
    }
    rows
}

/// The number after `key` in a list such as `c1 b0 nmE0`.
fn count(list: &str, key: &str) -> Option<usize> {
    list.split([' ', ',', ';']).find_map(|word| word.strip_prefix(key)?.parse().ok())
}

/// The report of the mesh before glTF nodes move it, as the manifest counts: degenerate are those triangles of fans from each
/// face's first corner.
fn stored_report(path: &std::path::Path) -> HealthReport {
    let loaded = load_mesh(path).unwrap();
    let positions = loaded.stored_positions.unwrap_or(loaded.mesh.positions);
    let mesh = TriMesh { positions, ..loaded.mesh };
    let faces = (0..mesh.face_count()).map(|f| mesh.face(f));
    let triangles = faces.flat_map(|face| (2..face.len()).map(move |i| [face[0], face[i - 1], face[i]]));
    let fans = HealthReport::of(&TriMesh { triangles: triangles.collect(), ..mesh.clone() });
    HealthReport { degenerate_triangles: fans.degenerate_triangles, ..HealthReport::of(&mesh) }
}

fn differences(row: &Row, report: &HealthReport) -> Vec<String> {
    let (stored, welded) = row.topology.split_once("welded:").unwrap_or((&row.topology, ""));
    // The manifest welds faces and triangles that a file has twice as two; here they are one.
    let welded = if report.duplicate_triangles == 0 { welded } else { "" };
    let genus = |list: &str, genus: Option<usize>| match (list.contains("g-"), count(list, "g")) {
        (true, _) => genus.is_none(),
        (false, Some(expected)) => genus == Some(expected),
        (false, None) => true,
    };
    let t = &report.topology;
    let w = &report.welded.topology;
    let mut found = vec![
        ("V", Some(row.vertices), report.vertices),
        ("F", Some(row.faces), report.polygons),
        ("c", count(stored, "c"), t.components),
        ("b", count(stored, "b"), t.boundary_loops),
        ("nmE", count(stored, "nmE"), t.nonmanifold_edges),
        ("nmV", count(stored, "nmV"), t.nonmanifold_vertices),
        ("degen", count(stored, "degen"), report.degenerate_triangles),
        ("dup", count(stored, "dup"), report.duplicate_vertices),
        ("welded V", count(welded, "V"), report.welded.vertices),
        ("welded c", count(welded, "c"), w.components),
        ("welded b", count(welded, "b"), w.boundary_loops),
    ];
    found.retain(|(_, expected, found)| expected.is_some_and(|expected| expected != *found));
    let mut lines: Vec<String> = found
        .iter()
        .map(|(key, expected, found)| format!("{}: {key} {expected:?} but {found}", row.path))
        .collect();
    if !genus(stored, t.genus) || !genus(welded, w.genus) {
        lines.push(format!(
            "{}: genus {:?} welded {:?}, manifest {}",
            row.path, t.genus, w.genus, row.topology
        ));
    }
    lines
}

#[test]
fn every_count_of_the_manifest() {
    let Some(path) = chladni_testdata::shared("meshes/MANIFEST.md") else { return };
    let rows = rows(&std::fs::read_to_string(path).unwrap());
    assert!(rows.len() > 40, "the manifest was not understood");
    let mut wrong = Vec::new();
    for row in rows.iter().filter(|row| row.faces > 0) {
        let path = chladni_testdata::shared(&row.path).expect("the manifest lists files that are there");
        wrong.extend(differences(row, &stored_report(&path)));
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
