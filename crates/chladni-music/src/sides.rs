//! Two half-masks, so that left and right can move apart.

use std::sync::Arc;

use chladni_harmonics::Body;

use crate::Class;

/// χ_L and χ_R = 1 − χ_L: a smooth step across the plane in which the shape is its own mirror.
///
/// "Left" is the viewer's left when the shape faces the viewer along +z with +y up: the side
/// of smaller x. Where the halves do not differ in x, it is the side of smaller z, else y.
#[derive(Clone, Debug)]
pub struct Sides {
    /// χ_L, N values in [0, 1].
    pub left: Arc<[f32]>,
    /// χ_R, N values in [0, 1]; χ_L + χ_R = 1.
    pub right: Arc<[f32]>,
    /// What the step was taken of.
    pub source: SideSource,
}

/// Where the half-masks of a body come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SideSource {
    /// The leading antisymmetric harmonic, k.
    Harmonic(usize),
    /// The x coordinate, because no antisymmetric harmonic tells two halves apart.
    Coordinate,
}

/// Half the width of the step, as a share of the signal's root mean square.
const STEP: f64 = 0.25;

impl Sides {
    pub(crate) fn of(body: &Body, classes: &[Class]) -> Self {
        let n = body.positions.len();
        // The leading one is the slowest that has one nodal line between two halves of equal
        // area: |Σ a sign(H)| small is given by antisymmetry, the two halves must lie apart.
        let leading =
            (1..classes.len().min(40)).filter(|&k| classes[k] == Class::Antisymmetric).max_by(|&i, &j| {
                separation(body, body.basis.harmonic(i)).total_cmp(&separation(body, body.basis.harmonic(j)))
            });
        let leading = leading.filter(|&k| separation(body, body.basis.harmonic(k)) > 0.3);
        let (signal, source) = match leading {
            Some(k) => (body.basis.harmonic(k).to_vec(), SideSource::Harmonic(k)),
            None => (body.positions.iter().map(|p| p[0]).collect(), SideSource::Coordinate),
        };
        let apart = halves_apart(body, &signal);
        let axis = [0, 2, 1].into_iter().find(|&i| apart[i].abs() > 0.05).unwrap_or(0);
        let sign = if apart[axis] > 0.0 { -1.0 } else { 1.0 };
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

/// Mean position where the signal is positive minus that where it is negative, weighted by
/// area and by the signal's size.
fn halves_apart(body: &Body, signal: &[f64]) -> [f64; 3] {
    let mut sums = [[0.0; 3]; 2];
    let mut weights = [0.0; 2];
    for ((p, h), a) in body.positions.iter().zip(signal).zip(&body.basis.mass) {
        let side = usize::from(*h < 0.0);
        weights[side] += a * h.abs();
        for i in 0..3 {
            sums[side][i] += a * h.abs() * p[i];
        }
    }
    std::array::from_fn(|i| {
        sums[0][i] / weights[0].max(f64::MIN_POSITIVE) - sums[1][i] / weights[1].max(f64::MIN_POSITIVE)
    })
}

/// How well one plane parts the signal's positive half from its negative one: the correlation
/// of its sign with the coordinate along the line between the two halves, weighted by area.
fn separation(body: &Body, signal: &[f64]) -> f64 {
    let d = halves_apart(body, signal);
    let length = (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).sqrt();
    if length <= 0.0 {
        return 0.0;
    }
    let (mut agree, mut total) = (0.0, 0.0);
    for ((p, h), a) in body.positions.iter().zip(signal).zip(&body.basis.mass) {
        let along = (p[0] * d[0] + p[1] * d[1] + p[2] * d[2]) / length;
        agree += a * along * h.signum();
        total += a * along.abs();
    }
    agree / total.max(f64::MIN_POSITIVE)
}
