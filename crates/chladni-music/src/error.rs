//! Errors of the music instrument.

/// An error of this crate: what, where and why.
#[derive(Debug, thiserror::Error)]
pub enum MusicError {
    /// A mapping whose numbers cannot be played.
    #[error("mapping: {what} {why}")]
    BadMapping {
        /// `transfer`, `amplification`, `stereo_mu` or `gain`.
        what: &'static str,
        /// The fault in it.
        why: String,
    },
    /// A body, spectrum or class list whose sizes do not fit each other.
    #[error("{what}: {found} where {expected} are needed")]
    Size {
        /// The things that were counted.
        what: &'static str,
        /// How many there are.
        found: usize,
        /// How many there must be.
        expected: usize,
    },
    /// An action names an item, a generation or a favorite that does not exist.
    #[error("there is no {what} {index}: there are {count}")]
    NoSuch {
        /// The kind of thing that was asked for.
        what: &'static str,
        /// Its index, from 0.
        index: usize,
        /// How many there are.
        count: usize,
    },
    /// Nothing was said to come on stage next.
    #[error("no dance is next on stage: choose one first")]
    NothingNext,
    /// The gallery refuses.
    #[error(transparent)]
    Breeding(#[from] chladni_breeding::BreedingError),
    /// A parameter out of its range.
    #[error("{name} = {value} is outside {range}")]
    OutOfRange {
        /// The parameter.
        name: &'static str,
        /// The value that was asked for.
        value: f64,
        /// The allowed range.
        range: String,
    },
    /// A preset or show file of a newer format.
    #[error("{kind} format version {found} is newer than {known}, the newest this program reads")]
    Version {
        /// `preset` or `show`.
        kind: &'static str,
        /// The version in the file.
        found: u32,
        /// The newest version that is understood.
        known: u32,
    },
    /// A preset or show that is not the text it should be.
    #[error("{kind}: {why}")]
    Parse {
        /// `preset` or `show`; `session` where a show is one of version 1.
        kind: &'static str,
        /// Line and reason, from the TOML reader.
        why: String,
    },
    /// A file that could not be read or written.
    #[error("{path}: {why}", path = path.display())]
    File {
        /// The file.
        path: std::path::PathBuf,
        /// The system's reason.
        why: std::io::Error,
    },
    /// The shape has no harmonics that could move it.
    #[error("symmetry: {0}")]
    Symmetry(String),
    /// Taps that do not say how far picture and sound are apart.
    #[error("{why}")]
    Calibration {
        /// Too few, or too far apart.
        why: String,
    },
    /// The work was cancelled.
    #[error(transparent)]
    Cancelled(#[from] chladni_task::Cancelled),
}
