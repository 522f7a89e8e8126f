//! Eigenpairs of dense symmetric matrices.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::evd::{
    ComputeEigenvectors, SelfAdjointEvdParams, self_adjoint_evd, self_adjoint_evd_scratch,
};
use faer::{Auto, Mat, Par, Spec};

/// Size below which faer's divide and conquer switches to QR iterations. Its default of 128 is a twentieth
/// slower on the Lanczos spaces, which are 200 to 350 wide.
const LEAF: usize = 64;

/// All eigenvalues, ascending, and eigenvectors of a symmetric matrix, of which only the lower triangle is
/// read.
pub(crate) fn symmetric_eigen(matrix: &Mat<f64>, par: Par) -> Option<(Vec<f64>, Mat<f64>)> {
    let n = matrix.nrows();
    // Faer 0.24 compares eigenvalues with a tolerance that assumes entries of size about 1. Scaling by a
    // power of two adds no rounding.
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
