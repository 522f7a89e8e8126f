//! What can go wrong between a mesh and its harmonics.

use chladni_task::Cancelled;

/// Why a mesh got no harmonic basis.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum HarmonicsError {
    /// No triangle with three different corners.
    #[error("the mesh has no triangle with three different corners")]
    NoTriangle,
    /// A triangle names a vertex that is not there.
    #[error("triangle {triangle} names vertex {vertex}, but there are only {vertices} vertices")]
    IndexOutOfRange {
        /// Index of the triangle, from 0.
        triangle: usize,
        /// The vertex it names, from 0.
        vertex: u32,
        /// n, how many there are.
        vertices: usize,
    },
    /// NaN or infinite coordinates, or coordinates too large to measure lengths with.
    #[error("vertex {vertex} has coordinates that are not finite or too large to compute with")]
    NotFinite {
        /// Index of the vertex in the file, from 0.
        vertex: usize,
    },
    /// A connected component whose triangles all have zero area.
    #[error("a connected component of {vertices} vertices has no area (vertex {vertex} is one of them)")]
    ZeroArea {
        /// Size of the component, in operator vertices.
        vertices: usize,
        /// One vertex of the file in it, from 0.
        vertex: usize,
    },
    /// The plain cotangent Laplacian has no weight for an edge of more than two triangles.
    #[error(
        "cannot have the papers' plain cotangent Laplacian: {triangles} triangles meet at the edge of vertices {} and \
         {} (the usual Laplacian takes any mesh)", ends[0], ends[1]
    )]
    CrowdedEdge {
        /// Vertices of the file at its ends, from 0.
        ends: [usize; 2],
        /// How many meet there.
        triangles: usize,
    },
    /// The plain cotangent Laplacian divides by the area of each triangle.
    #[error(
        "cannot have the papers' plain cotangent Laplacian: the triangle of vertices {}, {} and {} has no area (the \
         usual Laplacian takes any mesh)", corners[0], corners[1], corners[2]
    )]
    FlatTriangle {
        /// Vertices of the file at its corners, from 0.
        corners: [usize; 3],
    },
    /// K is 0, or more than N where exactly K were to be had.
    #[error(
        "{harmonics} harmonics were asked for, but the mesh has {vertices} usable vertices (welded, referenced): \
         ask for 1 to {vertices}"
    )]
    BadHarmonicCount {
        /// K as asked for.
        harmonics: usize,
        /// N.
        vertices: usize,
    },
    /// The pairs that were found did not pass their check, even after being sought again.
    #[error("the harmonics could not be certified: {reason}")]
    NotCertified {
        /// Which check failed and where.
        reason: String,
    },
    /// Harmonics that were solved for another shape.
    #[error("the harmonics are those of a shape of {harmonics_of} vertices, and this one has {vertices}")]
    OtherShape {
        /// N of the shape that they were solved for.
        harmonics_of: usize,
        /// N of the mesh.
        vertices: usize,
    },
    /// S and M are not what a solver can take.
    #[error("not a symmetric pencil: {reason}")]
    BadPencil {
        /// What is wrong with them.
        reason: String,
    },
    /// A heat step of a length that nothing can be computed for.
    #[error("no heat step of length {time} can be taken on this surface")]
    HeatStep {
        /// Its length, in squared units of the working frame.
        time: f64,
    },
    /// A distance that the heat of a step does not reach: it would be measured along no direction.
    #[error(
        "vertex {vertex} is so many edges away from every source that no heat reaches it: take a longer step"
    )]
    TooFar {
        /// The vertex in the file, from 0.
        vertex: usize,
    },
    /// A source, or a vertex of a map, that is not on the surface.
    #[error("vertex {vertex} is not on the surface, which has {vertices} vertices: {reason}")]
    NotOnSurface {
        /// The vertex asked for.
        vertex: usize,
        /// How many there are.
        vertices: usize,
        /// Why not.
        reason: &'static str,
    },
    /// A functional map whose size does not fit its eigenvectors.
    #[error("functional map: {reason}")]
    BadMap {
        /// What does not fit.
        reason: String,
    },
    /// More harmonics than can be held in memory, or than a solver for so many vertices finds.
    #[error("{harmonics} harmonics of {vertices} vertices cannot be solved for: {reason}")]
    TooMany {
        /// K as asked for.
        harmonics: usize,
        /// N.
        vertices: usize,
        /// What stands against it.
        reason: String,
    },
    /// There are no ranks to solve on, or not as asked for.
    #[error("cannot solve with SLEPc: {reason}")]
    NoRanks {
        /// What is missing or wrong.
        reason: String,
    },
    /// The ranks ended without a result.
    #[error("the ranks of SLEPc failed: {reason}")]
    RanksFailed {
        /// What the first of them said.
        reason: String,
    },
    /// The worker threads could not be started.
    #[error("the worker threads could not be started: {0}")]
    Threads(String),
    /// The work was cancelled; nothing is left behind.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl HarmonicsError {
    pub(crate) fn not_certified(reason: impl Into<String>) -> Self {
        Self::NotCertified { reason: reason.into() }
    }
}
