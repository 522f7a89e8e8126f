//! Generalized eigenproblems S h = λ M h, of a mesh or from elsewhere.

use std::time::Instant;

use chladni_task::Task;

use crate::build::on_threads;
use crate::eigen::{self, Solved};
use crate::{Basis, BasisSettings, BuildReport, HarmonicsError, Operator, SymmetricSparse};

/// S and the diagonal of M of S h = λ M h: a Laplacian of your own, the energy of a shell, a graph.
///
/// ```
/// use chladni_harmonics::{BasisSettings, Pencil, SymmetricSparse};
/// use chladni_task::Task;
///
/// // A string of 400 beads, held at both ends.
/// let springs = (0..400).flat_map(|i| [(i, i, 2.0)].into_iter().chain((i > 0).then(|| (i, i - 1, -1.0))));
/// let (stiffness, mass) = (SymmetricSparse::from_entries(400, springs)?, vec![1.0; 400]);
/// let pencil = Pencil::new(&stiffness, &mass)?;
/// let (basis, report) = pencil.solve(&BasisSettings::new(5), &Task::new())?;
/// for (k, lambda) in basis.eigenvalues.iter().enumerate() {
///     let expected = 2.0 - 2.0 * (std::f64::consts::PI * (k + 1) as f64 / 401.0).cos();
///     assert!((lambda / expected - 1.0).abs() < 1e-9);
/// }
/// assert!(report.warnings(&basis.certificate).is_empty());
/// # Ok::<(), chladni_harmonics::HarmonicsError>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Pencil<'a> {
    pub(crate) stiffness: &'a SymmetricSparse,
    pub(crate) mass: &'a [f64],
}

impl<'a> Pencil<'a> {
    /// S, N×N, and the N values of M's diagonal.
    ///
    /// # Errors
    /// [`HarmonicsError::BadPencil`] where S is no symmetric matrix with all of its diagonal stored
    /// ([`SymmetricSparse::from_entries`] makes one), where M has another size or a value that is not positive, or
    /// where anything is not finite.
    pub fn new(stiffness: &'a SymmetricSparse, mass: &'a [f64]) -> Result<Self, HarmonicsError> {
        let bad = |reason: String| Err(HarmonicsError::BadPencil { reason });
        stiffness.check().map_err(|reason| HarmonicsError::BadPencil { reason })?;
        if mass.len() != stiffness.size() {
            return bad(format!("S has {} rows and M has {} values", stiffness.size(), mass.len()));
        }
        // NaN is not positive either.
        if let Some(i) = mass.iter().position(|m| !(*m > 0.0 && m.is_finite())) {
            return bad(format!("value {i} of M is {}, not positive and finite", mass[i]));
        }
        Ok(Self { stiffness, mass })
    }

    /// The first K pairs, certified: λ ascending and H with HᵀMH = I, in the units of S and M.
    ///
    /// S must be positive semidefinite; its null space may have any dimension, and those of its eigenvalues that
    /// are 0 but for rounding come out as exactly 0. Signs are such that a harmonic is positive where it is
    /// largest; which vectors stand for a multiple eigenvalue is left to rounding. The certificate is that of
    /// S + tM, t being about the mean distance of the first K eigenvalues.
    ///
    /// `settings.laplacian` plays no part. K is at most N, and the report says so where more were asked for.
    ///
    /// # Errors
    /// K = 0, S with negative eigenvalues, a solve that cannot be certified, or [`HarmonicsError::Cancelled`].
    pub fn solve(
        &self,
        settings: &BasisSettings,
        task: &Task,
    ) -> Result<(Basis, BuildReport), HarmonicsError> {
        let start = Instant::now();
        let vertices = self.mass.len();
        let mut report = BuildReport { asked: settings.harmonics, vertices, ..BuildReport::default() };
        let harmonics = settings.clamped(vertices)?;
        let Solved { basis, cuts_cluster, fell_back_to_dense, profile } =
            on_threads(settings.threads, || {
                eigen::solve_given(*self, harmonics, settings.whole_clusters, task)
            })??;
        (report.cuts_cluster, report.fell_back_to_dense) = (cuts_cluster, fell_back_to_dense);
        report.profile = profile;
        report.seconds.solve = start.elapsed().as_secs_f64();
        report.seconds.total = report.seconds.solve;
        Ok((basis, report))
    }

    /// Gershgorin on M⁻¹ S: no eigenvalue is above the largest sum of sizes in a row. Where nothing off
    /// the diagonal is above zero that is twice the largest S_vv / a_v; plain cotangents may have more.
    pub(crate) fn bound(&self) -> f64 {
        let row = |v: usize| self.stiffness.column(v).map(|(_, s)| s.abs()).sum::<f64>() / self.mass[v];
        (0..self.mass.len()).map(row).fold(0.0, f64::max)
    }
}

impl Operator {
    /// Its S and M, as a solver takes them.
    pub fn pencil(&self) -> Pencil<'_> {
        Pencil { stiffness: &self.stiffness, mass: &self.mass }
    }
}
