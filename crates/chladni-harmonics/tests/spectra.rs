//! Compares eigenvalues with closed forms.

#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

mod shapes;

use chladni_harmonics::{BasisSettings, Body};
use chladni_mesh::TriMesh;
use chladni_task::Task;

fn build(mesh: &TriMesh, k: usize) -> Body {
    Body::build(mesh, &BasisSettings::new(k), &Task::new()).unwrap()
}

fn check(body: &Body) {
    let c = &body.basis.certificate;
    assert!(
        c.inertia_counts_match == Some(true)
            && c.max_relative_residual < 1e-9
            && c.max_orthogonality_error < 1e-8,
        "{c:?}"
    );
}

#[test]
fn the_unit_sphere_has_l_times_l_plus_1_with_multiplicity_2l_plus_1() {
    let body = build(&shapes::icosphere(4), 49);
    check(&body);
    let scale2 = body.frame.scale.powi(2);
    let mut k = 0;
    for l in 0..7 {
        for _ in 0..2 * l + 1 {
            let exact = f64::from(l * (l + 1));
            let lambda = body.basis.eigenvalues[k] * scale2;
            // The mesh has 2,562 vertices: the error is of the order of λ h², h ≈ 0.07.
            assert!(
                (lambda - exact).abs() <= 0.004 * exact * f64::from(l + 1),
                "l {l}: {lambda} for {exact}"
            );
            k += 1;
        }
    }
}

#[test]
fn a_finer_sphere_has_them_as_well() {
    // Large enough for orthogonalization against selected Ritz vectors; the eigenvalue λ = 11 · 12 has more
    // vectors than a block has columns.
    let body = build(&shapes::icosphere(5), 144);
    check(&body);
    let scale2 = body.frame.scale.powi(2);
    for (k, lambda) in body.basis.eigenvalues.iter().enumerate() {
        let l = (k as f64).sqrt().floor();
        let exact = l * (l + 1.0);
        assert!((lambda * scale2 - exact).abs() <= 0.0015 * exact * (l + 1.0), "{k}: {lambda} for {exact}");
    }
}

#[test]
fn the_unit_square_has_pi_squared_times_sums_of_squares() {
    let body = build(&shapes::square(40), 9);
    check(&body);
    let scale2 = body.frame.scale.powi(2);
    let exact = [0.0, 1.0, 1.0, 2.0, 4.0, 4.0, 5.0, 5.0, 8.0].map(|s| s * std::f64::consts::PI.powi(2));
    for (lambda, exact) in body.basis.eigenvalues.iter().zip(exact) {
        assert!((lambda * scale2 - exact).abs() <= 0.005 * exact, "{} for {exact}", lambda * scale2);
    }
}
