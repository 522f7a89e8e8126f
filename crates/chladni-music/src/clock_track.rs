//! The beat of an outer clock, kept with a show, so that a film has the beats that were danced to.

use serde::{Deserialize, Serialize};

use crate::Beat;
use crate::tempo::QUARTERS_PER_BAR as BAR;

/// A clock that runs otherwise than was expected by less than this many beats runs as expected: 10 ms at 120 beats a
/// minute, a third of a frame.
const TOLERANCE_BEATS: f64 = 0.02;
/// Counts and tempi of a file beyond these are refused.
const MOST_BEATS: f64 = 1e8;
const MOST_BPM: f64 = 4000.0;

/// From this time of the show on, the beat follows an external clock, or stops following it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ClockMark {
    /// Since the show began.
    pub at_secs: f64,
    /// Beats gone by then.
    pub count: f64,
    /// Beats per minute from then on: 0 while the clock stands still, `None` where the beat is again the one detected
    /// in the music.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bpm: Option<f64>,
    /// Bars begin where the count is this and a multiple of four.
    #[serde(default)]
    pub bar: f64,
    /// A bar begins with this mark whose count is up to a bar before, as after a start just behind a beat: the count does
    /// not go back.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub begins: bool,
}

/// A bar of the clock.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClockBar {
    /// When it began.
    pub at_secs: f64,
    /// How long it takes at the tempo that it began with.
    pub secs: f64,
}

/// How the clock of a show ran. Between two marks it goes on evenly, and no beat goes back.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct ClockTrack {
    marks: Vec<ClockMark>,
}

impl ClockMark {
    fn count_at(&self, at_secs: f64) -> f64 {
        self.count + (at_secs - self.at_secs).max(0.0) * self.bpm.unwrap_or(0.0) / 60.0
    }
}

impl ClockTrack {
    /// Whether no clock was ever followed.
    pub fn is_empty(&self) -> bool {
        self.marks.is_empty()
    }

    /// The marks, oldest first.
    pub fn marks(&self) -> &[ClockMark] {
        &self.marks
    }

    /// Whether times and counts are finite, in order and within bounds, as a file may not have them.
    pub fn is_sound(&self) -> bool {
        let is_sound = |mark: &ClockMark| {
            mark.at_secs.is_finite()
                && (0.0..=MOST_BEATS).contains(&mark.count)
                && mark.bpm.is_none_or(|bpm| (0.0..=MOST_BPM).contains(&bpm))
                && (0.0..BAR).contains(&mark.bar)
        };
        let follows =
            |pair: &[ClockMark]| pair[1].at_secs >= pair[0].at_secs && pair[1].count >= pair[0].count;
        self.marks.iter().all(is_sound) && self.marks.windows(2).all(follows)
    }

    /// The beat at `at_secs`, later than all so far, is that of a clock. Its last bar began with the count `bar_count`, and
    /// each further one begins a multiple of four later; since the last call one has begun, or not.
    pub fn follow(&mut self, at_secs: f64, beat: Beat, bpm: f64, (bar_count, has_begun): (f64, bool)) {
        let bpm = if beat.confidence > 0.0 { bpm.clamp(0.0, MOST_BPM) } else { 0.0 };
        let bar = bar_count.rem_euclid(BAR);
        // A bar whose count comes after the last mark follows from that one.
        let begun = beat.count - (beat.count - bar).rem_euclid(BAR);
        let follows = self.marks.last().is_some_and(|last| {
            last.bpm.is_some_and(|bpm| bpm > 0.0) && last.bar == bar && begun > last.count - 1e-6
        });
        let begins = has_begun && !follows;
        let is_expected = self.marks.last().is_some_and(|last| {
            let goes_on = last.bpm.is_some_and(|known| (known > 0.0) == (bpm > 0.0));
            goes_on && last.bar == bar && (last.count_at(at_secs) - beat.count).abs() < TOLERANCE_BEATS
        });
        if (begins || !is_expected) && at_secs.is_finite() && beat.count.is_finite() {
            let least = self.marks.last().map_or(0.0, |last| last.count);
            // A bar that has begun does not begin again after this mark, as where its first beat is heard late.
            let least = if bpm > 0.0 { least.max(bar_count + 2e-6) } else { least };
            let count = beat.count.max(least).min(MOST_BEATS);
            self.marks.push(ClockMark { at_secs, count, bpm: Some(bpm), bar, begins });
        }
    }

    /// From `at_secs` on, later than all so far, no clock is followed.
    pub fn leave(&mut self, at_secs: f64) {
        if let Some(last) = self.marks.last().filter(|last| last.bpm.is_some()) {
            let count = last.count_at(at_secs).min(MOST_BEATS);
            self.marks.push(ClockMark { at_secs, count, bpm: None, bar: 0.0, begins: false });
        }
    }

    /// Live input ends at `at_secs`, later than all so far, after `beat`. No song knows the beats that came in live: they
    /// count as those of a clock that is left then.
    pub fn leave_live(&mut self, at_secs: f64, beat: Beat) {
        self.follow(at_secs, beat, 0.0, (0.0, false));
        self.leave(at_secs);
    }

    /// Forgets how the clock ran after `at_secs`, as where a show that was known to its end goes on otherwise.
    pub fn cut(&mut self, at_secs: f64) {
        let begun = self.begun(at_secs);
        self.marks.truncate(begun);
    }

    /// The mark that determines the beat at `at_secs`; none before the first.
    pub fn mark_at(&self, at_secs: f64) -> Option<&ClockMark> {
        self.marks.get(self.begun(at_secs).checked_sub(1)?)
    }

    /// The beat of the clock at `at_secs`; `None` where none is followed.
    pub fn beat_at(&self, at_secs: f64) -> Option<Beat> {
        let begun = self.begun(at_secs);
        let mark = self.marks.get(begun.checked_sub(1)?)?;
        let bpm = mark.bpm?;
        let most = self.marks.get(begun).map_or(f64::INFINITY, |next| next.count);
        let confidence = if bpm > 0.0 { 1.0 } else { 0.0 };
        Some(Beat { count: mark.count_at(at_secs).min(most), confidence })
    }

    /// When the clock that is followed at `at_secs` was taken up.
    pub fn followed_since(&self, at_secs: f64) -> Option<f64> {
        let begun = self.begun(at_secs);
        let followed = self.marks.get(..begun)?.iter().rev().take_while(|mark| mark.bpm.is_some());
        followed.last().map(|mark| mark.at_secs)
    }

    /// The bars of the clock that have begun after `from_secs`, up to `to_secs`.
    pub fn bars_between(&self, from_secs: f64, to_secs: f64) -> Vec<ClockBar> {
        let first = self.begun(from_secs).saturating_sub(1);
        let mut bars = Vec::new();
        for (i, mark) in self.marks.iter().enumerate().skip(first).take_while(|(_, m)| m.at_secs <= to_secs) {
            let Some(bpm) = mark.bpm.filter(|bpm| *bpm > 0.0) else { continue };
            let next = self.marks.get(i + 1);
            let end_secs = next.map_or(to_secs, |next| next.at_secs.min(to_secs));
            let most = next.map_or(f64::INFINITY, |next| next.count);
            let before = i.checked_sub(1).and_then(|i| self.marks.get(i));
            let gone = match before.filter(|before| before.bpm.is_some() && before.bar == mark.bar) {
                _ if mark.begins => mark.count - BAR,
                // A bar that a correction met is not counted twice.
                Some(before) => before.count_at(mark.at_secs).min(mark.count),
                // One under way where the clock is taken up, or counts otherwise, began before.
                None => mark.count - 1e-6,
            };
            // Bars long before are not asked for.
            let gone = gone.max(mark.count_at(from_secs) - BAR);
            let mut count = ((gone - mark.bar) / BAR).floor() * BAR + BAR + mark.bar;
            while count <= mark.count_at(end_secs).min(most) {
                let at_secs = mark.at_secs + (count - mark.count).max(0.0) * 60.0 / bpm;
                if at_secs > from_secs && at_secs <= to_secs {
                    bars.push(ClockBar { at_secs, secs: 60.0 * BAR / bpm });
                }
                count += BAR;
            }
        }
        bars
    }

    fn begun(&self, at_secs: f64) -> usize {
        self.marks.partition_point(|mark| mark.at_secs <= at_secs)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{ClockMessage, Tempo};

    /// A clock of 24 ticks a quarter that wavers and gets faster, as a window at 60 frames a second follows it.
    fn recorded() -> (ClockTrack, Vec<(f64, f64)>, Vec<f64>) {
        let (mut track, mut tempo) = (ClockTrack::default(), Tempo::default());
        let (mut seen, mut bars) = (Vec::new(), Vec::new());
        let (mut tick, mut due) = (0u32, 1.0);
        for frame in 60..3600 {
            let now_secs = f64::from(frame) / 60.0;
            while due <= now_secs {
                let waver = 0.003 * (f64::from(tick) * 2.4).sin();
                tempo.hear(ClockMessage::Tick, due + waver);
                let bpm = if tick < 1200 { 120.0 } else { 133.0 };
                due += 60.0 / (24.0 * bpm);
                tick += 1;
            }
            if let Some(bpm) = tempo.bpm() {
                let (beat, bar) = (tempo.at(now_secs), tempo.bar(now_secs, 1.0, false));
                track.follow(now_secs, beat, bpm, (tempo.bar_count(), bar.is_some()));
                seen.push((now_secs, beat.count));
                bars.extend(bar.map(|_| now_secs));
            }
        }
        (track, seen, bars)
    }

    #[test]
    fn few_marks_give_the_beats_that_were_seen() {
        let (track, seen, bars) = recorded();
        assert!(track.is_sound() && track.marks().len() < 200, "{} marks", track.marks().len());
        let mut last = 0.0;
        for (at_secs, count) in seen {
            let beat = track.beat_at(at_secs).unwrap();
            assert!((beat.count - count).abs() < 0.03, "{} instead of {count} at {at_secs}", beat.count);
            assert!(beat.count >= last);
            last = beat.count;
        }
        // The first bar was under way when the clock was known.
        let later = |bars: &[f64]| bars.iter().copied().filter(|at| *at > 2.5).collect::<Vec<_>>();
        let told: Vec<f64> = track.bars_between(0.0, 60.0).iter().map(|bar| bar.at_secs).collect();
        let (told, seen) = (later(&told), later(&bars));
        assert_eq!(told.len(), seen.len(), "{told:?} instead of {seen:?}");
        for (told, seen) in told.iter().zip(&seen) {
            assert!((told - seen).abs() < 0.04, "{told} instead of {seen}");
        }
        // However the time is cut, each bar comes once.
        let cut: Vec<f64> = (0..6000)
            .flat_map(|i| track.bars_between(0.01 * f64::from(i), 0.01 * f64::from(i + 1)))
            .map(|bar| bar.at_secs)
            .collect();
        let whole: Vec<f64> = track.bars_between(0.0, 60.0).iter().map(|bar| bar.at_secs).collect();
        assert_eq!(cut, whole);
    }

    #[test]
    fn a_clock_that_is_left_gives_no_beat_and_one_that_stops_stands_still() {
        let mut track = ClockTrack::default();
        let beat = |count, confidence| Beat { count, confidence };
        track.follow(1.0, beat(8.0, 1.0), 120.0, (0.0, false));
        track.follow(2.0, beat(10.0, 0.0), 120.0, (0.0, false));
        track.follow(3.0, beat(10.0, 1.0), 60.0, (2.0, false));
        track.leave(5.0);
        track.leave(6.0);
        assert_eq!(track.marks().len(), 4);
        assert_eq!(track.beat_at(0.5), None);
        assert_eq!(track.beat_at(1.5), Some(beat(9.0, 1.0)));
        assert_eq!(track.beat_at(2.5), Some(beat(10.0, 0.0)));
        assert_eq!(track.beat_at(4.5), Some(beat(11.5, 1.0)));
        assert_eq!(track.beat_at(5.0), None);
        assert_eq!(track.mark_at(7.0).map(|mark| mark.count), Some(12.0));
        assert_eq!([0.5, 4.0, 5.5].map(|at| track.followed_since(at)), [None, Some(1.0), None]);
        let bars = track.bars_between(0.0, 9.0);
        assert_eq!(bars.iter().map(|bar| bar.at_secs).collect::<Vec<_>>(), [1.0, 3.0]);
    }

    #[test]
    fn a_film_has_the_bars_of_a_clock_that_the_window_had() {
        // Taken up in the middle of a bar; started just after a beat; given its first beat; twice as fast.
        let changed = |frame: u32, tempo: &mut Tempo, now_secs: f64| match frame {
            60 => tempo.set(120.0, 7.2, 5.0, now_secs),
            211 => tempo.hear(ClockMessage::Start, now_secs),
            510 => tempo.hear(ClockMessage::Beat { in_bar: Some(1) }, now_secs),
            800 => tempo.double(now_secs),
            _ => {}
        };
        // The first beat of a bar is heard late, at twice the tempo.
        let late = |frame: u32, tempo: &mut Tempo, now_secs: f64| match frame {
            0 => {
                tempo.set(60.0, 0.0, 0.0, now_secs);
                tempo.double(now_secs);
            }
            258 => tempo.hear(ClockMessage::Beat { in_bar: Some(1) }, now_secs),
            _ => {}
        };
        type Played = fn(u32, &mut Tempo, f64);
        let clocks: [Played; 2] = [changed, late];
        // The picture is that of the message, or one just before.
        for (clock, late_secs) in clocks.into_iter().flat_map(|clock| [(clock, 0.0), (clock, 0.03)]) {
            let (mut track, mut tempo) = (ClockTrack::default(), Tempo::default());
            let mut bars = Vec::new();
            for frame in 0..1200 {
                let now_secs = f64::from(frame) / 60.0;
                clock(frame, &mut tempo, now_secs);
                if let Some(bpm) = tempo.bpm() {
                    let shown_secs = now_secs - late_secs;
                    let (beat, bar) = (tempo.at(shown_secs), tempo.bar(shown_secs, 1.0, false));
                    track.follow(now_secs, beat, bpm, (tempo.bar_count(), bar.is_some()));
                    bars.extend(bar.map(|_| now_secs));
                }
            }
            let film: Vec<f64> = track.bars_between(0.0, 20.0).iter().map(|bar| bar.at_secs).collect();
            assert_eq!(film.len(), bars.len(), "{film:?} instead of {bars:?}");
            let off = film.iter().zip(&bars).map(|(film, window)| (film - window).abs());
            assert!(off.fold(0.0, f64::max) < 0.04, "{film:?} instead of {bars:?}");
        }
    }

    #[test]
    fn a_bar_begins_with_a_mark_that_says_so() {
        let mark = |at_secs, count, bar, begins| ClockMark { at_secs, count, bpm: Some(120.0), bar, begins };
        let bars = |begins: bool| -> Vec<f64> {
            let marks = vec![mark(0.0, 0.0, 0.0, false), mark(10.6, 21.2, 1.0, begins)];
            let bars = ClockTrack { marks }.bars_between(9.0, 13.0);
            bars.iter().map(|bar| (100.0 * bar.at_secs).round() / 100.0).collect()
        };
        // Shows of before say nothing of it.
        assert_eq!((bars(false), bars(true)), (vec![10.0, 12.5], vec![10.0, 10.6, 12.5]));
    }

    #[test]
    fn a_clock_that_is_cut_goes_on_or_is_left_before_its_later_marks() {
        let mut track = ClockTrack::default();
        let beat = |count| Beat { count, confidence: 1.0 };
        track.follow(1.0, beat(8.0), 120.0, (0.0, false));
        track.follow(3.0, beat(20.0), 60.0, (0.0, false));
        track.cut(2.0);
        assert_eq!((track.marks().len(), track.beat_at(2.5)), (1, Some(beat(11.0))));
        track.leave(2.0);
        assert!(track.is_sound());
        assert_eq!((track.beat_at(2.5), track.mark_at(2.5).map(|mark| mark.count)), (None, Some(10.0)));
    }

    #[test]
    fn a_clock_of_a_file_goes_on_within_the_bounds_of_files() {
        let mark =
            ClockMark { at_secs: 0.0, count: MOST_BEATS, bpm: Some(MOST_BPM), bar: 0.0, begins: false };
        let mut track = ClockTrack { marks: vec![mark] };
        assert!(track.is_sound());
        track.leave(60.0);
        track.follow(61.0, Beat { count: 5.0, confidence: 1.0 }, 120.0, (0.0, false));
        assert!(track.is_sound());
        assert_eq!(track.mark_at(61.0).map(|mark| mark.count), Some(MOST_BEATS));
    }

    #[test]
    fn what_no_clock_does_is_refused() {
        let track = |marks: &[ClockMark]| ClockTrack { marks: marks.to_vec() };
        let mark = ClockMark { at_secs: 1.0, count: 4.0, bpm: Some(120.0), bar: 0.0, begins: false };
        assert!(track(&[mark, ClockMark { at_secs: 2.0, bpm: None, ..mark }]).is_sound());
        for wrong in [
            ClockMark { at_secs: f64::NAN, ..mark },
            ClockMark { count: -1.0, ..mark },
            ClockMark { count: 1e300, ..mark },
            ClockMark { bpm: Some(f64::INFINITY), ..mark },
            ClockMark { bar: 4.0, ..mark },
        ] {
            assert!(!track(&[wrong]).is_sound(), "{wrong:?}");
        }
        assert!(!track(&[mark, ClockMark { count: 3.0, ..mark }]).is_sound());
        assert!(!track(&[mark, ClockMark { at_secs: 0.5, ..mark }]).is_sound());
    }
}
