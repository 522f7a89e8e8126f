//! The state that the audio callback shares with the rest of the program, without a lock.

use std::sync::atomic::{AtomicBool, AtomicU32, AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// Written by the callback (the only writer of the anchor) and read by everyone who needs the time.
pub(super) struct Clock {
    origin: Instant,
    /// A sequence lock: odd while the anchor is being written.
    sequence: AtomicU32,
    /// The ring frame of the anchor.
    anchor_frame: AtomicU64,
    /// When that frame is heard, in nanoseconds after `origin`.
    anchor_nanos: AtomicU64,
    consumed: AtomicU64,
    /// The ring frame at which the sound since the last pause began: no earlier frame is still to be heard.
    run_begin: AtomicU64,
    /// Frames before this one are dropped without being heard.
    flush_before: AtomicU64,
    underruns: AtomicU64,
    /// How many frames the device has requested, heard or not.
    asked: AtomicU64,
    last_callback_nanos: AtomicU64,
    paused: AtomicBool,
    /// Set once the engine has written everything: silence is then not an underrun.
    drained: AtomicBool,
    lost: AtomicBool,
    volume: AtomicU32,
    /// How far what is shown lies ahead of what is heard, in seconds.
    shown_ahead: AtomicU64,
    /// When the last sound that was handed out has been heard, as nanoseconds after `origin`; the end of time while there is sound.
    quiet_nanos: AtomicU64,
}

impl Clock {
    pub fn new() -> Self {
        Self {
            origin: Instant::now(),
            sequence: AtomicU32::new(0),
            anchor_frame: AtomicU64::new(0),
            anchor_nanos: AtomicU64::new(0),
            consumed: AtomicU64::new(0),
            run_begin: AtomicU64::new(0),
            flush_before: AtomicU64::new(0),
            underruns: AtomicU64::new(0),
            asked: AtomicU64::new(0),
            last_callback_nanos: AtomicU64::new(0),
            paused: AtomicBool::new(true),
            drained: AtomicBool::new(true),
            lost: AtomicBool::new(false),
            volume: AtomicU32::new(1.0f32.to_bits()),
            shown_ahead: AtomicU64::new(0f64.to_bits()),
            quiet_nanos: AtomicU64::new(0),
        }
    }

    fn nanos(&self, at: Instant) -> u64 {
        u64::try_from(at.saturating_duration_since(self.origin).as_nanos()).unwrap_or(u64::MAX)
    }

    /// Called by the callback: it runs at `now` and must supply this many frames.
    pub fn tick(&self, now: Instant, frames: usize) {
        self.asked.fetch_add(frames as u64, Ordering::Relaxed);
        self.last_callback_nanos.store(self.nanos(now), Ordering::Relaxed);
    }

    /// Called by the callback: ring frame `frame` will be heard at `heard`; the frames up to `consumed`
    /// have been taken; and there was no pause since `run_begin`.
    pub fn anchor(&self, frame: u64, heard: Instant, consumed: u64, run_begin: u64) {
        self.sequence.fetch_add(1, Ordering::AcqRel);
        self.anchor_frame.store(frame, Ordering::Relaxed);
        self.anchor_nanos.store(self.nanos(heard), Ordering::Relaxed);
        self.consumed.store(consumed, Ordering::Relaxed);
        self.run_begin.store(run_begin, Ordering::Relaxed);
        self.sequence.fetch_add(1, Ordering::Release);
    }

    /// The ring frame that is heard at `now`, as a fraction.
    pub fn heard_frame(&self, now: Instant, rate_hz: u32) -> f64 {
        let (frame, nanos, consumed, run_begin) = loop {
            let before = self.sequence.load(Ordering::Acquire);
            let values = (
                self.anchor_frame.load(Ordering::Acquire),
                self.anchor_nanos.load(Ordering::Acquire),
                self.consumed.load(Ordering::Acquire),
                self.run_begin.load(Ordering::Acquire),
            );
            if before.is_multiple_of(2) && before == self.sequence.load(Ordering::Acquire) {
                break values;
            }
            std::hint::spin_loop();
        };
        let since_secs = (self.nanos(now) as f64 - nanos as f64) * 1e-9;
        let heard = frame as f64 + since_secs * f64::from(rate_hz);
        let flushed = self.flush_before.load(Ordering::Acquire);
        // Frames flushed by a seek are skipped, frames heard before a pause are not heard again, and frames
        // that have not been taken cannot be heard.
        heard.min(consumed as f64).max(if frame >= flushed { run_begin as f64 } else { flushed as f64 })
    }

    /// The ring frame that is to be shown at `now`: the one that is heard, and what it is ahead or behind. Nothing is
    /// shown of what came before the last jump, which is not heard either.
    pub fn shown_frame(&self, now: Instant, rate_hz: u32) -> f64 {
        let heard = self.heard_frame(now, rate_hz);
        let shown = heard + self.shown_ahead_secs() * f64::from(rate_hz);
        shown.max(heard.min(self.flushed_before() as f64))
    }

    pub fn show_ahead(&self, secs: f64) {
        self.shown_ahead.store(secs.to_bits(), Ordering::Relaxed);
    }

    pub fn shown_ahead_secs(&self) -> f64 {
        f64::from_bits(self.shown_ahead.load(Ordering::Relaxed))
    }

    pub fn consumed(&self) -> u64 {
        self.consumed.load(Ordering::Acquire)
    }

    /// Called by the engine: drop all samples written before `frame`.
    pub fn flush_before(&self, frame: u64) {
        self.flush_before.store(frame, Ordering::Release);
    }

    pub fn flushed_before(&self) -> u64 {
        self.flush_before.load(Ordering::Acquire)
    }

    pub fn count_underrun(&self) {
        self.underruns.fetch_add(1, Ordering::Relaxed);
    }

    pub fn underruns(&self) -> u64 {
        self.underruns.load(Ordering::Relaxed)
    }

    pub fn asked(&self) -> u64 {
        self.asked.load(Ordering::Relaxed)
    }

    /// How long ago the callback last ran.
    pub fn silent_for(&self, now: Instant) -> Duration {
        Duration::from_nanos(self.nanos(now).saturating_sub(self.last_callback_nanos.load(Ordering::Relaxed)))
    }

    pub fn set_paused(&self, paused: bool) {
        self.paused.store(paused, Ordering::Release);
    }

    pub fn is_paused(&self) -> bool {
        self.paused.load(Ordering::Acquire)
    }

    pub fn set_drained(&self, drained: bool) {
        self.drained.store(drained, Ordering::Release);
    }

    pub fn is_drained(&self) -> bool {
        self.drained.load(Ordering::Acquire)
    }

    pub fn set_lost(&self) {
        self.lost.store(true, Ordering::Release);
    }

    pub fn take_lost(&self) -> bool {
        self.lost.swap(false, Ordering::AcqRel)
    }

    /// Limited to [0, 1]; what is not finite is silence, since a gain that is not a number would stay one.
    pub fn set_volume(&self, volume: f32) {
        let volume = if volume.is_finite() { volume.clamp(0.0, 1.0) } else { 0.0 };
        self.volume.store(volume.to_bits(), Ordering::Relaxed);
    }

    pub fn volume(&self) -> f32 {
        f32::from_bits(self.volume.load(Ordering::Relaxed))
    }

    /// Called by the callback: from then on nothing is heard, or something is.
    pub fn set_quiet_from(&self, from: Option<Instant>) {
        let nanos = from.map_or(u64::MAX, |from| self.nanos(from));
        // The first buffer of silence counts, not each that follows.
        if nanos == u64::MAX || self.quiet_nanos.load(Ordering::Relaxed) == u64::MAX {
            self.quiet_nanos.store(nanos, Ordering::Relaxed);
        }
    }

    /// Whether nothing is heard at `now`, as all that was handed out has been.
    pub fn is_quiet(&self, now: Instant) -> bool {
        self.quiet_nanos.load(Ordering::Relaxed) <= self.nanos(now)
    }

    /// Begins a new ring at frame 0.
    pub fn restart(&self) {
        self.quiet_nanos.store(0, Ordering::Relaxed);
        let now = Instant::now();
        self.flush_before.store(0, Ordering::Release);
        self.lost.store(false, Ordering::Release);
        self.asked.store(0, Ordering::Relaxed);
        self.tick(now, 0);
        self.anchor(0, now, 0, 0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_shown_lies_ahead_of_what_is_heard_or_behind_it() {
        let clock = Clock::new();
        let now = Instant::now();
        clock.anchor(48_000, now, 48_000, 0);
        let shown = |secs: f64| {
            clock.show_ahead(secs);
            (clock.shown_frame(now, 48_000) - clock.heard_frame(now, 48_000)).round()
        };
        assert_eq!([0.0, 0.1, -0.25].map(shown), [0.0, 4_800.0, -12_000.0]);
        assert_eq!(shown(-2.0), -48_000.0, "nothing lies before the first frame");
        clock.flush_before(45_000);
        assert_eq!((shown(-0.25), shown(0.1)), (-3_000.0, 4_800.0), "nor before a jump");
    }
}
