//! Chooses among equally good harmonics by geometry: the result then does not depend on rounding, and hence
//! not on the processor or the number of threads.
//!
//! The sign of an eigenvector is arbitrary, and eigenvectors of one eigenvalue may be rotated among each
//! other. The rotation chosen is the one that diagonalizes a fixed function of position; the sign chosen is
//! positive at the outermost of a harmonic's peaks along a fixed direction.

use chladni_task::{Cancelled, Task};
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatRef, Par};
use rayon::prelude::*;

use crate::basis::larger;
use crate::platform::split;
use crate::symmetric_eigen::symmetric_eigen;
use crate::{Basis, HarmonicsError, SymmetricSparse};

/// Eigenvalues that agree to this relative tolerance cannot be distinguished; rotating their vectors adds at
/// most as much to the relative residual.
const EQUAL: f64 = 3e-10;
/// Values of at least this share of the largest magnitude count as peaks.
const PEAK: f64 = 0.9;
/// The direction in which peaks are compared. It is mostly along x, which makes a harmonic that is odd
/// between left and right positive on a fixed side. No mirror plane of a box, an octahedron or a
/// dodecahedron contains it.
const OUTWARD: [f64; 3] = [1.0, 0.347, 0.171];
/// A group may be large: at most this many of its values are copied to be weighted, and this many rows to be rotated.
const WEIGHTED: usize = 1 << 20;
const ROWS: usize = 4096;

/// Makes every sign and every choice within equal eigenvalues canonical.
///
/// # Errors
/// A cancelled task.
pub(crate) fn choose(
    basis: &mut Basis,
    positions: &[[f64; 3]],
    stiffness: &SymmetricSparse,
    task: &Task,
) -> Result<(), HarmonicsError> {
    let n = basis.vertices();
    if n == 0 {
        return Ok(());
    }
    let clusters = clusters(&basis.eigenvalues);
    for cluster in clusters {
        let size = cluster.len();
        let columns = &mut basis.vectors[cluster.start * n..cluster.end * n];
        let Some(mix) = mix_within(columns, &basis.mass, positions, task)? else { continue };
        rotate(columns, &mix, n, task)?;
        let mean = basis.eigenvalues[cluster.clone()].iter().sum::<f64>() / size as f64;
        basis.eigenvalues[cluster].fill(mean);
        let worst = columns
            .par_chunks_exact(n)
            .map(|h| relative_residual(stiffness, &basis.mass, mean, h))
            .reduce(|| 0.0, larger);
        let certified = &mut basis.certificate.max_relative_residual;
        *certified = larger(*certified, worst);
    }
    let heights: Vec<f64> = positions.iter().map(height).collect();
    basis.vectors.par_chunks_exact_mut(n).for_each(|h| {
        if points_inward(h, &heights) {
            h.iter_mut().for_each(|x| *x = -*x);
        }
    });
    Ok(())
}

/// Chooses signs that make each harmonic positive where its magnitude is largest, which is all that can be
/// done without geometry.
pub(crate) fn orient(basis: &mut Basis) {
    let n = basis.vertices().max(1);
    basis.vectors.par_chunks_exact_mut(n).for_each(|h| {
        let largest = h.iter().fold(0.0_f64, |m, x| if x.abs() > m.abs() { *x } else { m });
        if largest < 0.0 {
            h.iter_mut().for_each(|x| *x = -*x);
        }
    });
}

/// The rotation, column by column, that makes the orthonormal `columns` (N values each) of one eigenvalue
/// canonical; `None` if it cannot be computed, as without any vertex.
///
/// For the same space it gives the same rotated columns up to sign, whatever basis of the space `columns`
/// is.
///
/// # Panics
/// If `columns` is not a whole number of columns of N values.
pub fn mix(columns: &[f64], mass: &[f64], positions: &[[f64; 3]]) -> Option<Mat<f64>> {
    if mass.is_empty() || positions.is_empty() {
        return None;
    }
    mix_within(columns, mass, positions, &Task::new()).ok().flatten()
}

fn mix_within(
    columns: &[f64],
    mass: &[f64],
    positions: &[[f64; 3]],
    task: &Task,
) -> Result<Option<Mat<f64>>, Cancelled> {
    let weights: Vec<f64> = positions.iter().zip(mass).map(|(p, a)| a * landscape(*p)).collect();
    let projected = projected(columns, &weights, task)?;
    let size = projected.ncols();
    let symmetric = Mat::from_fn(size, size, |i, j| 0.5 * (projected[(i, j)] + projected[(j, i)]));
    Ok(symmetric_eigen(&symmetric, Par::Seq).map(|(_, mix)| mix))
}

/// Hᵀ diag(w) H for `columns` H, which have as many values as there are weights w.
fn projected(columns: &[f64], weights: &[f64], task: &Task) -> Result<Mat<f64>, Cancelled> {
    let n = weights.len();
    let size = columns.len() / n;
    let h = MatRef::from_column_major_slice(columns, n, size);
    let mut sum = Mat::<f64>::zeros(size, size);
    let rows = (WEIGHTED / size.max(1)).max(1);
    for first in (0..n).step_by(rows) {
        task.check()?;
        let part = h.subrows(first, rows.min(n - first));
        let weighted = Mat::from_fn(part.nrows(), size, |v, j| weights[first + v] * part[(v, j)]);
        matmul(sum.as_mut(), Accum::Add, part.transpose(), weighted.as_ref(), 1.0, split());
    }
    Ok(sum)
}

/// Whether the sign rule flips the harmonic `h`.
pub fn is_turned(h: &[f64], positions: &[[f64; 3]]) -> bool {
    points_inward(h, &positions.iter().map(height).collect::<Vec<f64>>())
}

/// The coordinate of a point along the outward direction.
fn height(p: &[f64; 3]) -> f64 {
    (0..3).map(|i| OUTWARD[i] * p[i]).sum()
}

/// Whether the value is negative at the outermost of the vertices where the magnitude is close to its
/// maximum.
fn points_inward(h: &[f64], heights: &[f64]) -> bool {
    let threshold = PEAK * h.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
    let mut outermost = (f64::NEG_INFINITY, 0.0);
    for (x, height) in h.iter().zip(heights) {
        if x.abs() >= threshold && *height > outermost.0 {
            outermost = (*height, *x);
        }
    }
    outermost.1 < 0.0
}

/// A function of position with few symmetries. Squares along the axes dominate, which aligns the lowest
/// harmonics of round shapes with the axes; small waves in unrelated directions break the remaining ties.
fn landscape(p: [f64; 3]) -> f64 {
    let [x, y, z] = p;
    let squares = x * x + 0.41 * y * y - 0.23 * z * z;
    let waves = (1.3 * x + 0.7 * y - 0.9 * z + 0.4).sin()
        + (2.9 * x - 2.3 * y + 1.7 * z + 1.1).sin()
        + (6.1 * x + 5.3 * y + 7.7 * z + 2.3).sin();
    squares + 1e-3 * waves
}

/// Ranges of at least two equal eigenvalues, except λ = 0: each component keeps its own constant.
fn clusters(eigenvalues: &[f64]) -> Vec<std::ops::Range<usize>> {
    let zeros = eigenvalues.iter().take_while(|value| **value <= 0.0).count();
    let mut clusters = Vec::new();
    let mut first = zeros;
    for k in zeros + 1..=eigenvalues.len() {
        if k == eigenvalues.len() || eigenvalues[k] - eigenvalues[first] > EQUAL * eigenvalues[k] {
            if k - first > 1 {
                clusters.push(first..k);
            }
            first = k;
        }
    }
    clusters
}

/// columns ← columns · mix, in place.
fn rotate(columns: &mut [f64], mix: &Mat<f64>, n: usize, task: &Task) -> Result<(), Cancelled> {
    let mut old = Vec::new();
    for first in (0..n).step_by(ROWS) {
        task.check()?;
        let rows = first..n.min(first + ROWS);
        old.clear();
        columns.chunks_exact(n).for_each(|h| old.extend_from_slice(&h[rows.clone()]));
        let old = &old;
        columns.par_chunks_exact_mut(n).enumerate().for_each(|(j, h)| {
            let new = &mut h[rows.clone()];
            // As sums begin: −0 + x is x, whatever its sign.
            new.fill(-0.0);
            for (i, old) in old.chunks_exact(rows.len()).enumerate() {
                let share = mix[(i, j)];
                new.iter_mut().zip(old).for_each(|(new, old)| *new += share * old);
            }
        });
    }
    Ok(())
}

/// ‖S h − λ M h‖ / ‖S h‖.
fn relative_residual(stiffness: &SymmetricSparse, mass: &[f64], lambda: f64, h: &[f64]) -> f64 {
    let image = stiffness.times(h);
    let error: f64 = (0..h.len()).map(|v| (image[v] - lambda * mass[v] * h[v]).powi(2)).sum();
    (error / image.iter().map(|x| x * x).sum::<f64>()).sqrt()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::Certificate;

    /// A ring of points with the cosines and sines of two waves: two eigenvalues, each double.
    fn ring(turns: [f64; 2], signs: [bool; 4]) -> (Basis, Vec<[f64; 3]>, SymmetricSparse) {
        let n = 40;
        let angle = |v: usize| std::f64::consts::TAU * v as f64 / n as f64;
        let positions: Vec<[f64; 3]> = (0..n).map(|v| [angle(v).cos(), angle(v).sin(), 0.0]).collect();
        let scale = (2.0 / n as f64).sqrt();
        let mut vectors = Vec::new();
        for (wave, turn) in turns.into_iter().enumerate() {
            for (part, quarter) in [0.0, std::f64::consts::FRAC_PI_2].into_iter().enumerate() {
                let sign = if signs[2 * wave + part] { 1.0 } else { -1.0 };
                let phase = turn + quarter;
                let h = move |v: usize| sign * scale * ((wave + 1) as f64 * angle(v) + phase).cos();
                vectors.extend((0..n).map(h));
            }
        }
        let value = |wave: usize| 2.0 - 2.0 * (std::f64::consts::TAU * (wave + 1) as f64 / n as f64).cos();
        let eigenvalues = vec![value(0), value(0) * (1.0 + 1e-12), value(1), value(1)];
        let edges: Vec<(u32, u32, f64)> = (0..n as u32).map(|v| (v, (v + 1) % n as u32, 1.0)).collect();
        let stiffness = SymmetricSparse::laplacian(n, &edges);
        let certificate = Certificate {
            laplacian: crate::Laplacian::Delaunay,
            inertia_counts_match: Some(true),
            max_relative_residual: 0.0,
            max_orthogonality_error: 0.0,
        };
        (
            Basis { eigenvalues, vectors: vectors.into(), mass: vec![1.0; n], certificate },
            positions,
            stiffness,
        )
    }

    #[test]
    fn parts_of_a_group_sum_and_rotate_like_the_whole() {
        let (n, size) = (WEIGHTED / 3 + 5, 3);
        let columns: Vec<f64> = (0..n * size).map(|at| (0.37 * at as f64).sin()).collect();
        let weights: Vec<f64> = (0..n).map(|v| (0.11 * v as f64).cos()).collect();
        let task = Task::new();
        let sums = projected(&columns, &weights, &task).unwrap();
        let column = |j: usize| &columns[j * n..(j + 1) * n];
        let mix = Mat::from_fn(size, size, |i, j| (i + 2 * j) as f64 - 1.5);
        let mut rotated = columns.clone();
        rotate(&mut rotated, &mix, n, &task).unwrap();
        for j in 0..size {
            for i in 0..size {
                let exact: f64 = (0..n).map(|v| weights[v] * column(i)[v] * column(j)[v]).sum();
                assert!((sums[(i, j)] - exact).abs() < 1e-6, "{} for {exact}", sums[(i, j)]);
            }
            for v in 0..n {
                let exact: f64 = (0..size).map(|i| column(i)[v] * mix[(i, j)]).sum();
                assert_eq!(rotated[j * n + v].to_bits(), exact.to_bits());
            }
        }
    }

    #[test]
    fn the_choice_can_be_cancelled() {
        let (mut basis, positions, stiffness) = ring([0.0, 0.0], [true; 4]);
        let task = Task::new();
        task.cancel();
        let result = choose(&mut basis, &positions, &stiffness, &task);
        assert_eq!(result, Err(HarmonicsError::Cancelled(Cancelled)));
    }

    #[test]
    fn without_vertices_there_is_no_choice() {
        assert!(mix(&[], &[], &[]).is_none());
    }

    proptest! {
        #[test]
        fn neither_rotation_nor_sign_of_what_comes_in_matters(
            turns in [0.0..6.3, 0.0..6.3],
            signs in any::<[bool; 4]>(),
        ) {
            let (mut basis, positions, stiffness) = ring(turns, signs);
            choose(&mut basis, &positions, &stiffness, &Task::new()).unwrap();
            let (mut reference, ..) = ring([0.0, 0.0], [true; 4]);
            choose(&mut reference, &positions, &stiffness, &Task::new()).unwrap();
            for (a, b) in basis.vectors.iter().zip(&reference.vectors) {
                prop_assert!((a - b).abs() < 1e-9);
            }
            prop_assert!(basis.certificate.max_relative_residual < 1e-11);
        }
    }
}
