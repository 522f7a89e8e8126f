//! Capture: records a microphone, or the sound of the machine or of one of its programs.
//!
//! Windows (WASAPI) and macOS (14.6 and later) let an output device be recorded directly. Linux sound
//! servers offer the monitor of each sink as a source, but ALSA cannot name it; there the server's own
//! `parec` is run (PulseAudio, or PipeWire with its PulseAudio service), which also records single programs.

mod server;
mod source;

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use rtrb::chunks::ReadChunk;
use rtrb::{Consumer, Producer, RingBuffer};

pub use source::{CaptureKind, CaptureSource, capture_sources};

use crate::SoundError;
use crate::history::{Frame, History};
use crate::windowed::sounding;

/// The ring holds this many frames: 1.4 s at 48 kHz.
const RING_FRAMES: usize = 1 << 16;
/// The meter's peak falls by 20 dB in this time.
const METER_FALL_SECS: f32 = 1.0;

/// The loudness of the captured sound.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CaptureLevel {
    /// Largest amplitude; it falls by 20 dB per second.
    pub peak: f32,
    /// Root mean square of the last block.
    pub rms: f32,
}

/// A running capture. Dropping it ends the capture.
pub struct Capture {
    rate_hz: u32,
    consumer: Consumer<Frame>,
    history: History,
    level: CaptureLevel,
    /// Set by whatever delivers the samples when it ends.
    lost: Arc<AtomicBool>,
    _feed: Feed,
}

/// The running source. It is kept only to be dropped, which stops it.
enum Feed {
    Device { _stream: cpal::Stream },
    Server { _recorder: server::Recorder },
    Own,
}

/// The writing end of a capture into which the program itself writes. Dropping it has the effect of losing
/// the device.
pub struct CaptureFeed {
    inlet: Inlet,
}

impl CaptureFeed {
    /// Adds as many frames as the shorter of the two slices has. Frames that do not fit are dropped; samples that are not
    /// finite or absurdly loud are silence.
    pub fn push(&mut self, left: &[f32], right: &[f32]) {
        left.iter().zip(right).for_each(|(&l, &r)| self.inlet.push([l, r]));
    }
}

impl Drop for CaptureFeed {
    fn drop(&mut self) {
        self.inlet.lost.store(true, Ordering::Release);
    }
}

/// The writing end, owned by a device callback: it must neither allocate nor lock.
struct Inlet {
    producer: Producer<Frame>,
    lost: Arc<AtomicBool>,
}

fn inlet() -> (Inlet, Consumer<Frame>) {
    let (producer, consumer) = RingBuffer::new(RING_FRAMES);
    (Inlet { producer, lost: Arc::default() }, consumer)
}

impl Inlet {
    fn push(&mut self, frame: Frame) {
        // If the ring is full, nobody reads it: the newest frame is dropped, and the device does not wait.
        let _ = self.producer.push(frame.map(sounding));
    }
}

impl Capture {
    /// Opens a source and begins to capture.
    ///
    /// # Errors
    /// The source no longer exists, is busy or forbidden, or has no format that can be read.
    pub fn start(source: &CaptureSource) -> Result<Self, SoundError> {
        let (inlet, consumer) = inlet();
        let lost = Arc::clone(&inlet.lost);
        let (rate_hz, feed) = match &source.played {
            Some(played) => {
                let recorder = server::Recorder::start(&source.name, played, inlet)?;
                (server::RATE_HZ, Feed::Server { _recorder: recorder })
            }
            None => {
                let (rate_hz, stream) = source::open(source, inlet)?;
                (rate_hz, Feed::Device { _stream: stream })
            }
        };
        Ok(Self::new(rate_hz, consumer, lost, feed))
    }

    /// A capture of samples at `rate_hz` that the program itself writes.
    ///
    /// # Errors
    /// A rate outside [[`MIN_RATE_HZ`](crate::MIN_RATE_HZ), [`MAX_RATE_HZ`](crate::MAX_RATE_HZ)].
    ///
    /// ```
    /// let (mut capture, mut feed) = chladni_sound::Capture::fed(48_000)?;
    /// feed.push(&[0.5, 0.25], &[0.0, 0.0]);
    /// let (mut left, mut right) = (Vec::new(), Vec::new());
    /// assert_eq!(capture.take(&mut left, &mut right), 2);
    /// assert_eq!((left[1], capture.level().peak), (0.25, 0.5));
    /// drop(feed);
    /// assert!(capture.is_lost());
    /// # Ok::<(), chladni_sound::SoundError>(())
    /// ```
    pub fn fed(rate_hz: u32) -> Result<(Self, CaptureFeed), SoundError> {
        crate::check_rate("a feed", rate_hz)?;
        let (inlet, consumer) = inlet();
        let lost = Arc::clone(&inlet.lost);
        Ok((Self::new(rate_hz, consumer, lost, Feed::Own), CaptureFeed { inlet }))
    }

    fn new(rate_hz: u32, consumer: Consumer<Frame>, lost: Arc<AtomicBool>, feed: Feed) -> Self {
        let level = CaptureLevel::default();
        Self { rate_hz, consumer, history: History::new(rate_hz), level, lost, _feed: feed }
    }

    /// Frames per second.
    pub fn rate_hz(&self) -> u32 {
        self.rate_hz
    }

    /// Takes the frames that have arrived since the last call and appends them to `left` and `right`.
    /// Returns their number: 0 where 65,536 frames or more have waited, which are too old to be heard as the sound of now.
    pub fn take(&mut self, left: &mut Vec<f32>, right: &mut Vec<f32>) -> usize {
        let count = self.consumer.slots();
        if count == RING_FRAMES {
            // Nobody took it for long: what came last was dropped, and this is not the sound of now.
            self.consumer.read_chunk(count).into_iter().for_each(ReadChunk::commit_all);
            return 0;
        }
        let (mut peak, mut square) = (0.0f32, 0.0f32);
        for _ in 0..count {
            let Ok([l, r]) = self.consumer.pop() else { break };
            peak = peak.max(l.abs()).max(r.abs());
            square += 0.5 * (l * l + r * r);
            self.history.push([l, r]);
            left.push(l);
            right.push(r);
        }
        if count > 0 {
            let fallen = 0.1f32.powf(count as f32 / self.rate_hz as f32 / METER_FALL_SECS);
            self.level.peak = peak.max(self.level.peak * fallen);
            self.level.rms = (square / count as f32).sqrt();
        }
        count
    }

    /// Copies the newest frames that [`take`](Self::take) has taken.
    pub fn window(&self, left: &mut [f32], right: &mut [f32]) {
        self.history.window(self.history.written() as i64, left, right);
    }

    /// The current loudness.
    pub fn level(&self) -> CaptureLevel {
        self.level
    }

    /// Whether the device is lost. To continue, start a new capture.
    pub fn is_lost(&self) -> bool {
        self.lost.load(Ordering::Acquire)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sound_that_nobody_took_for_long_is_not_that_of_now() {
        let (mut capture, mut feed) = Capture::fed(48_000).unwrap();
        let (mut left, mut right) = (Vec::new(), Vec::new());
        let old = vec![0.5; RING_FRAMES + 100];
        feed.push(&old, &old);
        assert_eq!(capture.take(&mut left, &mut right), 0);
        feed.push(&[0.25], &[0.25]);
        assert_eq!((capture.take(&mut left, &mut right), &left[..]), (1, &[0.25][..]));
    }

    #[test]
    fn a_device_that_delivers_what_is_not_a_number_is_silent_for_that_long() {
        let (mut capture, mut feed) = Capture::fed(48_000).unwrap();
        feed.push(&[0.5, f32::NAN, f32::INFINITY, 0.25], &[-0.5, 0.125, 3e30, f32::NEG_INFINITY]);
        let (mut left, mut right) = (Vec::new(), Vec::new());
        capture.take(&mut left, &mut right);
        assert_eq!((left, right), (vec![0.5, 0.0, 0.0, 0.25], vec![-0.5, 0.125, 0.0, 0.0]));
        assert!(capture.level().peak == 0.5 && capture.level().rms.is_finite());
    }
}
