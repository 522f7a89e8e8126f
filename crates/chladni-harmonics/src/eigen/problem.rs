//! The symmetric problem A x = λ x that slices work on, A = M^-½ S M^-½ in elimination order.

use std::sync::{Mutex, PoisonError};

use super::lanczos::Window;
use super::tall::Blocks;
use crate::ldlt::{Row, Symbolic, nested_dissection};
use crate::{Operator, SolveProfile, SymmetricSparse};

/// Spare blocks that are given out at once.
const AT_ONCE: usize = 8;

/// What all slices share.
pub(super) struct Problem {
    pub symbolic: Symbolic,
    /// A, permuted.
    pub matrix: SymmetricSparse,
    /// √a of each vertex, permuted.
    pub root_mass: Vec<f64>,
    /// a of each vertex, permuted.
    pub mass: Vec<f64>,
    /// The component of each vertex, permuted.
    component: Vec<u32>,
    /// The area of each component.
    component_area: Vec<f64>,
    /// Σ a.
    pub area: f64,
    /// Blocks that finished slices have no more use for: fresh memory costs faults.
    spare: Mutex<Vec<Blocks>>,
}

/// Seconds of one thread in each part of the work.
pub(super) type Profile = SolveProfile;

impl Problem {
    pub(super) fn of(operator: &Operator) -> Self {
        let old = nested_dissection(&operator.stiffness);
        let symbolic = Symbolic::of(&operator.stiffness, old);
        let inverse_root: Vec<f64> = operator.mass.iter().map(|a| a.sqrt().recip()).collect();
        let matrix = operator.stiffness.permuted_and_scaled(&symbolic.old, &inverse_root);
        let mass: Vec<f64> = symbolic.old.iter().map(|&v| operator.mass[v as usize]).collect();
        let component: Vec<u32> = symbolic.old.iter().map(|&v| operator.component[v as usize]).collect();
        let mut component_area = vec![0.0; operator.components()];
        for (c, a) in component.iter().zip(&mass) {
            component_area[*c as usize] += a;
        }
        Self {
            symbolic,
            matrix,
            root_mass: mass.iter().map(|a| a.sqrt()).collect(),
            area: mass.iter().sum(),
            mass,
            component,
            component_area,
            spare: Mutex::default(),
        }
    }

    /// A few blocks of n rows with anything in them.
    pub(super) fn spare_blocks(&self) -> Blocks {
        let spare = self.spare.lock().unwrap_or_else(PoisonError::into_inner).pop();
        spare.unwrap_or_else(|| Blocks::untouched(self.matrix.size(), AT_ONCE))
    }

    /// Frees the spare blocks.
    pub(super) fn free_spare_blocks(&self) {
        self.spare.lock().unwrap_or_else(PoisonError::into_inner).clear();
    }

    /// Takes spare blocks that are not needed any more.
    pub(super) fn give_back(&self, blocks: Vec<Blocks>) {
        self.spare.lock().unwrap_or_else(PoisonError::into_inner).extend(blocks);
    }

    /// How many eigenvalues are exactly 0, each with a vector known in closed form: √a on one
    /// component, 0 elsewhere.
    pub(super) fn components(&self) -> usize {
        self.component_area.len()
    }

    /// The residual ‖A x − λ x‖ at which a pair counts as converged: small beside λ, for the
    /// pair's own sake, and beside the width of the window, because the overlap of vectors
    /// from different windows is at most the sum of their residuals over the distance of
    /// their eigenvalues.
    pub(super) fn tolerance(&self, lambda: f64, shift: f64, window: &Window) -> f64 {
        (2e-10 * lambda.abs()).min(2e-9 * window.width.max((lambda - shift).abs()))
    }

    /// Where the window reaches down to zero: makes each column orthogonal to the vectors of
    /// λ = 0.
    pub(super) fn remove_constants(&self, from_zero: bool, x: &mut [Row]) {
        if !from_zero {
            return;
        }
        let mut sums = vec![[0.0; 8]; self.components()];
        for ((x, &c), &root) in x.iter().zip(&self.component).zip(&self.root_mass) {
            for (sum, x) in sums[c as usize].iter_mut().zip(x) {
                *sum += root * x;
            }
        }
        for (sum, area) in sums.iter_mut().zip(&self.component_area) {
            sum.iter_mut().for_each(|s| *s /= area);
        }
        for ((x, &c), &root) in x.iter_mut().zip(&self.component).zip(&self.root_mass) {
            for (x, sum) in x.iter_mut().zip(&sums[c as usize]) {
                *x -= root * sum;
            }
        }
    }

    /// h of λ = 0 on component `c`, in the original order: 1/√area there.
    pub(super) fn constant(&self, operator: &Operator, c: usize) -> impl Iterator<Item = f64> {
        let value = self.component_area[c].sqrt().recip();
        operator.component.iter().map(move |&of| if of as usize == c { value } else { 0.0 })
    }
}
