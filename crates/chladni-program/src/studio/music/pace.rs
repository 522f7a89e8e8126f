//! Frame rate before detail: fewer harmonics if the machine does not keep up, more if it does.

use std::time::Duration;

/// Hearing, mapping and synthesis may take this long.
const BUDGET_SECS: f64 = 0.020;
/// With less than this there is room for more.
const ROOM_SECS: f64 = 0.008;
/// Frames that are averaged.
const FRAMES: u32 = 24;
/// Fewer harmonics than this are never used.
const FEWEST: u32 = 32;

/// How long frames take, and how many harmonics that leaves room for.
#[derive(Clone, Debug, Default)]
pub struct Pace {
    total_secs: f64,
    frames: u32,
    harmonics: Option<u32>,
    mean_secs: f64,
}

impl Pace {
    /// Harmonics in use; `None` is all.
    pub fn harmonics(&self) -> Option<u32> {
        self.harmonics
    }

    /// How long a frame took of late, without drawing.
    pub fn mean_secs(&self) -> f64 {
        self.mean_secs
    }

    /// Counts a frame that took this long before drawing, of a body of `all` harmonics. Returns a message
    /// when the number in use changes.
    pub fn frame(&mut self, took: Duration, all: usize) -> Option<String> {
        self.count(took.as_secs_f64(), all as u32)
    }

    fn count(&mut self, secs: f64, all: u32) -> Option<String> {
        self.total_secs += secs;
        self.frames += 1;
        if self.frames < FRAMES {
            return None;
        }
        self.mean_secs = self.total_secs / f64::from(self.frames);
        (self.total_secs, self.frames) = (0.0, 0);
        let now = self.harmonics.unwrap_or(all);
        if self.mean_secs > BUDGET_SECS && now > FEWEST {
            let fewer = (now / 2).max(FEWEST);
            self.harmonics = Some(fewer);
            return Some(format!("This machine is too slow for {now} harmonics: {fewer} are in use."));
        }
        if self.mean_secs < ROOM_SECS && now < all {
            let more = (now * 2).min(all);
            self.harmonics = (more < all).then_some(more);
            return Some(format!("There is room again: {more} harmonics are in use."));
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn harmonics_drop_while_frames_are_late_and_come_back() {
        let mut pace = Pace::default();
        let messages = |pace: &mut Pace, secs| (0..FRAMES).filter_map(|_| pace.count(secs, 200)).count();
        assert_eq!((messages(&mut pace, 0.015), pace.harmonics()), (0, None));
        assert_eq!((messages(&mut pace, 0.030), pace.harmonics()), (1, Some(100)));
        assert_eq!((messages(&mut pace, 0.030), pace.harmonics()), (1, Some(50)));
        assert_eq!((messages(&mut pace, 0.030), pace.harmonics()), (1, Some(32)));
        assert_eq!((messages(&mut pace, 0.030), pace.harmonics()), (0, Some(32)));
        assert_eq!((messages(&mut pace, 0.015), pace.harmonics()), (0, Some(32)));
        for harmonics in [Some(64), Some(128), None] {
            assert_eq!((messages(&mut pace, 0.002), pace.harmonics()), (1, harmonics));
        }
        assert_eq!(messages(&mut pace, 0.002), 0);
    }
}
