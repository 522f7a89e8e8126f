//! All eigenpairs of a small operator at once.

use faer::{Mat, Par};

use super::{Solved, certify, cluster_end};
use crate::symmetric_eigen::symmetric_eigen;
use crate::{Basis, HarmonicsError, Pencil, SolveProfile};

/// Solves M^-½ S M^-½, of which `zeros` eigenvalues are 0, as a dense matrix: all pairs are computed, so none
/// can be missed.
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
        .ok_or_else(|| HarmonicsError::not_certified("the dense solver failed"))?;
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
