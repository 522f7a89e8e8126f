//! Errors between a file and a mesh.

use std::fmt;
use std::io;
use std::path::PathBuf;

use chladni_task::Cancelled;

use crate::Format;

/// Why a mesh could not be read or written: what, where and why, in one line.
#[derive(Debug, thiserror::Error)]
pub enum MeshError {
    /// Another error, and the file it is about.
    #[error("{}: {error}", path.display())]
    InFile {
        /// The file.
        path: PathBuf,
        /// The error in it.
        error: Box<MeshError>,
    },
    /// The system would not read or write the file.
    #[error("{0}")]
    Io(io::Error),
    /// Neither the name nor the content is that of a known format.
    #[error("{0}")]
    UnknownFormat(String),
    /// The bytes are not what their format demands.
    #[error("{format}, {at}: {reason}")]
    Malformed {
        /// The format the bytes were read as.
        format: Format,
        /// Where the fault lies.
        at: Place,
        /// The error there.
        reason: String,
    },
    /// A well-formed file without a triangle or polygon.
    #[error("{0} without a face: a mesh needs at least one triangle")]
    NoFace(Format),
    /// The mesh cannot be put into this format.
    #[error("cannot be written as {format}: {reason}")]
    Unwritable {
        /// The format asked for.
        format: Format,
        /// Why not.
        reason: String,
    },
    /// A name that no sample has.
    #[error("sample:{name}: there is no such sample; there are {list} and portrait", list = known.join(", "))]
    NoSample {
        /// The name.
        name: String,
        /// Those that there are, without `portrait`, which has sliders.
        known: &'static [&'static str],
    },
    /// A head whose sliders do not stand so.
    #[error("sample:{name}: {why}")]
    Sliders {
        /// The sample as it was named.
        name: String,
        /// The error in it.
        why: String,
    },
    /// An empty text where a file or a sample is to be named.
    #[error("no shape is named: write a path or sample:NAME")]
    NoName,
    /// A text that does not name a direction.
    #[error("`{0}` is no direction: axes are x, y, z, -x, -y and -z")]
    Direction(String),
    /// The work was cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// A place in a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Place {
    /// Line number, from 1.
    Line(usize),
    /// Byte offset, from 0.
    Byte(usize),
    /// A part of a structured file, such as `accessors[3]`.
    Part(String),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Line(line) => write!(f, "line {line}"),
            Self::Byte(byte) => write!(f, "byte {byte}"),
            Self::Part(part) => f.write_str(part),
        }
    }
}

/// A fault inside a reader, before the file or format is known.
#[derive(Debug)]
pub(crate) struct Fault {
    pub at: Place,
    pub reason: String,
}

impl Fault {
    pub fn line(line: usize, reason: impl Into<String>) -> Self {
        Self { at: Place::Line(line), reason: reason.into() }
    }

    pub fn byte(byte: usize, reason: impl Into<String>) -> Self {
        Self { at: Place::Byte(byte), reason: reason.into() }
    }

    pub fn part(part: impl Into<String>, reason: impl Into<String>) -> Self {
        Self { at: Place::Part(part.into()), reason: reason.into() }
    }
}
