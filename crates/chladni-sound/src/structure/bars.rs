//! Which beats begin a bar: a bar pointer walks through bars of three and four beats.
//!
//! It works like the pointer for beats (`beat/meter.rs`), one level up. A state is a meter and a place in
//! the bar; each beat advances the place by one, and the meter may change where a bar ends. Observed are
//! how strongly a beat looks like a downbeat ([`signs`], assumed normal with mean ±[`DOWNBEAT`] depending
//! on the place), and whether the music resembles itself three or four beats ago.

use super::Bar;
use super::beat_features::{BeatFeatures, CONTEXT, signs};

const METERS: [usize; 2] = [3, 4];
const STATES: usize = METERS[0] + METERS[1];
/// How many standard deviations above the mean a downbeat is expected to be.
const DOWNBEAT: f32 = 1.5;
/// Weight of each sign: harmony, bass, onset in the bass, any onset.
const WEIGHTS: [f32; 4] = [0.5, 0.33, 0.9, 0.3];
/// Weight, in nats, of the similarity to the beat one bar ago.
const REPETITION: f32 = 3.0;
/// Probability that the next bar has the other meter, and, after each beat but its last, that a bar is cut short.
const CHANGE: f32 = 0.01;
const CUT: f32 = 0.000_5;
/// Prior probability of each meter.
const COMMON: [f32; 2] = [0.3, 0.7];

/// (meter, place) of a state: first all places of three, then all of four.
fn place(state: usize) -> (usize, usize) {
    if state < METERS[0] { (0, state) } else { (1, state - METERS[0]) }
}

/// Log-probability of the step between two states.
fn step(from: usize, to: usize) -> f32 {
    let ((meter, at), (next_meter, next)) = (place(from), place(to));
    let ends = at + 1 == METERS[meter];
    let chance = match (ends, meter == next_meter, next) {
        (false, true, next) if next == at + 1 => 1.0 - CUT,
        (false, true, 0) => CUT,
        (true, true, 0) => 1.0 - CHANGE,
        (true, false, 0) => CHANGE,
        _ => return f32::NEG_INFINITY,
    };
    chance.ln()
}

/// Running mean and standard deviation.
#[derive(Clone, Copy, Debug, Default)]
struct Running {
    count: f32,
    mean: f32,
    square: f32,
}

impl Running {
    fn learn(&mut self, value: f32) {
        // After 64 beats, old values slowly lose weight.
        self.count = (self.count + 1.0).min(64.0);
        self.mean += (value - self.mean) / self.count;
        self.square += (value * value - self.square) / self.count;
    }

    fn deviations(&self, value: f32) -> f32 {
        let deviation = (self.square - self.mean * self.mean).max(0.0).sqrt();
        if deviation > 1e-4 { ((value - self.mean) / deviation).clamp(-3.0, 3.0) } else { 0.0 }
    }
}

/// Computes the log-likelihood of each state for a beat.
#[derive(Clone, Debug)]
pub(super) struct Judge {
    levels: [Running; 4],
}

impl Judge {
    /// A judge that has not seen any beat.
    pub fn new() -> Self {
        Self { levels: [Running::default(); 4] }
    }

    /// Updates the statistics of the signs.
    pub fn learn(&mut self, signs: [f32; 4]) {
        self.levels.iter_mut().zip(signs).for_each(|(level, sign)| level.learn(sign));
    }

    /// The log-likelihood of each state; `past` holds the beats before this one, nearest first.
    pub fn judge(&self, signs: [f32; 4], beat: &BeatFeatures, past: &[&BeatFeatures]) -> [f32; STATES] {
        let parts = self.levels.iter().zip(signs).zip(WEIGHTS);
        let sign: f32 = parts.map(|((level, sign), weight)| weight * level.deviations(sign)).sum();
        let likeness = METERS.map(|beats| past.get(beats - 1).map(|before| beat.likeness(before)));
        let mean = match likeness {
            [Some(three), Some(four)] => 0.5 * (three + four),
            _ => 0.0,
        };
        std::array::from_fn(|state| {
            let (meter, at) = place(state);
            let beats = METERS[meter] as f32;
            let expected = if at == 0 { DOWNBEAT } else { -DOWNBEAT / (beats - 1.0) };
            let repeats = likeness[1].and(likeness[meter]).map_or(0.0, |like| REPETITION * (like - mean));
            expected * sign - 0.5 * expected * expected + repeats
        })
    }
}

fn beginning() -> [f32; STATES] {
    std::array::from_fn(|state| (COMMON[place(state).0] / METERS[place(state).0] as f32).ln())
}

/// The most probable paths through `heard` beats (Viterbi), the first `judged` of them weighted by their signs: the
/// score of each state at the last beat, and where each came from.
fn paths(heard: &[BeatFeatures], judged: usize) -> ([f32; STATES], Vec<[u8; STATES]>) {
    let signs: Vec<[f32; 4]> = (0..heard.len()).map(|i| signs_at(heard, i)).collect();
    let mut judge = Judge::new();
    signs.iter().for_each(|signs| judge.learn(*signs));
    let mut score = beginning();
    let mut came_from: Vec<[u8; STATES]> = Vec::with_capacity(heard.len());
    for (i, signs) in signs.iter().enumerate() {
        let past: Vec<&BeatFeatures> = heard[..i].iter().rev().take(METERS[1]).collect();
        let fits = if i < judged { judge.judge(*signs, &heard[i], &past) } else { [0.0; STATES] };
        let mut from = [0; STATES];
        let next = std::array::from_fn(|to| {
            let (best, arrives) = arrival(&score, to);
            from[to] = best as u8;
            fits[to] + if i == 0 { score[to] } else { arrives }
        });
        score = next;
        came_from.push(from);
    }
    (score, came_from)
}

/// From which state the best path comes to a state, and the score with which it arrives.
fn arrival(score: &[f32; STATES], to: usize) -> (usize, f32) {
    let arrive = |from: usize| score[from] + step(from, to);
    let best = (0..STATES).max_by(|&a, &b| arrive(a).total_cmp(&arrive(b))).unwrap_or(0);
    (best, arrive(best))
}

/// The bars of a song, given all of its beats.
pub(super) fn bars(beats_secs: &[f64], heard: &[BeatFeatures]) -> Vec<Bar> {
    // Where the last beat ends is assumed, not heard.
    let (score, came_from) = paths(heard, heard.len().saturating_sub(1));
    let mut at = (0..STATES).max_by(|&a, &b| score[a].total_cmp(&score[b])).unwrap_or(0);
    let mut places = vec![0; heard.len()];
    for i in (0..heard.len()).rev() {
        places[i] = at;
        at = usize::from(came_from[i][at]);
    }
    bars_of(beats_secs, &places)
}

/// Bars from the states of all beats; beats before the first downbeat belong to no bar.
fn bars_of(beats_secs: &[f64], places: &[usize]) -> Vec<Bar> {
    let mut bars: Vec<Bar> = Vec::new();
    for (&at_secs, &state) in beats_secs.iter().zip(places) {
        match bars.last_mut() {
            _ if place(state).1 == 0 => bars.push(Bar { at_secs, beats: 1 }),
            Some(bar) => bar.beats += 1,
            None => {}
        }
    }
    bars
}

/// [`signs`] of beat `i` of a song.
fn signs_at(heard: &[BeatFeatures], i: usize) -> [f32; 4] {
    let before: Vec<&BeatFeatures> = heard[..i].iter().rev().take(CONTEXT).collect();
    let after: Vec<&BeatFeatures> = heard[i..].iter().take(CONTEXT).collect();
    signs(&before, &after)
}

/// How many beats a listener remembers: about a minute.
const REMEMBERED: usize = 128;

/// The same for a listener: with each beat, the paths through all that are remembered are found anew, so that what
/// came later decides about what came before.
#[derive(Clone, Debug, Default)]
pub(super) struct BarPointer {
    heard: Vec<BeatFeatures>,
}

impl BarPointer {
    /// Takes a beat that has ended. If a bar begins now, returns its likely number of beats.
    pub fn beat(&mut self, ended: BeatFeatures) -> Option<usize> {
        if self.heard.len() == REMEMBERED {
            self.heard.remove(0);
        }
        self.heard.push(ended);
        let (score, _) = paths(&self.heard, self.heard.len());
        let now = |to: &usize| arrival(&score, *to).1;
        let best = (0..STATES).max_by(|a, b| now(a).total_cmp(&now(b)))?;
        let (meter, at) = place(best);
        (at == 0).then_some(METERS[meter])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn state(meter: usize, place: usize) -> usize {
        meter * METERS[0] + place
    }

    #[test]
    fn every_state_goes_somewhere_with_certainty() {
        for from in 0..STATES {
            let sum: f32 = (0..STATES).map(|to| step(from, to).exp()).sum();
            assert!((sum - 1.0).abs() < 1e-6, "{from}: {sum}");
        }
        assert_eq!(place(state(1, 2)), (1, 2));
    }

    #[test]
    fn bars_are_counted_from_the_first_downbeat() {
        let places = [state(1, 3), state(1, 0), state(1, 1), state(0, 0), state(0, 1), state(0, 2)];
        let bars = bars_of(&[0.0, 1.0, 2.0, 3.0, 4.0, 5.0], &places);
        assert_eq!(bars, [Bar { at_secs: 1.0, beats: 2 }, Bar { at_secs: 3.0, beats: 3 }]);
    }
}
