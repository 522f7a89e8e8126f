//! How mappings have children (stereo-music paper, section 4c) and how they mutate.

use chladni_breeding::{ChaCha8Rng, Genome, inherit, shift};
use rand::RngExt;

use crate::Mapping;

/// A mapping whose largest driven |a| is below this counts as not moving.
pub(crate) const SILENT: f32 = 0.02;

/// A child of two mappings. Transfer and amplification are each mixed with probability ½ and
/// otherwise taken whole from one parent; μ and gain likewise (a gallery then evens the
/// child's gain). Shorter vectors are resampled
/// to the longer parent's length, so that every value of the child lies between its parents'.
///
/// A child that no sound would move, because its transfer leads only to harmonics that it does not amplify,
/// gets the mean of both amplifications; if that does not help, its mother's transfer as well; if the
/// parents' amplifications cancel, its mother's amplification.
///
/// ```
/// use chladni_music::{ChaCha8Rng, Mapping, SeedableRng, breed};
///
/// let (mother, father) = (Mapping::rest(8, 4), Mapping { gain: 2.0, ..Mapping::rest(8, 4) });
/// let child = breed(&mother, &father, &mut ChaCha8Rng::seed_from_u64(7));
/// assert!((1.0..=2.0).contains(&child.gain));
/// ```
pub fn breed(mother: &Mapping, father: &Mapping, rng: &mut ChaCha8Rng) -> Mapping {
    let bands = mother.transfer.len().max(father.transfer.len());
    let harmonics = mother.amplification.len().max(father.amplification.len());
    let transfer = inherit(&mother.transfer_on(bands), &father.transfer_on(bands), rng);
    let amplification =
        inherit(&mother.amplification_on(harmonics), &father.amplification_on(harmonics), rng);
    let stereo_mu = inherit(&[mother.stereo_mu], &[father.stereo_mu], rng)[0];
    let gain = inherit(&[mother.gain], &[father.gain], rng)[0];
    let mut child = Mapping { transfer, amplification, stereo_mu, gain };
    if child.loudness() < SILENT {
        let (p, q) = (mother.amplification_on(harmonics), father.amplification_on(harmonics));
        child.amplification = p.iter().zip(&q).map(|(p, q)| 0.5 * (p + q)).collect();
        if child.loudness() < SILENT {
            child.transfer = mother.transfer_on(bands);
        }
        // The mean is silent where one parent amplifies what the other damps.
        if child.loudness() < SILENT {
            child.amplification = mother.amplification_on(harmonics);
        }
    }
    child
}

/// `mapping` changed a little: every run of t, a and μ moves by one random step of at most
/// `amount` (in [0, 1]) within its range. An amplification of zero stays zero in half of the
/// runs, so that bands do not all open at once. Bands do not move down to the first harmonic, which is constant and moves
/// nothing: they turn back before it. The gain follows, so that a mutant is as much louder or softer than its even gain as
/// `mapping` is.
pub fn mutate(mapping: &Mapping, amount: f32, rng: &mut ChaCha8Rng) -> Mapping {
    let mut mutant = mutate_plainly(mapping, amount, rng);
    let top = mapping.amplification.len().saturating_sub(1);
    if top > 0 {
        let second = 1.0 / top as f32;
        for (now, before) in mutant.transfer.iter_mut().zip(&mapping.transfer) {
            if *now < second && *before >= second {
                *now = (2.0 * second - *now).min(1.0);
            }
        }
    }
    as_loud_as(mutant, over_even(mapping))
}

/// How much louder or softer than its even gain a mapping is.
fn over_even(mapping: &Mapping) -> f32 {
    mapping.gain / mapping.even_gain()
}

fn as_loud_as(mapping: Mapping, over_even: f32) -> Mapping {
    Mapping { gain: (over_even * mapping.even_gain()).clamp(0.0, 100.0), ..mapping }
}

/// The mutation of shows before version 4: bands may move to the constant harmonic, and the gain stays.
pub(crate) fn mutate_plainly(mapping: &Mapping, amount: f32, rng: &mut ChaCha8Rng) -> Mapping {
    let mut mutant = mapping.clone();
    shift(&mut mutant.transfer, amount, 0.0, rng);
    shift(&mut mutant.amplification, amount, -1.0, rng);
    let step: f32 = rng.random_range(-1.0..=1.0);
    mutant.stereo_mu = (mutant.stereo_mu + amount * step).clamp(0.0, 1.0);
    mutant
}

impl Genome for Mapping {
    /// As [`breed`] says; a child inherits how much louder or softer than their even gain its parents are.
    fn child(mother: &Self, father: &Self, rng: &mut ChaCha8Rng) -> Self {
        let child = breed(mother, father, rng);
        as_loud_as(child, 0.5 * (over_even(mother) + over_even(father)))
    }

    fn mutant(&self, amount: f32, rng: &mut ChaCha8Rng) -> Self {
        mutate(self, amount, rng)
    }

    fn genes(&self) -> usize {
        self.transfer.len() + self.amplification.len()
    }

    /// Some sound is seen to move it.
    fn is_viable(&self) -> bool {
        self.loudness_from(1) >= SILENT
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use rand_chacha::rand_core::SeedableRng;

    fn mapping() -> impl Strategy<Value = Mapping> {
        (
            prop::collection::vec(0.0f32..=1.0, 1..80),
            prop::collection::vec(-1.0f32..=1.0, 1..80),
            0.0f32..=1.0,
            0.0f32..4.0,
        )
            .prop_map(|(transfer, amplification, stereo_mu, gain)| Mapping {
                transfer,
                amplification,
                stereo_mu,
                gain,
            })
    }

    fn between(child: &[f32], p: &[f32], q: &[f32]) -> bool {
        child.len() == p.len()
            && (0..p.len()).all(|i| child[i] >= p[i].min(q[i]) && child[i] <= p[i].max(q[i]))
    }

    proptest! {
        #[test]
        fn children_lie_between_their_parents(p in mapping(), q in mapping(), seed: u64) {
            let child = breed(&p, &q, &mut ChaCha8Rng::seed_from_u64(seed));
            let (bands, harmonics) = (p.transfer.len().max(q.transfer.len()), p.amplification.len().max(q.amplification.len()));
            prop_assert!(child.validate().is_ok());
            prop_assert!(between(&child.transfer, &p.transfer_on(bands), &q.transfer_on(bands)));
            prop_assert!(between(&child.amplification, &p.amplification_on(harmonics), &q.amplification_on(harmonics)));
            prop_assert!(between(&[child.stereo_mu], &[p.stereo_mu], &[q.stereo_mu]));
            prop_assert_eq!(&child, &breed(&p, &q, &mut ChaCha8Rng::seed_from_u64(seed)));
        }

        #[test]
        fn a_child_of_twins_is_their_twin(p in mapping(), seed: u64) {
            prop_assert_eq!(breed(&p, &p, &mut ChaCha8Rng::seed_from_u64(seed)), p);
        }

        #[test]
        fn mutants_are_valid_and_near(p in mapping(), amount in 0.0f32..=1.0, seed: u64) {
            let mutant = mutate(&p, amount, &mut ChaCha8Rng::seed_from_u64(seed));
            prop_assert!(mutant.validate().is_ok());
            let near = |(a, b): (&f32, &f32)| (a - b).abs() <= amount + 1e-6;
            prop_assert!(p.transfer.iter().zip(&mutant.transfer).all(near));
            prop_assert!(p.amplification.iter().zip(&mutant.amplification).all(near));
            prop_assert!(near((&p.stereo_mu, &mutant.stereo_mu)));
            let loudness = |mapping: &Mapping| mapping.gain / mapping.even_gain();
            prop_assert!(mutant.gain == 100.0 || (loudness(&mutant) - loudness(&p)).abs() <= 1e-4 * loudness(&p));
            let plain = mutate_plainly(&p, amount, &mut ChaCha8Rng::seed_from_u64(seed));
            prop_assert!(plain.transfer.iter().zip(&p.transfer).all(near) && plain.gain == p.gain);
        }
    }

    #[test]
    fn every_kind_of_value_mutates_as_far_as_it_may() {
        let half = vec![0.5; 80];
        let p =
            Mapping { transfer: half.clone(), amplification: half, stereo_mu: 0.5, ..Mapping::rest(1, 1) };
        let mut rng = ChaCha8Rng::seed_from_u64(7);
        let mutants: Vec<Mapping> = (0..100).map(|_| mutate(&p, 0.2, &mut rng)).collect();
        let kinds: [fn(&Mapping) -> &[f32]; 3] = [
            |mapping| &mapping.transfer,
            |mapping| &mapping.amplification,
            |mapping| std::slice::from_ref(&mapping.stereo_mu),
        ];
        for of in kinds {
            let values = || mutants.iter().flat_map(of).copied();
            let (least, most) = (values().fold(1.0, f32::min), values().fold(0.0, f32::max));
            assert!(least < 0.34 && most > 0.66, "{least} to {most}");
        }
    }

    #[test]
    fn bands_turn_back_before_the_constant_harmonic() {
        let (mut on_it, mut plainly) = (0, 0);
        let low = Mapping { transfer: vec![0.02; 128], ..Mapping::rest(128, 256) };
        for seed in 0..20 {
            let rng = || ChaCha8Rng::seed_from_u64(seed);
            let count = |mutant: Mapping| mutant.targets(128, 256).iter().filter(|k| **k == 0).count();
            on_it += count(mutate(&low, 0.2, &mut rng()));
            plainly += count(mutate_plainly(&low, 0.2, &mut rng()));
        }
        assert!(on_it == 0 && plainly > 500, "{on_it} and {plainly}");
    }

    #[test]
    fn no_dance_that_is_changed_a_little_stands_still_or_leaps() {
        let eigenvalues: Vec<f64> = (0..256).map(f64::from).collect();
        for seed in 0..9 {
            let shape = crate::GalleryShape { eigenvalues: eigenvalues.clone(), bands: 128 };
            let mut instrument = crate::Instrument::new(seed, 12, shape).unwrap();
            for item in 0..12 {
                let action = crate::Action::Mutate { item, amount: 0.2 };
                instrument.apply(crate::Moment::default(), action).unwrap();
            }
            for item in instrument.gallery().items() {
                assert!(item.genome.is_viable(), "seed {seed}, item {}", item.id);
                let loudness = item.genome.gain / item.genome.even_gain();
                assert!((0.99..1.01).contains(&loudness), "seed {seed}, item {}: {loudness}", item.id);
            }
        }
    }

    #[test]
    fn no_child_of_a_gallery_stands_still() {
        let eigenvalues: Vec<f64> = (0..96).map(f64::from).collect();
        for seed in 0..20 {
            let shape = crate::GalleryShape { eigenvalues: eigenvalues.clone(), bands: 128 };
            let mut instrument = crate::Instrument::new(seed, 12, shape).unwrap();
            let mut act = |action| instrument.apply(crate::Moment::default(), action).unwrap();
            (0..12).for_each(|item| act(crate::Action::Choose { item, on: true }));
            act(crate::Action::Breed);
            for item in instrument.gallery().items() {
                assert!(item.genome.loudness() >= SILENT, "seed {seed}, item {}", item.id);
            }
        }
    }

    #[test]
    fn halves_of_the_children_are_mixed_and_quarters_are_one_parents() {
        let p = Mapping { transfer: vec![0.0; 100], amplification: vec![1.0], ..Mapping::rest(1, 1) };
        let q = Mapping { transfer: vec![1.0; 100], ..p.clone() };
        let mut rng = ChaCha8Rng::seed_from_u64(7);
        let mut counts = [0; 3];
        for _ in 0..2000 {
            let child = breed(&p, &q, &mut rng);
            let kind = if child.transfer == p.transfer {
                0
            } else if child.transfer == q.transfer {
                1
            } else {
                2
            };
            counts[kind] += 1;
        }
        assert!((450..550).contains(&counts[0]) && (450..550).contains(&counts[1]), "{counts:?}");
    }
}
