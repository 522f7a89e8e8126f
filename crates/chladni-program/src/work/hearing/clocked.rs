//! Beats, bars and framing of a show: those of an outer clock while one is followed, otherwise those of its
//! songs.

use chladni_music::{BarLine, Beat, ClockTrack, Director, Framing, Moment};

use super::Hearing;
use super::songs::Seam;

/// A clock, and who films to it.
#[derive(Default)]
pub(super) struct Clocked {
    track: ClockTrack,
    director: Option<ClockDirector>,
}

struct ClockDirector {
    /// When the clock was taken up.
    since_secs: f64,
    /// Until when its bars were heard.
    heard_secs: f64,
    director: Director,
}

impl Hearing {
    /// The clock of the show so far.
    pub fn clock(&self) -> &ClockTrack {
        &self.clocked.track
    }

    /// The clock that the whole show was played to.
    pub fn know_clock(&mut self, track: ClockTrack) {
        self.clocked = Clocked { track, director: None };
    }

    /// The beat at `at_secs`, later than all so far, is that of a clock ([`ClockTrack::follow`]).
    pub fn follow_clock(&mut self, at_secs: f64, beat: Beat, bpm: f64, bars: (f64, bool)) {
        self.clocked.track.follow(at_secs, beat, bpm, bars);
    }

    /// From `at_secs` on, later than all so far, the beat is that of the songs.
    pub fn leave_clock(&mut self, at_secs: f64) {
        self.clocked.track.leave(at_secs);
    }

    /// From `at_secs` on, the clock of a show that was known to its end is followed no longer.
    pub fn give_up_clock(&mut self, at_secs: f64) {
        self.clocked.track.cut(at_secs);
        self.leave_clock(at_secs);
    }

    /// Live input ends at `at_secs`, later than all so far, after `beat` ([`ClockTrack::leave_live`]).
    pub fn leave_live(&mut self, at_secs: f64, beat: Beat) {
        self.clocked.track.leave_live(at_secs, beat);
    }

    /// Beats gone by at a moment at which something was done. Those of live input stay as they were counted.
    pub fn beats_at(&self, moment: Moment) -> f64 {
        let is_live = self.stretch_at(moment.at_secs).is_some_and(|(stretch, _)| stretch.song.is_none());
        if is_live { moment.at_beat } else { self.beat_at(moment.at_secs).count }
    }

    /// Beats gone by at any time of the show so far.
    pub fn beat_at(&self, at_secs: f64) -> Beat {
        let track = &self.clocked.track;
        if let Some(beat) = track.beat_at(at_secs) {
            return beat;
        }
        let beat = self.beat_by_songs(at_secs);
        Beat { count: self.seam_after_clocks(at_secs).count(beat.count), ..beat }
    }

    /// How the count goes on with the songs at a time when no clock is followed, so that it does not go back from that of
    /// the clock, or of live input, before.
    fn seam_after_clocks(&self, at_secs: f64) -> Seam {
        let track = &self.clocked.track;
        let (mut ends, mut until_secs, mut clocked) = (Vec::new(), at_secs, false);
        while let Some(left) = track.mark_at(until_secs).filter(|_| !clocked) {
            ends.push(left);
            until_secs = left.at_secs.next_down();
            clocked = track.beat_at(until_secs).is_some();
        }
        // A recording of live input may have more beats than were counted when it came in. Those of a song do not
        // count while a clock is followed.
        let nothing = Seam { gone: f64::NEG_INFINITY, added: f64::NEG_INFINITY };
        let before = if clocked { nothing } else { Seam::default() };
        ends.iter().rev().fold(before, |seam, left| {
            let least = seam.count(self.beat_by_songs(left.at_secs.next_down()).count);
            Seam::after(left.count.max(least), self.beat_by_songs(left.at_secs).count)
        })
    }

    /// The bars that have begun after `from_secs` of the show, up to `to_secs`.
    pub fn bars_between(&self, from_secs: f64, to_secs: f64) -> Vec<BarLine> {
        let track = &self.clocked.track;
        if track.beat_at(to_secs).is_none() {
            return self.bars_of_songs(from_secs, to_secs);
        }
        let bars = track.bars_between(from_secs, to_secs);
        bars.into_iter()
            .map(|bar| {
                // A clock has neither energy nor sections: those of the music, here since the bar before.
                let of_music = self.bars_of_songs(bar.at_secs - bar.secs, bar.at_secs);
                let energy = self.energy_by_songs(bar.at_secs);
                let begins_section = of_music.iter().any(|bar| bar.begins_section);
                BarLine { at_secs: bar.at_secs, secs: bar.secs, energy, begins_section }
            })
            .collect()
    }

    /// How the camera frames the shape then: by the bars that are heard, and the seeds at times of the show, up to
    /// this one.
    pub fn framing_at(&mut self, at_secs: f64, seed_at: impl Fn(f64) -> u64) -> Framing {
        let Some(since_secs) = self.clocked.track.followed_since(at_secs) else {
            return self.framing_by_songs(at_secs, seed_at);
        };
        let known = self.clocked.director.take();
        let fits = known.filter(|known| known.since_secs == since_secs && known.heard_secs <= at_secs);
        let mut filming = fits.unwrap_or_else(|| {
            // A performance played to a clock is filmed like live sound, whether a song or live input plays.
            let director = Director::of_song(seed_at(since_secs), since_secs);
            ClockDirector { since_secs, heard_secs: since_secs - 1e-9, director }
        });
        let bars = self.bars_between(filming.heard_secs, at_secs);
        for bar in bars {
            filming.director.set_seed(seed_at(bar.at_secs));
            filming.director.hear(bar);
        }
        filming.heard_secs = at_secs;
        self.clocked.director.insert(filming).director.at(at_secs)
    }
}

#[cfg(test)]
mod tests {
    use chladni_music::{ClockMark, Parameters, Stretch};
    use chladni_sound::{Bar, Beats, Section};

    use super::super::tests::{hearing, stretch};
    use super::*;

    /// A clock of another tempo than the tune's, from 2 to 9 s.
    fn clocked() -> Hearing {
        let mut hearing = hearing();
        let mut track = ClockTrack::default();
        track.follow(2.0, Beat { count: 5.0, confidence: 1.0 }, 150.0, (1.0, false));
        track.leave(9.0);
        hearing.know_clock(track);
        let bars = (0..6).map(|i| Bar { at_secs: 2.0 * f64::from(i), beats: 4 }).collect();
        let sections = vec![Section { at_secs: 6.0, name: 'A', energy: 0.8 }];
        let beats_secs = (0..24).map(|i| 0.5 * f64::from(i)).collect();
        hearing.know_beats(0, Beats { bars, sections, beats_secs, energy: vec![0.8], ..Beats::default() });
        hearing.begin(stretch(0.0, 0.0, true)).unwrap();
        hearing
    }

    #[test]
    fn beats_and_bars_are_the_clocks_where_it_was_followed() {
        let hearing = clocked();
        let songs = hearing.beat_by_songs(1.5);
        assert_eq!(hearing.beat_at(1.5), songs);
        assert_eq!(hearing.beat_at(4.0).count, 10.0);
        let mut last = 0.0;
        for i in 0..1200 {
            let count = hearing.beat_at(0.01 * f64::from(i)).count;
            assert!(i < 210 || count >= last, "{count} after {last}");
            last = count;
        }
        let bars: Vec<f64> = hearing.bars_between(1.9, 8.9).iter().map(|bar| bar.at_secs).collect();
        assert_eq!(bars.len(), 5, "{bars:?}");
        assert!(bars.iter().enumerate().all(|(i, at)| (at - 2.0 - 1.6 * i as f64).abs() < 1e-9), "{bars:?}");
        // Energy and sections are those of the song; the section of 6 s begins with the bar after it.
        let told = hearing.bars_between(1.9, 8.9);
        assert!(told.iter().all(|bar| bar.energy == 0.8));
        let begin: Vec<f64> = told.iter().filter(|bar| bar.begins_section).map(|bar| bar.at_secs).collect();
        assert_eq!(begin.len(), 1, "{begin:?}");
        assert!((begin[0] - 6.8).abs() < 1e-9);
    }

    #[test]
    fn the_energy_is_the_songs_wherever_in_its_bar_it_goes_on() {
        let mut hearing = clocked();
        for (at_secs, playing) in [(5.0, true), (6.0, false), (8.0, true)] {
            hearing.begin(stretch(at_secs, 4.5, playing)).unwrap();
        }
        // Bars of the clock begin at 5.2, 6.8 and 8.4 s, each before the song's next one.
        let energy = hearing.bars_between(5.0, 8.5).iter().map(|bar| bar.energy).collect::<Vec<_>>();
        assert_eq!(energy, [0.8, 0.0, 0.8]);
    }

    #[test]
    fn a_frame_is_filmed_alike_however_it_is_reached() {
        let film = |seed_at: &dyn Fn(f64) -> u64| -> Vec<Framing> {
            let mut hearing = clocked();
            (0..300).map(|i| hearing.framing_at(f64::from(i) / 25.0, seed_at)).collect()
        };
        // Another gallery begins while the clock is followed.
        let seed_at = |secs: f64| if secs < 7.5 { 7 } else { 8 };
        let (frames, before, after) = (film(&seed_at), film(&|_| 7), film(&|_| 8));
        let mut leaping = clocked();
        for i in [299, 120, 0, 226, 60, 61] {
            assert_eq!(leaping.framing_at(i as f64 / 25.0, seed_at), frames[i]);
        }
        // Shots that have begun go on.
        assert_eq!(frames[..188], before[..188]);
        assert!(frames[188..] != before[188..] && before[..188] != after[..188]);
    }

    #[test]
    fn no_beat_goes_back_where_a_clock_is_given_up_or_live_input_ends() {
        let mut given_up = clocked();
        let before = given_up.beat_at(5.0).count;
        given_up.give_up_clock(5.0);
        assert!(given_up.beat_at(5.0).count >= before && given_up.clock().beat_at(5.0).is_none());
        let mut live = hearing();
        live.begin(Stretch { song: None, ..stretch(0.0, 0.0, true) }).unwrap();
        live.begin(stretch(6.0, 2.0, true)).unwrap();
        live.leave_live(6.0, Beat { count: 500.0, confidence: 1.0 });
        assert!((500.0..502.0).contains(&live.beat_at(6.0).count), "{:?}", live.beat_at(6.0));
        let done = |at_secs| live.beats_at(Moment { at_secs, at_beat: 77.0 });
        assert_eq!([3.0, 7.0].map(done), [77.0, live.beat_at(7.0).count]);
    }

    #[test]
    fn the_count_waits_for_the_songs_where_live_input_ends_just_after_their_beat() {
        let mut live = hearing();
        live.begin(Stretch { song: None, ..stretch(0.0, 0.0, true) }).unwrap();
        live.begin(stretch(6.0, 2.0, true)).unwrap();
        let [begins, later] = [6.0, 6.5].map(|at_secs| live.beat_at(at_secs).count);
        live.leave_live(6.0, Beat { count: begins + 100.01, confidence: 1.0 });
        let counted = [6.0, 6.5].map(|at_secs| live.beat_at(at_secs).count);
        assert!((counted[0] - begins - 100.01).abs() < 1e-9, "{counted:?} after {begins}");
        assert!((counted[1] - later - 100.0).abs() < 1e-9, "{counted:?} after {later}");
    }

    #[test]
    fn no_beat_goes_back_where_a_recording_has_more_beats_than_live_input_had() {
        // Of 17 and 25 beats, the ear found 15 and 22.
        let mut filmed = hearing();
        let beats_secs: Vec<f64> = (0..40).map(|i| 0.25 * f64::from(i)).collect();
        filmed.know_beats(0, Beats { beats_secs, confidence: 1.0, ..Beats::default() });
        for at_secs in [0.0, 4.0, 6.0] {
            filmed.begin(stretch(at_secs, 0.0, true)).unwrap();
        }
        let mut last = filmed.beat_at(0.0).count;
        for (end_secs, count) in [(4.0, 15.0), (6.0, 22.0)] {
            filmed.leave_live(end_secs, Beat { count, confidence: 1.0 });
        }
        for i in 0..800 {
            let count = filmed.beat_at(0.01 * f64::from(i)).count;
            assert!((last..last + 2.0).contains(&count), "{count} after {last}");
            last = count;
        }
    }

    #[test]
    fn what_is_followed_live_is_what_the_show_keeps() {
        let (mut live, mut told) = (hearing(), Vec::new());
        live.begin(stretch(0.0, 0.0, true)).unwrap();
        for i in 0..600 {
            let at_secs = f64::from(i) / 60.0;
            if (100..500).contains(&i) {
                let count = 3.0 + 2.2 * (at_secs - 100.0 / 60.0);
                live.follow_clock(at_secs, Beat { count, confidence: 1.0 }, 132.0, (0.0, false));
            } else {
                live.leave_clock(at_secs);
            }
            told.push(live.beat_at(at_secs).count);
        }
        let mut filmed = Hearing::default();
        filmed.know(0, super::super::tests::known());
        filmed.tune(0.0, &Parameters::default());
        let kept: Vec<Stretch> = live.stretches().collect();
        filmed.go_on(&kept, live.clock().clone());
        assert_eq!(filmed.clock().marks().len(), 2, "{:?}", filmed.clock());
        assert!(matches!(
            filmed.clock().marks(),
            [ClockMark { bpm: Some(_), .. }, ClockMark { bpm: None, .. }]
        ));
        for (i, told) in told.iter().enumerate() {
            let count = filmed.beat_at(i as f64 / 60.0).count;
            assert!((count - told).abs() < 0.02, "{count} instead of {told} in frame {i}");
        }
    }
}
