//! Arithmetic on tall blocks: n rows of eight columns, stored row after row.

use std::ops::Range;

use rayon::prelude::*;

use crate::ldlt::Row;
use crate::simd::{Kernel, Lanes, dispatch};
use crate::values::{Keep, Values};
use crate::{SymmetricSparse, pages};

/// The number of columns of a block.
pub(super) const BLOCK: usize = 8;

/// Tall blocks of eight columns, stored one after the other.
#[derive(Clone, Debug, Default)]
pub(super) struct Blocks {
    rows: Values<Row>,
    /// The number of rows of a block.
    n: usize,
}

impl Blocks {
    /// `count` blocks of `n` rows, which must be written before they are read.
    pub(super) fn untouched(n: usize, count: usize) -> Self {
        Self { rows: pages::zeroed(n * count).into(), n }
    }

    /// `count` blocks of `n` rows of zeros, for adding to.
    pub(super) fn zeroed(n: usize, count: usize) -> Self {
        let mut blocks = Self::untouched(n, count);
        // Written now: a fresh page that is read before it is written costs two page faults instead of one.
        blocks.rows.fill([0.0; 8]);
        blocks
    }

    /// Moves the blocks to where `keep` says.
    pub(super) fn move_to(&mut self, keep: Keep) -> std::io::Result<()> {
        self.rows = std::mem::take(&mut self.rows).moved(keep)?;
        Ok(())
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = &[Row]> {
        self.rows.chunks_exact(self.n.max(1))
    }

    pub(super) fn iter_mut(&mut self) -> impl Iterator<Item = &mut [Row]> {
        self.rows.chunks_exact_mut(self.n.max(1))
    }

    pub(super) fn par_iter_mut(&mut self) -> impl IndexedParallelIterator<Item = &mut [Row]> {
        self.rows.par_chunks_exact_mut(self.n.max(1))
    }
}

/// An 8×8 matrix, row after row.
pub(super) type Small = [Row; BLOCK];

/// The number of rows that are processed while they are in the first-level cache.
const PANEL: usize = 64;

/// VᵀX for each block V of `basis` and each X of `xs`; the products of one V are stored side by side. The
/// basis is read once for all of `xs`.
pub(super) fn overlaps(basis: &[&[Row]], xs: &[&[Row]]) -> Vec<Small> {
    let mut sums = vec![[[0.0; 8]; BLOCK]; basis.len() * xs.len()];
    dispatch(Overlaps { basis, xs, upper: false, sums: &mut sums });
    sums
}

/// VᵀX for each pair of `blocks` in which V does not come after X; other pairs may be skipped.
pub(super) fn upper_overlaps(blocks: &[&[Row]]) -> Vec<Small> {
    let mut sums = vec![[[0.0; 8]; BLOCK]; blocks.len() * blocks.len()];
    dispatch(Overlaps { basis: blocks, xs: blocks, upper: true, sums: &mut sums });
    sums
}

/// VᵀX.
pub(super) fn overlap(v: &[Row], x: &[Row]) -> Small {
    let mut sums = [[[0.0; 8]; BLOCK]];
    dispatch(Overlaps { basis: &[v], xs: &[x], upper: false, sums: &mut sums });
    sums[0]
}

struct Overlaps<'a> {
    basis: &'a [&'a [Row]],
    xs: &'a [&'a [Row]],
    /// Whether pairs in which V comes after X may be skipped.
    upper: bool,
    sums: &'a mut [Small],
}

impl Kernel for Overlaps<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) {
        let n = self.xs.first().map_or(0, |x| x.len());
        for first in (0..n).step_by(PANEL) {
            let panel = first..(first + PANEL).min(n);
            for (b, sums) in self.sums.chunks_exact_mut(self.xs.len()).enumerate() {
                let v = &self.basis[b][panel.clone()];
                let next = upcoming(self.basis, b, &panel);
                let (pairs, last) = self.xs.as_chunks::<2>();
                let (pair_sums, last_sums) = sums.as_chunks_mut::<2>();
                let left_out = if self.upper { b / 2 } else { 0 };
                for (x, sum) in pairs.iter().zip(pair_sums).skip(left_out) {
                    add_overlaps(lanes, v, next, x.map(|x| &x[panel.clone()]), sum);
                }
                for (x, sum) in last.iter().zip(last_sums) {
                    add_overlaps(lanes, v, next, [&x[panel.clone()]], std::array::from_mut(sum));
                }
            }
        }
    }
}

/// The rows to prefetch after those of block `b` in `panel`: the same rows of the next block. Panels are
/// too short for the processor's own prefetching.
#[inline(always)]
fn upcoming<'a>(basis: &[&'a [Row]], b: usize, panel: &Range<usize>) -> &'a [Row] {
    match basis.get(b + 1) {
        Some(next) => &next[panel.clone()],
        None => {
            let first = basis[0];
            &first[panel.end..(panel.end + PANEL).min(first.len())]
        }
    }
}

#[inline(always)]
fn add_overlaps<L: Lanes, const X: usize>(
    lanes: L,
    v: &[Row],
    next: &[Row],
    xs: [&[Row]; X],
    sums: &mut [Small; X],
) {
    let mut total = [[lanes.splat(0.0); BLOCK]; X];
    let xs = xs.map(|x| &x[..v.len()]);
    for (k, v) in v.iter().enumerate() {
        if let Some(next) = next.get(k) {
            lanes.prefetch(next);
        }
        let x: [L::V; X] = std::array::from_fn(|b| lanes.load(&xs[b][k]));
        for i in 0..BLOCK {
            let v = lanes.splat(v[i]);
            for b in 0..X {
                total[b][i] = lanes.mul_add(v, x[b], total[b][i]);
            }
        }
    }
    for (sum, total) in sums.as_flattened_mut().iter_mut().zip(total.as_flattened()) {
        lanes.store(lanes.add(lanes.load(sum), *total), sum);
    }
}

/// X ← X − Σ V C over the blocks V of `basis`, for each X of `xs`. The coefficients C of one V are stored
/// side by side. The basis is read once for all of `xs`.
pub(super) fn subtract_products(xs: &mut [&mut [Row]], basis: &[&[Row]], coefficients: &[Small]) {
    dispatch(SubtractProducts { xs, basis, coefficients });
}

struct SubtractProducts<'a, 'b> {
    xs: &'a mut [&'b mut [Row]],
    basis: &'a [&'a [Row]],
    coefficients: &'a [Small],
}

impl Kernel for SubtractProducts<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) {
        let Self { xs, basis, coefficients } = self;
        let (n, count) = (xs.first().map_or(0, |x| x.len()), xs.len());
        let coefficients = Coefficients { of: coefficients, count };
        for first in (0..n).step_by(PANEL) {
            let panel = first..(first + PANEL).min(n);
            let (fours, rest) = xs.as_chunks_mut::<4>();
            let (pairs, last) = rest.as_chunks_mut::<2>();
            for (at, four) in fours.iter_mut().enumerate() {
                subtract_panel::<L, 4, 4>(lanes, four, basis, &panel, coefficients, 4 * at);
            }
            for pair in pairs {
                subtract_panel::<L, 2, 8>(lanes, pair, basis, &panel, coefficients, count / 4 * 4);
            }
            for x in last {
                let x = std::array::from_mut(x);
                subtract_panel::<L, 1, 8>(lanes, x, basis, &panel, coefficients, count - 1);
            }
        }
    }
}

/// For each block of a basis, one matrix for each of `count` blocks.
#[derive(Clone, Copy)]
struct Coefficients<'a> {
    of: &'a [Small],
    count: usize,
}

/// One panel of X blocks, starting with number `at`, R rows at a time.
#[inline(always)]
fn subtract_panel<L: Lanes, const X: usize, const R: usize>(
    lanes: L,
    xs: &mut [&mut [Row]; X],
    basis: &[&[Row]],
    panel: &Range<usize>,
    coefficients: Coefficients,
    at: usize,
) {
    let mut xs = xs.each_mut().map(|x| &mut x[panel.clone()]);
    for (block, c) in coefficients.of.chunks_exact(coefficients.count).enumerate() {
        let Some(c) = c[at..].first_chunk::<X>() else { return };
        let (groups, rest) = basis[block][panel.clone()].as_chunks::<R>();
        let next = upcoming(basis, block, panel).as_chunks::<R>().0;
        for (k, v) in groups.iter().enumerate() {
            if let Some(next) = next.get(k) {
                next.iter().for_each(|row| lanes.prefetch(row));
            }
            subtract_rows(lanes, &mut xs, R * k, v, c);
        }
        for (k, v) in rest.iter().enumerate() {
            subtract_rows(lanes, &mut xs, R * groups.len() + k, std::array::from_ref(v), c);
        }
    }
}

/// Rows `first .. first + R` of X − V C.
#[inline(always)]
fn subtract_rows<L: Lanes, const X: usize, const R: usize>(
    lanes: L,
    xs: &mut [&mut [Row]; X],
    first: usize,
    v: &[Row; R],
    c: &[Small; X],
) {
    let mut sum: [[L::V; R]; X] = std::array::from_fn(|b| {
        let x = &xs[b][first..first + R];
        std::array::from_fn(|r| lanes.load(&x[r]))
    });
    for i in 0..BLOCK {
        let c: [L::V; X] = std::array::from_fn(|b| lanes.load(&c[b][i]));
        for r in 0..R {
            let v = lanes.splat(v[r][i]);
            for b in 0..X {
                sum[b][r] = lanes.mul_sub_from(v, c[b], sum[b][r]);
            }
        }
    }
    for b in 0..X {
        let x = &mut xs[b][first..first + R];
        for r in 0..R {
            lanes.store(sum[b][r], &mut x[r]);
        }
    }
}

/// X ← X R. Callers pass the inverse of an upper triangular R to get X R⁻¹.
pub(super) fn multiply_right(x: &mut [Row], right: &Small) {
    dispatch(MultiplyRight { x, right });
}

struct MultiplyRight<'a> {
    x: &'a mut [Row],
    right: &'a Small,
}

impl Kernel for MultiplyRight<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) {
        let (chunks, rest) = self.x.as_chunks_mut::<8>();
        for x in chunks {
            multiply_rows(lanes, x, self.right);
        }
        for x in rest {
            multiply_rows(lanes, std::array::from_mut(x), self.right);
        }
    }
}

#[inline(always)]
fn multiply_rows<L: Lanes, const R: usize>(lanes: L, x: &mut [Row; R], right: &Small) {
    let mut sum = [lanes.splat(0.0); R];
    for (i, c) in right.iter().enumerate() {
        let c = lanes.load(c);
        for r in 0..R {
            sum[r] = lanes.mul_add(lanes.splat(x[r][i]), c, sum[r]);
        }
    }
    for r in 0..R {
        lanes.store(sum[r], &mut x[r]);
    }
}

/// For each column x with value λ: ‖A x − λ x‖², Σ w (A x − λ x)² and Σ w (A x)².
pub(super) fn residuals(matrix: &SymmetricSparse, x: &[Row], values: &Row, weight: &[f64]) -> [Row; 3] {
    dispatch(Residuals { matrix, x, values, weight })
}

struct Residuals<'a> {
    matrix: &'a SymmetricSparse,
    x: &'a [Row],
    values: &'a Row,
    weight: &'a [f64],
}

impl Kernel for Residuals<'_> {
    type Output = [Row; 3];

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) -> Self::Output {
        let Self { matrix, x, values, weight } = self;
        let mut sums = [lanes.splat(0.0); 3];
        let values = lanes.load(values);
        for i in 0..x.len() {
            let image = row_times(lanes, matrix, i, x);
            let w = lanes.splat(weight[i]);
            let r = lanes.mul_sub_from(values, lanes.load(&x[i]), image);
            sums[0] = lanes.mul_add(r, r, sums[0]);
            sums[1] = lanes.mul_add(lanes.mul(w, r), r, sums[1]);
            sums[2] = lanes.mul_add(lanes.mul(w, image), image, sums[2]);
        }
        let mut out = [[0.0; 8]; 3];
        for (sum, out) in sums.into_iter().zip(&mut out) {
            lanes.store(sum, out);
        }
        out
    }
}

/// Row `i` of the matrix times `x`.
#[inline(always)]
pub(super) fn row_times<L: Lanes>(lanes: L, matrix: &SymmetricSparse, i: usize, x: &[Row]) -> L::V {
    let range = matrix.column_starts[i]..matrix.column_starts[i + 1];
    let mut sum = lanes.splat(0.0);
    for (&j, &a) in matrix.rows[range.clone()].iter().zip(&matrix.values[range]) {
        sum = lanes.mul_add(lanes.splat(a), lanes.load(&x[j as usize]), sum);
    }
    sum
}

#[cfg(test)]
#[path = "tall_tests.rs"]
mod tests;
