//! Builds a [`Body`] from a mesh, using the cache if there is one; and a basis from a pencil.

use std::borrow::Cow;
use std::sync::Arc;

use chladni_mesh::TriMesh;
use chladni_mesh::surface::repeated_triangles;
use chladni_task::Task;

use crate::eigen::{self, Solved};
use crate::operator::Domain;
use crate::platform::Instant;
use crate::threads::on_threads;
use crate::{
    Basis, BasisCache, BasisSettings, Body, BuildReport, Certificate, ConsistentPencil, Eigenpairs,
    HarmonicsError, Laplacian, Operator, Pencil, Values, memory,
};

impl Body {
    /// Welds `mesh`, builds its Laplacian and solves for its harmonics.
    ///
    /// # Errors
    /// A mesh without usable triangles or without area, K = 0, a result that cannot be certified,
    /// or [`HarmonicsError::Cancelled`].
    pub fn build(mesh: &TriMesh, settings: &BasisSettings, task: &Task) -> Result<Self, HarmonicsError> {
        Self::load_or_build(mesh, settings, None, task).map(|(body, _)| body)
    }

    /// Like [`build`](Self::build), but reads the basis from `cache` if it holds an intact entry for this
    /// surface and K; otherwise solves and writes the entry.
    ///
    /// A damaged entry is solved again and replaced. A cache that cannot be written is reported in
    /// [`BuildReport::cache_warning`], and K > N and parts without area in [`BuildReport::warnings`].
    ///
    /// # Errors
    /// Those of [`build`](Self::build).
    pub fn load_or_build(
        mesh: &TriMesh,
        settings: &BasisSettings,
        cache: Option<&BasisCache>,
        task: &Task,
    ) -> Result<(Self, BuildReport), HarmonicsError> {
        built(mesh, None, settings, cache, task)
    }

    /// Like [`load_or_build`](Self::load_or_build), but takes an `operator` that was built from `mesh`
    /// before: S is then built only once if both S and H are needed. The Laplacian is that of the operator;
    /// the one in `settings` is ignored.
    ///
    /// # Errors
    /// Those of [`build`](Self::build), and an operator of a mesh with another number of vertices.
    pub fn of_operator(
        mesh: &TriMesh,
        operator: &Operator,
        settings: &BasisSettings,
        cache: Option<&BasisCache>,
        task: &Task,
    ) -> Result<(Self, BuildReport), HarmonicsError> {
        operator.check_belongs_to(mesh)?;
        let settings = BasisSettings { laplacian: operator.laplacian, ..settings.clone() };
        built(mesh, Some(operator), &settings, cache, task)
    }

    /// The welded shape of `mesh` without harmonics (K = 0), for work that needs none, such as matching.
    ///
    /// # Errors
    /// A mesh without usable triangles.
    pub fn unsolved(mesh: &TriMesh) -> Result<Self, HarmonicsError> {
        let domain = Domain::of(mesh)?;
        let basis = Basis {
            eigenvalues: Vec::new(),
            vectors: Values::default(),
            mass: vec![1.0; domain.positions.len()],
            // For an empty set of pairs all conditions hold.
            certificate: Certificate {
                laplacian: Laplacian::default(),
                inertia_counts_match: Some(true),
                max_relative_residual: 0.0,
                max_orthogonality_error: 0.0,
            },
        };
        Ok(assembled(mesh, domain, basis))
    }

    /// A body from `mesh` and harmonics that were solved elsewhere, for example in the worker of a web
    /// page.
    ///
    /// # Errors
    /// A mesh without usable triangles, or a basis with another number of vertices.
    pub fn of_basis(mesh: &TriMesh, basis: Basis) -> Result<Self, HarmonicsError> {
        let domain = Domain::of(mesh)?;
        let vertices = domain.positions.len();
        let fits = basis.mass.len() == vertices && basis.vectors.len() == vertices * basis.eigenvalues.len();
        if !fits {
            return Err(HarmonicsError::OtherShape { harmonics_of: basis.mass.len(), vertices });
        }
        Ok(assembled(mesh, domain, basis))
    }
}

fn assembled(mesh: &TriMesh, domain: Domain, basis: Basis) -> Body {
    let triangles = file_triangles(mesh, &domain.operator_vertex);
    let Domain { frame, positions, operator_vertex, .. } = domain;
    Body { frame, positions, triangles, operator_vertex, basis: Arc::new(basis) }
}

impl Pencil<'_> {
    /// Solves for the first K pairs and certifies them: ascending λ, and H with HᵀMH = I, in the units of S
    /// and M.
    ///
    /// S must be positive semidefinite. Its null space may have any dimension, and eigenvalues that are 0
    /// within rounding are returned as exactly 0. A harmonic is positive where its magnitude is largest.
    /// Within the space of a multiple eigenvalue, rounding determines the basis. The certificate is that of
    /// S + tM, where t is about the mean distance between the first K eigenvalues, or, if all of them are 0, about
    /// the first that is not.
    ///
    /// `settings.laplacian` is ignored. K is limited to N; the report says if more were requested.
    ///
    /// # Errors
    /// K = 0, an S with negative eigenvalues, a result that cannot be certified, or
    /// [`HarmonicsError::Cancelled`].
    pub fn solve(
        &self,
        settings: &BasisSettings,
        task: &Task,
    ) -> Result<(Basis, BuildReport), HarmonicsError> {
        self.solve_and_choose(settings, |_| Ok(()), task)
    }

    /// As [`solve`](Self::solve); `choose` chooses among equally good pairs, of which it sees whole groups.
    pub(crate) fn solve_and_choose(
        &self,
        settings: &BasisSettings,
        choose: impl FnOnce(&mut Basis) -> Result<(), HarmonicsError> + Send,
        task: &Task,
    ) -> Result<(Basis, BuildReport), HarmonicsError> {
        let start = Instant::now();
        let vertices = self.mass.len();
        let mut report = BuildReport { asked: settings.harmonics, vertices, ..BuildReport::default() };
        let settings = BasisSettings { harmonics: settings.clamped(vertices)?, ..settings.clone() };
        let Solved { basis, cuts_cluster, fell_back_to_dense, short_of_memory, profile } =
            on_threads(settings.threads, || eigen::solve_given(*self, &settings, choose, task))??;
        (report.cuts_cluster, report.fell_back_to_dense) = (cuts_cluster, fell_back_to_dense);
        report.short_of_memory = short_of_memory;
        report.profile = profile;
        report.seconds.solve = start.elapsed().as_secs_f64();
        report.seconds.total = report.seconds.solve;
        Ok((basis, report))
    }
}

impl ConsistentPencil {
    /// Solves for the first K pairs and certifies them; see [`Pencil::solve`].
    ///
    /// # Errors
    /// Those of [`Pencil::solve`], and an M that is not positive definite, or so nearly singular that
    /// nothing could be certified.
    pub fn solve(
        &self,
        settings: &BasisSettings,
        task: &Task,
    ) -> Result<(Eigenpairs, BuildReport), HarmonicsError> {
        let (basis, report) = self.pencil().solve(settings, task)?;
        let Basis { eigenvalues, vectors, certificate, .. } = basis;
        Ok((Eigenpairs { eigenvalues, vectors: vectors.into_vec(), certificate }, report))
    }
}

fn built(
    mesh: &TriMesh,
    operator: Option<&Operator>,
    settings: &BasisSettings,
    cache: Option<&BasisCache>,
    task: &Task,
) -> Result<(Body, BuildReport), HarmonicsError> {
    let start = Instant::now();
    task.check()?;
    let domain = operator.map_or_else(|| Domain::of(mesh), |operator| Ok(operator.domain()))?;
    let vertices = domain.positions.len();
    let (asked, without_area) = (settings.harmonics, domain.without_area);
    let cover = operator.and_then(|operator| operator.cover);
    let mut report = BuildReport { asked, vertices, without_area, cover, ..BuildReport::default() };
    let settings = &BasisSettings { harmonics: settings.clamped(vertices)?, ..settings.clone() };
    let entry = cache.map(|c| c.entry(&domain, settings));
    let found =
        entry.as_ref().map_or(Ok(None), |entry| entry.read(vertices, settings)).unwrap_or_else(|warning| {
            report.cache_warning = Some(warning.to_string());
            None
        });
    let basis = match found {
        Some((basis, cuts_cluster)) => {
            (report.cached, report.cuts_cluster) = (true, cuts_cluster);
            basis
        }
        None => {
            // The operator takes a while, too.
            memory::room_for_solve(vertices, 1, 1, settings)?;
            let basis = solved(&domain, operator, settings, &mut report, task)?;
            if let Some(Err(warning)) = entry.map(|entry| entry.write(&basis, report.cuts_cluster)) {
                report.cache_warning = Some(warning.to_string());
            }
            basis
        }
    };
    report.seconds.total = start.elapsed().as_secs_f64();
    Ok((assembled(mesh, domain, basis), report))
}

fn solved(
    domain: &Domain,
    operator: Option<&Operator>,
    settings: &BasisSettings,
    report: &mut BuildReport,
    task: &Task,
) -> Result<Basis, HarmonicsError> {
    on_threads(settings.threads, || {
        let start = Instant::now();
        let stage = task.stage("Laplacian", 1);
        let operator = match operator {
            Some(operator) => Cow::Borrowed(operator),
            None => Cow::Owned(Operator::on(domain, settings.laplacian)?),
        };
        stage.advance(1);
        report.cover = operator.cover;
        report.seconds.operator = start.elapsed().as_secs_f64();
        let solving = Instant::now();
        let Solved { basis, cuts_cluster, fell_back_to_dense, short_of_memory, profile } =
            eigen::solve(&operator, settings, task)?;
        (report.cuts_cluster, report.fell_back_to_dense) = (cuts_cluster, fell_back_to_dense);
        report.short_of_memory = short_of_memory;
        report.profile = profile;
        report.seconds.solve = solving.elapsed().as_secs_f64();
        Ok(basis)
    })?
}

/// The file's triangles over operator vertices. If a vertex is only used by a collapsed triangle, or a part without area,
/// that corner is replaced by another of its corners (or 0), which keeps the triangle collapsed; repeated ones collapse,
/// too.
pub(crate) fn file_triangles(mesh: &TriMesh, operator_vertex: &[Option<u32>]) -> Vec<[u32; 3]> {
    // Rows tell places apart; a face with a corner that has none collapses anyway.
    let place: Vec<u32> = operator_vertex.iter().map(|v| v.unwrap_or(u32::MAX)).collect();
    mesh.triangles
        .iter()
        .zip(repeated_triangles(mesh, &place))
        .map(|(corners, repeated)| {
            let rows = corners.map(|v| operator_vertex[v as usize]);
            match rows {
                [Some(a), Some(b), Some(c)] if !repeated => [a, b, c],
                _ => [rows.into_iter().flatten().next().unwrap_or(0); 3],
            }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use chladni_mesh::samples::icosphere;

    use super::*;
    use crate::CoverReport;

    #[test]
    fn a_build_reports_what_was_done_to_the_surface() {
        let open = {
            let mut ball = icosphere(1);
            ball.triangles.pop();
            ball
        };
        let report = |mesh: &TriMesh, laplacian| {
            let settings = BasisSettings { laplacian, ..BasisSettings::new(9) };
            Body::load_or_build(mesh, &settings, None, &Task::new()).unwrap().1.cover
        };
        for (mesh, sheets) in [(&icosphere(1), 1), (&open, 2)] {
            let cover = CoverReport::of(mesh).unwrap();
            assert_eq!((cover.sheets, cover.mollified_by), (sheets, 0.0));
            assert_eq!(report(mesh, Laplacian::Delaunay), Some(cover));
            assert_eq!(report(mesh, Laplacian::Cotangent), None);
        }
        let (_, held) = Body::with_held_border(&open, &BasisSettings::new(9), &Task::new()).unwrap();
        assert_eq!(held.cover, Some(CoverReport::of(&open).unwrap()));
    }

    #[test]
    fn two_sided_faces_make_the_same_body_in_the_file_s_order() {
        let ball = icosphere(1);
        let n = ball.positions.len() as u32;
        let mut both = ball.clone();
        both.positions.extend_from_within(..);
        both.triangles.extend(ball.triangles.iter().map(|[a, b, c]| [b + n, a + n, c + n]));
        let [single, body] = [&ball, &both].map(|mesh| Body::unsolved(mesh).unwrap());
        assert_eq!(body.positions.len(), single.positions.len());
        let (front, back) = body.triangles.split_at(ball.triangles.len());
        assert_eq!(front, single.triangles);
        assert!(back.len() == front.len() && back.iter().all(|[a, b, c]| a == b && b == c));
    }

    #[test]
    fn harmonics_solved_elsewhere_make_the_same_body_and_those_of_another_shape_none() {
        let (mesh, task) = (icosphere(2), Task::new());
        let solved = Body::build(&mesh, &BasisSettings::new(9), &task).unwrap();
        let made = Body::of_basis(&mesh, Basis::clone(&solved.basis)).unwrap();
        assert_eq!((&made.positions, &made.triangles), (&solved.positions, &solved.triangles));
        assert_eq!((made.frame, made.operator_vertex), (solved.frame, solved.operator_vertex));
        let bare = Body::unsolved(&mesh).unwrap();
        assert_eq!((bare.positions, bare.basis.harmonics()), (made.positions, 0));
        let other = Body::of_basis(&icosphere(1), Basis::clone(&solved.basis)).unwrap_err();
        assert_eq!(other, HarmonicsError::OtherShape { harmonics_of: 162, vertices: 42 });
        let operator = Operator::of(&icosphere(1)).unwrap();
        let other = HarmonicsError::OtherShape { harmonics_of: 42, vertices: 162 };
        let refused = Body::of_operator(&mesh, &operator, &BasisSettings::new(9), None, &task).unwrap_err();
        assert_eq!(refused, other);
        #[cfg(not(target_family = "wasm"))]
        {
            let ranks = crate::Ranks::here(1);
            let refused = Body::solve_on_ranks(&mesh, &operator, &BasisSettings::new(9), &ranks, &task);
            assert_eq!(refused.unwrap_err(), other);
        }
    }
}
