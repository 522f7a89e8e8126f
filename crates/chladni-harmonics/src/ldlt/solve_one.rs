//! Solves for a single right-hand side. Every value of L is used only once, and reading L takes all of the
//! time.

use super::panel::{PANEL, diagonal_len};
use super::solve::{parts, reorder};
use super::{Factor, Symbolic};
use crate::simd::{Kernel, Lanes, dispatch};

impl Factor {
    /// Replaces `x` (n values, new order) with (A − σI)⁻¹ x.
    pub(crate) fn solve_one(&self, symbolic: &Symbolic, x: &mut [f64]) {
        dispatch(SolveOne { factor: self, symbolic, x });
    }
}

pub(super) struct SolveOne<'a> {
    pub factor: &'a Factor,
    pub symbolic: &'a Symbolic,
    pub x: &'a mut [f64],
}

impl Kernel for SolveOne<'_> {
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
            let mut rest = diagonal;
            for i in (0..own.len()).step_by(PANEL) {
                let size = (own.len() - i).min(PANEL);
                let (group, after) = rest.split_at(size * (i + size));
                rest = after;
                let (left, triangle) = group.split_at(size * i);
                let (before, panel) = own.split_at_mut(i);
                let sums = products(lanes, left, size, before);
                panel.iter_mut().zip(sums).for_each(|(x, s)| *x -= s);
                for k in 0..size {
                    for r in k + 1..size {
                        panel[r] -= triangle[k * size + r] * panel[k];
                    }
                }
            }
            let mut rest = below;
            for rows in rows.chunks(PANEL) {
                let (panel, after) = rest.split_at(rows.len() * own.len());
                rest = after;
                let sums = products(lanes, panel, rows.len(), own);
                for (row, sum) in rows.iter().zip(sums) {
                    tail[*row as usize - end] -= sum;
                }
            }
        }
        for node in symbolic.supernodes.iter().rev() {
            let (diagonal, below, rows) = parts(factor, symbolic, node);
            let end = node.first + node.width;
            let (head, tail) = x.split_at_mut(end);
            let own = &mut head[node.first..];
            own.iter_mut().zip(&factor.inverse_pivots[node.first..end]).for_each(|(x, d)| *x *= d);
            let mut rest = below;
            for rows in rows.chunks(PANEL) {
                let (panel, after) = rest.split_at(rows.len() * own.len());
                rest = after;
                let mut x = [0.0; PANEL];
                for (x, row) in x.iter_mut().zip(rows) {
                    *x = tail[*row as usize - end];
                }
                subtract_transposed(lanes, panel, rows.len(), &x, own);
            }
            for i in (0..own.len()).step_by(PANEL).rev() {
                let size = (own.len() - i).min(PANEL);
                let group = &diagonal[diagonal_len(i)..][..size * (i + size)];
                let (left, triangle) = group.split_at(size * i);
                let (before, panel) = own.split_at_mut(i);
                let mut x = [0.0; PANEL];
                for r in (0..size).rev() {
                    let mut value = panel[r];
                    for k in r + 1..size {
                        value -= triangle[r * size + k] * x[k];
                    }
                    (x[r], panel[r]) = (value, value);
                }
                subtract_transposed(lanes, left, size, &x, before);
            }
            reorder(own, &factor.order[node.first..end], true);
        }
    }
}

/// The `size` rows of L in a panel, multiplied by `x`.
#[inline(always)]
fn products<L: Lanes>(lanes: L, panel: &[f64], size: usize, x: &[f64]) -> [f64; PANEL] {
    let mut sums = [0.0; PANEL];
    if size == PANEL {
        // Two partial sums: each addition to a single one would wait for the previous result.
        let mut lane = [lanes.splat(0.0); 2];
        let columns = panel.as_chunks::<PANEL>().0;
        let (pairs, last) = columns.as_chunks::<2>();
        let (xs, last_x) = x.as_chunks::<2>();
        for (l, x) in pairs.iter().zip(xs) {
            for s in 0..2 {
                lane[s] = lanes.mul_add(lanes.load(&l[s]), lanes.splat(x[s]), lane[s]);
            }
        }
        for (l, x) in last.iter().zip(last_x) {
            lane[0] = lanes.mul_add(lanes.load(l), lanes.splat(*x), lane[0]);
        }
        lanes.store(lanes.add(lane[0], lane[1]), &mut sums);
        return sums;
    }
    for (l, x) in panel.chunks_exact(size).zip(x) {
        sums.iter_mut().zip(l).for_each(|(s, l)| *s += l * x);
    }
    sums
}

/// own ← own − Lᵀ x for the `size` rows of L in a panel.
#[inline(always)]
fn subtract_transposed<L: Lanes>(lanes: L, panel: &[f64], size: usize, x: &[f64; PANEL], own: &mut [f64]) {
    if size == PANEL {
        let x = lanes.load(x);
        let (blocks, last) = panel.as_chunks::<PANEL>().0.as_chunks::<PANEL>();
        let (owns, last_own) = own.as_chunks_mut::<PANEL>();
        for (l, own) in blocks.iter().zip(owns) {
            // Eight columns of products, transposed: their column sums become sums of rows.
            let rows = lanes.transpose(std::array::from_fn(|k| lanes.mul(lanes.load(&l[k]), x)));
            let sum =
                |a: usize| lanes.add(lanes.add(rows[a], rows[a + 1]), lanes.add(rows[a + 2], rows[a + 3]));
            lanes.store(lanes.sub(lanes.load(own), lanes.add(sum(0), sum(4))), own);
        }
        for (l, own) in last.iter().zip(last_own) {
            let mut products = [0.0; PANEL];
            lanes.store(lanes.mul(lanes.load(l), x), &mut products);
            *own -= products.iter().sum::<f64>();
        }
        return;
    }
    for (l, own) in panel.chunks_exact(size).zip(own) {
        *own -= l.iter().zip(x).map(|(l, x)| l * x).sum::<f64>();
    }
}
