//! The beat of the sound, and the user's corrections.

use chladni_music::{BeatReading, ClockMessage};
use chladni_sound::{BeatMoment, Beats};

use super::Listening;
use crate::work::read_beats;

impl Listening {
    /// A tap by hand: the beats of a fully known song are shifted to it, or take the tempo of several, and an outer clock
    /// takes it as a beat.
    pub fn tap(&mut self) {
        if self.outer.wanted || self.follows_clock() {
            self.hear_clock(ClockMessage::Beat { in_bar: None }, self.last_secs);
        }
        if self.follows_clock() {
            return;
        }
        // A person taps to what is heard.
        let at_secs = self.clock.at_secs() - self.ahead_secs();
        let song_secs = self.hearing.stretch().map(|stretch| stretch.song_secs_at(at_secs));
        let known = self.song_with_beats().zip(song_secs);
        let is_taken = known.is_some_and(|(number, song_secs)| self.tap_song(number, song_secs));
        if !is_taken {
            self.ear.follower.tap(self.ear.follower.now_secs() - self.ahead_secs());
        }
    }

    /// Takes a tap at this time of a song, and reads its beats by it; false where no beats of it are known.
    fn tap_song(&mut self, number: usize, song_secs: f64) -> bool {
        let before = self.taps.take().filter(|(of, _)| *of == number);
        let mut taps = before.map(|(_, taps)| taps).unwrap_or_default();
        taps.add(song_secs);
        let reading = self.repertoire.get(number).and_then(|song| {
            let (found, mut reading) = (song.beats.as_ref()?, song.reading);
            if !reading.hear(&taps, &found.beats_secs) {
                let gap_secs = gap_secs(&read_beats(found, reading).beats_secs, song_secs)?;
                reading.shift(gap_secs);
            }
            Some(reading)
        });
        self.taps = Some((number, taps));
        let Some(reading) = reading else { return false };
        self.read_otherwise(number, |known| *known = reading);
        true
    }

    /// The beat half as fast.
    pub fn halve(&mut self) {
        if self.follows_clock() {
            let at_secs = self.shown_secs();
            return self.outer.tempo.halve(at_secs);
        }
        match self.song_with_beats() {
            Some(number) => self.read_otherwise(number, |reading| reading.change_octave(-1)),
            None => self.ear.follower.halve(),
        }
    }

    /// The beat twice as fast.
    pub fn double(&mut self) {
        if self.follows_clock() {
            let at_secs = self.shown_secs();
            return self.outer.tempo.double(at_secs);
        }
        match self.song_with_beats() {
            Some(number) => self.read_otherwise(number, |reading| reading.change_octave(1)),
            None => self.ear.follower.double(),
        }
    }

    /// The song that is heard, where its beats are known.
    pub(super) fn song_with_beats(&self) -> Option<usize> {
        self.known_beats().map(|(number, _)| number)
    }

    /// The song that is heard, and its beats, where they are known.
    pub(super) fn known_beats(&self) -> Option<(usize, &Beats)> {
        let number = self.hearing.stretch().filter(|_| self.live.is_none())?.song?;
        Some((number, self.hearing.song(number)?.beats.as_ref()?))
    }

    pub(super) fn read_otherwise(&mut self, number: usize, change: impl FnOnce(&mut BeatReading)) {
        let Some(song) = self.repertoire.get_mut(number) else { return };
        change(&mut song.reading);
        if let Some(beats) = &song.beats {
            self.hearing.know_beats(number, read_beats(beats, song.reading));
            self.beats_changed = true;
        }
    }

    /// The beat as known now.
    pub fn beat_moment(&self) -> BeatMoment {
        if let Some(moment) = self.clock_moment() {
            return moment;
        }
        let Some((_, beats)) = self.known_beats() else { return self.ear.follower.moment() };
        let beat = self.hearing.beat_at(self.clock.at_secs());
        let phase = beat.count.rem_euclid(1.0);
        let left_secs = if beats.tempo_bpm > 0.0 { (1.0 - phase) * 60.0 / beats.tempo_bpm } else { 0.0 };
        BeatMoment {
            tempo_bpm: beats.tempo_bpm,
            phase,
            next_beat_secs: self.clock.at_secs() + left_secs,
            confidence: f64::from(beat.confidence),
        }
    }
}

/// How much later the nearest beat must come to fall on a tap. Before the first beat and after the last one they go on
/// as they do there.
fn gap_secs(beats_secs: &[f64], tap_secs: f64) -> Option<f64> {
    let beyond = |beat: f64, spacing_secs: f64| {
        let gap_secs = tap_secs - beat;
        let whole = if spacing_secs > 0.0 { (gap_secs / spacing_secs).round() } else { 0.0 };
        gap_secs - whole * spacing_secs
    };
    let next = beats_secs.partition_point(|beat| *beat < tap_secs);
    match (beats_secs.get(..next)?, beats_secs.get(next..)?) {
        ([], [first, second, ..]) => Some(beyond(*first, second - first)),
        ([.., before, last], []) => Some(beyond(*last, last - before)),
        (before, after) => {
            let gaps = before.last().into_iter().chain(after.first()).map(|beat| tap_secs - beat);
            gaps.min_by(|a, b| a.abs().total_cmp(&b.abs()))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tap_by_ear_is_of_what_is_heard() {
        let mut listening = Listening::start(&egui::Context::default(), 1.0, None).unwrap();
        let silence = vec![0.0; 4 * 44_100];
        listening.ear.follower.push(&silence, &silence);
        listening.show_ahead(0.125);
        listening.tap();
        let heard_secs = listening.ear.follower.now_secs() - 0.125;
        let off = (listening.ear.follower.moment_at(heard_secs).phase + 0.5).fract() - 0.5;
        assert!(off.abs() < 0.05, "{off} beats beside the tap");
    }

    #[test]
    fn a_tap_moves_the_beats_by_half_of_one_at_most() {
        let beats_secs: Vec<f64> = (0..40).map(|n| 100.0 + 0.5 * f64::from(n)).collect();
        for (tap_secs, expected) in
            [(100.1, 0.1), (100.4, -0.1), (119.6, 0.1), (10.1, 0.1), (0.0, 0.0), (300.15, 0.15)]
        {
            let found = gap_secs(&beats_secs, tap_secs).unwrap();
            assert!((found - expected).abs() < 1e-9, "{tap_secs}: {found}");
        }
        assert_eq!(gap_secs(&[2.0], 5.0), Some(3.0));
        assert_eq!(gap_secs(&[], 5.0), None);
    }
}
