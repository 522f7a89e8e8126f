//! How steeply a movement bends the surface: where its gradient is large a triangle turns over, however small
//! the displacement.

use chladni_harmonics::Body;
use chladni_mesh::surface::vec3::{dot, sub};

/// Least ratio of height to length; narrower triangles have no meaningful gradient.
const LEAST_ASPECT: f64 = 1e-3;

/// A triangle of the rest shape on which gradients are taken.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Patch {
    pub corners: [u32; 3],
    /// In the unit of the positions, squared.
    pub area: f64,
    /// Inverse Gram matrix of the two edges from corner 0: g₁₁, g₁₂, g₂₂.
    metric: [f32; 3],
}

impl Patch {
    /// About `most` triangles of `body`, evenly among all that have an area.
    pub fn among(body: &Body, most: usize) -> Vec<Self> {
        let step = body.triangles.len().div_ceil(most.max(1)).max(1);
        body.triangles.iter().step_by(step).filter_map(|&t| Self::of(&body.positions, t)).collect()
    }

    pub fn of(positions: &[[f64; 3]], corners: [u32; 3]) -> Option<Self> {
        let [a, b, c] = corners.map(|v| positions[v as usize]);
        let (e, f) = (sub(b, a), sub(c, a));
        let (ee, ef, ff) = (dot(e, e), dot(e, f), dot(f, f));
        let determinant = ee * ff - ef * ef;
        let has_area = determinant > (LEAST_ASPECT * (ee + ff)).powi(2);
        has_area.then(|| Self {
            corners,
            area: 0.5 * determinant.sqrt(),
            metric: [ff, -ef, ee].map(|g| (g / determinant) as f32),
        })
    }

    /// ∇u of a movement of the three corners, as two vectors in the triangle's plane whose squares add up to
    /// that of [`steepness`](Self::steepness).
    pub fn gradient(&self, u: [[f32; 3]; 3]) -> [[f32; 3]; 2] {
        let [d, e] = [u[1], u[2]].map(|p| [0, 1, 2].map(|i| p[i] - u[0][i]));
        // Cholesky: g₁₁ d² + 2 g₁₂ d·e + g₂₂ e² = |a d + b e|² + |c e|².
        let [g11, g12, g22] = self.metric;
        let a = g11.max(0.0).sqrt();
        let b = if a > 0.0 { g12 / a } else { 0.0 };
        let c = (g22 - b * b).max(0.0).sqrt();
        [[0, 1, 2].map(|i| a * d[i] + b * e[i]), e.map(|e| c * e)]
    }

    /// ‖∇u‖, the root of the sum of its squares, of a movement of the three corners. Where it is below 1
    /// nothing turns over.
    pub fn steepness(&self, u: [[f32; 3]; 3]) -> f32 {
        let [d, e] = [u[1], u[2]].map(|p| [0, 1, 2].map(|i| p[i] - u[0][i]));
        let dot = |u: [f32; 3], v: [f32; 3]| u[0] * v[0] + u[1] * v[1] + u[2] * v[2];
        let [g11, g12, g22] = self.metric;
        (g11 * dot(d, d) + 2.0 * g12 * dot(d, e) + g22 * dot(e, e)).max(0.0).sqrt()
    }
}

/// The steepness that at most one in 50 of `patches` exceed where vertex v moves by `field(v)`, so that a few
/// sliver triangles of a scan do not limit the rest; and the steepest patch.
pub(crate) fn steepness(patches: &[Patch], field: impl Fn(u32) -> [f32; 3]) -> (f32, Option<Patch>) {
    let mut all: Vec<(f32, usize)> =
        patches.iter().enumerate().map(|(i, p)| (p.steepness(p.corners.map(&field)), i)).collect();
    all.sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    let exceeding = all.get(all.len() / 50).map_or(0.0, |s| s.0);
    (exceeding, all.first().map(|&(_, i)| patches[i]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stretch_is_as_steep_as_it_is_long_on_any_triangle() {
        let positions = [[0.1, 0.0, 0.3], [1.3, 0.2, 0.3], [0.4, 0.9, 0.3]];
        let patch = Patch::of(&positions, [0, 1, 2]).unwrap();
        // x grows by 30 %, y by 40 %.
        let moved = positions.map(|p| [0.3 * p[0] as f32, 0.4 * p[1] as f32, 0.0]);
        assert!((patch.steepness(moved) - 0.5).abs() < 1e-6);
        let [along, across] = patch.gradient(moved);
        let squares: f32 = along.iter().chain(&across).map(|x| x * x).sum();
        assert!((squares.sqrt() - patch.steepness(moved)).abs() < 1e-5);
        assert_eq!(patch.steepness([[0.7, 0.1, 0.2]; 3]), 0.0);
        assert!(Patch::of(&[[0.0; 3], [1.0, 0.0, 0.0], [2.0, 1e-5, 0.0]], [0, 1, 2]).is_none());
    }
}
