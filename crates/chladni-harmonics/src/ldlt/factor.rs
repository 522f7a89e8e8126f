//! The numerical factorization of A − σI.

use super::Symbolic;
use super::front::{ZeroPivot, eliminate, stride};
use super::panel::{diagonal_len, pack};
use crate::simd::{Kernel, Lanes, dispatch};
use crate::{SymmetricSparse, pages};

/// L and D for one shift.
#[derive(Debug, Default)]
pub(crate) struct Factor {
    /// Values of L in the layout of [`Symbolic`].
    pub values: Vec<f64>,
    /// For each position, the column of the supernode that was eliminated there, by new index (see
    /// [`eliminate`]).
    pub order: Vec<u32>,
    /// 1 / D, by new index, in elimination order.
    pub inverse_pivots: Vec<f64>,
    /// The number of negative pivots, which is the number of eigenvalues of A below σ (Sylvester).
    pub below_shift: usize,
}

/// Memory that is reused between factorizations.
#[derive(Debug, Default)]
pub(crate) struct Workspace {
    front: Vec<f64>,
    packed: Vec<f64>,
    /// A stack of Schur complements that wait for their parents.
    waiting: Vec<f64>,
}

impl Factor {
    /// Factors `matrix` − `shift`·I, where `matrix` is already in the order of `symbolic`.
    pub(crate) fn compute(
        &mut self,
        symbolic: &Symbolic,
        matrix: &SymmetricSparse,
        shift: f64,
        workspace: &mut Workspace,
    ) -> Result<(), ZeroPivot> {
        dispatch(self.factorization(symbolic, matrix, shift, workspace))
    }

    /// The work of [`compute`](Self::compute).
    pub(super) fn factorization<'a>(
        &'a mut self,
        symbolic: &'a Symbolic,
        matrix: &'a SymmetricSparse,
        shift: f64,
        workspace: &'a mut Workspace,
    ) -> Factorize<'a> {
        if self.values.len() != symbolic.values {
            self.values = pages::zeroed(symbolic.values);
        }
        self.inverse_pivots.resize(symbolic.size(), 0.0);
        self.order.resize(symbolic.size(), 0);
        Factorize { factor: self, symbolic, matrix, shift, workspace }
    }
}

pub(super) struct Factorize<'a> {
    factor: &'a mut Factor,
    symbolic: &'a Symbolic,
    matrix: &'a SymmetricSparse,
    shift: f64,
    workspace: &'a mut Workspace,
}

impl Kernel for Factorize<'_> {
    type Output = Result<(), ZeroPivot>;

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) -> Self::Output {
        let Self { factor, symbolic, matrix, shift, workspace } = self;
        let largest = (0..matrix.size())
            .map(|j| matrix.column(j).find(|(i, _)| *i == j).map_or(0.0, |(_, v)| v.abs()))
            .fold(shift.abs(), f64::max);
        let smallest = largest * 1e-15;
        workspace.waiting.clear();
        factor.below_shift = 0;
        let mut place = vec![0_u32; symbolic.size()];
        let mut pivots = Vec::new();
        // The fronts that wait for their parents: (supernode, where its complement is stored).
        let mut finished: Vec<(usize, usize)> = Vec::new();
        for (s, node) in symbolic.supernodes.iter().enumerate() {
            let size = node.width + node.below;
            let ld = stride(size);
            if workspace.front.len() < ld * ld {
                workspace.front.resize(ld * ld, 0.0);
            }
            if workspace.packed.len() < ld * node.width {
                workspace.packed.resize(ld * node.width, 0.0);
            }
            let front = &mut workspace.front[..ld * ld];
            for i in 0..size {
                front[i * ld..=i * ld + i].fill(0.0);
            }
            let rows = &symbolic.rows[node.rows_start..node.rows_start + node.below];
            for (at, &i) in rows.iter().enumerate() {
                place[i as usize] = (node.width + at) as u32;
            }
            let end = node.first + node.width;
            for j in node.first..end {
                let column = j - node.first;
                for (i, value) in matrix.column(j).filter(|(i, _)| *i >= j) {
                    let row = if i < end { i - node.first } else { place[i] as usize };
                    front[row * ld + column] += if i == j { value - shift } else { value };
                }
            }
            for _ in 0..node.children {
                let Some((child, start)) = finished.pop() else { continue };
                let child = &symbolic.supernodes[child];
                let into = &symbolic.into_parent[child.rows_start..child.rows_start + child.below];
                extend_add(front, ld, into, &workspace.waiting[start..]);
                workspace.waiting.truncate(start);
            }
            pivots.clear();
            pivots.resize(node.width, 0.0);
            let order = &mut factor.order[node.first..end];
            eliminate(lanes, front, size, node.width, &mut pivots, order, &mut workspace.packed, smallest)?;
            for (inverse, pivot) in factor.inverse_pivots[node.first..end].iter_mut().zip(&pivots) {
                *inverse = 1.0 / pivot;
                factor.below_shift += usize::from(*pivot < 0.0);
            }
            let stored = diagonal_len(node.width) + node.width * node.below;
            let values = &mut factor.values[node.values_start..node.values_start + stored];
            pack(front, ld, node.width, size, values);
            if node.below > 0 {
                finished.push((s, workspace.waiting.len()));
                for i in node.width..size {
                    workspace.waiting.extend_from_slice(&front[i * ld + node.width..=i * ld + i]);
                }
            }
        }
        Ok(())
    }
}

/// Adds the complement of a child (lower triangle, row by row) to its places in the front.
#[inline(always)]
fn extend_add(front: &mut [f64], ld: usize, into: &[u32], complement: &[f64]) {
    let mut at = 0;
    for (i, &row) in into.iter().enumerate() {
        let source = &complement[at..=at + i];
        let target = &mut front[row as usize * ld..row as usize * ld + ld];
        for (value, &column) in source.iter().zip(into) {
            target[column as usize] += value;
        }
        at += i + 1;
    }
}
