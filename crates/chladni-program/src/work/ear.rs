//! An ear that knows only the past: for live input, and for a song that is still being read.

use chladni_music::{Bands, BarLine, Beat, Harmony, Parameters, Resonators, Ringing};
use chladni_sound::{
    BeatFollower, HeardBar, Level, SoundError, Spectrum, SpectrumAnalyzer, SpectrumSettings,
};

use super::hearing::{bands_of, faded};
use super::tuning::spectrum_settings;

/// Windows of sound follow each other at most this far apart, however seldom a picture is drawn. At 60 pictures a second
/// there is one for each.
const HOP_SECS: f64 = 0.025;

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
    /// What was heard in another way before, while it fades out.
    fade: Option<Fade>,
    /// The last result.
    now: (Spectrum, Ringing, Harmony),
}

/// Sound that was heard in another way.
struct Fade {
    from: (Spectrum, Ringing, Harmony),
    /// How long it has faded; none before the first sound that comes after it.
    gone_secs: Option<f64>,
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
    /// After a longer pause only this much of the sound is heard.
    pub const LONGEST_SECS: f64 = 1.0;
    /// Live input from which nothing has come for longer is silent. Between two blocks of one that sounds it takes less.
    pub const QUIET_SECS: f64 = 0.2;

    /// For sound of this rate.
    ///
    /// # Errors
    /// [`SoundError::Setting`] where the rate is out of range.
    pub fn new(rate_hz: u32) -> Result<Self, SoundError> {
        let analyzer = SpectrumAnalyzer::new(SpectrumSettings::new(rate_hz))?;
        let silence = analyzer.spectrum().clone();
        Ok(Self {
            analyzer,
            follower: BeatFollower::new(rate_hz)?,
            beats: BeatCount::default(),
            resonators: None,
            rung_secs: 0.0,
            harmony: Harmony::default(),
            level: Level::Auto,
            fade: None,
            now: (silence, Ringing::default(), Harmony::default()),
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
            self.analyzer.retune(wanted)?;
        }
        Ok(())
    }

    /// Begins anew after sound that was heard in another way, as [`Hearing::heard`](super::Hearing::heard) has it: what
    /// this ear heard before is forgotten, and that sound fades out.
    pub fn go_on_from(&mut self, from: (Spectrum, Ringing, Harmony)) {
        self.analyzer.reset();
        self.resonators.iter_mut().for_each(Resonators::still);
        (self.rung_secs, self.harmony) = (0.0, Harmony::default());
        self.fade = Some(Fade { from, gone_secs: None });
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

    /// How many frames [`hear`](Self::hear) wants where the last of them are `dt_secs` after those before.
    pub fn frames(&self, dt_secs: f64) -> usize {
        let (hops, hop_secs) = hops(dt_secs);
        self.analyzer.window_frames() + self.frames_in(f64::from(hops - 1) * hop_secs)
    }

    /// Analyzes sound that ends `dt_secs` after the last one did, of which at most the last [`LONGEST_SECS`](Self::LONGEST_SECS)
    /// count: one window after the other, so that nothing in between is missed. Where `left` and `right` are shorter than
    /// [`frames`](Self::frames), silence came before them.
    pub fn hear(
        &mut self,
        (left, right): (&[f32], &[f32]),
        parameters: &Parameters,
        dt_secs: f64,
    ) -> (Bands<'_>, Harmony) {
        let timbre = parameters.timbre();
        Resonators::follow(&mut self.resonators, timbre.as_ref(), self.analyzer.settings().bands);
        let (hops, hop_secs) = hops(dt_secs);
        let rung_secs = hop_secs as f32;
        for later in (0..hops).rev() {
            let later_frames = self.frames_in(f64::from(later) * hop_secs);
            let [left, right] = [left, right].map(|side| &side[..side.len().saturating_sub(later_frames)]);
            self.analyzer.analyze(left, right, hop_secs);
            let spectrum = self.analyzer.spectrum();
            self.harmony.hear(&spectrum.mid, self.analyzer.bands_hz(), rung_secs);
            if let Some(bank) = &mut self.resonators {
                bank.hear(&bands_of(spectrum), std::mem::replace(&mut self.rung_secs, rung_secs));
            }
        }
        let (spectrum, ringing, harmony) = &mut self.now;
        spectrum.clone_from(self.analyzer.spectrum());
        match &mut self.resonators {
            Some(bank) => ringing.clone_from(bank.ring(rung_secs)),
            None => *ringing = Ringing::default(),
        }
        *harmony = self.harmony;
        if let Some(Fade { from, gone_secs }) = &mut self.fade {
            let gone = gone_secs.map_or(0.0, |gone| gone + dt_secs);
            *gone_secs = Some(gone);
            let left = 1.0 - faded(gone);
            spectrum.mix(&from.0, left);
            ringing.mix(&from.1, left);
            harmony.mix(from.2, left);
            if left <= 0.0 {
                self.fade = None;
            }
        }
        let ringing = self.resonators.is_some().then_some(&*ringing);
        (Bands { ringing, ..bands_of(spectrum) }, *harmony)
    }

    fn frames_in(&self, secs: f64) -> usize {
        (secs * f64::from(self.rate_hz())).round() as usize
    }

    /// The last result, for [`Hearing::fade_from`](super::Hearing::fade_from).
    pub fn heard(&self) -> (Spectrum, Ringing, Harmony) {
        self.now.clone()
    }
}

/// How many windows `dt_secs` of sound take, at least one, and how far apart these are.
fn hops(dt_secs: f64) -> (u32, f64) {
    let dt_secs = dt_secs.clamp(0.0, Ear::LONGEST_SECS);
    let hops = ((dt_secs / HOP_SECS).ceil() as u32).max(1);
    (hops, dt_secs / f64::from(hops))
}

#[cfg(test)]
mod tests {
    use super::super::hearing::FADE_SECS;
    use super::*;

    #[test]
    fn a_knock_between_two_late_pictures_moves_the_shape() {
        let (rate_hz, parameters) = (48_000, Parameters::default());
        let mut ear = Ear::new(rate_hz).unwrap();
        ear.tune(rate_hz, &parameters).unwrap();
        let silence = vec![0.0; ear.frames(0.3)];
        let mut sound = silence.clone();
        // It ends 0.16 s before the picture, and the last window begins 0.09 s before it.
        let from = sound.len() - 8640;
        for (i, sample) in sound[from..from + 960].iter_mut().enumerate() {
            *sample = 0.5 * (i as f32 * 0.06).sin();
        }
        let still = |ringing: Option<&Ringing>| {
            let mut rest = Ringing::default();
            rest.still(128);
            *ringing.unwrap() == rest
        };
        let (bands, _) = ear.hear((&silence, &silence), &parameters, 0.3);
        assert!(bands.mid.iter().all(|level| *level == 0.0) && still(bands.ringing));
        let (bands, _) = ear.hear((&sound, &sound), &parameters, 0.3);
        assert!(bands.mid.iter().any(|level| *level > 1e-3) && !still(bands.ringing));
    }

    #[test]
    fn an_ear_that_goes_on_forgets_what_it_heard_long_ago_and_fades_from_what_was_heard_since() {
        let (rate_hz, parameters) = (48_000, Parameters::default());
        let mut ear = Ear::new(rate_hz).unwrap();
        ear.tune(rate_hz, &parameters).unwrap();
        let frames = ear.frames(Ear::LONGEST_SECS);
        let tone: Vec<f32> = (0..frames).map(|i| 0.5 * (i as f32 * 0.06).sin()).collect();
        let silence = vec![0.0; frames];
        ear.hear((&tone, &tone), &parameters, Ear::LONGEST_SECS);
        assert!(ear.heard().0.mid.iter().any(|level| *level > 0.1));
        // What was heard of a known song since.
        let level = vec![0.4; 128];
        let [mid, side, left, right] = std::array::from_fn(|_| level.clone());
        let since = Spectrum { mid, side, left, right, side_gain: 2.0 };
        let mut ringing = Ringing::default();
        ringing.still(128);
        ear.go_on_from((since, ringing.clone(), Harmony::default()));
        // It begins there, however much sound it hears at first.
        let (bands, _) = ear.hear((&silence, &silence), &parameters, Ear::LONGEST_SECS);
        assert!(bands.mid.iter().chain(bands.side).all(|level| (level - 0.4).abs() < 1e-5));
        let (bands, _) = ear.hear((&silence, &silence), &parameters, 0.5 * FADE_SECS);
        assert!(bands.mid.iter().all(|level| (0.1..0.39).contains(level)));
        let (bands, _) = ear.hear((&silence, &silence), &parameters, FADE_SECS);
        assert!(bands.mid.iter().all(|level| *level == 0.0) && *bands.ringing.unwrap() == ringing);
    }

    #[test]
    fn windows_are_near_each_other_and_not_more_than_pictures_where_these_are_many() {
        for (dt_secs, hops_due) in [(0.0, 1), (1.0 / 144.0, 1), (1.0 / 60.0, 1), (0.05, 2), (0.3, 12)] {
            let (count, hop_secs) = hops(dt_secs);
            assert_eq!(count, hops_due);
            assert!(hop_secs <= HOP_SECS + 1e-9 && (f64::from(count) * hop_secs - dt_secs).abs() < 1e-9);
        }
        assert_eq!(hops(1000.0), (40, HOP_SECS));
        assert_eq!(hops(f64::NAN).0, 1);
    }

    #[test]
    fn beats_never_go_back() {
        let mut beats = BeatCount::default();
        // The tracker takes a beat back that it had not announced yet.
        assert_eq!([0.5, 0.99, 0.02, 0.6].map(|phase| beats.at(phase)), [0.5, 0.99, 0.99, 0.99]);
        beats.gone += 1.0;
        assert_eq!([0.05, 0.5].map(|phase| beats.at(phase)), [1.05, 1.5]);
    }
}
