//! How the bands of sound ring at one moment: the state of the bank of resonators.

use crate::timbre::TONES;

/// The state of the oscillators of all bands at one moment, for each signal that a form may use.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Ringing {
    pub(crate) bands: usize,
    /// Left, right, middle, side, and swing toward the left: TONES rows of bands each.
    pub(crate) q: [Vec<f32>; SIGNALS],
}

/// A signal of [`Ringing`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Signal {
    Left,
    Right,
    Mid,
    Side,
    Swing,
}

pub(crate) const SIGNALS: usize = 5;

impl Ringing {
    /// #ω, the number of bands.
    pub fn bands(&self) -> usize {
        self.bands
    }

    pub(crate) fn at(&self, signal: Signal, tone: u8, band: usize) -> f32 {
        self.q[signal as usize][usize::from(tone) * self.bands + band]
    }

    /// Resets to rest, with `bands` bands.
    pub fn still(&mut self, bands: usize) {
        self.bands = bands;
        for q in &mut self.q {
            q.clear();
            q.resize(TONES * bands, 0.0);
        }
    }

    /// Blends toward `other`, the ringing before a jump in the song, by `weight`; weight 1 replaces this
    /// one.
    pub fn mix(&mut self, other: &Self, weight: f32) {
        if other.bands == self.bands {
            for (q, other) in self.q.iter_mut().zip(&other.q) {
                q.iter_mut().zip(other).for_each(|(q, other)| *q += weight * (other - *q));
            }
        }
    }
}
