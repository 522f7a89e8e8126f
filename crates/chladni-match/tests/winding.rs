//! Files whose faces look inward, or partly so, are matched as well as others.

#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

use chladni_match::{Landmark, Match, MatchSettings, Method, match_shapes};
use chladni_mesh::surface::vec3::distance;
use chladni_mesh::{TriMesh, samples};
use chladni_task::Task;

fn moved(mesh: &TriMesh, map: impl Fn([f64; 3]) -> [f64; 3]) -> TriMesh {
    TriMesh { positions: mesh.positions.iter().map(|p| map(*p)).collect(), ..mesh.clone() }
}

/// A lump without any symmetry, and the same bent, turned and in other units.
fn pair() -> [TriMesh; 2] {
    let shape = moved(&samples::icosphere(3), |[x, y, z]| {
        let r = 1.0 + 0.3 * (2.0 * x + 0.5).sin() + 0.2 * y * z + 0.15 * (3.0 * z + y).cos();
        [1.6 * r * x, r * y, 0.9 * r * z]
    });
    let template = moved(&shape, |[x, y, z]| [3.0 * y, -3.0 * (x + 0.1 * (2.0 * z).sin()), 3.0 * z]);
    [shape, template]
}

/// Turns every `nth` triangle round.
fn turned(mut mesh: TriMesh, nth: usize) -> TriMesh {
    mesh.triangles.iter_mut().step_by(nth).for_each(|t| t.swap(0, 2));
    mesh
}

fn matched(shape: &TriMesh, template: &TriMesh, method: Method) -> Match {
    let landmarks = [0, 120, 240, 360, 480, 600].map(|v| Landmark { shape: v, template: v }).to_vec();
    let settings = MatchSettings { method, landmarks, ..MatchSettings::default() };
    match_shapes(shape, template, &settings, &Task::new()).unwrap()
}

#[test]
fn faces_that_look_inward_are_turned_for_the_match_and_reported() {
    let [shape, template] = pair();
    for method in [Method::Icp, Method::Fit, Method::Map] {
        let known = matched(&shape, &template, method);
        assert!(known.report.warnings.iter().all(|w| !w.contains("inward")), "{:?}", known.report);
        assert!(known.report.coverage > 0.9, "{:?}", known.report);
        for (inward_shape, inward_template) in
            [(Some(1), None), (None, Some(1)), (Some(1), Some(1)), (Some(5), None)]
        {
            let wound = |mesh: &TriMesh, nth: Option<usize>| match nth {
                Some(nth) => turned(mesh.clone(), nth),
                None => mesh.clone(),
            };
            let (s, t) = (wound(&shape, inward_shape), wound(&template, inward_template));
            let found = matched(&s, &t, method);
            let (near, report) = (&known.report, &found.report);
            assert!((report.coverage - near.coverage).abs() < 0.02, "{method:?}: {report:?}");
            assert!((report.mean_confidence - near.mean_confidence).abs() < 0.02, "{method:?}: {report:?}");
            assert!(report.flipped_triangles <= near.flipped_triangles + 20, "{method:?}: {report:?}");
            for (p, q) in found.correspondence.target.iter().zip(&known.correspondence.target) {
                let distance = distance(*p, *q);
                assert!(distance < 0.3, "{method:?}: {distance}");
            }
            for (nth, side) in [(inward_shape, "shape"), (inward_template, "template")] {
                let said = nth.map(|nth| {
                    format!("{} of 1280 faces of the {side} look inward", 1280_usize.div_ceil(nth))
                });
                let warned =
                    report.warnings.iter().find(|w| w.contains(&format!("of the {side} look inward")));
                assert_eq!(warned.is_some(), said.is_some(), "{:?}", report.warnings);
                assert!(said.is_none_or(|said| warned.unwrap().starts_with(&said)), "{:?}", report.warnings);
            }
        }
    }
}

#[test]
fn the_report_says_how_close_bending_came_and_what_is_strongly_stretched() {
    let [shape, template] = pair();
    let fit = matched(&shape, &template, Method::Fit).report;
    assert!(fit.residual_median.unwrap() < 0.5 * fit.median_distance, "{fit:?}");
    assert!(fit.residual_median < fit.residual_p95, "{fit:?}");
    let icp = matched(&shape, &template, Method::Icp).report;
    assert!((icp.residual_median.unwrap() - icp.median_distance).abs() < 1e-9, "{icp:?}");
    let same = |template: &TriMesh| matched(&shape, template, Method::Same).report;
    assert_eq!((same(&template).residual_median, same(&template).strongly_stretched), (None, 0));
    // Ten times as long: all triangles but those across it.
    let long = same(&moved(&shape, |[x, y, z]| [10.0 * x, y, z]));
    assert!(long.strongly_stretched > long.triangles / 2 && long.stretch > 5.0, "{long:?}");
}
