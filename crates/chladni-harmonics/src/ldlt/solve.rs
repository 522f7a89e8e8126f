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

/// Calls a function for groups of 1 to 7 with the size of the group known to the compiler, so that the
/// group stays in registers; most supernodes are that narrow.
macro_rules! sized {
    ($size:expr, $function:ident($($argument:expr),*)) => {
        match $size {
            1 => $function::<L, 1>($($argument),*),
            2 => $function::<L, 2>($($argument),*),
            3 => $function::<L, 3>($($argument),*),
            4 => $function::<L, 4>($($argument),*),
            5 => $function::<L, 5>($($argument),*),
            6 => $function::<L, 6>($($argument),*),
            7 => $function::<L, 7>($($argument),*),
            _ => {}
        }
    };
}

/// own ← L₁₁⁻¹ own.
#[inline(always)]
fn forward_diagonal<L: Lanes>(lanes: L, diagonal: &[f64], w: usize, own: &mut [Row]) {
    let whole = w - w % 8;
    for i in (0..whole).step_by(8) {
        forward_group::<L, 8>(lanes, diagonal, w, i, own);
    }
    sized!(w - whole, forward_group(lanes, diagonal, w, whole, own));
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
    let rows: [&[f64]; R] = std::array::from_fn(|r| &l[(first + r) * w..][..x.len()]);
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
    let whole = rows.len() - rows.len() % 8;
    for i in (0..whole).step_by(8) {
        forward_rows::<L, 8>(lanes, below, w, i, rows, own, tail, offset);
    }
    sized!(rows.len() - whole, forward_rows(lanes, below, w, whole, rows, own, tail, offset));
}

#[inline(always)]
fn forward_rows<L: Lanes, const R: usize>(
    lanes: L,
    below: &[f64],
    w: usize,
    first: usize,
    rows: &[u32],
    own: &[Row],
    tail: &mut [Row],
    offset: usize,
) {
    let sum = products::<L, R>(lanes, below, w, first, own);
    for (sum, &row) in sum.into_iter().zip(&rows[first..first + R]) {
        let x = &mut tail[row as usize - offset];
        lanes.store(lanes.sub(lanes.load(x), sum), x);
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
    let whole = w - w % 8;
    for k in (0..whole).step_by(8) {
        backward_columns::<L, 8>(lanes, below, w, rows, k, own, tail, offset);
    }
    sized!(w - whole, backward_columns(lanes, below, w, rows, whole, own, tail, offset));
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
    // Two sums per column, as one would wait for itself.
    let mut even = [lanes.splat(0.0); R];
    let mut odd = [lanes.splat(0.0); R];
    let (pairs, last) = rows.as_chunks::<2>();
    for (l, pair) in below.chunks_exact(2 * w).zip(pairs) {
        add_row(lanes, &l[k..k + R], &tail[pair[0] as usize - offset], &mut even);
        add_row(lanes, &l[w + k..w + k + R], &tail[pair[1] as usize - offset], &mut odd);
    }
    if let [row] = last {
        let first = (rows.len() - 1) * w + k;
        add_row(lanes, &below[first..first + R], &tail[*row as usize - offset], &mut even);
    }
    for r in 0..R {
        let x = &mut own[k + r];
        lanes.store(lanes.sub(lanes.load(x), lanes.add(even[r], odd[r])), x);
    }
}

/// sum ← sum + lᵀ x.
#[inline(always)]
fn add_row<L: Lanes, const R: usize>(lanes: L, l: &[f64], x: &Row, sum: &mut [L::V; R]) {
    let x = lanes.load(x);
    for r in 0..R {
        sum[r] = lanes.mul_add(lanes.splat(l[r]), x, sum[r]);
    }
}

/// own ← L₁₁⁻ᵀ own.
#[inline(always)]
fn backward_diagonal<L: Lanes>(lanes: L, diagonal: &[f64], w: usize, own: &mut [Row]) {
    let part = w % 8;
    sized!(part, backward_group(lanes, diagonal, w, w - part, own));
    for start in (0..w - part).step_by(8).rev() {
        backward_group::<L, 8>(lanes, diagonal, w, start, own);
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
