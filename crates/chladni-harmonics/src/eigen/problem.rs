//! The symmetric problem A x = λ x of the slices: A = M^-½ S M^-½ in elimination order.
//!
//! A mass matrix that is not diagonal is scaled by its diagonal D instead: A = D^-½ S D^-½ and B = D^-½ M
//! D^-½ = G Gᵀ, and the problem is G⁻¹ A G⁻ᵀ x = λ x. Vectors stay orthonormal in the plain sense, and only
//! factorization, solves, residuals and the last transformation need to know about B.

use std::sync::{Mutex, PoisonError};

use super::metric::Metric;
use super::tall;
use super::tall::Blocks;
use super::window::Window;
use crate::ldlt::{Factor, Row, Symbolic, Workspace, ZeroPivot, nested_dissection};
use crate::{HarmonicsError, Pencil, SolveProfile, SymmetricSparse, pages};

/// Spare blocks are handed out together if this many of them fill large pages, and otherwise one by one,
/// which was 6 to 12 % faster with 3,000 to 5,000 vertices and four threads.
const AT_ONCE: usize = 8;

/// Counts resolve eigenvalues down to this share of ‖A‖.
const RESOLVED: f64 = 1e-13;

/// How many eigenvalues of a connected surface are exactly 0: one, with the vector √a.
pub(super) const ZEROS: usize = 1;

/// The data that all slices share.
pub(super) struct Problem {
    pub symbolic: Symbolic,
    /// A, permuted.
    pub matrix: SymmetricSparse,
    /// √a of each vertex, permuted.
    pub root_mass: Vec<f64>,
    /// a of each vertex, permuted.
    pub mass: Vec<f64>,
    /// B, if M is not diagonal.
    metric: Option<Metric>,
    /// How many eigenvalues are exactly 0 and known beforehand: [`ZEROS`] for a surface, none for a given
    /// pencil.
    pub zeros: usize,
    /// Σ a of a surface; for a given pencil, the area of a surface whose eigenvalues are as dense.
    pub area: f64,
    /// The largest A_vv.
    pub largest: f64,
    /// Blocks that finished slices no longer need; they are reused because fresh memory costs page faults.
    spare: Mutex<Vec<Blocks>>,
}

/// Seconds of thread time in each part of the work.
pub(super) type Profile = SolveProfile;

impl Problem {
    pub(super) fn of(pencil: Pencil) -> Self {
        let old = nested_dissection(pencil.stiffness);
        let symbolic = Symbolic::of(pencil.stiffness, old);
        let inverse_root: Vec<f64> = pencil.mass.iter().map(|a| a.sqrt().recip()).collect();
        let matrix = pencil.stiffness.permuted_and_scaled(&symbolic.old, &inverse_root);
        let mass: Vec<f64> = symbolic.old.iter().map(|&v| pencil.mass[v as usize]).collect();
        Self {
            symbolic,
            root_mass: mass.iter().map(|a| a.sqrt()).collect(),
            metric: None,
            zeros: ZEROS,
            area: mass.iter().sum(),
            mass,
            largest: matrix.largest_diagonal(),
            matrix,
            spare: Mutex::default(),
        }
    }

    /// The same as the problem of a general `pencil`.
    ///
    /// # Errors
    /// M is not diagonal, and not positive definite or nearly singular.
    pub(super) fn given(self, pencil: Pencil) -> Result<Self, HarmonicsError> {
        let mut problem = Self { zeros: 0, ..self };
        if let Some(consistent) = pencil.consistent {
            let inverse_root: Vec<f64> = pencil.mass.iter().map(|a| a.sqrt().recip()).collect();
            let matrix = consistent.permuted_and_scaled(&problem.symbolic.old, &inverse_root);
            problem.metric = Some(Metric::of(matrix, &problem.symbolic)?);
        }
        Ok(problem)
    }

    /// A factor by which an eigenvalue may exceed those of D⁻¹ S, where D is the diagonal of M.
    pub(super) fn stretch(&self) -> f64 {
        self.metric.as_ref().map_or(1.0, |metric| metric.stretch)
    }

    /// Rounding is not expected to move a count by more than this along the spectrum.
    pub(super) fn resolved(&self) -> f64 {
        RESOLVED * self.largest * self.stretch()
    }

    /// Factors A − σB.
    pub(super) fn factor(
        &self,
        factor: &mut Factor,
        shift: f64,
        workspace: &mut Workspace,
    ) -> Result<(), ZeroPivot> {
        match &self.metric {
            None => factor.compute(&self.symbolic, &self.matrix, shift, workspace),
            Some(metric) => {
                let shifted = self.matrix.plus(&metric.matrix, -shift);
                factor.compute(&self.symbolic, &shifted, 0.0, workspace)
            }
        }
    }

    /// x ← (A − σI)⁻¹ x, or Gᵀ (A − σB)⁻¹ G x, given the `factor` at the shift.
    pub(super) fn solve(&self, factor: &Factor, x: &mut [Row]) {
        match &self.metric {
            None => factor.solve(&self.symbolic, x),
            Some(metric) => metric.solve(&self.symbolic, factor, x),
        }
    }

    /// For each column x with value λ: ‖A x − λ x‖² of the symmetric problem, and Σ a r² and Σ a s² for the
    /// residual r and the image s in S h = λ M h.
    pub(super) fn residuals(&self, x: &[Row], values: &Row) -> [Row; 3] {
        match &self.metric {
            None => tall::residuals(&self.matrix, x, values, &self.mass),
            Some(metric) => metric.residuals(&self.symbolic, &self.matrix, x, values, &self.mass),
        }
    }

    /// x ← G⁻ᵀ x. After this, only a factor of 1/√a per row is left to apply.
    pub(super) fn untransform(&self, x: &mut [Row]) {
        if let Some(metric) = &self.metric {
            metric.untransform(&self.symbolic, x);
        }
    }

    /// Adds `lift` to all eigenvalues; it is about their mean distance.
    pub(super) fn lift(&mut self, lift: f64) {
        self.matrix = match &self.metric {
            None => self.matrix.plus_diagonal(&vec![1.0; self.mass.len()], lift),
            Some(metric) => self.matrix.plus(&metric.matrix, lift),
        };
        self.largest += lift;
        self.expect_spacing(lift);
    }

    /// Sets the approximate distance of the eigenvalues: Weyl's law, solved for the area.
    pub(super) fn expect_spacing(&mut self, spacing: f64) {
        self.area = 4.0 * std::f64::consts::PI / spacing;
    }

    /// A few blocks of n rows with arbitrary contents.
    pub(super) fn spare_blocks(&self) -> Blocks {
        let spare = self.spare.lock().unwrap_or_else(PoisonError::into_inner).pop();
        let n = self.matrix.size();
        let count = if AT_ONCE * n * size_of::<Row>() >= pages::LARGE { AT_ONCE } else { 1 };
        spare.unwrap_or_else(|| Blocks::untouched(n, count))
    }

    /// Frees the spare blocks.
    pub(super) fn free_spare_blocks(&self) {
        self.spare.lock().unwrap_or_else(PoisonError::into_inner).clear();
    }

    /// Takes back blocks that are not needed any more.
    pub(super) fn give_back(&self, blocks: Vec<Blocks>) {
        self.spare.lock().unwrap_or_else(PoisonError::into_inner).extend(blocks);
    }

    /// The residual ‖A x − λ x‖ at which a pair counts as converged. It is small relative to λ, for the
    /// pair's own accuracy, and relative to the width of the window, because the overlap of vectors from
    /// different windows is at most the sum of their residuals divided by the distance of their
    /// eigenvalues.
    pub(super) fn tolerance(&self, lambda: f64, shift: f64, window: &Window) -> f64 {
        (2e-10 * lambda.abs()).min(2e-9 * window.width.max((lambda - shift).abs()))
    }

    /// If the window reaches down to zero, makes each column orthogonal to the vector of λ = 0.
    pub(super) fn remove_constants(&self, from_zero: bool, x: &mut [Row]) {
        if !from_zero || self.zeros == 0 {
            return;
        }
        let mut sums = [0.0; 8];
        for (x, &root) in x.iter().zip(&self.root_mass) {
            for (sum, x) in sums.iter_mut().zip(x) {
                *sum += root * x;
            }
        }
        let means = sums.map(|sum| sum / self.area);
        for (x, &root) in x.iter_mut().zip(&self.root_mass) {
            for (x, mean) in x.iter_mut().zip(&means) {
                *x -= root * mean;
            }
        }
    }
}
