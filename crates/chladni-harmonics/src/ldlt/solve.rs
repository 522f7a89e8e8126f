//! Solving with many right-hand sides at once.

use super::front::TILE;
use super::symbolic::Supernode;
use super::{Factor, Symbolic};
use crate::simd::{Kernel, Lanes, dispatch};

/// One row of a block of eight columns.
pub(crate) type Row = [f64; 8];

impl Factor {
    /// Overwrites the block `x` (n rows of right-hand sides, new order) by (A − σI)⁻¹ x.
    pub(crate) fn solve(&self, symbolic: &Symbolic, x: &mut [Row]) {
        dispatch(Solve { factor: self, symbolic, x });
    }
}

struct Solve<'a> {
    factor: &'a Factor,
    symbolic: &'a Symbolic,
    x: &'a mut [Row],
}

impl Kernel for Solve<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) {
        let Self { factor, symbolic, x } = self;
        for node in &symbolic.supernodes {
            let (diagonal, below, rows) = parts(factor, symbolic, node);
            let end = node.first + node.width;
            let (head, tail) = x.split_at_mut(end);
            let own = &mut head[node.first..];
            reorder(own, &factor.order[node.first..end], false);
            forward_diagonal(lanes, diagonal, node.width, own);
            forward_below(lanes, below, node.width, rows, own, tail, end);
        }
        for node in symbolic.supernodes.iter().rev() {
            let (diagonal, below, rows) = parts(factor, symbolic, node);
            let end = node.first + node.width;
            let (head, tail) = x.split_at_mut(end);
            let own = &mut head[node.first..];
            for (x, &d) in own.iter_mut().zip(&factor.inverse_pivots[node.first..end]) {
                lanes.store(lanes.mul(lanes.load(x), lanes.splat(d)), x);
            }
            backward_below(lanes, below, node.width, rows, own, tail, end);
            backward_diagonal(lanes, diagonal, node.width, own);
            reorder(own, &factor.order[node.first..end], true);
        }
    }
}

/// Puts the rows of a supernode in the order of elimination, or `back`. They move within
/// groups of [`TILE`] only.
#[inline(always)]
fn reorder(own: &mut [Row], order: &[u32], back: bool) {
    for (group, (rows, order)) in own.chunks_mut(TILE).zip(order.chunks(TILE)).enumerate() {
        let first = group * TILE;
        if order.iter().enumerate().all(|(k, &from)| first + k == from as usize) {
            continue;
        }
        let mut kept = [[0.0; 8]; TILE];
        kept[..rows.len()].copy_from_slice(rows);
        for (k, &from) in order.iter().enumerate() {
            let from = from as usize - first;
            if back {
                rows[from] = kept[k];
            } else {
                rows[k] = kept[from];
            }
        }
    }
}

#[inline(always)]
fn parts<'a>(
    factor: &'a Factor,
    symbolic: &'a Symbolic,
    node: &Supernode,
) -> (&'a [f64], &'a [f64], &'a [u32]) {
    let w = node.width;
    let values = &factor.values[node.values_start..node.values_start + w * (w + node.below)];
    let (diagonal, below) = values.split_at(w * w);
    (diagonal, below, &symbolic.rows[node.rows_start..node.rows_start + node.below])
}

#[inline(always)]
fn subtract<L: Lanes>(lanes: L, x: &mut Row, sum: L::V) {
    lanes.store(lanes.sub(lanes.load(x), sum), x);
}

/// own ← L₁₁⁻¹ own.
#[inline(always)]
fn forward_diagonal<L: Lanes>(lanes: L, diagonal: &[f64], w: usize, own: &mut [Row]) {
    let mut i = 0;
    while i + 8 <= w {
        forward_group::<L, 8>(lanes, diagonal, w, i, own);
        i += 8;
    }
    while i < w {
        forward_group::<L, 1>(lanes, diagonal, w, i, own);
        i += 1;
    }
}

/// Rows `i .. i + R` of L₁₁⁻¹, given all rows before them.
#[inline(always)]
fn forward_group<L: Lanes, const R: usize>(lanes: L, diagonal: &[f64], w: usize, i: usize, own: &mut [Row]) {
    let (before, group) = own.split_at_mut(i);
    let mut x = products::<L, R>(lanes, diagonal, w, i, before);
    for r in 0..R {
        x[r] = lanes.sub(lanes.load(&group[r]), x[r]);
        for k in 0..r {
            let l = lanes.splat(diagonal[(i + r) * w + i + k]);
            x[r] = lanes.mul_sub_from(l, x[k], x[r]);
        }
        lanes.store(x[r], &mut group[r]);
    }
}

/// Rows `first .. first + R` of L (rows `w` apart) times `x`.
#[inline(always)]
fn products<L: Lanes, const R: usize>(lanes: L, l: &[f64], w: usize, first: usize, x: &[Row]) -> [L::V; R] {
    let rows: [&[f64]; R] = std::array::from_fn(|r| &l[(first + r) * w..(first + r) * w + x.len()]);
    let mut sum = [lanes.splat(0.0); R];
    for (k, x) in x.iter().enumerate() {
        let x = lanes.load(x);
        for r in 0..R {
            let l = lanes.splat(rows[r][k]);
            sum[r] = lanes.mul_add(l, x, sum[r]);
        }
    }
    sum
}

/// x[rows] ← x[rows] − L₂₁ own.
#[inline(always)]
fn forward_below<L: Lanes>(
    lanes: L,
    below: &[f64],
    w: usize,
    rows: &[u32],
    own: &[Row],
    tail: &mut [Row],
    offset: usize,
) {
    let mut i = 0;
    while i + 8 <= rows.len() {
        let sum = products::<L, 8>(lanes, below, w, i, own);
        for r in 0..8 {
            subtract(lanes, &mut tail[rows[i + r] as usize - offset], sum[r]);
        }
        i += 8;
    }
    while i + 2 <= rows.len() {
        let sum = products::<L, 2>(lanes, below, w, i, own);
        for r in 0..2 {
            subtract(lanes, &mut tail[rows[i + r] as usize - offset], sum[r]);
        }
        i += 2;
    }
    if i < rows.len() {
        let sum = products::<L, 1>(lanes, below, w, i, own);
        subtract(lanes, &mut tail[rows[i] as usize - offset], sum[0]);
    }
}

/// own ← own − L₂₁ᵀ x[rows].
#[inline(always)]
fn backward_below<L: Lanes>(
    lanes: L,
    below: &[f64],
    w: usize,
    rows: &[u32],
    own: &mut [Row],
    tail: &[Row],
    offset: usize,
) {
    let mut k = 0;
    while k + 8 <= w {
        backward_columns::<L, 8>(lanes, below, w, rows, k, own, tail, offset);
        k += 8;
    }
    while k + 2 <= w {
        backward_columns::<L, 2>(lanes, below, w, rows, k, own, tail, offset);
        k += 2;
    }
    if k < w {
        backward_columns::<L, 1>(lanes, below, w, rows, k, own, tail, offset);
    }
}

#[inline(always)]
fn backward_columns<L: Lanes, const R: usize>(
    lanes: L,
    below: &[f64],
    w: usize,
    rows: &[u32],
    k: usize,
    own: &mut [Row],
    tail: &[Row],
    offset: usize,
) {
    let mut sum = [lanes.splat(0.0); R];
    for (l, &row) in below.chunks_exact(w).zip(rows) {
        let x = &tail[row as usize - offset];
        let x = lanes.load(x);
        let l = &l[k..k + R];
        for r in 0..R {
            let l = lanes.splat(l[r]);
            sum[r] = lanes.mul_add(l, x, sum[r]);
        }
    }
    for r in 0..R {
        subtract(lanes, &mut own[k + r], sum[r]);
    }
}

/// own ← L₁₁⁻ᵀ own.
#[inline(always)]
fn backward_diagonal<L: Lanes>(lanes: L, diagonal: &[f64], w: usize, own: &mut [Row]) {
    let mut end = w;
    while end >= 8 {
        end -= 8;
        backward_group::<L, 8>(lanes, diagonal, w, end, own);
    }
    while end > 0 {
        end -= 1;
        backward_group::<L, 1>(lanes, diagonal, w, end, own);
    }
}

/// Rows `start .. start + R` of L₁₁⁻ᵀ, given all rows after them.
#[inline(always)]
fn backward_group<L: Lanes, const R: usize>(
    lanes: L,
    diagonal: &[f64],
    w: usize,
    start: usize,
    own: &mut [Row],
) {
    let mut x = [lanes.splat(0.0); R];
    for i in start + R..w {
        let l = &diagonal[i * w + start..i * w + start + R];
        let later = lanes.load(&own[i]);
        for r in 0..R {
            let l = lanes.splat(l[r]);
            x[r] = lanes.mul_add(l, later, x[r]);
        }
    }
    for r in (0..R).rev() {
        x[r] = lanes.sub(lanes.load(&own[start + r]), x[r]);
        for later in r + 1..R {
            let l = lanes.splat(diagonal[(start + later) * w + start + r]);
            x[r] = lanes.mul_sub_from(l, x[later], x[r]);
        }
        lanes.store(x[r], &mut own[start + r]);
    }
}
