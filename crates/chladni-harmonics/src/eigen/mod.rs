//! The K smallest eigenpairs of S h = λ M h.

mod assemble;
mod certify;
mod dense;
mod join;
mod krylov;
mod lanczos;
mod plan;
mod polish;
mod problem;
mod slicing;
mod tall;

use chladni_task::Task;

use crate::{Basis, Certificate, HarmonicsError, Operator, SolveProfile};

/// Up to this many vertices a dense solve is quicker than slices.
const DENSE: usize = 300;
/// Up to this many a dense solve is the way where a large share of all pairs is asked for.
const DENSE_SHARE: usize = 4000;

/// Eigenpairs and what must be said about them.
pub(crate) struct Solved {
    pub basis: Basis,
    pub cuts_cluster: bool,
    /// Slices could not be certified, so everything was solved as a dense matrix.
    pub fell_back_to_dense: bool,
    pub profile: SolveProfile,
}

/// Solves for the first `harmonics` pairs of `operator`.
pub(crate) fn solve(
    operator: &Operator,
    harmonics: usize,
    whole_clusters: bool,
    task: &Task,
) -> Result<Solved, HarmonicsError> {
    let n = operator.vertices();
    if harmonics == 0 || harmonics > n {
        return Err(HarmonicsError::BadHarmonicCount { harmonics, vertices: n });
    }
    task.check()?;
    if n <= DENSE || (n <= DENSE_SHARE && harmonics * 3 > n) || harmonics * 2 > n {
        dense::solve(operator, harmonics, whole_clusters, task)
    } else {
        match slicing::solve(operator, harmonics, whole_clusters, task) {
            // Spectra of a few eigenvalues of huge multiplicity leave Krylov spaces without
            // directions; the last mend, where it is affordable, is to solve for everything.
            Err(HarmonicsError::NotCertified { .. }) if n <= DENSE_SHARE => {
                let solved = dense::solve(operator, harmonics, whole_clusters, task)?;
                Ok(Solved { fell_back_to_dense: true, ..solved })
            }
            solved => solved,
        }
    }
}

/// Measures pairs against the operator.
fn certify(operator: &Operator, eigenvalues: &[f64], vectors: &[f64], inertia: bool) -> Certificate {
    use faer::MatRef;
    let (n, k) = (operator.vertices(), eigenvalues.len());
    let mut residual = 0.0_f64;
    for (j, &lambda) in eigenvalues.iter().enumerate().skip(operator.components()) {
        let h = &vectors[j * n..(j + 1) * n];
        let s = operator.stiffness.times(h);
        let norm = s.iter().map(|x| x * x).sum::<f64>().sqrt();
        let error: f64 = (0..n).map(|v| (s[v] - lambda * operator.mass[v] * h[v]).powi(2)).sum();
        residual = residual.max(error.sqrt() / norm);
    }
    let h = MatRef::from_column_major_slice(vectors, n, k);
    let weighted = faer::Mat::from_fn(n, k, |v, j| operator.mass[v] * h[(v, j)]);
    let gram = h.transpose() * &weighted;
    let mut orthogonality = 0.0_f64;
    for j in 0..k {
        for i in 0..k {
            orthogonality = orthogonality.max((gram[(i, j)] - f64::from(u8::from(i == j))).abs());
        }
    }
    Certificate {
        inertia_counts_match: inertia,
        max_relative_residual: residual,
        max_orthogonality_error: orthogonality,
    }
}

/// The sign rule: the entry of largest magnitude is positive; of several that agree to 1e-6,
/// the first.
fn fix_sign(h: &mut [f64]) {
    let mut largest = 0.0_f64;
    for part in h.chunks(256) {
        // Whether there is anything larger, eight at a time, before looking where.
        let mut sizes = [0.0_f64; 8];
        for eight in part.chunks(8) {
            for (size, x) in sizes.iter_mut().zip(eight) {
                *size = if x.abs() > *size { x.abs() } else { *size };
            }
        }
        let bound = |largest: f64| largest.abs() * (1.0 + 1e-6);
        if sizes.iter().any(|size| *size > bound(largest)) {
            for &x in part {
                if x.abs() > bound(largest) {
                    largest = x;
                }
            }
        }
    }
    if largest < 0.0 {
        h.iter_mut().for_each(|x| *x = -*x);
    }
}
