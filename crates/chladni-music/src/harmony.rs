//! The place of the sound on the circle of fifths, by which a look may turn its colors.

use std::f32::consts::TAU;

/// Lower sounds are beats rather than notes of a chord, and higher ones have hardly a name.
const NOTES_HZ: [f32; 2] = [110.0, 2_400.0];
/// How long the place takes to follow a chord that is sure, to a third.
const FOLLOW_SECS: f32 = 0.5;

/// Follows the chords by the peaks of a spectrum. Each note points to its place on the circle of fifths, as far as it is
/// loud; the chord is where they point together, so that near keys are near places. Where they disagree, as those of drums
/// do, the place stays.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Harmony {
    turns: f32,
}

impl Harmony {
    /// Where it is now, in turns, in [0, 1); C major is at 1/8.
    pub fn turns(&self) -> f32 {
        self.turns
    }

    /// Hears the amplitudes of bands, whose centers are `bands_hz`, for a while.
    pub fn hear(&mut self, bands: &[f32], bands_hz: &[f32], secs: f32) {
        let (mut x, mut y, mut all) = (0.0, 0.0, 0.0);
        for (band, hz) in bands.windows(3).zip(bands_hz.windows(3)) {
            let (&[below, here, above], &[low_hz, mid_hz, high_hz]) = (band, hz) else { continue };
            if here <= below || here < above || !(NOTES_HZ[0]..NOTES_HZ[1]).contains(&mid_hz) {
                continue;
            }
            // The top of the parabola through the three, in steps between bands.
            let bend = below + above - 2.0 * here;
            let off = if bend < 0.0 { 0.5 * (below - above) / bend } else { 0.0 };
            let step = (if off < 0.0 { mid_hz / low_hz } else { high_hz / mid_hz }).ln();
            let octaves = (mid_hz / C_HZ).log2() + off * step / std::f32::consts::LN_2;
            // Twelve semitones an octave, and seven of them a fifth.
            let (sin, cos) = (TAU * (7.0 * octaves).rem_euclid(1.0)).sin_cos();
            (x, y, all) = (x + here * cos, y + here * sin, all + here);
        }
        if all <= 1e-6 {
            return;
        }
        let sure = (x * x + y * y).sqrt() / all;
        let off = (y.atan2(x) / TAU - self.turns + 0.5).rem_euclid(1.0) - 0.5;
        let part = 1.0 - (-secs * sure / FOLLOW_SECS).exp();
        self.turns = (self.turns + part * off).rem_euclid(1.0);
    }

    /// Goes a share of the way to `other`, the short way around.
    pub fn mix(&mut self, other: Self, share: f32) {
        let off = (other.turns - self.turns + 0.5).rem_euclid(1.0) - 0.5;
        self.turns = (self.turns + share * off).rem_euclid(1.0);
    }
}

/// Any C.
const C_HZ: f32 = 261.625_58;

#[cfg(test)]
mod tests {
    use super::*;

    /// 128 bands from 40 Hz to 16 kHz, each as far as notes are near, as the analyzer has them.
    fn sounding(notes: &[i32]) -> (Vec<f32>, Vec<f32>) {
        let ratio = 400f32.powf(1.0 / 127.0);
        let bands_hz: Vec<f32> = (0..128).map(|i| 40.0 * ratio.powi(i)).collect();
        let near = |hz: f32, note: i32| {
            let steps = (hz / (C_HZ * 2f32.powf(note as f32 / 12.0))).ln() / ratio.ln();
            if steps.abs() < 2.0 { 0.5 + 0.5 * (std::f32::consts::PI * steps / 2.0).cos() } else { 0.0 }
        };
        let band = |hz: &f32| notes.iter().map(|note| near(*hz, *note)).sum();
        (bands_hz.iter().map(band).collect(), bands_hz)
    }

    fn place(notes: &[i32]) -> f32 {
        let (bands, bands_hz) = sounding(notes);
        let mut harmony = Harmony::default();
        (0..2000).for_each(|_| harmony.hear(&bands, &bands_hz, 0.005));
        harmony.turns()
    }

    fn apart(a: f32, b: f32) -> f32 {
        ((a - b + 0.5).rem_euclid(1.0) - 0.5).abs()
    }

    #[test]
    fn chords_lie_on_the_circle_of_fifths_in_every_octave() {
        let major = |root: i32| place(&[root, root + 4, root + 7]);
        assert!(apart(major(0), 0.125) < 0.02, "C at {}", major(0));
        for root in -6..12 {
            let (here, fifth) = (major(root), major(root + 7));
            assert!(apart(fifth - here, 1.0 / 12.0) < 0.03, "from {root}: {here} to {fifth}");
            assert!(apart(here, major(root + 12)) < 0.03, "{root} an octave up");
        }
        // A tritone away is as far as one can go.
        assert!(apart(major(0), major(6)) > 0.45);
    }

    #[test]
    fn silence_and_noise_move_nothing_and_a_change_takes_its_time() {
        let mut harmony = Harmony { turns: 0.3 };
        let (bands, bands_hz) = sounding(&[0, 4, 7]);
        harmony.hear(&[0.0; 128], &bands_hz, 1.0);
        harmony.hear(&[0.4; 128], &bands_hz, 1.0);
        harmony.hear(&[], &[], 1.0);
        assert_eq!(harmony.turns(), 0.3);
        let mut last = harmony.turns();
        for _ in 0..400 {
            harmony.hear(&bands, &bands_hz, 0.01);
            assert!(apart(harmony.turns(), last) < 0.01);
            last = harmony.turns();
        }
        assert!(apart(last, 0.125) < 0.03);
        harmony.mix(Harmony { turns: 0.95 }, 0.5);
        assert!(apart(harmony.turns(), last) < 0.1 && apart(harmony.turns(), 0.95) < 0.1);
    }
}
