//! Solves for many right-hand sides at once.

use super::front::TILE;
use super::panel::{PANEL, diagonal_len};
use super::symbolic::Supernode;
use super::{Factor, Symbolic};
use crate::simd::{Kernel, Lanes, dispatch};

/// One row of a block of eight columns.
pub(crate) type Row = [f64; 8];

impl Factor {
    /// Replaces the block `x` (n rows of right-hand sides, new order) with (A − σI)⁻¹ x.
    pub(crate) fn solve(&self, symbolic: &Symbolic, x: &mut [Row]) {
        dispatch(Solve { factor: self, symbolic, x, part: Part::Whole });
    }

    /// For a positive definite A − σI = G Gᵀ: replaces `x` with G⁻¹ x, whose rows are in elimination order.
    pub(crate) fn solve_half(&self, symbolic: &Symbolic, x: &mut [Row]) {
        dispatch(Solve { factor: self, symbolic, x, part: Part::Forward });
    }

    /// Replaces `x`, with rows in elimination order, with G⁻ᵀ x (see [`solve_half`](Self::solve_half)).
    pub(crate) fn solve_transposed_half(&self, symbolic: &Symbolic, x: &mut [Row]) {
        dispatch(Solve { factor: self, symbolic, x, part: Part::Backward });
    }
}

/// The part of L D Lᵀ = A − σI to solve with: all of it, L √D, or the transpose of L √D.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Part {
    Whole,
    Forward,
    Backward,
}

pub(super) struct Solve<'a> {
    pub factor: &'a Factor,
    pub symbolic: &'a Symbolic,
    pub x: &'a mut [Row],
    pub part: Part,
}

impl Kernel for Solve<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) {
        let Self { factor, symbolic, x, part } = self;
        let forward = if part == Part::Backward { &[][..] } else { &symbolic.supernodes };
        for node in forward {
            let (diagonal, below, rows) = parts(factor, symbolic, node);
            let end = node.first + node.width;
            let (head, tail) = x.split_at_mut(end);
            let own = &mut head[node.first..];
            reorder(own, &factor.order[node.first..end], false);
            forward_diagonal(lanes, diagonal, own);
            forward_below(lanes, below, rows, own, tail, end);
        }
        if part == Part::Forward {
            for (x, d) in x.iter_mut().zip(&factor.inverse_pivots) {
                lanes.store(lanes.mul(lanes.load(x), lanes.splat(d.sqrt())), x);
            }
            return;
        }
        for node in symbolic.supernodes.iter().rev() {
            let (diagonal, below, rows) = parts(factor, symbolic, node);
            let end = node.first + node.width;
            let (head, tail) = x.split_at_mut(end);
            let own = &mut head[node.first..];
            for (x, &d) in own.iter_mut().zip(&factor.inverse_pivots[node.first..end]) {
                let d = if part == Part::Backward { d.sqrt() } else { d };
                lanes.store(lanes.mul(lanes.load(x), lanes.splat(d)), x);
            }
            backward_below(lanes, below, rows, own, tail, end);
            backward_diagonal(lanes, diagonal, own);
            reorder(own, &factor.order[node.first..end], true);
        }
    }
}

/// Permutes the rows of a supernode to elimination order, or `back`. Rows move only within groups of
/// [`TILE`].
#[inline(always)]
pub(super) fn reorder<T: Copy + Default>(own: &mut [T], order: &[u32], back: bool) {
    for (group, (rows, order)) in own.chunks_mut(TILE).zip(order.chunks(TILE)).enumerate() {
        let first = group * TILE;
        if order.iter().enumerate().all(|(k, &from)| first + k == from as usize) {
            continue;
        }
        let mut kept = [T::default(); TILE];
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

/// The diagonal block of a supernode, the values below it, and their rows.
#[inline(always)]
pub(super) fn parts<'a>(
    factor: &'a Factor,
    symbolic: &'a Symbolic,
    node: &Supernode,
) -> (&'a [f64], &'a [f64], &'a [u32]) {
    let diagonal = diagonal_len(node.width);
    let values = &factor.values[node.values_start..][..diagonal + node.width * node.below];
    let (diagonal, below) = values.split_at(diagonal);
    (diagonal, below, &symbolic.rows[node.rows_start..node.rows_start + node.below])
}

/// Calls a function for a panel of 1 to 7 rows with the number of rows as a constant, which keeps them in
/// registers.
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

/// The R rows of L in a panel, multiplied by `x`.
#[inline(always)]
fn products<L: Lanes, const R: usize>(lanes: L, panel: &[f64], x: &[Row]) -> [L::V; R] {
    let mut sum = [lanes.splat(0.0); R];
    for (l, x) in panel.as_chunks::<R>().0.iter().zip(x) {
        let x = lanes.load(x);
        for r in 0..R {
            sum[r] = lanes.mul_add(lanes.splat(l[r]), x, sum[r]);
        }
    }
    sum
}

/// own ← own − Lᵀ x for the R rows of L in a panel.
#[inline(always)]
fn subtract_transposed<L: Lanes, const R: usize>(lanes: L, panel: &[f64], x: &[L::V; R], own: &mut [Row]) {
    for (l, own) in panel.as_chunks::<R>().0.iter().zip(own) {
        // Two partial sums: each addition to a single one would wait for the previous result.
        let mut sum = [lanes.load(own), lanes.splat(0.0)];
        for r in 0..R {
            sum[r % 2] = lanes.mul_sub_from(lanes.splat(l[r]), x[r], sum[r % 2]);
        }
        lanes.store(if R > 1 { lanes.add(sum[0], sum[1]) } else { sum[0] }, own);
    }
}

/// own ← L₁₁⁻¹ own.
#[inline(always)]
fn forward_diagonal<L: Lanes>(lanes: L, mut diagonal: &[f64], own: &mut [Row]) {
    let whole = own.len() - own.len() % PANEL;
    for i in (0..whole).step_by(PANEL) {
        let (group, rest) = diagonal.split_at(PANEL * (i + PANEL));
        forward_group::<L, PANEL>(lanes, group, own, i);
        diagonal = rest;
    }
    sized!(own.len() - whole, forward_group(lanes, diagonal, own, whole));
}

/// Solves rows `i .. i + R` of L₁₁⁻¹, given all rows before them.
#[inline(always)]
fn forward_group<L: Lanes, const R: usize>(lanes: L, group: &[f64], own: &mut [Row], i: usize) {
    let (left, triangle) = group.split_at(R * i);
    let (before, own) = own.split_at_mut(i);
    let mut x = products::<L, R>(lanes, left, before);
    let (Some(triangle), Some(own)) =
        (triangle.as_chunks::<R>().0.first_chunk::<R>(), own.first_chunk_mut::<R>())
    else {
        return;
    };
    for r in 0..R {
        x[r] = lanes.sub(lanes.load(&own[r]), x[r]);
    }
    for k in 0..R {
        for r in k + 1..R {
            x[r] = lanes.mul_sub_from(lanes.splat(triangle[k][r]), x[k], x[r]);
        }
        lanes.store(x[k], &mut own[k]);
    }
}

/// own ← L₁₁⁻ᵀ own.
#[inline(always)]
fn backward_diagonal<L: Lanes>(lanes: L, mut diagonal: &[f64], own: &mut [Row]) {
    let part = own.len() % PANEL;
    let whole = own.len() - part;
    let (groups, last) = diagonal.split_at(diagonal_len(whole));
    sized!(part, backward_group(lanes, last, own, whole));
    diagonal = groups;
    for i in (0..whole).step_by(PANEL).rev() {
        let (rest, group) = diagonal.split_at(diagonal_len(i));
        backward_group::<L, PANEL>(lanes, group, own, i);
        diagonal = rest;
    }
}

/// Solves rows `i .. i + R` of L₁₁⁻ᵀ, and subtracts their contribution from all rows before them.
#[inline(always)]
fn backward_group<L: Lanes, const R: usize>(lanes: L, group: &[f64], own: &mut [Row], i: usize) {
    let (left, triangle) = group.split_at(R * i);
    let (before, own) = own.split_at_mut(i);
    let (Some(triangle), Some(own)) =
        (triangle.as_chunks::<R>().0.first_chunk::<R>(), own.first_chunk_mut::<R>())
    else {
        return;
    };
    let mut x: [L::V; R] = std::array::from_fn(|r| lanes.load(&own[r]));
    for r in (0..R).rev() {
        lanes.store(x[r], &mut own[r]);
        for k in 0..r {
            x[k] = lanes.mul_sub_from(lanes.splat(triangle[k][r]), x[r], x[k]);
        }
    }
    subtract_transposed(lanes, left, &x, before);
}

/// x[rows] ← x[rows] − L₂₁ own.
#[inline(always)]
fn forward_below<L: Lanes>(
    lanes: L,
    below: &[f64],
    rows: &[u32],
    own: &[Row],
    tail: &mut [Row],
    offset: usize,
) {
    let (panels, last) = rows.as_chunks::<PANEL>();
    let (values, last_values) = below.split_at(panels.len() * PANEL * own.len());
    for (panel, rows) in values.chunks_exact(PANEL * own.len()).zip(panels) {
        forward_rows::<L, PANEL>(lanes, panel, rows, own, tail, offset);
    }
    sized!(last.len(), forward_rows(lanes, last_values, last, own, tail, offset));
}

#[inline(always)]
fn forward_rows<L: Lanes, const R: usize>(
    lanes: L,
    panel: &[f64],
    rows: &[u32],
    own: &[Row],
    tail: &mut [Row],
    offset: usize,
) {
    let sum = products::<L, R>(lanes, panel, own);
    for (sum, &row) in sum.into_iter().zip(rows) {
        let x = &mut tail[row as usize - offset];
        lanes.store(lanes.sub(lanes.load(x), sum), x);
    }
}

/// own ← own − L₂₁ᵀ x[rows].
#[inline(always)]
fn backward_below<L: Lanes>(
    lanes: L,
    below: &[f64],
    rows: &[u32],
    own: &mut [Row],
    tail: &[Row],
    offset: usize,
) {
    let (panels, last) = rows.as_chunks::<PANEL>();
    let (values, last_values) = below.split_at(panels.len() * PANEL * own.len());
    for (panel, rows) in values.chunks_exact(PANEL * own.len()).zip(panels) {
        backward_rows::<L, PANEL>(lanes, panel, rows, own, tail, offset);
    }
    sized!(last.len(), backward_rows(lanes, last_values, last, own, tail, offset));
}

#[inline(always)]
fn backward_rows<L: Lanes, const R: usize>(
    lanes: L,
    panel: &[f64],
    rows: &[u32],
    own: &mut [Row],
    tail: &[Row],
    offset: usize,
) {
    let x: [L::V; R] = std::array::from_fn(|r| lanes.load(&tail[rows[r] as usize - offset]));
    subtract_transposed(lanes, panel, &x, own);
}
