//! What is asked of a basis, and what is told about it besides the numbers.

/// How a basis is solved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BasisSettings {
    /// K, from 1 to the number of operator vertices.
    pub harmonics: usize,
    /// Worker threads; `None` for all of the machine's. The result does not depend on it.
    pub threads: Option<usize>,
    /// Where K would cut a group of equal eigenvalues, extend K to the end of the group.
    pub whole_clusters: bool,
}

impl BasisSettings {
    /// K harmonics on all threads, exactly K even if that cuts a multiple eigenvalue.
    pub fn new(harmonics: usize) -> Self {
        Self { harmonics, threads: None, whole_clusters: false }
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
    /// the part that is there are then one of many equally good choices.
    pub cuts_cluster: bool,
    /// Why the cache could not be used or written; the basis itself is not affected.
    pub cache_warning: Option<String>,
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
