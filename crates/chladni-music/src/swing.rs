//! Which way harmonics swing when sound comes from one side, and which of them swing together.

use chladni_harmonics::{Body, canonical};
use rayon::prelude::*;

use crate::sides::Sides;
use crate::{Class, symmetry};

/// Partners are searched among this many neighbors in frequency on either side.
const NEIGHBORS: usize = 24;
/// The least agreement of partners; 1 is perfect.
const LEAST_AGREEMENT: f64 = 0.05;
/// A lean below this share of the largest possible one is rounding.
const LEAST_LEAN: f64 = 1e-3;

/// The sign and the partner of each harmonic in the modal form.
///
/// An eigenvector's sign is arbitrary. Here antisymmetric harmonics swing outward on the left on average:
/// ⟨H_a, χ_L − χ_R⟩ > 0. A symmetric one agrees on the left, and so disagrees on the right, with its partner:
/// the antisymmetric one of largest |⟨H_s, (χ_L − χ_R) H_a⟩| / (‖H_s‖ ‖H_a‖) ω_</ω_>, where ω_< ≤ ω_> are the
/// frequencies of the two, and each product is that of the movements, under the form's mask. The partner of an
/// antisymmetric one is the symmetric one that it then agrees with most. Both together, equally loud, move the
/// left half and leave the right one at rest.
#[derive(Clone, Debug)]
pub(crate) struct Swing {
    signs: Vec<f32>,
    partners: Vec<Option<u32>>,
}

impl Swing {
    /// `mask`: that of movements along the normal, N values.
    pub fn of(body: &Body, classes: &[Class], sides: &Sides, mask: &[f32]) -> Self {
        let basis = &*body.basis;
        let count = basis.harmonics();
        let first = symmetry::first_waving(&basis.eigenvalues);
        let moving: Vec<f64> = basis.mass.iter().zip(mask).map(|(a, m)| a * f64::from(m * m)).collect();
        let weights: Vec<f64> = (sides.left.iter().zip(&*sides.right).zip(&moving))
            .map(|((l, r), a)| a * f64::from(l - r))
            .collect();
        let sizes: Vec<f64> = (0..count)
            .into_par_iter()
            .map(|k| basis.harmonic(k).iter().zip(&moving).map(|(h, a)| a * h * h).sum::<f64>().sqrt())
            .collect();
        let area: f64 = basis.mass.iter().sum();
        let mut signs: Vec<f64> = (0..count)
            .into_par_iter()
            .map(|k| {
                let h = basis.harmonic(k);
                let lean: f64 = h.iter().zip(&weights).map(|(h, w)| h * w).sum();
                let leans = classes[k] == Class::Antisymmetric && lean.abs() > LEAST_LEAN * area.sqrt();
                let turned = if leans { lean < 0.0 } else { canonical::is_turned(h, &body.positions) };
                if turned { -1.0 } else { 1.0 }
            })
            .collect();
        // ⟨H_k, (χ_L − χ_R) H_j⟩ ω_</ω_> with the neighbors of the other class.
        let neighbors = |k: usize| k.saturating_sub(NEIGHBORS).max(first)..(k + NEIGHBORS + 1).min(count);
        let agreements: Vec<Vec<(usize, f64)>> = (0..count)
            .into_par_iter()
            .map(|k| {
                let others =
                    neighbors(k).filter(|&j| k >= first && classes[j].sign() * classes[k].sign() < 0);
                let size = |j: usize| (sizes[k] * sizes[j]).max(f64::MIN_POSITIVE);
                others.map(|j| (j, agreement(body, &weights, k, j) / size(j))).collect()
            })
            .collect();
        let mut partners = vec![None; count];
        for (k, agreements) in agreements.iter().enumerate() {
            let sizes = agreements.iter().map(|&(j, agreement)| (j, agreement.abs(), agreement.signum()));
            if let Some((j, _, sign)) = clearly_best(sizes)
                && classes[k] == Class::Symmetric
            {
                signs[k] = signs[j] * sign;
                partners[k] = Some(j as u32);
            }
        }
        for (k, agreements) in agreements.iter().enumerate() {
            let signed = agreements.iter().map(|&(j, agreement)| (j, agreement * signs[j] * signs[k], 1.0));
            if let Some((j, ..)) = clearly_best(signed)
                && classes[k] == Class::Antisymmetric
            {
                partners[k] = Some(j as u32);
            }
        }
        Self { signs: signs.into_iter().map(|sign| sign as f32).collect(), partners }
    }

    /// 1, or −1 where the sign of harmonic k is to be changed.
    pub fn sign(&self, k: u32) -> f32 {
        self.signs[k as usize]
    }

    /// The harmonic of the other class that swings with harmonic k.
    pub fn partner(&self, k: u32) -> Option<u32> {
        self.partners[k as usize]
    }
}

/// Harmonic, agreement and sign of the best one; among several that are equal to within rounding, the first.
fn clearly_best(agreements: impl Iterator<Item = (usize, f64, f64)>) -> Option<(usize, f64, f64)> {
    agreements.fold(None, |best: Option<(usize, f64, f64)>, one| {
        let least = best.map_or(LEAST_AGREEMENT, |best| best.1 * (1.0 + 1e-6));
        if one.1 > least { Some(one) } else { best }
    })
}

fn agreement(body: &Body, weights: &[f64], k: usize, j: usize) -> f64 {
    let basis = &*body.basis;
    let product: f64 =
        (basis.harmonic(k).iter().zip(basis.harmonic(j)).zip(weights)).map(|((a, b), w)| a * b * w).sum();
    let (low, high) = (k.min(j), k.max(j));
    product * (basis.eigenvalues[low] / basis.eigenvalues[high]).sqrt()
}
