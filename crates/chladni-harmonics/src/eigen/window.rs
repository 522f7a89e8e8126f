//! What one run has to find around its shift, what it found, and why it stopped.

use chladni_task::Cancelled;

use super::tall::Blocks;
use crate::HarmonicsError;

/// How far a run must go on one side of its shift.
#[derive(Clone, Copy, Debug)]
pub(super) enum Reach {
    /// Everything up to this eigenvalue, and the first pair beyond it, must converge.
    Beyond(f64),
    /// This many pairs must converge.
    Count(usize),
}

/// What one run has to find around its shift.
#[derive(Clone, Copy, Debug)]
pub(super) struct Window {
    pub below: Reach,
    pub above: Reach,
    /// Zero lies in the window: its known eigenvectors are deflated.
    pub from_zero: bool,
    /// How wide the window is in λ.
    pub width: f64,
    /// How many pairs are expected, which only decides when to check first.
    pub expected: usize,
}

/// Converged pairs nearest to a shift, without gaps on either side as far as Lanczos can tell.
#[derive(Debug, Default)]
pub(super) struct Pairs {
    /// Eigenvalues, ascending.
    pub values: Vec<f64>,
    /// Their orthonormal vectors, BLOCK to a block in the order of `values`; the last block
    /// is filled up with zeros.
    pub blocks: Blocks,
}

/// Why a run stopped without its pairs.
#[derive(Debug)]
pub(super) enum Stopped {
    Cancelled,
    /// The shift is too close to an eigenvalue, or the factorization lost its precision.
    BadShift,
    /// The space was used up before the window had converged.
    Exhausted,
}

impl From<Cancelled> for Stopped {
    fn from(_: Cancelled) -> Self {
        Self::Cancelled
    }
}

impl From<Stopped> for HarmonicsError {
    fn from(stopped: Stopped) -> Self {
        match stopped {
            Stopped::Cancelled => Self::Cancelled(Cancelled),
            Stopped::BadShift => Self::not_certified("no shift near the planned one could be factored"),
            Stopped::Exhausted => {
                Self::not_certified("the Krylov space was used up before all pairs had converged")
            }
        }
    }
}
