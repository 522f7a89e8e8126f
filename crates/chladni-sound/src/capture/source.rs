//! The sources that can be captured, and how they are opened.

use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Duration;

use cpal::traits::{DeviceTrait, HostTrait, StreamTrait};
use cpal::{ErrorKind, FromSample, SampleFormat, SizedSample, StreamConfig};

use super::Inlet;
use super::server::{self, Played};
use crate::SoundError;
use crate::converters::is_converter;
use crate::names::{tell_apart, with_id};

/// The kind of sound that a source captures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CaptureKind {
    /// The room: a microphone or a line input.
    Input,
    /// The sound that this machine plays.
    Loopback,
    /// The sound that one program plays.
    Program,
}

/// A source that can be captured.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CaptureSource {
    /// Its name for display, with its id where others have the same name.
    pub name: String,
    /// Whether it captures the room, this machine or a program.
    pub kind: CaptureKind,
    /// The id of the device within the audio host.
    pub(super) device: Option<String>,
    /// The output of a sound server that is captured, if it is one.
    pub(super) played: Option<Played>,
}

impl CaptureSource {
    /// Whether it can be captured now; asks the sound system, which takes a moment.
    pub fn is_there(&self) -> bool {
        capture_sources().is_ok_and(|sources| sources.iter().any(|source| self.is_same(source)))
    }

    /// Whether both are one source; their names depend on the others.
    pub fn is_same(&self, other: &Self) -> bool {
        (self.kind, &self.device, &self.played) == (other.kind, &other.device, &other.played)
    }

    /// Whether it has this name, or had it while there were more or fewer others of the same name.
    pub fn is_called(&self, name: &str) -> bool {
        let differs_by_id = |id: &str| with_id(name, id) == self.name || with_id(&self.name, id) == name;
        self.name == name || self.device.as_deref().is_some_and(differs_by_id)
    }
}

/// The sources that can be captured now: the default input first, then loopbacks, programs that play something (on
/// Linux, where a sound server tells them apart), then other inputs.
///
/// # Errors
/// The sound system does not answer.
pub fn capture_sources() -> Result<Vec<CaptureSource>, SoundError> {
    let host = cpal::default_host();
    let failed = |error: cpal::Error| SoundError::Device { what: error.to_string() };
    let source = |device: cpal::Device, kind: CaptureKind| {
        let id = device.id().ok()?.to_string();
        Some(CaptureSource { name: device.to_string(), kind, device: Some(id), played: None })
    };
    let default = host.default_input_device().and_then(|device| source(device, CaptureKind::Input));
    let mut sources: Vec<CaptureSource> = default.clone().into_iter().collect();
    if cfg!(any(target_os = "windows", target_os = "macos")) {
        let outputs = host.output_devices().map_err(failed)?;
        sources.extend(outputs.filter_map(|device| source(device, CaptureKind::Loopback)));
    } else {
        let of = |name: String, kind, played: fn(String) -> Played| CaptureSource {
            played: Some(played(name.clone())),
            name,
            kind,
            device: None,
        };
        let monitors =
            server::monitors().into_iter().map(|name| of(name, CaptureKind::Loopback, Played::Monitor));
        sources.extend(monitors);
        sources.extend(
            server::programs().into_iter().map(|name| of(name, CaptureKind::Program, Played::Program)),
        );
    }
    let inputs = host.input_devices().map_err(failed)?;
    let inputs = inputs.filter(|device| !is_converter(device));
    let inputs = inputs.filter_map(|device| source(device, CaptureKind::Input));
    sources.extend(inputs.filter(|input| Some(input) != default.as_ref()));
    tell_apart(sources.iter_mut().map(|source| (&mut source.name, source.device.as_deref())));
    Ok(sources)
}

/// Opens a device. A loopback is an output device that is opened as an input.
pub(super) fn open(source: &CaptureSource, inlet: Inlet) -> Result<(u32, cpal::Stream), SoundError> {
    let failed = |what: String| SoundError::Device { what: format!("{}: {what}", source.name) };
    let host = cpal::default_host();
    let id = source.device.as_deref().and_then(|id| id.parse().ok());
    let device = id.and_then(|id| host.device_by_id(&id)).ok_or_else(|| failed("is not there".into()))?;
    let supported = match source.kind {
        CaptureKind::Input => device.default_input_config(),
        CaptureKind::Loopback | CaptureKind::Program => device.default_output_config(),
    }
    .map_err(|error| failed(error.to_string()))?;
    let config = supported.config();
    let stream = match supported.sample_format() {
        SampleFormat::F32 => stream::<f32>(&device, config, inlet),
        SampleFormat::I16 => stream::<i16>(&device, config, inlet),
        SampleFormat::I32 => stream::<i32>(&device, config, inlet),
        SampleFormat::U8 => stream::<u8>(&device, config, inlet),
        SampleFormat::U16 => stream::<u16>(&device, config, inlet),
        SampleFormat::F64 => stream::<f64>(&device, config, inlet),
        _ => Err(ErrorKind::UnsupportedConfig.into()),
    }
    .map_err(|error| failed(error.to_string()))?;
    stream.play().map_err(|error| failed(error.to_string()))?;
    Ok((config.sample_rate, stream))
}

fn stream<T: SizedSample>(
    device: &cpal::Device,
    config: StreamConfig,
    mut inlet: Inlet,
) -> Result<cpal::Stream, cpal::Error>
where
    f32: FromSample<T>,
{
    let channels = usize::from(config.channels).max(1);
    let lost = Arc::clone(&inlet.lost);
    let take = move |data: &[T], _: &cpal::InputCallbackInfo| {
        for frame in data.chunks_exact(channels) {
            let left = cpal::Sample::to_sample::<f32>(frame[0]);
            // A single channel is used for both sides.
            let right = frame.get(1).map_or(left, |&right| cpal::Sample::to_sample::<f32>(right));
            inlet.push([left, right]);
        }
    };
    let on_error = move |error: cpal::Error| {
        let harmless = [ErrorKind::Xrun, ErrorKind::DeviceChanged, ErrorKind::RealtimeDenied];
        if !harmless.contains(&error.kind()) {
            lost.store(true, Ordering::Release);
        }
    };
    device.build_input_stream(config, take, on_error, Some(Duration::from_secs(2)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn source(name: &str) -> CaptureSource {
        let device = Some("alsa:hw:1".into());
        CaptureSource { name: name.into(), kind: CaptureKind::Input, device, played: None }
    }

    #[test]
    fn a_source_is_the_same_whatever_others_make_of_its_name() {
        let alone = source("USB Audio");
        assert!(alone.is_same(&source("USB Audio (alsa:hw:1)")));
        let other = CaptureSource { device: Some("alsa:hw:2".into()), ..alone.clone() };
        let loopback = CaptureSource { kind: CaptureKind::Loopback, ..alone.clone() };
        assert!(!alone.is_same(&other) && !alone.is_same(&loopback));
    }

    #[test]
    fn a_source_is_called_the_same_whether_others_have_its_name_or_not() {
        let (alone, beside) = ("USB Audio", "USB Audio (alsa:hw:1)");
        for is in [alone, beside] {
            for was in [alone, beside] {
                assert!(source(is).is_called(was), "{is}, {was}");
            }
        }
        assert!(!source(beside).is_called("USB Audio (alsa:hw:2)") && !source(alone).is_called("USB"));
    }
}
