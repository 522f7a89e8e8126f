//! The signals that drive symmetric and antisymmetric harmonics in stereo sound (section 5c).

use crate::ringing::Signal;
use crate::{Bands, Playing, Ringing};

/// How middle S = (L + R) / 2 and side U = (L − R) / 2 are mixed for one item at one moment.
///
/// Mixes complex spectra of which only the squared magnitudes are known:
/// |α S + β U|² = α² |S|² + β² |U|² + 2 α β Re(S Ū), with Re(S Ū) = (|L|² − |R|²) / 4.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StereoMix {
    mu: f32,
    /// g^(1−μ): at μ = 1 it is 1, so that S − U is R and U + S is L.
    side_gain: f32,
    /// g, by which the bands' side signal is already multiplied.
    bands_gain: f32,
    /// −1 where left and right are exchanged: U changes sign.
    turn: f32,
}

impl StereoMix {
    pub fn new(mu: f32, bands: &Bands<'_>, flip_sides: bool) -> Self {
        let bands_gain = bands.side_gain.max(0.0);
        let turn = if flip_sides { -1.0 } else { 1.0 };
        Self { mu, side_gain: bands_gain.powf(1.0 - mu), bands_gain, turn }
    }

    /// |S − μ g U|, what symmetric harmonics hear of band `b`.
    pub fn symmetric(&self, bands: &Bands<'_>, b: usize) -> f32 {
        if self.mu == 0.0 { bands.mid[b] } else { self.magnitude(bands, b, 1.0, -self.mu * self.side_gain) }
    }

    /// |g U + μ S|, what antisymmetric harmonics hear of band `b`.
    pub fn antisymmetric(&self, bands: &Bands<'_>, b: usize) -> f32 {
        if self.mu == 0.0 { bands.side[b] } else { self.magnitude(bands, b, self.mu, self.side_gain) }
    }

    /// What symmetric harmonics hear in the modal form: at μ = 0 the mean of the two channels' levels, which is |S| where
    /// they are in phase, and sound where they are opposite, which would have no middle.
    pub fn level(&self, bands: &Bands<'_>, b: usize) -> f32 {
        let mean = 0.5 * (bands.left[b] + bands.right[b]);
        mean + self.mu * (self.symmetric(bands, b) - mean)
    }

    /// What antisymmetric harmonics hear in the modal form: positive toward the left.
    ///
    /// At μ = 0 half the difference of the levels times g, limited to their mean, so that the movement by both sides
    /// at most stops on one side and is never reversed there. As μ goes to 1 only a single channel is heard,
    /// and nothing swings.
    pub fn swing(&self, bands: &Bands<'_>, b: usize) -> f32 {
        let (l, r) = (bands.left[b], bands.right[b]);
        let mean = 0.5 * (l + r);
        let towards = (0.5 * self.turn * self.side_gain * (l - r)).max(-mean).min(mean);
        towards + self.mu * (self.antisymmetric(bands, b) - towards)
    }

    /// Interpolates from the value at μ = 0 to the value at μ = 1.
    fn between(&self, at_zero: f32, at_one: f32) -> f32 {
        at_zero + self.mu * (at_one - at_zero)
    }

    /// The signals that drive antisymmetric and symmetric harmonics at μ = 1.
    fn channels(&self) -> (Signal, Signal) {
        if self.turn > 0.0 { (Signal::Left, Signal::Right) } else { (Signal::Right, Signal::Left) }
    }

    /// |α S + β U|.
    fn magnitude(&self, bands: &Bands<'_>, b: usize, alpha: f32, beta: f32) -> f32 {
        let (l, r, s) = (bands.left[b], bands.right[b], bands.mid[b]);
        // Where the side gain is not 0, the side itself is more accurate than a difference.
        let side_square = match self.bands_gain {
            g if g > 0.0 => (bands.side[b] / g).powi(2),
            _ => (0.5 * (l * l + r * r) - s * s).max(0.0),
        };
        let crossed = 2.0 * alpha * beta * self.in_step(bands, b);
        (alpha * alpha * s * s + beta * beta * side_square + crossed).max(0.0).sqrt()
    }

    /// Re(S Ū).
    fn in_step(&self, bands: &Bands<'_>, b: usize) -> f32 {
        let (l, r) = (bands.left[b], bands.right[b]);
        self.turn * 0.25 * (l - r) * (l + r)
    }
}

/// The sound at one moment, as harmonics receive it: the level of each band, or how it rings.
#[derive(Clone, Copy)]
pub(crate) struct Ear<'a> {
    mix: StereoMix,
    bands: &'a Bands<'a>,
    ringing: Option<&'a Ringing>,
}

impl<'a> Ear<'a> {
    pub fn new(bands: &'a Bands<'a>, playing: &Playing, mu: f32) -> Self {
        let ringing = bands.ringing.filter(|r| playing.timbre.is_some() && r.bands() == bands.mid.len());
        Self { mix: StereoMix::new(mu, bands, playing.flip_sides), bands, ringing }
    }

    pub fn left(&self, b: usize, tone: u8) -> f32 {
        self.ringing.map_or_else(|| self.bands.left[b], |r| r.at(Signal::Left, tone, b))
    }

    pub fn right(&self, b: usize, tone: u8) -> f32 {
        self.ringing.map_or_else(|| self.bands.right[b], |r| r.at(Signal::Right, tone, b))
    }

    /// Ringing has a sign, and the magnitude of a mixture has none. A single signal is heard at μ = 0 and at
    /// μ = 1; in between, the two are blended linearly.
    pub fn symmetric(&self, b: usize, tone: u8) -> f32 {
        self.ringing.map_or_else(
            || self.mix.symmetric(self.bands, b),
            |r| self.mix.between(r.at(Signal::Mid, tone, b), r.at(self.mix.channels().1, tone, b)),
        )
    }

    pub fn antisymmetric(&self, b: usize, tone: u8) -> f32 {
        self.ringing.map_or_else(
            || self.mix.antisymmetric(self.bands, b),
            |r| self.mix.between(r.at(Signal::Side, tone, b), r.at(self.mix.channels().0, tone, b)),
        )
    }

    pub fn level(&self, b: usize, tone: u8) -> f32 {
        self.ringing.map_or_else(
            || self.mix.level(self.bands, b),
            |r| {
                let mean = 0.5 * (r.at(Signal::Left, tone, b) + r.at(Signal::Right, tone, b));
                self.mix.between(mean, r.at(self.mix.channels().1, tone, b))
            },
        )
    }

    pub fn swing(&self, b: usize, tone: u8) -> f32 {
        self.ringing.map_or_else(
            || self.mix.swing(self.bands, b),
            |r| {
                let towards_left = self.mix.turn * r.at(Signal::Swing, tone, b);
                self.mix.between(towards_left, r.at(self.mix.channels().0, tone, b))
            },
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// One band of two complex channels.
    struct Heard {
        left: [f32; 1],
        right: [f32; 1],
        mid: [f32; 1],
        side: [f32; 1],
        side_gain: f32,
    }

    type Complex = (f32, f32);

    fn sum(a: Complex, b: Complex, alpha: f32, beta: f32) -> Complex {
        (alpha * a.0 + beta * b.0, alpha * a.1 + beta * b.1)
    }

    fn size((re, im): Complex) -> f32 {
        re.hypot(im)
    }

    impl Heard {
        fn of(l: Complex, r: Complex, side_gain: f32) -> Self {
            let side = side_gain * size(sum(l, r, 0.5, -0.5));
            Self {
                left: [size(l)],
                right: [size(r)],
                mid: [size(sum(l, r, 0.5, 0.5))],
                side: [side],
                side_gain,
            }
        }

        fn bands(&self) -> Bands<'_> {
            let Self { left, right, mid, side, side_gain } = self;
            Bands { left, right, mid, side, side_gain: *side_gain, ringing: None }
        }
    }

    #[test]
    fn in_phase_at_one_each_class_hears_exactly_one_channel() {
        let heard = Heard::of((1.0, 0.0), (0.8, 0.0), 10.0);
        for (flip_sides, antisymmetric, symmetric) in [(false, 1.0, 0.8), (true, 0.8, 1.0)] {
            let mix = StereoMix::new(1.0, &heard.bands(), flip_sides);
            assert!((mix.symmetric(&heard.bands(), 0) - symmetric).abs() < 1e-6);
            assert!((mix.antisymmetric(&heard.bands(), 0) - antisymmetric).abs() < 1e-6);
            assert!((mix.swing(&heard.bands(), 0) - antisymmetric).abs() < 1e-6);
        }
    }

    #[test]
    fn at_zero_a_channel_alone_rests_the_other_half_and_mono_swings_nothing() {
        for (l, r, swing) in [(1.0, 0.0, 0.5), (0.0, 1.0, -0.5), (1.0, 1.0, 0.0)] {
            let heard = Heard::of((l, 0.0), (0.0, r), 10.0);
            let heard = if l == r { Heard::of((l, 0.0), (r, 0.0), 10.0) } else { heard };
            let mix = StereoMix::new(0.0, &heard.bands(), false);
            assert_eq!(mix.swing(&heard.bands(), 0), swing);
            assert_eq!(mix.level(&heard.bands(), 0), heard.mid[0]);
        }
    }

    #[test]
    fn a_song_in_opposite_phase_is_as_loud_as_one_in_phase() {
        for (r, mid) in [(0.6, 0.7), (-0.6, 0.1)] {
            let heard = Heard::of((0.8, 0.0), (r, 0.0), 1.0);
            assert!((heard.mid[0] - mid).abs() < 1e-6);
            let mix = StereoMix::new(0.0, &heard.bands(), false);
            assert!((mix.level(&heard.bands(), 0) - 0.7).abs() < 1e-6);
            assert!((mix.swing(&heard.bands(), 0) - 0.1).abs() < 1e-6);
        }
    }

    proptest! {
        #[test]
        fn magnitudes_are_those_of_the_mixed_spectra(
            l in (-1.0f32..1.0, -1.0f32..1.0), r in (-1.0f32..1.0, -1.0f32..1.0),
            mu in 0.0f32..=1.0, side_gain in 0.0f32..20.0)
        {
            let heard = Heard::of(l, r, side_gain);
            let mix = StereoMix::new(mu, &heard.bands(), false);
            let g = side_gain.powf(1.0 - mu);
            let (s, u) = (sum(l, r, 0.5, 0.5), sum(l, r, 0.5, -0.5));
            let near = 2e-3 * (1.0 + g);
            prop_assert!((mix.symmetric(&heard.bands(), 0) - size(sum(s, u, 1.0, -mu * g))).abs() < near);
            prop_assert!((mix.antisymmetric(&heard.bands(), 0) - size(sum(s, u, mu, g))).abs() < near);
            let mean = 0.5 * (size(l) + size(r));
            prop_assert!(mix.swing(&heard.bands(), 0).abs() <= mix.antisymmetric(&heard.bands(), 0) + mean + near);
        }
    }
}
