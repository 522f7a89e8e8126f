//! How the bands of sound ring at one moment: the state of the bank of resonators.

use crate::timbre::TONES;

/// The state of the oscillators of all bands at one moment, for each signal that a form may use.
#[derive(Debug, Default, PartialEq)]
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

impl Clone for Ringing {
    fn clone(&self) -> Self {
        Self { bands: self.bands, q: self.q.clone() }
    }

    /// Keeps the memory, since each picture copies one.
    fn clone_from(&mut self, source: &Self) {
        self.bands = source.bands;
        self.q.clone_from(&source.q);
    }
}

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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_copy_keeps_its_memory() {
        let mut ringing = Ringing::default();
        ringing.still(8);
        let mut copy = ringing.clone();
        ringing.q[Signal::Mid as usize][3] = 0.5;
        let memory = |of: &Ringing| of.q.each_ref().map(Vec::as_ptr);
        let before = memory(&copy);
        copy.clone_from(&ringing);
        assert_eq!((memory(&copy), &copy), (before, &ringing));
    }
}
