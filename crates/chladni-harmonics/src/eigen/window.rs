//! One run around a shift: what it must find, what it found, and why it stopped.

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

/// The part of the spectrum that one run must find around its shift.
#[derive(Clone, Copy, Debug)]
pub(super) struct Window {
    pub below: Reach,
    pub above: Reach,
    /// Whether zero lies in the window: then its known eigenvectors are deflated.
    pub from_zero: bool,
    /// The width of the window in λ.
    pub width: f64,
    /// The expected number of pairs, which only decides when to check convergence first.
    pub expected: usize,
}

/// Converged pairs nearest to a shift, without gaps on either side as far as Lanczos can tell.
#[derive(Debug, Default)]
pub(super) struct Pairs {
    /// Eigenvalues, ascending.
    pub values: Vec<f64>,
    /// The orthonormal vectors, BLOCK to a block, in the order of `values`. The last block is padded with
    /// zeros.
    pub blocks: Blocks,
}

/// Why a run stopped without finding its pairs.
#[derive(Debug)]
pub(super) enum Stopped {
    Cancelled,
    /// The shift is too close to an eigenvalue, or the factorization lost its precision.
    BadShift,
    /// The space was exhausted before the window had converged.
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
