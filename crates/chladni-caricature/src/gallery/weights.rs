//! How much of each part the layers of a variant take.

use std::sync::Arc;

use rayon::prelude::*;

use super::variant::{Group, Variant};

/// Parts whose number is nearer to 0 neither grow nor shrink.
pub(super) const STIR: f32 = 0.35;
/// χ01 of the main layer where a part's number is 0.
const NEUTRAL: f32 = 0.4;

/// χ01 as a constant and a factor for each part.
pub(super) struct Weights {
    pub main: (f32, Vec<f32>),
    pub more: (f32, Vec<f32>),
    pub less: (f32, Vec<f32>),
}

impl Weights {
    pub fn of(variant: &Variant, parts: usize) -> Self {
        let numbers = variant.genes(Group::Parts);
        let of =
            |f: fn(f32) -> f32| (0..parts).map(|part| f(numbers.get(part).copied().unwrap_or(0.0))).collect();
        // A part at 1 is exaggerated wholly, one at −1 not at all.
        let main = |x: f32| if x > 0.0 { x * (1.0 - NEUTRAL) } else { x * NEUTRAL };
        let stirred = |x: f32| ((x - STIR) / (1.0 - STIR)).max(0.0);
        let neutral = if parts == 0 { 1.0 } else { NEUTRAL };
        Self {
            main: (neutral, of(main)),
            more: (0.0, of(stirred)),
            less: (0.0, of(|x| ((-x - STIR) / (1.0 - STIR)).max(0.0))),
        }
    }

    pub fn at((constant, factors): &(f32, Vec<f32>), parts: &[Arc<[f32]>], v: usize) -> f32 {
        factors.iter().zip(parts).fold(*constant, |sum, (w, part)| sum + w * part[v])
    }

    pub fn sum(weights: &(f32, Vec<f32>), parts: &[Arc<[f32]>], n: usize) -> Vec<f32> {
        (0..n).into_par_iter().map(|v| Self::at(weights, parts, v)).collect()
    }
}
