//! What is asked of a basis, and what is told about it besides the numbers.

use serde::{Deserialize, Serialize};

use crate::Certificate;

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
    /// K, from 1 to the number of operator vertices.
    pub harmonics: usize,
    /// The operator whose harmonics they are.
    pub laplacian: Laplacian,
    /// Worker threads; `None` for all of the machine's. The result does not depend on it.
    pub threads: Option<usize>,
    /// Where K would cut a group of equal eigenvalues, extend K to the end of the group.
    pub whole_clusters: bool,
}

impl BasisSettings {
    /// K harmonics on all threads, exactly K even if that cuts a multiple eigenvalue.
    pub fn new(harmonics: usize) -> Self {
        Self { harmonics, laplacian: Laplacian::default(), threads: None, whole_clusters: false }
    }
}

/// How a basis came to be.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BuildReport {
    /// Whether it was read from the cache.
    pub cached: bool,
    /// Wall-clock times.
    pub seconds: BuildSeconds,
    /// K cuts a group of equal eigenvalues: λ_{K−1} and λ_K agree to 1e-7. The harmonics of
    /// the part that is there are the first of the canonical choice in the whole group.
    pub cuts_cluster: bool,
    /// A solve by slices could not be certified, so the operator was solved as a dense matrix.
    pub fell_back_to_dense: bool,
    /// Where the time of a solve by slices went; all zero if cached or solved densely.
    pub profile: SolveProfile,
    /// Why the cache could not be used or written; the basis itself is not affected.
    pub cache_warning: Option<String>,
}

impl BuildReport {
    /// What whoever uses the basis should be told: that the cache failed, that `certificate` is not
    /// that of a sound mesh.
    pub fn warnings(&self, certificate: &Certificate) -> Vec<String> {
        self.cache_warning.iter().cloned().chain(certificate.warning()).collect()
    }
}

/// Wall-clock seconds of each part of a build.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct BuildSeconds {
    /// Welding and the Laplacian.
    pub operator: f64,
    /// The eigenpairs and their certificate; 0 if cached.
    pub solve: f64,
    /// All of it, the cache included.
    pub total: f64,
}

/// Where the time of a solve went. `analyze`, `plan` and `assemble` are wall-clock seconds, of a
/// shape of several components summed over them and what joins them; the others are seconds of
/// one thread summed over all threads.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct SolveProfile {
    /// Elimination order and symbolic analysis (wall clock).
    pub analyze: f64,
    /// Counting eigenvalues to place the slices (wall clock).
    pub plan: f64,
    /// Certificate, and the vectors written out in the mesh's order (wall clock).
    pub assemble: f64,
    /// Numerical factorizations.
    pub factor: f64,
    /// Triangular solves.
    pub solve: f64,
    /// Orthogonalisation of the Krylov blocks.
    pub orthogonalize: f64,
    /// Multiplications and additions in it, 2·n per pair of columns and product.
    pub orthogonalize_flops: u64,
    /// Small dense eigenproblems.
    pub project: f64,
    /// Eigenvectors from the Krylov blocks.
    pub vectors: f64,
    /// Factorizations made.
    pub factored: u64,
    /// Right-hand sides solved for.
    pub solved_columns: u64,
}

impl SolveProfile {
    pub(crate) fn add(&mut self, other: &Self) {
        self.analyze += other.analyze;
        self.plan += other.plan;
        self.assemble += other.assemble;
        self.factor += other.factor;
        self.solve += other.solve;
        self.orthogonalize += other.orthogonalize;
        self.orthogonalize_flops += other.orthogonalize_flops;
        self.project += other.project;
        self.vectors += other.vectors;
        self.factored += other.factored;
        self.solved_columns += other.solved_columns;
    }
}
