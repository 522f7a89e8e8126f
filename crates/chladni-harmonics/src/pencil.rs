//! Generalized eigenproblems S h = λ M h, from a mesh or from elsewhere.

use crate::{Certificate, HarmonicsError, Operator, SymmetricSparse};

/// S and the diagonal of M of S h = λ M h, for example of your own Laplacian, a shell energy or a graph.
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
    /// The diagonal of M.
    pub(crate) mass: &'a [f64],
    /// All of M if it is not diagonal; stored at the same places as S.
    pub(crate) consistent: Option<&'a SymmetricSparse>,
}

impl<'a> Pencil<'a> {
    /// S, N×N, and the N values of M's diagonal.
    ///
    /// # Errors
    /// [`HarmonicsError::BadPencil`] if S is not a symmetric matrix with all of its diagonal stored
    /// ([`SymmetricSparse::from_entries`] makes one), if M has another size or a value that is not
    /// positive, or if a value is not finite.
    pub fn new(stiffness: &'a SymmetricSparse, mass: &'a [f64]) -> Result<Self, HarmonicsError> {
        let bad = |reason: String| Err(HarmonicsError::bad_pencil(reason));
        stiffness.check("S")?;
        if mass.len() != stiffness.size() {
            return bad(format!("S has {} rows and M has {} values", stiffness.size(), mass.len()));
        }
        // This condition also catches NaN.
        if let Some(i) = mass.iter().position(|m| !(*m > 0.0 && m.is_finite())) {
            return bad(format!("value {i} of M is {}, not positive and finite", mass[i]));
        }
        Ok(Self::lumped(stiffness, mass))
    }

    /// A pencil from matrices that are known to be valid.
    pub(crate) fn lumped(stiffness: &'a SymmetricSparse, mass: &'a [f64]) -> Self {
        Self { stiffness, mass, consistent: None }
    }

    /// M x.
    pub(crate) fn mass_times(&self, x: &[f64]) -> Vec<f64> {
        match self.consistent {
            None => x.iter().zip(self.mass).map(|(x, a)| x * a).collect(),
            Some(consistent) => consistent.times(x),
        }
    }

    /// An upper bound of the eigenvalues of D⁻¹ S, where D is the diagonal of M: the largest sum of
    /// magnitudes in a row of M⁻¹ S or of D^-½ S D^-½ (Gershgorin). The first is tight for Laplacians, the
    /// second if masses differ by orders of magnitude.
    pub(crate) fn bound(&self) -> f64 {
        let largest = |weight: &dyn Fn(usize, usize) -> f64| {
            let row = |v| self.stiffness.column(v).map(|(i, s)| s.abs() * weight(i, v)).sum::<f64>();
            (0..self.mass.len()).map(row).fold(0.0, f64::max)
        };
        let roots: Vec<f64> = self.mass.iter().map(|a| a.sqrt()).collect();
        largest(&|_, v| self.mass[v].recip()).min(largest(&|i, v| (roots[i] * roots[v]).recip()))
    }
}

/// S and M of S h = λ M h for an M that is not diagonal, such as the consistent mass of finite elements.
///
/// ```
/// use chladni_harmonics::{BasisSettings, ConsistentPencil, SymmetricSparse};
/// use chladni_task::Task;
///
/// // A string of length 1 in 400 linear elements, free at both ends.
/// let (n, h) = (401, 1.0 / 400.0);
/// let elements = |own: f64, other: f64| {
///     let all = (0..400).flat_map(move |i| [(i, i, own), (i + 1, i + 1, own), (i, i + 1, other)]);
///     SymmetricSparse::from_entries(n, all.collect::<Vec<_>>())
/// };
/// let (stiffness, mass) = (elements(1.0 / h, -1.0 / h)?, elements(h / 3.0, h / 6.0)?);
/// let pencil = ConsistentPencil::new(&stiffness, &mass)?;
/// let (pairs, _) = pencil.solve(&BasisSettings::new(5), &Task::new())?;
/// for (k, lambda) in pairs.eigenvalues.iter().enumerate() {
///     let c = (std::f64::consts::PI * k as f64 * h).cos();
///     assert!((lambda - 6.0 / (h * h) * (1.0 - c) / (2.0 + c)).abs() < 1e-7);
/// }
/// # Ok::<(), chladni_harmonics::HarmonicsError>(())
/// ```
#[derive(Clone, Debug)]
pub struct ConsistentPencil {
    stiffness: SymmetricSparse,
    mass: SymmetricSparse,
    diagonal: Vec<f64>,
}

impl ConsistentPencil {
    /// S and M, both N×N.
    ///
    /// # Errors
    /// [`HarmonicsError::BadPencil`] if S or M is not a symmetric matrix with all of its diagonal stored,
    /// if the two differ in size, or if the diagonal of M is not positive. Whether M is positive definite
    /// is checked by [`solve`](Self::solve).
    pub fn new(stiffness: &SymmetricSparse, mass: &SymmetricSparse) -> Result<Self, HarmonicsError> {
        mass.check("M")?;
        let diagonal = mass.diagonal();
        Pencil::new(stiffness, &diagonal)?;
        let (stiffness, mass) = (stiffness.at_places_of(mass), mass.at_places_of(stiffness));
        Ok(Self { stiffness, mass, diagonal })
    }

    /// S and M in the form that the solver takes.
    pub(crate) fn pencil(&self) -> Pencil<'_> {
        Pencil { stiffness: &self.stiffness, mass: &self.diagonal, consistent: Some(&self.mass) }
    }
}

/// The first K pairs S h = λ M h of a [`ConsistentPencil`].
#[derive(Clone, Debug, PartialEq)]
pub struct Eigenpairs {
    /// λ_k, K values, ascending.
    pub eigenvalues: Vec<f64>,
    /// H, N×K, column-major, HᵀMH = I.
    pub vectors: Vec<f64>,
    /// The results of checking the pairs.
    pub certificate: Certificate,
}

impl Operator {
    /// S and M in the form that a solver takes.
    pub fn pencil(&self) -> Pencil<'_> {
        Pencil::lumped(&self.stiffness, &self.mass)
    }
}
