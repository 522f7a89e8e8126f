//! Frames from the ring to the buffers of a device, without clicks: jumps and edges of silence are faded.

use std::sync::Arc;
use std::time::{Duration, Instant};

use cpal::{FromSample, SizedSample};
use rtrb::Consumer;

use super::clock::Clock;
use crate::Seam;
use crate::history::Frame;

/// The reading end of a ring. [`fill`](Self::fill) runs in the audio callback: it must not allocate, lock or log, since a late
/// callback is audible as a click.
pub(super) struct HandOut {
    consumer: Consumer<Frame>,
    clock: Arc<Clock>,
    rate_hz: u32,
    channels: usize,
    consumed: u64,
    /// The frame at which the current sound began; `None` during silence.
    run_begin: Option<u64>,
    gain: f32,
    /// Whether the last frame came from the ring.
    sounded: bool,
    seam: Seam,
}

impl HandOut {
    pub fn new(consumer: Consumer<Frame>, clock: Arc<Clock>, rate_hz: u32, channels: u16) -> Self {
        let channels = usize::from(channels).max(1);
        let seam = Seam::new(rate_hz);
        Self {
            consumer,
            clock,
            rate_hz,
            channels,
            consumed: 0,
            run_begin: None,
            gain: 0.0,
            sounded: false,
            seam,
        }
    }

    /// Fills a buffer that the device asks for at `now`, and whose first frame is heard at `heard`.
    pub fn fill<T: SizedSample + FromSample<f32>>(&mut self, data: &mut [T], now: Instant, heard: Instant) {
        let wanted = data.len() / self.channels;
        self.clock.tick(now, wanted);
        if wanted == 0 {
            return;
        }
        let first = drop_flushed(&mut self.consumer, &self.clock, self.consumed);
        if first > self.consumed {
            self.run_begin = None;
            self.seam.begin();
        }
        self.consumed = first;
        let (is_paused, ramp) = (self.clock.is_paused(), 1.0 / self.seam.frames() as f32);
        let target = if is_paused { 0.0 } else { self.clock.volume() };
        let mut played = 0;
        for frame in data.chunks_mut(self.channels) {
            self.gain += (target - self.gain).clamp(-ramp, ramp);
            let silent = target == 0.0 && self.gain == 0.0 && is_paused;
            let sample = if silent { None } else { self.consumer.pop().ok() };
            played += usize::from(sample.is_some());
            if sample.is_some() != self.sounded {
                self.sounded = sample.is_some();
                self.seam.begin();
            }
            let gained = sample.unwrap_or_default().map(|side| self.gain * side);
            write_frame(frame, self.seam.over(gained));
        }
        self.consumed += played as u64;
        if played < wanted && target > 0.0 && !self.clock.is_drained() {
            self.clock.count_underrun();
        }
        let length = Duration::from_secs_f64(wanted as f64 / f64::from(self.rate_hz.max(1)));
        let is_quiet = !self.sounded && self.seam.is_over();
        self.clock.set_quiet_from(is_quiet.then_some(heard + length));
        if played > 0 {
            self.clock.anchor(first, heard, self.consumed, *self.run_begin.get_or_insert(first));
            return;
        }
        self.run_begin = None;
        // Before the first sample, the clock may still belong to another output.
        if first > 0 && first != self.clock.consumed() {
            self.clock.anchor(first, now, first, first);
        }
    }
}

/// Writes one frame. A single channel gets the mean of both; channels beyond the second are silent.
fn write_frame<T: SizedSample + FromSample<f32>>(frame: &mut [T], [left, right]: Frame) {
    let (left, right) = (left.clamp(-1.0, 1.0), right.clamp(-1.0, 1.0));
    match frame {
        [mono] => *mono = T::from_sample(0.5 * (left + right)),
        [l, r, rest @ ..] => {
            *l = T::from_sample(left);
            *r = T::from_sample(right);
            rest.fill(T::from_sample(0.0));
        }
        [] => {}
    }
}

/// Drops the frames that a seek has made stale. Returns the number of frames consumed so far.
pub(super) fn drop_flushed(consumer: &mut Consumer<Frame>, clock: &Clock, consumed: u64) -> u64 {
    let stale = clock.flushed_before().saturating_sub(consumed);
    let stale = consumer.slots().min(usize::try_from(stale).unwrap_or(usize::MAX));
    if let Ok(chunk) = consumer.read_chunk(stale) {
        chunk.commit_all();
    }
    consumed + stale as u64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::SEAM_SECS;
    use rtrb::{Producer, RingBuffer};

    const RATE_HZ: u32 = 48_000;
    /// The loudest tone that is played, and how far one of its samples is from the next, at most.
    const LOUD: f32 = 0.9;
    const HZ: f32 = 440.0;

    fn largest_slope() -> f32 {
        LOUD * std::f32::consts::TAU * HZ / RATE_HZ as f32
    }

    /// A player's ring without an engine and a device.
    struct Desk {
        producer: Producer<Frame>,
        clock: Arc<Clock>,
        output: HandOut,
        began: Instant,
        /// Frames that were asked for, of which all that was handed out so far.
        asked: u64,
        heard: Vec<f32>,
        written: u64,
    }

    impl Desk {
        fn new() -> Self {
            let (producer, consumer) = RingBuffer::new(RATE_HZ as usize);
            let clock = Arc::new(Clock::new());
            clock.set_paused(false);
            clock.set_drained(false);
            let output = HandOut::new(consumer, Arc::clone(&clock), RATE_HZ, 2);
            Self { producer, clock, output, began: Instant::now(), asked: 0, heard: Vec::new(), written: 0 }
        }

        fn write(&mut self, frames: usize, frame: impl Fn(u64) -> f32) {
            for _ in 0..frames {
                let sample = frame(self.written);
                if self.producer.push([sample, -sample]).is_ok() {
                    self.written += 1;
                }
            }
        }

        /// The device asks for frames, `late_secs` after it should.
        fn ask(&mut self, frames: usize, late_secs: f64) {
            let mut buffer = vec![0.0f32; 2 * frames];
            let due = self.began + Duration::from_secs_f64(self.asked as f64 / f64::from(RATE_HZ));
            let now = due + Duration::from_secs_f64(late_secs);
            self.output.fill(&mut buffer, now, now + Duration::from_millis(20));
            assert!(buffer.chunks(2).all(|pair| pair[0] == -pair[1]));
            self.heard.extend(buffer.chunks(2).map(|pair| pair[0]));
            self.asked += frames as u64;
        }

        fn largest_step(&self) -> f32 {
            let before = std::iter::once(&0.0).chain(&self.heard);
            before.zip(&self.heard).map(|(one, next)| (next - one).abs()).fold(0.0, f32::max)
        }
    }

    fn tone(n: u64) -> f32 {
        LOUD * (std::f32::consts::TAU * HZ * n as f32 / RATE_HZ as f32).sin()
    }

    /// Where the sound itself moves by `slope`: with a fade over twice the loudest sample, and one of the gain.
    fn allowed(slope: f32) -> f32 {
        slope + 3.1 * LOUD / (SEAM_SECS * RATE_HZ as f32)
    }

    #[test]
    fn no_step_is_heard_where_samples_run_out_and_come_again() {
        // A tone, and levels that fall to silence farthest.
        for level in [None, Some(LOUD), Some(-LOUD)] {
            let sound = |n| level.unwrap_or_else(|| tone(n));
            let slope = level.map_or(largest_slope(), |_| 0.0);
            let mut desk = Desk::new();
            for pause in [0, 3, 100, 5000] {
                desk.write(4000, sound);
                desk.ask(4000, 0.0);
                desk.ask(pause, 0.0);
            }
            assert!(desk.heard.iter().any(|sample| sample.abs() > 0.8 * LOUD));
            let step = desk.largest_step();
            assert!(step <= allowed(slope), "{step} of {}", allowed(slope));
            assert!(desk.clock.underruns() > 0);
        }
    }

    #[test]
    fn no_step_is_heard_at_a_seek_a_pause_a_change_of_volume_and_the_end() {
        let mut desk = Desk::new();
        desk.write(20_000, |_| LOUD);
        desk.ask(3000, 0.0);
        // Another jump comes in the midst of a fade, and at its end.
        for frames in [150, 150, 370, 150, 370] {
            desk.clock.flush_before(desk.written);
            desk.write(1000, |_| -LOUD);
            desk.ask(frames, 0.0);
            desk.clock.flush_before(desk.written);
            desk.write(3000, |_| LOUD);
            desk.ask(1000, 0.0);
        }
        desk.clock.set_volume(0.1);
        desk.ask(500, 0.0);
        desk.clock.set_volume(1.0);
        desk.ask(500, 0.0);
        desk.clock.set_paused(true);
        desk.ask(1000, 0.0);
        assert_eq!(desk.heard.last(), Some(&0.0));
        desk.clock.set_paused(false);
        desk.ask(500, 0.0);
        desk.clock.set_drained(true);
        desk.ask(6000, 0.0);
        assert_eq!(desk.heard.last(), Some(&0.0));
        assert!(desk.heard.iter().any(|sample| *sample < -0.3) && desk.clock.underruns() == 0);
        let step = desk.largest_step();
        assert!(step <= allowed(0.0), "{step} of {}", allowed(0.0));
    }

    #[test]
    fn no_jump_is_louder_than_the_sound_around_it() {
        let mut desk = Desk::new();
        desk.write(2000, tone);
        for frames in [1000, 1013, 150, 1059, 1090, 1200] {
            desk.ask(frames, 0.0);
            desk.clock.flush_before(desk.written);
            desk.write(2000, tone);
        }
        desk.ask(1000, 0.0);
        let loudest = desk.heard.iter().fold(0.0_f32, |most, sample| most.max(sample.abs()));
        assert!(loudest <= LOUD + 1e-6, "{loudest}");
    }

    #[test]
    fn a_device_that_asks_for_any_number_at_any_time_gets_every_sample_once() {
        let mut chance = chladni_testdata::chance(5);
        let mut below = |most: u64| (chance() >> 33) % most;
        let mut desk = Desk::new();
        let mut position: f64 = 0.0;
        while desk.heard.len() < 200_000 {
            desk.write(4096, tone);
            // None, one, or more than a usual buffer, up to 30 ms late.
            let frames = match below(4) {
                0 => below(2),
                _ => below(3000),
            };
            desk.ask(frames as usize, 1e-3 * below(30) as f64);
            let now = desk.began + Duration::from_secs_f64(desk.asked as f64 / f64::from(RATE_HZ));
            let heard = desk.clock.heard_frame(now, RATE_HZ);
            assert!(heard <= desk.asked as f64, "{heard}: not before it was handed out");
            position = position.max(heard);
            // 30 ms late, and 20 ms on the way.
            assert!(position - heard < 0.06 * f64::from(RATE_HZ), "{heard} after {position}");
        }
        // The first ones fade in.
        for (n, sample) in desk.heard.iter().enumerate().skip(1000) {
            assert!((sample - tone(n as u64)).abs() < 1e-6, "{n}: {sample}");
        }
        assert_eq!(desk.clock.underruns(), 0);
    }

    #[test]
    fn it_says_from_when_nothing_is_heard() {
        let mut desk = Desk::new();
        desk.write(20_000, tone);
        desk.ask(4000, 0.0);
        let now = desk.began + Duration::from_secs(1);
        assert!(!desk.clock.is_quiet(now));
        desk.clock.set_paused(true);
        desk.ask(4000, 0.0);
        // It was handed out 8000 frames after the beginning, and is heard 20 ms later.
        let end = desk.began + Duration::from_secs_f64(8000.0 / f64::from(RATE_HZ) + 0.02);
        assert!(!desk.clock.is_quiet(end - Duration::from_millis(1)));
        assert!(desk.clock.is_quiet(end + Duration::from_millis(1)));
    }
}
