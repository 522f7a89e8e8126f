//! Heat flow on a body: one implicit step of the heat equation, a smoothing that does not overshoot.

use std::sync::Arc;

use crate::laplacian::{MOLLIFY, delaunay_laplacian};
use crate::ldlt::{Factor, Symbolic, Workspace, nested_dissection};
use crate::operator::check_corners;
use crate::{Body, HarmonicsError, SymmetricSparse};

/// The Laplacian of a body in elimination order, shared by steps of every length.
pub struct HeatFlow {
    symbolic: Symbolic,
    /// S, in elimination order.
    stiffness: SymmetricSparse,
    /// a(v), in elimination order.
    mass: Vec<f64>,
}

/// An extra mass of every vertex, as a share of its diagonal value. It makes sure that a component is
/// leveled even if the step is so long, or the component so small, that rounding swallows the vertex's own
/// mass.
const LEAST_MASS: f64 = 4e-15;

/// One implicit Euler step of length t: u = (M + tS)⁻¹ M f, factored once for any number of signals f.
///
/// S has no positive value off the diagonal, and its rows sum to zero. M + tS is therefore an M-matrix, and
/// (M + tS)⁻¹ M computes averages: u lies between the smallest and the largest value of f, without
/// overshoot, for any t. Harmonic k is multiplied by 1 / (1 + tλ_k).
pub struct HeatStep {
    flow: Arc<HeatFlow>,
    /// t.
    time: f64,
    factor: Factor,
    /// 1 / √(a + tS_vv) in elimination order, with which the matrix is scaled to a unit diagonal before it
    /// is factored.
    scale: Vec<f64>,
    /// The reciprocal of the step applied to 1, by operator vertex. It is 1 up to rounding, which is not
    /// negligible on a component a billionth of the shape's size: there all weights are off by a common factor.
    inverse_ones: Vec<f64>,
}

impl std::fmt::Debug for HeatFlow {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("HeatFlow").field("vertices", &self.mass.len()).finish_non_exhaustive()
    }
}

impl std::fmt::Debug for HeatStep {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("HeatStep").field("vertices", &self.scale.len()).finish_non_exhaustive()
    }
}

impl HeatFlow {
    /// Builds the Laplacian of `body` again and computes its elimination order. This is about ten times the
    /// work of factoring a step, done once for steps of every length.
    ///
    /// # Errors
    /// Those of [`on_surface`](Self::on_surface).
    pub fn of(body: &Body) -> Result<Self, HarmonicsError> {
        Self::on_surface(&body.positions, &body.triangles)
    }

    /// The same from the N positions of a body, in its working frame, and its triangles.
    ///
    /// # Errors
    /// [`HarmonicsError::NoTriangle`] if no triangle has three different corners; [`HarmonicsError::IndexOutOfRange`] for a
    /// corner that is not there; [`HarmonicsError::NotOnSurface`] for a position that no triangle with three different corners uses.
    pub fn on_surface(positions: &[[f64; 3]], triangles: &[[u32; 3]]) -> Result<Self, HarmonicsError> {
        let vertices = positions.len();
        check_corners(triangles, vertices)?;
        let whole = |[a, b, c]: &&[u32; 3]| a != b && b != c && c != a;
        let triangles: Vec<[u32; 3]> = triangles.iter().filter(whole).copied().collect();
        if triangles.is_empty() {
            return Err(HarmonicsError::NoTriangle);
        }
        let mut is_used = vec![false; vertices];
        triangles.as_flattened().iter().for_each(|v| is_used[*v as usize] = true);
        if let Some(vertex) = is_used.iter().position(|is_used| !is_used) {
            let reason = "no triangle uses it";
            return Err(HarmonicsError::NotOnSurface { vertex, vertices, reason });
        }
        let (stiffness, mass) = delaunay_laplacian(positions, &triangles, MOLLIFY)?;
        Ok(Self::on(&stiffness, &mass))
    }

    /// The flow of a Laplacian without positive values off the diagonal.
    pub(crate) fn on(stiffness: &SymmetricSparse, mass: &[f64]) -> Self {
        let symbolic = Symbolic::of(stiffness, nested_dissection(stiffness));
        let stiffness = stiffness.permuted_and_scaled(&symbolic.old, &vec![1.0; mass.len()]);
        let mass = symbolic.old.iter().map(|v| mass[*v as usize]).collect();
        Self { symbolic, stiffness, mass }
    }

    /// N, the number of operator vertices.
    pub fn vertices(&self) -> usize {
        self.mass.len()
    }

    /// The step of length `time`, in squared units of the working frame.
    ///
    /// # Errors
    /// [`HarmonicsError::HeatStep`] if `time` is not a number ≥ 0, or too large to compute with.
    pub fn step(self: &Arc<Self>, time: f64) -> Result<HeatStep, HarmonicsError> {
        if !(time.is_finite() && time >= 0.0) {
            return Err(HarmonicsError::HeatStep { time });
        }
        let (matrix, scale) = self.scaled(time);
        let mut factor = Factor::default();
        factor
            .compute(&self.symbolic, &matrix, 0.0, &mut Workspace::default())
            .map_err(|_| HarmonicsError::HeatStep { time })?;
        let mut step = HeatStep { flow: self.clone(), time, factor, scale, inverse_ones: Vec::new() };
        let ones = step.solve(|v| step.flow.mass[v]);
        if !ones.iter().all(|x| x.is_finite() && *x > 0.0) {
            return Err(HarmonicsError::HeatStep { time });
        }
        step.inverse_ones = ones.iter().map(|x| x.recip()).collect();
        Ok(step)
    }

    /// D (M + tS) D with a unit diagonal, and D. Pivots are then relative to their surroundings, however
    /// different the sizes of the triangles are.
    fn scaled(&self, time: f64) -> (SymmetricSparse, Vec<f64>) {
        let stiffness = &self.stiffness;
        let diagonal = |j: usize| stiffness.column(j).find(|(i, _)| *i == j).map_or(0.0, |(_, v)| v);
        let scale: Vec<f64> =
            self.mass.iter().enumerate().map(|(j, a)| (a + time * diagonal(j)).sqrt().recip()).collect();
        let mut matrix = stiffness.clone();
        for j in 0..self.vertices() {
            for at in stiffness.column_starts[j]..stiffness.column_starts[j + 1] {
                let i = stiffness.rows[at] as usize;
                matrix.values[at] = if i == j {
                    1.0 + LEAST_MASS
                } else {
                    // Symmetric to the last bit, because the two scales are multiplied first.
                    (scale[i] * scale[j]) * (time * stiffness.values[at])
                };
            }
        }
        (matrix, scale)
    }
}

impl HeatStep {
    /// u = (M + tS)⁻¹ M f for a signal f with one value per operator vertex. Equal signals give equal bits,
    /// for any number of threads.
    ///
    /// # Panics
    /// If `signal` does not have one value per operator vertex.
    pub fn apply(&self, signal: &[f32]) -> Vec<f64> {
        assert_eq!(signal.len(), self.inverse_ones.len(), "one value per operator vertex");
        let old = |i: usize| self.flow.symbolic.old[i] as usize;
        let smooth = self.solve(|i| self.flow.mass[i] * f64::from(signal[old(i)]));
        smooth.iter().zip(&self.inverse_ones).map(|(x, one)| x * one).collect()
    }

    /// t, in squared units of the working frame.
    pub(crate) fn time(&self) -> f64 {
        self.time
    }

    /// (M + tS)⁻¹ b for a right-hand side b by operator vertex.
    pub(crate) fn solve_for(&self, right: &[f64]) -> Vec<f64> {
        self.solve(|i| right[self.flow.symbolic.old[i] as usize])
    }

    /// D (D (M + tS) D)⁻¹ D b by operator vertex, for a b in elimination order. The result is nowhere
    /// negative if b is not: L of an M-matrix has no positive value off the diagonal, and nothing is ever
    /// subtracted.
    fn solve(&self, right: impl Fn(usize) -> f64) -> Vec<f64> {
        let symbolic = &self.flow.symbolic;
        let places = || symbolic.old.iter().zip(&self.scale);
        let mut x: Vec<f64> = self.scale.iter().enumerate().map(|(i, d)| d * right(i)).collect();
        self.factor.solve_one(symbolic, &mut x);
        let mut smooth = vec![0.0; x.len()];
        for ((v, d), x) in places().zip(x) {
            smooth[*v as usize] = d * x;
        }
        smooth
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{BasisSettings, Operator};
    use chladni_mesh::{TriMesh, samples};
    use chladni_task::Task;

    fn body(mesh: &TriMesh, harmonics: usize) -> Body {
        Body::build(mesh, &BasisSettings::new(harmonics), &Task::new()).unwrap()
    }

    /// Long thin triangles, three sheets at one edge, an open rim, and a tiny component far away.
    fn hard() -> TriMesh {
        let mut positions: Vec<[f64; 3]> = Vec::new();
        let mut triangles = Vec::new();
        for i in 0..40_u32 {
            let x = f64::from(i) * 0.05;
            positions.extend([[x, 0.0, 0.0], [x + 0.9, 0.01, 0.0], [x, 0.5, 0.3], [x, -0.5, 0.3]]);
            if i > 0 {
                let v = 4 * i;
                for side in 1..4 {
                    triangles.extend([[v - 4, v, v - 4 + side], [v, v + side, v - 4 + side]]);
                }
            }
        }
        let v = positions.len() as u32;
        positions.extend([[5.0, 0.0, 0.0], [5.0 + 1e-5, 0.0, 0.0], [5.0, 1e-5, 0.0]]);
        triangles.push([v, v + 1, v + 2]);
        TriMesh { positions, triangles, ..TriMesh::default() }
    }

    #[test]
    fn it_is_the_operator_that_the_basis_was_solved_for() {
        for mesh in [samples::icosphere(2), hard()] {
            let body = body(&mesh, 12);
            let (flow, operator) = (HeatFlow::of(&body).unwrap(), Operator::of(&mesh).unwrap());
            for (i, v) in flow.symbolic.old.iter().enumerate() {
                assert_eq!(flow.mass[i].to_bits(), operator.mass[*v as usize].to_bits());
                assert_eq!(flow.mass[i].to_bits(), body.basis.mass[*v as usize].to_bits());
            }
        }
    }

    #[test]
    fn a_step_multiplies_each_harmonic_by_its_gain() {
        let body = body(&samples::icosphere(3), 40);
        let flow = Arc::new(HeatFlow::of(&body).unwrap());
        let signal: Vec<f32> = body.positions.iter().map(|p| f32::from(u8::from(p[0] > 0.3))).collect();
        let plain: Vec<f64> = signal.iter().map(|x| f64::from(*x)).collect();
        let before = body.basis.transform(&plain);
        for time in [0.0, 1e-3, 0.1, 10.0] {
            let after = body.basis.transform(&flow.step(time).unwrap().apply(&signal));
            for (k, lambda) in body.basis.eigenvalues.iter().enumerate() {
                assert!((after[k] - before[k] / (1.0 + time * lambda)).abs() < 1e-12, "{k} at {time}");
            }
        }
    }

    #[test]
    fn the_maximum_principle_holds_at_every_length_of_step() {
        for mesh in [samples::sample("head").unwrap(), hard()] {
            let body = body(&mesh, 2);
            let flow = Arc::new(HeatFlow::of(&body).unwrap());
            assert!((0..flow.vertices()).all(|j| flow.stiffness.column(j).all(|(i, s)| i == j || s <= 0.0)));
            // A checkerboard of spots: the opposite of a smooth signal.
            let spots = |v: usize| f32::from(u8::from((v * 2_654_435_761) >> 7 & 3 == 0));
            let n = body.positions.len();
            for signal in [(0..n).map(spots).collect(), vec![1.0; n]] {
                for time in [1e-9, 1e-4, 1e-2, 1.0, 1e3, 1e9] {
                    let smooth = flow.step(time).unwrap().apply(&signal);
                    let (low, high) =
                        smooth.iter().fold((f64::MAX, f64::MIN), |(l, h), x| (l.min(*x), h.max(*x)));
                    assert!(low >= 0.0 && high <= 1.0 + 1e-12, "{low} to {high} at {time}");
                    let constant = signal.iter().all(|x| *x == 1.0);
                    assert!(!constant || low >= 1.0 - 1e-12, "{low} at {time}");
                }
            }
        }
    }

    #[test]
    fn a_corner_that_is_not_there_and_a_position_without_triangle_are_refused() {
        let ball = samples::icosphere(1);
        let refused = HeatFlow::on_surface(&ball.positions, &[[0, 1, 2], [0, 1, 99]]).unwrap_err();
        assert_eq!(refused, HarmonicsError::IndexOutOfRange { triangle: 1, vertex: 99, vertices: 42 });
        let more = [&ball.positions[..], &[[2.0; 3]]].concat();
        let refused = HeatFlow::on_surface(&more, &ball.triangles).unwrap_err();
        assert!(matches!(refused, HarmonicsError::NotOnSurface { vertex: 42, .. }), "{refused}");
    }

    #[test]
    fn no_step_is_taken_over_no_time_at_all_or_for_ever() {
        let flow = Arc::new(HeatFlow::of(&body(&samples::icosphere(1), 4)).unwrap());
        for time in [-1.0, f64::NAN, f64::INFINITY, f64::MAX] {
            assert!(matches!(flow.step(time), Err(HarmonicsError::HeatStep { .. })), "{time}");
        }
    }
}
