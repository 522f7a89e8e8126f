//! Arithmetic on tall blocks: n rows of 8·W columns, stored row after row.

use crate::SymmetricSparse;
use crate::ldlt::Row;
use crate::simd::{Kernel, Lanes, dispatch};

/// A tall block of 8·W columns.
pub(super) type Block<const W: usize> = Vec<Row<W>>;

/// A small matrix of 8·W columns; row i holds the coefficients of column i of a block.
pub(super) type Small<const W: usize> = Vec<Row<W>>;

/// Rows that are worked on while they lie in the first cache.
const PANEL: usize = 128;

/// VᵀX for each block V of `basis`.
pub(super) fn overlaps<const W: usize>(basis: &[&[Row<W>]], x: &[Row<W>]) -> Vec<Small<W>> {
    let mut sums = vec![vec![[[0.0; 8]; W]; 8 * W]; basis.len()];
    dispatch(Overlaps { basis, x, sums: &mut sums });
    sums
}

struct Overlaps<'a, const W: usize> {
    basis: &'a [&'a [Row<W>]],
    x: &'a [Row<W>],
    sums: &'a mut [Small<W>],
}

impl<const W: usize> Kernel for Overlaps<'_, W> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) {
        for (panel, x) in self.x.chunks(PANEL).enumerate() {
            for (v, sum) in self.basis.iter().zip(self.sums.iter_mut()) {
                let v = &v[panel * PANEL..panel * PANEL + x.len()];
                for group in 0..W {
                    add_overlap(lanes, v, x, group, &mut sum[8 * group..8 * group + 8]);
                }
            }
        }
    }
}

/// Eight rows of VᵀX, those of one group of V's columns.
#[inline(always)]
fn add_overlap<L: Lanes, const W: usize>(
    lanes: L,
    v: &[Row<W>],
    x: &[Row<W>],
    group: usize,
    sum: &mut [Row<W>],
) {
    let mut total = [[lanes.splat(0.0); W]; 8];
    for (v, x) in v.iter().zip(x) {
        let x: [L::V; W] = std::array::from_fn(|b| lanes.load(&x[b]));
        for i in 0..8 {
            let v = lanes.splat(v[group][i]);
            for b in 0..W {
                total[i][b] = lanes.mul_add(v, x[b], total[i][b]);
            }
        }
    }
    for (sum, total) in sum.iter_mut().zip(total) {
        for b in 0..W {
            lanes.store(lanes.add(lanes.load(&sum[b]), total[b]), &mut sum[b]);
        }
    }
}

/// X ← X − Σ V C over the blocks V of `basis` and their coefficients C.
pub(super) fn subtract_products<const W: usize>(
    x: &mut [Row<W>],
    basis: &[&[Row<W>]],
    coefficients: &[Small<W>],
) {
    dispatch(SubtractProducts { x, basis, coefficients });
}

struct SubtractProducts<'a, const W: usize> {
    x: &'a mut [Row<W>],
    basis: &'a [&'a [Row<W>]],
    coefficients: &'a [Small<W>],
}

impl<const W: usize> Kernel for SubtractProducts<'_, W> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) {
        for (panel, x) in self.x.chunks_mut(PANEL).enumerate() {
            for (v, c) in self.basis.iter().zip(self.coefficients) {
                let v = &v[panel * PANEL..panel * PANEL + x.len()];
                let (mut xs, mut vs) = (x.chunks_exact_mut(8), v.chunks_exact(8));
                for (x, v) in xs.by_ref().zip(vs.by_ref()) {
                    subtract_rows::<L, 8, W>(lanes, x, v, c);
                }
                for (x, v) in xs.into_remainder().iter_mut().zip(vs.remainder()) {
                    subtract_rows::<L, 1, W>(lanes, std::slice::from_mut(x), std::slice::from_ref(v), c);
                }
            }
        }
    }
}

#[inline(always)]
fn subtract_rows<L: Lanes, const R: usize, const W: usize>(
    lanes: L,
    x: &mut [Row<W>],
    v: &[Row<W>],
    c: &[Row<W>],
) {
    let mut sum: [[L::V; W]; R] = std::array::from_fn(|r| std::array::from_fn(|b| lanes.load(&x[r][b])));
    for group in 0..W {
        for i in 0..8 {
            let c: [L::V; W] = std::array::from_fn(|b| lanes.load(&c[8 * group + i][b]));
            for r in 0..R {
                let v = lanes.splat(v[r][group][i]);
                for b in 0..W {
                    sum[r][b] = lanes.mul_sub_from(v, c[b], sum[r][b]);
                }
            }
        }
    }
    for r in 0..R {
        for b in 0..W {
            lanes.store(sum[r][b], &mut x[r][b]);
        }
    }
}

/// X ← X R⁻¹ for an upper triangular R given by its inverse (8W × 8W).
pub(super) fn multiply_right<const W: usize>(x: &mut [Row<W>], right: &Small<W>) {
    dispatch(MultiplyRight { x, right });
}

struct MultiplyRight<'a, const W: usize> {
    x: &'a mut [Row<W>],
    right: &'a Small<W>,
}

impl<const W: usize> Kernel for MultiplyRight<'_, W> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) {
        let mut chunks = self.x.chunks_exact_mut(8);
        for x in chunks.by_ref() {
            multiply_rows::<L, 8, W>(lanes, x, self.right);
        }
        for x in chunks.into_remainder() {
            multiply_rows::<L, 1, W>(lanes, std::slice::from_mut(x), self.right);
        }
    }
}

#[inline(always)]
fn multiply_rows<L: Lanes, const R: usize, const W: usize>(lanes: L, x: &mut [Row<W>], right: &[Row<W>]) {
    let mut sum = [[lanes.splat(0.0); W]; R];
    for group in 0..W {
        for i in 0..8 {
            let c: [L::V; W] = std::array::from_fn(|b| lanes.load(&right[8 * group + i][b]));
            for r in 0..R {
                let v = lanes.splat(x[r][group][i]);
                for b in 0..W {
                    sum[r][b] = lanes.mul_add(v, c[b], sum[r][b]);
                }
            }
        }
    }
    for r in 0..R {
        for b in 0..W {
            lanes.store(sum[r][b], &mut x[r][b]);
        }
    }
}

/// For each column x with value λ: ‖A x − λ x‖², Σ w (A x − λ x)² and Σ w (A x)².
pub(super) fn residuals<const W: usize>(
    matrix: &SymmetricSparse,
    x: &[Row<W>],
    values: &Row<W>,
    weight: &[f64],
) -> [Row<W>; 3] {
    dispatch(Residuals { matrix, x, values, weight })
}

struct Residuals<'a, const W: usize> {
    matrix: &'a SymmetricSparse,
    x: &'a [Row<W>],
    values: &'a Row<W>,
    weight: &'a [f64],
}

impl<const W: usize> Kernel for Residuals<'_, W> {
    type Output = [Row<W>; 3];

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) -> Self::Output {
        let Self { matrix, x, values, weight } = self;
        let mut sums = [[lanes.splat(0.0); W]; 3];
        for i in 0..x.len() {
            let range = matrix.column_starts[i]..matrix.column_starts[i + 1];
            let mut image = [lanes.splat(0.0); W];
            for (&j, &a) in matrix.rows[range.clone()].iter().zip(&matrix.values[range]) {
                for b in 0..W {
                    image[b] = lanes.mul_add(lanes.splat(a), lanes.load(&x[j as usize][b]), image[b]);
                }
            }
            let w = lanes.splat(weight[i]);
            for b in 0..W {
                let r = lanes.mul_sub_from(lanes.load(&values[b]), lanes.load(&x[i][b]), image[b]);
                sums[0][b] = lanes.mul_add(r, r, sums[0][b]);
                sums[1][b] = lanes.mul_add(lanes.mul(w, r), r, sums[1][b]);
                sums[2][b] = lanes.mul_add(lanes.mul(w, image[b]), image[b], sums[2][b]);
            }
        }
        let mut out = [[[0.0; 8]; W]; 3];
        for (sum, out) in sums.into_iter().zip(&mut out) {
            for b in 0..W {
                lanes.store(sum[b], &mut out[b]);
            }
        }
        out
    }
}

/// The factor of an orthonormalisation X = Q R.
pub(super) struct Triangular<const W: usize> {
    /// R, row i from column i on.
    pub r: Small<W>,
}

/// X ← Q and R of X = Q R by Cholesky on XᵀX, twice (Yamamoto et al. 2015). `None`, with X
/// spoiled, where the columns are dependent to working precision.
pub(super) fn orthonormalize<const W: usize>(x: &mut [Row<W>]) -> Option<Triangular<W>> {
    let mut r: Option<Small<W>> = None;
    for _ in 0..2 {
        let gram = overlaps::<W>(&[x], x).pop()?;
        let (upper, inverse) = cholesky::<W>(&gram)?;
        multiply_right(x, &inverse);
        r = Some(match r {
            None => upper,
            Some(first) => product::<W>(&upper, &first),
        });
    }
    r.map(|r| Triangular { r })
}

/// Upper triangular R with RᵀR = G, and its inverse.
fn cholesky<const W: usize>(gram: &Small<W>) -> Option<(Small<W>, Small<W>)> {
    let b = 8 * W;
    let at = |m: &Small<W>, i: usize, j: usize| m[i][j / 8][j % 8];
    let mut r = vec![[[0.0; 8]; W]; b];
    for i in 0..b {
        let sum: f64 = (0..i).map(|k| at(&r, k, i).powi(2)).sum();
        let pivot = at(gram, i, i) - sum;
        if pivot.is_nan() || pivot <= 1e-24 * at(gram, i, i) || at(gram, i, i) < f64::MIN_POSITIVE {
            return None;
        }
        let root = pivot.sqrt();
        r[i][i / 8][i % 8] = root;
        for j in i + 1..b {
            let sum: f64 = (0..i).map(|k| at(&r, k, i) * at(&r, k, j)).sum();
            r[i][j / 8][j % 8] = (at(gram, i, j) - sum) / root;
        }
    }
    let mut inverse = vec![[[0.0; 8]; W]; b];
    for j in 0..b {
        inverse[j][j / 8][j % 8] = 1.0 / at(&r, j, j);
        for i in (0..j).rev() {
            let sum: f64 = (i + 1..=j).map(|k| at(&r, i, k) * at(&inverse, k, j)).sum();
            inverse[i][j / 8][j % 8] = -sum / at(&r, i, i);
        }
    }
    Some((r, inverse))
}

fn product<const W: usize>(a: &Small<W>, b: &Small<W>) -> Small<W> {
    let size = 8 * W;
    let mut out = vec![[[0.0; 8]; W]; size];
    for i in 0..size {
        for k in 0..size {
            let factor = a[i][k / 8][k % 8];
            for group in 0..W {
                for lane in 0..8 {
                    out[i][group][lane] += factor * b[k][group][lane];
                }
            }
        }
    }
    out
}
