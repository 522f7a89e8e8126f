//! All eigenpairs of a small operator at once.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::evd::{
    ComputeEigenvectors, SelfAdjointEvdParams, self_adjoint_evd, self_adjoint_evd_scratch,
};
use faer::{Auto, Mat, Par, Spec};

use super::problem::Pencil;
use super::{Solved, certify, cluster_end};
use crate::{Basis, HarmonicsError, SolveProfile};

/// Parts that faer's divide and conquer leaves to QR iterations; its own 128 makes the spaces of
/// Lanczos, 200 to 350 wide, a twentieth slower.
const LEAF: usize = 64;

/// Solves M^-½ S M^-½ as a dense matrix, of which `zeros` eigenvalues are 0: every pair is there,
/// so nothing can be missed.
pub(super) fn solve(
    pencil: Pencil,
    zeros: usize,
    harmonics: usize,
    whole_clusters: bool,
) -> Result<Solved, HarmonicsError> {
    let n = pencil.mass.len();
    let symmetric = symmetrized(pencil);
    let par = Par::rayon(rayon::current_num_threads());
    let (mut eigenvalues, coordinates) = symmetric_eigen(&symmetric, par)
        .ok_or_else(|| HarmonicsError::NotCertified { reason: "the dense solver failed".into() })?;
    eigenvalues[..zeros].fill(0.0);
    let cluster_end = cluster_end(&eigenvalues, harmonics);
    let keep = if whole_clusters { cluster_end } else { harmonics };
    eigenvalues.truncate(keep);
    let mut vectors = vec![0.0; n * keep];
    for (k, h) in vectors.chunks_exact_mut(n).enumerate() {
        for v in 0..n {
            h[v] = coordinates[(v, k)] / pencil.mass[v].sqrt();
        }
    }
    let certificate = certify(pencil, zeros, &eigenvalues, &vectors, true);
    let basis = Basis { eigenvalues, vectors, mass: pencil.mass.to_vec(), certificate };
    Ok(Solved {
        basis,
        cuts_cluster: keep < cluster_end,
        fell_back_to_dense: false,
        profile: SolveProfile::default(),
    })
}

/// M^-½ S M^-½.
pub(super) fn symmetrized(pencil: Pencil) -> Mat<f64> {
    let n = pencil.mass.len();
    let scale: Vec<f64> = pencil.mass.iter().map(|a| a.sqrt().recip()).collect();
    let mut matrix = Mat::<f64>::zeros(n, n);
    for j in 0..n {
        for (i, value) in pencil.stiffness.column(j) {
            matrix[(i, j)] = value * scale[i] * scale[j];
        }
    }
    matrix
}

/// All eigenvalues, ascending, and eigenvectors of a symmetric matrix (its lower triangle).
pub(crate) fn symmetric_eigen(matrix: &Mat<f64>, par: Par) -> Option<(Vec<f64>, Mat<f64>)> {
    let n = matrix.nrows();
    // Faer 0.24 takes eigenvalues for equal by a measure in which 1 is the size of the matrix. A
    // power of two rounds nothing.
    let largest = (0..n).flat_map(|j| (j..n).map(move |i| matrix[(i, j)].abs())).fold(0.0, f64::max);
    let unit = if largest.is_normal() { largest.log2().floor().exp2() } else { 1.0 };
    let matrix = faer::Scale(unit.recip()) * matrix;
    let mut values = faer::diag::Diag::<f64>::zeros(n);
    let mut vectors = Mat::<f64>::zeros(n, n);
    let auto = <SelfAdjointEvdParams as Auto<f64>>::auto();
    let params = Spec::new(SelfAdjointEvdParams { recursion_threshold: LEAF, ..auto });
    let scratch = self_adjoint_evd_scratch::<f64>(n, ComputeEigenvectors::Yes, par, params);
    let mut buffer = MemBuffer::try_new(scratch).ok()?;
    let stack = MemStack::new(&mut buffer);
    let (s, u) = (values.as_mut(), Some(vectors.as_mut()));
    self_adjoint_evd(matrix.as_ref(), s, u, par, stack, params).ok()?;
    Some((values.column_vector().iter().map(|value| value * unit).collect(), vectors))
}
