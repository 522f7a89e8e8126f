//! Caricature layers, or any other fixed deformation, as instruments of the band.

use chladni_synth::{Coefficients, Item, Term};
use serde::{Deserialize, Serialize};

use crate::probes::{Probes, scale_term, soft_limit};
use crate::stage::Beat;
use crate::{Bands, Dancer, MusicError};

/// The feature of the song that drives a voice.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Driver {
    /// The loudest mid amplitude between two shares of the frequency axis, in [0, 1].
    Band {
        /// Where it begins.
        from: f32,
        /// Where it ends.
        to: f32,
    },
    /// One at each beat, fading until the next.
    Beat,
    /// The loudest band of the mid signal.
    Mid,
    /// The loudest band of the side signal, at most 1.
    Side,
}

impl Driver {
    /// The strength this driver gives, about [0, 1].
    pub fn strength(&self, bands: &Bands<'_>, beat: Beat) -> f32 {
        let loudest = |f: &[f32]| f.iter().copied().fold(0.0, f32::max);
        match *self {
            Self::Band { from, to } => {
                let count = bands.mid.len();
                let index = |share: f32| ((share.clamp(0.0, 1.0) * count as f32) as usize).min(count);
                let first = index(from.min(to)).min(count.saturating_sub(1));
                loudest(&bands.mid[first..index(from.max(to)).max(first + 1).min(count)])
            }
            Self::Beat => {
                let phase = beat.count.rem_euclid(1.0) as f32;
                beat.confidence.clamp(0.0, 1.0) * (1.0 - phase).powi(2)
            }
            Self::Mid => loudest(bands.mid),
            Self::Side => loudest(bands.side).min(1.0),
        }
    }
}

/// The driver of a voice, and how strongly the voice answers to it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct VoiceSettings {
    /// The feature of the song that it answers to.
    pub driver: Driver,
    /// Factor on the driver's strength, [−10, 10]; 0 is silent.
    pub gain: f32,
}

impl VoiceSettings {
    /// The default of voice number `voice`: the bass, the beat, the side and the treble in turn, so that the
    /// layers of a caricature move differently.
    pub fn initial(voice: usize) -> Self {
        let driver = match voice % 4 {
            0 => Driver::Band { from: 0.0, to: 0.2 },
            1 => Driver::Beat,
            2 => Driver::Side,
            _ => Driver::Band { from: 0.5, to: 1.0 },
        };
        Self { driver, gain: 1.0 }
    }

    /// Checks that the band lies in [0, 1] and the gain in [−10, 10].
    ///
    /// # Errors
    /// Names the one that is out of its range.
    pub fn validate(&self) -> Result<(), MusicError> {
        let check = |name, value: f32, low: f32, high: f32, range| {
            let ok = (low..=high).contains(&value);
            if ok {
                Ok(())
            } else {
                Err(MusicError::OutOfRange { name, value: value.into(), range: String::from(range) })
            }
        };
        if let Driver::Band { from, to } = self.driver {
            check("voice band", from, 0.0, 1.0, "[0, 1]")?;
            check("voice band", to, 0.0, 1.0, "[0, 1]")?;
        }
        check("voice gain", self.gain, -10.0, 10.0, "[-10, 10]")
    }
}

/// One voice: a deformation whose strength the song drives.
#[derive(Clone, Debug)]
pub struct Voice {
    /// The deformation at full strength, such as one layer of a caricature.
    pub term: Term,
    /// Its driver and gain.
    pub settings: VoiceSettings,
}

/// Several voices that together make one item.
#[derive(Clone, Debug)]
pub struct Voices {
    voices: Vec<Voice>,
    probes: Probes,
    box_diagonal: f32,
    limit: f32,
    most_harmonics: usize,
    scratch: Vec<[f32; 3]>,
}

impl Voices {
    /// Voices for a dancer; `limit` is the share of its bounding box's diagonal that no probe
    /// is to exceed, (0, 1].
    ///
    /// # Errors
    /// A gain or the limit is out of range, or a term has more coefficients than the dancer has harmonics.
    pub fn new(voices: Vec<Voice>, dancer: &Dancer, limit: f32) -> Result<Self, MusicError> {
        for voice in &voices {
            voice.settings.validate()?;
            let found = match &voice.term.coefficients {
                Coefficients::Vector(c) => c.len(),
                Coefficients::Normal(c) => c.len(),
            };
            if found > dancer.harmonics() {
                return Err(MusicError::Size {
                    what: "voice coefficients",
                    found,
                    expected: dancer.harmonics(),
                });
            }
        }
        let mut new = Self { voices, ..Self::silent(dancer) };
        new.set_limit(limit)?;
        Ok(new)
    }

    /// No voices at all.
    pub(crate) fn silent(dancer: &Dancer) -> Self {
        let (probes, box_diagonal) = (dancer.probes.clone(), dancer.box_diagonal);
        let most_harmonics = usize::MAX;
        Self {
            voices: Vec::new(),
            probes,
            box_diagonal,
            limit: box_diagonal,
            most_harmonics,
            scratch: Vec::new(),
        }
    }

    /// Leaves out all harmonics from this one on, on a machine that does not keep up. `None` leaves out none.
    pub(crate) fn use_at_most(&mut self, harmonics: Option<usize>) {
        self.most_harmonics = harmonics.unwrap_or(usize::MAX);
    }

    /// How many harmonics the voices with a gain use, counted up to the highest, if none is left out.
    pub(crate) fn harmonics_wanted(&self) -> u32 {
        let heard = self.voices.iter().filter(|voice| voice.settings.gain != 0.0);
        let wanted = heard.map(|voice| {
            let highest = match &voice.term.coefficients {
                Coefficients::Vector(c) => c.iter().rposition(|c| *c != [0.0; 3]),
                Coefficients::Normal(c) => c.iter().rposition(|c| *c != 0.0),
            };
            highest.map_or(0, |k| k as u32 + 1)
        });
        wanted.max().unwrap_or(0)
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.voices.len()
    }

    /// Another limit, (0, 1].
    ///
    /// # Errors
    /// A limit out of that range.
    pub fn set_limit(&mut self, limit: f32) -> Result<(), MusicError> {
        if !(limit > 0.0 && limit <= 1.0) {
            return Err(MusicError::OutOfRange {
                name: "limit",
                value: limit.into(),
                range: "(0, 1]".into(),
            });
        }
        self.limit = limit * self.box_diagonal;
        Ok(())
    }

    /// Lets a voice listen to something else.
    ///
    /// # Errors
    /// There is no such voice, or a setting is out of its range.
    pub fn tune(&mut self, voice: usize, settings: VoiceSettings) -> Result<(), MusicError> {
        settings.validate()?;
        let count = self.voices.len();
        let missing = MusicError::NoSuch { what: "voice", index: voice, count };
        self.voices.get_mut(voice).ok_or(missing)?.settings = settings;
        Ok(())
    }

    /// An item with one term per voice, for [`play`](Self::play) to write.
    pub fn item(&self) -> Item {
        Item { terms: self.voices.iter().map(|v| v.term.clone()).collect() }
    }

    /// Writes the effect of the sound into `item`, made by [`item`](Self::item). Returns the share
    /// of the limit reached before it was softened. Allocates nothing after the first call.
    ///
    /// # Errors
    /// An item of another number of voices.
    pub fn play(&mut self, bands: &Bands<'_>, beat: Beat, item: &mut Item) -> Result<f32, MusicError> {
        if item.terms.len() != self.voices.len() {
            return Err(MusicError::Size {
                what: "terms",
                found: item.terms.len(),
                expected: self.voices.len(),
            });
        }
        for (voice, term) in self.voices.iter().zip(&mut item.terms) {
            match (&mut term.coefficients, &voice.term.coefficients) {
                (Coefficients::Vector(to), Coefficients::Vector(from)) => {
                    to.clone_from(from);
                    silence(to, self.most_harmonics, [0.0; 3]);
                }
                (Coefficients::Normal(to), Coefficients::Normal(from)) => {
                    to.clone_from(from);
                    silence(to, self.most_harmonics, 0.0);
                }
                _ => return Err(MusicError::Size { what: "terms of the same form", found: 0, expected: 1 }),
            }
            term.residual_gain = voice.term.residual_gain;
            let VoiceSettings { driver, gain } = voice.settings;
            scale_term(term, gain * driver.strength(bands, beat));
        }
        let reach = self.probes.displacement(&item.terms, &mut self.scratch) / self.limit;
        let scale = soft_limit(reach);
        if scale < 1.0 {
            item.terms.iter_mut().for_each(|term| scale_term(term, scale));
        }
        Ok(reach)
    }

    /// Adds `voices`, as [`play`](Self::play) wrote them, to an item that keeps the limit by itself: weaker where together
    /// they would go beyond it.
    pub(crate) fn join(&mut self, voices: &Item, item: &mut Item) {
        if voices.terms.is_empty() {
            return;
        }
        let own_count = item.terms.len();
        item.terms.extend_from_slice(&voices.terms);
        let together = self.probes.displacement(&item.terms, &mut self.scratch);
        if together <= self.limit {
            return;
        }
        let (own, added) = item.terms.split_at_mut(own_count);
        let alone = self.probes.displacement(own, &mut self.scratch).min(self.limit);
        // The way of the farthest probe is a convex function of the voices' share.
        let share = (self.limit - alone) / (together - alone);
        added.iter_mut().for_each(|term| scale_term(term, share));
    }
}

/// Sets all coefficients from `first` on to zero.
fn silence<T: Copy>(coefficients: &mut [T], first: usize, zero: T) {
    if let Some(fine) = coefficients.get_mut(first..) {
        fine.fill(zero);
    }
}
