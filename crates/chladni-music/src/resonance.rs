//! Resonators: harmonics as damped oscillators that the bands of sound strike.
//!
//! Between the sound and a mapping lies a bank of oscillators
//!
//! ```text
//! q̈ + 2 ζ ω q̇ + ω² q = ω² h f(t),      q̇ += ω s max(0, Δf) where f rises by Δf,
//! ```
//!
//! There is one for each band of sound and each of [`TONES`] frequencies ω; h holds the level, s strikes. A
//! mapping is linear in its bands: a harmonic of frequency ω that is driven by the sum of some bands moves
//! as the sum of their oscillators. One bank therefore serves all dances, and none of them has a state of
//! its own. The movement at any time depends only on the sound up to then, not on how often it was drawn or
//! the breeding and choices in between.

use rayon::prelude::*;

use crate::ringing::SIGNALS;
use crate::stereo::StereoMix;
use crate::timbre::{TONES, Timbre, tone_hz};
use crate::{Bands, Ringing};

/// The largest number of pieces of sound that wait before the oscillators process them together.
const WAITING: usize = 32;

/// From so many levels of bands on, tones are solved on all threads: a knob that sets the number of bands to thousands lets
/// the bank hear the last seconds again within a frame.
const WIDE: usize = 4096;

/// The bank of oscillators.
///
/// Sound comes in as pieces of constant level, and each is solved exactly. [`hear`](Self::hear) begins a
/// piece, and [`ring`](Self::ring) gives the oscillators at a time within it. Pieces are solved together,
/// tone by tone, when the result is needed: the state of a tone is then read from memory once for all of
/// them.
#[derive(Clone, Debug)]
pub struct Resonators {
    damping: f32,
    strike: f32,
    hold: f32,
    bands: usize,
    /// For each tone s ω, which a rise of 1 adds to q̇.
    strokes: [f32; TONES],
    signals: [Row; SIGNALS],
    /// The number of pieces of sound that were heard but not yet solved. Each began when the one before it
    /// had lasted as long as `piece`.
    waiting: usize,
    piece: Step,
    /// The step from the beginning of the current piece to now.
    within: Step,
    now: Ringing,
}

/// The oscillators of one signal.
#[derive(Clone, Debug)]
struct Row {
    /// q and q̇ at the beginning of the last piece that was solved.
    q: Vec<f32>,
    speed: Vec<f32>,
    /// f of that piece and of those that wait, one row of bands per piece.
    levels: Vec<f32>,
    /// The strikes at the beginning of each piece that waits.
    rises: Vec<f32>,
}

/// The exact solution over one time step for each tone: with y = q − h f, y(t) = a y + b ẏ and ẏ(t) = c y +
/// d ẏ.
#[derive(Clone, Debug)]
struct Step {
    secs: f32,
    tones: [[f32; 4]; TONES],
}

impl Step {
    fn of(secs: f32, damping: f32) -> Self {
        Self { secs, tones: std::array::from_fn(|tone| exact(secs, tone_hz(tone), damping)) }
    }

    fn set(&mut self, secs: f32, damping: f32) {
        if self.secs != secs {
            *self = Self::of(secs, damping);
        }
    }
}

/// Sets decaying values to 0 before they become denormal numbers: processors are some fifty times slower
/// with these, and each pause of a song would be full of them.
#[inline]
fn audible(x: f32) -> f32 {
    if x.abs() < 1e-18 { 0.0 } else { x }
}

/// a, b, c and d of one oscillator, underdamped (ζ < 1) or not.
fn exact(secs: f32, hz: f32, damping: f32) -> [f32; 4] {
    let (t, omega, zeta) = (f64::from(secs), std::f64::consts::TAU * f64::from(hz), f64::from(damping));
    let decay = (-zeta * omega * t).exp();
    // sin(ω_d t)/ω_d and cos(ω_d t), or their hyperbolic counterparts, as they decay; the first is t if ω_d is 0.
    let square = omega * omega * (1.0 - zeta * zeta);
    let x = square.abs().sqrt();
    let (sine, cosine) = match () {
        () if x * t < 1e-6 => (decay * t, decay),
        () if square > 0.0 => (decay * (x * t).sin() / x, decay * (x * t).cos()),
        // Decayed before they are added: sinh and cosh alone would overflow.
        () => {
            let [slow, fast] = [x, -x].map(|x| ((x - zeta * omega) * t).exp());
            (0.5 * (slow - fast) / x, 0.5 * (slow + fast))
        }
    };
    let of_rate = zeta * omega * sine;
    [cosine + of_rate, sine, -omega * omega * sine, cosine - of_rate].map(|x| x as f32)
}

impl Resonators {
    /// A bank at rest for `bands` bands.
    pub fn new(timbre: &Timbre, bands: usize) -> Self {
        let silence = vec![0.0; TONES * bands];
        let row = Row {
            q: silence.clone(),
            speed: silence.clone(),
            levels: vec![0.0; (WAITING + 1) * bands],
            rises: vec![0.0; WAITING * bands],
        };
        Self {
            damping: timbre.damping,
            strike: timbre.strike,
            hold: timbre.hold,
            bands,
            strokes: std::array::from_fn(|tone| timbre.strike * std::f32::consts::TAU * tone_hz(tone)),
            signals: std::array::from_fn(|_| row.clone()),
            waiting: 0,
            piece: Step::of(0.0, timbre.damping),
            within: Step::of(0.0, timbre.damping),
            now: Ringing { bands, q: std::array::from_fn(|_| silence.clone()) },
        }
    }

    /// Makes `bank` ring with `timbre`, creating it at rest if needed; without a timbre removes it. The
    /// bank ignores tuning and stretch, which concern only the mappings.
    pub fn follow(bank: &mut Option<Self>, timbre: Option<&Timbre>, bands: usize) {
        let has = bank.as_ref().map(|bank| (bank.damping, bank.strike, bank.hold, bank.bands));
        let wants = timbre.map(|timbre| (timbre.damping, timbre.strike, timbre.hold, bands));
        if has != wants {
            *bank = timbre.map(|timbre| Self::new(timbre, bands));
        }
    }

    /// Brings all oscillators to rest.
    pub fn still(&mut self) {
        self.waiting = 0;
        for row in &mut self.signals {
            [&mut row.levels, &mut row.q, &mut row.speed].into_iter().for_each(|values| values.fill(0.0));
        }
        self.now.q.iter_mut().for_each(|q| q.fill(0.0));
    }

    /// Begins a piece of sound, after the previous one has lasted for `lasted_secs`. A different number of
    /// bands is ignored.
    pub fn hear(&mut self, bands: &Bands<'_>, lasted_secs: f32) {
        if bands.mid.len() != self.bands {
            return;
        }
        if self.waiting == WAITING || self.piece.secs != lasted_secs {
            self.solve();
        }
        self.piece.set(lasted_secs, self.damping);
        let mix = StereoMix::new(0.0, bands, false);
        for (number, row) in self.signals.iter_mut().enumerate() {
            row.hear(self.waiting, self.bands, |band| match number {
                0 => bands.left[band],
                1 => bands.right[band],
                2 => bands.mid[band],
                3 => bands.side[band],
                _ => mix.swing(bands, band),
            });
        }
        self.waiting += 1;
    }

    /// The oscillators `after_secs` into the current piece of sound.
    pub fn ring(&mut self, after_secs: f32) -> &Ringing {
        self.solve();
        self.within.set(after_secs, self.damping);
        for (row, out) in self.signals.iter().zip(&mut self.now.q) {
            for (tone, &[a, b, ..]) in self.within.tones.iter().enumerate() {
                let of = tone * self.bands..(tone + 1) * self.bands;
                let (q, speed) = (&row.q[of.clone()], &row.speed[of.clone()]);
                for (((out, q), speed), level) in out[of].iter_mut().zip(q).zip(speed).zip(&row.levels) {
                    let held = self.hold * level;
                    *out = held + a * (q - held) + b * speed;
                }
            }
        }
        &self.now
    }

    /// Advances the oscillators to the beginning of the current piece.
    fn solve(&mut self) {
        for row in &mut self.signals {
            row.solve(self.waiting, &self.piece, self.hold, &self.strokes);
        }
        self.waiting = 0;
    }

    /// The result of the last [`ring`](Self::ring).
    pub fn ringing(&self) -> &Ringing {
        &self.now
    }
}

impl Row {
    /// Records the piece that comes after `waiting` others.
    fn hear(&mut self, waiting: usize, bands: usize, level: impl Fn(usize) -> f32) {
        let (before, after) = self.levels[waiting * bands..].split_at_mut(bands);
        let rises = &mut self.rises[waiting * bands..];
        for (band, ((before, after), rise)) in before.iter().zip(after).zip(rises).enumerate() {
            *after = level(band);
            // The side has a sign: a growing magnitude strikes, a shrinking one does not.
            let grown = after.abs() - before.abs();
            *rise = if grown > 0.0 { after.signum() * grown } else { 0.0 };
        }
    }

    /// Advances to the beginning of the last of `waiting` pieces.
    fn solve(&mut self, waiting: usize, piece: &Step, hold: f32, strokes: &[f32; TONES]) {
        let bands = self.levels.len() / (WAITING + 1);
        if waiting == 0 || bands == 0 {
            return;
        }
        let (levels, rises) = (&self.levels, &self.rises);
        let tone = |q: &mut [f32], speed: &mut [f32], step: &[f32; 4], stroke: &f32| {
            let pieces = levels.chunks_exact(bands).zip(rises.chunks_exact(bands));
            for (levels, rises) in pieces.take(waiting) {
                advance((&mut *q, &mut *speed), (levels, rises), *step, hold, *stroke);
            }
        };
        if waiting * bands >= WIDE {
            let state = self.q.par_chunks_exact_mut(bands).zip(self.speed.par_chunks_exact_mut(bands));
            state
                .zip(&piece.tones)
                .zip(strokes)
                .for_each(|(((q, speed), step), stroke)| tone(q, speed, step, stroke));
        } else {
            let state = self.q.chunks_exact_mut(bands).zip(self.speed.chunks_exact_mut(bands));
            state
                .zip(&piece.tones)
                .zip(strokes)
                .for_each(|(((q, speed), step), stroke)| tone(q, speed, step, stroke));
        }
        self.levels.copy_within(waiting * bands..(waiting + 1) * bands, 0);
    }
}

/// Advances the oscillators of one tone over one piece of sound.
#[inline]
fn advance(
    (q, speed): (&mut [f32], &mut [f32]),
    (levels, rises): (&[f32], &[f32]),
    [a, b, c, d]: [f32; 4],
    hold: f32,
    stroke: f32,
) {
    for (((q, speed), level), rise) in q.iter_mut().zip(speed).zip(levels).zip(rises) {
        let held = hold * level;
        let (y, rate) = (*q - held, *speed);
        *q = audible(held + a * y + b * rate);
        *speed = audible(c * y + d * rate + stroke * rise);
    }
}

#[cfg(test)]
mod tests;
