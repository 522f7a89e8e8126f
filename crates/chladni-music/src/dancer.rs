//! A body made ready to dance: what every frame needs to know of it.

use std::ops::Range;

use chladni_harmonics::{Basis, Body};
use chladni_synth::Residual;
use rayon::prelude::*;

use crate::probes::Probes;
use crate::sides::Sides;
use crate::swing::Swing;
use crate::unison::unisons;
use crate::{Class, Error, SymmetrySettings};

/// What the mappings of all items share of one body. Working frame.
#[derive(Clone, Debug)]
pub struct Dancer {
    /// λ_k, K values.
    pub eigenvalues: Vec<f64>,
    /// x̃_k: the harmonic transform of the rest positions.
    pub spectrum: Vec<[f32; 3]>,
    /// max_v |H_k(v)|: how far one unit of c_k moves the most moved vertex.
    pub reach: Vec<f32>,
    /// Whether H_k is symmetric, antisymmetric or neither.
    pub classes: Vec<Class>,
    /// χ_L and χ_R.
    pub sides: Sides,
    /// dx: the part of the rest positions above K.
    pub residual: Residual,
    /// Diagonal of the bounding box, the yardstick of every displacement.
    pub box_diagonal: f32,
    pub(crate) probes: Probes,
    pub(crate) swing: Swing,
    /// For each harmonic those that it sounds together with.
    unisons: Vec<Range<u32>>,
    /// For each harmonic, max_v |Σ H_k(v) x̃_k| over its unison.
    filter_reach: Vec<f32>,
}

impl Dancer {
    /// Prepares `body`, whose harmonics have `classes` (K of them, see
    /// [`Symmetry`](crate::Symmetry)).
    ///
    /// Errors if the counts differ, or if there is no harmonic or no vertex.
    pub fn new(body: &Body, classes: &[Class]) -> Result<Self, Error> {
        let basis = &*body.basis;
        let k = basis.harmonics();
        if classes.len() != k {
            return Err(Error::Size { what: "symmetry classes", found: classes.len(), expected: k });
        }
        if k == 0 || basis.vertices() == 0 {
            return Err(Error::Size { what: "harmonics", found: k, expected: 1 });
        }
        if body.positions.len() != basis.vertices() {
            return Err(Error::Size {
                what: "positions",
                found: body.positions.len(),
                expected: basis.vertices(),
            });
        }
        let spectrum64 = basis.transform3(&body.positions);
        let smooth = basis.synthesize3(&spectrum64);
        let residual = body
            .positions
            .iter()
            .zip(&smooth)
            .map(|(x, s)| std::array::from_fn(|i| (x[i] - s[i]) as f32))
            .collect();
        let reach: Vec<f32> = (0..k)
            .into_par_iter()
            .map(|k| basis.harmonic(k).iter().fold(0.0, |m: f64, h| m.max(h.abs())) as f32)
            .collect();
        let spectrum: Vec<[f32; 3]> = spectrum64.iter().map(|x| x.map(|c| c as f32)).collect();
        let runs = unisons(basis, classes, SymmetrySettings::default().cluster_gap);
        let unison_reach: Vec<f32> =
            runs.par_iter().map(|run| farthest_in_unison(basis, &spectrum64, run.clone())).collect();
        let unisons = runs.iter().flat_map(|run| vec![run.start as u32..run.end as u32; run.len()]).collect();
        let filter_reach: Vec<f32> =
            runs.iter().zip(&unison_reach).flat_map(|(run, &reach)| vec![reach; run.len()]).collect();
        let sides = Sides::of(body, classes);
        Ok(Self {
            eigenvalues: basis.eigenvalues.clone(),
            swing: Swing::of(body, classes, &sides),
            sides,
            probes: Probes::new(body, &filter_reach),
            spectrum,
            reach,
            classes: classes.to_vec(),
            residual: Residual::Vector(residual),
            box_diagonal: box_diagonal(&body.positions),
            unisons,
            filter_reach,
        })
    }

    /// K.
    pub fn harmonics(&self) -> usize {
        self.eigenvalues.len()
    }

    /// What has to fit into the picture: the rest positions, each moved away from the origin as
    /// far as a `limit` of displacement (a share of the bounding box's diagonal) allows.
    pub fn room(&self, rest_positions: &[[f32; 3]], limit: f32) -> Vec<[f32; 3]> {
        let outwards = limit * self.box_diagonal;
        rest_positions.iter().map(|&p| p.map(|c| c * (1.0 + outwards / length(p).max(1e-6)))).collect()
    }

    /// How far the most moved vertex goes when harmonic k, and what it sounds together with, is
    /// amplified by 1 in the filter form.
    pub fn filter_reach(&self, k: usize) -> f32 {
        self.filter_reach[k]
    }

    /// Harmonic k and those of the same eigenvalue and class: which of them is which is a matter of
    /// choice, so that the filter form lets them sound as one.
    pub(crate) fn unison(&self, k: u32) -> Range<u32> {
        self.unisons[k as usize].clone()
    }
}

/// max_v |Σ H_k(v) x̃_k| over a run of harmonics.
fn farthest_in_unison(basis: &Basis, spectrum: &[[f64; 3]], run: Range<usize>) -> f32 {
    let mut sum = vec![[0.0f64; 3]; basis.vertices()];
    for k in run {
        for (sum, h) in sum.iter_mut().zip(basis.harmonic(k)) {
            *sum = std::array::from_fn(|i| sum[i] + h * spectrum[k][i]);
        }
    }
    sum.iter().map(|d| d.iter().map(|c| c * c).sum::<f64>()).fold(0.0, f64::max).sqrt() as f32
}

fn length(v: [f32; 3]) -> f32 {
    (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt()
}

pub(crate) fn box_diagonal(positions: &[[f64; 3]]) -> f32 {
    let mut low = [f64::MAX; 3];
    let mut high = [f64::MIN; 3];
    for p in positions {
        for i in 0..3 {
            low[i] = low[i].min(p[i]);
            high[i] = high[i].max(p[i]);
        }
    }
    (0..3).map(|i| (high[i] - low[i]).powi(2)).sum::<f64>().sqrt() as f32
}
