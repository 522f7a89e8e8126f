//! State that the engine and its handles share.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use super::clock::Clock;
use super::queue::{Dropped, Stretches};
use crate::history::History;

/// The audio callback uses only the clock and never waits.
pub(super) struct Shared {
    pub clock: Arc<Clock>,
    pub timeline: Mutex<Timeline>,
}

pub(super) struct Timeline {
    pub stretches: Stretches,
    pub dropped: Dropped,
    pub history: History,
    pub rate_hz: u32,
    pub device: Option<String>,
    pub playing: bool,
    pub stopped: bool,
}

impl Shared {
    pub fn new(volume: f32) -> Self {
        let clock = Arc::new(Clock::new());
        clock.set_volume(volume.clamp(0.0, 1.0));
        let timeline = Mutex::new(Timeline {
            stretches: Stretches::default(),
            dropped: Dropped::default(),
            history: History::new(0),
            rate_hz: 0,
            device: None,
            playing: false,
            stopped: true,
        });
        Self { clock, timeline }
    }

    /// If another thread panicked while it held the lock, the music continues.
    pub fn timeline(&self) -> MutexGuard<'_, Timeline> {
        self.timeline.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
