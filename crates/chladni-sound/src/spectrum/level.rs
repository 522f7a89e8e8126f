//! One loudness for loud and quiet masters.

/// How the spectrum is brought to a common level.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Level {
    /// The loudest band of the last two seconds is 1.
    Auto,
    /// Amplitudes are multiplied by this.
    Fixed(f32),
}

/// The level never falls below this amplitude of a band (−74 dB): the noise before a song is not to
/// be blown up to the size of music.
const FLOOR: f32 = 2e-4;
/// The loudest moment is remembered this long: a bar of slow music.
const MEMORY_SECS: f64 = 2.0;
/// The memory is kept in slots of an eighth of a second.
const SLOTS: usize = 16;
/// Once the loudest moment is forgotten the level sinks with this time constant, in decibels.
const RELEASE_SECS: f64 = 0.3;

/// Follows the level: up at once, down in decibels towards the loudest of the last 2 s.
/// All of it scales with the sound, so that a master 40 dB quieter gives the same result.
pub(super) struct LevelFollower {
    slots: [f32; SLOTS],
    slot: usize,
    slot_secs: f64,
    level: f32,
}

impl LevelFollower {
    pub fn new() -> Self {
        Self { slots: [0.0; SLOTS], slot: 0, slot_secs: 0.0, level: 0.0 }
    }

    /// Takes the loudest band of a frame `dt_secs` after the last one; returns the level.
    pub fn follow(&mut self, loudest: f32, dt_secs: f64) -> f32 {
        let per_slot = MEMORY_SECS / SLOTS as f64;
        self.slot_secs += dt_secs;
        let passed = (self.slot_secs / per_slot).floor();
        self.slot_secs -= passed * per_slot;
        for _ in 0..(passed.min(SLOTS as f64) as usize) {
            self.slot = (self.slot + 1) % SLOTS;
            self.slots[self.slot] = 0.0;
        }
        self.slots[self.slot] = self.slots[self.slot].max(loudest);
        let remembered = self.slots.iter().fold(FLOOR, |a, &b| a.max(b));
        self.level = if remembered >= self.level {
            remembered
        } else {
            let keep = (-dt_secs / RELEASE_SECS).exp() as f32;
            remembered * (self.level / remembered).powf(keep)
        };
        self.level
    }
}
