//! The sound of late, by which children of a gallery are judged.

use chladni_music::{Bands, Moments};

/// Between two moments that are remembered.
const EVERY_SECS: f64 = 1.5;

/// Moments of the last minutes of a show's sound.
#[derive(Default)]
pub struct Recent {
    moments: Moments,
    at_secs: f64,
}

impl Recent {
    /// Remembers the sound of some moments of the show.
    pub fn hear(&mut self, at_secs: f64, bands: &Bands<'_>) {
        if (at_secs - self.at_secs).abs() >= EVERY_SECS {
            self.moments.remember(bands);
            self.at_secs = at_secs;
        }
    }

    /// Enough to compare dances by, even before a song plays.
    pub fn moments(&self, bands: usize) -> Moments {
        if self.moments.are_enough() { self.moments.clone() } else { Moments::of_anything(bands) }
    }
}
