//! Descriptors of a mapping on a body: numbers that are near each other where movements look alike.

use std::sync::Arc;

use chladni_breeding::{Describe, Descriptor};

use crate::{Bands, Dancer, Mapping, MusicError, Player, Playing};

/// A few moments of a song, by which movements are compared.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Moments {
    /// For each the amplitudes of left, right, middle and side, #ω each.
    pub bands: Vec<[Vec<f32>; 4]>,
    /// For each the gain that its side has.
    pub side_gains: Vec<f32>,
}

/// The level of a single octave: loud, but not so loud that all movements reach their limits.
const LEVEL: f32 = 0.3;
/// The largest number of moments that are remembered.
const MOST_MOMENTS: usize = 12;

impl Moments {
    /// Remembers the current sound, in place of the oldest of twelve moments. Where the number of bands has
    /// changed, the others are forgotten.
    pub fn remember(&mut self, heard: &Bands<'_>) {
        let bands = heard.mid.len();
        if self.bands.first().is_some_and(|moment| moment[0].len() != bands) {
            *self = Self::default();
        }
        if self.bands.len() < MOST_MOMENTS {
            self.bands.push(std::array::from_fn(|_| vec![0.0; bands]));
        } else {
            self.bands.rotate_left(1);
            self.side_gains.remove(0);
        }
        self.side_gains.push(heard.side_gain);
        if let Some(moment) = self.bands.last_mut() {
            let heard = [heard.left, heard.right, heard.mid, heard.side];
            moment.iter_mut().zip(heard).for_each(|(kept, heard)| kept.copy_from_slice(heard));
        }
    }

    /// Whether there are enough to compare movements by: half of those that are remembered, not silent.
    pub fn are_enough(&self) -> bool {
        let sounds = |moment: &&[Vec<f32>; 4]| moment.iter().flatten().any(|level| *level > 0.02);
        2 * self.bands.iter().filter(sounds).count() >= MOST_MOMENTS
    }

    /// Moments for an unknown song: one octave after the other, in each channel and in both.
    pub fn of_anything(bands: usize) -> Self {
        const STEPS: usize = 6;
        let range = |step: usize| bands * step / STEPS..bands * (step + 1) / STEPS;
        let one = |(step, [left, right]): (usize, [f32; 2])| {
            let fill = |level: f32| {
                let mut all = vec![0.0; bands];
                all[range(step)].fill(level);
                all
            };
            [left, right, 0.5 * (left + right), 0.5 * (left - right).abs()].map(fill)
        };
        let channels = [[LEVEL, LEVEL], [LEVEL, 0.0], [0.0, LEVEL]];
        let all = (0..STEPS).flat_map(|step| channels.map(|channels| (step, channels)));
        let bands: Vec<[Vec<f32>; 4]> = all.map(one).collect();
        Self { side_gains: vec![1.0; bands.len()], bands }
    }
}

/// Describes mappings for one body, one way of playing and some moments of a song.
#[derive(Clone, Debug)]
pub struct Describer {
    dancer: Arc<Dancer>,
    playing: Playing,
    moments: Moments,
}

impl Describer {
    /// For a body, a way of playing and some moments.
    ///
    /// # Errors
    /// [`MusicError::Size`] where there are no moments or their bands or gains differ in number, and the errors of
    /// [`Playing::validate`].
    pub fn new(dancer: Arc<Dancer>, playing: Playing, moments: Moments) -> Result<Self, MusicError> {
        playing.validate()?;
        let bands = moments.bands.first().map_or(0, |moment| moment[0].len());
        for band in moments.bands.iter().flatten() {
            if band.len() != bands {
                return Err(MusicError::Size {
                    what: "bands of a moment",
                    found: band.len(),
                    expected: bands,
                });
            }
        }
        let (found, expected) = (moments.side_gains.len(), moments.bands.len());
        if found != expected {
            return Err(MusicError::Size { what: "gains of the sides", found, expected });
        }
        if bands == 0 {
            return Err(MusicError::Size { what: "bands of a moment", found: 0, expected: 1 });
        }
        // Moments are single pictures: what rings has no time to.
        Ok(Self { dancer, playing: Playing { timbre: None, ..playing }, moments })
    }

    /// How `mapping` moves the body: displacements and gradients at its probes, as shares of the limits,
    /// so that a ripple counts as much as a sway.
    ///
    /// # Errors
    /// Where it is not valid.
    pub fn describe(&self, mapping: &Mapping) -> Result<Descriptor, MusicError> {
        let bands = self.moments.bands[0][0].len();
        let mut player = Player::new(mapping, &self.dancer, bands, self.playing)?;
        let mut item = player.item();
        let mut values = Vec::new();
        for ([left, right, mid, side], &side_gain) in self.moments.bands.iter().zip(&self.moments.side_gains)
        {
            player.play(&Bands { left, right, mid, side, side_gain, ringing: None }, &mut item)?;
            player.feel(&item, &mut values);
        }
        Ok(Descriptor::of(values))
    }
}

impl Describe<Mapping> for Describer {
    type Error = MusicError;

    fn describe(&self, mapping: &Mapping) -> Result<Descriptor, MusicError> {
        Self::describe(self, mapping)
    }
}
