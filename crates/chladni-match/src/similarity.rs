//! Similarities x ↦ s R x + t, and the best one between pairs of points.

use chladni_mesh::symmetric_eigen;
use glam::{DMat3, DVec3};

use crate::MatchError;

/// x ↦ s R x + t, with s > 0 and R a proper rotation (never a reflection).
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Similarity {
    /// s, positive.
    pub scale: f64,
    /// R, by rows; det R = 1.
    pub rotation: [[f64; 3]; 3],
    /// t.
    pub translation: [f64; 3],
}

/// Whether a fit may change the size.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Scaling {
    /// s is fitted.
    #[default]
    Free,
    /// s = 1: a rigid motion.
    Rigid,
}

impl Similarity {
    /// x ↦ x.
    pub const IDENTITY: Self = Self {
        scale: 1.0,
        rotation: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        translation: [0.0; 3],
    };

    pub(crate) fn new(scale: f64, rotation: DMat3, translation: DVec3) -> Self {
        Self { scale, rotation: rotation.transpose().to_cols_array_2d(), translation: translation.to_array() }
    }

    pub(crate) fn rotation_matrix(&self) -> DMat3 {
        DMat3::from_cols_array_2d(&self.rotation).transpose()
    }

    pub(crate) fn at(&self, point: DVec3) -> DVec3 {
        self.rotation_matrix() * point * self.scale + DVec3::from_array(self.translation)
    }

    /// Computes s R x + t.
    pub fn apply(&self, point: [f64; 3]) -> [f64; 3] {
        self.at(DVec3::from_array(point)).to_array()
    }

    /// The inverse similarity.
    pub fn inverse(&self) -> Self {
        let rotation = self.rotation_matrix().transpose();
        let scale = 1.0 / self.scale;
        Self::new(scale, rotation, rotation * DVec3::from_array(self.translation) * -scale)
    }

    /// The composition: first `self`, then `next`.
    pub fn then(&self, next: &Self) -> Self {
        Self::new(
            self.scale * next.scale,
            next.rotation_matrix() * self.rotation_matrix(),
            next.at(DVec3::from_array(self.translation)),
        )
    }

    /// The 4×4 matrix [sR t; 0 1], by rows.
    pub fn to_matrix(&self) -> [[f64; 4]; 4] {
        let row = |r: usize| {
            let [a, b, c] = self.rotation[r].map(|x| x * self.scale);
            [a, b, c, self.translation[r]]
        };
        [row(0), row(1), row(2), [0.0, 0.0, 0.0, 1.0]]
    }

    /// The similarity that minimizes Σ w ‖s R from + t − to‖² (Umeyama, PAMI 1991).
    ///
    /// R is found from the leading eigenvector of Horn's quaternion matrix (JOSA A 1987), which gives the
    /// proper rotation of Umeyama's SVD solution. Weights are ≥ 0; without weights, all are 1.
    ///
    /// # Errors
    /// Fewer than three pairs, lists of different lengths, or points on one line.
    pub fn fit(
        from: &[[f64; 3]],
        to: &[[f64; 3]],
        weights: Option<&[f64]>,
        scaling: Scaling,
    ) -> Result<Self, MatchError> {
        if from.len() != to.len() {
            return Err(MatchError::LengthsDiffer {
                what: "points to align",
                left: from.len(),
                right: to.len(),
            });
        }
        if let Some(w) = weights
            && w.len() != from.len()
        {
            return Err(MatchError::LengthsDiffer {
                what: "points and their weights",
                left: from.len(),
                right: w.len(),
            });
        }
        let pairs =
            from.iter().zip(to).enumerate().map(|(i, (a, b))| {
                (DVec3::from_array(*a), DVec3::from_array(*b), weights.map_or(1.0, |w| w[i]))
            });
        fit_pairs(pairs, scaling)
    }
}

/// [`Similarity::fit`] for pairs given as (from, to, weight).
pub(crate) fn fit_pairs(
    pairs: impl Iterator<Item = (DVec3, DVec3, f64)> + Clone,
    scaling: Scaling,
) -> Result<Similarity, MatchError> {
    let (mut count, mut total, mut a0, mut b0) = (0, 0.0, DVec3::ZERO, DVec3::ZERO);
    for (a, b, w) in pairs.clone() {
        count += usize::from(w > 0.0);
        total += w;
        a0 += a * w;
        b0 += b * w;
    }
    if count < 3 {
        return Err(MatchError::TooFewPairs(count));
    }
    a0 /= total;
    b0 /= total;
    let (mut covariance, mut spread_a, mut spread_b) = (DMat3::ZERO, 0.0, 0.0);
    for (a, b, w) in pairs {
        let (a, b) = (a - a0, b - b0);
        covariance += DMat3::from_cols(b * (a.x * w), b * (a.y * w), b * (a.z * w));
        spread_a += w * a.length_squared();
        spread_b += w * b.length_squared();
    }
    // m(r, c) = Σ w a_r b_c, Horn's S.
    let m = |r: usize, c: usize| covariance.col(r)[c];
    let horn = [
        [m(0, 0) + m(1, 1) + m(2, 2), m(1, 2) - m(2, 1), m(2, 0) - m(0, 2), m(0, 1) - m(1, 0)],
        [m(1, 2) - m(2, 1), m(0, 0) - m(1, 1) - m(2, 2), m(0, 1) + m(1, 0), m(2, 0) + m(0, 2)],
        [m(2, 0) - m(0, 2), m(0, 1) + m(1, 0), m(1, 1) - m(0, 0) - m(2, 2), m(1, 2) + m(2, 1)],
        [m(0, 1) - m(1, 0), m(2, 0) + m(0, 2), m(1, 2) + m(2, 1), m(2, 2) - m(0, 0) - m(1, 1)],
    ];
    let (values, vectors) = symmetric_eigen(horn);
    let size = (spread_a * spread_b).sqrt();
    // If the two leading eigenvalues are equal, a whole circle of rotations fits equally well.
    if !(values[0] - values[1] > size * 1e-12) || !size.is_finite() {
        return Err(MatchError::Degenerate);
    }
    let [w, x, y, z] = vectors[0];
    let rotation = DMat3::from_quat(glam::DQuat::from_xyzw(x, y, z, w).normalize());
    let scale = match scaling {
        Scaling::Free => values[0] / spread_a,
        Scaling::Rigid => 1.0,
    };
    if !(scale > 0.0 && scale.is_finite()) {
        return Err(MatchError::Degenerate);
    }
    Ok(Similarity::new(scale, rotation, b0 - rotation * a0 * scale))
}

/// Like [`fit_pairs`]; if `scale` is given, s has that value.
pub(crate) fn fit_pairs_at(
    pairs: impl Iterator<Item = (DVec3, DVec3, f64)> + Clone,
    scale: Option<f64>,
) -> Result<Similarity, MatchError> {
    let Some(scale) = scale else { return fit_pairs(pairs, Scaling::Free) };
    let rigid = fit_pairs(pairs.map(|(a, b, w)| (a * scale, b, w)), Scaling::Rigid)?;
    Ok(Similarity { scale, ..rigid })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn point() -> impl Strategy<Value = [f64; 3]> {
        [-1.0..1.0, -1.0..1.0, -1.0..1.0]
    }

    proptest! {
        #[test]
        fn a_known_similarity_is_recovered(
            points in prop::collection::vec(point(), 5..20),
            axis in point(), angle in -3.1..3.1f64, log_scale in -5.0..5.0f64, shift in point(),
        ) {
            let axis = DVec3::from_array(axis);
            prop_assume!(axis.length() > 0.1);
            let truth = Similarity::new(
                log_scale.exp(), DMat3::from_axis_angle(axis.normalize(), angle),
                DVec3::from_array(shift) * 10.0,
            );
            let moved: Vec<_> = points.iter().map(|p| truth.apply(*p)).collect();
            let Ok(found) = Similarity::fit(&points, &moved, None, Scaling::Free) else {
                return Ok(()); // points drawn in one line
            };
            for (p, q) in points.iter().zip(&moved) {
                let r = found.apply(*p);
                for i in 0..3 {
                    prop_assert!((r[i] - q[i]).abs() < 1e-7 * truth.scale.max(1.0), "{r:?} {q:?}");
                }
            }
            let back = found.then(&found.inverse());
            let p = back.apply([1.0, 2.0, 3.0]);
            prop_assert!((p[0] - 1.0).abs() + (p[1] - 2.0).abs() + (p[2] - 3.0).abs() < 1e-9);
        }

        #[test]
        fn reflections_are_refused(points in prop::collection::vec(point(), 6..20)) {
            let mirrored: Vec<_> = points.iter().map(|p| [-p[0], p[1], p[2]]).collect();
            if let Ok(s) = Similarity::fit(&points, &mirrored, None, Scaling::Free) {
                prop_assert!((s.rotation_matrix().determinant() - 1.0).abs() < 1e-12);
                prop_assert!(s.scale > 0.0);
            }
        }
    }

    #[test]
    fn points_in_one_line_are_refused() {
        let line = [[0.0; 3], [1.0, 1.0, 1.0], [2.0, 2.0, 2.0], [3.0, 3.0, 3.0]];
        assert_eq!(Similarity::fit(&line, &line, None, Scaling::Free), Err(MatchError::Degenerate));
        assert_eq!(
            Similarity::fit(&line[..2], &line[..2], None, Scaling::Free),
            Err(MatchError::TooFewPairs(2))
        );
    }
}
