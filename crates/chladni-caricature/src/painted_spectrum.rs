//! The transform of a painted signal, which follows the brush: a stroke costs only the rows of the vertices that it
//! touches.

use std::sync::Arc;

use chladni_harmonics::Basis;
use rayon::prelude::*;

/// Vertices that are processed together.
const BLOCK: usize = 512;
/// From this many changed vertices in a block, reading its whole stretch of a harmonic is faster than picking
/// them out.
const DENSE: usize = BLOCK / 8;

/// χ̃01_k = Σ_v a(v) H_k(v) χ01(v) and the χ01 that it belongs to.
///
/// Each addend is rounded to a multiple of 2⁻⁴⁴, so sums below 2⁹ are exact (|χ̃01_k| is at most the root of
/// the area). The order of additions and subtractions does not matter: undoing a stroke, or loading the
/// project again, gives the same bits.
#[derive(Clone, Debug, Default)]
pub(crate) struct PaintedSpectrum {
    painted: Arc<[f32]>,
    spectrum: Arc<[f64]>,
}

/// Adding and then subtracting it rounds to a multiple of 2⁻⁴⁴.
const GRID: f64 = 1.5 * (1_u64 << (52 - 44)) as f64;

fn rounded(x: f64) -> f64 {
    (x + GRID) - GRID
}

impl PaintedSpectrum {
    /// The first `harmonics` coefficients, or more, of `painted` (N values).
    pub(crate) fn follow(&mut self, basis: &Basis, painted: &[f32], harmonics: usize) -> &[f64] {
        if self.painted.len() != painted.len() || self.spectrum.len() < harmonics {
            self.painted = vec![0.0; painted.len()].into();
            self.spectrum = vec![0.0; harmonics].into();
        }
        let (before, known) = (&self.painted, self.spectrum.len());
        let sums = painted
            .par_chunks(BLOCK)
            .zip(before.par_chunks(BLOCK))
            .enumerate()
            .fold(
                || vec![0.0; known],
                |mut sums, (block, (new, old))| {
                    add_block(basis, block * BLOCK, old, new, &mut sums);
                    sums
                },
            )
            .reduce_with(|mut a, b| {
                a.iter_mut().zip(b).for_each(|(a, b)| *a += b);
                a
            });
        // New ones, as the clones of a stack share those before.
        if let Some(changes) = sums {
            self.spectrum = self.spectrum.iter().zip(changes).map(|(sum, change)| sum + change).collect();
            self.painted = painted.into();
        }
        &self.spectrum
    }
}

/// Adds what changes from `old` to `new` on the vertices from `first` on.
fn add_block(basis: &Basis, first: usize, old: &[f32], new: &[f32], sums: &mut [f64]) {
    let mass = &basis.mass[first..first + new.len()];
    let mut changed: Vec<(usize, f64, f64)> = Vec::new();
    for (i, ((old, new), a)) in old.iter().zip(new).zip(mass).enumerate() {
        if old != new {
            changed.push((i, a * f64::from(*old), a * f64::from(*new)));
        }
    }
    if changed.is_empty() {
        return;
    }
    if changed.len() < DENSE {
        for (k, sum) in sums.iter_mut().enumerate() {
            let h = &basis.harmonic(k)[first..first + new.len()];
            *sum +=
                changed.iter().map(|(i, old, new)| rounded(h[*i] * new) - rounded(h[*i] * old)).sum::<f64>();
        }
        return;
    }
    let (mut before, mut after) = ([0.0; BLOCK], [0.0; BLOCK]);
    for (i, old, new) in changed {
        (before[i], after[i]) = (old, new);
    }
    for (k, sum) in sums.iter_mut().enumerate() {
        let h = &basis.harmonic(k)[first..first + new.len()];
        let mut lanes = [0.0; 8];
        let addends = h.chunks(8).zip(before.chunks(8).zip(after.chunks(8)));
        for (h, (old, new)) in addends {
            for (lane, (h, (old, new))) in lanes.iter_mut().zip(h.iter().zip(old.iter().zip(new))) {
                *lane += rounded(h * new) - rounded(h * old);
            }
        }
        *sum += lanes.iter().sum::<f64>();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::bumpy_sphere;

    #[test]
    fn it_is_the_transform_of_the_painted_signal_and_forgets_the_way() {
        let (body, _) = bumpy_sphere();
        let n = body.positions.len();
        let (basis, k) = (&body.basis, body.basis.harmonics());
        let signal = |seed: usize, every: usize| -> Vec<f32> {
            (0..n).map(|v| if v % every == 0 { ((v * seed) % 97) as f32 / 96.0 } else { 0.0 }).collect()
        };
        let mut walked = PaintedSpectrum::default();
        // Few changes and many, with fewer harmonics first.
        walked.follow(basis, &signal(31, 40), k / 2);
        for (seed, every) in [(7, 90), (11, 1), (13, 2), (5, 33), (17, 1), (19, 3)] {
            let painted = signal(seed, every);
            let here = walked.follow(basis, &painted, k).to_vec();
            let mut fresh = PaintedSpectrum::default();
            let straight = fresh.follow(basis, &painted, k);
            let bits = |c: &[f64]| c.iter().map(|c| c.to_bits()).collect::<Vec<_>>();
            assert_eq!(bits(&here), bits(straight));
            let plain: Vec<f64> = painted.iter().map(|x| f64::from(*x)).collect();
            for (a, b) in here.iter().zip(basis.transform(&plain)) {
                assert!((a - b).abs() < 1e-10, "{a} against {b}");
            }
        }
        let empty = walked.follow(basis, &vec![0.0; n], k);
        assert!(empty.iter().all(|c| *c == 0.0));
    }
}
