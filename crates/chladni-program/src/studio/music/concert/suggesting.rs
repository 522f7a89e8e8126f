//! Suggested children: judged by what was heard last.

use chladni_music::{Action, Bands, Describer, Moments, suggest};

use super::Concert;
use crate::work::Error;

/// Between two moments that are remembered.
const EVERY_SECS: f64 = 1.5;

/// What was heard last.
#[derive(Default)]
pub struct Recent {
    moments: Moments,
    at_secs: f64,
}

impl Recent {
    /// Remembers what is heard at some time of the show, now and then.
    pub fn hear(&mut self, at_secs: f64, bands: &Bands<'_>) {
        if (at_secs - self.at_secs).abs() >= EVERY_SECS {
            self.moments.remember(bands);
            self.at_secs = at_secs;
        }
    }

    /// Enough to compare dances by, even before a song plays.
    fn moments(&self, bands: usize) -> Moments {
        if self.moments.are_enough() { self.moments.clone() } else { Moments::of_anything(bands) }
    }
}

impl Concert {
    /// Breeding, with the children that are most worth looking at.
    pub(super) fn suggested(&self) -> Result<Action, Error> {
        let playing = self.instrument.parameters().playing();
        let moments = self.recent.moments(self.instrument.shape().bands);
        let describer = Describer::new(self.ensemble.dancer().clone(), playing, moments)?;
        Ok(Action::BreedFrom { candidates: suggest(self.instrument.gallery(), &describer)? })
    }
}
