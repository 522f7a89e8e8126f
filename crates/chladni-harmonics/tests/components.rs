//! Shapes with several connected components: the lowest pairs of the whole, whatever share each component
//! has.

#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

mod shapes;

use chladni_harmonics::{BasisSettings, Body, Operator};
use chladni_mesh::TriMesh;
use chladni_task::Task;
use proptest::prelude::*;

/// Solves and recomputes the certificate.
fn certified(mesh: &TriMesh, k: usize) -> Body {
    let body = Body::build(mesh, &BasisSettings::new(k), &Task::new()).unwrap();
    let certificate = Operator::of(mesh).unwrap().certify(&body.basis).unwrap();
    for certificate in [certificate, body.basis.certificate] {
        assert!(certificate.is_precise(), "{certificate:?}");
    }
    assert_eq!(body.basis.harmonics(), k);
    body
}

/// Compares every eigenvalue with those of the parts, each solved separately as a dense matrix.
fn against_dense_parts(parts: &[TriMesh], offset: [f64; 3], k: usize) -> Body {
    let body = certified(&shapes::beside(parts, offset), k);
    let mut exact: Vec<f64> = parts
        .iter()
        .flat_map(|part| {
            let operator = Operator::of(part).unwrap();
            let mut values = operator.dense_eigenvalues().unwrap();
            values[0] = 0.0;
            let ratio = (body.frame.scale / operator.frame.scale).powi(-2);
            values.into_iter().map(move |value| value * ratio)
        })
        .collect();
    exact.sort_by(f64::total_cmp);
    for (value, exact) in body.basis.eigenvalues.iter().zip(&exact) {
        assert!((value - exact).abs() <= 1e-9 * exact, "{value} for {exact}");
    }
    body
}

#[test]
fn equal_components_have_eigenvalues_of_any_multiplicity() {
    // Each fivefold eigenvalue occurs sixty times, beyond what a single Krylov space of the whole could
    // hold.
    let body = against_dense_parts(&vec![shapes::icosphere(3); 12], [2.5, 0.0, 0.0], 300);
    assert!(body.basis.eigenvalues[12] > 0.0 && body.basis.eigenvalues[11] == 0.0);
    against_dense_parts(&vec![shapes::icosphere(2); 40], [2.5, 0.0, 0.0], 300);
}

#[test]
fn equal_components_that_are_solved_by_slices() {
    let sphere = shapes::icosphere(4);
    let alone = Body::build(&sphere, &BasisSettings::new(100), &Task::new()).unwrap();
    let body = certified(&shapes::beside(&vec![sphere; 3], [3.0, 0.0, 0.0]), 300);
    let ratio = (body.frame.scale / alone.frame.scale).powi(-2);
    for (k, value) in body.basis.eigenvalues.iter().enumerate() {
        let exact = alone.basis.eigenvalues[k / 3] * ratio;
        assert!((value - exact).abs() <= 1e-9 * exact, "{k}: {value} for {exact}");
    }
}

#[test]
fn components_of_different_shape_and_size_have_their_own_shares() {
    let parts = [
        shapes::icosphere(3),
        shapes::scaled(&shapes::square(12), 0.3),
        shapes::scaled(&shapes::icosphere(1), 1e-3),
        shapes::square(17),
    ];
    for k in [4, 5, 90, 400] {
        against_dense_parts(&parts, [2.5, 0.0, 0.0], k);
    }
    // All harmonics, up to those of the tiny component, which are a million times larger than the others.
    let n = parts.iter().map(|part| part.positions.len()).sum();
    against_dense_parts(&parts, [2.5, 0.0, 0.0], n);
}

#[test]
fn a_speck_does_no_harm_to_the_rest() {
    let sphere = shapes::icosphere(4);
    let speck = shapes::scaled(&shapes::icosphere(3), 1e-9);
    let alone = Body::build(&sphere, &BasisSettings::new(79), &Task::new()).unwrap();
    let body = certified(&shapes::beside(&[speck, sphere], [1e-3, 0.0, 0.0]), 80);
    for (value, exact) in body.basis.eigenvalues[1..].iter().zip(&alone.basis.eigenvalues) {
        assert!((value - exact).abs() <= 1e-3 * exact, "{value} for {exact}");
    }
}

#[test]
fn a_sheet_of_slivers_beside_a_sound_component_does_not_spoil_the_basis() {
    // Every other column of cells is a ten-millionth wide: solved as a dense matrix, it has residuals of
    // 10⁻⁴.
    let sheet = shapes::square(16);
    let slim = |p: &[f64; 3]| {
        let column = (p[0] * 16.0).round();
        let x = if column % 2.0 == 0.0 { p[0] } else { (column - 1.0) / 16.0 + 1e-7 };
        [x, p[1], 0.3 * (5.0 * p[0]).sin() * p[1]]
    };
    let slivers = TriMesh { positions: sheet.positions.iter().map(slim).collect(), ..sheet };
    let body = certified(&shapes::beside(&[shapes::icosphere(3), slivers], [2.5, 0.0, 0.0]), 100);
    assert!(body.basis.eigenvalues[2] > 0.0);
}

#[test]
fn three_hundred_triangles_and_every_number_of_harmonics() {
    let triangle = shapes::mesh(vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], vec![[0, 1, 2]]);
    let parts = vec![triangle; 300];
    for k in [1, 299, 300, 301, 599, 600, 601, 899, 900] {
        against_dense_parts(&parts, [1.5, 0.0, 0.0], k);
    }
}

#[test]
fn a_cluster_that_goes_through_all_components_is_taken_whole_when_asked() {
    // λ = 0 twice, then l = 1 on both spheres: six equal eigenvalues.
    let mesh = shapes::beside(&vec![shapes::icosphere(3); 2], [3.0, 0.0, 0.0]);
    for (asked, whole) in [(1, 2), (2, 2), (3, 8), (7, 8), (8, 8)] {
        let build = |whole_clusters| {
            let settings = BasisSettings { whole_clusters, ..BasisSettings::new(asked) };
            let (body, report) = Body::load_or_build(&mesh, &settings, None, &Task::new()).unwrap();
            (body.basis.harmonics(), report.cuts_cluster)
        };
        assert_eq!(build(false), (asked, asked < whole));
        assert_eq!(build(true), (whole, false));
    }
}

#[test]
fn threads_change_nothing_and_progress_comes_to_its_end() {
    let mesh =
        shapes::beside(&[shapes::icosphere(3), shapes::square(30), shapes::icosphere(1)], [2.5, 0.0, 0.0]);
    let with = |threads| {
        let (settings, task) =
            (BasisSettings { threads: Some(threads), ..BasisSettings::new(150) }, Task::new());
        let body = Body::build(&mesh, &settings, &task).unwrap();
        let progress = task.progress();
        assert!(progress.total >= 150 && progress.done == progress.total, "{progress:?}");
        body.basis
    };
    let one = with(1);
    assert_eq!(one, with(2));
    assert_eq!(one, with(5));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// Spheres, squares and triangles of sizes from 10⁻³ to 1, in any order.
    #[test]
    fn random_collections_agree_with_dense_solves_of_their_parts(
        kinds in proptest::collection::vec((0_usize..5, -3.0_f64..0.0), 2..9),
        share in 0.0_f64..1.0,
    ) {
        let triangle = shapes::mesh(vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], vec![[0, 1, 2]]);
        let shapes_of = [triangle, shapes::square(3), shapes::icosphere(1), shapes::square(9), shapes::icosphere(2)];
        let parts: Vec<TriMesh> =
            kinds.iter().map(|&(kind, size)| shapes::scaled(&shapes_of[kind], 10_f64.powf(size))).collect();
        let n: usize = parts.iter().map(|part| part.positions.len()).sum();
        against_dense_parts(&parts, [2.5, 0.0, 0.0], ((share * n as f64) as usize).max(1));
    }
}
