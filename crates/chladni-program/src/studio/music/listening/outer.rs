//! The beat of an outer clock, in place of the one that is heard.

use std::time::Instant;

use chladni_music::{BarLine, Beat, ClockMessage, Tempo};
use chladni_sound::BeatMoment;

use super::Listening;
use crate::work::BeatCount;

/// An outer clock, and what only the music can tell: energy and sections.
#[derive(Default)]
pub struct Outer {
    pub tempo: Tempo,
    /// Whether the preferences ask for it.
    pub wanted: bool,
    /// Whether it was followed in the last frame.
    pub was_followed: bool,
    /// The tempo is one of the music that is held: no clock has given it.
    is_of_music: bool,
    /// The music's, since the last bar of the clock.
    section_begins: bool,
    /// A bar of the clock that has begun with the last beat, until it is reported.
    fresh_bar: Option<BarLine>,
    /// The count with which the last bar began, where the beats are still counted alike.
    pub bar_count: Option<f64>,
}

/// How much goes on, and how many bars and sections have begun since listening began.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Progress {
    pub bars: u32,
    pub sections: u32,
    /// In [0, 1], of the bar that began last.
    pub energy: f32,
    /// Bars of an outer clock begin where its count is this and a multiple of four; `None` where none is followed.
    pub bar_offset: Option<f64>,
}

impl Progress {
    fn hear(&mut self, bar: &BarLine) {
        self.bars = self.bars.wrapping_add(1);
        self.sections = self.sections.wrapping_add(u32::from(bar.begins_section));
        self.energy = bar.energy;
    }
}

impl Listening {
    /// Whether the beat of an outer clock is to be followed. Until one is heard the beat stays that of the music.
    pub fn want_clock(&mut self, on: bool) {
        self.outer.wanted = on;
    }

    /// Takes a clock's message at `at_secs` of the clock that [`hear`](Self::hear) uses.
    pub fn hear_clock(&mut self, message: ClockMessage, at_secs: f64) {
        match message {
            // The first that a clock says: the beat of the music goes on at its tempo.
            ClockMessage::Tempo { bpm }
                if self.last_beat.confidence > 0.0 && self.outer.tempo == Tempo::default() =>
            {
                self.outer.tempo = self.music_at(bpm);
            }
            _ => self.outer.tempo.hear(message, at_secs),
        }
    }

    /// Whether the beat is that of an outer clock, or locked.
    pub fn follows_clock(&self) -> bool {
        let Outer { tempo, wanted, .. } = &self.outer;
        tempo.is_known() && (*wanted || tempo.is_locked())
    }

    /// Whether tempo and beat go on as they are.
    pub fn is_locked(&self) -> bool {
        self.outer.tempo.is_locked()
    }

    /// Goes on at the present tempo, whatever is heard; or listens again.
    pub fn lock(&mut self, on: bool) {
        if on && !self.follows_clock() {
            let tempo = self.music_at(self.beat_moment().tempo_bpm);
            if !tempo.is_known() {
                return self.warnings.push("There is no tempo to hold yet.".into());
            }
            (self.outer.tempo, self.outer.is_of_music) = (tempo, true);
        }
        self.outer.tempo.lock(on);
        if !on {
            let is_of_music = std::mem::take(&mut self.outer.is_of_music);
            if is_of_music || !self.outer.wanted {
                self.outer.tempo = Tempo::default();
            }
        }
    }

    /// The beat and the bars of the music, as they go on at a tempo from the moment that is shown.
    fn music_at(&self, bpm: f64) -> Tempo {
        let count = self.last_beat.count;
        let bar_count = self.outer.bar_count.unwrap_or(count.floor());
        let mut tempo = Tempo::default();
        tempo.set(bpm, count, bar_count, self.shown_secs());
        tempo
    }

    /// Moves the beat; positive comes sooner.
    pub fn nudge(&mut self, secs: f64) {
        if self.follows_clock() {
            return self.outer.tempo.nudge(secs);
        }
        match self.song_with_beats() {
            Some(number) => self.read_otherwise(number, |reading| reading.shift(-secs)),
            None => {
                self.warnings.push("A beat that is heard live cannot be nudged: tap it, or hold it.".into())
            }
        }
    }

    /// The beat, as it was heard last, for others, to whom a pause has none.
    pub fn sent_beat(&self) -> Beat {
        let runs = self.follows_clock() || self.live.is_some() || self.plays_songs();
        Beat { confidence: if runs { self.last_beat.confidence } else { 0.0 }, ..self.last_beat }
    }

    /// When that was, for those who go on counting from it.
    pub fn heard_at(&self) -> Instant {
        self.heard_at
    }

    /// Bars, sections and energy so far.
    pub fn progress(&self) -> Progress {
        self.progress
    }

    /// The beat at this moment, of the clock where it is followed.
    pub(super) fn beat_or(&mut self, by_music: Beat) -> Beat {
        let follows = self.follows_clock();
        if follows != std::mem::replace(&mut self.outer.was_followed, follows) {
            self.change_clock(follows);
        }
        let at_secs = self.clock.at_secs();
        if !follows {
            // Where a song is counted otherwise, its bar has begun with another count.
            if !(0.0..2.0).contains(&(by_music.count - self.last_beat.count)) {
                self.outer.bar_count = None;
            }
            self.progress.bar_offset = None;
            self.hearing.leave_clock(at_secs);
            return by_music;
        }
        let shown_secs = self.shown_secs();
        let tempo = &mut self.outer.tempo;
        let (beat, bar_offset) = (tempo.at(shown_secs), tempo.bar_offset());
        // What the next message changes does not change this bar. Its energy is known where it is reported.
        let fresh_bar = tempo.bar(shown_secs, 0.0, false);
        // A show that is filmed later has these beats and bars.
        let bpm = tempo.bpm().unwrap_or(0.0);
        self.hearing.follow_clock(at_secs, beat, bpm, (tempo.bar_count(), fresh_bar.is_some()));
        self.outer.fresh_bar = fresh_bar;
        self.progress.bar_offset = Some(bar_offset);
        self.outer_beat = beat;
        beat
    }

    /// The bars to report: those of the clock where the last beat was its, with what `of_music` say of energy and sections.
    pub(super) fn bars_or(&mut self, of_music: Vec<BarLine>) -> Vec<BarLine> {
        let bars = if self.outer.was_followed {
            let outer = &mut self.outer;
            if let Some(last) = of_music.last() {
                self.progress.energy = last.energy;
            }
            outer.section_begins |= of_music.iter().any(|bar| bar.begins_section);
            let bar = outer.fresh_bar.take().map(|bar| {
                let begins_section = std::mem::take(&mut outer.section_begins);
                BarLine { energy: self.progress.energy, begins_section, ..bar }
            });
            if let Some(bar) = bar {
                self.director.hear(bar);
            }
            // The show has its own time.
            bar.map(|bar| BarLine { at_secs: self.clock.at_secs(), ..bar }).into_iter().collect()
        } else {
            of_music
        };
        if !bars.is_empty() {
            self.outer.bar_count = Some(self.last_beat.count.floor());
        }
        bars.iter().for_each(|bar| self.progress.hear(bar));
        bars
    }

    pub(super) fn clock_moment(&self) -> Option<BeatMoment> {
        let tempo_bpm = self.outer.tempo.bpm().filter(|_| self.follows_clock())?;
        let Beat { count, confidence } = self.outer_beat;
        let phase = count.rem_euclid(1.0);
        let next_beat_secs = self.shown_secs() + (1.0 - phase) * 60.0 / tempo_bpm;
        Some(BeatMoment { tempo_bpm, phase, next_beat_secs, confidence: f64::from(confidence) })
    }

    /// The time of the outer clock that the picture shows.
    pub(super) fn shown_secs(&self) -> f64 {
        self.last_secs + self.ahead_secs()
    }

    /// No beat goes back: the count goes on from that of the clock before.
    fn change_clock(&mut self, follows: bool) {
        if follows {
            self.outer.tempo.go_on_from(self.last_beat.count, self.shown_secs());
        } else {
            self.ear.beats = BeatCount::from(self.outer_beat.count);
            // Past actions are counted again in the beats of the song, where these are known.
            self.beats_changed |= self.known_beats().is_some();
        }
        self.film_anew();
    }

    /// Bars now have another time.
    fn film_anew(&mut self) {
        let at_secs = if self.follows_clock() { self.shown_secs() } else { self.ear.follower.now_secs() };
        self.director = self.director.anew(at_secs);
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use chladni_music::Stretch;
    use chladni_sound::{Beats, sample_tune, sample_tune_beats_secs};

    use super::super::Message;
    use super::*;
    use crate::work::KnownSong;

    /// A song whose beats are known, and the preference for a clock.
    fn listening() -> Listening {
        let mut listening = Listening::start(&egui::Context::default(), 1.0, None).unwrap();
        let beats = Beats { tempo_bpm: 112.0, beats_secs: sample_tune_beats_secs(), ..Beats::default() };
        listening.hearing.know(0, KnownSong::new(Arc::new(sample_tune())).unwrap());
        listening.hearing.know_beats(0, beats);
        let (song, crossfade_secs) = (Some(0), 0.0);
        let stretch = Stretch { at_secs: 0.0, song, song_secs: 2.0, playing: true, crossfade_secs };
        listening.hearing.begin(stretch).unwrap();
        listening.want_clock(true);
        listening
    }

    #[test]
    fn a_tempo_of_the_music_that_was_held_is_forgotten() {
        let mut listening = listening();
        for _ in 0..2 {
            assert!(!listening.follows_clock());
            listening.lock(true);
            assert!(listening.follows_clock());
            assert_eq!(listening.beat_moment().tempo_bpm.round(), 112.0);
            listening.lock(false);
        }
        assert!(!listening.follows_clock());
    }

    /// The beats and bars of frames from one time to another, a tenth of a second apart, as the window asks for them.
    fn frames(listening: &mut Listening, from_secs: f64, to_secs: f64) -> Vec<(f64, usize)> {
        let mut seen = Vec::new();
        for frame in 0..((to_secs - from_secs) * 10.0) as u32 {
            let bars = listening.bars_or(Vec::new()).len();
            seen.push((listening.last_beat.count, bars));
            listening.last_secs = from_secs + 0.1 * f64::from(frame);
            listening.last_beat = listening.beat_or(listening.last_beat);
        }
        seen
    }

    #[test]
    fn a_tempo_that_is_held_keeps_the_bars_of_the_music() {
        let mut listening = listening();
        listening.last_beat = Beat { count: 11.1, confidence: 1.0 };
        let bar = BarLine { at_secs: 0.0, secs: 2.0, energy: 0.5, begins_section: false };
        assert_eq!(listening.bars_or(vec![bar]).len(), 1);
        // The third beat of its bar sounds.
        listening.last_beat.count = 13.5;
        listening.lock(true);
        let seen = frames(&mut listening, 0.1, 4.1);
        let begin: Vec<f64> =
            seen.iter().filter(|(_, bars)| *bars > 0).map(|(count, _)| count.floor()).collect();
        assert_eq!(begin, [15.0, 19.0]);
    }

    #[test]
    fn the_first_tempo_of_a_clock_leaves_the_beat_in_its_place() {
        let mut listening = listening();
        listening.last_beat = Beat { count: 12.37, confidence: 1.0 };
        listening.last_secs = 5.0;
        listening.hear_clock(ClockMessage::Tempo { bpm: 120.0 }, 5.005);
        let seen = frames(&mut listening, 5.1, 5.35);
        assert!((seen[1].0 - 12.57).abs() < 1e-6, "{seen:?}");
    }

    #[test]
    fn no_bar_begins_where_a_clock_is_taken_up() {
        // With its first tempo, and where that and a start came earlier: bars begin 2, 4 and 6 s after it.
        for (known, from_secs, begin) in [(false, 5.05, 1), (true, 8.8, 2)] {
            let mut listening = listening();
            listening.want_clock(!known);
            listening.hear_clock(ClockMessage::Tempo { bpm: 120.0 }, 5.04);
            if known {
                listening.hear_clock(ClockMessage::Start, 5.04);
            }
            listening.want_clock(true);
            let seen = frames(&mut listening, from_secs, from_secs + 3.4);
            let bars: usize = seen.iter().map(|(_, bars)| bars).sum();
            assert_eq!(bars, begin, "{seen:?}");
        }
    }

    #[test]
    fn a_clock_that_is_not_followed_is_no_tempo_to_hold() {
        let mut listening = Listening::start(&egui::Context::default(), 1.0, None).unwrap();
        listening.hear_clock(ClockMessage::Tempo { bpm: 90.0 }, 1.0);
        listening.lock(true);
        assert!(!listening.is_locked() && !listening.follows_clock());
        assert!(listening.messages().contains(&Message::Warning("There is no tempo to hold yet.".into())));
    }

    #[test]
    fn others_are_sent_no_beat_in_a_pause() {
        let mut listening = listening();
        listening.last_beat.confidence = 1.0;
        let began = Instant::now();
        while listening.sent_beat().confidence != 0.0 {
            assert!(began.elapsed() < chladni_testdata::HANGS);
            listening.player.pause();
            std::thread::sleep(std::time::Duration::from_millis(5));
        }
        listening.lock(true);
        assert_eq!(listening.sent_beat().confidence, 1.0);
    }

    #[test]
    fn a_clock_that_was_held_is_followed_again() {
        let mut listening = listening();
        listening.lock(true);
        listening.lock(false);
        listening.hear_clock(ClockMessage::Tempo { bpm: 90.0 }, 1.0);
        listening.lock(true);
        listening.lock(false);
        assert!(listening.follows_clock());
    }
}
