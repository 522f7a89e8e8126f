//! The instruments: each is a function of the time since its note began, with an amplitude of about 1.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use std::f32::consts::TAU;

/// White noise in [−1, 1] from a seed.
pub(super) struct Noise(ChaCha8Rng);

impl Noise {
    pub fn new(seed: u64) -> Self {
        Self(ChaCha8Rng::seed_from_u64(seed))
    }

    pub fn next(&mut self) -> f32 {
        self.0.next_u32() as f32 / (u32::MAX as f32 / 2.0) - 1.0
    }
}

/// A sine that falls from 155 to 45 Hz.
pub(super) fn kick(t: f32) -> f32 {
    const FALL_SECS: f32 = 0.035;
    let phase = 45.0 * t + 110.0 * FALL_SECS * (1.0 - (-t / FALL_SECS).exp());
    (TAU * phase).sin() * (-t / 0.14).exp()
}

/// A snare drum: its skin and its wires.
pub(super) fn snare(t: f32, noise: f32) -> f32 {
    0.5 * (TAU * 185.0 * t).sin() * (-t / 0.06).exp() + 0.6 * noise * (-t / 0.08).exp()
}

/// An envelope that rises in 5 ms and falls in 30 ms after `secs`.
fn gate(t: f32, secs: f32) -> f32 {
    (t / 0.005).min(1.0) * ((secs + 0.03 - t) / 0.03).clamp(0.0, 1.0)
}

pub(super) fn bass(t: f32, hz: f32, secs: f32) -> f32 {
    let body: f32 =
        (1..=6).map(|h| h as f32).map(|h| (TAU * h * hz * t).sin() / h * (-t * 2.5 * (h - 1.0)).exp()).sum();
    body * (0.4 + 0.6 * (-t / 0.25).exp()) * gate(t, secs)
}

/// Two slightly detuned soft tones that swell and fade.
pub(super) fn pad(t: f32, hz: f32, secs: f32) -> f32 {
    let swell = (t / 0.25).min(1.0) * ((secs + 0.4 - t) / 0.5).clamp(0.0, 1.0);
    let tone = |hz: f32| {
        (TAU * hz * t).sin() + 0.35 * (TAU * 2.0 * hz * t).sin() + 0.12 * (TAU * 3.0 * hz * t).sin()
    };
    (tone(hz * 1.002) + tone(hz * 0.998)) * swell
}

/// A plucked string: higher partials decay faster.
pub(super) fn pluck(t: f32, hz: f32, _secs: f32) -> f32 {
    let string: f32 = (1..=10)
        .map(|h| h as f32)
        .take_while(|h| h * hz < 16_000.0)
        .map(|h| (TAU * h * hz * t).sin() / h.powf(0.8) * (-t * (2.5 + 2.2 * h)).exp())
        .sum();
    0.6 * string * (t / 0.002).min(1.0)
}

/// A bell by frequency modulation (Chowning 1973) with ratio 3.5, whose brightness fades first.
pub(super) fn bell(t: f32, hz: f32, _secs: f32) -> f32 {
    let index = 2.2 * (-t / 0.18).exp();
    let modulator = (TAU * 3.5 * hz * t).sin();
    0.8 * (TAU * hz * t + index * modulator).sin() * (-t / 0.35).exp() * (t / 0.002).min(1.0)
}
