//! All eigenpairs of a small operator at once.

use chladni_task::Task;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::evd::{ComputeEigenvectors, self_adjoint_evd, self_adjoint_evd_scratch};
use faer::{Mat, Par};

use super::slicing::CLUSTER;
use super::{Solved, certify, fix_sign};
use crate::{Basis, HarmonicsError, Operator, SolveProfile};

/// Solves M^-½ S M^-½ as a dense matrix: every pair is there, so nothing can be missed.
pub(super) fn solve(
    operator: &Operator,
    harmonics: usize,
    whole_clusters: bool,
    task: &Task,
) -> Result<Solved, HarmonicsError> {
    let n = operator.vertices();
    let stage = task.stage("harmonics", 1);
    let symmetric = symmetrized(operator);
    let par = Par::rayon(rayon::current_num_threads());
    let (values, coordinates) = symmetric_eigen(&symmetric, par)
        .ok_or_else(|| HarmonicsError::NotCertified { reason: "the dense solver failed".into() })?;
    let components = operator.components();
    let exact = |k: usize| if k < components { 0.0 } else { values[k] };
    let is_gap = |k: usize| k == n || exact(k) - exact(k - 1) > CLUSTER * exact(k);
    let cluster_end = (harmonics..=n).find(|&k| is_gap(k)).unwrap_or(n);
    let keep = if whole_clusters { cluster_end } else { harmonics };
    let eigenvalues: Vec<f64> = (0..keep).map(exact).collect();
    let mut vectors = vec![0.0; n * keep];
    for (k, h) in vectors.chunks_exact_mut(n).enumerate() {
        for v in 0..n {
            h[v] = coordinates[(v, k)] / operator.mass[v].sqrt();
        }
        fix_sign(h);
    }
    let certificate = certify(operator, &eigenvalues, &vectors, true);
    stage.advance(1);
    let basis = Basis { eigenvalues, vectors, mass: operator.mass.clone(), certificate };
    Ok(Solved {
        basis,
        cuts_cluster: keep < cluster_end,
        fell_back_to_dense: false,
        profile: SolveProfile::default(),
    })
}

/// M^-½ S M^-½.
pub(super) fn symmetrized(operator: &Operator) -> Mat<f64> {
    let n = operator.vertices();
    let scale: Vec<f64> = operator.mass.iter().map(|a| a.sqrt().recip()).collect();
    let mut matrix = Mat::<f64>::zeros(n, n);
    for j in 0..n {
        for (i, value) in operator.stiffness.column(j) {
            matrix[(i, j)] = value * scale[i] * scale[j];
        }
    }
    matrix
}

/// All eigenvalues, ascending, and eigenvectors of a symmetric matrix (its lower triangle).
pub(super) fn symmetric_eigen(matrix: &Mat<f64>, par: Par) -> Option<(Vec<f64>, Mat<f64>)> {
    let n = matrix.nrows();
    let mut values = faer::diag::Diag::<f64>::zeros(n);
    let mut vectors = Mat::<f64>::zeros(n, n);
    let scratch = self_adjoint_evd_scratch::<f64>(n, ComputeEigenvectors::Yes, par, Default::default());
    let mut buffer = MemBuffer::try_new(scratch).ok()?;
    let stack = MemStack::new(&mut buffer);
    let (s, u) = (values.as_mut(), Some(vectors.as_mut()));
    self_adjoint_evd(matrix.as_ref(), s, u, par, stack, Default::default()).ok()?;
    Some((values.column_vector().iter().copied().collect(), vectors))
}
