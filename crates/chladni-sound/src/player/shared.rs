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
    /// How many outputs there were: each counts its frames anew.
    pub outputs: u64,
    pub rate_hz: u32,
    pub device: Option<String>,
    pub playing: bool,
    pub stopped: bool,
    /// Stopped because the last song was heard to its end.
    pub over: bool,
}

impl Shared {
    pub fn new(volume: f32) -> Self {
        let clock = Arc::new(Clock::new());
        clock.set_volume(volume);
        let timeline = Mutex::new(Timeline {
            stretches: Stretches::default(),
            dropped: Dropped::default(),
            history: History::new(0),
            outputs: 0,
            rate_hz: 0,
            device: None,
            playing: false,
            stopped: true,
            over: false,
        });
        Self { clock, timeline }
    }

    /// If another thread panicked while it held the lock, the music continues.
    pub fn timeline(&self) -> MutexGuard<'_, Timeline> {
        self.timeline.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_player_begins_with_a_volume_that_is_a_number() {
        let volumes = [f32::NAN, f32::INFINITY, -1.0, 0.5, 7.0];
        assert_eq!(volumes.map(|volume| Shared::new(volume).clock.volume()), [0.0, 0.0, 0.0, 0.5, 1.0]);
    }
}
