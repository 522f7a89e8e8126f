//! All eigenvalues of a small pencil, computed independently of the solver.

use chladni_harmonics::SymmetricSparse;
use faer::{Mat, Side};

/// Up to this many vertices Jacobi rotations are used, which are accurate even for the smallest
/// eigenvalues; beyond it, faer.
const JACOBI: usize = 80;

/// The eigenvalues of M^-½ S M^-½, ascending.
pub fn spectrum(stiffness: &SymmetricSparse, mass: &[f64]) -> Vec<f64> {
    let n = mass.len();
    let mut a = vec![0.0; n * n];
    for j in 0..n {
        for (i, value) in stiffness.column(j) {
            a[j * n + i] = value / (mass[i].sqrt() * mass[j].sqrt());
        }
    }
    if n <= JACOBI {
        return jacobi(a, n);
    }
    let largest = a.iter().fold(0.0_f64, |m, x| m.max(x.abs())).max(f64::MIN_POSITIVE);
    let matrix = Mat::from_fn(n, n, |i, j| a[j * n + i] / largest);
    let values = matrix.self_adjoint_eigenvalues(Side::Lower).unwrap();
    values.into_iter().map(|value| value * largest).collect()
}

/// Cyclic Jacobi (Golub & Van Loan, 8.5) on the n×n matrix `a`.
fn jacobi(mut a: Vec<f64>, n: usize) -> Vec<f64> {
    for _ in 0..40 {
        let mut turned = false;
        for p in 0..n {
            for q in p + 1..n {
                let (app, aqq, apq) = (a[p * n + p], a[q * n + q], a[p * n + q]);
                if apq.abs() <= f64::EPSILON * 0.1 * (app.abs() * aqq.abs()).sqrt() {
                    continue;
                }
                turned = true;
                let tau = (aqq - app) / (2.0 * apq);
                let t = tau.signum() / (tau.abs() + tau.hypot(1.0));
                let c = t.hypot(1.0).recip();
                let s = t * c;
                for k in 0..n {
                    let (x, y) = (a[k * n + p], a[k * n + q]);
                    (a[k * n + p], a[k * n + q]) = (c * x - s * y, s * x + c * y);
                }
                for k in 0..n {
                    let (x, y) = (a[p * n + k], a[q * n + k]);
                    (a[p * n + k], a[q * n + k]) = (c * x - s * y, s * x + c * y);
                }
            }
        }
        if !turned {
            break;
        }
    }
    let mut values: Vec<f64> = (0..n).map(|i| a[i * n + i]).collect();
    values.sort_by(f64::total_cmp);
    values
}
