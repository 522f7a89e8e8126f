//! A mass matrix that is not diagonal, as the inner product of a problem.

use super::tall::row_times;
use crate::ldlt::{Factor, Row, Symbolic, Workspace};
use crate::simd::{Kernel, Lanes, dispatch};
use crate::{HarmonicsError, SymmetricSparse};

/// The number of steps of inverse iteration that estimate the smallest eigenvalue of B, and the factor by
/// which the estimate may be wrong.
const STEPS: usize = 20;
const MARGIN: f64 = 2.0;
/// Nothing is certified under a metric whose smallest eigenvalue is below this share of its largest.
const FLATTEST: f64 = 1e-10;

/// B = G Gᵀ with a unit diagonal, in the order of the problem's symbolic factorization.
pub(super) struct Metric {
    /// B, with entries stored at the places of A.
    pub matrix: SymmetricSparse,
    factor: Factor,
    /// At least about 1 / (the smallest eigenvalue of B): the eigenvalues of A h = λ B h are at most this
    /// factor farther from 0 than those of A.
    pub stretch: f64,
}

impl Metric {
    pub fn of(matrix: SymmetricSparse, symbolic: &Symbolic) -> Result<Self, HarmonicsError> {
        let mut factor = Factor::default();
        let factored = factor.compute(symbolic, &matrix, 0.0, &mut Workspace::default());
        if factored.is_err() || factor.below_shift > 0 {
            return Err(HarmonicsError::bad_pencil("M is not positive definite"));
        }
        let stretch = MARGIN * largest_inverse(&factor, symbolic);
        if stretch.is_nan() || stretch * FLATTEST > 1.0 {
            return Err(HarmonicsError::bad_pencil(
                "M is so nearly singular that nothing could be certified",
            ));
        }
        Ok(Self { matrix, factor, stretch })
    }

    /// x ← Gᵀ (A − σB)⁻¹ G x, where G = B G⁻ᵀ and Gᵀ = G⁻¹ B.
    pub fn solve(&self, symbolic: &Symbolic, shifted: &Factor, x: &mut [Row]) {
        self.factor.solve_transposed_half(symbolic, x);
        let mut image = vec![[0.0; 8]; x.len()];
        dispatch(Times { matrix: &self.matrix, x, image: &mut image });
        shifted.solve(symbolic, &mut image);
        dispatch(Times { matrix: &self.matrix, x: &image, image: x });
        self.factor.solve_half(symbolic, x);
    }

    /// See [`Problem::residuals`](super::problem::Problem::residuals).
    pub fn residuals(
        &self,
        symbolic: &Symbolic,
        matrix: &SymmetricSparse,
        x: &[Row],
        values: &Row,
        weight: &[f64],
    ) -> [Row; 3] {
        let mut h = x.to_vec();
        self.untransform(symbolic, &mut h);
        let (mut image, mut rest) = (vec![[0.0; 8]; h.len()], vec![[0.0; 8]; h.len()]);
        dispatch(Times { matrix, x: &h, image: &mut image });
        dispatch(Times { matrix: &self.matrix, x: &h, image: &mut rest });
        let mut sums = [[0.0; 8]; 3];
        for ((rest, image), w) in rest.iter_mut().zip(&image).zip(weight) {
            for j in 0..8 {
                rest[j] = image[j] - values[j] * rest[j];
                sums[1][j] += w * rest[j] * rest[j];
                sums[2][j] += w * image[j] * image[j];
            }
        }
        self.factor.solve_half(symbolic, &mut rest);
        for row in &rest {
            for j in 0..8 {
                sums[0][j] += row[j] * row[j];
            }
        }
        sums
    }

    /// x ← G⁻ᵀ x.
    pub fn untransform(&self, symbolic: &Symbolic, x: &mut [Row]) {
        self.factor.solve_transposed_half(symbolic, x);
    }
}

/// A lower bound of the largest eigenvalue of the inverse of the factored matrix.
fn largest_inverse(factor: &Factor, symbolic: &Symbolic) -> f64 {
    let n = symbolic.size();
    // A rough vector, which has a component along every eigenvector.
    let mut x: Vec<f64> = (0..n).map(|i| ((i * 2_654_435_761) % 1009) as f64 / 504.0 - 1.0).collect();
    let mut size = 0.0;
    for _ in 0..STEPS {
        let length = x.iter().map(|x| x * x).sum::<f64>().sqrt();
        x.iter_mut().for_each(|x| *x /= length);
        factor.solve_one(symbolic, &mut x);
        size = x.iter().map(|x| x * x).sum::<f64>().sqrt();
    }
    size
}

/// The image of `x` under a matrix.
struct Times<'a> {
    matrix: &'a SymmetricSparse,
    x: &'a [Row],
    image: &'a mut [Row],
}

impl Kernel for Times<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) {
        let Self { matrix, x, image } = self;
        for (i, image) in image.iter_mut().enumerate() {
            lanes.store(row_times(lanes, matrix, i, x), image);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simd::{alike, run_for};

    #[test]
    fn images_are_right_on_every_kind_of_processor() {
        let edges: Vec<(u32, u32, f64)> =
            (0..40).map(|v| (v, (7 * v + 6) % 41, 1.0 + f64::from(v % 3))).collect();
        let matrix = SymmetricSparse::laplacian(41, &edges);
        let x: Vec<Row> =
            (0..41).map(|i| std::array::from_fn(|j| ((i * 31 + j * 17) % 101) as f64)).collect();
        let image = alike(|processor| {
            let mut image = vec![[0.0; 8]; 41];
            run_for(processor, Times { matrix: &matrix, x: &x, image: &mut image })?;
            Some(image)
        });
        for j in 0..8 {
            let exact = matrix.times(&x.iter().map(|row| row[j]).collect::<Vec<f64>>());
            for (image, exact) in image.iter().zip(exact) {
                assert!((image[j] - exact).abs() < 1e-10, "{} {exact}", image[j]);
            }
        }
    }
}
