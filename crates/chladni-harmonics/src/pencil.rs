//! Generalized eigenproblems S h = λ M h, of a mesh or from elsewhere.

use crate::{HarmonicsError, Operator, SymmetricSparse};

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
