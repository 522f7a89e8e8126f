//! Checks a basis again, from its numbers alone.

use super::components::{Components, Kind};
use crate::{Basis, Certificate, HarmonicsError, Operator};

/// The number of pairs between two counts.
const STRIDE: usize = 50;
/// Neighboring eigenvalues that differ by less than this share are too close to count between them.
const ROOM: f64 = 1e-6;

impl Operator {
    /// Checks `basis` against this operator, whichever solver computed it. Counts eigenvalues by inertia
    /// above the last pair and below every fiftieth, and measures every residual and every scalar product.
    ///
    /// The solver certifies its result while it solves (docs/eigensolver.md). This check costs a few
    /// factorizations and a matrix product N×K×K more; it is meant for tests and for bases from elsewhere.
    ///
    /// # Errors
    /// A basis with another number of vertices, or no successful factorization near a count.
    pub fn certify(&self, basis: &Basis) -> Result<Certificate, HarmonicsError> {
        if basis.vertices() != self.vertices() || basis.vectors.len() != self.vertices() * basis.harmonics() {
            return Err(HarmonicsError::not_certified("the basis is of another mesh"));
        }
        let mut certificate =
            super::certify(self.pencil(), self.components(), &basis.eigenvalues, &basis.vectors, None);
        certificate.laplacian = self.laplacian;
        certificate.inertia_counts_match = Some(self.counts_match(&basis.eigenvalues)?);
        Ok(certificate)
    }

    fn counts_match(&self, values: &[f64]) -> Result<bool, HarmonicsError> {
        let components = Components::of(self.pencil(), &self.component, Kind::Surface)?;
        let is_room = |k: usize| values[k] - values[k - 1] > ROOM * values[k];
        let mut places: Vec<(usize, f64)> = (1..values.len())
            .step_by(STRIDE)
            .filter_map(|from| (from..values.len()).find(|&k| is_room(k)))
            .map(|k| (k, 0.5 * (values[k - 1] + values[k])))
            .collect();
        places.dedup_by_key(|p| p.0);
        for (k, lambda) in places {
            if components.count(lambda)? != k {
                return Ok(false);
            }
        }
        // Just above the last pair there are as many eigenvalues as pairs, or more if K cuts a multiple
        // eigenvalue.
        let last = values.last().copied().unwrap_or(0.0);
        let scale = 4.0 * std::f64::consts::PI / self.mass.iter().sum::<f64>();
        Ok(components.count(last + ROOM * last.max(scale))? >= values.len())
    }
}
