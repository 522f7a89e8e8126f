//! Checks a basis again, from its numbers alone.

use super::components::{Components, Kind};
use crate::basis::larger;
use crate::{Basis, Certificate, HarmonicsError, Operator};

/// The number of pairs between two counts.
const STRIDE: usize = 50;
/// Neighboring eigenvalues that differ by less than this share are too close to count between them.
const ROOM: f64 = 1e-6;

impl Operator {
    /// Checks `basis` against this operator, whichever solver computed it. Counts eigenvalues by inertia
    /// below every fiftieth pair, below the last group of equal ones, and above the last pair, and measures
    /// every residual and every scalar product. Residuals of constants, where ‖S h‖ is 0, are shares of a bound
    /// on the eigenvalues.
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
        certificate.max_relative_residual =
            larger(certificate.max_relative_residual, self.residual_of_constants(basis));
        certificate.inertia_counts_match = Some(self.counts_match(&basis.eigenvalues)?);
        Ok(certificate)
    }

    /// The largest ‖M^-½ (S h − λ M h)‖ of the first pair of each component, as a share of ‖M^-½ |S| |h|‖: the terms
    /// that cancel, since S h of a constant is 0.
    fn residual_of_constants(&self, basis: &Basis) -> f64 {
        let residual = |(h, lambda): (&[f64], &f64)| {
            let (mut error, mut size) = (0.0, 0.0);
            for (v, a) in self.mass.iter().enumerate() {
                let terms = self.stiffness.column(v).map(|(i, s)| s * h[i]);
                let (sum, all) = terms.fold((0.0, 0.0), |(sum, all), x| (sum + x, all + x.abs()));
                error += (sum - lambda * a * h[v]).powi(2) / a;
                size += all * all / a;
            }
            (error / size).sqrt()
        };
        let pairs = basis.vectors.chunks_exact(self.vertices().max(1)).zip(&basis.eigenvalues);
        pairs.take(self.components()).map(residual).fold(0.0, larger)
    }

    fn counts_match(&self, values: &[f64]) -> Result<bool, HarmonicsError> {
        let components = Components::of(self.pencil(), &self.component, Kind::Surface)?;
        let scale = 4.0 * std::f64::consts::PI / self.mass.iter().sum::<f64>();
        let margin = |lambda: f64| ROOM * lambda.max(scale);
        let is_room = |k: usize| match k {
            0 => values[0] > margin(0.0),
            _ => values[k] - values[k - 1] > ROOM * values[k],
        };
        let mut places: Vec<(usize, f64)> = (1..values.len())
            .step_by(STRIDE)
            .filter_map(|from| (from..values.len()).find(|&k| is_room(k)))
            .map(|k| (k, 0.5 * (values[k - 1] + values[k])))
            .collect();
        places.dedup_by_key(|p| p.0);
        // K may cut the last group of equal eigenvalues; just below it no pair is missing, even if it is all that there is.
        if let Some(k) = (0..values.len()).rev().find(|&k| is_room(k)) {
            let middle = 0.5 * (k.checked_sub(1).map_or(0.0, |k| values[k]) + values[k]);
            places.push((k, middle.max(values[k] - margin(values[k]))));
        }
        for (k, lambda) in places {
            if components.count(lambda)? != k {
                return Ok(false);
            }
        }
        // Just above the last pair there are as many eigenvalues as pairs, or more if K cuts a multiple
        // eigenvalue.
        let last = values.last().copied().unwrap_or(0.0);
        Ok(components.count(last + margin(last))? >= values.len())
    }
}
