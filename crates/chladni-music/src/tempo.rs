//! A beat that is given by MIDI clock, by OSC or by taps, instead of being heard.

use crate::clock::{ClockMessage, TICKS_PER_QUARTER};
use crate::pulses::Pulses;
use crate::{BarLine, Beat};

/// Quarters per bar, which MIDI clock does not transmit.
pub(crate) const QUARTERS_PER_BAR: f64 = 4.0;
/// The slowest and the fastest tempo, in beats per minute.
const TEMPI_BPM: std::ops::RangeInclusive<f64> = 20.0..=400.0;
/// A beat that comes sooner after another one than at the fastest tempo is the same, heard twice.
pub(crate) const SAME_BEAT_SECS: f64 = 60.0 / *TEMPI_BPM.end();
/// Bars are missing where a gap is a whole number of them too long, but for this share of one; a beat is the next where
/// its gap is one beat, likewise.
const BAR_TOLERANCE: f64 = 0.1;
/// How often the tempo may be halved or doubled.
const MOST_OCTAVES: i32 = 3;

/// Evenly spaced quarters: their count at one time, and their number per second.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Grid {
    quarters: f64,
    at_secs: f64,
    per_sec: f64,
}

impl Grid {
    fn at(&self, secs: f64) -> f64 {
        self.quarters + (secs - self.at_secs) * self.per_sec
    }
}

/// Follows a beat that is given. All times are in seconds, on one steady clock.
///
/// The jitter of ticks and taps is filtered: a straight line is fitted to the last two quarters of ticks,
/// or the last eight taps. If a clock falls silent, the beat continues at its last tempo. Bars have four
/// beats.
#[derive(Clone, Debug, PartialEq)]
pub struct Tempo {
    ticks: Pulses,
    beats: Pulses,
    /// The place in its bar of the last beat, from 0, where that was said.
    beat_place: Option<f64>,
    /// The position in the song, in quarters, at the last tick.
    position: f64,
    /// A message has said where the next tick falls.
    is_placed: bool,
    grid: Option<Grid>,
    runs: bool,
    /// Beats per quarter, as a power of two; and the whole number of beats that is added.
    octave: i32,
    origin: f64,
    nudge_secs: f64,
    is_locked: bool,
    /// The count that was returned last: it never decreases.
    shown: f64,
    told_bar: Option<f64>,
}

impl Default for Tempo {
    fn default() -> Self {
        Self {
            ticks: Pulses::new(2 * TICKS_PER_QUARTER as usize, TICKS_PER_QUARTER as usize / 2, 0.5),
            beats: Pulses::new(8, 2, 2.0),
            beat_place: None,
            // Until the position is known, the first tick is assumed to be a beat.
            position: -1.0 / TICKS_PER_QUARTER,
            is_placed: false,
            grid: None,
            // Many clocks run without ever sending a start message.
            runs: true,
            octave: 0,
            origin: 0.0,
            nudge_secs: 0.0,
            is_locked: false,
            shown: 0.0,
            told_bar: None,
        }
    }
}

impl Tempo {
    /// Whether a tempo is known.
    pub fn is_known(&self) -> bool {
        self.grid.is_some()
    }

    /// Takes a message of a clock at `at_secs`. Does nothing while locked.
    pub fn hear(&mut self, message: ClockMessage, at_secs: f64) {
        if self.is_locked || !at_secs.is_finite() {
            return;
        }
        match message {
            ClockMessage::Tick => self.tick(at_secs),
            ClockMessage::Lost { ticks } => self.skip(ticks),
            ClockMessage::Start => self.jump(0.0, at_secs),
            ClockMessage::Continue => {
                if let Some(grid) = self.grid.as_mut().filter(|_| !self.runs) {
                    grid.at_secs = at_secs;
                }
                // One that has never stopped goes on from where the beat has come to meanwhile.
                self.is_placed |= !self.runs;
                self.runs = true;
                self.ticks.clear();
            }
            ClockMessage::Stop => self.stop(at_secs),
            ClockMessage::Position { quarters } => {
                let runs = self.runs;
                self.jump(quarters, at_secs);
                self.runs = runs;
            }
            ClockMessage::Tempo { bpm } => self.set_tempo(bpm, at_secs),
            ClockMessage::Beat { in_bar } => self.beat(in_bar, at_secs),
        }
    }

    /// Continues at `bpm` beats per minute, with a count of `count` beats at `at_secs`, and with a bar that began at
    /// `bar_count`, a whole one.
    pub fn set(&mut self, bpm: f64, count: f64, bar_count: f64, at_secs: f64) {
        if TEMPI_BPM.contains(&bpm) && count.is_finite() && bar_count.is_finite() {
            let (origin, quarters, is_locked) = (bar_count, count - bar_count, self.is_locked);
            let grid = Some(Grid { quarters, at_secs, per_sec: bpm / 60.0 });
            *self = Self { grid, origin, is_locked, shown: count, ..Self::default() };
            self.told_bar = self.bar_under_way(at_secs);
        }
    }

    /// Continues with the count of another clock.
    pub fn go_on_from(&mut self, count: f64, at_secs: f64) {
        self.shown = count;
        self.rebase(count, at_secs);
        // Its bar that is under way began while it was not followed.
        self.told_bar = None;
    }

    /// The beat at `secs`. Its count never decreases.
    pub fn at(&mut self, secs: f64) -> Beat {
        if let Some(count) = self.count(secs) {
            self.shown = self.shown.max(count);
        }
        let confidence = if self.is_known() && self.runs { 1.0 } else { 0.0 };
        Beat { count: self.shown, confidence }
    }

    /// Beats per minute; `None` before the first tempo is known.
    pub fn bpm(&self) -> Option<f64> {
        Some(60.0 * self.grid?.per_sec * self.beats_per_quarter())
    }

    /// The bar that has begun since the last call, if there is one. `energy` and `begins_section` describe
    /// the music.
    pub fn bar(&mut self, secs: f64, energy: f32, begins_section: bool) -> Option<BarLine> {
        let grid = self.grid.filter(|_| self.runs)?;
        let per_bar = QUARTERS_PER_BAR / self.beats_per_quarter();
        let bar = self.bar_under_way(secs)?;
        // A bar that is under way where a clock is taken up began before.
        if *self.told_bar.get_or_insert(bar) >= bar {
            return None;
        }
        self.told_bar = Some(bar);
        let at_secs = grid.at_secs + (bar * per_bar - grid.quarters) / grid.per_sec - self.nudge_secs;
        Some(BarLine { at_secs, secs: per_bar / grid.per_sec, energy, begins_section })
    }

    /// The number of the beat within its bar, from 1.
    #[cfg(test)]
    fn beat_in_bar(&self, secs: f64) -> Option<u32> {
        Some(1 + self.beats_of_song(secs)?.floor().rem_euclid(QUARTERS_PER_BAR) as u32)
    }

    /// Bars begin where the count of [`at`](Self::at) is this and a multiple of four.
    pub fn bar_offset(&self) -> f64 {
        self.origin.rem_euclid(QUARTERS_PER_BAR)
    }

    /// The count of [`at`](Self::at) with which the last bar of [`bar`](Self::bar) began; before any, that of the bar under
    /// way.
    pub fn bar_count(&self) -> f64 {
        let told = self.told_bar.map(|bar| self.origin + QUARTERS_PER_BAR * bar);
        told.unwrap_or_else(|| self.shown - (self.shown - self.origin).rem_euclid(QUARTERS_PER_BAR))
    }

    /// Moves the beat; with a positive value it comes sooner.
    pub fn nudge(&mut self, secs: f64) {
        self.nudge_secs = (self.nudge_secs + secs).clamp(-1.0, 1.0);
    }

    /// Halves the number of beats per minute.
    pub fn halve(&mut self, at_secs: f64) {
        self.change_octave(self.octave - 1, at_secs);
    }

    /// Doubles the number of beats per minute.
    pub fn double(&mut self, at_secs: f64) {
        self.change_octave(self.octave + 1, at_secs);
    }

    /// Whether it ignores the clock and continues as it is.
    pub fn is_locked(&self) -> bool {
        self.is_locked
    }

    /// Locks it, which makes it ignore the clock, or unlocks it.
    pub fn lock(&mut self, on: bool) {
        self.is_locked = on;
    }

    fn beats_per_quarter(&self) -> f64 {
        2f64.powi(self.octave)
    }

    /// The place in the song at `secs`, in quarters; a clock that was stopped stands still.
    fn place(&self, secs: f64) -> Option<f64> {
        self.grid.map(|grid| if self.runs { grid.at(secs) } else { grid.quarters })
    }

    /// The beats from the beginning of the song to `secs`.
    fn beats_of_song(&self, secs: f64) -> Option<f64> {
        Some(self.place(secs + self.nudge_secs)? * self.beats_per_quarter())
    }

    fn count(&self, secs: f64) -> Option<f64> {
        Some(self.origin + self.beats_of_song(secs)?)
    }

    /// The number of the bar at `secs`, from the beginning of the song.
    fn bar_under_way(&self, secs: f64) -> Option<f64> {
        Some((self.beats_of_song(secs)? / QUARTERS_PER_BAR).floor())
    }

    /// The place in the song is another one: a bar that begins with it is new, one under way is not. The picture may lag
    /// behind the message: no bar before it begins.
    fn bar_anew(&mut self, quarters: f64) {
        let beats = quarters * self.beats_per_quarter();
        self.told_bar = self.grid.map(|_| ((beats - 0.5) / QUARTERS_PER_BAR).floor());
    }

    fn tick(&mut self, at_secs: f64) {
        let begins = self.ticks.last_secs().is_none() && !std::mem::take(&mut self.is_placed);
        let silent = self.ticks.add(at_secs) || begins;
        if self.runs {
            self.position += 1.0 / TICKS_PER_QUARTER;
        }
        if let Some(grid) = self.grid.filter(|_| silent && self.runs) {
            // Meanwhile the beat has continued by itself: the position moves by whole quarters to the
            // nearest one.
            self.position += (grid.at(at_secs) - self.position).round();
        }
        match (self.ticks.line(), self.grid) {
            (Some((due_secs, gap_secs)), _) => {
                let per_sec = 1.0 / (gap_secs * TICKS_PER_QUARTER);
                if TEMPI_BPM.contains(&(60.0 * per_sec)) {
                    let at_secs = if self.runs { due_secs } else { at_secs };
                    self.follow(Grid { quarters: self.position, at_secs, per_sec });
                }
            }
            // The first ticks of a song give its position; the tempo is still the previous one.
            (None, Some(grid)) => self.grid = Some(Grid { quarters: self.position, at_secs, ..grid }),
            (None, None) => {}
        }
    }

    /// Whether ticks have come until now.
    fn ticks_come(&self, at_secs: f64) -> bool {
        self.ticks.last_secs().is_some_and(|last_secs| at_secs - last_secs <= self.ticks.longest_gap_secs)
    }

    /// Counts ticks whose times are unknown: the tempo stays the previous one until enough ticks are heard.
    fn skip(&mut self, ticks: u32) {
        if self.runs {
            self.position += f64::from(ticks) / TICKS_PER_QUARTER;
        }
        // A line through the ticks on both sides of the gap would be too flat.
        self.ticks.clear();
        self.is_placed = true;
    }

    fn stop(&mut self, at_secs: f64) {
        if let Some(grid) = self.grid.filter(|_| self.runs) {
            // Stops at the tick that was heard last, or at the current count if there were none of late.
            if !self.ticks_come(at_secs) {
                self.position = grid.at(at_secs);
            }
            self.grid = Some(Grid { quarters: self.position, at_secs, ..grid });
        }
        self.runs = false;
    }

    /// Sets the position in the song, in quarters, of the next tick, or of this moment if there are no
    /// ticks.
    fn jump(&mut self, quarters: f64, at_secs: f64) {
        let count = self.shown.max(self.count(at_secs).unwrap_or(0.0));
        self.runs = true;
        self.position = quarters - 1.0 / TICKS_PER_QUARTER;
        self.is_placed = true;
        let gap_secs = self.ticks.line().map_or(0.0, |(_, gap_secs)| gap_secs);
        if let Some(grid) = self.grid {
            self.grid = Some(Grid { quarters, at_secs: at_secs + gap_secs, ..grid });
        }
        self.ticks.clear();
        self.origin = (count - quarters * self.beats_per_quarter()).round();
        self.bar_anew(quarters);
    }

    fn set_tempo(&mut self, bpm: f64, at_secs: f64) {
        if TEMPI_BPM.contains(&bpm) {
            let quarters = self.place(at_secs).unwrap_or(0.0);
            self.follow(Grid { quarters, at_secs, per_sec: bpm / 60.0 });
        }
    }

    fn beat(&mut self, in_bar: Option<u32>, at_secs: f64) {
        let place = in_bar.map(|beat| f64::from(beat.saturating_sub(1)).rem_euclid(QUARTERS_PER_BAR));
        self.add_beat(place, at_secs);
        // The first beat of its song, or the nearest quarter if a clock is ticking.
        let quarters = self.place(at_secs).unwrap_or(0.0);
        let whole = match place {
            Some(place) => ((quarters - place) / QUARTERS_PER_BAR).round() * QUARTERS_PER_BAR + place,
            None => quarters.round(),
        };
        let moved = whole - quarters;
        let ticks = self.ticks_come(at_secs);
        let line = self.beats.line().filter(|(_, gap)| TEMPI_BPM.contains(&(60.0 / gap)) && !ticks);
        match (line, self.grid) {
            (Some((due_secs, gap_secs)), _) => {
                self.follow(Grid { quarters: whole, at_secs: due_secs, per_sec: 1.0 / gap_secs });
            }
            (None, Some(grid)) => {
                self.grid = Some(Grid { quarters: grid.quarters + moved, ..grid });
                self.position += moved;
            }
            (None, None) => {}
        }
        // A move to another place in the bar must not step the beat.
        let moved_beats = (moved * self.beats_per_quarter()).round();
        self.origin -= moved_beats;
        // Less than half a quarter is the same place, heard sooner or later.
        if moved_beats != 0.0 && moved.abs() >= 0.5 {
            self.bar_anew(whole);
        }
    }

    /// Takes a beat into their line. One whose place in the bar is said, as that of the one before it was, comes as
    /// many beats after it as that says: messages get lost, and some clocks send only bars.
    fn add_beat(&mut self, place: Option<f64>, at_secs: f64) {
        let before = self.beat_place;
        let apart = place.zip(before).map(|(place, before)| (place - before).rem_euclid(QUARTERS_PER_BAR));
        let gap_secs = self.beats.last_secs().map_or(f64::INFINITY, |last_secs| at_secs - last_secs);
        if (0.0..SAME_BEAT_SECS).contains(&gap_secs) && apart.is_none_or(|apart| apart == 0.0) {
            self.beat_place = place.or(before);
            return self.beats.put_again(at_secs);
        }
        self.beat_place = place;
        // One that comes a beat later at the tempo so far is the next one, also where its bar is counted anew.
        let is_next = self.grid.is_some_and(|grid| (gap_secs * grid.per_sec - 1.0).abs() < BAR_TOLERANCE);
        let Some(apart) = apart.filter(|_| !is_next) else {
            self.beats.add(at_secs);
            return;
        };
        let least = if apart > 0.0 { apart } else { QUARTERS_PER_BAR };
        // Whole bars are missing, too, where the gap is that long at the tempo so far; any other gap is another tempo.
        // Of bars alone, one missing each time cannot be distinguished from half the tempo: the tempo so far is kept.
        let bars = self.grid.map_or(0.0, |grid| (gap_secs * grid.per_sec - least) / QUARTERS_PER_BAR);
        let whole = bars.round();
        let missing = if (bars - whole).abs() < BAR_TOLERANCE { whole.max(0.0) } else { 0.0 };
        self.beats.add_after(least + missing * QUARTERS_PER_BAR, least, at_secs);
    }

    fn follow(&mut self, grid: Grid) {
        let first = self.grid.replace(grid).is_none();
        if first {
            self.rebase(self.shown, grid.at_secs);
        }
    }

    fn rebase(&mut self, count: f64, at_secs: f64) {
        if let Some(quarters) = self.place(at_secs) {
            self.origin = (count - quarters * self.beats_per_quarter()).ceil();
        }
    }

    fn change_octave(&mut self, octave: i32, at_secs: f64) {
        let octave = octave.clamp(-MOST_OCTAVES, MOST_OCTAVES);
        if octave == self.octave {
            return;
        }
        let count = self.at(at_secs).count;
        self.octave = octave;
        self.told_bar = self.bar_under_way(at_secs);
        self.rebase(count, at_secs);
    }
}

#[cfg(test)]
mod tests;
