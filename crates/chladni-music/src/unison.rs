//! Harmonics that sound together: those of one eigenvalue, whose basis is arbitrary.

use std::ops::Range;

use chladni_harmonics::Basis;

use crate::Class;
use crate::symmetry::repeated;

/// Runs of harmonics of one repeated eigenvalue and one class, which cover all K in order; most hold a single
/// harmonic.
///
/// Σ H_k x̃_k over a run does not change when its harmonics are rotated among each other or change sign, so
/// the movement of a run in unison depends on the shape alone.
pub(crate) fn unisons(basis: &Basis, classes: &[Class], gap: f64) -> Vec<Range<usize>> {
    let mut runs: Vec<Range<usize>> = Vec::new();
    for group in repeated(basis, gap) {
        let first = group.start;
        for k in group {
            match runs.last_mut() {
                Some(run) if run.start >= first && classes[run.start] == classes[k] => run.end = k + 1,
                _ => runs.push(k..k + 1),
            }
        }
    }
    runs
}
