//! The errors of this crate.

use std::io;
use std::path::PathBuf;

/// Why a sound could not be read, written, analyzed, played or captured.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SoundError {
    /// The operating system refused to let the file be read.
    #[error("{name}: cannot be read: {source}")]
    Read {
        /// The file, as the caller named it.
        name: String,
        /// The system's reason.
        source: io::Error,
    },
    /// No known container begins with the bytes of this file.
    #[error("{name}: not a sound file of a known kind ({reason})")]
    Unrecognized {
        /// The file, as the caller named it.
        name: String,
        /// The reader's message.
        reason: String,
    },
    /// The container is known, but its codec is not supported.
    #[error("{name}: holds {codec} sound, which is not supported: {advice}")]
    UnsupportedCodec {
        /// The file, as the caller named it.
        name: String,
        /// The codec's name.
        codec: String,
        /// A remedy for the user.
        advice: &'static str,
    },
    /// The file is well-formed but holds no samples.
    #[error("{name}: holds no sound")]
    Empty {
        /// The file, as the caller named it.
        name: String,
    },
    /// The file's content contradicts its headers.
    #[error("{name}: damaged: {what}")]
    Damaged {
        /// The file, as the caller named it.
        name: String,
        /// The fault.
        what: String,
    },
    /// An implausible sampling rate.
    #[error("{name}: a sampling rate of {rate_hz} Hz is outside {min} to {max} Hz", min = crate::MIN_RATE_HZ, max = crate::MAX_RATE_HZ)]
    Rate {
        /// The file, as the caller named it.
        name: String,
        /// The rate it states.
        rate_hz: u32,
    },
    /// The song does not fit into the memory that the caller allows.
    #[error("{name}: longer than the {limit_secs:.0} s that can be read as a whole")]
    TooLong {
        /// The file, as the caller named it.
        name: String,
        /// How many seconds fit.
        limit_secs: f64,
    },
    /// A file could not be written.
    #[error("{}: cannot be written: {source}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        source: io::Error,
    },
    /// A setting is out of range.
    #[error("{what}")]
    Setting {
        /// The setting and its allowed range.
        what: String,
    },
    /// A sound device failed or does not exist.
    #[error("sound device: {what}")]
    Device {
        /// Which device, and why.
        what: String,
    },
    /// The work was cancelled through its task.
    #[error(transparent)]
    Cancelled(#[from] chladni_task::Cancelled),
}
