//! Crossing (stereo-music paper, section 4c) and mutation of vectors of numbers.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// Mean length of a run, as a share of the length of the vector.
const MEAN_RUN: f64 = 0.1;

/// Crosses the values of two parents, which have the same length. With probability ½ the values are mixed
/// run by run, and each value of the child lies between those of the parents; otherwise the child is a copy
/// of one parent.
///
/// # Panics
/// If the parents differ in length.
pub fn inherit(mother: &[f32], father: &[f32], rng: &mut ChaCha8Rng) -> Vec<f32> {
    assert_eq!(mother.len(), father.len(), "both parents have the same number of values");
    if rng.random_bool(0.5) {
        return mix(mother, father, rng);
    }
    if rng.random_bool(0.5) { mother.to_vec() } else { father.to_vec() }
}

/// Mixes in runs of geometrically distributed length; each run has one random weight w in [0, 1] and
/// becomes w·p₁ + (1 − w)·p₂.
fn mix(mother: &[f32], father: &[f32], rng: &mut ChaCha8Rng) -> Vec<f32> {
    let mut child = Vec::with_capacity(mother.len());
    while child.len() < mother.len() {
        let end = (child.len() + run_length(mother.len(), rng)).min(mother.len());
        let w: f32 = rng.random();
        for i in child.len()..end {
            let (p, q) = (mother[i], father[i]);
            let (mixed, low, high) = (w * p + (1.0 - w) * q, p.min(q), p.max(q));
            // Rounding must not carry a child's value outside its parents' range; NaN has none.
            child.push(match mixed {
                x if x < low => low,
                x if x > high => high,
                x => x,
            });
        }
    }
    child
}

/// A geometric random number in 1, 2, …, by inversion; its mean is a tenth of `length`.
fn run_length(length: usize, rng: &mut ChaCha8Rng) -> usize {
    let mean = (MEAN_RUN * length as f64).max(1.0);
    if mean <= 1.0 {
        return 1;
    }
    let u: f64 = rng.random();
    1 + ((1.0 - u).ln() / (1.0 - 1.0 / mean).ln()) as usize
}

/// Mutates `values`: each run moves by one random step of at most `amount`, and stays within [`low`, 1]. If
/// `low` is not 0, half of the runs leave values of zero at zero; otherwise a mutation would activate all
/// of them at once.
///
/// # Panics
/// If `low` is NaN or above 1.
pub fn shift(values: &mut [f32], amount: f32, low: f32, rng: &mut ChaCha8Rng) {
    assert!(low <= 1.0, "values stay within [low, 1]");
    let mut start = 0;
    while start < values.len() {
        let end = (start + run_length(values.len(), rng)).min(values.len());
        let step = amount * rng.random_range(-1.0f32..=1.0);
        let opens = rng.random_bool(0.5);
        for v in &mut values[start..end] {
            if low == 0.0 || *v != 0.0 || opens {
                *v = (*v + step).clamp(low, 1.0);
            }
        }
        start = end;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_chacha::rand_core::SeedableRng;

    #[test]
    fn runs_are_geometric_with_the_stated_mean() {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let total: usize = (0..20_000).map(|_| run_length(200, &mut rng)).sum();
        assert!((total as f64 / 20_000.0 - 20.0).abs() < 0.6, "{total}");
    }

    #[test]
    #[should_panic(expected = "same number of values")]
    fn parents_of_different_length_have_no_child() {
        inherit(&[0.5], &[0.5, 1.0], &mut ChaCha8Rng::seed_from_u64(1));
    }

    #[test]
    #[should_panic(expected = "within [low, 1]")]
    fn no_value_is_above_1_and_not_below_2() {
        shift(&mut [0.0; 0], 0.5, 2.0, &mut ChaCha8Rng::seed_from_u64(1));
    }

    #[test]
    fn runs_move_as_one_by_up_to_the_amount_in_either_direction() {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let mut values = vec![0.5_f32; 4000];
        values.chunks_mut(200).for_each(|part| shift(part, 0.2, -1.0, &mut rng));
        assert!(values.iter().all(|v| (v - 0.5).abs() <= 0.2 + 1e-6));
        assert!(values.iter().filter(|v| **v != 0.5).count() > 3900);
        assert!(values.iter().any(|v| *v > 0.66) && values.iter().any(|v| *v < 0.34));
        // About 200 runs of about 20.
        let borders = values.windows(2).filter(|pair| pair[0] != pair[1]).count();
        assert!((120..300).contains(&borders), "{borders}");
    }

    #[test]
    fn half_of_the_runs_leave_zeros_at_zero() {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let mut values = vec![0.0_f32; 40_000];
        values.chunks_mut(200).for_each(|part| shift(part, 0.2, -1.0, &mut rng));
        let zeros = values.iter().filter(|v| **v == 0.0).count();
        assert!((16_000..24_000).contains(&zeros), "{zeros}");
        assert!(values.iter().any(|v| *v > 0.1) && values.iter().any(|v| *v < -0.1));
    }

    #[test]
    fn a_value_that_is_no_number_can_be_inherited() {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        for _ in 0..16 {
            let child = inherit(&[f32::NAN, 0.5], &[f32::NAN, 0.5], &mut rng);
            assert!(child[0].is_nan() && child[1] == 0.5, "{child:?}");
        }
    }
}
