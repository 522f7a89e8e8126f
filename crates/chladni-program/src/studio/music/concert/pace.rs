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

/// A change of how many harmonics are in use, in words.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Change {
    /// Some are left out, or more than before.
    Fewer(String),
    /// Some are back.
    More(String),
}

impl Pace {
    /// At most this many harmonics are in use; `None` is all.
    pub fn harmonics(&self) -> Option<u32> {
        self.harmonics
    }

    /// How long a frame took of late, without drawing.
    pub fn mean_secs(&self) -> f64 {
        self.mean_secs
    }

    /// Counts a frame that took this long before drawing, of dances that use `wanted` harmonics if none are left out.
    /// Returns a change of the number in use.
    pub fn frame(&mut self, took: Duration, wanted: u32) -> Option<Change> {
        self.count(took.as_secs_f64(), wanted)
    }

    fn count(&mut self, secs: f64, wanted: u32) -> Option<Change> {
        self.total_secs += secs;
        self.frames += 1;
        if self.frames < FRAMES {
            return None;
        }
        self.mean_secs = self.total_secs / f64::from(self.frames);
        (self.total_secs, self.frames) = (0.0, 0);
        // Those above have no weight: to leave them out saves nothing.
        let now = self.harmonics.map_or(wanted, |most| most.min(wanted));
        if self.mean_secs > BUDGET_SECS && now > FEWEST {
            let fewer = (now / 2).max(FEWEST);
            self.harmonics = Some(fewer);
            let text = format!("This machine is too slow for {now} harmonics: {fewer} are in use.");
            return Some(Change::Fewer(text));
        }
        if self.mean_secs < ROOM_SECS && now < wanted {
            let more = (now * 2).min(wanted);
            self.harmonics = (more < wanted).then_some(more);
            return Some(Change::More(format!("There is room again: {more} harmonics are in use.")));
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

    #[test]
    fn harmonics_that_no_dance_uses_are_not_left_out() {
        let mut pace = Pace::default();
        let message = |pace: &mut Pace, secs, wanted| {
            let said = (0..FRAMES).filter_map(|_| pace.count(secs, wanted)).map(|change| match change {
                Change::Fewer(text) => text,
                Change::More(text) => format!("Good news: {text}"),
            });
            said.collect::<String>()
        };
        // Of a shape of 512, dances use the first 64.
        assert!(message(&mut pace, 0.030, 64).contains("too slow for 64 harmonics: 32"));
        assert_eq!(pace.harmonics(), Some(32));
        assert!(
            message(&mut pace, 0.002, 64)
                .starts_with("Good news: There is room again: 64 harmonics are in use")
                && pace.harmonics().is_none()
        );
        // A limit above what is used stays, and says nothing.
        assert!(message(&mut pace, 0.030, 512).contains("256 are in use"));
        assert_eq!((message(&mut pace, 0.002, 64).as_str(), pace.harmonics()), ("", Some(256)));
        assert!(message(&mut pace, 0.030, 64).contains("too slow for 64 harmonics: 32"));
        assert_eq!((message(&mut pace, 0.030, 20).as_str(), pace.harmonics()), ("", Some(32)));
    }
}
