//! Φ_{t,a}: which sound band drives which harmonic, and how strongly.

use std::ops::Range;

use serde::{Deserialize, Serialize};

use crate::symmetry::{first_waving, spare_constants};
use crate::{Class, MusicError};

/// Finer harmonics have lines too close for a figure of sand.
const MOST_FIGURES: usize = 96;

/// The most bands or harmonics a stored mapping may have.
pub const MAX_GENES: usize = 1 << 14;

/// A mapping from sound to shape that belongs to no shape in particular (stereo-music paper,
/// section 4a and "Harmonic mapping re-use"): it plays on any number of bands and harmonics.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Mapping {
    /// t̄, one value in [0, 1] per sound band: band b of B stands for the stretch
    /// [b/B, (b+1)/B) of the frequency axis and drives harmonic round(t̄ (K − 1)).
    pub transfer: Vec<f32>,
    /// a as a function of k/K, each value in [−1, 1]: value i of A stands for [i/A, (i+1)/A). Only proportions
    /// count: the largest |a| of any driven harmonic acts as 1.
    pub amplification: Vec<f32>,
    /// μ in [0, 1]: 0 sends mid to symmetric and side to antisymmetric harmonics; 1 mixes them.
    pub stereo_mu: f32,
    /// Strength. At 1 a full-scale band moves the shape as far, or as steeply, as calibrated.
    pub gain: f32,
}

impl Mapping {
    /// The mapping that leaves every shape at rest: a ≡ 0.
    pub fn rest(bands: usize, harmonics: usize) -> Self {
        Self {
            transfer: vec![0.0; bands.max(1)],
            amplification: vec![0.0; harmonics.max(1)],
            stereo_mu: 0.0,
            gain: 1.0,
        }
    }

    /// The direct mapping for a shape: t_ini read at ω/2, so that the song drives the lower quarter of the
    /// harmonics; the lower a harmonic, the more it is amplified. Constant harmonics, of which a shape has one for
    /// each of its pieces, count as one. Pieces that are alike share the sound: where their harmonics differ little, bands
    /// take turns in driving them, and all are amplified alike.
    pub fn direct(eigenvalues: &[f64], bands: usize) -> Self {
        let k_count = eigenvalues.len().max(1);
        let spare = spare_constants(eigenvalues);
        // A quarter of fewer than five would be the constant one alone.
        let count = (k_count - spare).max(5);
        let groups = alike(eigenvalues);
        let amplification = groups
            .iter()
            .flat_map(|group| {
                let x = (4.0 * group.start.saturating_sub(spare) as f32 / count as f32).min(1.0);
                std::iter::repeat_n((1.0 - x) * (1.0 - x), group.len())
            })
            .collect();
        let transfer = direct_transfer(eigenvalues, bands.max(1), 0.5, false);
        let mapping = Self { transfer, amplification, stereo_mu: 0.0, gain: 1.0 };
        // The lowest of a group, which most bands would drive, moves one piece alone.
        let top = (k_count - 1).max(1) as f32;
        let in_turn = |(b, k): (usize, u32)| {
            let k = k as usize;
            let group = groups.get(groups.partition_point(|group| group.end <= k));
            group.map_or(k, |group| group.start + b % group.len()) as f32 / top
        };
        let transfer = mapping.targets(bands.max(1), k_count).into_iter().enumerate().map(in_turn).collect();
        let mapping = Self { transfer, ..mapping };
        Self { gain: mapping.even_gain(), ..mapping }
    }

    /// The mapping for sand. Going from the lowest band to the highest, it picks finer and finer harmonics in even
    /// steps, all equally amplified, so that a higher tone draws a finer figure. It uses only harmonics that answer
    /// to the middle (S) of the sound, except constant ones and the three coarsest others, which draw hardly any
    /// figure, and those whose lines are too close to tell apart.
    pub fn figures(eigenvalues: &[f64], classes: &[Class], bands: usize) -> Self {
        let (bands, top) = (bands.max(1), (classes.len().max(2) - 1) as f32);
        let answering = |k: &usize| classes[*k] != Class::Antisymmetric;
        let spare = spare_constants(eigenvalues);
        let end = classes.len().min(spare + MOST_FIGURES);
        let answering: Vec<usize> = (spare + 1..end).filter(answering).skip(3).collect();
        let transfer = (0..bands)
            .map(|b| answering.get(b * answering.len() / bands).map_or(1.0, |k| *k as f32 / top))
            .collect();
        let mapping =
            Self { transfer, amplification: vec![1.0; classes.len().max(1)], stereo_mu: 0.0, gain: 1.0 };
        Self { gain: mapping.even_gain(), ..mapping }
    }

    /// n^-¾, where n bands share the busiest harmonic that is amplified. At this gain a sound spread over
    /// them moves the shape about as far as one full-scale band does at gain 1: bands of music are neither
    /// all in step (1/n) nor independent (1/√n). Without it a mapping that sends the whole song to a few
    /// harmonics would always be at its limit.
    pub fn even_gain(&self) -> f32 {
        self.even_gain_on(self.transfer.len())
    }

    /// The gain on `bands` bands of sound: its own, in proportion to the even gain there, because more bands
    /// would otherwise drive each harmonic harder.
    pub(crate) fn gain_on(&self, bands: usize) -> f32 {
        self.gain * (self.even_gain_on(bands) / self.even_gain())
    }

    fn even_gain_on(&self, bands: usize) -> f32 {
        let answer = |k: u32| Some((k, *self.amplification.get(k as usize)?));
        let driven = self.targets(bands, self.amplification.len()).into_iter().filter_map(answer);
        busiest(driven).powf(EVENING)
    }

    /// The largest |a| of any driven harmonic, in [0, 1]: a mapping of loudness 0 is not moved by any sound.
    pub fn loudness(&self) -> f32 {
        self.loudness_from(0)
    }

    /// The same of the harmonics from `first` on.
    pub(crate) fn loudness_from(&self, first: u32) -> f32 {
        let driven = self.targets(self.transfer.len(), self.amplification.len()).into_iter();
        let answers = driven.filter(|k| *k >= first).filter_map(|k| self.amplification.get(k as usize));
        answers.fold(0.0, |loudest, a| loudest.max(a.abs()))
    }

    /// Checks lengths (1 to 16384), that every number is finite, and the ranges above
    /// (the gain lies in [0, 100]).
    ///
    /// # Errors
    /// Names the number that is wrong.
    pub fn validate(&self) -> Result<(), MusicError> {
        let bad = |what, why: String| Err(MusicError::BadMapping { what, why });
        for (what, values, low) in
            [("transfer", &self.transfer, 0.0), ("amplification", &self.amplification, -1.0)]
        {
            if values.is_empty() || values.len() > MAX_GENES {
                return bad(what, format!("has {} values, not 1 to {MAX_GENES}", values.len()));
            }
            if let Some((i, v)) = values.iter().enumerate().find(|(_, v)| !(low..=1.0).contains(*v)) {
                return bad(what, format!("value {i} is {v}, outside [{low}, 1]"));
            }
        }
        if !(0.0..=1.0).contains(&self.stereo_mu) {
            return bad("stereo_mu", format!("is {}, outside [0, 1]", self.stereo_mu));
        }
        if !(0.0..=100.0).contains(&self.gain) {
            return bad("gain", format!("is {}, outside [0, 100]", self.gain));
        }
        Ok(())
    }

    /// t̄ on `bands` bands: itself where the count agrees, else linear between band centers.
    pub fn transfer_on(&self, bands: usize) -> Vec<f32> {
        resample(&self.transfer, bands)
    }

    /// a on `harmonics` harmonics: itself where the count agrees, else linear in between.
    pub fn amplification_on(&self, harmonics: usize) -> Vec<f32> {
        resample(&self.amplification, harmonics)
    }

    /// t(ω) ∈ {0 … K−1} for each of `bands` bands on a shape of `harmonics` = K harmonics.
    pub fn targets(&self, bands: usize, harmonics: usize) -> Vec<u32> {
        let top = harmonics.saturating_sub(1) as f32;
        self.transfer_on(bands).into_iter().map(|t| (t.clamp(0.0, 1.0) * top).round() as u32).collect()
    }
}

/// The power of the even gain: see [`Mapping::even_gain`].
pub(crate) const EVENING: f32 = -0.75;

/// How many bands drive the harmonic that most of them drive, of those that answer; at least 1. Each band comes with its
/// harmonic, and how strongly that answers.
pub(crate) fn busiest(driven: impl IntoIterator<Item = (u32, f32)>) -> f32 {
    let answers = driven.into_iter().filter(|(_, answer)| *answer != 0.0);
    let mut heard: Vec<u32> = answers.map(|(k, _)| k).collect();
    heard.sort_unstable();
    heard.chunk_by(|a, b| a == b).map(<[u32]>::len).max().unwrap_or(1) as f32
}

/// Samples at cell centers, linear in between, constant beyond the outermost centers.
fn resample(values: &[f32], count: usize) -> Vec<f32> {
    if values.len() == count {
        return values.to_vec();
    }
    let Some(last) = values.len().checked_sub(1) else { return vec![0.0; count] };
    (0..count)
        .map(|i| {
            let x = ((i as f64 + 0.5) * values.len() as f64 / count as f64 - 0.5).clamp(0.0, last as f64);
            let low = x as usize;
            let (a, b) = (values[low], values[(low + 1).min(last)]);
            a + (b - a) * (x - low as f64) as f32
        })
        .collect()
}

/// All harmonics in groups of not more than the shape has pieces, first the constant ones. In a group, the largest λ is less
/// than one and a half times the least, as of one wave on pieces that are nearly alike; of one large piece beside small ones
/// these are few harmonics of about one fineness. On a shape in one piece each harmonic is alone.
fn alike(eigenvalues: &[f64]) -> Vec<Range<usize>> {
    const ALIKE: f64 = 1.5;
    let pieces = spare_constants(eigenvalues) + 1;
    let next = |group: &Range<usize>| {
        let start = group.end;
        let lowest = eigenvalues.get(start)?;
        let near = eigenvalues.partition_point(|l| *l < ALIKE * lowest);
        Some(start..near.clamp(start + 1, start + pieces).min(eigenvalues.len()))
    };
    std::iter::successors(Some(0..pieces), next).collect()
}

/// t_ini(ω) = min{ k : ω/ω_max ≤ √(λ_k/λ_max) }, read at α·ω, normalized to [0, 1] (section 4d).
///
/// Band b of `bands` stands at ω/ω_max = (b+1)/bands, so that the last one reaches λ_max.
/// Only harmonics with λ_k > 0 count: a constant harmonic cannot move the shape in the filter
/// form, and α = 0 would otherwise send all sound there. `reversed` gives t_rev = K − 1 − t_ini, counted from the last
/// of the constant harmonics, of which a shape has one for each of its pieces.
pub fn direct_transfer(eigenvalues: &[f64], bands: usize, alpha: f64, reversed: bool) -> Vec<f32> {
    let Some(&largest) = eigenvalues.last() else { return vec![0.0; bands] };
    let top = (eigenvalues.len() - 1).max(1) as f64;
    let first = first_waving(eigenvalues).min(eigenvalues.len() - 1);
    let spare = first.saturating_sub(1) as f64;
    (0..bands)
        .map(|b| {
            let omega = alpha * (b + 1) as f64 / bands as f64;
            // ω ≤ √(λ/λ_max) ⇔ ω² λ_max ≤ λ, without losing the equality at ω = 1 to rounding.
            let k = eigenvalues
                .partition_point(|&l| l < omega * omega * largest)
                .clamp(first, eigenvalues.len() - 1) as f64;
            (if reversed { top - k + spare } else { k } / top) as f32
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn the_direct_transfer_is_the_formula() {
        let eigenvalues = [0.0, 1.0, 2.5, 4.0, 9.0, 16.0];
        let t = direct_transfer(&eigenvalues, 8, 1.0, false);
        for (b, t) in t.iter().enumerate() {
            let omega = (b + 1) as f64 / 8.0;
            let k = (0..6).find(|&k| omega <= (eigenvalues[k] / 16.0f64).sqrt()).unwrap();
            assert_eq!((t * 5.0).round() as usize, k);
        }
        let reversed = direct_transfer(&eigenvalues, 8, 1.0, true);
        assert!(t.iter().zip(&reversed).all(|(t, r)| (t + r - 1.0).abs() < 1e-6));
        let constant = direct_transfer(&eigenvalues, 8, 0.0, false);
        assert!(constant.iter().all(|t| (t * 5.0).round() == 1.0));
        // Of three pieces, the third constant is the lowest that the reversed one drives.
        let pieces = direct_transfer(&[0.0, 0.0, 0.0, 1.0, 4.0, 9.0], 8, 1.0, true);
        let lowest = pieces.iter().map(|t| (t * 5.0).round() as usize).min();
        assert_eq!(lowest, Some(2));
    }

    #[test]
    fn the_direct_mapping_amplifies_what_it_drives_on_shapes_of_few_harmonics_or_many_pieces() {
        let weyl = |pieces: usize, k_count: usize| -> Vec<f64> {
            (0..k_count).map(|k| (k + 1).saturating_sub(pieces) as f64).collect()
        };
        for (pieces, k_count) in [(1, 2), (1, 3), (1, 4), (2, 4), (3, 4), (4, 16), (128, 512), (500, 512)] {
            let mapping = Mapping::direct(&weyl(pieces, k_count), 128);
            mapping.validate().unwrap();
            assert!(mapping.loudness() > 0.0, "{pieces} pieces, K = {k_count}");
        }
        // A sphere's first three waves are of one frequency.
        assert!(Mapping::direct(&[0.0, 2.0, 2.0, 2.0], 128).loudness() > 0.0);
        // On a shape in one piece, the lower quarter.
        for k_count in [1, 5, 7, 8, 162, 256] {
            let quarter = (0..k_count).map(|k| (1.0 - (4.0 * k as f32 / k_count as f32).min(1.0)).powi(2));
            let mapping = Mapping::direct(&weyl(1, k_count), 128);
            assert_eq!(mapping.amplification, quarter.collect::<Vec<_>>());
        }
    }

    #[test]
    fn pieces_that_are_alike_share_the_sound_and_small_ones_leave_it_to_the_large_one() {
        // Twelve pieces of nearly one size; each has five harmonics.
        let piece = [0.0, 1.0, 1.2, 1.4, 3.9];
        let wave = |l: f64| (0..12).map(move |i| l * (1.0 + 0.01 * f64::from(i)));
        let mapping = Mapping::direct(&piece.into_iter().flat_map(wave).collect::<Vec<_>>(), 128);
        let targets = mapping.targets(128, 60);
        assert!(targets.iter().all(|k| (12..24).contains(k)), "the first wave of each piece");
        assert_eq!(busiest(targets.iter().map(|k| (*k, 1.0))), 11.0, "128 bands for 12 pieces");
        assert_eq!(mapping.amplification[12..24], [mapping.amplification[12]; 12]);
        assert!(mapping.amplification[24] < mapping.amplification[12]);
        // One large piece, and eleven without waves that are low enough.
        let eigenvalues: Vec<f64> = (0..60).map(|k| f64::from((k - 11i32).max(0))).collect();
        let harmonic = |t: &f32| (t * 59.0).round() as usize;
        let straight = direct_transfer(&eigenvalues, 128, 0.5, false);
        for (now, straight) in Mapping::direct(&eigenvalues, 128).transfer.iter().zip(&straight) {
            let ratio = eigenvalues[harmonic(now)] / eigenvalues[harmonic(straight)];
            assert!(ratio > 1.0 / 1.5 && ratio < 1.5, "{ratio}");
        }
    }

    #[test]
    fn figures_of_a_shape_in_pieces_are_no_constant_harmonics() {
        let classes = [Class::Symmetric; 512];
        let eigenvalues: Vec<f64> = (0..512).map(|k| f64::from((k - 127i32).max(0))).collect();
        let targets = Mapping::figures(&eigenvalues, &classes, 128).targets(128, 512);
        assert_eq!((targets[0], targets[127]), (131, 222));
        // All are constant: there is a mapping, although it moves nothing.
        Mapping::figures(&[0.0; 8], &classes[..8], 128).validate().unwrap();
    }

    #[test]
    fn values_on_another_number_of_cells_are_linear_between_their_centers() {
        assert_eq!(resample(&[0.0, 1.0, 2.0, 3.0], 2), [0.5, 2.5]);
        assert_eq!(resample(&[0.0, 1.0], 4), [0.0, 0.25, 0.75, 1.0]);
        assert_eq!(resample(&[0.0, 1.0, 5.0], 1), [1.0]);
        assert_eq!(resample(&[], 2), [0.0, 0.0]);
    }

    proptest! {
        #[test]
        fn resampling_keeps_the_range_and_the_same_count_keeps_all(
            values in prop::collection::vec(-1.0f32..1.0, 1..60), count in 1usize..90)
        {
            let low = values.iter().copied().fold(f32::MAX, f32::min);
            let high = values.iter().copied().fold(f32::MIN, f32::max);
            let out = resample(&values, count);
            prop_assert_eq!(out.len(), count);
            prop_assert!(out.iter().all(|v| *v >= low - 1e-6 && *v <= high + 1e-6));
            prop_assert_eq!(resample(&values, values.len()), values);
        }

        #[test]
        fn targets_exist_on_any_shape(
            transfer in prop::collection::vec(0.0f32..=1.0, 1..60), bands in 1usize..90, harmonics in 1usize..90)
        {
            let mapping = Mapping { transfer, ..Mapping::rest(1, 1) };
            prop_assert!(mapping.validate().is_ok());
            prop_assert!(mapping.targets(bands, harmonics).iter().all(|&k| (k as usize) < harmonics));
        }
    }
}
