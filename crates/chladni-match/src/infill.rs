//! Fills in the difference from its surroundings where a match is not trusted.

use chladni_mesh::TriMesh;
use glam::DVec3;

use crate::laplacian::Laplacian;
use crate::surface::UnitSurface;
use crate::{Correspondence, MatchError, Side};

/// Up to this confidence a point has no weight; from [`TRUSTED`] on it has full weight.
const DOUBTED: f64 = 0.25;
const TRUSTED: f64 = 0.5;
/// The length, in diagonals, at which a point of medium weight and its surroundings count equally.
const LENGTH: f64 = 0.02;

/// The points of a correspondence, with the untrusted ones filled in.
#[derive(Clone, Debug, PartialEq)]
pub struct Infill {
    /// x^r(v), n points in the shape file's coordinates.
    pub target: Vec<[f64; 3]>,
    /// The share of the shape's area that was filled in, weighted by the degree to which it was.
    pub share: f64,
}

/// Fills in the difference x^r − x where `found` is not trusted: on parts without a counterpart on the
/// template, such as hair, and on parts beyond its edge, such as a neck that it lacks. There the difference
/// continues that of its surroundings as smoothly as possible (it is harmonic). A piece of the shape
/// without any trusted point stays where it is. Points with confidence ½ or more are not changed. `None` if
/// these are all.
///
/// # Errors
/// A shape without a surface, or a correspondence with another number of vertices.
pub fn infilled(shape: &TriMesh, found: &Correspondence) -> Result<Option<Infill>, MatchError> {
    let (left, right) = (shape.positions.len(), found.vertices());
    if left != right {
        return Err(MatchError::LengthsDiffer {
            what: "vertices of the shape and of the correspondence",
            left,
            right,
        });
    }
    let surface = UnitSurface::new(shape, Side::Shape)?;
    let n = surface.points.len();
    let (mut delta, mut trust) = (vec![DVec3::ZERO; n], vec![1.0; n]);
    for (v, point) in surface.point_of_vertex.iter().enumerate() {
        if let Some(point) = point {
            let point = *point as usize;
            delta[point] = surface.in_frame(found.target[v]) - surface.points[point];
            trust[point] = smooth_step((found.confidence[v] - DOUBTED) / (TRUSTED - DOUBTED));
        }
    }
    let doubted: f64 = surface.areas.iter().zip(&trust).map(|(a, t)| a * (1.0 - t)).sum();
    if doubted <= 0.0 {
        return Ok(None);
    }
    fill(&surface, &trust, &mut delta);
    let target = shape.positions.iter().zip(&surface.point_of_vertex).zip(&found.target);
    let target = target.map(|((_, point), as_found)| match point {
        Some(point) if trust[*point as usize] < 1.0 => {
            let point = *point as usize;
            surface.to_file(surface.points[point] + delta[point]).to_array()
        }
        _ => *as_found,
    });
    Ok(Some(Infill { target: target.collect(), share: doubted / surface.area() }))
}

/// Leaves each vertex of `shape` where it is that no triangle uses and that has no partner: the closest point means nothing
/// for a vertex off the surface.
pub(crate) fn rest_off_surface(shape: &TriMesh, confidence: &[f64], target: &mut [[f64; 3]]) {
    let mut used = vec![false; target.len()];
    shape.triangles.as_flattened().iter().for_each(|v| used[*v as usize] = true);
    for (v, own) in shape.positions.iter().enumerate() {
        if !used[v] && confidence[v] == 0.0 {
            target[v] = *own;
        }
    }
}

/// Minimizes Σ W ‖d − x^δ‖² + ℓ² ‖∇d‖² over the points that are not fully trusted, with W = a t/(1 − t):
/// trusted points keep their difference, and without trust only smoothness counts.
fn fill(surface: &UnitSurface, trust: &[f64], delta: &mut [DVec3]) {
    let all = Laplacian::new(&surface.points, &surface.triangles);
    let free: Vec<u32> = (0..trust.len() as u32).filter(|v| trust[*v as usize] < 1.0).collect();
    let alpha = LENGTH * LENGTH;
    let mut weights = Vec::with_capacity(free.len());
    let mut right = Vec::with_capacity(free.len());
    for &v in &free {
        let (t, area) = (trust[v as usize], surface.areas[v as usize]);
        let weight = area * (t / (1.0 - t)).min(1e3);
        // The last term holds pieces in place that are otherwise free.
        weights.push(weight + 1e-7 * area);
        let held = all.row(v as usize).iter().filter(|(u, _)| trust[*u as usize] >= 1.0);
        let pull: DVec3 = held.map(|(u, s)| delta[*u as usize] * *s).sum();
        right.push(delta[v as usize] * weight + pull * alpha);
    }
    let solved = all.among(&free).solve(&weights, alpha, &right, vec![DVec3::ZERO; free.len()], 1e-5);
    for (v, d) in free.iter().zip(solved) {
        if d.is_finite() {
            delta[*v as usize] = d;
        }
    }
}

fn smooth_step(t: f64) -> f64 {
    let t = t.clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}
