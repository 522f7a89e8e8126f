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
/// Probability that the next bar has the other meter, and that a bar is cut short.
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

/// The bars of a song, given all of its beats: the most probable path (Viterbi).
pub(super) fn bars(beats_secs: &[f64], heard: &[BeatFeatures]) -> Vec<Bar> {
    let signs: Vec<[f32; 4]> = (0..heard.len()).map(|i| signs_at(heard, i)).collect();
    let mut judge = Judge::new();
    signs.iter().for_each(|signs| judge.learn(*signs));
    let mut score = beginning();
    let mut came_from: Vec<[u8; STATES]> = Vec::with_capacity(heard.len());
    for (i, signs) in signs.iter().enumerate() {
        let past: Vec<&BeatFeatures> = heard[..i].iter().rev().take(METERS[1]).collect();
        let judged = judge.judge(*signs, &heard[i], &past);
        let mut from = [0; STATES];
        let next = std::array::from_fn(|to| {
            let arrive = |from: usize| score[from] + step(from, to);
            let best = (0..STATES).max_by(|&a, &b| arrive(a).total_cmp(&arrive(b))).unwrap_or(0);
            from[to] = best as u8;
            judged[to] + if i == 0 { score[to] } else { arrive(best) }
        });
        score = next;
        came_from.push(from);
    }
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

/// The same pointer as a forward filter: its result for a beat depends on no later beat.
#[derive(Clone, Debug)]
pub(super) struct BarPointer {
    belief: [f32; STATES],
    judge: Judge,
    /// The beats that have ended, nearest first.
    past: Vec<BeatFeatures>,
}

impl BarPointer {
    /// A pointer for which all places of a bar are still possible.
    pub fn new() -> Self {
        Self { belief: beginning(), judge: Judge::new(), past: Vec::new() }
    }

    /// Takes a beat that has ended. If a bar begins now, returns its likely number of beats.
    pub fn beat(&mut self, ended: BeatFeatures) -> Option<usize> {
        self.past.insert(0, ended);
        self.past.truncate(2 * CONTEXT);
        let heard: Vec<&BeatFeatures> = self.past.iter().collect();
        // A beat is judged once the context after it has been heard.
        if let Some((judged, before)) = heard.get(CONTEXT - 1..).and_then(|at| at.split_first()) {
            let after: Vec<&BeatFeatures> = heard[..CONTEXT].iter().rev().copied().collect();
            let signs = signs(before, &after);
            self.judge.learn(signs);
            let judged = self.judge.judge(signs, judged, before);
            self.belief.iter_mut().zip(judged).for_each(|(belief, judged)| *belief += judged);
            self.belief = on(&self.belief);
        }
        // The belief about the judged beat, advanced to the beat that begins now.
        let now = (1..CONTEXT).fold(self.belief, |belief, _| on(&belief));
        let best = (0..STATES).max_by(|&a, &b| now[a].total_cmp(&now[b]))?;
        let (meter, at) = place(best);
        (at == 0).then_some(METERS[meter])
    }
}

/// The belief one beat later, normalized to a maximum of 0.
fn on(belief: &[f32; STATES]) -> [f32; STATES] {
    let next: [f32; STATES] = std::array::from_fn(|to| {
        let arriving: [f32; STATES] = std::array::from_fn(|from| belief[from] + step(from, to));
        let most = arriving.iter().copied().fold(f32::NEG_INFINITY, f32::max);
        most + arriving.iter().map(|value| (value - most).exp()).sum::<f32>().ln()
    });
    let most = next.iter().copied().fold(f32::NEG_INFINITY, f32::max);
    // Every state stays possible: it may turn out to be the right one.
    next.map(|value| (value - most).max(-30.0))
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
