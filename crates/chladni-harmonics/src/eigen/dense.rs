//! All eigenpairs of a small operator at once.

use chladni_task::Task;
use faer::{Mat, Side};

use super::{Solved, certify, fix_signs};
use crate::{Basis, HarmonicsError, Operator};

/// Solves M^-½ S M^-½ as a dense matrix: every pair is there, so nothing can be missed.
pub(crate) fn solve(operator: &Operator, harmonics: usize, task: &Task) -> Result<Solved, HarmonicsError> {
    let n = operator.vertices();
    let stage = task.stage("harmonics", 1);
    let scale: Vec<f64> = operator.mass.iter().map(|a| a.sqrt().recip()).collect();
    let mut symmetric = Mat::<f64>::zeros(n, n);
    for j in 0..n {
        for (i, value) in operator.stiffness.column(j) {
            symmetric[(i, j)] = value * scale[i] * scale[j];
        }
    }
    let eigen = symmetric
        .self_adjoint_eigen(Side::Lower)
        .map_err(|e| HarmonicsError::NotCertified { reason: format!("the dense solver failed: {e:?}") })?;
    let components = operator.components();
    let mut eigenvalues: Vec<f64> = (0..harmonics).map(|k| eigen.S()[k]).collect();
    eigenvalues.iter_mut().take(components).for_each(|l| *l = 0.0);
    let mut vectors = vec![0.0; n * harmonics];
    for k in 0..harmonics {
        for v in 0..n {
            vectors[k * n + v] = eigen.U()[(v, k)] * scale[v];
        }
    }
    fix_signs(&mut vectors, n);
    let certificate = certify(operator, &eigenvalues, &vectors, true);
    let cuts_cluster =
        harmonics < n && eigen.S()[harmonics] - eigen.S()[harmonics - 1] <= 1e-7 * eigen.S()[harmonics];
    stage.advance(1);
    Ok(Solved { basis: Basis { eigenvalues, vectors, mass: operator.mass.clone(), certificate }, cuts_cluster })
}
