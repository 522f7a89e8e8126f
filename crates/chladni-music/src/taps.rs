//! Taps by hand to a song whose beats were found, and the beats that they put in the place of those.

use std::ops::RangeInclusive;

use serde::{Deserialize, Serialize};

use crate::pulses::Pulses;
use crate::tempo::{QUARTERS_PER_BAR, SAME_BEAT_SECS};

/// Fewer taps have no tempo, and no more are counted.
const FEWEST: usize = 4;
const MOST: usize = 16;
/// After a longer pause they begin anew.
const LONGEST_GAP_SECS: f64 = 2.0;
/// Even taps lie this near to the straight line through them, as a share of the time between two.
const EVEN: f64 = 0.15;
/// Beats at the tempo of the taps drift away from them by less than this from the first tap to the last, as a share of the
/// time between two. So the tempo of eight taps may be off by 4 %, and that of four, which is less exact, by 10 %.
const LARGEST_DRIFT: f64 = 0.3;
/// With their octaves, the ratios by which a found tempo is wrong most often: 3/2 and 2/3, 3 and 1/3, 4/3 and 3/4.
const SIMPLE: [f64; 2] = [3.0 / 4.0, 4.0 / 3.0];
/// The slowest and the fastest beats, for each that was found.
const PER_FOUND: RangeInclusive<f64> = 0.05..=20.0;

/// Beats of a song at a tempo that a person tapped, in bars of four. They follow the changes of tempo of the beats that
/// were found.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TappedBeats {
    /// How many there are for each beat that was found, from 0.05 to 20.
    pub per_found: f64,
    /// When the first beat of a bar falls, in seconds of the song.
    pub at_secs: f64,
}

impl TappedBeats {
    pub(crate) fn has_tempo(self) -> bool {
        PER_FOUND.contains(&self.per_found)
    }

    /// The beats from the first to the last of `found_secs` (ascending), each with its place in its bar, from 0; none
    /// where fewer than two were found.
    pub fn among(self, found_secs: &[f64]) -> Vec<(i64, f64)> {
        let Some(begin) = place_among(found_secs, self.at_secs) else { return Vec::new() };
        let per_found = self.per_found.clamp(*PER_FOUND.start(), *PER_FOUND.end());
        let last = (found_secs.len() - 1) as f64;
        let (from, to) = ((-begin * per_found).ceil() as i64, ((last - begin) * per_found).floor() as i64);
        let in_bar = |n: i64| n.rem_euclid(QUARTERS_PER_BAR as i64);
        let secs = |n: i64| secs_at(found_secs, (begin + n as f64 / per_found).clamp(0.0, last));
        (from..=to).map(|n| (in_bar(n), secs(n))).collect()
    }
}

/// The last taps to a song.
#[derive(Clone, Debug)]
pub struct Taps(Pulses);

impl Default for Taps {
    fn default() -> Self {
        Self(Pulses::new(MOST, FEWEST, LONGEST_GAP_SECS))
    }
}

impl Taps {
    /// Takes a tap, in seconds of the song. One that comes less than 0.15 s after another is the same. They begin anew
    /// with one that comes more than two seconds after the last, or with which they are not even.
    pub fn add(&mut self, secs: f64) {
        let is_same = |last: f64| (0.0..SAME_BEAT_SECS).contains(&(secs - last));
        if !secs.is_finite() || self.0.last_secs().is_some_and(is_same) {
            return;
        }
        self.0.add(secs);
        if !self.0.are_even(EVEN) {
            self.0.clear();
            self.0.add(secs);
        }
    }

    /// The beats of the last 16 taps at most, the first of which began a bar, and whether their tempo is that of
    /// `found_secs` (ascending), or half of it, twice and so on. `None` where there are fewer than four even taps, or
    /// fewer than two beats were found.
    pub(crate) fn over(&self, found_secs: &[f64]) -> Option<(TappedBeats, bool)> {
        let (due_secs, gap_secs) = self.0.line()?;
        let (first, last) = self.0.places()?;
        let taps = last - first;
        let place = |secs: f64| place_among(found_secs, secs);
        let found = place(due_secs)? - place(due_secs - taps * gap_secs)?;
        let octave_of = |ratio: f64| ratio * (taps / (ratio * found)).log2().round().exp2();
        let drift = |per_found: f64| (taps - per_found * found).abs();
        let (own, [low, high]) = (octave_of(1.0), SIMPLE.map(octave_of));
        let simple = if drift(low) < drift(high) { low } else { high };
        let is_own = drift(own) <= LARGEST_DRIFT;
        let per_found = match (is_own, drift(simple) <= LARGEST_DRIFT) {
            (true, _) => own,
            (false, true) => simple,
            (false, false) => taps / found,
        };
        let beats =
            TappedBeats { per_found, at_secs: due_secs - last.rem_euclid(QUARTERS_PER_BAR) * gap_secs };
        beats.has_tempo().then_some((beats, is_own))
    }
}

/// How many beats after the first of `beats_secs` a time lies. Before the first and after the last, they go on as there.
fn place_among(beats_secs: &[f64], secs: f64) -> Option<f64> {
    let last = beats_secs.len().checked_sub(1).filter(|last| *last > 0)?;
    let next = beats_secs.partition_point(|beat| *beat <= secs).clamp(1, last);
    let (before, after) = (beats_secs[next - 1], beats_secs[next]);
    Some((next - 1) as f64 + (secs - before) / (after - before).max(1e-3))
}

/// The time at a place among two or more beats, from 0 to that of the last.
fn secs_at(beats_secs: &[f64], place: f64) -> f64 {
    let before = (place as usize).min(beats_secs.len() - 2);
    beats_secs[before] + (place - before as f64) * (beats_secs[before + 1] - beats_secs[before])
}
