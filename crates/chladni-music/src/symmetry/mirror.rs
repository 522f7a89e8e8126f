//! The plane in which a shape is its own mirror image, and where that mirror takes each vertex.

use chladni_harmonics::Body;
use chladni_mesh::{Rows, vertex_triangles};
use chladni_task::Task;
use kiddo::{ImmutableKdTree, SquaredEuclidean};
use rayon::prelude::*;

use super::SymmetrySettings;
use super::jacobi::symmetric_eigen;
use crate::Error;

/// A distance, a point and the point that its mirror image comes to lie on.
type Pair = (f64, [f64; 3], [f64; 3]);

/// The plane {p : normal · p = offset}, working frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MirrorPlane {
    /// Unit normal; its largest component is positive.
    pub normal: [f64; 3],
    /// Distance from the origin along the normal.
    pub offset: f64,
    /// How far mirrored vertices miss the surface: root mean square over the best nine tenths
    /// of the vertices, as a share of the bounding box's diagonal.
    pub misfit: f64,
}

impl MirrorPlane {
    fn reflect(&self, p: [f64; 3]) -> [f64; 3] {
        let height = 2.0 * (dot(self.normal, p) - self.offset);
        std::array::from_fn(|i| p[i] - height * self.normal[i])
    }
}

/// Where the mirror takes each vertex: a point of a triangle, as corners and weights.
pub(super) type Image = Vec<([u32; 3], [f64; 3])>;

/// Vertices that judge the candidates.
const JUDGES: usize = 600;
/// Candidates that are refined.
const FINALISTS: usize = 6;

/// The best mirror plane, and the mirror as a map of the surface; `None` where no plane fits
/// within the tolerance.
pub(super) fn find(
    body: &Body,
    pairs: &[[u32; 2]],
    settings: &SymmetrySettings,
    task: &Task,
) -> Result<Option<(MirrorPlane, Image)>, Error> {
    let Ok(tree) = ImmutableKdTree::<f64, 3>::new_from_slice(&body.positions) else { return Ok(None) };
    let surface = Surface { body, tree, around: vertex_triangles(body.positions.len(), &body.triangles) };
    let stride = body.positions.len().div_ceil(JUDGES).max(1);
    let judges: Vec<usize> = (0..body.positions.len()).step_by(stride).collect();
    let mut candidates: Vec<MirrorPlane> = candidates(body, pairs)
        .into_par_iter()
        .map(|mut plane| {
            plane.misfit = surface.misfit(&plane, &judges);
            plane
        })
        .collect();
    candidates.sort_by(|a, b| preference(a).total_cmp(&preference(b)));
    let mut best: Option<MirrorPlane> = None;
    for plane in candidates.into_iter().take(FINALISTS) {
        task.check()?;
        let refined = surface.refine(plane, &judges);
        if best.is_none_or(|b| preference(&refined) < preference(&b)) {
            best = Some(refined);
        }
    }
    let Some(best) = best else { return Ok(None) };
    let all: Vec<usize> = (0..body.positions.len()).collect();
    let best = surface.refine(best, &all);
    if best.misfit > settings.plane_tolerance {
        return Ok(None);
    }
    let image = all.par_iter().map(|&v| surface.closest(best.reflect(body.positions[v])).1).collect();
    Ok(Some((best, image)))
}

/// Smaller is better. Where several planes fit about as well (a box, an eight-armed octopus),
/// the one whose normal is nearest to x is what a viewer calls left and right.
fn preference(plane: &MirrorPlane) -> f64 {
    (plane.misfit + 0.002) * (1.5 - 0.5 * plane.normal[0].abs())
}

/// Planes across the pairs, across the axes of inertia and across the coordinate axes, all
/// through the centroid: a mirror keeps the centroid and permutes the axes of inertia.
fn candidates(body: &Body, pairs: &[[u32; 2]]) -> Vec<MirrorPlane> {
    let plane = |normal: [f64; 3]| {
        let length = dot(normal, normal).sqrt();
        (length > 1e-6).then(|| MirrorPlane { normal: normal.map(|c| c / length), offset: 0.0, misfit: 1.0 })
    };
    let mut covariance = vec![vec![0.0; 3]; 3];
    for (p, a) in body.positions.iter().zip(&body.basis.mass) {
        for i in 0..3 {
            for j in 0..3 {
                covariance[i][j] += a * p[i] * p[j];
            }
        }
    }
    let (_, axes) = symmetric_eigen(covariance);
    let from_pairs = pairs.iter().map(|p| {
        let [a, b] = p.map(|v| body.positions[v as usize]);
        std::array::from_fn(|i| a[i] - b[i])
    });
    let axes = (0..3).map(|j| std::array::from_fn(|i| axes[i][j]));
    let coordinates = (0..3).map(|j| std::array::from_fn(|i| f64::from(u8::from(i == j))));
    coordinates.chain(axes).chain(from_pairs).filter_map(plane).collect()
}

struct Surface<'a> {
    body: &'a Body,
    tree: ImmutableKdTree<f64, 3>,
    around: Rows,
}

impl Surface<'_> {
    /// The nearest point among the triangles around the nearest vertex: its squared distance,
    /// corners and weights.
    fn closest(&self, p: [f64; 3]) -> (f64, ([u32; 3], [f64; 3])) {
        let v = self.tree.query(&p).nearest_one::<SquaredEuclidean<f64>>().execute().item as usize;
        let own = v as u32;
        let mut best = (squared(p, self.body.positions[v]), ([own; 3], [1.0, 0.0, 0.0]));
        for &t in self.around.row(v) {
            let corners = self.body.triangles[t as usize];
            let [a, b, c] = corners.map(|v| self.body.positions[v as usize]);
            let weights = closest_on_triangle(p, a, b, c);
            let q = std::array::from_fn(|i| weights[0] * a[i] + weights[1] * b[i] + weights[2] * c[i]);
            let distance = squared(p, q);
            if distance < best.0 {
                best = (distance, (corners, weights));
            }
        }
        best
    }

    fn matches(&self, plane: &MirrorPlane, vertices: &[usize]) -> Vec<Pair> {
        let mut matches: Vec<_> = vertices
            .par_iter()
            .map(|&v| {
                let p = self.body.positions[v];
                let (distance, (corners, weights)) = self.closest(plane.reflect(p));
                let at = corners.map(|v| self.body.positions[v as usize]);
                let q = std::array::from_fn(|i| (0..3).map(|j| weights[j] * at[j][i]).sum());
                (distance, p, q)
            })
            .collect();
        matches.sort_by(|a, b| a.0.total_cmp(&b.0));
        matches.truncate((vertices.len() * 9).div_ceil(10));
        matches
    }

    fn misfit(&self, plane: &MirrorPlane, vertices: &[usize]) -> f64 {
        self.misfit_of(&self.matches(plane, vertices))
    }

    fn misfit_of(&self, matches: &[Pair]) -> f64 {
        let mean = matches.iter().map(|m| m.0).sum::<f64>() / matches.len().max(1) as f64;
        mean.sqrt() / box_diagonal(&self.body.positions)
    }

    /// Iterated closest points over reflections: with p matched to q, the best normal is the
    /// eigenvector of least eigenvalue of Σ (p q^T + q p^T), centred, and the plane passes
    /// through the middle of the two centroids.
    fn refine(&self, plane: MirrorPlane, vertices: &[usize]) -> MirrorPlane {
        let mut best = plane;
        best.misfit = self.misfit(&best, vertices);
        for _ in 0..20 {
            let matches = self.matches(&best, vertices);
            let count = matches.len().max(1) as f64;
            let mean = |f: fn(&Pair) -> [f64; 3]| -> [f64; 3] {
                let mut sum = [0.0; 3];
                for m in &matches {
                    let p = f(m);
                    for i in 0..3 {
                        sum[i] += p[i] / count;
                    }
                }
                sum
            };
            let (center_p, center_q) = (mean(|m| m.1), mean(|m| m.2));
            let mut b = vec![vec![0.0; 3]; 3];
            for (_, p, q) in &matches {
                for i in 0..3 {
                    for j in 0..3 {
                        let (pi, pj) = (p[i] - center_p[i], p[j] - center_p[j]);
                        let (qi, qj) = (q[i] - center_q[i], q[j] - center_q[j]);
                        b[i][j] += pi * qj + qi * pj;
                    }
                }
            }
            let (_, vectors) = symmetric_eigen(b);
            let mut normal: [f64; 3] = std::array::from_fn(|i| vectors[i][2]);
            let largest = normal.iter().copied().fold(0.0, |m: f64, c| if c.abs() > m.abs() { c } else { m });
            if largest < 0.0 {
                normal = normal.map(|c| -c);
            }
            let middle = std::array::from_fn(|i| 0.5 * (center_p[i] + center_q[i]));
            let mut next = MirrorPlane { normal, offset: dot(normal, middle), misfit: 0.0 };
            next.misfit = self.misfit(&next, vertices);
            if next.misfit >= best.misfit * (1.0 - 1e-6) {
                break;
            }
            best = next;
        }
        best
    }
}

/// Barycentric weights of the point of triangle abc closest to p (Ericson 2005, section 5.1.5).
fn closest_on_triangle(p: [f64; 3], a: [f64; 3], b: [f64; 3], c: [f64; 3]) -> [f64; 3] {
    let minus = |u: [f64; 3], v: [f64; 3]| -> [f64; 3] { std::array::from_fn(|i| u[i] - v[i]) };
    let (ab, ac, ap) = (minus(b, a), minus(c, a), minus(p, a));
    let (d1, d2) = (dot(ab, ap), dot(ac, ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return [1.0, 0.0, 0.0];
    }
    let bp = minus(p, b);
    let (d3, d4) = (dot(ab, bp), dot(ac, bp));
    if d3 >= 0.0 && d4 <= d3 {
        return [0.0, 1.0, 0.0];
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 && d1 > d3 {
        let t = d1 / (d1 - d3);
        return [1.0 - t, t, 0.0];
    }
    let cp = minus(p, c);
    let (d5, d6) = (dot(ab, cp), dot(ac, cp));
    if d6 >= 0.0 && d5 <= d6 {
        return [0.0, 0.0, 1.0];
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 && d2 > d6 {
        let t = d2 / (d2 - d6);
        return [1.0 - t, 0.0, t];
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0 && d4 - d3 + d5 - d6 > 0.0 {
        let t = (d4 - d3) / (d4 - d3 + d5 - d6);
        return [0.0, 1.0 - t, t];
    }
    let sum = va + vb + vc;
    if sum > 0.0 { [va / sum, vb / sum, vc / sum] } else { [1.0, 0.0, 0.0] }
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn squared(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|i| (a[i] - b[i]).powi(2)).sum()
}

fn box_diagonal(positions: &[[f64; 3]]) -> f64 {
    f64::from(crate::dancer::box_diagonal(positions)).max(f64::MIN_POSITIVE)
}
