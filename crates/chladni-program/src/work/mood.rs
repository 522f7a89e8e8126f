//! The sound as numbers that a look answers to.

use chladni_music::{Bands, Beat};
use chladni_view::Mood;

use super::Heard;

/// The mean of a channel's bands at which a picture is two thirds as bright as it gets; half of it gives a fifth, so that
/// beats stand out.
const USUAL: f32 = 0.22;
/// A beat's accent rises over this part of it, so that nothing flickers.
const RISE: f64 = 0.08;
/// And is gone to a third over this one.
const FALL: f64 = 0.3;

impl Heard<'_> {
    /// The mood that a look answers to.
    pub fn mood(&self) -> Mood {
        let Bands { mid, left, right, .. } = self.bands;
        let total: f32 = mid.iter().sum();
        let weighted: f32 = mid.iter().zip(0u16..).map(|(band, i)| band * f32::from(i)).sum();
        let last = mid.len().saturating_sub(1).max(1) as f32;
        let (apart, both) = left.iter().zip(right).fold((0.0f32, 0.0f32), |(apart, both), (l, r)| {
            (apart + (l - r).abs(), both + l.abs() + r.abs())
        });
        let share = |part: f32, of: f32| if of > 1e-6 { (part / of).clamp(0.0, 1.0) } else { 0.0 };
        let (beats, certainty, accent) = match self.fading {
            None => (self.beat.count, self.beat.confidence, accent(self.beat)),
            Some((before, done)) => {
                let mix = |from: f64, to: f64| from + f64::from(done) * (to - from);
                let of_both = mix(f64::from(accent(before)), f64::from(accent(self.beat)));
                let certainty = mix(before.confidence.into(), self.beat.confidence.into()) as f32;
                (mix(before.count, self.beat.count), certainty, of_both as f32)
            }
        };
        Mood {
            levels: [left, right].map(level),
            timbre: share(weighted, total * last),
            sides: share(apart, both),
            key_turns: self.harmony.turns(),
            beats,
            certainty,
            accent,
        }
    }
}

/// How loud a channel is, in [0, 1).
fn level(bands: &[f32]) -> f32 {
    let mean = bands.iter().sum::<f32>() / bands.len().max(1) as f32;
    1.0 - (-(mean.max(0.0) / USUAL).powi(2)).exp()
}

/// How much of a beat is still felt.
fn accent(Beat { count, confidence }: Beat) -> f32 {
    let phase = count.rem_euclid(1.0);
    let felt = (phase / RISE).min(1.0) * (-(phase - RISE).max(0.0) / FALL).exp();
    // The next beat finds nothing left of this one.
    (felt * ((1.0 - phase) / RISE).min(1.0)) as f32 * confidence
}

#[cfg(test)]
mod tests {
    use super::*;
    use chladni_music::Harmony;

    fn mood(mid: &[f32], left: &[f32], right: &[f32], count: f64) -> Mood {
        let bands = Bands { ringing: None, left, right, mid, side: mid, side_gain: 1.0 };
        let beat = Beat { count, confidence: 1.0 };
        let harmony = Harmony::default();
        Heard { at_secs: 0.0, is_known: true, bands, harmony, beat, fading: None }.mood()
    }

    #[test]
    fn louder_shriller_and_more_apart_are_more() {
        let silent = mood(&[0.0; 4], &[0.0; 4], &[0.0; 4], 0.0);
        assert_eq!(silent, Mood { certainty: 1.0, ..Mood::default() });
        let (low, high) = ([0.4, 0.1, 0.0, 0.0], [0.0, 0.0, 0.1, 0.4]);
        let [dull, shrill] = [low, high].map(|bands| mood(&bands, &bands, &bands, 0.0));
        assert!(dull.timbre < 0.3 && shrill.timbre > 0.7 && dull.levels == shrill.levels);
        let apart = mood(&low, &low, &[0.0; 4], 0.0);
        assert_eq!((dull.sides, apart.sides), (0.0, 1.0));
        assert!(apart.levels[0] == dull.levels[0] && apart.levels[1] == 0.0);
        let loud = mood(&low, &[0.9; 4], &[0.8; 4], 0.0);
        assert!(dull.levels[0] < loud.levels[1] && loud.levels[1] < loud.levels[0] && loud.levels[0] < 1.0);
        assert_eq!(mood(&[], &[], &[], 0.0), silent);
    }

    #[test]
    fn an_accent_comes_with_the_beat_and_never_jumps() {
        let at = |i: u32| mood(&[0.0], &[0.0], &[0.0], 3.0 + f64::from(i) / 500.0).accent;
        let all: Vec<f32> = (0..1500).map(at).collect();
        assert!(all.windows(2).all(|pair| (pair[1] - pair[0]).abs() < 0.03));
        assert!(all.iter().copied().fold(0.0, f32::max) > 0.95 && all[499] < 0.05);
    }
}
