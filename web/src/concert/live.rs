//! A microphone in place of a song.

use chladni_music::{BarLine, Beat, ClockTrack, Director, Framing, Instrument, Parameters};
use chladni_program::work::{BeatCount, Ear, Error, Heard};
use wasm_bindgen::prelude::*;

use super::Concert;

/// A slow picture counts as this long: sound may be waiting behind it.
const LONGEST_STEP_SECS: f64 = 0.1;

/// The latest live sound, and the ear that listens to it.
pub(super) struct Live {
    rate_hz: u32,
    /// The ear that listens.
    pub ear: Ear,
    /// As long as the ear may want to hear at once; silence before the first sound.
    left: Vec<f32>,
    right: Vec<f32>,
    last_secs: f64,
    /// How long no sound has come; `None` where some came since it was analyzed last.
    quiet_secs: Option<f64>,
    /// As it was heard last.
    beat: Beat,
    director: Director,
    /// Bars that began since they were asked for.
    bars: Vec<BarLine>,
}

impl Live {
    /// Whole beats are counted on from `gone`.
    fn new(rate_hz: u32, instrument: &Instrument, gone: f64) -> Result<Self, Error> {
        let mut ear = Ear::new(rate_hz)?;
        ear.tune(rate_hz, instrument.parameters())?;
        ear.beats = BeatCount::from(gone);
        let silence = vec![0.0; ear.frames(Ear::LONGEST_SECS)];
        let (left, right) = (silence.clone(), silence);
        let director = Director::live(instrument.seed(), 0.0);
        let beat = Beat { count: gone, confidence: 0.0 };
        let (last_secs, quiet_secs, bars) = (0.0, None, Vec::new());
        Ok(Self { rate_hz, ear, left, right, last_secs, quiet_secs, beat, director, bars })
    }

    fn take(&mut self, left: &[f32], right: &[f32], seed: u64) {
        self.director.set_seed(seed);
        self.quiet_secs = None;
        for bar in self.ear.follow(left, right) {
            self.director.hear(bar);
            // Only an autopilot asks for them.
            self.bars.truncate(8);
            self.bars.push(bar);
        }
        for (kept, new) in [(&mut self.left, left), (&mut self.right, right)] {
            let fresh = &new[new.len().saturating_sub(kept.len())..];
            kept.drain(..fresh.len());
            kept.extend_from_slice(fresh);
        }
    }

    /// Analyzes the sound at `at_secs` of the show.
    pub fn hear(&mut self, at_secs: f64, parameters: &Parameters) -> Result<Heard<'_>, Error> {
        self.ear.tune(self.rate_hz, parameters)?;
        let frames = self.ear.frames(Ear::LONGEST_SECS);
        for kept in [&mut self.left, &mut self.right] {
            let longer = kept.len().saturating_sub(frames);
            kept.drain(..longer);
            let missing = frames - kept.len();
            kept.splice(..0, std::iter::repeat_n(0.0, missing));
        }
        let dt_secs = (at_secs - std::mem::replace(&mut self.last_secs, at_secs)).max(1e-3);
        let quiet_secs = self.quiet_secs.map_or(0.0, |secs| secs + dt_secs.min(LONGEST_STEP_SECS));
        self.quiet_secs = Some(quiet_secs);
        if quiet_secs > Ear::QUIET_SECS {
            self.left.fill(0.0);
            self.right.fill(0.0);
        }
        self.beat = self.ear.beat();
        let (bands, harmony) = self.ear.hear((&self.left, &self.right), parameters, dt_secs);
        Ok(Heard { at_secs, is_known: false, bands, harmony, beat: self.beat, fading: None })
    }

    /// How the camera frames it.
    pub fn framing(&mut self) -> Framing {
        self.director.at(self.ear.follower.now_secs())
    }

    /// The bars that have begun since the last call, as of `at_secs` of the show.
    pub fn new_bars(&mut self, at_secs: f64) -> Vec<BarLine> {
        self.bars.drain(..).map(|bar| BarLine { at_secs, ..bar }).collect()
    }
}

#[wasm_bindgen]
impl Concert {
    /// Listens to sound as it comes in at `rate_hz`, in place of a song.
    ///
    /// # Errors
    /// A rate out of range.
    pub fn listen(&mut self, rate_hz: u32) -> Result<(), JsError> {
        // No beat goes back.
        let gone = self.beat_at(self.clock.at_secs()).ceil();
        let before = self.live.as_ref().map_or_else(|| self.hearing.heard(), |live| live.ear.heard());
        let mut live = Live::new(rate_hz, &self.instrument, gone)?;
        live.ear.go_on_from(before);
        self.live = Some(live);
        Ok(())
    }

    /// Takes sound that has come in since the last call, as many frames of both channels.
    pub fn take_sound(&mut self, left: &[f32], right: &[f32]) {
        if let Some(live) = &mut self.live {
            live.take(left, right, self.instrument.seed());
        }
    }

    /// Back to the songs.
    pub fn stop_listening(&mut self) {
        if let Some(live) = self.live.take() {
            let at_secs = self.clock.at_secs();
            self.hearing.leave_live(at_secs, live.beat);
            self.hearing.fade_from(at_secs, live.ear.heard(), live.beat);
        }
    }
}

impl Concert {
    /// Beats gone by at a time of the show; while it is live, those heard so far.
    pub(super) fn beat_at(&self, at_secs: f64) -> f64 {
        self.live.as_ref().map_or_else(|| self.hearing.beat_at(at_secs), |live| live.beat).count
    }

    /// The clock of the show so far, as if live input ended now.
    pub(super) fn clock_track(&self) -> ClockTrack {
        let (mut track, at_secs) = (self.hearing.clock().clone(), self.clock.at_secs());
        // That of a show that is played is known to its end.
        track.cut(at_secs);
        if let Some(live) = &self.live {
            track.leave_live(at_secs, live.beat);
        }
        track
    }
}
