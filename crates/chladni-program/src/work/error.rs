//! Why work failed, and warnings about work that was not done quite as asked.

use std::fmt::Display;
use std::path::{Path, PathBuf};

use chladni_caricature::CaricatureError;
use chladni_harmonics::HarmonicsError;
use chladni_match::{MatchError, NEAR_TIE};
use chladni_mesh::{MeshError, Orientation, TriMesh};
use chladni_music::MusicError;
use chladni_sound::SoundError;
use chladni_synth::SynthError;
use chladni_task::Cancelled;
use chladni_view::ViewError;

use super::health::digits;

/// An error of another library.
type Cause = Box<dyn std::error::Error + Send + Sync>;

/// Why work was not done. Its line says what, where and why.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// It was cancelled.
    #[error("cancelled; no unfinished file is left")]
    Cancelled,
    /// A request that cannot be met, for the reason given.
    #[error("{0}")]
    Input(String),
    /// An error about `name`, which the error itself does not mention.
    #[error("{name}: {error}")]
    Of {
        /// A file, a sample, a pair of them.
        name: String,
        /// The error in it.
        error: Box<Self>,
    },
    /// A file could not be written; the error says which.
    #[error("{0}")]
    Unsaved(Box<Self>),
    /// A file could not be written.
    #[error("{}: cannot be written: {why}", path.display())]
    Unwritten {
        /// The file.
        path: PathBuf,
        /// The reason given by the system or the format.
        why: Cause,
    },
    /// Work on a thread of its own ended without a result: a bug in that work.
    #[error("{0} broke off; this is a bug")]
    BrokeOff(String),
    /// A failure of the machine or of the program rather than of the input.
    #[error("{0}")]
    Other(Cause),
    /// A mesh cannot be read.
    #[error(transparent)]
    Mesh(MeshError),
    /// A mesh has no harmonics.
    #[error(transparent)]
    Harmonics(HarmonicsError),
    /// Two shapes do not match.
    #[error(transparent)]
    Match(MatchError),
    /// A project cannot be read or evaluated.
    #[error(transparent)]
    Caricature(CaricatureError),
    /// A preset or show cannot be read or played.
    #[error(transparent)]
    Music(MusicError),
    /// A song cannot be read or played.
    #[error(transparent)]
    Sound(SoundError),
    /// A shape cannot be deformed.
    #[error(transparent)]
    Synth(#[from] SynthError),
    /// A picture cannot be drawn.
    #[error(transparent)]
    View(ViewError),
}

impl Error {
    /// A request that cannot be met because of `why`.
    pub fn input(why: impl Display) -> Self {
        Self::Input(why.to_string())
    }

    /// A failure of the machine or the program.
    pub fn other(cause: impl Into<Cause>) -> Self {
        Self::Other(cause.into())
    }

    /// Writing `path` failed.
    pub fn unwritten(path: &Path, why: impl Into<Cause>) -> Self {
        Self::Unwritten { path: path.to_owned(), why: why.into() }
    }

    /// Saving failed, with an error that names the file.
    pub fn unsaved(error: impl Into<Self>) -> Self {
        Self::Unsaved(Box::new(error.into()))
    }

    /// The same error, attributed to `name`; cancelling is not attributed.
    pub fn of(self, name: impl Display) -> Self {
        match self {
            Self::Cancelled => Self::Cancelled,
            error => Self::Of { name: name.to_string(), error: Box::new(error) },
        }
    }

    /// Whether the work was cancelled.
    pub fn is_cancelled(&self) -> bool {
        matches!(self, Self::Cancelled)
    }

    /// Whether a file, a shape or a request is at fault, rather than the machine or the program.
    pub fn is_of_input(&self) -> bool {
        match self {
            Self::Of { error, .. } => error.is_of_input(),
            Self::Input(_) => true,
            Self::Mesh(_) | Self::Match(_) | Self::Caricature(_) | Self::Music(_) => true,
            Self::Harmonics(error) => {
                use HarmonicsError::{NoScratch, NotCertified, RanksFailed, Threads};
                !matches!(error, NotCertified { .. } | NoScratch { .. } | RanksFailed { .. } | Threads(_))
            }
            Self::Sound(error) => !matches!(error, SoundError::Write { .. } | SoundError::Device { .. }),
            Self::Cancelled
            | Self::Unsaved(_)
            | Self::Unwritten { .. }
            | Self::BrokeOff(_)
            | Self::Other(_)
            | Self::Synth(_)
            | Self::View(_) => false,
        }
    }
}

impl From<Cancelled> for Error {
    fn from(_: Cancelled) -> Self {
        Self::Cancelled
    }
}

/// Conversions of the engines' errors; cancelling becomes one variant, whichever engine reports it.
macro_rules! from_engines {
    ($($engine:ident => $variant:ident),+) => {$(
        impl From<$engine> for Error {
            fn from(error: $engine) -> Self {
                match error {
                    $engine::Cancelled(_) => Self::Cancelled,
                    error => Self::$variant(error),
                }
            }
        }
    )+};
}

from_engines! {
    MeshError => Mesh,
    HarmonicsError => Harmonics,
    MatchError => Match,
    CaricatureError => Caricature,
    MusicError => Music,
    SoundError => Sound,
    ViewError => View
}

/// Something was repaired or is not as asked, and work continues.
#[derive(Clone, Debug, PartialEq)]
pub enum Warning {
    /// The shape called `name` has too few vertices for the harmonics that were `asked` for.
    FewerHarmonics {
        /// Name of the shape.
        name: String,
        /// Usable vertices, which is also the number of harmonics.
        vertices: usize,
        /// The number of harmonics asked for.
        asked: usize,
    },
    /// Most harmonics of the shape called `name` are constants of its pieces.
    ManyPieces {
        /// Name of the shape.
        name: String,
        /// Harmonics that are constant on each piece.
        constants: usize,
        /// All of them.
        harmonics: usize,
    },
    /// A region holds no vertex of a shape, which reaches from `from` to `to`.
    EmptyRegion {
        /// The layer whose region it is, if it is one's.
        layer: Option<String>,
        /// The least coordinates, file units.
        from: [f64; 3],
        /// The largest.
        to: [f64; 3],
    },
    /// It could not be found out how a shape stands.
    InDoubt {
        /// Name of the shape.
        name: String,
        /// How it is drawn.
        stands: Orientation,
    },
    /// A layer's template fits in another pose nearly as well.
    NearTie {
        /// The template.
        template: String,
    },
    /// A warning of an engine or a file about `name`.
    Of {
        /// A file, a sample, a template.
        name: String,
        /// A sentence.
        message: String,
    },
    /// A warning about all of the work.
    Plain(String),
}

impl Warning {
    /// A warning about `name`.
    pub fn of(name: impl Display, message: impl Display) -> Self {
        Self::Of { name: name.to_string(), message: message.to_string() }
    }

    /// The region, of this `layer` if it is one's, holds no vertex of `mesh`.
    pub fn empty_region(layer: Option<&str>, mesh: &TriMesh) -> Self {
        let [from, to] = [f64::min, f64::max].map(|of: fn(f64, f64) -> f64| {
            let all = mesh.positions.iter().copied();
            all.reduce(|a, b| std::array::from_fn(|i| of(a[i], b[i]))).unwrap_or_default()
        });
        Self::EmptyRegion { layer: layer.map(str::to_owned), from, to }
    }
}

impl Display for Warning {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::FewerHarmonics { name, vertices, asked } => {
                write!(f, "{name}: has {vertices} vertices; {vertices} harmonics instead of {asked}")
            }
            Self::ManyPieces { name, constants, harmonics } => write!(
                f,
                "{name}: {constants} of {harmonics} harmonics only say where its pieces lie: fewer loose pieces or more \
                 harmonics would give it more form"
            ),
            Self::EmptyRegion { layer, from, to } => {
                let diagonal = (0..3).map(|i| (to[i] - from[i]).powi(2)).sum::<f64>().sqrt();
                let corner = |at: &[f64; 3]| at.map(|c| digits(c, diagonal)).join(",");
                let (from, to) = (corner(from), corner(to));
                match layer {
                    Some(layer) => {
                        write!(f, "layer {layer}: its region holds no vertex, so it moves nothing")?;
                    }
                    None => f.write_str("the region holds no vertex")?,
                }
                write!(f, "; the shape reaches from {from} to {to}")
            }
            Self::InDoubt { name, stands } => write!(f, "{name}: drawn with {stands}, which is in doubt"),
            Self::NearTie { template } => write!(f, "{template}: {NEAR_TIE}"),
            Self::Of { name, message } => write!(f, "{name}: {message}"),
            Self::Plain(message) => f.write_str(message),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_small_shape_reaches_somewhere_too() {
        let warning = |from, to| Warning::EmptyRegion { layer: Some("a".into()), from, to }.to_string();
        let small = warning([-1e-5, 0.0, 0.0], [2e-5, 1e-5, 0.0]);
        let reached = "from -1.00000e-5,0.000000,0.000000 to 2.00000e-5,1.00000e-5,0.000000";
        assert!(small.ends_with(reached), "{small}");
        assert!(warning([0.0; 3], [1.0; 3]).ends_with("to 1.000000,1.000000,1.000000"));
    }

    #[test]
    fn cancelling_is_one_thing_and_blame_is_kept_through_names() {
        let stopped = Error::from(SoundError::Cancelled(Cancelled)).of("a.wav");
        assert!(stopped.is_cancelled() && !stopped.is_of_input());
        let bad = Error::from(HarmonicsError::NoTriangle).of("a.obj");
        assert!(bad.is_of_input() && bad.to_string().starts_with("a.obj: "));
        let doubtful = Error::from(HarmonicsError::NotCertified { reason: String::new() }).of("a.obj");
        assert!(!doubtful.is_of_input());
        let full = HarmonicsError::NoScratch { folder: "/tmp".into(), reason: "no room".into() };
        assert!(!Error::from(full).is_of_input());
        assert!(!Error::unsaved(Error::input("disk full")).is_of_input());
    }
}
