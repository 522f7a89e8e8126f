//! How surfaces bend: curvature tensors at vertices, and averages that take the noise of a scan out of them.

use rayon::prelude::*;

use super::vec3::{Vec3, add, cross, distance, dot, length, scaled, sub, unit};
use super::{Rows, corners, doubled_area_normal, vertex_normals_around};

/// A symmetric 3×3 matrix: xx, xy, xz, yy, yz, zz. As the curvature at a point it is II on the tangent plane and 0
/// along the normal, in 1 / length, positive where the surface is convex.
pub type Tensor = [f64; 6];

/// T x.
pub fn times([xx, xy, xz, yy, yz, zz]: Tensor, x: Vec3) -> Vec3 {
    [dot([xx, xy, xz], x), dot([xy, yy, yz], x), dot([xz, yz, zz], x)]
}

/// s (a bᵀ + b aᵀ) / 2.
fn product(a: Vec3, b: Vec3, s: f64) -> Tensor {
    let of = |i: usize, j: usize| 0.5 * s * (a[i] * b[j] + a[j] * b[i]);
    [of(0, 0), of(0, 1), of(0, 2), of(1, 1), of(1, 2), of(2, 2)]
}

fn plus(a: Tensor, b: Tensor) -> Tensor {
    std::array::from_fn(|i| a[i] + b[i])
}

/// The principal values and directions of a [`Tensor`] in the plane at right angles to a normal.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Principal {
    /// Its values, the greater first: the principal curvatures κ₁ ≥ κ₂ of a curvature tensor.
    pub values: [f64; 2],
    /// Their directions, unit, at right angles to the normal and to each other; their signs are arbitrary.
    pub directions: [Vec3; 2],
}

impl Principal {
    /// The values and directions of `tensor` at right angles to `normal`, which is unit or zero.
    pub fn of(tensor: Tensor, normal: Vec3) -> Self {
        let least = (0..3).min_by(|i, j| normal[*i].abs().total_cmp(&normal[*j].abs())).unwrap_or(0);
        let u = unit(cross(normal, std::array::from_fn(|i| f64::from(u8::from(i == least)))));
        let v = cross(normal, u);
        let (tu, tv) = (times(tensor, u), times(tensor, v));
        let (a, b, c) = (dot(u, tu), dot(u, tv), dot(v, tv));
        let angle = 0.5 * (2.0 * b).atan2(a - c);
        let (middle, half) = (0.5 * (a + c), (0.5 * (a - c)).hypot(b));
        let (sin, cos) = angle.sin_cos();
        let along = |x: f64, y: f64| add(scaled(u, x), scaled(v, y));
        Self { values: [middle + half, middle - half], directions: [along(cos, sin), along(-sin, cos)] }
    }

    /// The tensor with the same directions and |values|.
    pub fn magnitude(&self) -> Tensor {
        let [a, b] = self.values;
        let [d, e] = self.directions;
        plus(product(d, d, a.abs()), product(e, e, b.abs()))
    }
}

/// For each vertex the third of its triangles' areas, in squared units of `positions`.
pub fn vertex_areas(positions: &[Vec3], triangles: &[[u32; 3]]) -> Vec<f64> {
    let mut areas = vec![0.0; positions.len()];
    for triangle in triangles {
        let third = length(doubled_area_normal(corners(positions, triangle))) / 6.0;
        triangle.iter().for_each(|v| areas[*v as usize] += third);
    }
    areas
}

/// The curvature tensor of each vertex, from how its triangles' `normals` (one a vertex, unit) turn along their edges
/// (Rusinkiewicz, "Estimating curvatures and their derivatives on triangle meshes", 2004). `around` is the surface's
/// [`vertex_triangles`](super::vertex_triangles). Zero where no triangle has an area.
///
/// # Panics
/// If a triangle names a vertex that is not there, or `around` is of another surface.
pub fn curvature_tensors(
    positions: &[Vec3],
    triangles: &[[u32; 3]],
    normals: &[Vec3],
    around: &Rows,
) -> Vec<Tensor> {
    let bends: Vec<Option<Bend>> = triangles
        .par_iter()
        .map(|t| Bend::of(corners(positions, t), t.map(|v| normals[v as usize])))
        .collect();
    let tensor = |v: usize| {
        let (mut sum, mut weights) = ([0.0; 6], 0.0);
        for &t in around.row(v) {
            let Some(bend) = &bends[t as usize] else { continue };
            let corner = triangles[t as usize].iter().position(|w| *w as usize == v).unwrap_or(0);
            let weight = bend.shares[corner];
            if let Some(turned) = bend.turned(normals[v]) {
                sum = plus(sum, turned.map(|x| x * weight));
                weights += weight;
            }
        }
        if weights > 0.0 { sum.map(|x| x / weights) } else { sum }
    };
    (0..positions.len()).into_par_iter().map(tensor).collect()
}

/// The second fundamental form of one triangle: a u², b u v, c v² in its own plane.
struct Bend {
    frame: [Vec3; 3],
    form: [f64; 3],
    /// The area nearest to each corner.
    shares: [f64; 3],
}

impl Bend {
    /// Least squares over the three edges, along each of which the normal turns as the form says.
    fn of(at: [Vec3; 3], normals: [Vec3; 3]) -> Option<Self> {
        let normal = doubled_area_normal(at);
        let edges: [Vec3; 3] = std::array::from_fn(|i| sub(at[(i + 2) % 3], at[(i + 1) % 3]));
        let (n, u) = (unit(normal), unit(edges[0]));
        let v = cross(n, u);
        let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
        let mut right = [0.0; 3];
        for (i, edge) in edges.into_iter().enumerate() {
            let turn = sub(normals[(i + 2) % 3], normals[(i + 1) % 3]);
            let (x, y) = (dot(edge, u), dot(edge, v));
            let (p, q) = (dot(turn, u), dot(turn, v));
            (xx, xy, yy) = (xx + x * x, xy + x * y, yy + y * y);
            right = add(right, [x * p, y * p + x * q, y * q]);
        }
        let form = solved(xx, xy, yy, right)?;
        Some(Self { frame: [u, v, n], form, shares: nearest_areas(at) })
    }

    /// As a tensor, with the triangle's plane turned the short way into that of `normal`; `None` where they face
    /// opposite ways.
    fn turned(&self, normal: Vec3) -> Option<Tensor> {
        let [u, v, n] = self.frame;
        let both = add(n, normal);
        let whole = 1.0 + dot(n, normal);
        let turn = |x: Vec3| sub(x, scaled(both, dot(normal, x) / whole));
        let (u, v) = (turn(u), turn(v));
        let [a, b, c] = self.form;
        let tensor = plus(plus(product(u, u, a), product(u, v, 2.0 * b)), product(v, v, c));
        (whole > 0.1).then_some(tensor)
    }
}

/// Solves the symmetric [xx xy 0; xy xx+yy xy; 0 xy yy] z = r; `None` for a triangle without area.
fn solved(xx: f64, xy: f64, yy: f64, r: Vec3) -> Option<Vec3> {
    let middle = xx + yy;
    // By Cramer's rule; the determinant is (xx + yy)(xx yy − xy²).
    let determinant = middle * (xx * yy - xy * xy);
    let [p, q, s] = r;
    let a = p * (middle * yy - xy * xy) - q * xy * yy + s * xy * xy;
    let b = xx * (q * yy - s * xy) - p * xy * yy;
    let c = s * (xx * middle - xy * xy) - xx * xy * q + xy * xy * p;
    (determinant > 1e-14 * middle * middle * middle).then(|| [a, b, c].map(|x| x / determinant))
}

/// The area of a triangle nearest to each of its corners (Meyer et al., "Discrete differential-geometry operators",
/// 2003).
fn nearest_areas(at: [Vec3; 3]) -> Vec3 {
    let area = 0.5 * length(doubled_area_normal(at));
    let squared: Vec3 = std::array::from_fn(|i| distance(at[(i + 1) % 3], at[(i + 2) % 3]).powi(2));
    let total: f64 = squared.iter().sum();
    if let Some(wide) = (0..3).find(|i| 2.0 * squared[*i] > total) {
        return std::array::from_fn(|i| if i == wide { 0.5 * area } else { 0.25 * area });
    }
    let cotangent = |i: usize| (total - 2.0 * squared[i]) / (4.0 * area);
    std::array::from_fn(|i| {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        (squared[j] * cotangent(j) + squared[k] * cotangent(k)) / 8.0
    })
}

/// The gradient at each vertex of a function that is linear on each triangle: the mean of its triangles', by area.
/// Per unit of `positions`, one entry a vertex. `around` is the surface's
/// [`vertex_triangles`](super::vertex_triangles).
///
/// # Panics
/// As [`curvature_tensors`].
pub fn vertex_gradients(
    positions: &[Vec3],
    triangles: &[[u32; 3]],
    values: &[f64],
    around: &Rows,
) -> Vec<Vec3> {
    // Twice the area times the gradient is n × Σ f_i e_i, e_i the edge across from corner i.
    let faces: Vec<(Vec3, f64)> = triangles
        .par_iter()
        .map(|t| {
            let at = corners(positions, t);
            let normal = doubled_area_normal(at);
            let sum = (0..3).fold([0.0; 3], |sum, i| {
                add(sum, scaled(sub(at[(i + 2) % 3], at[(i + 1) % 3]), values[t[i] as usize]))
            });
            (cross(unit(normal), sum), length(normal))
        })
        .collect();
    let gradient = |v: usize| {
        let row = around.row(v).iter().map(|t| faces[*t as usize]);
        let (sum, area) = row.fold(([0.0; 3], 0.0), |(sum, area), (g, a)| (add(sum, g), area + a));
        if area > 0.0 { scaled(sum, 1.0 / area) } else { sum }
    };
    (0..positions.len()).into_par_iter().map(gradient).collect()
}

/// Replaces `passes` times each vertex' value by the mean, by `areas`, of its own and its `neighbors`'
/// ([`vertex_neighbors`](super::vertex_neighbors)). On even triangles with edges ℓ, p passes are a Gaussian of
/// standard deviation 0.65 ℓ √p.
///
/// # Panics
/// If the three are not of one surface.
pub fn averaged<const D: usize>(
    mut values: Vec<[f64; D]>,
    neighbors: &Rows,
    areas: &[f64],
    passes: usize,
) -> Vec<[f64; D]> {
    for _ in 0..passes {
        let mean = |v: usize| {
            let ring = neighbors.row(v).iter().map(|w| *w as usize).chain([v]);
            let (mut sum, mut total) = ([0.0; D], 0.0);
            for w in ring {
                sum = std::array::from_fn(|i| sum[i] + areas[w] * values[w][i]);
                total += areas[w];
            }
            if total > 0.0 { sum.map(|x| x / total) } else { values[v] }
        };
        values = (0..values.len()).into_par_iter().map(mean).collect();
    }
    values
}

/// Passes of averaging, at most: dense meshes are smoothed less far than asked for.
const MOST_PASSES: usize = 100;

/// How many passes of [`averaged`] reach `share` of the size √(A/π) of a surface with these vertex `areas`, or 100 where
/// it would take more.
pub fn averaging_passes(areas: &[f64], share: f64) -> usize {
    let area: f64 = areas.iter().sum();
    // A vertex of a mesh of equilateral triangles has √3/2 ℓ² of the area.
    let edge = (area / areas.len().max(1) as f64 / 0.866).sqrt();
    let size = (area / std::f64::consts::PI).sqrt();
    ((share * size / (0.65 * edge)).powi(2).ceil() as usize).min(MOST_PASSES)
}

/// Unit normals and the [`curvature_tensors`] that follow from them, both [`averaged`]. `around` is the surface's
/// [`vertex_triangles`](super::vertex_triangles).
///
/// # Panics
/// As [`curvature_tensors`] and [`averaged`].
pub fn averaged_curvature(
    positions: &[Vec3],
    triangles: &[[u32; 3]],
    areas: &[f64],
    around: &Rows,
    neighbors: &Rows,
    passes: usize,
) -> (Vec<Vec3>, Vec<Tensor>) {
    let normals = vertex_normals_around(positions, triangles, around);
    let mut normals = averaged(normals, neighbors, areas, passes);
    normals.iter_mut().for_each(|n| *n = unit(*n));
    let tensors = curvature_tensors(positions, triangles, &normals, around);
    let tensors = averaged(tensors, neighbors, areas, passes);
    (normals, tensors)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;
    use crate::samples;
    use crate::surface::{vertex_neighbors, vertex_triangles};

    /// A tube about z where `ring` 0, else a torus about z of that radius; its tube's radius is 0.5. Positions,
    /// triangles, normals and for each vertex its angle around the tube.
    fn tube(ring: f64, around: usize, along: usize) -> (Vec<Vec3>, Vec<[u32; 3]>, Vec<Vec3>, Vec<f64>) {
        let (mut positions, mut normals, mut angles) = (Vec::new(), Vec::new(), Vec::new());
        for i in 0..along {
            for j in 0..around {
                let (a, b) = (TAU * j as f64 / around as f64, TAU * i as f64 / along as f64);
                let (n, p) = if ring > 0.0 {
                    let n = [a.cos() * b.cos(), a.cos() * b.sin(), a.sin()];
                    (n, add(scaled(n, 0.5), [ring * b.cos(), ring * b.sin(), 0.0]))
                } else {
                    let n = [a.cos(), a.sin(), 0.0];
                    (n, [0.5 * n[0], 0.5 * n[1], b])
                };
                positions.push(p);
                normals.push(n);
                angles.push(a);
            }
        }
        let at = |i: usize, j: usize| (i % along * around + j % around) as u32;
        let mut triangles = Vec::new();
        for i in 0..if ring > 0.0 { along } else { along - 1 } {
            for j in 0..around {
                let [a, b, c, d] = [at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)];
                triangles.extend(if ring > 0.0 { [[a, c, b], [a, d, c]] } else { [[a, b, c], [a, c, d]] });
            }
        }
        (positions, triangles, normals, angles)
    }

    #[test]
    fn a_sphere_bends_alike_everywhere_and_every_way() {
        let mut ball = samples::icosphere(3);
        let normals = ball.positions.clone();
        ball.positions.iter_mut().for_each(|p| *p = scaled(*p, 3.0));
        let around = vertex_triangles(normals.len(), &ball.triangles);
        let tensors = curvature_tensors(&ball.positions, &ball.triangles, &normals, &around);
        for (tensor, n) in tensors.into_iter().zip(normals) {
            let Principal { values, directions: [d, e] } = Principal::of(tensor, n);
            values.into_iter().for_each(|k| assert!((k - 1.0 / 3.0).abs() < 1e-3, "{k}"));
            assert!(dot(d, e).abs() < 1e-12 && dot(d, n).abs() < 1e-12 && (length(d) - 1.0).abs() < 1e-12);
            assert!(length(times(tensor, n)) < 1e-12);
        }
    }

    #[test]
    fn a_cylinder_bends_around_and_not_along() {
        let (positions, triangles, normals, _) = tube(0.0, 64, 30);
        let around = vertex_triangles(positions.len(), &triangles);
        let tensors = curvature_tensors(&positions, &triangles, &normals, &around);
        for (tensor, n) in tensors.into_iter().zip(normals) {
            let Principal { values: [a, b], directions } = Principal::of(tensor, n);
            assert!((a - 2.0).abs() < 2e-3 && b.abs() < 1e-9, "{a} {b}");
            assert!((directions[1][2].abs() - 1.0).abs() < 1e-6);
        }
    }

    #[test]
    fn a_torus_has_its_principal_curvatures_and_the_error_falls_with_the_edges() {
        let error = |n: usize| {
            let (positions, triangles, normals, angles) = tube(1.5, n, 3 * n);
            let around = vertex_triangles(positions.len(), &triangles);
            let tensors = curvature_tensors(&positions, &triangles, &normals, &around);
            let worst = tensors.into_iter().zip(&normals).zip(angles).map(|((tensor, n), angle)| {
                let known = [2.0, angle.cos() / (1.5 + 0.5 * angle.cos())];
                let found = Principal::of(tensor, *n).values;
                (found[0] - known[0]).abs().max((found[1] - known[1]).abs())
            });
            worst.fold(0.0, f64::max)
        };
        let (coarse, fine) = (error(16), error(32));
        assert!(coarse < 0.05 && fine < 0.35 * coarse, "{coarse} {fine}");
    }

    #[test]
    fn the_gradient_of_a_linear_function_is_its_slope_along_the_surface() {
        let (positions, triangles, normals, _) = tube(1.5, 40, 120);
        let slope = [0.3, -1.0, 2.0];
        let values: Vec<f64> = positions.iter().map(|p| dot(*p, slope)).collect();
        let around = vertex_triangles(positions.len(), &triangles);
        let found = vertex_gradients(&positions, &triangles, &values, &around);
        for (g, n) in found.into_iter().zip(normals) {
            assert!(distance(g, sub(slope, scaled(n, dot(n, slope)))) < 0.02);
        }
    }

    #[test]
    fn averages_keep_what_is_constant_and_take_away_noise() {
        let ball = samples::icosphere(3);
        let neighbors = vertex_neighbors(ball.positions.len(), &ball.triangles);
        let areas = vertex_areas(&ball.positions, &ball.triangles);
        let constant = averaged(vec![[2.0]; areas.len()], &neighbors, &areas, 5);
        assert!(constant.iter().all(|[x]| (x - 2.0).abs() < 1e-12));
        let rough: Vec<[f64; 1]> = (0..areas.len()).map(|v| [if v % 2 == 0 { 1.0 } else { -1.0 }]).collect();
        let spread = |values: &[[f64; 1]]| values.iter().map(|[x]| x * x).sum::<f64>() / values.len() as f64;
        assert!(spread(&averaged(rough.clone(), &neighbors, &areas, 4)) < 0.1 * spread(&rough));
    }
}
