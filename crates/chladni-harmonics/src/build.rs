//! From a mesh to a [`Body`], through the cache where there is one.

use std::sync::Arc;
use std::time::Instant;

use chladni_mesh::TriMesh;
use chladni_task::Task;

use crate::eigen::{self, Solved};
use crate::operator::Surface;
use crate::{Basis, BasisCache, BasisSettings, Body, BuildReport, HarmonicsError, Operator};

impl Body {
    /// Welds `mesh`, builds its Laplacian and solves for its harmonics.
    ///
    /// # Errors
    /// A mesh without usable triangles, a component without area, K out of range, a solve
    /// that cannot be certified, or [`HarmonicsError::Cancelled`].
    pub fn build(mesh: &TriMesh, settings: &BasisSettings, task: &Task) -> Result<Self, HarmonicsError> {
        Self::load_or_build(mesh, settings, None, task).map(|(body, _)| body)
    }

    /// Like [`build`](Self::build), but reads the basis from `cache` where a sound entry for
    /// this very surface and K is there, and writes it there otherwise.
    ///
    /// A damaged entry is solved again and replaced; a cache that cannot be written is told in
    /// [`BuildReport::cache_warning`].
    pub fn load_or_build(
        mesh: &TriMesh,
        settings: &BasisSettings,
        cache: Option<&BasisCache>,
        task: &Task,
    ) -> Result<(Self, BuildReport), HarmonicsError> {
        let start = Instant::now();
        task.check()?;
        let surface = Surface::of(mesh)?;
        let n = surface.positions.len();
        if settings.harmonics == 0 || settings.harmonics > n {
            return Err(HarmonicsError::BadHarmonicCount { harmonics: settings.harmonics, vertices: n });
        }
        let mut report = BuildReport::default();
        let triangles = file_triangles(mesh, &surface.operator_vertex);
        let entry = cache.map(|c| c.entry(&surface, settings));
        if let Some(entry) = &entry {
            match entry.read(n) {
                Ok(Some((basis, cuts_cluster))) => {
                    report.cached = true;
                    report.cuts_cluster = cuts_cluster;
                    report.seconds.total = start.elapsed().as_secs_f64();
                    return Ok((Self::from_surface(surface, triangles, basis), report));
                }
                Ok(None) => {}
                Err(warning) => report.cache_warning = Some(warning),
            }
        }
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(settings.threads.unwrap_or(0))
            .build()
            .map_err(|e| HarmonicsError::Threads(e.to_string()))?;
        let stage = task.stage("Laplacian", 1);
        let operator = pool.install(|| Operator::of_surface(surface, settings.laplacian))?;
        stage.advance(1);
        report.seconds.operator = start.elapsed().as_secs_f64();
        let solving = Instant::now();
        let Solved { basis, cuts_cluster, fell_back_to_dense, profile } =
            pool.install(|| eigen::solve(&operator, settings.harmonics, settings.whole_clusters, task))?;
        report.cuts_cluster = cuts_cluster;
        report.fell_back_to_dense = fell_back_to_dense;
        report.profile = profile;
        report.seconds.solve = solving.elapsed().as_secs_f64();
        if let Some(entry) = &entry
            && let Err(warning) = entry.write(&basis, cuts_cluster)
        {
            report.cache_warning = Some(warning);
        }
        report.seconds.total = start.elapsed().as_secs_f64();
        let Operator { frame, positions, operator_vertex, .. } = operator;
        let body = Self { frame, positions, triangles, operator_vertex, basis: Arc::new(basis) };
        Ok((body, report))
    }

    fn from_surface(surface: Surface, triangles: Vec<[u32; 3]>, basis: Basis) -> Self {
        let Surface { frame, positions, operator_vertex, .. } = surface;
        Self { frame, positions, triangles, operator_vertex, basis: Arc::new(basis) }
    }
}

/// The file's triangles over operator vertices. Where a collapsed triangle is the only one that
/// uses a vertex, that corner is given another of its corners (or 0), which keeps it collapsed.
fn file_triangles(mesh: &TriMesh, operator_vertex: &[Option<u32>]) -> Vec<[u32; 3]> {
    mesh.triangles
        .iter()
        .map(|corners| {
            let rows = corners.map(|v| operator_vertex[v as usize]);
            match rows {
                [Some(a), Some(b), Some(c)] => [a, b, c],
                _ => [rows.into_iter().flatten().next().unwrap_or(0); 3],
            }
        })
        .collect()
}
