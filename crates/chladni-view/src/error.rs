//! Errors between a mesh and its picture.

use std::fmt::Display;
use std::io;
use std::path::{Path, PathBuf};

/// Why a picture or a film could not be made.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ViewError {
    /// No graphics adapter, not even a software one.
    #[error(
        "no graphics adapter: let the processor draw, or install a Vulkan driver (Mesa's lavapipe needs no card): {0}"
    )]
    NoAdapter(String),
    /// The adapter refused to open a device.
    #[error("graphics adapter {adapter}: {reason}")]
    NoDevice {
        /// The adapter's own name.
        adapter: String,
        /// The driver's message.
        reason: String,
    },
    /// The device went away, or refused a command.
    #[error("graphics device: {0}")]
    Device(String),
    /// A picture of no pixels, or larger than the device can draw.
    #[error("a picture of {width}×{height} pixels: each side must be 1 to {limit}")]
    Size {
        /// Width asked for, pixels.
        width: u32,
        /// Height asked for, pixels.
        height: u32,
        /// Longest side that can be drawn, pixels.
        limit: u32,
    },
    /// Arrays that belong together differ in length, or a triangle names a vertex that is not there.
    #[error("{0}")]
    Shape(String),
    /// An image could not be encoded or decoded.
    #[error("image: {0}")]
    Image(String),
    /// ffmpeg is needed for this film and is not on the PATH.
    #[error("ffmpeg is not on the PATH: install it")]
    NoFfmpeg,
    /// ffmpeg ended with an error.
    #[error("ffmpeg: {0}")]
    Ffmpeg(String),
    /// A frame does not fit the film it was given to.
    #[error("film: {0}")]
    Film(String),
    /// Pictures cannot be given to other programs as a camera.
    #[error("camera: {0}")]
    Camera(String),
    /// A setting that does not exist.
    #[error("expected {0}")]
    Expected(&'static str),
    /// A file could not be written or read.
    #[error("{path}: {source}")]
    File {
        /// The file.
        path: PathBuf,
        /// The system's error.
        source: io::Error,
    },
    /// The work was cancelled.
    #[error(transparent)]
    Cancelled(#[from] chladni_task::Cancelled),
}

impl ViewError {
    /// The system's error about the file at `path`.
    pub(crate) fn at(path: &Path) -> impl Fn(io::Error) -> Self {
        move |source| Self::File { path: path.to_owned(), source }
    }

    /// That an image could not be encoded or decoded, in the words of its library.
    pub(crate) fn image(error: impl Display) -> Self {
        Self::Image(error.to_string())
    }
}
