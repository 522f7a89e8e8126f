//! Two half-masks, so that left and right can move apart.

use std::sync::Arc;

use chladni_harmonics::Body;
use chladni_mesh::Orientation;

use crate::Class;

/// χ_L and χ_R = 1 − χ_L: a smooth step across the plane in which the shape is its own mirror.
///
/// "Left" is the viewer's left in front of the shape as it stands: with y up and z in front, the side of smaller x.
/// A shape without a mirror plane between the viewer's left and right, such as an animal seen from the side, is
/// divided in its middle.
#[derive(Clone, Debug)]
pub struct Sides {
    /// χ_L, N values in [0, 1].
    pub left: Arc<[f32]>,
    /// χ_R, N values in [0, 1]; χ_L + χ_R = 1.
    pub right: Arc<[f32]>,
    /// The signal that the step was made from.
    pub source: SideSource,
}

/// Where the half-masks of a body come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SideSource {
    /// The leading antisymmetric harmonic, k.
    Harmonic(usize),
    /// How far to the viewer's right a vertex lies, because no antisymmetric harmonic tells the viewer's halves apart.
    Coordinate,
}

/// Half the width of the step, as a share of the signal's root mean square.
const STEP: f64 = 0.28;
/// The least correlation with the viewer's sides of a signal that separates them.
const PARTED: f64 = 0.9;

impl Sides {
    pub(crate) fn of(body: &Body, classes: &[Class], stands: &Orientation) -> Self {
        let right = stands.right();
        let across: Vec<f64> = body.positions.iter().map(|p| (0..3).map(|i| right[i] * p[i]).sum()).collect();
        let n = body.positions.len();
        // An antisymmetric harmonic divides the shape along its mirror plane; of those that separate the
        // viewer's left and right, the slowest has the fewest nodal lines.
        let parts = |k: &usize| parting(body, &across, body.basis.harmonic(*k)).abs() > PARTED;
        let leading = (1..classes.len().min(40)).filter(|&k| classes[k] == Class::Antisymmetric).find(parts);
        let (signal, source) = match leading {
            Some(k) => (body.basis.harmonic(k).to_vec(), SideSource::Harmonic(k)),
            None => (across.clone(), SideSource::Coordinate),
        };
        let sign = if parting(body, &across, &signal) > 0.0 { -1.0 } else { 1.0 };
        let area: f64 = body.basis.mass.iter().sum();
        let mean_square = signal.iter().zip(&body.basis.mass).map(|(h, a)| a * h * h).sum::<f64>()
            / area.max(f64::MIN_POSITIVE);
        let width = STEP * mean_square.sqrt().max(f64::MIN_POSITIVE);
        let mut left = Vec::with_capacity(n);
        for h in &signal {
            let x = (sign * h / width * 0.5 + 0.5).clamp(0.0, 1.0);
            left.push((x * x * (3.0 - 2.0 * x)) as f32);
        }
        let right = left.iter().map(|l| 1.0 - l).collect();
        Self { left: left.into(), right, source }
    }
}

/// How well the signal's sign separates the viewer's right half from the left: the correlation with the sign
/// of x across the shape, weighted by area and |x|, in [−1, 1].
fn parting(body: &Body, across: &[f64], signal: &[f64]) -> f64 {
    let (mut agree, mut total) = (0.0, 0.0);
    for ((x, h), a) in across.iter().zip(signal).zip(&body.basis.mass) {
        agree += a * x * h.signum();
        total += a * x.abs();
    }
    agree / total.max(f64::MIN_POSITIVE)
}
