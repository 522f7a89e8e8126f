//! Meshes that are hard for eigensolvers, each compared with a dense solve or a closed form. The
//! certificate is recomputed from the result.

#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

mod shapes;

use chladni_harmonics::{
    Basis, BasisSettings, BasisWarning, Body, CoverReport, HarmonicsError, Laplacian, Operator,
    mesh_laplacian,
};
use chladni_mesh::TriMesh;
use chladni_task::Task;
use proptest::prelude::*;

fn build(mesh: &TriMesh, k: usize) -> Body {
    Body::build(mesh, &BasisSettings::new(k), &Task::new()).unwrap()
}

/// Solves, recomputes the certificate, and compares every eigenvalue with a dense solve.
fn against_dense(mesh: &TriMesh, k: usize) -> Body {
    against_dense_of(mesh, k, Laplacian::Delaunay)
}

fn against_dense_of(mesh: &TriMesh, k: usize, laplacian: Laplacian) -> Body {
    let settings = BasisSettings { laplacian, ..BasisSettings::new(k) };
    let body = Body::build(mesh, &settings, &Task::new()).unwrap();
    let operator = Operator::with(mesh, laplacian).unwrap();
    let certificate = operator.certify(&body.basis).unwrap();
    assert_eq!((certificate.laplacian, body.basis.certificate.laplacian), (laplacian, laplacian));
    assert!(certificate.inertia_counts_match == Some(true), "{certificate:?}");
    assert!(certificate.max_relative_residual < 1e-8, "{certificate:?}");
    assert!(certificate.max_orthogonality_error < 1e-8, "{certificate:?}");
    let exact = operator.dense_eigenvalues().unwrap();
    let scale = exact[exact.len() - 1];
    for (value, exact) in body.basis.eigenvalues.iter().zip(&exact) {
        assert!((value - exact).abs() <= 1e-9 * exact.abs() + 1e-13 * scale, "{value} for {exact}");
    }
    body
}

#[test]
fn three_identical_spheres_have_every_eigenvalue_three_times() {
    let sphere = shapes::icosphere(3);
    let mesh = shapes::beside(&[sphere.clone(), sphere.clone(), sphere], [3.0, 0.0, 0.0]);
    let body = against_dense(&mesh, 3 * 25);
    let mut k = 0;
    for l in 0..5 {
        let exact = f64::from(l * (l + 1));
        for _ in 0..3 * (2 * l + 1) {
            let lambda = body.basis.eigenvalues[k] * body.frame.scale.powi(2);
            assert!((lambda - exact).abs() <= 0.03 * exact + 1e-12, "l {l}: {lambda}");
            k += 1;
        }
    }
}

#[test]
fn fifty_identical_components_have_fifty_zeros_and_eigenvalues_of_multiplicity_150() {
    let mesh = shapes::beside(&vec![shapes::icosphere(0); 50], [2.5, 0.0, 0.0]);
    let body = against_dense(&mesh, 200);
    assert!(body.basis.eigenvalues[..50].iter().all(|l| *l == 0.0));
    assert!(body.basis.eigenvalues[50] > 0.0);
    let (first, last) = (body.basis.eigenvalues[50], body.basis.eigenvalues[199]);
    assert!((last - first).abs() < 1e-9 * first);
}

#[test]
fn a_flat_square_has_double_eigenvalues() {
    against_dense(&shapes::square(24), 100);
}

#[test]
fn plain_cotangents_of_obtuse_triangles_in_one_piece_and_in_two() {
    let mut slanted = shapes::square(22);
    slanted.positions.iter_mut().for_each(|p| p[0] += 4.0 * p[1]);
    let two = shapes::beside(&[slanted.clone(), shapes::icosphere(2)], [7.0, 0.0, 0.0]);
    for mesh in [slanted, two] {
        let body = against_dense_of(&mesh, 60, Laplacian::Cotangent);
        let operator = Operator::with(&mesh, Laplacian::Cotangent).unwrap();
        let above = |j: usize| operator.stiffness.column(j).filter(|(i, v)| *i != j && *v > 0.1).count();
        assert!((0..operator.vertices()).map(above).sum::<usize>() > 100, "the case is what it says");
        // The intrinsic Delaunay operator of the same mesh is a different one.
        let usual = build(&mesh, 60);
        assert!((usual.basis.eigenvalues[40] - body.basis.eigenvalues[40]).abs() > 1e-3);
    }
}

#[test]
fn a_moebius_strip_a_fan_and_flat_triangles() {
    // A strip of 60 quads whose ends are joined with a half turn.
    let (around, across) = (60_u32, 6_u32);
    let mut positions = Vec::new();
    for i in 0..around {
        let a = std::f64::consts::TAU * f64::from(i) / f64::from(around);
        for j in 0..across {
            let w = 0.4 * (f64::from(j) / f64::from(across - 1) - 0.5);
            let r = 1.0 + w * (a / 2.0).cos();
            positions.push([r * a.cos(), r * a.sin(), w * (a / 2.0).sin()]);
        }
    }
    let at = |i: u32, j: u32| if i < around { i * across + j } else { across - 1 - j };
    let triangles = (0..around)
        .flat_map(|i| (0..across - 1).map(move |j| (i, j)))
        .flat_map(|(i, j)| {
            [[at(i, j), at(i + 1, j), at(i, j + 1)], [at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]]
        })
        .collect();
    let strip = shapes::mesh(positions, triangles);
    against_dense(&strip, 60);

    // Three copies of the square that share one edge.
    let leaf = shapes::square(14);
    let turned = |angle: f64| TriMesh {
        positions: leaf.positions.iter().map(|p| [p[0] * angle.cos(), p[1], p[0] * angle.sin()]).collect(),
        ..leaf.clone()
    };
    against_dense(&shapes::beside(&[turned(0.0), turned(2.0), turned(4.0)], [0.0; 3]), 60);

    // Triangles without area among sound ones.
    let mut flat = shapes::square(18);
    for v in 0..17 {
        flat.triangles.push([v, v + 1, v + 2]);
    }
    against_dense(&flat, 40);
}

#[test]
fn the_smallest_and_the_fullest_problems() {
    let triangle = shapes::mesh(vec![[0.0; 3], [2.0, 0.0, 0.0], [0.0, 1.0, 0.0]], vec![[0, 1, 2]]);
    for k in 1..=3 {
        against_dense(&triangle, k);
    }
    let square = shapes::square(19);
    let n = square.positions.len();
    against_dense(&square, n - 1);
    against_dense(&square, n);
    let none = Body::build(&square, &BasisSettings::new(0), &Task::new()).unwrap_err();
    assert_eq!(none, HarmonicsError::BadHarmonicCount { harmonics: 0, vertices: n });
    let crowded = BasisSettings { threads: Some(1025), ..BasisSettings::new(9) };
    let refused = Body::build(&square, &crowded, &Task::new()).unwrap_err();
    assert_eq!(refused, HarmonicsError::TooManyThreads { threads: 1025, most: 1024 });
    let (body, report) =
        Body::load_or_build(&square, &BasisSettings::new(n + 1), None, &Task::new()).unwrap();
    assert_eq!(body.basis.harmonics(), n);
    let fewer = BasisWarning::FewerHarmonics { asked: n + 1, vertices: n };
    assert!(report.warnings(&body.basis.certificate).contains(&fewer));
}

#[test]
fn eigenvalues_scale_with_the_inverse_square_of_the_mesh() {
    let mesh = shapes::square(22);
    let plain = build(&mesh, 60);
    for factor in [1e8, 1e-8] {
        let body = build(&shapes::scaled(&mesh, factor), 60);
        for (a, b) in plain.basis.eigenvalues.iter().zip(&body.basis.eigenvalues) {
            let (a, b) = (a * plain.frame.scale.powi(2), b * (body.frame.scale * factor).powi(2));
            assert!((a - b).abs() <= 1e-9 * a, "{a} and {b} at {factor}");
        }
    }
}

#[test]
fn planted_faults_fail_the_certificate() {
    let mesh = shapes::square(24);
    let operator = Operator::of(&mesh).unwrap();
    let good = (*build(&mesh, 80).basis).clone();
    let n = good.vertices();
    assert_eq!(operator.certify(&good).unwrap().inertia_counts_match, Some(true));
    for k in [40, 60] {
        let mut removed = good.clone();
        removed.eigenvalues.remove(k);
        removed.vectors = [&good.vectors[..k * n], &good.vectors[(k + 1) * n..]].concat().into();
        assert_eq!(operator.certify(&removed).unwrap().inertia_counts_match, Some(false), "{k}");
    }
    // The second pair alone.
    let (eigenvalues, vectors) = (vec![good.eigenvalues[1]], good.harmonic(1).to_vec().into());
    let second = Basis { eigenvalues, vectors, ..good.clone() };
    assert_eq!(operator.certify(&second).unwrap().inertia_counts_match, Some(false));
    // The last harmonic in place of the constant.
    let mut misplaced = good.clone();
    misplaced.eigenvalues.pop();
    misplaced.vectors = [good.harmonic(79), &good.vectors[n..79 * n]].concat().into();
    let certificate = operator.certify(&misplaced).unwrap();
    assert!(certificate.max_relative_residual > 1e-6 && certificate.max_orthogonality_error < 1e-8);
    let mut doubled = good.clone();
    let copy = good.harmonic(40).to_vec();
    doubled.eigenvalues[41] = doubled.eigenvalues[40];
    doubled.vectors[41 * n..42 * n].copy_from_slice(&copy);
    assert!(operator.certify(&doubled).unwrap().max_orthogonality_error > 0.9);
    let mut unknown = good.clone();
    unknown.vectors[30 * n] = f64::NAN;
    let certificate = operator.certify(&unknown).unwrap();
    assert!(certificate.max_relative_residual.is_nan() && certificate.max_orthogonality_error.is_nan());
    assert!(!certificate.is_precise());
    let mut wrong = good;
    wrong.vectors[30 * n] += 1.0;
    assert!(operator.certify(&wrong).unwrap().max_relative_residual > 1e-6);
}

#[test]
fn a_false_constant_beside_a_speck_fails_the_certificate() {
    let speck = shapes::scaled(&shapes::icosphere(2), 1e-9);
    let mesh = shapes::beside(&[speck, shapes::icosphere(2)], [1e-3, 0.0, 0.0]);
    let operator = Operator::of(&mesh).unwrap();
    let good = (*build(&mesh, 20).basis).clone();
    assert!(operator.certify(&good).unwrap().is_precise());
    let (n, last) = (good.vertices(), good.harmonics() - 1);
    for constant in [0, 1] {
        let mut false_one = good.clone();
        false_one.eigenvalues.pop();
        let mut vectors = good.vectors[..last * n].to_vec();
        vectors[constant * n..(constant + 1) * n].copy_from_slice(good.harmonic(last));
        false_one.vectors = vectors.into();
        assert!(!operator.certify(&false_one).unwrap().is_precise(), "{constant}");
    }
}

#[test]
fn the_result_does_not_depend_on_threads() {
    let mesh = shapes::icosphere(3);
    let with = |threads| {
        let settings = BasisSettings { threads: Some(threads), ..BasisSettings::new(100) };
        Body::build(&mesh, &settings, &Task::new()).unwrap()
    };
    assert_eq!(with(1).basis, with(3).basis);
}

#[test]
fn whole_clusters_are_taken_whole_when_asked() {
    // The eigenvalue with l = 1 is exactly triple on an icosphere; K = 3 cuts it.
    let mesh = shapes::icosphere(3);
    let settings = BasisSettings::new(3);
    let (body, report) = Body::load_or_build(&mesh, &settings, None, &Task::new()).unwrap();
    assert_eq!((body.basis.harmonics(), report.cuts_cluster), (3, true));
    let settings = BasisSettings { whole_clusters: true, ..settings };
    let (body, report) = Body::load_or_build(&mesh, &settings, None, &Task::new()).unwrap();
    assert_eq!((body.basis.harmonics(), report.cuts_cluster), (4, false));
}

#[test]
fn a_cancelled_solve_says_so() {
    let task = Task::new();
    task.cancel();
    let result = Body::build(&shapes::icosphere(3), &BasisSettings::new(20), &task);
    assert!(matches!(result, Err(HarmonicsError::Cancelled(_))));
}

#[test]
fn what_cannot_be_used_is_told_apart() {
    let bad = |positions, triangles| {
        Body::build(&shapes::mesh(positions, triangles), &BasisSettings::new(1), &Task::new()).unwrap_err()
    };
    let corner = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    assert_eq!(bad(corner.clone(), vec![]), HarmonicsError::NoTriangle);
    assert_eq!(bad(corner.clone(), vec![[0, 1, 1]]), HarmonicsError::NoTriangle);
    assert_eq!(
        bad(corner.clone(), vec![[0, 1, 7]]),
        HarmonicsError::IndexOutOfRange { triangle: 0, vertex: 7, vertices: 3 }
    );
    let mut holed = corner;
    holed[1][2] = f64::NAN;
    assert_eq!(bad(holed, vec![[0, 1, 2]]), HarmonicsError::NotFinite { vertex: 1 });
    let line = vec![[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]];
    assert_eq!(bad(line, vec![[0, 1, 2]]), HarmonicsError::ZeroArea { vertices: 3, vertex: 0 });
}

#[test]
fn a_detached_part_without_area_is_left_out_with_a_warning() {
    let ball = shapes::icosphere(3);
    let (settings, task) = (BasisSettings::new(20), Task::new());
    let alone = Body::build(&ball, &settings, &task).unwrap();
    let mut mesh = ball.clone();
    let n = mesh.positions.len() as u32;
    mesh.positions.extend([[3.0; 3], [4.0; 3], [6.0; 3]]);
    mesh.triangles.insert(7, [n, n + 1, n + 2]);
    let (body, report) = Body::load_or_build(&mesh, &settings, None, &task).unwrap();
    assert_eq!(body.basis.eigenvalues, alone.basis.eigenvalues);
    assert_eq!((body.frame, &body.positions), (alone.frame, &alone.positions));
    assert_eq!(body.operator_vertex[n as usize..], [None; 3]);
    assert!(report.warnings(&body.basis.certificate).contains(&BasisWarning::WithoutArea { parts: 1 }));
    let operator = Operator::of(&mesh).unwrap();
    assert_eq!((operator.components(), operator.without_area), (1, 1));
    let (of_ball, of_both) = (mesh_laplacian(&ball, 1e-5).unwrap().1, mesh_laplacian(&mesh, 1e-5).unwrap().1);
    let area = |mass: &[f64]| mass.iter().take(n as usize).sum::<f64>();
    assert!((area(&of_ball) / area(&of_both) - 1.0).abs() < 1e-12 && of_both[n as usize] > 0.0);
    // A triangle whose corners are three vertices in one place, which this Laplacian does not weld.
    let mut with_point = ball.clone();
    with_point.positions.extend([[3.0; 3]; 3]);
    with_point.triangles.push([n, n + 1, n + 2]);
    let mass = mesh_laplacian(&with_point, 1e-5).unwrap().1;
    assert!((area(&of_ball) / area(&mass) - 1.0).abs() < 1e-12 && mass[n as usize] > 0.0);
}

#[test]
fn a_speck_that_the_working_frame_flattens_does_not_refuse_the_mesh() {
    let mut mesh = shapes::icosphere(2);
    mesh.positions.iter_mut().for_each(|p| *p = p.map(|x| x + 0.5));
    let alone = build(&mesh, 9);
    let n = mesh.positions.len() as u32;
    mesh.positions.extend([[0.0; 3], [1e-4, 0.0, 0.0], [2e-4, 2.7e-17, 0.0]]);
    mesh.triangles.push([n, n + 1, n + 2]);
    let operator = Operator::of(&mesh).unwrap();
    assert_eq!((operator.components(), operator.without_area), (2, 0));
    assert!(operator.mass.iter().all(|a| *a > 0.0));
    assert_eq!(operator.cover, Some(CoverReport::of(&mesh).unwrap()));
    for mollify in [0.0, 1e-5] {
        assert!(mesh_laplacian(&mesh, mollify).unwrap().1.iter().all(|a| *a > 0.0));
    }
    // The speck has a constant of its own, and its other eigenvalues are far above.
    let both = build(&mesh, 10);
    assert_eq!(both.basis.eigenvalues[..2], [0.0; 2]);
    for (value, exact) in both.basis.eigenvalues[2..].iter().zip(&alone.basis.eigenvalues[1..]) {
        assert!((value / exact - 1.0).abs() < 1e-3, "{value} for {exact}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    /// Random triangles on random points: non-manifold, self-intersecting, of every shape.
    #[test]
    fn random_soups_agree_with_a_dense_solve(
        points in proptest::collection::vec(prop::array::uniform3(-1.0_f64..1.0), 310..420),
        corners in proptest::collection::vec(prop::array::uniform3(0_u32..310), 500..900),
        k in 1_usize..90,
    ) {
        let mesh = shapes::mesh(points, corners);
        let usable = Operator::of(&mesh).unwrap().vertices();
        against_dense(&mesh, k.min(usable));
    }
}

/// The same surface with its vertices and triangles in reverse order.
fn listed_backwards(mesh: &TriMesh) -> TriMesh {
    let last = mesh.positions.len() as u32 - 1;
    TriMesh {
        positions: mesh.positions.iter().rev().copied().collect(),
        triangles: mesh.triangles.iter().rev().map(|t| t.map(|v| last - v)).collect(),
        ..TriMesh::default()
    }
}

#[test]
fn equal_eigenvalues_have_the_same_harmonics_however_the_vertices_are_listed() {
    // K = 30 cuts the nine eigenvalues of l = 5 on the sphere; K = 40 cuts a pair (i, j), (j, i) of the
    // square.
    for (mesh, harmonics) in [(shapes::icosphere(3), 30), (shapes::square(24), 40)] {
        let (there, back) = (build(&mesh, harmonics), build(&listed_backwards(&mesh), harmonics));
        let n = there.basis.vertices();
        for k in 0..harmonics {
            let backwards = back.basis.harmonic(k).iter().rev();
            let furthest = (there.basis.harmonic(k).iter().zip(backwards))
                .fold(0.0_f64, |m, (a, b)| m.max((a - b).abs()));
            assert!(furthest < 1e-6, "harmonic {k} of {n} vertices differs by {furthest:e}");
        }
        assert!(there.basis.certificate.is_precise());
    }
}
