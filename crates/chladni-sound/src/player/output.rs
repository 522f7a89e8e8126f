//! Where samples are played: a sound device, or silence in real time.

use std::sync::Arc;
use std::time::{Duration, Instant};

use cpal::traits::{DeviceTrait, HostTrait, StreamTrait};
use cpal::{BufferSize, ErrorKind, FromSample, SampleFormat, SizedSample, StreamConfig, SupportedBufferSize};
use rtrb::{Consumer, Producer, RingBuffer};

use super::clock::Clock;
use super::hand_out::{HandOut, drop_flushed};
use crate::SoundError;
use crate::converters::is_converter;
use crate::history::Frame;
use crate::names::tell_apart;

/// The rate used without a device.
const SILENT_RATE_HZ: u32 = 48_000;
/// Frames per device buffer: about 43 ms, of which about two are queued. A busy machine needs this latency,
/// and the playback position accounts for it.
const BUFFER_FRAMES: u32 = 2048;
/// Capacity of the ring.
const RING_SECS: f64 = 1.0;

/// A device that can play sound.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OutputDevice {
    /// The id that [`PlayerSettings::device`](super::PlayerSettings) takes.
    pub id: String,
    /// The name that is displayed, with the id where others have the same name.
    pub name: String,
}

/// The devices that can play, with the system's default first.
/// ALSA's plugins that convert or discard samples are left out.
///
/// # Errors
/// The sound system does not answer.
pub fn output_devices() -> Result<Vec<OutputDevice>, SoundError> {
    let host = cpal::default_host();
    let default = host.default_output_device().and_then(|device| device.id().ok());
    let mut devices: Vec<OutputDevice> = host
        .output_devices()
        .map_err(|error| SoundError::Device { what: error.to_string() })?
        .filter(|device| !is_converter(device))
        .filter_map(|device| {
            Some(OutputDevice { id: device.id().ok()?.to_string(), name: device.to_string() })
        })
        .collect();
    let default = default.map(|id| id.to_string());
    devices.sort_by_key(|device| Some(&device.id) != default.as_ref());
    tell_apart(devices.iter_mut().map(|device| (&mut device.name, Some(device.id.as_str()))));
    Ok(devices)
}

/// The writing end of a ring, and what consumes it.
pub(super) struct Output {
    pub rate_hz: u32,
    pub producer: Producer<Frame>,
    /// The device's name; `None` for silence.
    pub device: Option<String>,
    opened: Instant,
    sink: Sink,
}

enum Sink {
    /// The device's stream. It is kept only to be dropped, which stops it.
    Device {
        _stream: cpal::Stream,
    },
    Silence {
        consumer: Consumer<Frame>,
        last: Instant,
        owed: f64,
    },
}

impl Output {
    /// Opens the device with an id, or the system's default. The clock does not change until the device
    /// gets samples.
    pub fn device(id: Option<&str>, clock: &Arc<Clock>) -> Result<Self, SoundError> {
        let failed = |what: String| SoundError::Device { what };
        let host = cpal::default_host();
        let device = match id {
            Some(id) => {
                let known = id.parse().map_err(|_| failed(format!("{id} is no device's name")))?;
                host.device_by_id(&known).ok_or_else(|| failed(format!("{id} is not there")))?
            }
            None => host.default_output_device().ok_or_else(|| failed("there is none".into()))?,
        };
        let supported = device.default_output_config().map_err(|error| failed(error.to_string()))?;
        let buffer_size = match supported.buffer_size() {
            SupportedBufferSize::Range { min, max } => {
                BufferSize::Fixed(BUFFER_FRAMES.clamp(*min, (*max).max(*min)))
            }
            SupportedBufferSize::Unknown => BufferSize::Default,
        };
        let config = StreamConfig { buffer_size, ..supported.config() };
        let format = supported.sample_format();
        let name = device.to_string();
        let attempt = |config| Self::open(&device, config, format, clock, name.clone());
        attempt(config)
            .or_else(|_| attempt(StreamConfig { buffer_size: BufferSize::Default, ..config }))
            .map_err(|error| failed(format!("{name}: {error}")))
    }

    fn open(
        device: &cpal::Device,
        config: StreamConfig,
        format: SampleFormat,
        clock: &Arc<Clock>,
        name: String,
    ) -> Result<Self, cpal::Error> {
        let (producer, consumer) = ring(config.sample_rate);
        let counter = Arc::clone(clock);
        let stream = match format {
            SampleFormat::F32 => stream::<f32>(device, config, consumer, counter),
            SampleFormat::I16 => stream::<i16>(device, config, consumer, counter),
            SampleFormat::I32 => stream::<i32>(device, config, consumer, counter),
            SampleFormat::U8 => stream::<u8>(device, config, consumer, counter),
            SampleFormat::U16 => stream::<u16>(device, config, consumer, counter),
            SampleFormat::F64 => stream::<f64>(device, config, consumer, counter),
            _ => Err(ErrorKind::UnsupportedConfig.into()),
        }?;
        stream.play()?;
        Ok(Self {
            rate_hz: config.sample_rate,
            producer,
            device: Some(name),
            opened: Instant::now(),
            sink: Sink::Device { _stream: stream },
        })
    }

    /// An output that plays silence in real time.
    pub fn silence() -> Self {
        Self::silence_at(SILENT_RATE_HZ)
    }

    /// The same at another rate.
    pub(super) fn silence_at(rate_hz: u32) -> Self {
        let (producer, consumer) = ring(rate_hz);
        let now = Instant::now();
        let sink = Sink::Silence { consumer, last: now, owed: 0.0 };
        Self { rate_hz, producer, device: None, opened: now, sink }
    }

    /// Consumes the frames that would have been played by `now`, if this output is silent. A device does
    /// that itself.
    pub fn advance(&mut self, clock: &Clock, now: Instant) {
        let Sink::Silence { consumer, last, owed } = &mut self.sink else { return };
        *owed += (now - *last).as_secs_f64() * f64::from(self.rate_hz);
        *last = now;
        clock.tick(now, 0);
        let consumed = drop_flushed(consumer, clock, clock.consumed());
        if clock.is_paused() {
            *owed = 0.0;
        }
        let take = consumer.slots().min(*owed as usize);
        if let Ok(chunk) = consumer.read_chunk(take) {
            chunk.commit_all();
        }
        // Missing frames are not made up for: the song pauses and does not jump.
        *owed = if consumer.is_empty() { owed.fract() } else { *owed - take as f64 };
        let consumed = consumed + take as u64;
        clock.anchor(consumed, now, consumed, consumed);
    }

    /// Why the device can no longer be used, if that is so: it reported an error, it has stopped asking for
    /// samples, or it takes them faster than time passes (ALSA's null device).
    pub fn trouble(&self, clock: &Clock, now: Instant) -> Option<String> {
        let name = self.device.as_ref()?;
        if clock.take_lost() {
            return Some(format!("{name} is gone"));
        }
        let open_for = now - self.opened;
        if open_for > Duration::from_secs(2) && clock.silent_for(now) > Duration::from_millis(1500) {
            return Some(format!("{name} has stopped"));
        }
        let asked_secs = clock.asked() as f64 / f64::from(self.rate_hz);
        if asked_secs > 1.5 * open_for.as_secs_f64() + 2.0 {
            return Some(format!("{name} does not keep time"));
        }
        None
    }
}

#[cfg(test)]
impl Output {
    /// An output that passes for a device, what it is handed out, and the end of a ring that is abandoned once it is closed.
    pub fn by_hand(rate_hz: u32, clock: &Arc<Clock>) -> (Self, HandOut, Producer<Frame>) {
        let (producer, consumer) = ring(rate_hz);
        let mut output = Self { device: Some("test".into()), ..Self::silence_at(rate_hz) };
        let open = std::mem::replace(&mut output.producer, producer);
        (output, HandOut::new(consumer, Arc::clone(clock), rate_hz, 2), open)
    }
}

fn ring(rate_hz: u32) -> (Producer<Frame>, Consumer<Frame>) {
    RingBuffer::new((f64::from(rate_hz) * RING_SECS) as usize)
}

fn stream<T: SizedSample + FromSample<f32>>(
    device: &cpal::Device,
    config: StreamConfig,
    consumer: Consumer<Frame>,
    clock: Arc<Clock>,
) -> Result<cpal::Stream, cpal::Error> {
    let counter = Arc::clone(&clock);
    let mut output = HandOut::new(consumer, clock, config.sample_rate, config.channels);
    let play = move |data: &mut [T], info: &cpal::OutputCallbackInfo| {
        let (now, stamp) = (Instant::now(), info.timestamp());
        output.fill(data, now, now + stamp.playback.duration_since(stamp.callback));
    };
    let on_error = move |error: cpal::Error| heed(error.kind(), &counter);
    device.build_output_stream(config, play, on_error, Some(Duration::from_secs(2)))
}

/// Takes note of an error of the device's stream.
fn heed(error: ErrorKind, clock: &Clock) {
    match error {
        ErrorKind::Xrun => clock.count_underrun(),
        // ALSA's way to PulseAudio reports one of these after each underrun and goes on: a device that does not has
        // soon stopped.
        ErrorKind::BackendError | ErrorKind::DeviceChanged | ErrorKind::RealtimeDenied => {}
        _ => clock.set_lost(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An output that passes for a device.
    fn device() -> (Output, Clock) {
        let clock = Clock::new();
        clock.restart();
        (Output { device: Some("test".into()), ..Output::silence() }, clock)
    }

    #[test]
    fn time_in_silence_is_that_of_the_clock_and_what_is_missing_is_not_made_up_for() {
        let (mut output, clock) = (Output::silence(), Clock::new());
        let began = output.opened;
        let at = |output: &mut Output, millis: u64| {
            output.advance(&clock, began + Duration::from_millis(millis));
            clock.consumed()
        };
        // Less than a frame may be owed.
        let close = |found: u64, wanted: u64| assert!(found.abs_diff(wanted) <= 1, "{found}, not {wanted}");
        for _ in 0..SILENT_RATE_HZ {
            output.producer.push([0.5; 2]).unwrap();
        }
        assert_eq!(at(&mut output, 300), 0, "nothing plays");
        clock.set_paused(false);
        for millis in [301, 307, 400, 401, 890] {
            close(at(&mut output, millis), 48 * (millis - 300));
        }
        clock.set_paused(true);
        close(at(&mut output, 891), 48 * 590);
        close(at(&mut output, 5000), 48 * 590);
        // A quarter of a second is missing in the end: 410 ms are there, 660 pass.
        clock.set_paused(false);
        assert_eq!(at(&mut output, 5660), 48_000);
        for _ in 0..480 {
            output.producer.push([0.5; 2]).unwrap();
        }
        close(at(&mut output, 5661), 48_048);
    }

    #[test]
    fn a_device_that_asks_for_nothing_has_stopped() {
        let (output, clock) = device();
        let after = |secs: f64| output.opened + Duration::from_secs_f64(secs);
        // It has time to begin, and may stumble.
        assert_eq!(output.trouble(&clock, after(1.9)), None);
        clock.tick(after(2.0), 2048);
        assert_eq!(output.trouble(&clock, after(3.4)), None);
        assert_eq!(output.trouble(&clock, after(3.6)).as_deref(), Some("test has stopped"));
        // Called again and again without a frame to fill, it is there.
        clock.tick(after(3.6), 0);
        assert_eq!(output.trouble(&clock, after(3.7)), None);
    }

    #[test]
    fn an_error_from_which_a_device_recovers_does_not_close_it() {
        let (output, clock) = device();
        let now = output.opened + Duration::from_secs(3);
        clock.tick(now, 2048);
        for error in [ErrorKind::Xrun, ErrorKind::BackendError, ErrorKind::DeviceChanged] {
            heed(error, &clock);
            assert_eq!(output.trouble(&clock, now), None, "{error:?}");
        }
        assert_eq!(clock.underruns(), 1, "a stumble counts once");
        let later = now + Duration::from_millis(1600);
        assert_eq!(output.trouble(&clock, later).as_deref(), Some("test has stopped"));
        // So is one whose stream ends because its rate has changed: it is opened anew, at that rate.
        for error in [ErrorKind::DeviceNotAvailable, ErrorKind::StreamInvalidated] {
            heed(error, &clock);
            assert_eq!(output.trouble(&clock, now).as_deref(), Some("test is gone"), "{error:?}");
        }
    }

    #[test]
    fn a_device_that_swallows_samples_keeps_no_time() {
        let (output, clock) = device();
        let now = output.opened + Duration::from_secs(1);
        clock.tick(now, 3 * SILENT_RATE_HZ as usize);
        assert_eq!(output.trouble(&clock, now), None, "a large buffer is filled at once");
        clock.tick(now, SILENT_RATE_HZ as usize);
        assert_eq!(output.trouble(&clock, now).as_deref(), Some("test does not keep time"));
        clock.set_lost();
        assert_eq!(output.trouble(&clock, now).as_deref(), Some("test is gone"));
    }
}
