//! The bar pointer: the states (tempo, position within a beat) in which the music may be.
//!
//! A pointer walks through a beat of `period` frames, one frame at a time, and may change its period only
//! when a beat begins (N. Whiteley, A. T. Cemgil and S. Godsill, ISMIR 2006, in the form of F. Krebs, S.
//! Böck and G. Widmer, "An efficient state-space model for joint tempo and meter tracking", ISMIR 2015).
//! Here the observation is onset strength instead of the beat activation of a network, and its
//! log-likelihood is a product: the observed strength minus its mean, times the strength expected at this
//! position minus its mean. Random onsets then favor no tempo, while a beat without an onset and an onset
//! off the beat both count against a path.

use crate::{ONSET_RATE_HZ, Onset};

pub(super) const SLOWEST_BPM: f64 = 42.0;
pub(super) const FASTEST_BPM: f64 = 216.0;
/// Width of the Gaussian of expected onsets around a beat, in frames (20 ms).
const BEAT_WIDTH: f64 = 2.0;
/// The strength expected halfway between two beats, as a share of that on a beat.
const OFFBEAT: f64 = 0.17;
/// The same at two thirds of the beat, where a shuffle has its second note.
const SHUFFLE: f64 = 0.1;
/// A change of period by the factor r costs this times |ln r|.
const TEMPO_STIFFNESS: f64 = 90.0;
/// Preferred tempo and its spread in octaves (as D. Ellis 2007, but narrower).
const PREFERRED_BPM: f64 = 118.0;
const SPREAD_OCTAVES: f64 = 0.8;
/// The cost of a beat, in units of the log-likelihood: of two tempi that explain the same onsets, the
/// slower one is simpler.
const BEAT_COST: f64 = 4.0;
/// The weight, in nats, of an onset one standard deviation above the mean.
const TRUST: f64 = 0.6;

/// The place of one tempo among the states.
#[derive(Clone, Copy)]
pub(super) struct Tempo {
    /// Frames per beat.
    pub period: usize,
    /// The index of its first state.
    pub first: usize,
}

/// All tempi, the onset strength expected at each position, and the costs of tempo changes.
pub(super) struct Meter {
    pub tempi: Vec<Tempo>,
    /// For each state, the expected onset strength, weighted by the probability of the tempo.
    pub expected: Vec<f32>,
    /// Log-probability of going from tempo j (row) to tempo i (column), minus the cost of the beat that
    /// begins.
    pub change: Vec<f32>,
}

impl Meter {
    pub fn new() -> Self {
        let shortest = (60.0 * ONSET_RATE_HZ / FASTEST_BPM).floor() as usize;
        let longest = (60.0 * ONSET_RATE_HZ / SLOWEST_BPM).ceil() as usize;
        let mut tempi = Vec::new();
        let mut expected = Vec::new();
        for period in shortest..=longest {
            tempi.push(Tempo { period, first: expected.len() });
            let weight = TRUST * preference(period);
            let raw: Vec<f64> = (0..period).map(|place| template(place, period)).collect();
            let mean = raw.iter().sum::<f64>() / period as f64;
            expected.extend(raw.iter().map(|e| (weight * (e - mean)) as f32));
        }
        let mut change = Vec::with_capacity(tempi.len() * tempi.len());
        for from in &tempi {
            let cost = |to: &Tempo| -TEMPO_STIFFNESS * (to.period as f64 / from.period as f64).ln().abs();
            let total: f64 = tempi.iter().map(|to| cost(to).exp()).sum();
            let beat = |to: &Tempo| BEAT_COST * TRUST * preference(to.period);
            change.extend(tempi.iter().map(|to| (cost(to) - total.ln() - beat(to)) as f32));
        }
        Self { tempi, expected, change }
    }

    /// Calls `each` for every state of `tempo`, whose ring begins at index `start`, with its value and the onset strength
    /// expected there.
    pub fn expect(
        &self,
        tempo: &Tempo,
        start: usize,
        states: &mut [f32],
        mut each: impl FnMut(&mut f32, f32),
    ) {
        let states = &mut states[tempo.first..tempo.first + tempo.period];
        let expected = &self.expected[tempo.first..tempo.first + tempo.period];
        let (before, from_start) = states.split_at_mut(start);
        for (s, e) in from_start.iter_mut().zip(expected) {
            each(s, *e);
        }
        for (s, e) in before.iter_mut().zip(&expected[tempo.period - start..]) {
            each(s, *e);
        }
    }
}

/// Where `place` lies in the ring of a tempo at frame `t`. The positions of a tempo form a ring: advancing moves the
/// start of the ring, not its values, so position p is at index (p − t) mod period.
pub(super) fn ring(place: usize, t: u64, period: usize) -> usize {
    (place + period - (t % period as u64) as usize) % period
}

/// The onset strength expected at a place within a beat of this period.
fn template(place: usize, period: usize) -> f64 {
    let bump = |center: f64| {
        let off = (place as f64 - center).abs();
        let off = off.min(period as f64 - off);
        (-0.5 * (off / BEAT_WIDTH).powi(2)).exp()
    };
    let period = period as f64;
    bump(0.0) + OFFBEAT * bump(period / 2.0) + SHUFFLE * bump(period * 2.0 / 3.0)
}

fn preference(period: usize) -> f64 {
    let bpm = 60.0 * ONSET_RATE_HZ / period as f64;
    (-0.5 * ((bpm / PREFERRED_BPM).log2() / SPREAD_OCTAVES).powi(2)).exp()
}

/// The weight of bass onsets relative to onsets in all bands.
const BASS: f32 = 0.5;

fn mix(all: f32, bass: f32) -> f32 {
    (all + BASS * bass) / (1.0 + BASS * BASS).sqrt()
}

/// Normalizes onset strength to mean 0 and standard deviation about 1 over the last seconds, separately for
/// all bands and for the bass, and mixes the two.
#[derive(Clone, Copy)]
pub(super) struct Normalizer {
    all: RunningMoments,
    bass: RunningMoments,
}

impl Normalizer {
    pub fn new() -> Self {
        Self { all: RunningMoments::new(), bass: RunningMoments::new() }
    }

    pub fn next(&mut self, onset: Onset) -> f32 {
        mix(self.all.next(onset.all), self.bass.next(onset.bass))
    }

    /// Normalizes all onsets of a song, using the future as much as the past.
    pub fn both_ways(onsets: &[Onset]) -> Vec<f32> {
        let part =
            |of: fn(&Onset) -> f32| RunningMoments::both_ways(&onsets.iter().map(of).collect::<Vec<_>>());
        let (all, bass) = (part(|onset| onset.all), part(|onset| onset.bass));
        all.iter().zip(&bass).map(|(&all, &bass)| mix(all, bass)).collect()
    }
}

/// Running mean and standard deviation of one strength over the last seconds.
#[derive(Clone, Copy)]
struct RunningMoments {
    mean: f64,
    square: f64,
    weight: f64,
}

/// Onset strength, or a deviation of it, below this is rounding noise: silence has no onsets.
pub(super) const NO_ONSET: f32 = 1e-4;
/// Time constant of the running mean.
const NORMAL_SECS: f64 = 3.7;
/// Onsets are limited to this many standard deviations.
const MOST: f64 = 4.0;

impl RunningMoments {
    fn new() -> Self {
        Self { mean: 0.0, square: 0.0, weight: 0.0 }
    }

    fn next(&mut self, onset: f32) -> f32 {
        let keep = (-1.0 / (NORMAL_SECS * ONSET_RATE_HZ)).exp();
        let onset = f64::from(onset);
        self.mean = keep * self.mean + (1.0 - keep) * onset;
        self.square = keep * self.square + (1.0 - keep) * onset * onset;
        self.weight = keep * self.weight + (1.0 - keep);
        self.value(onset)
    }

    fn value(&self, onset: f64) -> f32 {
        let mean = self.mean / self.weight;
        let deviation = (self.square / self.weight - mean * mean).max(0.0).sqrt();
        if deviation < f64::from(NO_ONSET) { 0.0 } else { ((onset - mean) / deviation).min(MOST) as f32 }
    }

    fn both_ways(onsets: &[f32]) -> Vec<f32> {
        let run = |values: &mut dyn Iterator<Item = &f32>| {
            let mut state = Self::new();
            values
                .map(|&o| {
                    state.next(o);
                    state
                })
                .collect::<Vec<_>>()
        };
        let forward = run(&mut onsets.iter());
        let mut backward = run(&mut onsets.iter().rev());
        backward.reverse();
        let mix = |a: &Self, b: &Self| Self {
            mean: a.mean + b.mean,
            square: a.square + b.square,
            weight: a.weight + b.weight,
        };
        forward.iter().zip(&backward).zip(onsets).map(|((a, b), &o)| mix(a, b).value(f64::from(o))).collect()
    }
}
