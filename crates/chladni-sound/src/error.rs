//! What can go wrong with sound.

use std::io;
use std::path::PathBuf;

/// Why a sound could not be read, written, analyzed, played or captured.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SoundError {
    /// The operating system would not let us read.
    #[error("{name}: cannot be read: {source}")]
    Read {
        /// The file, as the caller named it.
        name: String,
        /// The system's reason.
        source: io::Error,
    },
    /// No known container starts this way.
    #[error("{name}: not a sound file of a known kind ({reason})")]
    Unrecognised {
        /// The file, as the caller named it.
        name: String,
        /// What the reader said.
        reason: String,
    },
    /// The container is known, but its codec is not supported.
    #[error("{name}: holds {codec} sound, which is not supported: {advice}")]
    UnsupportedCodec {
        /// The file, as the caller named it.
        name: String,
        /// The codec's name.
        codec: String,
        /// What the user can do.
        advice: &'static str,
    },
    /// The file seems well-formed but holds no samples.
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
        /// What is wrong.
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
    /// The song does not fit the memory that the caller allows.
    #[error(
        "{name}: longer than the {limit_secs:.0} s that fit into the memory allowed; give a start and a duration"
    )]
    TooLong {
        /// The file, as the caller named it.
        name: String,
        /// How many seconds would have fitted.
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
    /// A setting makes no sense.
    #[error("{what}")]
    Setting {
        /// Which and why.
        what: String,
    },
    /// A sound device failed or is not there.
    #[error("sound device: {what}")]
    Device {
        /// Which and why.
        what: String,
    },
    /// The work was cancelled through its task.
    #[error(transparent)]
    Cancelled(#[from] chladni_task::Cancelled),
}
