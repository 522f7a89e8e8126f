//! The errors of this crate.

use chladni_task::Cancelled;

/// Which of the two meshes an error is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// The mesh to be caricatured.
    Shape,
    /// The mesh it is compared with.
    Template,
}

impl std::fmt::Display for Side {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Shape => "shape",
            Self::Template => "template",
        })
    }
}

/// Why a correspondence could not be computed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MatchError {
    /// A mesh has no triangle of positive area.
    #[error("the {0} has no triangle of positive area, so it has no surface to match")]
    NoSurface(Side),
    /// A coordinate is not finite.
    #[error("the {side} has a coordinate that is not finite (vertex {vertex})")]
    NotFinite {
        /// Which mesh.
        side: Side,
        /// Index of the vertex.
        vertex: usize,
    },
    /// A triangle uses a vertex that does not exist.
    #[error("triangle {triangle} of the {side} uses vertex {vertex}, but there are only {vertices}")]
    IndexOutOfRange {
        /// Which mesh.
        side: Side,
        /// Index of the triangle.
        triangle: usize,
        /// The index it uses.
        vertex: u32,
        /// n.
        vertices: usize,
    },
    /// A mesh has more vertices or triangles than 32-bit indices can count.
    #[error("the {0} has more vertices or triangles than 32-bit indices can count")]
    TooLarge(Side),
    /// A landmark file cannot be read.
    #[error("{}: {why}", path.display())]
    InLandmarkFile {
        /// The file.
        path: std::path::PathBuf,
        /// The reason, with the line if one is at fault.
        why: String,
    },
    /// The meshes should have the same connectivity, but their numbers of vertices differ.
    #[error(
        "not the same connectivity: the shape has {shape_vertices} vertices, the template {template_vertices}"
    )]
    VertexCountsDiffer {
        /// n of the shape.
        shape_vertices: usize,
        /// n of the template.
        template_vertices: usize,
    },
    /// The meshes should have the same connectivity, but only their numbers of vertices agree.
    #[error("not the same connectivity: {}", differing([*missing, *extra], [*triangles, *template_triangles]))]
    TrianglesDiffer {
        /// How many of the shape's triangles the template lacks.
        missing: usize,
        /// How many of the template's triangles the shape lacks.
        extra: usize,
        /// m of the shape.
        triangles: usize,
        /// m of the template.
        template_triangles: usize,
    },
    /// Too few pairs of points to determine a similarity.
    #[error("{0} pairs of points do not determine a similarity: three that are not in one line are needed")]
    TooFewPairs(usize),
    /// The pairs of points lie on one line or in one place.
    #[error("the pairs of points lie in one line or in one place: they do not determine a rotation")]
    Degenerate,
    /// Two lists that belong together differ in length.
    #[error("{what}: {left} against {right}")]
    LengthsDiffer {
        /// Which lists.
        what: &'static str,
        /// Length of the first.
        left: usize,
        /// Length of the second.
        right: usize,
    },
    /// A landmark refers to a vertex that does not exist or that no triangle uses. The text counts from one, as lists of
    /// landmarks do.
    #[error("landmark {}: vertex {vertex} of the {side} {problem}", landmark + 1)]
    Landmark {
        /// Index of the pair, from zero.
        landmark: usize,
        /// Which mesh.
        side: Side,
        /// Index of the vertex.
        vertex: u32,
        /// The fault in it.
        problem: &'static str,
    },
    /// A map through a sphere needs at least three landmarks.
    #[error("landmarks on both surfaces' largest components: {0}, where the map needs three or more")]
    TooFewLandmarks(usize),
    /// A line of a landmark file cannot be read.
    #[error("landmark file, line {line}: {problem}")]
    LandmarkFile {
        /// Line, from one.
        line: usize,
        /// The fault in it.
        problem: String,
    },
    /// A surface cannot be mapped to a sphere.
    #[error("the {side} cannot be mapped to a sphere: {problem}")]
    NoCommonDomain {
        /// Which mesh.
        side: Side,
        /// The reason.
        problem: String,
    },
    /// A parameter is out of its range.
    #[error("{name} must be {range}, not {value}")]
    Parameter {
        /// Its name.
        name: &'static str,
        /// The allowed range.
        range: &'static str,
        /// The given value.
        value: f64,
    },
    /// A linear system could not be solved.
    #[error("the {0} system could not be solved: the meshes are numerically degenerate")]
    Solver(&'static str),
    /// The task was cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// How triangles differ: `missing` ones of the shape's, whose number comes first, and `extra` ones of the template's.
fn differing([missing, extra]: [usize; 2], [ours, theirs]: [usize; 2]) -> String {
    let absent = format!("{missing} of the shape's {ours} triangles are not among the template's {theirs}");
    match (missing, extra) {
        (0, 0) => {
            format!("some of the shape's {ours} triangles, or of the template's {theirs}, are there twice")
        }
        (0, _) => format!("{extra} of the template's {theirs} triangles are not among the shape's {ours}"),
        (_, 0) => absent,
        _ => format!("{absent}, and {extra} of those not among the shape's"),
    }
}
