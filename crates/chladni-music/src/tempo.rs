//! A beat that is given rather than heard: by MIDI clock, by OSC or by a hand.

use crate::clock::{ClockMessage, TICKS_PER_QUARTER};
use crate::pulses::Pulses;
use crate::{BarLine, Beat};

/// Quarters in a bar, as MIDI clock does not tell.
const QUARTERS_PER_BAR: f64 = 4.0;
/// The slowest and the fastest tempo, in beats a minute.
const TEMPI_BPM: std::ops::RangeInclusive<f64> = 20.0..=400.0;
/// The tempo may be halved and doubled so often.
const MOST_OCTAVES: i32 = 3;

/// Quarters that go by evenly: their count at one time, and how many go by a second.
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

/// Follows a beat that is given. All times are seconds of one steadily running clock.
///
/// The jitter of ticks and taps is filtered: a straight line goes through the last two quarters of ticks, or the last
/// eight taps. A clock that falls silent goes on at its last tempo. Bars have four beats.
#[derive(Clone, Debug, PartialEq)]
pub struct Tempo {
    ticks: Pulses,
    beats: Pulses,
    /// Quarters of the song at the last tick.
    position: f64,
    grid: Option<Grid>,
    runs: bool,
    /// Beats a quarter, as a power of two, and the whole beats that are added.
    octave: i32,
    origin: f64,
    nudge_secs: f64,
    is_locked: bool,
    /// The count never goes back.
    shown: f64,
    told_bar: Option<f64>,
}

impl Default for Tempo {
    fn default() -> Self {
        Self {
            ticks: Pulses::new(2 * TICKS_PER_QUARTER as usize, TICKS_PER_QUARTER as usize / 2, 0.5),
            beats: Pulses::new(8, 2, 2.0),
            // The first tick falls on a beat, as far as anybody knows.
            position: -1.0 / TICKS_PER_QUARTER,
            grid: None,
            // Many clocks run without ever saying that they start.
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

    /// Takes what a clock said at `at_secs`. Locked, it listens to nothing.
    pub fn hear(&mut self, message: ClockMessage, at_secs: f64) {
        if self.is_locked || !at_secs.is_finite() {
            return;
        }
        match message {
            ClockMessage::Tick => self.tick(at_secs),
            ClockMessage::Start => self.jump(0.0, at_secs),
            ClockMessage::Continue => {
                self.runs = true;
                self.ticks.secs.clear();
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

    /// Goes on at `bpm` beats a minute, of which `count` have gone by at `at_secs`.
    pub fn set(&mut self, bpm: f64, count: f64, at_secs: f64) {
        if TEMPI_BPM.contains(&bpm) && count.is_finite() {
            *self =
                Self { origin: count.floor(), shown: count, is_locked: self.is_locked, ..Self::default() };
            self.grid = Some(Grid { quarters: count.fract(), at_secs, per_sec: bpm / 60.0 });
        }
    }

    /// Lets the count go on from that of another clock.
    pub fn go_on_from(&mut self, count: f64, at_secs: f64) {
        self.shown = count;
        self.rebase(count, at_secs);
    }

    /// The beat at `secs`: never less than before.
    pub fn at(&mut self, secs: f64) -> Beat {
        if let Some(count) = self.count(secs) {
            self.shown = self.shown.max(count);
        }
        let confidence = if self.is_known() && self.runs { 1.0 } else { 0.0 };
        Beat { count: self.shown, confidence }
    }

    /// Beats a minute; `None` before the first tempo.
    pub fn bpm(&self) -> Option<f64> {
        Some(60.0 * self.grid?.per_sec * self.beats_per_quarter())
    }

    /// The bar that has begun since the last call, if one has. `energy` and `begins_section` are those of the music.
    pub fn bar(&mut self, secs: f64, energy: f32, begins_section: bool) -> Option<BarLine> {
        let grid = self.grid.filter(|_| self.runs)?;
        let per_bar = QUARTERS_PER_BAR / self.beats_per_quarter();
        let bar = (grid.at(secs + self.nudge_secs) / per_bar).floor();
        if self.told_bar.is_some_and(|last| last >= bar) {
            return None;
        }
        self.told_bar = Some(bar);
        let at_secs = grid.at_secs + (bar * per_bar - grid.quarters) / grid.per_sec - self.nudge_secs;
        Some(BarLine { at_secs, secs: per_bar / grid.per_sec, energy, begins_section })
    }

    /// Which beat of its bar it is, from 1.
    pub fn beat_in_bar(&self, secs: f64) -> Option<u32> {
        let beats = self.grid?.at(secs + self.nudge_secs) * self.beats_per_quarter();
        Some(1 + beats.floor().rem_euclid(QUARTERS_PER_BAR) as u32)
    }

    /// Moves the beat; positive comes sooner.
    pub fn nudge(&mut self, secs: f64) {
        self.nudge_secs = (self.nudge_secs + secs).clamp(-1.0, 1.0);
    }

    /// Half as many beats a minute.
    pub fn halve(&mut self, at_secs: f64) {
        self.change_octave(self.octave - 1, at_secs);
    }

    /// Twice as many.
    pub fn double(&mut self, at_secs: f64) {
        self.change_octave(self.octave + 1, at_secs);
    }

    /// Whether it goes on as it is, whatever a clock says.
    pub fn is_locked(&self) -> bool {
        self.is_locked
    }

    /// Goes on as it is, or listens again.
    pub fn lock(&mut self, on: bool) {
        self.is_locked = on;
    }

    fn beats_per_quarter(&self) -> f64 {
        2f64.powi(self.octave)
    }

    fn count(&self, secs: f64) -> Option<f64> {
        let secs = if self.runs { secs + self.nudge_secs } else { self.grid?.at_secs };
        Some(self.origin + self.grid?.at(secs) * self.beats_per_quarter())
    }

    fn tick(&mut self, at_secs: f64) {
        let silent = self.ticks.add(at_secs);
        if self.runs {
            self.position += 1.0 / TICKS_PER_QUARTER;
        }
        if let Some(grid) = self.grid.filter(|_| silent && self.runs) {
            // Meanwhile the beat went on by itself: the nearest whole one is where it is now.
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
            // The first ticks of a song tell where it is, and the tempo is still that of before.
            (None, Some(grid)) => self.grid = Some(Grid { quarters: self.position, at_secs, ..grid }),
            (None, None) => {}
        }
    }

    fn stop(&mut self, at_secs: f64) {
        if let Some(grid) = self.grid.filter(|_| self.runs) {
            // It stands still at the tick that was heard last, or where it has come to without ticks.
            let quarters = if self.ticks.secs.is_empty() { grid.at(at_secs) } else { self.position };
            self.grid = Some(Grid { quarters, at_secs, ..grid });
        }
        self.runs = false;
    }

    /// The next tick, or this moment where there are no ticks, is at `quarters` of the song.
    fn jump(&mut self, quarters: f64, at_secs: f64) {
        let count = self.shown.max(self.count(at_secs).unwrap_or(0.0));
        self.runs = true;
        self.position = quarters - 1.0 / TICKS_PER_QUARTER;
        let gap_secs = self.ticks.line().map_or(0.0, |(_, gap_secs)| gap_secs);
        if let Some(grid) = self.grid {
            self.grid = Some(Grid { quarters, at_secs: at_secs + gap_secs, ..grid });
        }
        self.ticks.secs.clear();
        self.origin = (count - quarters * self.beats_per_quarter()).round();
        self.told_bar = None;
    }

    fn set_tempo(&mut self, bpm: f64, at_secs: f64) {
        if TEMPI_BPM.contains(&bpm) {
            let quarters = self.grid.map_or(0.0, |grid| grid.at(at_secs));
            self.follow(Grid { quarters, at_secs, per_sec: bpm / 60.0 });
        }
    }

    fn beat(&mut self, in_bar: Option<u32>, at_secs: f64) {
        self.beats.add(at_secs);
        // The first one of its song or, where a clock ticks, the nearest.
        let quarters = self.grid.map_or(0.0, |grid| grid.at(at_secs));
        let place = f64::from(in_bar.unwrap_or(1) - 1).rem_euclid(QUARTERS_PER_BAR);
        let whole = match in_bar {
            Some(_) => ((quarters - place) / QUARTERS_PER_BAR).round() * QUARTERS_PER_BAR + place,
            None => quarters.round(),
        };
        let moved = whole - quarters;
        let ticks = self.ticks.secs.back().is_some_and(|last| at_secs - last <= self.ticks.longest_gap_secs);
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
        // A move to another place in the bar does not step the beat.
        self.origin -= (moved * self.beats_per_quarter()).round();
    }

    fn follow(&mut self, grid: Grid) {
        let first = self.grid.replace(grid).is_none();
        if first {
            self.rebase(self.shown, grid.at_secs);
        }
    }

    fn rebase(&mut self, count: f64, at_secs: f64) {
        if let Some(grid) = self.grid {
            self.origin = (count - grid.at(at_secs) * self.beats_per_quarter()).ceil();
        }
    }

    fn change_octave(&mut self, octave: i32, at_secs: f64) {
        let count = self.at(at_secs).count;
        self.octave = octave.clamp(-MOST_OCTAVES, MOST_OCTAVES);
        self.told_bar = None;
        self.rebase(count, at_secs);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    /// Ticks from `from_secs` on, late by up to `jitter_secs`, and the exact quarters at the last of them.
    fn play(tempo: &mut Tempo, (from_secs, bpm, ticks): (f64, f64, u32), jitter_secs: f64, seed: u64) -> f64 {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let gap_secs = 60.0 / bpm / TICKS_PER_QUARTER;
        for tick in 0..ticks {
            let late_secs = jitter_secs * random.random_range(-0.5..0.5);
            tempo.hear(ClockMessage::Tick, from_secs + f64::from(tick) * gap_secs + late_secs);
        }
        from_secs + f64::from(ticks - 1) * gap_secs
    }

    #[test]
    fn jitter_is_filtered() {
        for (seed, bpm) in [(1, 61.3), (2, 120.0), (3, 174.0)] {
            let mut tempo = Tempo::default();
            tempo.hear(ClockMessage::Start, 0.99);
            // 4 ms either way, a fifth to a half of a tick, as from a busy computer.
            let at_secs = play(&mut tempo, (1.0, bpm, 24 * 16 + 1), 8e-3, seed);
            assert!((tempo.bpm().unwrap() / bpm - 1.0).abs() < 0.004, "{:?} {bpm}", tempo.bpm());
            let off_secs = (tempo.at(at_secs).count - 16.0) * 60.0 / bpm;
            assert!(off_secs.abs() < 2.5e-3, "{off_secs} s at {bpm}");
            // It is followed into another tempo within two quarters.
            let next_secs = at_secs + 60.0 / bpm / TICKS_PER_QUARTER;
            play(&mut tempo, (next_secs, 1.1 * bpm, 50), 8e-3, seed);
            assert!((tempo.bpm().unwrap() / bpm - 1.1).abs() < 0.006);
        }
    }

    #[test]
    fn the_count_never_goes_back_and_stays_near_the_clock() {
        let mut tempo = Tempo::default();
        let mut random = ChaCha8Rng::seed_from_u64(9);
        let (gap_secs, mut shown) = (0.5 / TICKS_PER_QUARTER, 0.0);
        for tick in 0..2000 {
            let exact_secs = f64::from(tick) * gap_secs;
            tempo.hear(ClockMessage::Tick, exact_secs + random.random_range(0.0..0.01));
            let count = tempo.at(exact_secs + 0.01).count;
            assert!(count >= shown);
            if tick > 60 {
                // In the mean a tick comes 5 ms late, and it is asked 10 ms after the exact time.
                let step = count - shown;
                assert!(step < 3.0 / TICKS_PER_QUARTER, "a step of {step}");
            }
            shown = count;
        }
        assert!((shown - 2000.0 / TICKS_PER_QUARTER).abs() < 1.1, "{shown}");
    }

    #[test]
    fn start_stop_continue_and_song_position_lead_to_the_bar() {
        let mut tempo = Tempo::default();
        // A clock that has long been ticking when the song starts.
        let last_secs = play(&mut tempo, (0.0, 120.0, 101), 0.0, 0);
        let before = tempo.at(last_secs).count;
        tempo.hear(ClockMessage::Start, last_secs + 0.005);
        let first_secs = last_secs + 0.5 / TICKS_PER_QUARTER;
        let at_secs = play(&mut tempo, (first_secs, 120.0, 24 * 6 + 1), 0.0, 0);
        let now = tempo.at(at_secs);
        assert!((now.count - now.count.round()).abs() < 1e-6 && now.confidence == 1.0, "{now:?}");
        assert!((now.count - before - 6.0).abs() <= 0.5 + 1.0 / TICKS_PER_QUARTER, "{before} {now:?}");
        assert_eq!(tempo.beat_in_bar(at_secs + 0.01), Some(3));
        let bar = tempo.bar(at_secs, 0.5, true).unwrap();
        let off_secs = [bar.at_secs - first_secs - 2.0, bar.secs - 2.0];
        assert!(off_secs.iter().all(|off| off.abs() < 1e-6), "{bar:?}");
        assert_eq!(tempo.bar(at_secs + 0.9, 0.5, true), None);
        assert!((tempo.bar(at_secs + 1.01, 0.5, false).unwrap().at_secs - at_secs - 1.0).abs() < 1e-6);
        // Stopped, nothing goes on, though the clock ticks.
        tempo.hear(ClockMessage::Stop, at_secs + 0.01);
        let still = tempo.at(at_secs + 0.02);
        let later_secs = play(&mut tempo, (at_secs + 0.02, 120.0, 100), 0.0, 0);
        assert_eq!((tempo.at(later_secs).count, still.confidence), (still.count, 0.0));
        assert_eq!(tempo.bar(later_secs, 0.5, false), None);
        // On from the third beat of a bar.
        tempo.hear(ClockMessage::Position { quarters: 10.0 }, later_secs + 0.001);
        assert_eq!(tempo.at(later_secs + 0.3).confidence, 0.0);
        tempo.hear(ClockMessage::Continue, later_secs + 0.002);
        let at_secs = play(&mut tempo, (later_secs + 0.1, 120.0, 25), 0.0, 0);
        assert_eq!(tempo.beat_in_bar(at_secs + 0.02), Some(4));
        assert!(tempo.at(at_secs).count >= still.count);
    }

    #[test]
    fn it_goes_on_where_a_clock_falls_silent_and_meets_it_again() {
        let mut tempo = Tempo::default();
        let last_secs = play(&mut tempo, (0.0, 120.0, 24 * 8 + 1), 0.0, 0);
        let before = tempo.at(last_secs).count;
        assert!((tempo.at(last_secs + 10.1).count - before - 20.2).abs() < 1e-6);
        // It goes on with the first tick after a beat.
        let again_secs = play(&mut tempo, (last_secs + 10.25, 120.0, 24 * 2 + 1), 0.0, 0);
        let count = tempo.at(again_secs).count;
        let off = count - count.round() - 1.0 / TICKS_PER_QUARTER;
        assert!((count - before - 22.5).abs() < 0.6 && off.abs() < 1e-6, "{count}");
    }

    #[test]
    fn taps_and_osc_give_tempo_and_phase() {
        let mut tempo = Tempo::default();
        assert_eq!((tempo.at(1.0), tempo.bpm()), (Beat::default(), None));
        for (i, off_secs) in [0.01, -0.012, 0.004, 0.0, -0.007, 0.009].into_iter().enumerate() {
            tempo.hear(ClockMessage::Beat { in_bar: None }, 3.0 + 0.5 * i as f64 + off_secs);
        }
        assert!((tempo.bpm().unwrap() - 120.0).abs() < 2.0, "{:?}", tempo.bpm());
        let phase = tempo.at(5.75).count.fract();
        assert!((phase - 0.5).abs() < 0.03, "{phase}");
        tempo.hear(ClockMessage::Tempo { bpm: 90.0 }, 6.0);
        assert_eq!(tempo.bpm(), Some(90.0));
        tempo.hear(ClockMessage::Tempo { bpm: 1e9 }, 6.0);
        tempo.hear(ClockMessage::Tempo { bpm: f64::NAN }, 6.0);
        assert_eq!(tempo.bpm(), Some(90.0));
        tempo.hear(ClockMessage::Beat { in_bar: Some(2) }, 10.0);
        assert_eq!(tempo.beat_in_bar(10.01), Some(2));
    }

    #[test]
    fn it_is_nudged_halved_doubled_and_locked() {
        let mut tempo = Tempo::default();
        tempo.set(100.0, 7.25, 20.0);
        assert_eq!((tempo.at(20.0).count, tempo.bpm()), (7.25, Some(100.0)));
        tempo.nudge(0.06);
        assert!((tempo.at(20.0).count - 7.35).abs() < 1e-9);
        tempo.nudge(-0.06);
        tempo.double(20.6);
        assert_eq!(tempo.bpm(), Some(200.0));
        let begun = tempo.at(21.2).count;
        assert!((tempo.at(21.8).count - begun - 2.0).abs() < 1e-9);
        tempo.halve(22.0);
        tempo.halve(22.0);
        assert_eq!(tempo.bpm(), Some(50.0));
        assert!(tempo.at(22.0).count >= begun);
        tempo.lock(true);
        let locked = tempo.clone();
        tempo.hear(ClockMessage::Tempo { bpm: 150.0 }, 23.0);
        tempo.hear(ClockMessage::Start, 23.0);
        assert!(tempo == locked && tempo.is_locked());
    }
}
