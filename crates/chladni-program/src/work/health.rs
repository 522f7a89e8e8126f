//! A health report in words, the same on the command line and in the window.

use chladni_harmonics::{CoverReport, HarmonicsError};
use chladni_mesh::{HealthReport, Topology};
use chladni_task::counted;

/// A name and what is said of it.
pub type HealthRow = (&'static str, String);

/// The rows of `report`, in order.
pub fn health_rows(report: &HealthReport) -> Vec<HealthRow> {
    let mut rows = Vec::new();
    let mut row = |name: &'static str, value: String| rows.push((name, value));
    row("vertices", report.vertices.to_string());
    row("triangles", report.triangles.to_string());
    if report.polygons != report.triangles {
        row("polygons", report.polygons.to_string());
    }
    row("as stored", described(&report.topology));
    let welded = &report.welded;
    if welded.vertices != report.vertices || welded.triangles != report.triangles {
        let counts = format!("{} vertices, {} triangles", welded.vertices, welded.triangles);
        row("welded", format!("{counts}; {}", described(&welded.topology)));
    }
    for (name, count) in [
        ("degenerate triangles", report.degenerate_triangles),
        ("duplicate triangles", report.duplicate_triangles),
        ("duplicate vertices", report.duplicate_vertices),
        ("unreferenced vertices", report.unreferenced_vertices),
    ] {
        row(name, count.to_string());
    }
    if report.inward_triangles > 0 {
        let of = format!("{} of {}", report.inward_triangles, welded.triangles);
        row("faces look inward", format!("{of}, or against their neighbors"));
    }
    let [low, high] = [report.bounds_min, report.bounds_max];
    let length = |value| digits(value, report.diagonal);
    for (i, axis) in ["x", "y", "z"].into_iter().enumerate() {
        row(axis, format!("{} to {}", length(low[i]), length(high[i])));
    }
    let extent: Vec<String> = (0..3).map(|i| length(high[i] - low[i])).collect();
    row("extent", format!("{} (diagonal {})", extent.join(" × "), length(report.diagonal)));
    row("area", digits(report.area, report.area));
    if let Some(volume) = report.volume {
        row("volume", digits(volume, volume));
    }
    rows
}

/// What is done to the shape for its Laplacian, or why it has none.
pub fn laplacian_row(cover: Result<&CoverReport, &HarmonicsError>) -> HealthRow {
    ("Laplacian", cover.map_or_else(|error| format!("none: {error}"), ToString::to_string))
}

/// Whether the surface, once welded, is manifold, and its faces evenly look outward. It may have a border, as most scans of
/// faces do.
pub fn is_sound(report: &HealthReport) -> bool {
    let found = &report.welded.topology;
    let branches = found.nonmanifold_edges + found.nonmanifold_vertices;
    branches + found.misoriented_edges + report.inward_triangles == 0
}

/// `value` with six decimals or, where these would say little on a `scale` as small as this one, six digits.
pub fn digits(value: f64, scale: f64) -> String {
    if scale.abs() < 1e-3 && value != 0.0 { format!("{value:.5e}") } else { format!("{:.6}", value + 0.0) }
}

/// A topology in words, the good news short.
fn described(topology: &Topology) -> String {
    let mut words = vec![
        counted(topology.components, "component", "components"),
        match topology.boundary_loops {
            0 => "closed".to_owned(),
            loops => counted(loops, "boundary loop", "boundary loops"),
        },
    ];
    for (n, one, many) in [
        (topology.nonmanifold_edges, "non-manifold edge", "non-manifold edges"),
        (topology.nonmanifold_vertices, "non-manifold vertex", "non-manifold vertices"),
        (topology.misoriented_edges, "wrongly oriented edge", "wrongly oriented edges"),
    ] {
        if n > 0 {
            words.push(counted(n, one, many));
        }
    }
    if let Some(genus) = topology.genus {
        words.push(format!("genus {genus}"));
    }
    words.join(", ")
}

#[cfg(test)]
mod tests {
    use chladni_mesh::TriMesh;
    use chladni_mesh::samples::icosphere;

    use super::*;

    #[test]
    fn a_fin_and_a_turned_face_are_found_and_a_seam_and_a_hole_are_none() {
        let sound = |change: fn(&mut TriMesh)| {
            let mut mesh = icosphere(1);
            change(&mut mesh);
            is_sound(&HealthReport::of(&mesh))
        };
        assert!(sound(|_| {}));
        // The first triangle has a corner of its own, in the place of another.
        assert!(sound(|mesh| {
            let [a, ..] = mesh.triangles[0];
            let own = mesh.positions[a as usize];
            mesh.triangles[0][0] = mesh.positions.len() as u32;
            mesh.positions.push(own);
        }));
        assert!(sound(|mesh| mesh.triangles.truncate(79)));
        assert!(!sound(|mesh| mesh.triangles[0].swap(0, 1)));
        assert!(!sound(|mesh| {
            let [a, b, _] = mesh.triangles[0];
            mesh.triangles.push([a, b, mesh.positions.len() as u32]);
            mesh.positions.push([2.0; 3]);
        }));
    }

    #[test]
    fn what_is_done_for_the_laplacian_is_described_and_so_is_why_there_is_none() {
        let operated = |mesh: &TriMesh| laplacian_row(CoverReport::of(mesh).as_ref()).1;
        assert_eq!(operated(&icosphere(1)), "the mesh as it is, 0 edge flips");
        let line = TriMesh {
            positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]],
            triangles: vec![[0, 1, 2]],
            ..TriMesh::default()
        };
        assert!(operated(&line).starts_with("none: "));
    }

    #[test]
    fn small_shapes_have_sizes_too() {
        assert_eq!(digits(1.25, 2.0), "1.250000");
        assert_eq!(digits(-0.0, 2.0), "0.000000");
        assert_eq!(digits(1e-5, 1.7e-5), "1.00000e-5");
        assert_eq!(digits(0.0, 1.7e-5), "0.000000");
    }
}
