//! The settings of a basis.

use serde::{Deserialize, Serialize};

use crate::HarmonicsError;

/// Which discrete Laplacian a mesh is given (docs/laplacian.md).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Laplacian {
    /// The intrinsic Delaunay Laplacian of the tufted cover: every mesh with area has it.
    #[default]
    Delaunay,
    /// The papers': the cotangents of the mesh's own triangles, negative weights and all. It
    /// needs at most two triangles on every edge, and triangles that have an area.
    Cotangent,
}

impl std::fmt::Display for Laplacian {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Delaunay => "delaunay",
            Self::Cotangent => "cotangent",
        })
    }
}

/// How a basis is solved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BasisSettings {
    /// K ≥ 1; a shape with fewer operator vertices gets one harmonic per vertex.
    pub harmonics: usize,
    /// The operator whose harmonics they are.
    pub laplacian: Laplacian,
    /// Worker threads; `None` for all of the machine's, or those of the pool in which the solver is called
    /// (`pool.install(|| …)` of rayon hands one in). The result does not depend on it.
    pub threads: Option<usize>,
    /// Where K would cut a group of equal eigenvalues, extend K to the end of the group.
    pub whole_clusters: bool,
}

/// 256 harmonics, enough to recognize a face.
impl Default for BasisSettings {
    fn default() -> Self {
        Self::new(256)
    }
}

impl BasisSettings {
    /// K harmonics on all threads, exactly K even if that cuts a multiple eigenvalue.
    pub fn new(harmonics: usize) -> Self {
        Self { harmonics, laplacian: Laplacian::default(), threads: None, whole_clusters: false }
    }

    /// K, or N where that is less.
    pub(crate) fn clamped(&self, vertices: usize) -> Result<usize, HarmonicsError> {
        match self.harmonics.min(vertices) {
            0 => Err(HarmonicsError::BadHarmonicCount { harmonics: self.harmonics, vertices }),
            harmonics => Ok(harmonics),
        }
    }
}
