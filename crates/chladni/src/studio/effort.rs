//! Moving pictures before fine ones: what is drawn with less effort while frames are late.

use chladni_view::Samples;

/// A frame that takes longer than this is late.
const LATE_SECS: f64 = 0.050;
/// Frames that come faster than this leave room.
const EARLY_SECS: f64 = 0.020;
/// A longer pause is no animation.
const PAUSE_SECS: f64 = 0.24;
/// So many frames are looked at together.
const FRAMES: u32 = 12;
/// After so long without trouble more is tried; twice as long after each time that it failed.
const PATIENCE_SECS: f64 = 6.0;

/// What is drawn, from the best.
const STEPS: [Quality; 4] = [
    Quality { samples: Samples::Four, percent: 100 },
    Quality { samples: Samples::One, percent: 100 },
    Quality { samples: Samples::One, percent: 75 },
    Quality { samples: Samples::One, percent: 50 },
];

/// How finely a picture is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Quality {
    /// Samples a pixel.
    pub samples: Samples,
    /// Width and height in percent of what is shown.
    pub percent: u32,
}

impl Quality {
    /// That of pictures that do not move.
    pub const STILL: Self = STEPS[0];
}

impl std::fmt::Display for Quality {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}", self.samples)?;
        if self.percent < 100 { write!(f, ", {} % of its size", self.percent) } else { Ok(()) }
    }
}

/// The effort that this machine has room for.
#[derive(Clone, Debug)]
pub struct Effort {
    first: usize,
    step: usize,
    last_secs: Option<f64>,
    total_secs: f64,
    frames: u32,
    changed_secs: f64,
    patience_secs: f64,
}

impl Effort {
    /// Begins with what suits a device that draws with so many samples.
    pub fn new(samples: Samples) -> Self {
        let first = usize::from(samples == Samples::One);
        Self {
            first,
            step: first,
            last_secs: None,
            total_secs: 0.0,
            frames: 0,
            changed_secs: 0.0,
            patience_secs: PATIENCE_SECS,
        }
    }

    /// How moving pictures are drawn now.
    pub fn quality(&self) -> Quality {
        STEPS[self.step]
    }

    /// Whether this is less than the device began with.
    pub fn is_reduced(&self) -> bool {
        self.step > self.first
    }

    /// Counts a moving picture that is drawn at `now_secs`.
    pub fn frame(&mut self, now_secs: f64) {
        let Some(last_secs) = self.last_secs.replace(now_secs) else { return };
        let secs = now_secs - last_secs;
        if !(0.0..PAUSE_SECS).contains(&secs) {
            (self.total_secs, self.frames) = (0.0, 0);
            return;
        }
        self.total_secs += secs;
        self.frames += 1;
        if self.frames < FRAMES {
            return;
        }
        let mean_secs = self.total_secs / f64::from(self.frames);
        (self.total_secs, self.frames) = (0.0, 0);
        let calm_secs = now_secs - self.changed_secs;
        if mean_secs > LATE_SECS && self.step + 1 < STEPS.len() {
            // What had just been tried was too much.
            if calm_secs < PATIENCE_SECS {
                self.patience_secs *= 2.0;
            }
            (self.step, self.changed_secs) = (self.step + 1, now_secs);
        } else if mean_secs < EARLY_SECS && self.is_reduced() && calm_secs > self.patience_secs {
            (self.step, self.changed_secs) = (self.step - 1, now_secs);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Frames of `frame_secs` for `secs` seconds.
    fn play(effort: &mut Effort, now_secs: &mut f64, secs: f64, frame_secs: f64) {
        let end_secs = *now_secs + secs;
        while *now_secs < end_secs {
            *now_secs += frame_secs;
            effort.frame(*now_secs);
        }
    }

    #[test]
    fn effort_falls_while_frames_are_late_and_comes_back() {
        let (mut effort, mut now_secs) = (Effort::new(Samples::Four), 0.0);
        play(&mut effort, &mut now_secs, 3.0, 0.016);
        assert_eq!((effort.quality(), effort.is_reduced()), (Quality::STILL, false));
        play(&mut effort, &mut now_secs, 1.2, 0.08);
        assert_eq!(effort.quality(), Quality { samples: Samples::One, percent: 100 });
        play(&mut effort, &mut now_secs, 9.0, 0.08);
        assert_eq!((effort.quality().percent, effort.is_reduced()), (50, true));
        // Neither late nor early: it stays.
        play(&mut effort, &mut now_secs, 60.0, 0.03);
        assert_eq!(effort.quality().percent, 50);
        play(&mut effort, &mut now_secs, 200.0, 0.016);
        assert_eq!(effort.quality(), Quality::STILL);
    }

    #[test]
    fn pauses_are_not_late_frames_and_software_begins_with_one_sample() {
        let (mut effort, mut now_secs) = (Effort::new(Samples::One), 0.0);
        play(&mut effort, &mut now_secs, 60.0, 0.5);
        assert_eq!(effort.quality(), Quality { samples: Samples::One, percent: 100 });
        assert!(!effort.is_reduced());
    }
}
