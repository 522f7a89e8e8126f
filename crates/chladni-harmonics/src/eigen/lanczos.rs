//! Block Lanczos on (A + σI)⁻¹ with full reorthogonalisation, one shift for all pairs.

use chladni_task::Task;
use faer::linalg::solvers::Solve;
use faer::sparse::{SparseColMat, Triplet};
use faer::{Mat, Side};

use super::{Solved, certify, fix_signs};
use crate::{Basis, HarmonicsError, Operator};

const BLOCK: usize = 16;

/// Grows an orthonormal basis V of the Krylov space and takes Ritz pairs of V^T OP V.
pub(crate) fn solve(operator: &Operator, harmonics: usize, task: &Task) -> Result<Solved, HarmonicsError> {
    let n = operator.vertices();
    let stage = task.stage("harmonics", 0);
    let failed = |reason: String| HarmonicsError::NotCertified { reason };
    let scale: Vec<f64> = operator.mass.iter().map(|a| a.sqrt().recip()).collect();
    let shift = 4.0 / operator.mass.iter().sum::<f64>();
    let mut triplets = Vec::new();
    for j in 0..n {
        for (i, value) in operator.stiffness.column(j) {
            let a = value * scale[i] * scale[j];
            triplets.push(Triplet::new(i, j, if i == j { a + shift } else { a }));
        }
    }
    let matrix = SparseColMat::<usize, f64>::try_new_from_triplets(n, n, &triplets)
        .map_err(|e| failed(format!("{e:?}")))?;
    let factor = matrix.sp_cholesky(Side::Lower).map_err(|e| failed(format!("{e:?}")))?;
    let mut seed = 0x2545_f491_4f6c_dd1d_u64;
    let mut random = || {
        seed ^= seed << 13;
        seed ^= seed >> 7;
        seed ^= seed << 17;
        (seed >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    };
    let mut basis = Mat::<f64>::zeros(n, 0);
    let mut image = Mat::<f64>::zeros(n, 0);
    let mut next = Mat::from_fn(n, BLOCK, |_, _| random());
    loop {
        task.check()?;
        for _ in 0..2 {
            let overlap = basis.transpose() * &next;
            next -= &basis * overlap;
            next = next.qr().compute_thin_Q();
        }
        let solved = factor.solve(&next);
        let m = basis.ncols();
        basis = Mat::from_fn(n, m + BLOCK, |i, j| if j < m { basis[(i, j)] } else { next[(i, j - m)] });
        image = Mat::from_fn(n, m + BLOCK, |i, j| if j < m { image[(i, j)] } else { solved[(i, j - m)] });
        next = solved;
        stage.advance(1);
        let m = m + BLOCK;
        if m < (harmonics * 3 / 2 + 48).min(n - BLOCK) || (m / BLOCK) % 4 != 0 && m + BLOCK <= n {
            continue;
        }
        let projected = basis.transpose() * &image;
        let ritz = projected.self_adjoint_eigen(Side::Lower).map_err(|e| failed(format!("{e:?}")))?;
        // Largest θ first: λ = 1/θ − σ ascending.
        let coordinates = Mat::from_fn(m, harmonics, |i, k| ritz.U()[(i, m - 1 - k)]);
        let vectors = &image * &coordinates;
        let mut eigenvalues: Vec<f64> = (0..harmonics).map(|k| 1.0 / ritz.S()[m - 1 - k] - shift).collect();
        eigenvalues.iter_mut().take(operator.components()).for_each(|l| *l = 0.0);
        let mut flat = vec![0.0; n * harmonics];
        for k in 0..harmonics {
            let norm = (0..n).map(|v| vectors[(v, k)].powi(2)).sum::<f64>().sqrt();
            for v in 0..n {
                flat[k * n + v] = vectors[(v, k)] * scale[v] / norm;
            }
        }
        fix_signs(&mut flat, n);
        let certificate = certify(operator, &eigenvalues, &flat, true);
        if certificate.max_relative_residual < 1e-9 && certificate.max_orthogonality_error < 1e-8 {
            let mass = operator.mass.clone();
            return Ok(Solved {
                basis: Basis { eigenvalues, vectors: flat, mass, certificate },
                cuts_cluster: false,
            });
        }
        if m + BLOCK > n {
            return Err(failed("the Krylov space is exhausted".into()));
        }
    }
}
