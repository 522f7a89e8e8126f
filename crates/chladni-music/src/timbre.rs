//! Timbres: how harmonics ring, and the tones of the bank of resonators in which they do.

use serde::{Deserialize, Serialize};

/// The number of frequencies in the bank, in even factors from 0.4 to 12 Hz: neighbors differ by 5.5 %.
pub const TONES: usize = 64;
/// The lowest frequency of the bank.
pub const LOWEST_HZ: f32 = 0.4;
/// The highest frequency of the bank: a period of two and a half frames at 30 Hz.
pub const HIGHEST_HZ: f32 = 12.0;

/// How harmonics ring. It makes a shape look like a certain material.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Timbre {
    /// ζ in [0.01, 2]; from 1 on nothing overshoots.
    pub damping: f32,
    /// The frequency of the slowest harmonic, in Hz, above 0.
    pub tuning_hz: f32,
    /// Frequencies are proportional to √λ to this power: 1 is the ratio of a membrane, 0 gives all
    /// harmonics one frequency.
    pub stretch: f32,
    /// s ≥ 0: a rise of the sound by 1 makes a harmonic swing about this far.
    pub strike: f32,
    /// h ≥ 0: how far a steady sound of level 1 displaces a harmonic.
    pub hold: f32,
}

impl Timbre {
    /// Named timbres, the default first.
    pub const NAMED: [(&'static str, Self); 6] = [
        ("rubber", Self { damping: 0.7, tuning_hz: 5.0, stretch: 0.45, strike: 2.4, hold: 0.5 }),
        ("jelly", Self { damping: 0.3, tuning_hz: 3.0, stretch: 0.45, strike: 3.5, hold: 0.25 }),
        ("bell", Self { damping: 0.04, tuning_hz: 2.5, stretch: 0.6, strike: 1.0, hold: 0.1 }),
        ("drum", Self { damping: 0.3, tuning_hz: 3.0, stretch: 0.5, strike: 1.8, hold: 0.15 }),
        ("cloth", Self { damping: 0.55, tuning_hz: 0.7, stretch: 0.6, strike: 1.6, hold: 0.8 }),
        ("metal", Self { damping: 0.08, tuning_hz: 4.0, stretch: 0.8, strike: 1.1, hold: 0.25 }),
    ];

    /// The timbre with that name.
    pub fn named(name: &str) -> Option<Self> {
        Self::NAMED.into_iter().find(|(known, _)| *known == name).map(|(_, timbre)| timbre)
    }

    /// The tone of the bank in which a harmonic with eigenvalue `lambda` rings. `slowest` is the eigenvalue
    /// of the slowest wave.
    pub(crate) fn tone(&self, lambda: f64, slowest: f64) -> u8 {
        let ratio = (lambda / slowest).max(1.0).sqrt() as f32;
        let hz = self.tuning_hz * ratio.powf(self.stretch);
        let share = (hz / LOWEST_HZ).ln() / (HIGHEST_HZ / LOWEST_HZ).ln();
        (share.clamp(0.0, 1.0) * (TONES - 1) as f32).round() as u8
    }
}

/// Frequency of a tone of the bank, in Hz.
pub(crate) fn tone_hz(tone: usize) -> f32 {
    LOWEST_HZ * (HIGHEST_HZ / LOWEST_HZ).powf(tone as f32 / (TONES - 1) as f32)
}
