//! Checks a basis again, from its numbers alone.

use std::ops::RangeInclusive;

use super::components::{Components, Kind};
use crate::basis::larger;
use crate::{Basis, Certificate, HarmonicsError, Operator};

/// The number of pairs between two counts.
const STRIDE: usize = 50;
/// Neighboring eigenvalues that differ by less than this share are too close to count between them.
const ROOM: f64 = 1e-6;

/// A λ at which eigenvalues are counted.
struct Place {
    lambda: f64,
    /// What the count must be.
    count: RangeInclusive<usize>,
    /// How far the nearest pair is.
    room: f64,
}

impl Place {
    /// Between pair number `k` and the one below it: in the middle, or no farther than `reach` from pair `k`.
    fn below(values: &[f64], k: usize, reach: f64) -> Self {
        let (low, high) = (k.checked_sub(1).map_or(0.0, |k| values[k]), values[k]);
        let lambda = (0.5 * (low + high)).max(high - reach);
        Self { lambda, count: k..=k, room: (lambda - low).min(high - lambda) }
    }
}

impl Operator {
    /// Checks `basis` against this operator, whichever solver computed it. Counts eigenvalues by inertia
    /// below every fiftieth pair, below the last group of equal ones, and above the last pair, and measures
    /// every residual and every scalar product. Residuals of constants, where ‖S h‖ is 0, are shares of a bound
    /// on the eigenvalues.
    ///
    /// [`inertia_counts_match`](Certificate::inertia_counts_match) is `Some(true)` if all counts are as the pairs say, and
    /// `Some(false)` if one differs that rounding cannot have changed: a pair is missing, doubled or in another place.
    /// `None` means that it cannot be decided, since counts differ only within 10⁻¹³ of the largest eigenvalue from a pair,
    /// which rounding may blur. Slivers can make that larger than the first eigenvalues.
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
        certificate.inertia_counts_match = self.counts_match(&basis.eigenvalues)?;
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

    fn counts_match(&self, values: &[f64]) -> Result<Option<bool>, HarmonicsError> {
        let components = Components::of(self.pencil(), &self.component, Kind::Surface)?;
        let scale = 4.0 * std::f64::consts::PI / self.mass.iter().sum::<f64>();
        let resolved = components.resolved();
        let mut verdict = Some(true);
        for Place { lambda, count, room } in places(values, scale, resolved) {
            if !count.contains(&components.count(lambda)?) {
                if room > resolved {
                    return Ok(Some(false));
                }
                verdict = None;
            }
        }
        Ok(verdict)
    }
}

/// Where to count to find out whether `values` are the first eigenvalues; `scale` is about the first that is not 0, and
/// rounding moves no count by more than `resolved`.
fn places(values: &[f64], scale: f64, resolved: f64) -> Vec<Place> {
    let margin = |lambda: f64| ROOM * lambda.max(scale);
    let is_room = |k: usize| match k {
        0 => values[0] > margin(0.0),
        _ => values[k] - values[k - 1] > ROOM * values[k],
    };
    let mut between: Vec<usize> = (1..values.len())
        .step_by(STRIDE)
        .filter_map(|from| (from..values.len()).find(|&k| is_room(k)))
        .collect();
    between.dedup();
    let mut places: Vec<Place> =
        between.into_iter().map(|k| Place::below(values, k, f64::INFINITY)).collect();
    // K may cut the last group of equal eigenvalues; just below it no pair is missing, even if it is all that there is.
    if let Some(k) = (0..values.len()).rev().find(|&k| is_room(k)) {
        places.push(Place::below(values, k, margin(values[k])));
    }
    // Rounding may blur that count, and the last that it cannot blur refutes more.
    let is_wide = |k: usize| values[k] - k.checked_sub(1).map_or(0.0, |k| values[k]) > 4.0 * resolved;
    if let Some(k) = (0..values.len()).rev().find(|&k| is_room(k) && is_wide(k))
        && places.last().is_some_and(|last| last.room <= resolved)
    {
        places.push(Place::below(values, k, margin(values[k]).max(2.0 * resolved)));
    }
    // Just above the last pair there are as many eigenvalues as pairs, or more if K cuts a multiple eigenvalue.
    let last = values.last().copied().unwrap_or(0.0);
    places.push(Place { lambda: last + margin(last), count: values.len()..=usize::MAX, room: margin(last) });
    places
}

#[cfg(test)]
mod tests {
    use chladni_mesh::samples;

    use super::*;
    use crate::SymmetricSparse;

    #[test]
    fn counts_refute_nothing_that_rounding_may_have_changed() {
        // Two beads that a stiff spring joins, and a third on a soft one.
        let stiff = 1e14;
        let entries = [(0, 0, stiff), (1, 1, stiff + 1.0), (2, 2, 1.0), (0, 1, -stiff), (1, 2, -1.0)];
        let operator = Operator {
            stiffness: SymmetricSparse::from_entries(3, entries).unwrap(),
            mass: vec![1.0; 3],
            component: vec![0; 3],
            ..Operator::of(&samples::icosphere(0)).unwrap()
        };
        let counts_match = |values: &[f64]| operator.counts_match(values).unwrap();
        // The two move as one, up to a share of 10⁻¹⁴.
        assert_eq!(counts_match(&[0.0, 1.5, 2.0 * stiff + 0.5]), Some(true));
        // Only the first of these is an eigenvalue, but beside the largest there is no telling.
        assert_eq!(counts_match(&[0.0, 0.1, 0.2]), None);
        // 1.5 or 0 is missing, and counts far from any pair say so.
        assert_eq!(counts_match(&[0.0, 1e3, 2.0 * stiff + 0.5]), Some(false));
        assert_eq!(counts_match(&[0.0, 2.0 * stiff + 0.5]), Some(false));
        assert_eq!(counts_match(&[1.5, 2.0 * stiff + 0.5]), Some(false));
    }
}
