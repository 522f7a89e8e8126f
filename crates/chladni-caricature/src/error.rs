//! Errors of this crate: what went wrong, where and why.

use std::path::PathBuf;
use std::sync::Arc;

/// An error of this crate.
#[derive(Debug, thiserror::Error)]
pub enum CaricatureError {
    /// A signal does not have one value per operator vertex.
    #[error("{what} has {found} values, the shape has {expected} vertices")]
    VertexCount {
        /// The signal.
        what: &'static str,
        /// Values it has.
        found: usize,
        /// Values it should have.
        expected: usize,
    },
    /// A region was painted on a shape with other vertices.
    #[error(
        "the painted region has {found} values, the shape has {expected} vertices: the shape has changed, \
         or an older Chladni counted its parts without area; paint the region again"
    )]
    PaintedElsewhere {
        /// Values of the region.
        found: usize,
        /// Operator vertices of the shape.
        expected: usize,
    },
    /// A text, such as a command-line argument or a field of a project, does not parse.
    #[error("{what} `{text}`: {why}")]
    Syntax {
        /// The kind of text that was being read.
        what: &'static str,
        /// The text as given, shortened.
        text: String,
        /// The fault in it.
        why: String,
    },
    /// A number lies outside its range.
    #[error("{what} is {value}, it must be {range}")]
    Range {
        /// The quantity.
        what: &'static str,
        /// Its value.
        value: f64,
        /// The values it may have, in words.
        range: &'static str,
    },
    /// An action names a layer that the project does not have.
    #[error("there is no layer {0}")]
    NoLayer(u64),
    /// A layer would lose the layer whose result is its template, or come to lie below it.
    #[error("layer {layer} is compared with the result of layer {of}, which has to be below it")]
    NotBelow {
        /// The name of the layer.
        layer: String,
        /// The name of the one below, or its number where there is none.
        of: String,
    },
    /// Painting was asked for before the shape was loaded.
    #[error("a region can only be painted on a loaded shape")]
    NoSurface,
    /// A shape is not named, or cannot be read.
    #[error(transparent)]
    Shape(#[from] chladni_mesh::MeshError),
    /// A template could not be loaded or matched.
    #[error("template {template}: {why}")]
    Template {
        /// The template, as written in the project.
        template: String,
        /// The reason.
        why: String,
    },
    /// The match that a layer needs failed before.
    #[error(transparent)]
    Unmatched(Arc<Self>),
    /// A layer's displacement could not be limited.
    #[error("its triangles cannot be kept: {0}")]
    Unkept(Arc<Self>),
    /// Work for a layer failed outside this crate; the text is that of the failure and names the file.
    #[error("{0}")]
    Elsewhere(String),
    /// A file of a project whose name is not Unicode, which a project file has to be.
    #[error("{}: its name is not valid Unicode", .0.display())]
    NotUnicode(PathBuf),
    /// Painted vertices or picked points of one shape have no place on another.
    #[error("the layers cannot be carried to this shape: {0}")]
    Carry(String),
    /// A project file is not valid.
    #[error("{}: {why}", path.display())]
    ProjectFile {
        /// The file.
        path: PathBuf,
        /// The fault in it, with line and column where known.
        why: String,
    },
    /// A project cannot be put into a file.
    #[error(transparent)]
    Unwritable(#[from] toml::ser::Error),
    /// A project file was written by a newer program.
    #[error("{}: has format version {found}, this program reads up to {supported}; a newer Chladni wrote it", path.display())]
    NewerFormat {
        /// The file.
        path: PathBuf,
        /// The version it names.
        found: i64,
        /// The newest version that can be read.
        supported: i64,
    },
    /// Reading or writing a file failed.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// The system's error.
        source: std::io::Error,
    },
    /// A region cannot be softened on this surface.
    #[error("the region cannot be softened: {0}")]
    Softening(#[from] chladni_harmonics::HarmonicsError),
    /// A gallery of caricatures refuses.
    #[error(transparent)]
    Breeding(#[from] chladni_breeding::BreedingError),
    /// Variants cannot be evaluated; the text says why.
    #[error("the gallery cannot be drawn: {0}")]
    Gallery(String),
    /// The work was cancelled through its task.
    #[error(transparent)]
    Cancelled(#[from] chladni_task::Cancelled),
}

impl CaricatureError {
    /// A [`Syntax`](Self::Syntax) error that quotes at most 40 characters of `text`.
    pub(crate) fn syntax(what: &'static str, text: &str, why: impl Into<String>) -> Self {
        let mut shown: String = text.chars().take(40).collect();
        if shown.len() < text.len() {
            shown.push('…');
        }
        Self::Syntax { what, text: shown, why: why.into() }
    }
}
