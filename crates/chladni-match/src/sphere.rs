//! Maps a closed genus-0 mesh to the unit sphere.
//!
//! Conformalized mean-curvature flow (Kazhdan, Solomon, Ben-Chen, *Can Mean-Curvature Flow be Modified to
//! be Non-singular?*, SGP 2012): the stiffness matrix stays that of the initial surface while the masses
//! follow the moving one, and the limit is a conformal map to a sphere.

use chladni_task::Task;
use glam::DVec3;

use crate::closed::Closed;
use crate::laplacian::Laplacian;
use crate::{MatchError, Side};

/// The largest number of steps of the flow.
const STEPS: usize = 60;

/// Unit vectors for the points of `closed`, such that every triangle faces outward.
pub(crate) fn onto_sphere(closed: &Closed, side: Side, task: &Task) -> Result<Vec<DVec3>, MatchError> {
    let laplacian = Laplacian::new(&closed.points, &closed.triangles);
    let mut x = closed.points.clone();
    let volume: f64 = closed.triangles.iter().map(|t| orientation(t.map(|v| x[v as usize]))).sum();
    if volume < 0.0 {
        // A surface without a clear inside keeps its winding. Where it faces inward, its mirror image faces outward.
        x.iter_mut().for_each(|p| *p = -*p);
    }
    normalize_area(&mut x, &closed.triangles);
    let stage = task.stage("unfolding onto a sphere", STEPS as u64);
    let mut time_step = 0.01;
    let mut best = (usize::MAX, f64::INFINITY, x.clone());
    let mut stale = 0;
    for _ in 0..STEPS {
        task.check()?;
        let mass = masses(&x, &closed.triangles);
        let b: Vec<DVec3> = x.iter().zip(&mass).map(|(x, m)| *x * *m).collect();
        x = laplacian.solve(&mass, time_step, &b, x, 1e-4);
        normalize_area(&mut x, &closed.triangles);
        stage.advance(1);
        let (folds, uneven) = (folded(&x, closed).len(), unevenness(&x, &mass));
        // The limit is a sphere only up to Möbius maps, and the discrete flow drifts along them. Keep the
        // roundest surface without folds, as seen from its center.
        if (folds, uneven) < (best.0, best.1) {
            best = (folds, uneven, x.clone());
            stale = 0;
        } else {
            stale += 1;
        }
        if best.0 == 0 && (best.1 < 0.02 || stale >= 5) {
            break;
        }
        time_step = (time_step * 1.15_f64).min(0.1);
    }
    let mut x = best.2;
    for p in &mut x {
        *p = p.try_normalize().unwrap_or(DVec3::Z);
    }
    untangle(&mut x, closed, &laplacian);
    center(&mut x, closed);
    untangle(&mut x, closed, &laplacian);
    let folded = folded(&x, closed).len();
    if folded * 100 > closed.triangles.len() {
        return Err(MatchError::NoCommonDomain {
            side,
            problem: format!("{folded} of {} triangles fold over on the sphere", closed.triangles.len()),
        });
    }
    Ok(x)
}

/// Mean deviation of the radius from its mean, relative to the mean.
fn unevenness(x: &[DVec3], mass: &[f64]) -> f64 {
    let total: f64 = mass.iter().sum();
    let mean = x.iter().zip(mass).map(|(p, m)| p.length() * m).sum::<f64>() / total;
    x.iter().zip(mass).map(|(p, m)| m * (p.length() - mean).abs()).sum::<f64>() / (total * mean)
}

/// Moves the centroid of the area to the origin and scales the total area to 1.
fn normalize_area(x: &mut [DVec3], triangles: &[[u32; 3]]) {
    let mass = masses(x, triangles);
    let area: f64 = mass.iter().sum();
    let middle: DVec3 = x.iter().zip(&mass).map(|(p, m)| *p * *m).sum::<DVec3>() / area;
    let scale = 1.0 / area.sqrt();
    for p in x.iter_mut() {
        *p = (*p - middle) * scale;
    }
}

fn masses(x: &[DVec3], triangles: &[[u32; 3]]) -> Vec<f64> {
    let mut mass = vec![1e-12; x.len()];
    for t in triangles {
        let [a, b, c] = t.map(|v| x[v as usize]);
        let third = (b - a).cross(c - a).length() / 6.0;
        t.iter().for_each(|v| mass[*v as usize] += third);
    }
    mass
}

/// Six times the signed volume of the tetrahedron of the triangle and the center: positive if the triangle
/// faces outward.
pub(crate) fn orientation([a, b, c]: [DVec3; 3]) -> f64 {
    a.dot(b.cross(c))
}

fn folded(x: &[DVec3], closed: &Closed) -> Vec<usize> {
    (0..closed.triangles.len())
        .filter(|t| !(orientation(closed.triangles[*t].map(|v| x[v as usize])) > 0.0))
        .collect()
}

/// Moves the vertices of folded triangles, and more and more of those around them, to the mean of their
/// neighbors.
fn untangle(x: &mut [DVec3], closed: &Closed, laplacian: &Laplacian) {
    let mut active = vec![false; x.len()];
    for _ in 0..100 {
        let folded = folded(x, closed);
        if folded.is_empty() {
            return;
        }
        for t in folded {
            for v in closed.triangles[t] {
                active[v as usize] = true;
                laplacian.row(v as usize).iter().for_each(|(w, _)| active[*w as usize] = true);
            }
        }
        for _ in 0..10 {
            for v in (0..x.len()).filter(|v| active[*v]) {
                // With equal weights, the mean lies among the neighbors.
                let sum: DVec3 = laplacian.row(v).iter().map(|(w, _)| x[*w as usize]).sum();
                x[v] = sum.try_normalize().unwrap_or(x[v]);
            }
        }
    }
}

/// Applies the Möbius map that moves the surface's centroid of area to the center of the sphere (Baden,
/// Crane, Kazhdan, *Möbius Registration*, SGP 2018), by Newton steps through inversions.
fn center(x: &mut [DVec3], closed: &Closed) {
    let area = masses(&closed.points, &closed.triangles);
    let total: f64 = area.iter().sum();
    for _ in 0..50 {
        let mean: DVec3 = x.iter().zip(&area).map(|(p, a)| *p * *a).sum::<DVec3>() / total;
        if mean.length() < 1e-6 {
            return;
        }
        let outer: f64 = 2.0 / 3.0; // the Jacobian 2(I − E[xxᵀ]) for points all around
        let c = (mean * -(0.5 / outer)).clamp_length_max(0.5);
        let keep = 1.0 - c.length_squared();
        for p in x.iter_mut() {
            // Inversion about c, then back: conformal, sphere to sphere.
            let d = *p + c;
            *p = (d * (keep / d.length_squared()) + c).normalize_or(*p);
        }
    }
}

#[cfg(test)]
mod tests {
    use chladni_mesh::samples;

    use super::*;
    use crate::surface::UnitSurface;

    #[test]
    fn a_surface_lands_facing_outward_whichever_way_it_faces() {
        let mut mesh = samples::icosphere(3);
        mesh.positions.iter_mut().for_each(|p| *p = [1.5 * p[0], p[1] + 0.2 * p[0] * p[0], p[2]]);
        for _ in 0..2 {
            let surface = UnitSurface::new(&mesh, Side::Shape).unwrap();
            let closed = Closed::new(&surface, Side::Shape).unwrap();
            let x = onto_sphere(&closed, Side::Shape, &Task::new()).unwrap();
            assert!(folded(&x, &closed).is_empty());
            mesh.triangles.iter_mut().for_each(|t| t.swap(0, 1));
        }
    }
}
