//! A smooth flow of the sphere that moves landmarks to their partners.

use chladni_task::Task;
use faer::linalg::solvers::Solve;
use glam::DVec3;
use rayon::prelude::*;

use crate::MatchError;

/// Steps of the flow.
const STEPS: usize = 80;
/// Widths of the kernels in radians, wide ones first.
const WIDTHS: [f64; 3] = [1.2, 0.6, 0.3];

/// Moves all points `x` by a flow that takes the points `from[i]` to `to[i]` (all are unit vectors).
///
/// Each step follows a smooth velocity field, the least sum of Gaussians that moves the landmarks along
/// their great circles. A flow of smooth fields is one to one (Joshi and Miller, *Landmark matching via
/// large deformation diffeomorphisms*, 2000), up to the size of the steps.
pub(crate) fn carry(x: &mut [DVec3], from: &[DVec3], to: &[DVec3], task: &Task) -> Result<(), MatchError> {
    let mut at = from.to_vec();
    let stage = task.stage("carrying landmarks", (WIDTHS.len() * STEPS) as u64);
    for (pass, width) in WIDTHS.into_iter().enumerate() {
        // Wide fields cover most of the distance, narrow ones the rest.
        let share = if pass + 1 == WIDTHS.len() { 1.0 } else { 0.7 };
        for step in 0..STEPS {
            task.check()?;
            let left = (STEPS - step) as f64;
            let velocity: Vec<DVec3> =
                at.iter().zip(to).map(|(p, q)| toward(*p, *q) * (share / left).min(1.0)).collect();
            let momenta = momenta(&at, &velocity, width)?;
            let field = |p: DVec3| -> DVec3 {
                let v: DVec3 = at.iter().zip(&momenta).map(|(q, m)| *m * kernel(p, *q, width)).sum();
                v - p * p.dot(v)
            };
            x.par_iter_mut().for_each(|p| *p = (*p + field(*p)).normalize_or(*p));
            at = at.iter().map(|p| (*p + field(*p)).normalize_or(*p)).collect();
            stage.advance(1);
        }
    }
    Ok(())
}

fn kernel(p: DVec3, q: DVec3, width: f64) -> f64 {
    ((p.dot(q) - 1.0) / (width * width)).exp()
}

/// The tangent vector at `p` toward `q`, with the length of the arc between them.
fn toward(p: DVec3, q: DVec3) -> DVec3 {
    let flat = q - p * p.dot(q);
    flat.normalize_or_zero() * p.angle_between(q)
}

/// The momenta m whose field has the given tangent velocities: Σ_j P_i K(p_i, p_j) m_j = v_i, where m_j is
/// tangent at p_j.
fn momenta(at: &[DVec3], velocity: &[DVec3], width: f64) -> Result<Vec<DVec3>, MatchError> {
    let n = at.len();
    let frames: Vec<[DVec3; 2]> = at
        .iter()
        .map(|p| {
            let (a, b) = p.any_orthonormal_pair();
            [a, b]
        })
        .collect();
    let matrix = faer::Mat::from_fn(2 * n, 2 * n, |r, c| {
        let k = kernel(at[r / 2], at[c / 2], width);
        let ridge = if r == c { 1e-6 } else { 0.0 };
        k * frames[r / 2][r % 2].dot(frames[c / 2][c % 2]) + ridge
    });
    let right = faer::Mat::from_fn(2 * n, 1, |r, _| frames[r / 2][r % 2].dot(velocity[r / 2]));
    let factor = matrix.llt(faer::Side::Lower).map_err(|_| MatchError::Solver("landmark flow"))?;
    let m = factor.solve(&right);
    Ok((0..n).map(|i| frames[i][0] * m[(2 * i, 0)] + frames[i][1] * m[(2 * i + 1, 0)]).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn landmarks_arrive_and_nothing_folds() {
        let mesh = chladni_mesh::samples::icosphere(4);
        let mut x: Vec<DVec3> = mesh.positions.iter().map(|p| DVec3::from_array(*p).normalize()).collect();
        let picks = [3, 40, 200, 500, 900];
        let from: Vec<DVec3> = picks.iter().map(|i| x[*i]).collect();
        let to: Vec<DVec3> = from
            .iter()
            .enumerate()
            .map(|(i, p)| (*p + DVec3::new(0.5, -0.3 * i as f64, 0.4)).normalize())
            .collect();
        carry(&mut x, &from, &to, &Task::new()).unwrap();
        for (i, q) in picks.iter().zip(&to) {
            assert!(x[*i].angle_between(*q) < 1e-3, "{}", x[*i].angle_between(*q));
        }
        let folded = mesh
            .triangles
            .iter()
            .filter(|t| crate::sphere::orientation(t.map(|v| x[v as usize])) <= 0.0)
            .count();
        assert_eq!(folded, 0);
    }
}
