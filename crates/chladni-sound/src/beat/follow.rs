//! Beat tracking while listening, from past samples only.

use std::collections::VecDeque;

use super::meter::{Meter, NO_ONSET, Normalizer, Tempo, ring};
use crate::structure::{BarFollower, HeardBar};
use crate::{ONSET_RATE_HZ, Onset, OnsetDetector, SoundError};

/// The beat as known at some time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BeatMoment {
    /// Beats per minute; 0 before anything was heard.
    pub tempo_bpm: f64,
    /// Place within the beat, in [0, 1).
    pub phase: f64,
    /// When the next beat is expected, in seconds.
    pub next_beat_secs: f64,
    /// Confidence in tempo and phase, in [0, 1].
    pub confidence: f64,
}

/// The share of the belief that is spread over all states at each beat. It lets a tracker that is wrong
/// find another tempo.
const DOUBT: f32 = 0.001_35;
/// The smallest time between two announced beats, in beats.
const SHORTEST_GAP: f64 = 0.6;
/// A beat that is recognized this late is still announced.
const LATEST_SECS: f64 = 0.06;
/// The most and the fewest beats that are announced per beat tracked.
const FASTEST_SPEED: f64 = 4.0;
const SLOWEST_SPEED: f64 = 0.25;
/// Where no onset is heard, this many tracked beats are still announced: a break of two bars.
const LONGEST_BREAK_BEATS: usize = 8;
/// Beats are looked for this often, however many samples come at once: less often, they would be recognized too late.
const LOOKS_PER_SEC: usize = 100;
/// Beats, and bars, that may wait to be taken: those of several seconds at any tempo.
const MOST_WAITING: usize = 64;

/// Follows the beat of a stream of samples: a forward filter over the states of the bar pointer. Its
/// statement about a time depends on no sample after it.
pub struct BeatFollower {
    meter: Meter,
    /// The exponents of e^(z · expected) and the results: one exponential per state is enough.
    belief: Vec<f32>,
    arriving: Vec<f32>,
    /// Probability of changing from tempo j to tempo i.
    change: Vec<f32>,
    onsets: OnsetDetector,
    fresh: Vec<Onset>,
    normalizer: Normalizer,
    rate_hz: f64,
    frames_heard: u64,
    samples_heard: u64,
    best: Best,
    /// How many frames have passed without an onset.
    silent_frames: usize,
    last_beat_secs: f64,
    /// The tracked beat from which those at half the speed are counted: the one tapped or announced last.
    counted_secs: Option<f64>,
    /// Beats and bars that nobody has taken yet, oldest first.
    pending: VecDeque<f64>,
    bars: BarFollower,
    begun: VecDeque<HeardBar>,
    /// How many beats are announced per beat tracked: 2 after "double", ½ after "halve", and after taps that are faster or
    /// slower than all tempi.
    speed: f64,
    taps: Taps,
    /// Slow mean of the onset strength at the beats.
    clarity: f64,
}

#[derive(Clone, Copy, Default)]
struct Best {
    period: usize,
    place: usize,
    mass: f32,
}

/// The last few taps of the user.
#[derive(Default)]
struct Taps {
    secs: [f64; 8],
    count: usize,
}

impl BeatFollower {
    /// A follower for samples at `rate_hz`.
    ///
    /// # Errors
    /// A rate outside [[`MIN_RATE_HZ`](crate::MIN_RATE_HZ), [`MAX_RATE_HZ`](crate::MAX_RATE_HZ)].
    pub fn new(rate_hz: u32) -> Result<Self, SoundError> {
        let meter = Meter::new();
        let states = meter.expected.len();
        Ok(Self {
            belief: vec![1.0 / states as f32; states],
            arriving: vec![0.0; meter.tempi.len()],
            change: meter.change.iter().map(|c| c.exp()).collect(),
            meter,
            onsets: OnsetDetector::new(rate_hz)?,
            fresh: Vec::with_capacity(64),
            normalizer: Normalizer::new(),
            rate_hz: f64::from(rate_hz),
            frames_heard: 0,
            samples_heard: 0,
            best: Best::default(),
            silent_frames: 0,
            last_beat_secs: f64::MIN,
            counted_secs: None,
            pending: VecDeque::with_capacity(MOST_WAITING),
            bars: BarFollower::new(rate_hz)?,
            begun: VecDeque::with_capacity(MOST_WAITING),
            speed: 1.0,
            taps: Taps::default(),
            clarity: 0.0,
        })
    }

    /// Takes the next samples that were heard, any number of them. Of the beats and bars in them that are not taken
    /// before the next call, the last 64 are kept.
    pub fn push(&mut self, left: &[f32], right: &[f32]) {
        let block = (self.rate_hz as usize / LOOKS_PER_SEC).max(1);
        let frames = left.len().min(right.len());
        for (left, right) in left[..frames].chunks(block).zip(right[..frames].chunks(block)) {
            self.push_block(left, right);
        }
    }

    fn push_block(&mut self, left: &[f32], right: &[f32]) {
        self.samples_heard += left.len() as u64;
        let mut fresh = std::mem::take(&mut self.fresh);
        fresh.clear();
        self.onsets.push(left, right, &mut fresh);
        for &onset in &fresh {
            self.step(onset);
        }
        self.bars.push(left, right, &fresh);
        self.fresh = fresh;
        self.announce();
    }

    /// The time up to which samples have been pushed, in seconds.
    pub fn now_secs(&self) -> f64 {
        self.samples_heard as f64 / self.rate_hz
    }

    /// The time of the oldest beat that became due and was not taken yet, if there is one.
    pub fn take_beat(&mut self) -> Option<f64> {
        self.pending.pop_front()
    }

    /// The oldest bar that has begun and was not taken yet, if there is one.
    pub fn take_bar(&mut self) -> Option<HeardBar> {
        self.begun.pop_front()
    }

    /// Tempo, phase and confidence now.
    pub fn moment(&self) -> BeatMoment {
        self.moment_at(self.now_secs())
    }

    /// Tempo, phase and confidence at a time not before the last sample; the beat is extrapolated.
    pub fn moment_at(&self, secs: f64) -> BeatMoment {
        if self.best.period == 0 {
            return BeatMoment::default();
        }
        let (begin, gap) = self.grid();
        let beats = (secs - begin) / gap;
        let phase = beats - beats.floor();
        BeatMoment {
            tempo_bpm: 60.0 / gap,
            phase,
            next_beat_secs: secs + (1.0 - phase) * gap,
            confidence: self.confidence(),
        }
    }

    /// Announces twice as many beats from now on.
    pub fn double(&mut self) {
        self.speed = (self.speed * 2.0).min(FASTEST_SPEED);
    }

    /// Announces half as many beats from now on.
    pub fn halve(&mut self) {
        self.speed = (self.speed / 2.0).max(SLOWEST_SPEED);
    }

    /// Takes a tap of the user at a time. Each tap sets the phase at once; from the second tap on, also the
    /// tempo. A tap within 67 ms of another one is a key that bounces.
    pub fn tap(&mut self, secs: f64) {
        if self.taps.bounces(secs) {
            return;
        }
        let tapped = self.taps.add(secs).map(|gap_secs| self.tracked(gap_secs * ONSET_RATE_HZ));
        if let Some((_, speed)) = tapped {
            self.speed = speed;
        }
        self.counted_secs = Some(secs);
        // What is tapped in silence is announced.
        self.silent_frames = 0;
        let frames_ago = (self.frames_heard as f64 - 1.0 - secs * ONSET_RATE_HZ).round();
        let count = self.belief.len() as f32;
        self.belief.fill(DOUBT / count);
        for tempo in &self.meter.tempi {
            let period = tempo.period as f64;
            // A gap within 8 % of a tempo supports that tempo. Without a gap, the last best tempo is
            // supported.
            let wanted = tapped.map_or(self.best.period as f64, |(period, _)| period);
            let off = if wanted > 0.0 { (period / wanted).ln() / 0.04 } else { 0.0 };
            let place = frames_ago.rem_euclid(period) as usize % tempo.period;
            let index = (place + tempo.period - self.ring_start(tempo.period)) % tempo.period;
            self.belief[tempo.first + index] += (-0.5 * off * off).exp() as f32;
        }
        self.normalize();
        self.find_best();
    }

    /// The period to track where the time between taps is `gap` frames, and how many beats are announced per tracked one:
    /// only tempi of the meter can be tracked. Taps that are faster still have no tempo.
    fn tracked(&self, gap: f64) -> (f64, f64) {
        let periods = || self.meter.tempi.iter().map(|tempo| tempo.period as f64);
        let (shortest, longest) = (periods().fold(f64::MAX, f64::min), periods().fold(0.0, f64::max));
        let (mut period, mut speed) = (gap, 1.0);
        while period < shortest && speed < FASTEST_SPEED {
            (period, speed) = (2.0 * period, 2.0 * speed);
        }
        while period > longest && speed > SLOWEST_SPEED {
            (period, speed) = (period / 2.0, speed / 2.0);
        }
        if (shortest..=longest).contains(&period) { (period, speed) } else { (gap, 1.0) }
    }

    /// Forgets everything, as after a seek, including taps, doubling and halving.
    ///
    /// # Errors
    /// None in practice: the rate was accepted before.
    pub fn reset(&mut self) -> Result<(), SoundError> {
        *self = Self::new(self.rate_hz as u32)?;
        Ok(())
    }

    /// The place at ring index 0: t mod period, where t is the last frame heard.
    fn ring_start(&self, period: usize) -> usize {
        (self.frames_heard.saturating_sub(1) % period as u64) as usize
    }

    /// Processes one frame: advances, perhaps changes tempo at a beat, and weights the states by the onset.
    fn step(&mut self, onset: Onset) {
        let z = self.normalizer.next(onset);
        let t = self.frames_heard;
        self.frames_heard += 1;
        let count = self.meter.tempi.len();
        let begin = |tempo: &Tempo| tempo.first + ring(0, t, tempo.period);
        for (value, tempo) in self.arriving.iter_mut().zip(&self.meter.tempi) {
            *value = self.belief[begin(tempo)];
        }
        let doubt = DOUBT * self.arriving.iter().sum::<f32>() / count as f32;
        for (i, tempo) in self.meter.tempi.iter().enumerate() {
            let rows = self.change.chunks_exact(count);
            let sum: f32 = self.arriving.iter().zip(rows).map(|(a, row)| a * row[i]).sum();
            self.belief[begin(tempo)] = (1.0 - DOUBT) * sum + doubt;
        }
        for tempo in &self.meter.tempi {
            let start = ring(0, t, tempo.period);
            self.meter.expect(tempo, start, &mut self.belief, |s, e| *s *= (z * e).exp());
        }
        self.normalize();
        self.silent_frames = if onset.all < NO_ONSET { self.silent_frames.saturating_add(1) } else { 0 };
        // In silence slow beats cost less. So a tempo that is known goes on once a whole beat is silent.
        if (1..self.silent_frames).contains(&self.best.period) {
            self.best.place = (self.best.place + 1) % self.best.period;
        } else {
            self.find_best();
        }
        self.listen_for_clarity(z);
    }

    fn normalize(&mut self) {
        let sum: f32 = self.belief.iter().sum();
        let count = self.belief.len() as f32;
        if sum > 0.0 && sum.is_finite() {
            let scale = 1.0 / sum;
            // Keeps every state possible: a wrong tempo can be corrected later.
            let least = 1e-9 / count;
            for b in &mut self.belief {
                *b = (*b * scale).max(least);
            }
        } else {
            self.belief.fill(1.0 / count);
        }
    }

    fn find_best(&mut self) {
        let mut best = (0.0f32, 0, 0);
        for (i, tempo) in self.meter.tempi.iter().enumerate() {
            for (index, &b) in self.belief[tempo.first..tempo.first + tempo.period].iter().enumerate() {
                if b > best.0 {
                    best = (b, i, index);
                }
            }
        }
        let tempo = self.meter.tempi[best.1];
        let place = (best.2 + self.ring_start(tempo.period)) % tempo.period;
        self.best = Best { period: tempo.period, place, mass: best.0 };
    }

    fn listen_for_clarity(&mut self, z: f32) {
        if self.best.place.min(self.best.period - self.best.place) <= 3 {
            let keep = 0.98;
            self.clarity = keep * self.clarity + (1.0 - keep) * f64::from(z.max(0.0));
        }
    }

    fn confidence(&self) -> f64 {
        // Mean deviation near beats: random onsets give 0.4, a clear pulse more than 1.5.
        ((self.clarity - 0.4) / 1.1).clamp(0.0, 1.0)
    }

    /// The time of a beat and the time between beats, as announced.
    fn grid(&self) -> (f64, f64) {
        let frame_secs = self.frames_heard.saturating_sub(1) as f64 / ONSET_RATE_HZ;
        let period_secs = self.best.period as f64 / ONSET_RATE_HZ;
        let mut begin = frame_secs - self.best.place as f64 / ONSET_RATE_HZ;
        // Beats at half the speed go on from the last one, not from each that is tracked.
        if let Some(counted_secs) = self.counted_secs.filter(|_| self.speed < 1.0) {
            let since = ((begin - counted_secs) / period_secs).round();
            begin -= since.rem_euclid(1.0 / self.speed) * period_secs;
        }
        (begin, period_secs / self.speed)
    }

    fn announce(&mut self) {
        let is_over = self.silent_frames > LONGEST_BREAK_BEATS * self.best.period;
        if self.best.period == 0 || self.best.mass <= 0.0 || self.clarity <= 0.0 || is_over {
            return;
        }
        let now = self.now_secs();
        let (begin, gap) = self.grid();
        let last = begin + ((now - begin) / gap).floor() * gap;
        let rested = last - self.last_beat_secs > SHORTEST_GAP * gap;
        if rested && now - last <= LATEST_SECS {
            self.last_beat_secs = now;
            self.counted_secs = Some(now);
            keep(&mut self.pending, now);
            if let Some(bar) = self.bars.beat(now) {
                keep(&mut self.begun, bar);
            }
        }
    }
}

/// Adds a value; the oldest one is dropped where too many wait.
fn keep<T>(waiting: &mut VecDeque<T>, value: T) {
    if waiting.len() == MOST_WAITING {
        waiting.pop_front();
    }
    waiting.push_back(value);
}

/// Four beats for each of the fastest tempo that is tracked are not so near.
const BOUNCE_SECS: f64 = 0.0675;

impl Taps {
    /// Whether a tap is the echo of the last one.
    fn bounces(&self, secs: f64) -> bool {
        let last = self.count.checked_sub(1).map(|i| self.secs[i]);
        last.is_some_and(|last| (0.0..BOUNCE_SECS).contains(&(secs - last)))
    }

    /// The time between taps, once there are two. A pause of 2 s starts over.
    fn add(&mut self, secs: f64) -> Option<f64> {
        let last = self.count.checked_sub(1).map(|i| self.secs[i]);
        if last.is_some_and(|last| !(0.0..2.0).contains(&(secs - last))) {
            self.count = 0;
        }
        if self.count == self.secs.len() {
            self.secs.rotate_left(1);
            self.count -= 1;
        }
        self.secs[self.count] = secs;
        self.count += 1;
        (self.count >= 2).then(|| (secs - self.secs[0]) / (self.count - 1) as f64)
    }
}
