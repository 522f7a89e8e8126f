//! Matches of real heads and animals; needs the shared data.

#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

use chladni_match::{Landmark, Match, MatchSettings, Method, match_shapes};
use chladni_mesh::{TriMesh, load_mesh};
use chladni_task::Task;

fn shared(name: &str) -> Option<TriMesh> {
    let path = chladni_testdata::shared(&format!("meshes/{name}"))?;
    Some(load_mesh(&path).unwrap().mesh)
}

fn run(shape: &TriMesh, template: &TriMesh, method: Method, landmarks: &[(u32, u32)]) -> Match {
    let landmarks = landmarks.iter().map(|&(shape, template)| Landmark { shape, template }).collect();
    match_shapes(
        shape,
        template,
        &MatchSettings { method, landmarks, seed: 1, ..MatchSettings::default() },
        &Task::new(),
    )
    .unwrap()
}

fn distance(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt()
}

fn diagonal(mesh: &TriMesh) -> f64 {
    let low: [f64; 3] =
        std::array::from_fn(|i| mesh.positions.iter().map(|p| p[i]).fold(f64::INFINITY, f64::min));
    let high: [f64; 3] =
        std::array::from_fn(|i| mesh.positions.iter().map(|p| p[i]).fold(f64::NEG_INFINITY, f64::max));
    distance(&low, &high)
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

#[test]
fn two_heads_of_one_model_match_without_their_indices() {
    let (Some(a), Some(b)) = (shared("heads/generic_neutral_mesh.obj"), shared("heads/identity005.obj"))
    else {
        return;
    };
    let found = run(&a, &b, Method::Fit, &[]);
    let error = found.correspondence.point.iter().zip(&b.positions).map(|(p, q)| distance(p, q)).collect();
    let error = median(error) / diagonal(&b);
    assert!(error < 0.001, "{error}");
    let flipped = found.report.flipped_triangles as f64 / found.report.triangles as f64;
    assert!(flipped < 0.005, "{flipped}");
    assert!(found.report.coverage > 0.9 && !found.report.near_tie, "{:?}", found.report);
}

#[test]
fn a_face_finds_its_place_on_a_whole_head() {
    let (Some(mask), Some(head)) = (shared("heads/reference.obj"), shared("heads/target.obj")) else {
        return;
    };
    // The landmarks that trimesh publishes for this pair.
    let published = [
        (177, 1633),
        (181, 1561),
        (614, 1556),
        (610, 1629),
        (114, 315),
        (398, 413),
        (812, 412),
        (227, 99),
        (241, 87),
        (674, 86),
        (660, 98),
        (362, 574),
        (779, 573),
    ];
    let found = run(&mask, &head, Method::Fit, &[]);
    assert!(!found.report.near_tie, "{:?}", found.report);
    let errors = published.iter().map(|&(s, t): &(u32, u32)| {
        distance(&found.correspondence.point[s as usize], &head.positions[t as usize]) / diagonal(&head)
    });
    assert!(median(errors.collect()) < 0.02);
    let led = run(&mask, &head, Method::Fit, &published);
    let errors = published.iter().map(|&(s, t)| {
        distance(&led.correspondence.point[s as usize], &head.positions[t as usize]) / diagonal(&head)
    });
    assert!(median(errors.collect()) < 0.01);
}

/// Nose, eyes, ears, chin, crown and nape, as vertices of face.obj and lion.off.
const MAN_LION: [(u32, u32); 8] = [
    (2867, 4756),
    (6714, 8297),
    (9957, 838),
    (16591, 5346),
    (16586, 3411),
    (10694, 4598),
    (12032, 1388),
    (6170, 2388),
];

#[test]
fn a_man_becomes_a_lion_without_tears() {
    let (Some(man), Some(lion)) = (shared("heads/face.obj"), shared("animals/lion.off")) else { return };
    let found = run(&man, &lion, Method::Map, &MAN_LION);
    for (s, t) in MAN_LION {
        let miss = distance(&found.correspondence.point[s as usize], &lion.positions[t as usize]);
        assert!(miss < 0.01 * diagonal(&lion), "{s} {t}: {miss}");
    }
    let flipped = found.report.flipped_triangles as f64 / found.report.triangles as f64;
    assert!(flipped < 0.03, "{flipped}");
    // Continuity: no edge of the man is torn across the lion.
    let torn = man
        .triangles
        .iter()
        .flat_map(|t| [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])])
        .map(|(a, b)| {
            distance(&found.correspondence.point[a as usize], &found.correspondence.point[b as usize])
        })
        .fold(0.0, f64::max);
    assert!(torn < 0.1 * diagonal(&lion), "{torn}");
}

#[test]
fn landmarks_swapped_left_for_right_are_noticed() {
    let (Some(mask), Some(head)) = (shared("heads/reference.obj"), shared("heads/target.obj")) else {
        return;
    };
    let swapped = [
        (177, 1556),
        (181, 1629),
        (614, 1633),
        (610, 1561),
        (398, 412),
        (812, 413),
        (114, 315),
        (362, 573),
        (779, 574),
    ];
    let found = run(&mask, &head, Method::Fit, &swapped);
    assert!(found.report.warnings.iter().any(|w| w.contains("landmarks")), "{:?}", found.report);
}
