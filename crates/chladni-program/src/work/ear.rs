//! An ear that knows only the past: for live input, and for a song that is still being read.

use chladni_music::{Bands, BarLine, Beat, Harmony, Parameters, Resonators, Ringing};
use chladni_sound::{
    BeatFollower, HeardBar, Level, SoundError, Spectrum, SpectrumAnalyzer, SpectrumSettings,
};

use super::hearing::bands_of;
use super::tuning::spectrum_settings;

/// An analyzer, a beat tracker, the resonators that they strike, and the chords.
pub struct Ear {
    analyzer: SpectrumAnalyzer,
    /// The beat tracker, for corrections by hand.
    pub follower: BeatFollower,
    /// The beats that it has found.
    pub beats: BeatCount,
    resonators: Option<Resonators>,
    /// How long the last piece has rung.
    rung_secs: f32,
    harmony: Harmony,
    level: Level,
}

/// The number of beats so far. A tracker sometimes corrects its phase backward, but things that move with the beat
/// must not jump back.
#[derive(Clone, Copy, Debug, Default)]
pub struct BeatCount {
    /// Whole beats.
    gone: f64,
    shown: f64,
}

impl BeatCount {
    /// With so many beats before those that are heard from now on.
    pub fn from(count: f64) -> Self {
        Self { gone: count.ceil(), shown: count }
    }

    /// With the place within the present beat; never less than before.
    pub fn at(&mut self, phase: f64) -> f64 {
        self.shown = self.shown.max(self.gone + phase.clamp(0.0, 1.0));
        self.shown
    }
}

impl Ear {
    /// For sound of this rate.
    ///
    /// # Errors
    /// [`SoundError::Setting`] where the rate is out of range.
    pub fn new(rate_hz: u32) -> Result<Self, SoundError> {
        Ok(Self {
            analyzer: SpectrumAnalyzer::new(SpectrumSettings::new(rate_hz))?,
            follower: BeatFollower::new(rate_hz)?,
            beats: BeatCount::default(),
            resonators: None,
            rung_secs: 0.0,
            harmony: Harmony::default(),
            level: Level::Auto,
        })
    }

    /// The rate of the sound that it is tuned to.
    pub fn rate_hz(&self) -> u32 {
        self.analyzer.settings().rate_hz
    }

    /// The analyzer of the sound.
    pub fn analyzer(&self) -> &SpectrumAnalyzer {
        &self.analyzer
    }

    /// Follows the level of the sound, or keeps one, from the next [`tune`](Self::tune) on.
    pub fn set_level(&mut self, level: Level) {
        self.level = level;
    }

    /// Listens to sound of this rate from now on, as the knobs say.
    ///
    /// # Errors
    /// Those of [`new`](Self::new).
    pub fn tune(&mut self, rate_hz: u32, parameters: &Parameters) -> Result<(), SoundError> {
        if rate_hz != self.rate_hz() {
            self.follower = BeatFollower::new(rate_hz)?;
        }
        let wanted = SpectrumSettings { level: self.level, ..spectrum_settings(rate_hz, parameters) };
        if *self.analyzer.settings() != wanted {
            self.analyzer = SpectrumAnalyzer::new(wanted)?;
        }
        Ok(())
    }

    /// Takes new sound and tracks its beat; returns the bars that begin in it, in the tracker's own time. After a long
    /// frame there may be several.
    pub fn follow(&mut self, left: &[f32], right: &[f32]) -> Vec<BarLine> {
        self.follower.push(left, right);
        while self.follower.take_beat().is_some() {
            self.beats.gone += 1.0;
        }
        let beat_secs = 60.0 / self.follower.moment().tempo_bpm.max(1.0);
        let line = |HeardBar { at_secs, beats, energy, begins_section }| BarLine {
            at_secs,
            secs: f64::from(beats) * beat_secs,
            energy,
            begins_section,
        };
        std::iter::from_fn(|| self.follower.take_bar()).map(line).collect()
    }

    /// The beat now.
    pub fn beat(&mut self) -> Beat {
        let moment = self.follower.moment();
        Beat { count: self.beats.at(moment.phase), confidence: moment.confidence as f32 }
    }

    /// Analyzes a window of the sound ([`SpectrumAnalyzer::window_frames`]) that ends `dt_secs` after the last one.
    pub fn hear(
        &mut self,
        (left, right): (&[f32], &[f32]),
        parameters: &Parameters,
        dt_secs: f64,
    ) -> (Bands<'_>, Harmony) {
        self.analyzer.analyze(left, right, dt_secs);
        let (spectrum, dt_secs) = (self.analyzer.spectrum(), dt_secs as f32);
        self.harmony.hear(&spectrum.mid, self.analyzer.bands_hz(), dt_secs);
        let timbre = parameters.timbre();
        Resonators::follow(&mut self.resonators, timbre.as_ref(), spectrum.mid.len());
        let ringing = self.resonators.as_mut().map(|bank| {
            bank.hear(&bands_of(spectrum), std::mem::replace(&mut self.rung_secs, dt_secs));
            bank.ring(dt_secs)
        });
        (Bands { ringing, ..bands_of(spectrum) }, self.harmony)
    }

    /// The last result, for [`Hearing::fade_from`](super::Hearing::fade_from).
    pub fn heard(&self) -> (Spectrum, Ringing, Harmony) {
        let ringing = self.resonators.as_ref().map(|bank| bank.ringing().clone()).unwrap_or_default();
        (self.analyzer.spectrum().clone(), ringing, self.harmony)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn beats_never_go_back() {
        let mut beats = BeatCount::default();
        // The tracker takes a beat back that it had not announced yet.
        assert_eq!([0.5, 0.99, 0.02, 0.6].map(|phase| beats.at(phase)), [0.5, 0.99, 0.99, 0.99]);
        beats.gone += 1.0;
        assert_eq!([0.05, 0.5].map(|phase| beats.at(phase)), [1.05, 1.5]);
    }
}
