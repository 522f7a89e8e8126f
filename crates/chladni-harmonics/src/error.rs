//! The errors of this crate.

use std::path::PathBuf;

use chladni_task::Cancelled;

/// Why a mesh or a pencil has no harmonics, or why work with them failed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum HarmonicsError {
    /// No triangle with three different corners.
    #[error("the mesh has no triangle with three different corners")]
    NoTriangle,
    /// A triangle refers to a vertex that does not exist.
    #[error("triangle {triangle} names vertex {vertex}, but there are only {vertices} vertices")]
    IndexOutOfRange {
        /// Index of the triangle, from 0.
        triangle: usize,
        /// Index of the vertex, from 0.
        vertex: u32,
        /// n, the number of vertices.
        vertices: usize,
    },
    /// A coordinate is NaN or infinite, or too large to compute lengths with.
    #[error("vertex {vertex} has coordinates that are not finite or too large to compute with")]
    NotFinite {
        /// Index of the vertex in the file, from 0.
        vertex: usize,
    },
    /// A mesh none of whose connected components has an area; the first of them.
    #[error("a connected component of {vertices} vertices has no area (vertex {vertex} is one of them)")]
    ZeroArea {
        /// Size of the component, in operator vertices.
        vertices: usize,
        /// One vertex of the file in it, from 0.
        vertex: usize,
    },
    /// More than two triangles meet at an edge, for which the plain cotangent Laplacian has no weight.
    #[error(
        "cannot have the papers' plain cotangent Laplacian: {triangles} triangles meet at the edge of vertices {} and \
         {} (the usual Laplacian takes any mesh)", ends[0], ends[1]
    )]
    CrowdedEdge {
        /// The vertices of the file at the ends of the edge, from 0.
        ends: [usize; 2],
        /// The number of triangles at the edge.
        triangles: usize,
    },
    /// A triangle has no area, by which the plain cotangent Laplacian would divide.
    #[error(
        "cannot have the papers' plain cotangent Laplacian: the triangle of vertices {}, {} and {} has no area (the \
         usual Laplacian takes any mesh)", corners[0], corners[1], corners[2]
    )]
    FlatTriangle {
        /// The vertices of the file at the corners, from 0.
        corners: [usize; 3],
    },
    /// K is 0, or more than N where exactly K harmonics are needed.
    #[error(
        "{harmonics} harmonics were asked for, but the mesh has {vertices} usable vertices (welded, referenced): \
         ask for 1 to {vertices}"
    )]
    BadHarmonicCount {
        /// K as requested.
        harmonics: usize,
        /// N.
        vertices: usize,
    },
    /// The pairs that were found did not pass their check, even after another search.
    #[error("the harmonics could not be certified: {reason}")]
    NotCertified {
        /// Which check failed and where.
        reason: String,
    },
    /// The harmonics belong to another shape.
    #[error("the harmonics are those of a shape of {harmonics_of} vertices, and this one has {vertices}")]
    OtherShape {
        /// N of the shape for which they were solved.
        harmonics_of: usize,
        /// N of the mesh.
        vertices: usize,
    },
    /// S and M do not form a pencil that can be solved.
    #[error("{reason}")]
    BadPencil {
        /// The fault in them.
        reason: String,
    },
    /// A heat step of a length that cannot be computed.
    #[error(
        "no heat step of length {time} can be taken on this surface: it is not above 0, or too long for it"
    )]
    HeatStep {
        /// Its length, as it was asked for.
        time: f64,
    },
    /// A vertex is so far from all sources that no heat reaches it; its distance cannot be measured.
    #[error(
        "vertex {vertex} is too many edges away from every source for heat to reach it: take a longer step"
    )]
    TooFar {
        /// The vertex in the file, from 0.
        vertex: usize,
    },
    /// A source, a vertex of a map, or a position that is not on the surface.
    #[error("vertex {vertex} is not on the surface, which has {vertices} vertices: {reason}")]
    NotOnSurface {
        /// Index of the vertex.
        vertex: usize,
        /// The number of vertices.
        vertices: usize,
        /// The reason.
        reason: &'static str,
    },
    /// Distances are asked for from no vertex.
    #[error("there is no source to measure distances from")]
    NoSource,
    /// The shape is so small or so large that its areas or eigenvalues are no numbers.
    #[error(
        "the shape is about {size:e} across, so that areas or eigenvalues in its units are beyond what numbers can \
         hold: scale it"
    )]
    ExtremeSize {
        /// The extent along an axis, in its own units.
        size: f64,
    },
    /// A functional map whose size does not fit its eigenvectors.
    #[error("functional map: {reason}")]
    BadMap {
        /// The mismatch.
        reason: String,
    },
    /// More harmonics than fit in memory, or than a solver can find for this number of vertices.
    #[error("{harmonics} harmonics of {vertices} vertices cannot be solved for: {reason}")]
    TooMany {
        /// K as requested.
        harmonics: usize,
        /// N.
        vertices: usize,
        /// The reason.
        reason: String,
    },
    /// The harmonics that do not fit in memory, or that ranks exchange, cannot be kept in the scratch folder.
    #[error("harmonics cannot be kept in {}: {reason}", folder.display())]
    NoScratch {
        /// The folder.
        folder: PathBuf,
        /// The system's message.
        reason: String,
    },
    /// A file of a basis in a folder cannot be read.
    #[error("{}: {reason}", path.display())]
    Stored {
        /// The file.
        path: PathBuf,
        /// The fault in it.
        reason: String,
    },
    /// Values or coefficients of a signal that are not as many as the basis needs.
    #[error("a signal of {given} {values}, where the basis has {needed}")]
    BadSignal {
        /// The number of values that were given.
        given: usize,
        /// Their kind, in the plural.
        values: &'static str,
        /// The number of vertices or harmonics.
        needed: usize,
    },
    /// SLEPc cannot be used, or not with the requested ranks.
    #[error("cannot solve with SLEPc: {reason}")]
    NoRanks {
        /// The missing or wrong part.
        reason: String,
    },
    /// The ranks ended without a result.
    #[error("the ranks of SLEPc failed: {reason}")]
    RanksFailed {
        /// The report of the first rank that failed.
        reason: String,
    },
    /// More worker threads than any machine has use for: each costs memory and a process of the system.
    #[error("{threads} threads: at most {most} are possible")]
    TooManyThreads {
        /// The number that was asked for.
        threads: usize,
        /// The largest that is possible.
        most: usize,
    },
    /// The worker threads could not be started.
    #[error("the worker threads could not be started: {0}")]
    Threads(String),
    /// The work was cancelled; nothing is left behind.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl HarmonicsError {
    pub(crate) fn bad_pencil(reason: impl Into<String>) -> Self {
        Self::BadPencil { reason: reason.into() }
    }

    pub(crate) fn not_certified(reason: impl Into<String>) -> Self {
        Self::NotCertified { reason: reason.into() }
    }
}
