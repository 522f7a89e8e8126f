//! The settings of a match: same connectivity, fixed size, and filling in where the match is not trusted.

#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

use chladni_match::{
    Correspondence, Landmark, MatchError, MatchSettings, Method, Scaling, has_same_vertices, infilled,
    match_shapes, same_connectivity,
};
use chladni_mesh::{Format, TriMesh, read_mesh, samples};
use chladni_task::Task;

fn moved(mesh: &TriMesh, map: impl Fn([f64; 3]) -> [f64; 3]) -> TriMesh {
    let mut moved = mesh.clone();
    moved.positions.iter_mut().for_each(|p| *p = map(*p));
    moved
}

/// A lump without any symmetry.
fn lump(subdivisions: u32) -> TriMesh {
    moved(&samples::icosphere(subdivisions), |[x, y, z]| {
        let r = 1.0 + 0.3 * (2.0 * x + 0.5).sin() + 0.2 * y * z + 0.15 * (3.0 * z + y).cos();
        [1.6 * r * x, r * y, 0.9 * r * z]
    })
}

fn distance(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt()
}

#[test]
fn the_same_vertices_are_told_by_their_triangles() {
    let shape = lump(2);
    let matched = |template: &TriMesh| same_connectivity(&shape, template, Scaling::Free);
    // The triangles in another order, each beginning with another corner.
    let mut reordered = moved(&shape, |p| p.map(|c| 3.0 * c));
    reordered.triangles.reverse();
    reordered.triangles.iter_mut().for_each(|t| t.rotate_left(1));
    assert_eq!(matched(&reordered).unwrap().confidence, vec![1.0; shape.positions.len()]);
    // The same number of vertices, but in another order: another mesh.
    let n = shape.positions.len() as u32;
    let mut other = shape.clone();
    other.positions.reverse();
    other.triangles.iter_mut().for_each(|t| *t = t.map(|v| n - 1 - v));
    let failed = matched(&other).unwrap_err();
    assert!(matches!(failed, MatchError::TrianglesDiffer { missing, .. } if missing > 0), "{failed}");
    let mut inside_out = shape.clone();
    inside_out.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    assert!(matches!(matched(&inside_out), Err(MatchError::TrianglesDiffer { .. })));
    let fewer = TriMesh { triangles: shape.triangles[1..].to_vec(), ..shape.clone() };
    assert!(matches!(matched(&fewer), Err(MatchError::TrianglesDiffer { missing: 1, extra: 0, .. })));
    // Also where only the template has more, or one of them twice.
    let refused = |shape: &TriMesh, template: &TriMesh| {
        same_connectivity(shape, template, Scaling::Free).unwrap_err().to_string()
    };
    let said = refused(&fewer, &shape);
    assert!(said.ends_with("1 of the template's 320 triangles are not among the shape's 319"), "{said}");
    let mut twice = shape.clone();
    twice.triangles.push(shape.triangles[0]);
    let said = refused(&shape, &twice);
    assert!(said.contains("320") && said.contains("321") && said.ends_with("twice"), "{said}");
}

/// A quadrilateral may become an arrowhead, and has then to be divided along its other diagonal.
#[test]
fn polygons_that_are_divided_otherwise_are_the_same() {
    let cube = |corner: &str, top: &str| {
        let obj = format!(
            "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv {corner} 1\nv 1 1 1\nv 0 1 1\nf 1 4 3 2\n\
             f 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\nf {top}\n"
        );
        read_mesh(obj.as_bytes(), Format::Obj).unwrap().mesh
    };
    let (rest, pulled) = (cube("1 0", "5 6 7 8"), cube("0.4 0.6", "5 6 7 8"));
    assert!(rest.triangles != pulled.triangles && has_same_vertices(&rest, &pulled));
    let found = same_connectivity(&rest, &pulled, Scaling::Free).unwrap();
    assert_eq!(found.confidence, [1.0; 8]);
    assert!(!has_same_vertices(&rest, &cube("0.4 0.6", "8 7 6 5")));
    // So they are without their polygons, as arrays, in whatever order.
    let bare = |mesh: &TriMesh| TriMesh {
        positions: mesh.positions.clone(),
        triangles: mesh.triangles.clone(),
        ..TriMesh::default()
    };
    let (bare, mut other) = (bare(&rest), bare(&pulled));
    other.triangles.reverse();
    assert!(bare.triangles != other.triangles && has_same_vertices(&bare, &other));
    other.triangles[0] = [0, 6, 2];
    assert!(!has_same_vertices(&bare, &other));
}

/// Some exporters leave a copy of a vertex behind, which no triangle uses and which need not move along.
#[test]
fn a_copy_that_no_triangle_uses_goes_with_the_vertex_in_its_place() {
    let mut shape = lump(3);
    shape.positions.push(shape.positions[7]);
    let stretch = |[x, y, z]: [f64; 3]| [1.1 * x, y, z + 0.1 * x];
    let mut template = moved(&shape, stretch);
    template.positions[642] = [9.0, 0.0, 0.0];
    let found = same_connectivity(&shape, &template, Scaling::Free).unwrap();
    let bare = same_connectivity(&lump(3), &moved(&lump(3), stretch), Scaling::Free).unwrap();
    assert_eq!(found.similarity, bare.similarity, "where it lies does not tilt the rest");
    assert_eq!(found.confidence[642], 1.0);
    assert_eq!(found.target[642], found.target[7]);
    assert!(infilled(&shape, &found).unwrap().is_none());
}

#[test]
fn a_size_that_is_kept_is_a_difference() {
    let shape = lump(3);
    // Turned, moved, and a fifth larger.
    let template = moved(&shape, |[x, y, z]| [-1.2 * y + 7.0, 1.2 * x - 3.0, 1.2 * z]);
    let landmarks: Vec<Landmark> =
        [0, 100, 200, 400].into_iter().map(|v| Landmark { shape: v, template: v }).collect();
    for (method, landmarks) in [
        (Method::Same, Vec::new()),
        (Method::Icp, Vec::new()),
        (Method::Icp, landmarks.clone()),
        (Method::Fit, Vec::new()),
        (Method::Map, landmarks),
    ] {
        let at = |scaling| {
            let settings =
                MatchSettings { method, landmarks: landmarks.clone(), scaling, ..MatchSettings::default() };
            match_shapes(&shape, &template, &settings, &Task::new()).unwrap()
        };
        let (free, rigid) = (at(Scaling::Free), at(Scaling::Rigid));
        let scale = free.correspondence.similarity.scale;
        assert!((scale - 1.0 / 1.2).abs() < 0.02, "{method:?}: {scale}");
        // Exact up to the rounding of the rotation.
        let scale = rigid.correspondence.similarity.scale;
        assert!((scale - 1.0).abs() < 1e-12, "{method:?}: {scale}");
        // Turned back onto the shape. By closest points alone, a larger lump may fit in another pose.
        let turn = rigid.correspondence.similarity.rotation;
        let back = (turn[0][1] - 1.0).abs() < 0.05 && (turn[1][0] + 1.0).abs() < 0.05;
        assert!(back || (landmarks.is_empty() && method != Method::Same), "{method:?}: {turn:?}");
        let (small, large) = (free.report.median_distance, rigid.report.median_distance);
        assert!(large > 0.01 && large > 3.0 * small, "{method:?}: {small} and {large}");
        assert!(rigid.report.warnings.iter().all(|w| !w.contains("one unit")));
    }
    let meters = moved(&shape, |p| p.map(|c| 0.001 * c));
    let settings =
        MatchSettings { method: Method::Same, scaling: Scaling::Rigid, ..MatchSettings::default() };
    let found = match_shapes(&shape, &meters, &settings, &Task::new()).unwrap();
    assert!(found.report.warnings.iter().any(|w| w.contains("1000.0 times smaller")), "{:?}", found.report);
}

#[test]
fn a_map_says_how_many_landmarks_it_cannot_use() {
    let template = lump(3);
    let mut shape = template.clone();
    let n = shape.positions.len() as u32;
    let ball = samples::icosphere(1);
    shape.positions.extend(ball.positions.iter().map(|p| [0.2 * p[0] + 3.0, 0.2 * p[1], 0.2 * p[2]]));
    shape.triangles.extend(ball.triangles.iter().map(|t| t.map(|v| n + v)));
    let warnings = |vertices: &[u32]| {
        let landmarks = vertices.iter().map(|v| Landmark { shape: *v, template: *v % n }).collect();
        let settings = MatchSettings { method: Method::Map, landmarks, ..MatchSettings::default() };
        match_shapes(&shape, &template, &settings, &Task::new()).unwrap().report.warnings
    };
    let says_so = |vertices: &[u32]| {
        let warnings = warnings(vertices);
        warnings.iter().any(|warning| warning.contains("1 of 5 landmarks lie outside"))
    };
    assert!(says_so(&[0, 100, 200, 400, n]));
    assert!(!says_so(&[0, 100, 200, 400, 500]));
}

/// A head whose template lacks the lower third, where nothing has a counterpart.
#[test]
fn what_the_template_lacks_goes_on_as_its_surroundings_do() {
    let shape = lump(4);
    let whole =
        moved(&shape, |[x, y, z]| [1.02 * x + 0.03 * z, 0.97 * y + 0.04 * (2.0 * z).sin(), z + 0.03 * x]);
    let mut cut = whole.clone();
    cut.triangles.retain(|t| t.iter().all(|v| shape.positions[*v as usize][2] > -0.4));
    // From above, all around.
    let high = (0..shape.positions.len() as u32).filter(|v| shape.positions[*v as usize][2] > 0.0);
    let landmarks = high.step_by(150).map(|v| Landmark { shape: v, template: v }).collect();
    let settings = MatchSettings { method: Method::Fit, landmarks, ..MatchSettings::default() };
    let found = match_shapes(&shape, &cut, &settings, &Task::new()).unwrap().correspondence;
    let filled = infilled(&shape, &found).unwrap().unwrap();
    assert!((0.05..0.5).contains(&filled.share), "{}", filled.share);
    // The result is nearer to the true difference than the raw match, which is as long as the distance to
    // the edge. What the fit dragged over the edge remains.
    let farthest = |points: &[[f64; 3]]| {
        let below = shape.positions.iter().zip(points).filter(|(p, _)| p[2] < -0.55);
        below.map(|(p, q)| distance(p, q)).fold(0.0, f64::max)
    };
    let aligned: Vec<_> = whole.positions.iter().map(|p| found.similarity.apply(*p)).collect();
    let (raw, mended, truth) = (farthest(&found.target), farthest(&filled.target), farthest(&aligned));
    assert!(mended < 0.4 * raw && truth < mended, "{raw}, {mended}, {truth}");
    for (v, c) in found.confidence.iter().enumerate() {
        if *c >= 0.5 {
            assert_eq!(filled.target[v], found.target[v]);
        }
    }
}

#[test]
fn a_match_that_is_trusted_everywhere_or_nowhere_is_left_alone_or_at_rest() {
    let shape = lump(2);
    let target: Vec<_> = shape.positions.iter().map(|p| p.map(|c| 1.5 * c)).collect();
    let found = |confidence: f64| Correspondence {
        confidence: vec![confidence; target.len()],
        target: target.clone(),
        ..same_connectivity(&shape, &shape, Scaling::Free).unwrap()
    };
    assert_eq!(infilled(&shape, &found(0.5)), Ok(None));
    let nowhere = infilled(&shape, &found(0.1)).unwrap().unwrap();
    assert!((nowhere.share - 1.0).abs() < 1e-9);
    for (p, q) in shape.positions.iter().zip(&nowhere.target) {
        assert!(distance(p, q) < 1e-9);
    }
    let fewer = TriMesh { positions: shape.positions[1..].to_vec(), ..TriMesh::default() };
    assert!(matches!(infilled(&fewer, &found(1.0)), Err(MatchError::LengthsDiffer { .. })));
}
