//! Dense products and least squares, which round alike on any number of threads: faer's own `qr` and `svd` divide their
//! sums among as many parts as there are threads.

use faer::diag::Diag;
use faer::dyn_stack::{MemBuffer, MemStack, StackReq};
use faer::linalg::householder::{
    apply_block_householder_sequence_transpose_on_the_left_in_place_scratch as apply_scratch,
    apply_block_householder_sequence_transpose_on_the_left_in_place_with_conj as apply_transposed,
};
use faer::linalg::matmul::matmul;
use faer::linalg::qr::no_pivoting::factor::{qr_in_place, qr_in_place_scratch, recommended_block_size};
use faer::linalg::svd::{ComputeSvdVectors, svd, svd_scratch};
use faer::linalg::triangular_solve::solve_upper_triangular_in_place;
use faer::{Accum, Conj, Mat, MatRef, Par, Spec};

use crate::platform::split;

/// A B.
pub(crate) fn product(a: MatRef<f64>, b: MatRef<f64>) -> Mat<f64> {
    let mut out = Mat::zeros(a.nrows(), b.ncols());
    matmul(out.as_mut(), Accum::Replace, a, b, 1.0, split());
    out
}

/// The X that minimizes ‖A X − B‖, and ‖X‖ where several do. A has at least as many rows as columns. `None` if singular
/// values were not found.
pub(crate) fn least_squares(a: MatRef<f64>, b: MatRef<f64>) -> Option<Mat<f64>> {
    let (n, k) = (a.nrows(), a.ncols());
    let (r, mut image) = triangular(a, b);
    let negligible = f64::EPSILON * n as f64;
    let largest = (0..k).map(|i| r[(i, i)].abs()).fold(0.0, f64::max);
    if (0..k).all(|i| r[(i, i)].abs() > negligible * largest) {
        solve_upper_triangular_in_place(r.as_ref(), image.as_mut(), split());
        return Some(image);
    }
    let (singular, u, v) = decomposed(r.as_ref())?;
    let cut = negligible * singular.iter().copied().fold(0.0, f64::max);
    let image = product(u.transpose(), image.as_ref());
    let shares =
        Mat::from_fn(
            k,
            image.ncols(),
            |i, j| {
                if singular[i] > cut { image[(i, j)] / singular[i] } else { 0.0 }
            },
        );
    Some(product(v.as_ref(), shares.as_ref()))
}

/// R and Qᵀ B for A = Q R.
fn triangular(a: MatRef<f64>, b: MatRef<f64>) -> (Mat<f64>, Mat<f64>) {
    let (n, k, par) = (a.nrows(), a.ncols(), split());
    let block = recommended_block_size::<f64>(n, k);
    let (mut qr, mut factors, mut image) = (a.to_owned(), Mat::zeros(block, k), b.to_owned());
    let mut memory = MemBuffer::new(StackReq::any_of(&[
        qr_in_place_scratch::<f64>(n, k, block, par, Spec::default()),
        apply_scratch::<f64>(n, block, b.ncols()),
    ]));
    qr_in_place(qr.as_mut(), factors.as_mut(), par, MemStack::new(&mut memory), Spec::default());
    let (q, stack) = (qr.as_ref(), MemStack::new(&mut memory));
    apply_transposed(q, factors.as_ref(), Conj::No, image.as_mut(), par, stack);
    let r = Mat::from_fn(k, k, |i, j| if i <= j { qr[(i, j)] } else { 0.0 });
    (r, image.get(..k, ..).to_owned())
}

/// Σ, U and V of a square matrix U Σ Vᵀ.
fn decomposed(matrix: MatRef<f64>) -> Option<(Vec<f64>, Mat<f64>, Mat<f64>)> {
    let (k, all) = (matrix.nrows(), ComputeSvdVectors::Full);
    let (mut values, mut u, mut v) = (Diag::<f64>::zeros(k), Mat::zeros(k, k), Mat::zeros(k, k));
    let mut memory = MemBuffer::new(svd_scratch::<f64>(k, k, all, all, Par::Seq, Spec::default()));
    let (stack, into) = (MemStack::new(&mut memory), (Some(u.as_mut()), Some(v.as_mut())));
    svd(matrix, values.as_mut(), into.0, into.1, Par::Seq, stack, Spec::default()).ok()?;
    Some((values.column_vector().iter().copied().collect(), u, v))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::threads::on_threads;

    /// Of 3000 × 30 values, faer's own `qr` gives other bits for each number of threads.
    #[test]
    fn threads_change_no_bit() {
        let mut chance = chladni_testdata::chance(7);
        let mut next = || (chance() >> 40) as f64 / (1 << 23) as f64 - 1.0;
        let a = Mat::from_fn(3000, 30, |_, _| next());
        let b = Mat::from_fn(3000, 20, |_, _| next());
        // Two columns that are equal need singular values.
        let dependent = Mat::from_fn(3000, 30, |i, j| a[(i, j.max(1))]);
        for a in [a, dependent] {
            let on = |threads: usize| {
                on_threads(Some(threads), || least_squares(a.as_ref(), b.as_ref())).unwrap().unwrap()
            };
            let one = on(1);
            let rest = &b - product(a.as_ref(), one.as_ref());
            let normal = product(a.transpose(), rest.as_ref());
            assert!(normal.norm_max() < 1e-9, "{}", normal.norm_max());
            for threads in [2, 5] {
                assert!(on(threads) == one, "{threads} threads");
            }
        }
    }
}
