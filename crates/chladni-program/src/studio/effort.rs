//! Smooth movement before fine pictures: drawing quality is reduced while frames are late.

use chladni_view::{Device, Finish, Samples};

/// A frame that takes longer than this is late.
const LATE_SECS: f64 = 0.050;
/// Frames that come faster than this leave room: a screen of 30 Hz shows none sooner.
const EARLY_SECS: f64 = 0.036;
/// Frames that are judged together, fewer if they are very late.
const FRAMES: usize = 12;
/// The fewest frames that are judged after [`LONG_SECS`].
const FEWEST_FRAMES: usize = 4;
/// After this time fewer than [`FRAMES`] are judged.
const LONG_SECS: f64 = 2.0;
/// After this time without late frames a higher quality is tried; the time doubles after each failed attempt.
const PATIENCE_SECS: f64 = 6.0;

/// Qualities on a graphics card, from the best: effects on the finished picture are dropped first, that which costs most
/// before the others.
const CARD: [Quality; 6] = [
    Quality { samples: Samples::Four, percent: 100, effects: Effects::All },
    Quality { samples: Samples::Four, percent: 100, effects: Effects::Sharp },
    Quality { samples: Samples::Four, percent: 100, effects: Effects::Bare },
    Quality { samples: Samples::One, percent: 100, effects: Effects::Bare },
    Quality { samples: Samples::One, percent: 75, effects: Effects::Bare },
    Quality { samples: Samples::One, percent: 50, effects: Effects::Bare },
];
/// The same where the processor draws, which always takes four samples.
const PROCESSOR: [Quality; 5] =
    [CARD[0], CARD[1], CARD[2], Quality { percent: 75, ..CARD[2] }, Quality { percent: 50, ..CARD[2] }];

/// The effects on the finished picture that are shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Effects {
    /// All.
    All,
    /// All but depth of field.
    Sharp,
    /// Neither depth of field nor glow nor trails.
    Bare,
}

impl Effects {
    /// What is left of a finish.
    pub fn of(self, finish: Finish) -> Finish {
        match self {
            Self::All => finish,
            Self::Sharp => Finish { blur: 0.0, ..finish },
            Self::Bare => finish.without_glow(),
        }
    }
}

/// How finely a picture is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Quality {
    /// Samples a pixel.
    pub samples: Samples,
    /// Width and height in percent of the area shown.
    pub percent: u32,
    /// The effects of the finish.
    pub effects: Effects,
}

impl Quality {
    /// The quality of pictures that do not move.
    pub const STILL: Self = CARD[0];
}

impl std::fmt::Display for Quality {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}", self.samples)?;
        match self.effects {
            Effects::All => {}
            Effects::Sharp => write!(f, ", without depth of field")?,
            Effects::Bare => write!(f, ", without glow")?,
        }
        if self.percent < 100 { write!(f, ", {} % of its size", self.percent) } else { Ok(()) }
    }
}

/// The quality that this machine can keep up with.
#[derive(Clone, Debug)]
pub struct Effort {
    steps: &'static [Quality],
    step: usize,
    last_secs: Option<f64>,
    frames_secs: Vec<f64>,
    changed_secs: f64,
    /// The last change was to more.
    tried: bool,
    patience_secs: f64,
}

impl Effort {
    /// Begins with the best quality of the device.
    pub fn new(device: &Device) -> Self {
        Self {
            steps: if device.gpu().is_some() { &CARD } else { &PROCESSOR },
            step: 0,
            last_secs: None,
            frames_secs: Vec::with_capacity(FRAMES),
            changed_secs: 0.0,
            tried: false,
            patience_secs: PATIENCE_SECS,
        }
    }

    /// How moving pictures are drawn now.
    pub fn quality(&self) -> Quality {
        self.steps[self.step]
    }

    /// Whether this is less than the device began with.
    pub fn is_reduced(&self) -> bool {
        self.step > 0
    }

    /// Nothing moves: the time until the next moving picture is not counted.
    pub fn rest(&mut self) {
        self.last_secs = None;
    }

    /// The next step, of more or of less, at which a picture with this finish looks otherwise than now.
    fn other(&self, finish: Finish, less: bool) -> Option<usize> {
        let drawn = |step: usize| {
            self.steps.get(step).map(|quality| (quality.samples, quality.percent, quality.effects.of(finish)))
        };
        let differs = |step: &usize| drawn(*step) != drawn(self.step);
        if less {
            (self.step + 1..self.steps.len()).find(differs)
        } else {
            // The best of those that look alike: nothing is left to be tried above it.
            let more = (0..self.step).rev().find(differs)?;
            (0..=more).find(|step| drawn(*step) == drawn(more))
        }
    }

    /// Counts a moving picture with this finish that is drawn at `now_secs`. The window asks for the next frame at once,
    /// and says where that one shows nothing new: all other time between two pictures was needed.
    pub fn frame(&mut self, now_secs: f64, finish: Finish) {
        let Some(last_secs) = self.last_secs.replace(now_secs) else { return };
        self.frames_secs.push((now_secs - last_secs).max(0.0));
        let total_secs: f64 = self.frames_secs.iter().sum();
        let count = self.frames_secs.len();
        if count < FRAMES && (count < FEWEST_FRAMES || total_secs < LONG_SECS) {
            return;
        }
        // One frame may be late by chance, or because the window was hidden.
        self.frames_secs.sort_unstable_by(f64::total_cmp);
        let usual_secs = self.frames_secs[count / 2];
        self.frames_secs.clear();
        let calm_secs = now_secs - self.changed_secs;
        if usual_secs > LATE_SECS
            && let Some(less) = self.other(finish, true)
        {
            // The quality that was just tried was too high.
            if self.tried && calm_secs < PATIENCE_SECS {
                self.patience_secs *= 2.0;
            }
            (self.step, self.changed_secs, self.tried) = (less, now_secs, false);
        } else if usual_secs < EARLY_SECS && self.is_reduced() && calm_secs > self.patience_secs {
            let more = self.other(finish, false).unwrap_or(0);
            (self.step, self.changed_secs, self.tried) = (more, now_secs, true);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GLOWING: Finish = Finish { bloom: 0.7, ..Finish::NOTHING };

    /// A card's steps, without a card.
    fn card() -> Effort {
        Effort { steps: &CARD, ..Effort::new(&Device::Processor) }
    }

    /// Frames of `frame_secs` for `secs` seconds.
    fn play(effort: &mut Effort, now_secs: &mut f64, secs: f64, frame_secs: f64) {
        play_with(GLOWING, effort, now_secs, secs, frame_secs);
    }

    /// The same of another finish.
    fn play_with(finish: Finish, effort: &mut Effort, now_secs: &mut f64, secs: f64, frame_secs: f64) {
        let end_secs = *now_secs + secs;
        while *now_secs < end_secs {
            *now_secs += frame_secs;
            effort.frame(*now_secs, finish);
        }
    }

    #[test]
    fn effort_falls_while_frames_are_late_and_comes_back() {
        let (mut effort, mut now_secs) = (card(), 0.0);
        play(&mut effort, &mut now_secs, 3.0, 0.016);
        assert_eq!((effort.quality(), effort.is_reduced()), (Quality::STILL, false));
        play(&mut effort, &mut now_secs, 1.5, 0.08);
        let without_glow = Quality { effects: Effects::Bare, ..Quality::STILL };
        assert_eq!(effort.quality(), without_glow);
        play(&mut effort, &mut now_secs, 1.0, 0.08);
        assert_eq!(effort.quality(), Quality { samples: Samples::One, ..without_glow });
        play(&mut effort, &mut now_secs, 9.0, 0.08);
        assert_eq!((effort.quality().percent, effort.is_reduced()), (50, true));
        // Neither late nor early: it stays.
        play(&mut effort, &mut now_secs, 60.0, 0.04);
        assert_eq!(effort.quality().percent, 50);
        // Two steps down in a row were no attempt that failed: each step up waits six seconds.
        play(&mut effort, &mut now_secs, 28.0, 0.016);
        assert_eq!(effort.quality(), Quality::STILL);
    }

    #[test]
    fn what_costs_most_goes_first_and_what_is_not_there_is_passed_over() {
        let falls = |finish: Finish| {
            let (mut effort, mut now_secs, mut seen) = (card(), 0.0, vec![Quality::STILL]);
            for _ in 0..200 {
                play_with(finish, &mut effort, &mut now_secs, 0.1, 0.08);
                if seen.last() != Some(&effort.quality()) {
                    seen.push(effort.quality());
                }
            }
            // And all of it comes back.
            play_with(finish, &mut effort, &mut now_secs, 60.0, 0.016);
            assert!(!effort.is_reduced());
            seen
        };
        let soft = Finish { blur: 0.6, ..Finish::NOTHING };
        assert_eq!(falls(Finish { blur: 0.6, ..GLOWING }), CARD);
        assert_eq!(falls(GLOWING), [CARD[0], CARD[2], CARD[3], CARD[4], CARD[5]]);
        assert_eq!(falls(soft), [CARD[0], CARD[1], CARD[3], CARD[4], CARD[5]]);
        assert_eq!(falls(Finish::NOTHING), [CARD[0], CARD[3], CARD[4], CARD[5]]);
        let left = |effects: Effects| effects.of(Finish { trail_secs: 0.2, blur: 0.6, ..GLOWING });
        assert_eq!((left(Effects::Sharp).blur, left(Effects::Sharp).bloom), (0.0, GLOWING.bloom));
        assert_eq!(left(Effects::Bare), Finish::NOTHING);
    }

    #[test]
    fn attempts_that_fail_become_rare() {
        let (mut effort, mut now_secs, mut attempts) = (card(), 0.0, 0);
        let end_secs = 120.0;
        let mut before = effort.quality();
        while now_secs < end_secs {
            now_secs += if effort.quality() == Quality::STILL { 0.08 } else { 0.016 };
            effort.frame(now_secs, GLOWING);
            attempts += u32::from(before != effort.quality() && effort.quality() == Quality::STILL);
            before = effort.quality();
        }
        assert!((2..=5).contains(&attempts), "{attempts}");
    }

    #[test]
    fn the_slowest_machine_draws_less_and_a_slow_screen_recovers() {
        for frame_secs in [0.25, 0.5, 1.5] {
            let (mut effort, mut now_secs) = (Effort::new(&Device::Processor), 0.0);
            play(&mut effort, &mut now_secs, 12.0 * frame_secs + 5.0, frame_secs);
            assert_eq!(effort.quality().percent, 50, "{frame_secs}");
        }
        for screen_hz in [30.0, 50.0] {
            let (mut effort, mut now_secs) = (card(), 0.0);
            play(&mut effort, &mut now_secs, 1.2, 0.08);
            assert!(effort.is_reduced());
            play(&mut effort, &mut now_secs, 10.0, 1.0 / screen_hz);
            assert!(!effort.is_reduced(), "{screen_hz}");
        }
    }

    #[test]
    fn the_processor_keeps_its_four_samples() {
        let (mut effort, mut now_secs, mut seen) = (Effort::new(&Device::Processor), 0.0, Vec::new());
        for _ in 0..40 {
            play(&mut effort, &mut now_secs, 0.5, 0.1);
            seen.push(effort.quality());
        }
        assert!(seen.iter().all(|quality| quality.samples == Samples::Four));
        assert_eq!(seen.last().map(|quality| quality.percent), Some(50));
    }

    #[test]
    fn pauses_are_not_late_frames() {
        let (mut effort, mut now_secs) = (Effort::new(&Device::Processor), 0.0);
        for _ in 0..40 {
            play(&mut effort, &mut now_secs, 0.03, 0.016);
            effort.rest();
            now_secs += 0.5;
        }
        // Hidden once: the window did not say that it rests.
        now_secs += 100.0;
        play(&mut effort, &mut now_secs, 5.0, 0.016);
        assert_eq!(effort.quality(), Quality::STILL);
        assert!(!effort.is_reduced());
    }
}
