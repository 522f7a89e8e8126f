//! The harmonic basis and the transform to and from it.

use crate::{Laplacian, Values};

/// The results of checking a [`Basis`] after it was solved.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Certificate {
    /// The operator to which the pairs belong; for a [`Pencil`](crate::Pencil), whose operator is unknown,
    /// the default.
    #[serde(default)]
    pub laplacian: Laplacian,
    /// Whether the number of eigenvalues below every slice boundary (of a dense solve, below the gap above the
    /// last pair), by Sylvester's law of inertia, equals the number of pairs found there: then none is missing
    /// and none is doubled. `None` where that is not known: a solver without factors
    /// ([`InnerSolver::Iterated`](crate::InnerSolver)) cannot count, nor are pairs of a dense solve counted whose
    /// residuals or overlaps exceed 10⁻⁷ (of a [`Pencil`](crate::Pencil), those of S + tM), and beside a far larger eigenvalue
    /// the count of a dense solve may be lost in rounding.
    pub inertia_counts_match: Option<bool>,
    /// max over k ≥ 1 of ‖S h − λ M h‖ / ‖S h‖; from [`Operator::certify`](crate::Operator::certify) also that of the
    /// constants, as a share of the terms that cancel. For a [`Pencil`](crate::Pencil), that of S + tM, which is solved
    /// instead of S, or where that of S itself exceeds 10⁻⁷ and is larger, that (docs/eigensolver.md).
    pub max_relative_residual: f64,
    /// max |HᵀMH − I|.
    pub max_orthogonality_error: f64,
}

impl Certificate {
    /// The largest relative residual to expect on a sound mesh.
    pub const RESIDUAL: f64 = 1e-9;
    /// The largest orthogonality error to expect on a sound mesh.
    pub const ORTHOGONALITY: f64 = 1e-8;

    /// The joint certificate of two sets of pairs with disjoint supports.
    pub(crate) fn and(&self, other: &Self) -> Self {
        let both = |a: Option<bool>, b: Option<bool>| match (a, b) {
            (Some(a), Some(b)) => Some(a && b),
            (Some(false), None) | (None, Some(false)) => Some(false),
            _ => None,
        };
        Self {
            laplacian: self.laplacian,
            inertia_counts_match: both(self.inertia_counts_match, other.inertia_counts_match),
            max_relative_residual: larger(self.max_relative_residual, other.max_relative_residual),
            max_orthogonality_error: larger(self.max_orthogonality_error, other.max_orthogonality_error),
        }
    }

    /// Whether the pairs are as exact as those of a sound mesh. On meshes whose triangles differ in size by
    /// many orders of magnitude, rounding alone may make that impossible.
    #[must_use]
    pub fn is_precise(&self) -> bool {
        self.warning().is_none()
    }

    /// The condition of [`Self::is_precise`] that fails, in words; `None` if all hold.
    #[must_use]
    pub fn warning(&self) -> Option<String> {
        let exceeds = |error: f64, limit: f64| error.is_nan() || error > limit;
        let mut failed = Vec::new();
        match self.inertia_counts_match {
            Some(true) => {}
            Some(false) => failed
                .push("harmonics may be missing or double: the counts of eigenvalues do not agree".into()),
            None => failed.push("no count of the eigenvalues shows that no harmonic is missing".into()),
        }
        if exceeds(self.max_relative_residual, Self::RESIDUAL) {
            failed.push(format!(
                "the harmonics solve their equation to {:.1e} only (sound meshes: at most {:.0e})",
                self.max_relative_residual,
                Self::RESIDUAL
            ));
        }
        if exceeds(self.max_orthogonality_error, Self::ORTHOGONALITY) {
            failed.push(format!(
                "any two harmonics overlap by up to {:.1e} (sound meshes: at most {:.0e})",
                self.max_orthogonality_error,
                Self::ORTHOGONALITY
            ));
        }
        (!failed.is_empty()).then(|| failed.join("; "))
    }
}

/// The larger of two errors; NaN, which `f64::max` drops, must not count as small.
pub(crate) fn larger(a: f64, b: f64) -> f64 {
    if a.is_nan() || b.is_nan() { f64::NAN } else { a.max(b) }
}

/// The first K generalized eigenpairs S h = λ M h of a shape.
///
/// Vertices are the N operator vertices, welded and referenced. Units are those of the frame in which it
/// was solved; see [`Body`](crate::Body).
#[derive(Clone, Debug, PartialEq)]
pub struct Basis {
    /// λ_k, K values, ascending; 0 occurs once per component.
    pub eigenvalues: Vec<f64>,
    /// H, N×K, column-major: harmonic k is `vectors[k·N .. (k+1)·N]`. HᵀMH = I. In a file if
    /// memory had no room for them ([`BasisSettings::scratch`](crate::BasisSettings::scratch)).
    pub vectors: Values,
    /// a(v), N lumped areas; positive.
    pub mass: Vec<f64>,
    /// How far the pairs can be trusted.
    pub certificate: Certificate,
}

impl Basis {
    /// N, the number of operator vertices.
    pub fn vertices(&self) -> usize {
        self.mass.len()
    }

    /// K, the number of harmonics.
    pub fn harmonics(&self) -> usize {
        self.eigenvalues.len()
    }

    /// The number of harmonics that are constant on each component: one per component, as far as K reaches.
    pub fn constants(&self) -> usize {
        self.eigenvalues.iter().take_while(|l| **l <= 0.0).count()
    }

    /// The number of harmonics below `cutoff`, at most K. The constants of all components count as one: a
    /// low-pass with only some of the constants would tear the components apart.
    pub fn harmonics_below(&self, cutoff: usize) -> usize {
        let further = if cutoff > 0 { self.constants().saturating_sub(1) } else { 0 };
        cutoff.saturating_add(further).min(self.harmonics())
    }

    /// Keeps the first `harmonics` harmonics, or all if there are fewer.
    pub(crate) fn truncate(&mut self, harmonics: usize) {
        self.eigenvalues.truncate(harmonics);
        self.vectors.truncate(harmonics * self.mass.len());
    }

    /// H_k, N values. Panics if `k ≥ K`.
    pub fn harmonic(&self, k: usize) -> &[f64] {
        let n = self.vertices();
        &self.vectors[k * n..(k + 1) * n]
    }
}

#[cfg(test)]
mod tests {
    use super::{Certificate, Laplacian};

    #[test]
    fn what_is_unknown_in_one_part_is_unknown_in_the_whole() {
        let sound = Certificate {
            laplacian: Laplacian::Delaunay,
            inertia_counts_match: Some(true),
            max_relative_residual: 1e-11,
            max_orthogonality_error: 1e-10,
        };
        let unknown = Certificate { max_relative_residual: f64::NAN, ..sound };
        for both in [sound.and(&unknown), unknown.and(&sound)] {
            assert!(both.max_relative_residual.is_nan() && both.max_orthogonality_error == 1e-10);
        }
    }

    #[test]
    fn a_warning_names_what_failed_and_nothing_else() {
        let sound = Certificate {
            laplacian: Laplacian::Delaunay,
            inertia_counts_match: Some(true),
            max_relative_residual: 1e-11,
            max_orthogonality_error: 1e-10,
        };
        assert!(sound.is_precise() && sound.warning().is_none());
        let rough = Certificate { max_relative_residual: 3e-9, ..sound };
        let slanted = Certificate { max_orthogonality_error: 2e-8, ..sound };
        let (residual, overlap) = ("solve their equation to 3.0e-9", "overlap by up to 2.0e-8");
        let warning = |certificate: Certificate| certificate.warning().unwrap();
        assert!(warning(rough).contains(residual) && !warning(rough).contains("overlap"));
        assert!(warning(slanted).contains(overlap) && !warning(slanted).contains("equation"));
        let both = warning(Certificate { max_orthogonality_error: 2e-8, ..rough });
        assert!(both.contains(residual) && both.contains(overlap));
        assert!(
            warning(Certificate { inertia_counts_match: Some(false), ..sound }).contains("may be missing")
        );
        assert!(warning(Certificate { inertia_counts_match: None, ..sound }).contains("no count"));
    }
}
