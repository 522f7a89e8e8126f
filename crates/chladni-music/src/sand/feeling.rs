//! What sand feels of a sound: how fast each vertex moves, and how new that is.

use std::sync::Arc;

use chladni_synth::{Coefficients, Item};
use rayon::prelude::*;

use super::{CHUNK, SAND_STEP_SECS, Sand};

/// The energy of a harmonic is its mean over about this time.
const MEMORY_SECS: f32 = 0.2;
/// The most harmonics that drive the sand: those of the most energy.
const MOST_DRIVERS: usize = 12;
/// Harmonics of less than this share of the strongest one's energy do not drive it.
const LEAST_SHARE: f32 = 0.02;
/// A figure is new as far as it differs from that of about this time.
const HABIT_SECS: f32 = 0.8;
/// The share of it at which the vigor is one half.
const HALF_VIGOR: f32 = 0.1;

impl Sand {
    /// Takes in the sounding item: the energy of each vertex, the length of the waves, the vigor.
    pub(super) fn feel(&mut self, item: &Item, full: f32) {
        let keep = (-SAND_STEP_SECS as f32 / MEMORY_SECS).exp();
        let (basis, slowest) = (Arc::clone(&self.tray.basis), self.tray.slowest);
        let silence = vec![0.0; basis.harmonics()];
        self.powers.resize(self.powers.len().max(item.terms.len()), silence);
        for (t, powers) in self.powers.iter_mut().enumerate() {
            for (k, power) in powers.iter_mut().enumerate() {
                let now = item.terms.get(t).map_or(0.0, |term| strength(&term.coefficients, k));
                let fast = (basis.eigenvalues[k] / slowest) as f32;
                *power = keep * *power + (1.0 - keep) * fast * now;
            }
        }
        let drivers = self.drivers();
        let sum = |of: fn(f64) -> f64| -> f64 {
            drivers.iter().map(|&(k, share)| f64::from(share).powi(3) * of(basis.eigenvalues[k])).sum()
        };
        let (total, curved) = (sum(|_| 1.0), sum(|lambda| lambda));
        if curved > 0.0 {
            self.wave = (total / curved).sqrt();
        }
        self.vibrate(item, &drivers);
        self.level = if full > 0.0 { self.most_speed / full } else { 0.0 };
        self.vigor = self.level / (self.level + HALF_VIGOR);
    }

    /// The speed of each vertex, and how new that figure is.
    fn vibrate(&mut self, item: &Item, drivers: &[(usize, f32)]) {
        let basis = &self.tray.basis;
        let term = |(t, powers): (usize, &Vec<f32>)| -> Driven<'_> {
            let wave = |&(k, share): &(usize, f32)| (share * powers[k].sqrt(), basis.harmonic(k));
            let mask = item.terms.get(t).and_then(|term| term.mask.as_deref());
            (drivers.iter().map(wave).filter(|(amplitude, _)| *amplitude > 0.0).collect(), mask)
        };
        let terms: Vec<Driven<'_>> = self.powers.iter().enumerate().map(term).collect();
        let chunks = self.speed.par_chunks_mut(CHUNK).zip(self.habit.par_chunks_mut(CHUNK)).enumerate();
        // Summed chunk by chunk, in their order: threads play no part.
        let sums: Vec<[f32; 4]> = chunks
            .map(|(chunk, (speed, habit))| {
                superpose(speed, &terms, chunk * CHUNK);
                compare(speed, habit)
            })
            .collect();
        let [both, new, old] = [0, 1, 2].map(|i| sums.iter().map(|sums| sums[i]).sum::<f32>());
        let alike = (new * old).sqrt();
        self.novelty = if alike > 0.0 { (1.0 - both / alike).clamp(0.0, 1.0) } else { 0.0 };
        self.most_speed = sums.iter().fold(0.0, |most, sums| sums[3].max(most));
    }

    /// The harmonics that drive the sand, and the weights of their movements: one weaker than the strongest
    /// counts less still, so that few of them draw the figure. Constant ones have no frequency.
    fn drivers(&self) -> Vec<(usize, f32)> {
        let power = |k: usize| self.powers.iter().map(|powers| powers[k]).sum::<f32>();
        let mut all: Vec<(usize, f32)> = (0..self.tray.basis.harmonics()).map(|k| (k, power(k))).collect();
        let order = |a: &(usize, f32), b: &(usize, f32)| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0));
        if all.len() > MOST_DRIVERS {
            all.select_nth_unstable_by(MOST_DRIVERS, order);
            all.truncate(MOST_DRIVERS);
        }
        all.sort_unstable_by(order);
        let most = all.first().map_or(0.0, |(_, power)| *power).max(f32::MIN_POSITIVE);
        all.iter_mut().for_each(|(_, power)| *power /= most);
        all.retain(|(_, share)| *share >= LEAST_SHARE);
        all
    }
}

/// Harmonics and what each is multiplied by, and the mask of their sum.
type Driven<'a> = (Vec<(f32, &'a [f64])>, Option<&'a [f32]>);

/// u of the vertices from `first` on: Σ over the terms of mask · Σ amplitude · harmonic.
fn superpose(speed: &mut [f32], terms: &[Driven<'_>], first: usize) {
    speed.fill(0.0);
    let mut sum = [0.0_f32; CHUNK];
    for (waves, mask) in terms {
        let sum = &mut sum[..speed.len()];
        sum.fill(0.0);
        // Wave by wave, which the processor does for many vertices at once.
        for (amplitude, harmonic) in waves {
            sum.iter_mut().zip(&harmonic[first..]).for_each(|(sum, h)| *sum += amplitude * *h as f32);
        }
        if let Some(mask) = mask {
            sum.iter_mut().zip(&mask[first..]).for_each(|(sum, share)| *sum *= share);
        }
        speed.iter_mut().zip(sum).for_each(|(speed, sum)| *speed += *sum);
    }
}

/// Makes E a little more habitual; Σ habit · E, Σ E², Σ habit² and the largest speed.
fn compare(speed: &[f32], habit: &mut [f32]) -> [f32; 4] {
    let forget = (-SAND_STEP_SECS as f32 / HABIT_SECS).exp();
    let (mut both, mut new, mut old, mut most) = (0.0_f32, 0.0_f32, 0.0_f32, 0.0_f32);
    for (habit, speed) in habit.iter_mut().zip(speed) {
        let energy = speed * speed;
        *habit = forget * *habit + (1.0 - forget) * energy;
        both += *habit * energy;
        new += energy * energy;
        old += *habit * *habit;
        most = most.max(energy);
    }
    [both, new, old, most.sqrt()]
}

/// The squared amplitude of harmonic k.
fn strength(coefficients: &Coefficients, k: usize) -> f32 {
    match coefficients {
        Coefficients::Vector(c) => c.get(k).map_or(0.0, |c| c.iter().map(|c| c * c).sum()),
        Coefficients::Normal(c) => c.get(k).map_or(0.0, |c| c * c),
    }
}
