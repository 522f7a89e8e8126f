//! Shapes of a few triangles with sharp corners, or of one.

#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

use chladni_match::{Match, MatchSettings, Method, match_shapes};
use chladni_mesh::TriMesh;
use chladni_mesh::surface::vec3::distance;
use chladni_task::Task;

fn mesh(positions: &[[f64; 3]], triangles: &[[u32; 3]]) -> TriMesh {
    TriMesh { positions: positions.to_vec(), triangles: triangles.to_vec(), ..TriMesh::default() }
}

fn tetrahedron() -> TriMesh {
    let corners = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    mesh(&corners, &[[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
}

fn cuboid(size: [f64; 3]) -> TriMesh {
    let corner = |i: usize| [0, 1, 2].map(|axis| size[axis] * ((i >> axis) & 1) as f64);
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles: Vec<[u32; 3]> = faces.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    mesh(&(0..8).map(corner).collect::<Vec<[f64; 3]>>(), &triangles)
}

fn matched(shape: &TriMesh, template: &TriMesh, method: Method) -> Match {
    let settings = MatchSettings { method, ..MatchSettings::default() };
    match_shapes(shape, template, &settings, &Task::new()).unwrap()
}

#[test]
fn sharp_corners_are_found_and_are_no_folds() {
    let (cube, longer, brick) = (cuboid([1.0; 3]), cuboid([1.0, 1.0, 1.1]), cuboid([1.0, 2.0, 3.0]));
    let solid = tetrahedron();
    for (shape, template) in [(&solid, &solid), (&cube, &longer), (&brick, &brick)] {
        for method in [Method::Same, Method::Icp, Method::Fit] {
            let Match { correspondence, report } = matched(shape, template, method);
            let spoiled = report.flipped_triangles + report.strongly_stretched;
            assert!(spoiled == 0 && report.coverage > 0.9, "{method:?}: {report:?}");
            for (found, own) in correspondence.target.iter().zip(&shape.positions) {
                assert!(distance(*found, *own) < 0.1, "{method:?}: {found:?} {own:?}");
            }
        }
    }
}

#[test]
fn coverage_of_nothing_is_not_below_0() {
    let triangle = mesh(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], &[[0, 1, 2]]);
    let report = matched(&triangle, &triangle, Method::Icp).report;
    assert!(report.coverage == 0.0 && report.coverage.is_sign_positive(), "{report:?}");
    assert!(report.warnings.iter().any(|w| w.starts_with("only 0 %")), "{:?}", report.warnings);
}
