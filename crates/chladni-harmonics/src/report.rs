//! What is reported about a basis besides its numbers.

use crate::Certificate;

/// How a basis came to be.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BuildReport {
    /// K as it was asked for.
    pub asked: usize,
    /// N, the number of operator vertices, which is also the number of all harmonics.
    pub vertices: usize,
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
    /// What users of the basis should know; `certificate` is the basis's.
    pub fn warnings(&self, certificate: &Certificate) -> Vec<BasisWarning> {
        let Self { asked, vertices, .. } = *self;
        let fewer = (asked > vertices).then_some(BasisWarning::FewerHarmonics { asked, vertices });
        let cache = self.cache_warning.clone().map(BasisWarning::Cache);
        fewer.into_iter().chain(cache).chain(certificate.warning().map(BasisWarning::Imprecise)).collect()
    }
}

/// A basis was made, but not quite as asked for.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum BasisWarning {
    /// K was more than there are.
    #[error("has {vertices} vertices; {vertices} harmonics instead of {asked}")]
    FewerHarmonics {
        /// K as it was asked for.
        asked: usize,
        /// N, and K as it is.
        vertices: usize,
    },
    /// The cache could not be used or written.
    #[error("{0}")]
    Cache(String),
    /// The certificate is not that of a sound mesh.
    #[error("{0}")]
    Imprecise(String),
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

/// Where the time of a solve went. `analyze`, `plan` and `assemble` are wall-clock seconds, summed over the
/// components of a shape and their joining; the others are seconds of one thread, summed over all threads.
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
    /// Orthogonalization of the Krylov blocks.
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
