//! Automatic level: compensates differences between loud and quiet masters, bass and treble, mid and side.

/// How the spectrum is brought to a common level.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Level {
    /// In loud passages the loudest band of the last two seconds is 1; in soft passages it is less. Softer
    /// bands are raised by most of their difference (docs/sound.md, "Level").
    Auto,
    /// Amplitudes are multiplied by this.
    Fixed(f32),
}

/// The lowest level of the loudest band (−74 dB). It keeps the noise before a song from being amplified to
/// the level of music.
const FLOOR: f32 = 2e-4;
/// Below the floor a sound fades to nothing; this share of the floor (−194 dB in all) stands for silence.
const NOTHING: f32 = 1e-6;
/// How long the loudest moment is remembered: a bar of slow music.
const MEMORY_SECS: f64 = 2.0;
/// The memory consists of this many slots of an eighth of a second.
const SLOTS: usize = 16;
/// Once the loudest moment is forgotten, the level falls with this time constant, in decibels.
const RELEASE_SECS: f64 = 0.3;

/// The share of a band's difference from the loudest band, in decibels, that is compensated.
const LIFT: f32 = 0.8;
/// The lowest relative level of a band (−60 dB); softer bands are not raised further, because they are
/// hiss.
const SOFTEST: f32 = 1e-3;
/// A band's level rises at once, and falls with this time constant, in decibels.
const BAND_RELEASE_SECS: f64 = 4.0;
/// Leveled amplitudes are raised to this power: a sound 10 dB softer than the level of its band appears 7
/// dB softer.
const COMPRESSION: f32 = 0.7;

/// The share of a passage's difference from the loud ones, in decibels, that is shown: 20 dB softer looks
/// 10 dB softer.
const DYNAMICS: f32 = 0.5;
/// If the level of a song's loud passages is not known, it is learned from the song and forgotten with this
/// time constant, in decibels.
const LOUD_RELEASE_SECS: f64 = 15.0;

/// The gain of each band and of the side.
pub(super) struct Leveler {
    whole: LevelFollower,
    /// The level of loud passages, known or learned.
    loud: f32,
    is_known: bool,
    /// The gain of the present passage.
    softness: f32,
    side: LevelFollower,
    /// For each band, its own level relative to that of the loudest, in [`SOFTEST`, 1].
    bands: Vec<f32>,
}

impl Leveler {
    /// A leveler for `bands` bands. `loud` is the level of the song's loud passages, if it is known.
    pub fn new(bands: usize, loud: Option<f32>) -> Self {
        let loud = loud.filter(|loud| *loud > FLOOR && loud.is_finite());
        Self {
            whole: LevelFollower::new(),
            loud: loud.unwrap_or(FLOOR),
            is_known: loud.is_some(),
            softness: 1.0,
            side: LevelFollower::new(),
            bands: vec![SOFTEST; bands],
        }
    }

    /// Goes on from the levels that another one has followed, whose bands may be others.
    pub fn remember(&mut self, before: Self) {
        *self = Self { bands: std::mem::take(&mut self.bands), ..before };
    }

    /// Takes the amplitude of each band in the louder channel, `dt_secs` after the previous ones, and
    /// replaces it by the gain of the band.
    pub fn follow(&mut self, amplitudes: &mut [f32], dt_secs: f64) {
        let level = self.whole.follow(amplitudes.iter().fold(0.0, |a: f32, &b| a.max(b)), dt_secs);
        if !self.is_known {
            let keep = (-dt_secs / LOUD_RELEASE_SECS).exp() as f32;
            self.loud = followed(self.loud, level, keep);
        }
        // Lifting each band would undo the floor.
        self.softness = self.whole.presence * (level / self.loud).min(1.0).powf(DYNAMICS);
        let keep = (-dt_secs / BAND_RELEASE_SECS).exp() as f32;
        for (own, amplitude) in self.bands.iter_mut().zip(amplitudes) {
            let now = (*amplitude / level).clamp(SOFTEST, 1.0);
            *own = followed(*own, now, keep);
            let leveled = *amplitude / (level * own.powf(LIFT));
            let gain = self.softness * leveled.powf(COMPRESSION) / *amplitude;
            *amplitude = if leveled > 0.0 { gain } else { 0.0 };
        }
    }

    /// The gain of the side: `most`, or less, if that brings the side's loudest leveled band of the last
    /// two seconds to 1. `loudest` is that band now.
    pub fn side_gain(&mut self, loudest: f32, most: f32, dt_secs: f64) -> f32 {
        most.min(1.0 / self.side.follow(loudest / self.softness, dt_secs))
    }
}

/// Follows the level. It rises at once, and falls in decibels toward the loudest moment of the last 2 s. It
/// scales with the sound: a master that is 40 dB quieter gives the same result.
struct LevelFollower {
    slots: [f32; SLOTS],
    slot: usize,
    slot_secs: f64,
    level: f32,
    /// The level as a share of the floor, in [`NOTHING`, 1].
    presence: f32,
}

impl LevelFollower {
    fn new() -> Self {
        Self { slots: [0.0; SLOTS], slot: 0, slot_secs: 0.0, level: 0.0, presence: NOTHING }
    }

    /// Takes the amplitude of the loudest band, `dt_secs` after the previous one. Returns the level.
    fn follow(&mut self, loudest: f32, dt_secs: f64) -> f32 {
        let per_slot = MEMORY_SECS / SLOTS as f64;
        self.slot_secs += dt_secs;
        let passed = (self.slot_secs / per_slot).floor();
        self.slot_secs -= passed * per_slot;
        for _ in 0..(passed.min(SLOTS as f64) as usize) {
            self.slot = (self.slot + 1) % SLOTS;
            self.slots[self.slot] = 0.0;
        }
        self.slots[self.slot] = self.slots[self.slot].max(loudest);
        let remembered = self.slots.iter().fold(0.0f32, |a, &b| a.max(b));
        let keep = (-dt_secs / RELEASE_SECS).exp() as f32;
        self.level = followed(self.level, remembered.max(FLOOR), keep);
        self.presence = followed(self.presence, (remembered / FLOOR).clamp(NOTHING, 1.0), keep);
        self.level
    }
}

/// A level that rises at once from `was` to `now`, and falls by all but the share `keep` of the difference
/// in decibels.
fn followed(was: f32, now: f32, keep: f32) -> f32 {
    if now >= was { now } else { now * (was / now).powf(keep) }
}
