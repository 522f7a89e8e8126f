//! Sound for the music instrument: decoding, playback, capture, spectra and beat tracking.
//!
//! ```
//! use chladni_sound::{Spectrum, SpectrumAnalyzer, SpectrumSettings};
//!
//! // A tone of 440 Hz that is only in the left channel.
//! let rate_hz = 44_100;
//! let settings = SpectrumSettings { bands: 96, ..SpectrumSettings::new(rate_hz) };
//! let mut analyzer = SpectrumAnalyzer::new(settings)?;
//! let left: Vec<f32> = (0..analyzer.window_frames())
//!     .map(|n| (std::f32::consts::TAU * 440.0 * n as f32 / rate_hz as f32).sin())
//!     .collect();
//! let right = vec![0.0; left.len()];
//! let spectrum: &Spectrum = analyzer.analyze(&left, &right, 1.0 / 60.0);
//! let loudest = |bands: &[f32]| (0..bands.len()).max_by(|&a, &b| bands[a].total_cmp(&bands[b]));
//! let band = loudest(&spectrum.mid).expect("there are 96 bands");
//! assert!((analyzer.bands_hz()[band] / 440.0).log2().abs() < 0.1);
//! # Ok::<(), chladni_sound::SoundError>(())
//! ```
//!
//! Not guaranteed: the exact samples decoded by a lossy codec, which may change with the version of the
//! decoder; that a tracker's beats are those that a listener hears. Check the confidence that it states.

#![warn(clippy::missing_errors_doc)]

mod beat;
#[cfg(feature = "devices")]
mod capture;
mod clicks;
#[cfg(feature = "devices")]
mod converters;
mod crossfade;
mod decode;
mod error;
#[cfg(feature = "devices")]
mod history;
#[cfg(feature = "devices")]
mod names;
mod onset;
#[cfg(feature = "devices")]
mod player;
mod seam;
mod spectrum;
mod structure;
mod tune;
mod windowed;

pub use beat::{BeatFollower, BeatMoment, BeatScore, Beats, beat_score, track_beats, track_beats_causally};
#[cfg(feature = "devices")]
pub use capture::{Capture, CaptureFeed, CaptureKind, CaptureLevel, CaptureSource, capture_sources};
pub use clicks::clicks;
pub use crossfade::{LONGEST_CROSSFADE_SECS, crossfade_gain};
pub use decode::{
    SONG_EXTENSIONS, Song, SongOptions, SongReader, SongTags, StereoResampler, WavSample, is_decoding,
    wav_bytes, write_wav,
};
pub use error::SoundError;
pub use onset::{ONSET_RATE_HZ, Onset, OnsetDetector};
#[cfg(feature = "devices")]
pub use player::{
    HeardTo, MOST_AHEAD_SECS, OutputDevice, Player, PlayerEvent, PlayerSettings, PlayerState, PlayerStatus,
    Repeat, output_devices,
};
pub use seam::{SEAM_SECS, Seam};
pub use spectrum::{FrontEnd, Hop, Level, SongSpectrum, Spectrum, SpectrumAnalyzer, SpectrumSettings};
pub use structure::{Bar, ENERGY_RATE_HZ, HeardBar, Section};
pub use tune::{TUNE_BPM, TUNE_RATE_HZ, sample_tune, sample_tune_beats_secs};

/// The lowest sampling rate that is accepted, in Hz.
pub const MIN_RATE_HZ: u32 = 1_000;
/// The highest sampling rate that is accepted, in Hz.
pub const MAX_RATE_HZ: u32 = 768_000;

fn check_rate(name: &str, rate_hz: u32) -> Result<(), SoundError> {
    if (MIN_RATE_HZ..=MAX_RATE_HZ).contains(&rate_hz) {
        Ok(())
    } else {
        Err(SoundError::Rate { name: name.to_owned(), rate_hz })
    }
}

/// The examples of README.md, compiled.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
pub struct Readme;
