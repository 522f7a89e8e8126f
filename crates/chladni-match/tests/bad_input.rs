//! Any input must give finite numbers or an error.

use chladni_match::{
    Correspondence, Ellipsoid, Landmark, MatchError, MatchReport, MatchSettings, Method, Scaling, Side,
    infilled, match_shapes, onto_ellipsoid, same_connectivity, self_scaled,
};
use chladni_mesh::{TriMesh, samples};
use chladni_task::{Cancelled, Task};
use proptest::prelude::*;

fn mesh(positions: Vec<[f64; 3]>, triangles: Vec<[u32; 3]>) -> TriMesh {
    TriMesh { positions, triangles, ..TriMesh::default() }
}

fn settings(method: Method) -> MatchSettings {
    MatchSettings { method, ..MatchSettings::default() }
}

fn check(found: &Correspondence, template: Option<&TriMesh>) {
    let numbers = found.point.iter().chain(&found.target).flatten().chain(&found.confidence);
    assert!(numbers.copied().all(f64::is_finite));
    assert!(found.confidence.iter().all(|c| (0.0..=1.0).contains(c)));
    assert!(found.similarity.to_matrix().iter().flatten().all(|x| x.is_finite()));
    if let (Some(on), Some(template)) = (&found.on_template, template) {
        for on in on {
            assert!((on.triangle as usize) < template.triangles.len());
            let b = on.weights;
            assert!(b.iter().all(|b| *b >= -1e-9) && (b.iter().sum::<f64>() - 1.0).abs() < 1e-9);
        }
    }
}

fn check_report(report: &MatchReport) {
    for x in
        [report.median_distance, report.p95_distance, report.coverage, report.stretch, report.mean_confidence]
    {
        assert!(x.is_finite(), "{report:?}");
    }
    assert!(
        [report.residual_median, report.residual_p95].iter().flatten().all(|x| x.is_finite()),
        "{report:?}"
    );
    assert!(report.strongly_stretched <= report.triangles, "{report:?}");
}

/// Unconnected triangles of any size and place, some flat, some repeated.
fn soup() -> impl Strategy<Value = TriMesh> {
    let coordinate = prop_oneof![-1.0..1.0f64, Just(0.0), Just(1.0)];
    (
        prop::collection::vec(prop::array::uniform3(coordinate), 3..25),
        prop::collection::vec(prop::array::uniform3(0usize..25), 1..40),
        -6..6i32,
    )
        .prop_map(|(points, triangles, exponent)| {
            let n = points.len();
            let scale = 10.0_f64.powi(exponent);
            mesh(
                points.iter().map(|p| p.map(|x| x * scale + scale)).collect(),
                triangles.iter().map(|t| t.map(|v| (v % n) as u32)).collect(),
            )
        })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(6))]
    #[test]
    fn any_two_soups_give_finite_numbers_or_an_error(shape in soup(), template in soup()) {
        let all = [Method::Icp, Method::Fit, Method::Map].into_iter();
        for (method, scaling) in all.flat_map(|m| [(m, Scaling::Free), (m, Scaling::Rigid)]) {
            let mut s = MatchSettings { scaling, ..settings(method) };
            if method == Method::Map {
                s.landmarks = (0..3).map(|v| Landmark { shape: v, template: v }).collect();
            }
            if let Ok(found) = match_shapes(&shape, &template, &s, &Task::new()) {
                check(&found.correspondence, Some(&template));
                check_report(&found.report);
                if let Some(filled) = infilled(&shape, &found.correspondence).unwrap() {
                    assert!(filled.target.iter().flatten().all(|x| x.is_finite()) && filled.share <= 1.0 + 1e-9);
                }
            }
        }
    }
}

proptest! {
    #[test]
    fn templates_without_a_mesh_give_finite_numbers_or_an_error(shape in soup(), scale in 0.0..3.0f64) {
        let found = Ellipsoid::fitted(&shape).and_then(|e| onto_ellipsoid(&shape, &e));
        let sphere = Ellipsoid::fitted_sphere(&shape).and_then(|e| onto_ellipsoid(&shape, &e));
        for found in [found, sphere, self_scaled(&shape, scale)].into_iter().flatten() {
            check(&found, None);
            check_report(&MatchReport::without_template(&shape, &found).unwrap());
        }
        if let Ok(found) = same_connectivity(&shape, &shape, Scaling::Free) {
            check(&found, Some(&shape));
        }
    }
}

/// Three thousand triangles that do not touch each other.
fn confetti() -> TriMesh {
    mesh(
        (0..3000)
            .flat_map(|i| {
                let [x, y, z] = [(i % 20) as f64, (i / 20 % 20) as f64, (i / 400) as f64];
                [[x, y, z], [x + 0.1, y, z], [x, y + 0.1, z]]
            })
            .collect(),
        (0..3000).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect(),
    )
}

/// A ball stretched along x, y and z, with a nose on the positive side of x.
fn potato() -> TriMesh {
    let mut ball = samples::icosphere(3);
    for p in &mut ball.positions {
        let nose = 1.0 + 0.3 * (-8.0 * (1.0 - p[0])).exp();
        *p = [nose * p[0], 0.8 * p[1], 1.2 * p[2]];
    }
    ball
}

#[test]
fn confetti_and_a_template_in_two_places_give_finite_numbers() {
    let ball = potato();
    let n = ball.positions.len() as u32;
    let far = ball.positions.iter().map(|p| [p[0] + 50.0, p[1], p[2]]);
    let two_places = mesh(
        ball.positions.iter().copied().chain(far).collect(),
        ball.triangles.iter().copied().chain(ball.triangles.iter().map(|t| t.map(|v| v + n))).collect(),
    );
    for (shape, template) in [(&confetti(), &ball), (&ball, &two_places)] {
        let found = match_shapes(shape, template, &settings(Method::Fit), &Task::new()).unwrap();
        check(&found.correspondence, Some(template));
        check_report(&found.report);
    }
}

/// The vertex that is farthest along a direction.
fn extreme(mesh: &TriMesh, along: [f64; 3]) -> u32 {
    let reach = |p: &[f64; 3]| (0..3).map(|i| p[i] * along[i]).sum::<f64>();
    let farthest = mesh.positions.iter().enumerate().max_by(|a, b| reach(a.1).total_cmp(&reach(b.1)));
    farthest.map_or(0, |(v, _)| v as u32)
}

#[test]
fn swapped_and_senseless_landmarks_are_said_to_be_so() {
    let ball = potato();
    let at = |x: f64, y: f64, z: f64| extreme(&ball, [x, y, z]);
    let [nose, nape, left, right, top, bottom] = [
        at(1.0, 0.0, 0.0),
        at(-1.0, 0.0, 0.0),
        at(0.3, 1.0, 0.3),
        at(0.3, -1.0, 0.3),
        at(0.0, 0.0, 1.0),
        at(0.0, 0.0, -1.0),
    ];
    let pairs = |list: &[(u32, u32)]| -> Vec<Landmark> {
        list.iter().map(|&(shape, template)| Landmark { shape, template }).collect()
    };
    let good = [(nose, nose), (nape, nape), (left, left), (right, right), (top, top), (bottom, bottom)];
    let swapped = [(nose, nose), (nape, nape), (left, right), (right, left), (top, top), (bottom, bottom)];
    let senseless = [(nose, top), (nape, left), (left, nose), (right, bottom), (top, right), (bottom, nape)];
    for (list, doubted) in [(good, false), (swapped, true), (senseless, true)] {
        for method in [Method::Fit, Method::Map] {
            let s = MatchSettings { landmarks: pairs(&list), ..settings(method) };
            let found = match_shapes(&ball, &ball, &s, &Task::new()).unwrap();
            check(&found.correspondence, Some(&ball));
            check_report(&found.report);
            let doubts = found.report.warnings.iter().any(|w| w.contains("landmarks"));
            assert_eq!(doubts, doubted, "{method:?}: {:?}", found.report.warnings);
        }
    }
    // Three landmarks at one spot of the template do not determine its rotation.
    let s =
        MatchSettings { landmarks: pairs(&[(nose, top), (nape, top), (left, top)]), ..settings(Method::Fit) };
    let failed = match_shapes(&ball, &ball, &s, &Task::new());
    assert_eq!(failed, Err(MatchError::Degenerate));
}

#[test]
fn hopeless_templates_are_errors_or_say_that_they_are_not_trusted() {
    let shape = samples::icosphere(3);
    let triangle = mesh(vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], vec![[0, 1, 2]]);
    let flat = samples::grid_square(6);
    for template in [&triangle, &flat, &confetti()] {
        let found = match_shapes(&shape, template, &settings(Method::Fit), &Task::new()).unwrap();
        check(&found.correspondence, Some(template));
        assert!(!found.report.warnings.is_empty(), "{:?}", found.report);
        assert!(found.report.mean_confidence < 0.6, "{:?}", found.report);
    }
    let line = mesh(vec![[0.0; 3], [1.0; 3], [2.0; 3]], vec![[0, 1, 2]]);
    let failed = match_shapes(&shape, &line, &settings(Method::Fit), &Task::new());
    assert_eq!(failed, Err(MatchError::NoSurface(Side::Template)));
}

#[test]
fn landmarks_that_are_not_there_are_named() {
    let shape = samples::icosphere(2);
    let mut template = shape.clone();
    template.positions.push([9.0; 3]);
    let loose = template.positions.len() as u32 - 1;
    for (s, t, side) in [(100_000, 0, Side::Shape), (0, 100_000, Side::Template), (0, loose, Side::Template)]
    {
        let landmarks = vec![Landmark { shape: s, template: t }];
        let wrong = MatchSettings { landmarks, ..settings(Method::Fit) };
        let failed = match_shapes(&shape, &template, &wrong, &Task::new()).unwrap_err();
        let is_named =
            matches!(&failed, MatchError::Landmark { landmark: 0, side: found, .. } if *found == side);
        // The text counts from one.
        assert!(is_named && failed.to_string().starts_with("landmark 1: "), "{failed:?}");
    }
    let few = match_shapes(&shape, &shape, &settings(Method::Map), &Task::new());
    assert_eq!(few, Err(MatchError::TooFewLandmarks(0)));
    let shape = samples::icosphere(4);
    let landmarks = (0..2001).map(|v| Landmark { shape: v, template: v }).collect();
    let many = MatchSettings { landmarks, ..settings(Method::Map) };
    let refused = match_shapes(&shape, &shape, &many, &Task::new()).unwrap_err().to_string();
    assert!(refused.contains("at most 2000") && refused.ends_with("not 2001"), "{refused}");
}

#[test]
fn what_is_no_sphere_cannot_be_mapped_to_one() {
    let shape = samples::icosphere(2);
    let landmarks: Vec<Landmark> = (0..4).map(|v| Landmark { shape: v, template: 7 * v }).collect();
    let torus = samples::torus(0.4, 20, 12);
    let failed =
        match_shapes(&shape, &torus, &MatchSettings { landmarks, ..settings(Method::Map) }, &Task::new());
    assert!(matches!(failed, Err(MatchError::NoCommonDomain { side: Side::Template, .. })), "{failed:?}");
}

#[test]
fn cancelling_stops_the_work() {
    let task = Task::new();
    task.cancel();
    let shape = samples::icosphere(3);
    for method in [Method::Icp, Method::Fit] {
        let stopped = match_shapes(&shape, &shape, &settings(method), &task);
        assert_eq!(stopped, Err(MatchError::Cancelled(Cancelled)));
    }
}
