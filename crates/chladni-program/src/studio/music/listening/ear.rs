//! The samples that the live ear is given, and when it forgets the beat.

use chladni_music::BarLine;
use chladni_sound::PlayerStatus;

use super::Listening;
use crate::work::{BeatCount, Ear, ShowClock};

/// If the song's position deviates from the clock by more than this, the user has sought: the beat tracker is
/// reset.
const SEEK_SECS: f64 = 0.3;

/// A longer pause between two frames is not caught up.
const LONGEST_STEP_SECS: f64 = 2.0;

/// How loud one channel is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Loudness {
    /// Largest amplitude, falling by 20 dB a second.
    pub peak: f32,
    /// Root mean square of the current sound.
    pub rms: f32,
}

impl Loudness {
    pub(super) fn of(samples: &[f32], before: Self, dt_secs: f64) -> Self {
        let (peak, square) =
            samples.iter().fold((0.0f32, 0.0f32), |(peak, square), s| (peak.max(s.abs()), square + s * s));
        let fallen = before.peak * 0.1f32.powf(dt_secs as f32);
        let rms = (square / samples.len().max(1) as f32).sqrt();
        Self { peak: peak.max(if fallen > 1e-3 { fallen } else { 0.0 }), rms }
    }
}

impl Listening {
    /// Hears a song by itself once it is `known`, and anything else by the ear; the beats count on from the last. Returns how
    /// long a sound the ear is to take in.
    pub(super) fn change_ears(
        &mut self,
        at_secs: f64,
        (known, has_beats): (bool, bool),
        dt_secs: f64,
    ) -> f64 {
        if std::mem::replace(&mut self.had_beats, has_beats) && !has_beats {
            self.ear.beats = BeatCount::from(self.last_beat.count);
        }
        match (std::mem::replace(&mut self.by_ear, !known), known) {
            (true, true) => self.hearing.fade_from(at_secs, self.ear.heard(), self.last_beat),
            (false, false) => {
                self.ear.go_on_from(self.hearing.heard());
                // What an ear heard before a known song may be minutes old.
                return Ear::LONGEST_SECS;
            }
            (true, false) | (false, true) => {}
        }
        dt_secs
    }

    /// The samples of the last `dt_secs` to analyze: around the position heard in a song, later by the delay of the
    /// decay; the newest ones of live input.
    pub(super) fn take_window(&mut self, playing: bool, dt_secs: f64) {
        let frames = self.ear.frames(dt_secs);
        self.left.resize(frames, 0.0);
        self.right.resize(frames, 0.0);
        match &self.live {
            Some(live) => {
                live.window(&mut self.left, &mut self.right);
                [&mut self.left, &mut self.right].into_iter().for_each(|side| self.input.amplify(side));
            }
            None => {
                let late = self.ear.analyzer().lag_secs() * f64::from(self.ear.rate_hz());
                let ahead = self.ear.analyzer().window_frames() / 2 + late as usize;
                self.player.heard_window(ahead, &mut self.left, &mut self.right);
            }
        }
        if !playing {
            self.left.fill(0.0);
            self.right.fill(0.0);
        }
    }

    /// Feeds the tracker with the live sound of the last `dt_secs`.
    pub(super) fn take_live(&mut self, dt_secs: f64) {
        let Some(live) = &mut self.live else { return };
        self.left.clear();
        self.right.clear();
        live.take(dt_secs, &mut self.left, &mut self.right);
        [&mut self.left, &mut self.right].into_iter().for_each(|side| self.input.amplify(side));
        if let Some(tee) = &mut self.tee {
            tee.rate_hz = live.capture.rate_hz();
            if tee.until.take().is_some() {
                tee.breaks.push(tee.left.len());
            }
            tee.left.extend_from_slice(&self.left);
            tee.right.extend_from_slice(&self.right);
        }
        self.follow_beat();
    }

    /// Feeds the tracker with the sound since the last frame.
    pub(super) fn follow_song(&mut self, status: &PlayerStatus, since_last_secs: f64) {
        let step_secs = status.position_secs - self.last_position_secs;
        // Nothing is heard twice.
        if ShowClock::stumbles(step_secs, status.position_secs) {
            return;
        }
        self.last_position_secs = status.position_secs;
        let paused = step_secs == 0.0;
        let sought = !paused && (step_secs - since_last_secs).abs() > SEEK_SECS;
        if sought || !(0.0..LONGEST_STEP_SECS).contains(&step_secs) {
            return self.forget_beat();
        }
        let frames = (step_secs * f64::from(status.rate_hz)).round() as usize;
        self.left.resize(frames, 0.0);
        self.right.resize(frames, 0.0);
        self.player.heard_window(0, &mut self.left, &mut self.right);
        self.follow_beat();
    }

    /// Feeds the tracker with the samples taken.
    fn follow_beat(&mut self) {
        for bar in self.ear.follow(&self.left, &self.right) {
            if !self.follows_clock() {
                self.director.hear(bar);
            }
            // Nobody may ask for them for hours.
            self.fresh_bars.truncate(8);
            self.fresh_bars.push(BarLine { at_secs: self.clock.at_secs(), ..bar });
        }
    }

    /// After a seek the old beat is meaningless; a tracker that cannot be reset continues as it is.
    pub(super) fn forget_beat(&mut self) {
        let _ = self.ear.follower.reset();
        if !self.follows_clock() {
            self.director = self.director.anew(0.0);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_beat_is_forgotten_after_a_seek_and_not_where_the_device_stumbles() {
        let mut listening = Listening::start(&egui::Context::default(), 1.0, None).unwrap();
        let silence = vec![0.0; 44_100];
        listening.ear.follower.push(&silence, &silence);
        listening.last_position_secs = 5.0;
        let mut heard_secs = |position_secs: f64| {
            let status = PlayerStatus { position_secs, rate_hz: 44_100, ..PlayerStatus::default() };
            listening.follow_song(&status, 0.016);
            listening.ear.follower.now_secs()
        };
        assert_eq!([4.95, 4.96, 5.2, 4.5].map(&mut heard_secs), [1.0, 1.0, 1.2, 0.0]);
    }
}
