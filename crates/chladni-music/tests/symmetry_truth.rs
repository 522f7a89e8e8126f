//! The classes agree with what the mirror itself does to each harmonic.

#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "a panic is how a test fails, a printed line how it tells what it skipped"
)]

use std::sync::Arc;

use chladni_harmonics::{BasisSettings, Body};
use chladni_mesh::{TriMesh, samples};
use chladni_music::{Class, Symmetry, SymmetryMethod};
use chladni_task::Task;

const K: usize = 100;

/// ⟨H_k, H_k∘T⟩ where T is the mirror x → 2c − x taken to the nearest vertex, by brute force
/// over at most 3000 vertices spread over the list: another way than the crate's own.
fn measured(body: &Body, c: f64) -> Vec<f64> {
    let n = body.positions.len();
    let some: Vec<usize> = (0..n).step_by(n.div_ceil(3000)).collect();
    let image: Vec<usize> = some
        .iter()
        .map(|&v| {
            let p = body.positions[v];
            let q = [2.0 * c - p[0], p[1], p[2]];
            (0..n)
                .min_by(|&i, &j| {
                    let d = |v: usize| (0..3).map(|a| (body.positions[v][a] - q[a]).powi(2)).sum::<f64>();
                    d(i).total_cmp(&d(j))
                })
                .unwrap()
        })
        .collect();
    (0..body.basis.harmonics())
        .map(|k| {
            let h = body.basis.harmonic(k);
            some.iter().zip(&image).map(|(&v, &w)| body.basis.mass[v] * h[v] * h[w]).sum()
        })
        .collect()
}

/// Share of the non-degenerate harmonics k ≥ 1 whose class is the sign of what was measured.
fn agreement(mesh: &TriMesh, c: f64) -> (f64, usize, Symmetry) {
    let body = Body::build(mesh, &BasisSettings::new(K + 1), &Task::new()).unwrap();
    let symmetry = Symmetry::of(&body, &Task::new()).unwrap();
    let truth = measured(&body, c);
    let lambda = &body.basis.eigenvalues;
    let single: Vec<usize> = (1..K)
        .filter(|&k| {
            lambda[k] - lambda[k - 1] > 1e-3 * lambda[k] && lambda[k + 1] - lambda[k] > 1e-3 * lambda[k]
        })
        .collect();
    let agree =
        single.iter().filter(|&&k| f64::from(symmetry.classes[k].sign()) == truth[k].signum()).count();
    println!(
        "agree {agree} of {}; method {:?}; {} extrema, {} pairs; undecided {}; smallest |score| {:.3}",
        single.len(),
        symmetry.method,
        symmetry.extrema.len(),
        symmetry.pairs.len(),
        symmetry.classes[..K].iter().filter(|c| **c == Class::Undecided).count(),
        symmetry.scores[..K].iter().map(|s| s.abs()).fold(f64::MAX, f64::min)
    );
    (agree as f64 / single.len().max(1) as f64, single.len(), symmetry)
}

/// Two ellipsoidal lobes of different size joined to a body that is a mirror image of itself
/// in x, in no other plane, and whose eigenvalues are all single.
fn mirror_blob() -> TriMesh {
    let mut mesh = samples::icosphere(4);
    for p in &mut mesh.positions {
        let [x, y, z] = *p;
        let arms = 0.9 * x * x * (0.4 + 0.6 * y);
        *p = [1.3 * x + 0.5 * x * arms, 0.8 * y + arms + 0.1 * z * z, 0.6 * z + 0.35 * y * y - 0.15 * x * x];
    }
    mesh
}

#[test]
fn built_in_mirror_shape() {
    let (share, count, symmetry) = agreement(&mirror_blob(), 0.0);
    assert!(count > 80, "{count} single harmonics");
    assert!(share >= 0.95, "{share}");
    assert!(matches!(symmetry.method, SymmetryMethod::Mirror(plane) if plane.normal[0] > 0.999));
}

/// In its own plane every harmonic would be symmetric, and the side signal would move nothing.
#[test]
fn a_flat_rectangle_has_antisymmetric_harmonics_however_it_stands() {
    for axis in 0..3 {
        let mut mesh = samples::grid_square(15);
        for p in &mut mesh.positions {
            let [x, y, _] = *p;
            *p = [0.0; 3];
            (p[(axis + 1) % 3], p[(axis + 2) % 3]) = (x, 0.7 * y);
        }
        let body = Body::build(&mesh, &BasisSettings::new(30), &Task::new()).unwrap();
        let symmetry = Symmetry::of(&body, &Task::new()).unwrap();
        let antisymmetric = symmetry.classes.iter().filter(|c| **c == Class::Antisymmetric).count();
        assert!((8..=22).contains(&antisymmetric), "{antisymmetric} of 30 by {:?}", symmetry.method);
    }
}

/// A square has two harmonics of its second eigenvalue. One of them alone is what a solver makes of them, and where it leans
/// between the mirror's own it is of neither class.
#[test]
fn a_harmonic_that_k_parts_from_its_eigenvalue_s_others_may_have_no_class() {
    let whole = Body::build(&samples::grid_square(8), &BasisSettings::new(3), &Task::new()).unwrap();
    let classes = Symmetry::of(&whole, &Task::new()).unwrap().classes;
    assert!(classes.contains(&Class::Symmetric) && classes.contains(&Class::Antisymmetric), "{classes:?}");
    assert!(!classes.contains(&Class::Undecided), "{classes:?}");

    let mut basis = (*whole.basis).clone();
    let (sin, cos) = 0.5_f64.sin_cos();
    let n = basis.vertices();
    for v in 0..n {
        basis.vectors[n + v] = cos * basis.vectors[n + v] + sin * basis.vectors[2 * n + v];
    }
    basis.eigenvalues.truncate(2);
    basis.vectors.truncate(2 * n);
    let parted = Body { basis: Arc::new(basis), ..whole };
    let symmetry = Symmetry::of(&parted, &Task::new()).unwrap();
    assert!(matches!(symmetry.method, SymmetryMethod::Mirror(_)));
    assert_eq!(symmetry.classes, [Class::Symmetric, Class::Undecided], "{:?}", symmetry.scores);
}

#[test]
fn scorpion_spot_and_face() {
    for name in ["shapes/scorpion_low_resolution.obj", "animals/spot.obj", "heads/face.obj"] {
        let Some(path) = chladni_testdata::shared(&format!("meshes/{name}")) else { return };
        let mesh = chladni_mesh::load_mesh(&path).unwrap().mesh;
        let body_center = Body::build(&mesh, &BasisSettings::new(2), &Task::new()).unwrap();
        let x: Vec<f64> = body_center.positions.iter().map(|p| p[0]).collect();
        let c =
            0.5 * (x.iter().copied().fold(f64::MAX, f64::min) + x.iter().copied().fold(f64::MIN, f64::max));
        let (share, count, _) = agreement(&mesh, c);
        println!("{name}: {share:.3} of {count}, center {c:.4}");
        assert!(share >= 0.95, "{name}: {share} of {count}");
    }
}
