//! The settings of a basis.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::HarmonicsError;

/// Which discrete Laplacian is used for a mesh (docs/laplacian.md).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Laplacian {
    /// The intrinsic Delaunay Laplacian of the tufted cover, which every mesh with area has.
    #[default]
    Delaunay,
    /// The Laplacian of the papers: the cotangents of the mesh's own triangles, including negative weights.
    /// It needs at most two triangles at every edge, and triangles with positive area.
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
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BasisSettings {
    /// K ≥ 1. A shape with fewer operator vertices gets one harmonic per vertex.
    pub harmonics: usize,
    /// The operator whose harmonics are computed.
    pub laplacian: Laplacian,
    /// The number of worker threads. `None` uses the rayon pool in which the solver is called
    /// (`pool.install(|| …)`), or all threads of the machine; at most 1,024. The result does not depend on it.
    pub threads: Option<usize>,
    /// Whether to extend K to the end of a group of equal eigenvalues that it would cut.
    pub whole_clusters: bool,
    /// The memory in bytes that a solve may take; `None` means the free memory of the system. A solve that does
    /// not fit solves fewer slices at once, if need be with its harmonics in `scratch`, or is refused.
    pub memory_bytes: Option<u64>,
    /// The folder for harmonics that do not fit in memory; `None` keeps all of them in memory. The result
    /// does not depend on it. See [`default_scratch`](Self::default_scratch).
    pub scratch: Option<PathBuf>,
}

/// The default is 256 harmonics, enough to recognize a face.
impl Default for BasisSettings {
    fn default() -> Self {
        Self::new(256)
    }
}

impl BasisSettings {
    /// K harmonics on all threads; exactly K, even if that cuts a group of equal eigenvalues.
    pub fn new(harmonics: usize) -> Self {
        Self {
            harmonics,
            laplacian: Laplacian::default(),
            threads: None,
            whole_clusters: false,
            memory_bytes: None,
            scratch: None,
        }
    }

    /// The folder that `TMPDIR` names; without it `/var/tmp` where there is one, because `/tmp` is often kept
    /// in memory; else the system's folder for temporary files.
    pub fn default_scratch() -> PathBuf {
        let disk = Path::new("/var/tmp");
        if std::env::var_os("TMPDIR").is_none() && cfg!(unix) && disk.is_dir() {
            return disk.into();
        }
        std::env::temp_dir()
    }

    /// K, or N if that is less.
    pub(crate) fn clamped(&self, vertices: usize) -> Result<usize, HarmonicsError> {
        match self.harmonics.min(vertices) {
            0 => Err(HarmonicsError::BadHarmonicCount { harmonics: self.harmonics, vertices }),
            harmonics => Ok(harmonics),
        }
    }
}
