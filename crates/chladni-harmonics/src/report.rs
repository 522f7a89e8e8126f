//! Reports on a basis besides its numbers.

use std::path::PathBuf;

use crate::Certificate;

/// How a basis was computed.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BuildReport {
    /// K as requested.
    pub asked: usize,
    /// N, the number of operator vertices. No K is larger than that less `held`.
    pub vertices: usize,
    /// The number of them on a held border, where all harmonics are 0; 0 without one.
    pub held: usize,
    /// The number of connected components that were left out, since they have no area.
    pub without_area: usize,
    /// Whether the basis was read from the cache.
    pub cached: bool,
    /// Wall-clock times.
    pub seconds: BuildSeconds,
    /// Whether K cuts a group of equal eigenvalues: λ_{K−1} and λ_K agree to 1e-7. The harmonics before the
    /// cut are the first ones of the canonical choice in the whole group.
    pub cuts_cluster: bool,
    /// Whether slices could not be certified, and the operator was solved as a dense matrix instead.
    pub fell_back_to_dense: bool,
    /// How the intrinsic triangulation was made; `None` for a basis from the cache, whose operator was not built
    /// ([`CoverReport::of`] makes it again), for the plain cotangent Laplacian and for a [`Pencil`](crate::Pencil).
    pub cover: Option<CoverReport>,
    /// Concessions to a shortage of memory.
    pub short_of_memory: Option<ShortOfMemory>,
    /// Where the time of a solve by slices went; all zero if the basis was cached or solved densely.
    pub profile: SolveProfile,
    /// Why the cache could not be used or written; the basis itself is not affected.
    pub cache_warning: Option<String>,
}

impl BuildReport {
    /// The warnings that users of the basis should see; `certificate` is that of the basis.
    pub fn warnings(&self, certificate: &Certificate) -> Vec<BasisWarning> {
        let Self { asked, vertices, held, without_area, .. } = *self;
        let free = vertices.saturating_sub(held);
        let fewer = (asked > free).then_some(match held {
            0 => BasisWarning::FewerHarmonics { asked, vertices },
            _ => BasisWarning::HeldBorder { asked, vertices, free },
        });
        let flat = (without_area > 0).then_some(BasisWarning::WithoutArea { parts: without_area });
        let cache = self.cache_warning.clone().map(BasisWarning::Cache);
        let short = self.short_of_memory.clone().map(BasisWarning::ShortOfMemory);
        let imprecise = certificate.warning().map(BasisWarning::Imprecise);
        fewer.into_iter().chain(flat).chain(cache).chain(short).chain(imprecise).collect()
    }
}

/// What was done to a surface for its intrinsic Delaunay Laplacian (docs/laplacian.md).
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct CoverReport {
    /// How often the surface is covered: once by its own triangles, if it is closed, edge-manifold and oriented, else
    /// twice by its tufted cover.
    pub sheets: usize,
    /// The length by which all sides grew, as a share of the mean edge length; 0 on a sound mesh.
    pub mollified_by: f64,
    /// The number of edges that were flipped, over all sheets; an edge that was flipped twice counts twice.
    pub flips: usize,
}

impl std::fmt::Display for CoverReport {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(if self.sheets > 1 { "tufted cover" } else { "the mesh as it is" })?;
        if self.mollified_by > 0.0 {
            write!(f, ", mollified by {:.1e} mean edge lengths", self.mollified_by)?;
        }
        write!(f, ", {} edge flip{}", self.flips, if self.flips == 1 { "" } else { "s" })
    }
}

/// A difference between a basis and what was requested.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum BasisWarning {
    /// K was larger than the number of vertices.
    #[error("has {vertices} vertices; {vertices} harmonics instead of {asked}")]
    FewerHarmonics {
        /// K as requested.
        asked: usize,
        /// N, which is K of the result.
        vertices: usize,
    },
    /// K was larger than the number of vertices that are not on the held border.
    #[error("has {free} vertices off its held border, of {vertices}; {free} harmonics instead of {asked}")]
    HeldBorder {
        /// K as requested.
        asked: usize,
        /// N.
        vertices: usize,
        /// The number of vertices that are not held, which is K of the result.
        free: usize,
    },
    /// Connected components have no area, and no harmonics.
    #[error("has parts without area ({parts}), which are left out")]
    WithoutArea {
        /// The number of components.
        parts: usize,
    },
    /// The cache could not be used or written.
    #[error("{0}")]
    Cache(String),
    /// The solve did not fit in memory as a whole.
    #[error("{0}")]
    ShortOfMemory(ShortOfMemory),
    /// The certificate is worse than that of a sound mesh.
    #[error("{0}")]
    Imprecise(String),
}

/// How a solve differed from one with enough memory. Its result is the same.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ShortOfMemory {
    /// The number of slices that were solved at once.
    pub slices: usize,
    /// The number with enough memory.
    pub of_slices: usize,
    /// The folder in which the harmonics were kept, and the bytes that they took there at most.
    pub scratch: Option<(PathBuf, u64)>,
}

impl std::fmt::Display for ShortOfMemory {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "memory is short: ")?;
        if let Some((folder, bytes)) = &self.scratch {
            write!(
                f,
                "the harmonics are kept in {} (up to {:.1} GB)",
                folder.display(),
                *bytes as f64 / 1e9
            )?;
        }
        let between = if self.scratch.is_some() { ", and " } else { "" };
        if self.slices < self.of_slices {
            write!(f, "{between}{} of {} threads solve", self.slices, self.of_slices)?;
        }
        Ok(())
    }
}

/// Wall-clock seconds of each part of a build.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct BuildSeconds {
    /// Welding and the Laplacian.
    pub operator: f64,
    /// The eigenpairs and their certificate; 0 if cached.
    pub solve: f64,
    /// The whole build, including the cache.
    pub total: f64,
}

/// Where the time of a solve went. `analyze`, `plan` and `assemble` are wall-clock seconds, summed over the
/// components of a shape and over merging them; the others are seconds of thread time, summed over all
/// threads.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct SolveProfile {
    /// Elimination order and symbolic analysis (wall clock).
    pub analyze: f64,
    /// Counting eigenvalues to place the slices (wall clock).
    pub plan: f64,
    /// Computing the certificate, and writing the vectors in the order of the mesh (wall clock).
    pub assemble: f64,
    /// Numerical factorizations.
    pub factor: f64,
    /// Triangular solves.
    pub solve: f64,
    /// Orthogonalization of the Krylov blocks.
    pub orthogonalize: f64,
    /// Multiplications and additions in the orthogonalization, 2·n per pair of columns and product.
    pub orthogonalize_flops: u64,
    /// Small dense eigenproblems.
    pub project: f64,
    /// Computing eigenvectors from the Krylov blocks.
    pub vectors: f64,
    /// The number of factorizations.
    pub factored: u64,
    /// The number of right-hand sides solved.
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
