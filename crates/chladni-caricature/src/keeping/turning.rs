//! Detail that turns with what carries it.

use chladni_harmonics::Basis;
use chladni_mesh::surface::vec3::{Vec3, add, cross, dot, length, scaled, sub, unit};
use chladni_mesh::surface::{Rows, corners, doubled_area_normal};
use rayon::prelude::*;

use crate::{Base, Surface};

/// Where the triangles around a vertex add up to less than this share of their area, they have no common normal.
const CANCELS: f64 = 0.1;

/// The part of `signal` in the first `harmonics`, fading out over the finest of them.
fn smooth_part(basis: &Basis, harmonics: usize, signal: &[Vec3]) -> Vec<Vec3> {
    let mut low = basis.analyze(harmonics, |v| signal[v]);
    let last = low.len().max(1) as f64;
    for (k, c) in low.iter_mut().enumerate() {
        *c = scaled(*c, 1.0 - (k as f64 / last).powi(4));
    }
    basis.synthesize3(&low)
}

/// `displacement` with the detail of the shape and of the displacement carried in the local frames of their smooth
/// parts, which are those of the first `harmonics`: where these turn the surface by R(v), the detail x − x_s + d − d_s is
/// turned by R(v), too. `share` is how far, from 0 to 1, at each vertex.
pub(super) fn turned(
    base: &Base,
    surface: &Surface,
    neighbors: &Rows,
    harmonics: usize,
    displacement: &[Vec3],
    share: Option<&[f32]>,
) -> Vec<Vec3> {
    let basis = base.basis();
    let from = smooth_part(basis, harmonics, &base.positions);
    let smooth = smooth_part(basis, harmonics, displacement);
    let to: Vec<Vec3> = from.par_iter().zip(&smooth).map(|(x, d)| add(*x, *d)).collect();
    let (normals, turned_normals) = (common_normals(surface, &from), common_normals(surface, &to));
    let turned = |(v, d): (usize, &Vec3)| {
        let share = share.map_or(1.0, |share| f64::from(share[v]).clamp(0.0, 1.0));
        let detail = add(sub(base.positions[v], from[v]), sub(*d, smooth[v]));
        let frame = Frame { from: &from, to: &to, normals: [normals[v], turned_normals[v]] };
        let Some(r) = frame.rotation(v, neighbors.row(v)) else { return *d };
        let moved = sub(apply(&r, detail), detail);
        add(*d, scaled(moved, share))
    };
    displacement.par_iter().enumerate().map(turned).collect()
}

/// The unit normals of `surface` with its vertices at `positions`. Zero where the triangles around a vertex nearly cancel,
/// as where a one-sided surface turns over: the least displacement would swing their sum to any side.
fn common_normals(surface: &Surface, positions: &[Vec3]) -> Vec<Vec3> {
    let normal = |v: u32| {
        let (mut sum, mut area) = ([0.0; 3], 0.0);
        for t in surface.triangles_around(v) {
            let normal = doubled_area_normal(corners(positions, &surface.triangles[*t as usize]));
            sum = add(sum, normal);
            area += length(normal);
        }
        if length(sum) > CANCELS * area { unit(sum) } else { [0.0; 3] }
    };
    (0..positions.len() as u32).into_par_iter().map(normal).collect()
}

/// The smooth surface around a vertex before and after.
struct Frame<'a> {
    from: &'a [Vec3],
    to: &'a [Vec3],
    normals: [Vec3; 2],
}

type Matrix = [Vec3; 3];

fn apply(m: &Matrix, v: Vec3) -> Vec3 {
    m.map(|row| dot(row, v))
}

impl Frame<'_> {
    /// The rotation closest to the deformation of the ring around `v`; `None` where it has no area or normal.
    fn rotation(&self, v: usize, ring: &[u32]) -> Option<Matrix> {
        let [n, m] = self.normals;
        if dot(n, n) == 0.0 || dot(m, m) == 0.0 {
            return None;
        }
        let t = unit(cross(n, if n[0].abs() < 0.7 { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] }));
        let b = cross(n, t);
        let (mut tt, mut bb) = ([0.0; 3], [0.0; 3]);
        let (mut aa, mut ab, mut cc) = (0.0, 0.0, 0.0);
        for w in ring {
            let w = *w as usize;
            let (e, f) = (sub(self.from[w], self.from[v]), sub(self.to[w], self.to[v]));
            let (x, y) = (dot(e, t), dot(e, b));
            tt = add(tt, scaled(f, x));
            bb = add(bb, scaled(f, y));
            aa += x * x;
            ab += x * y;
            cc += y * y;
        }
        let det = aa * cc - ab * ab;
        if det <= 1e-9 * (aa + cc) * (aa + cc) {
            return None;
        }
        // The images of t and b under the least-squares Jacobian, on the new tangent plane.
        let jt = scaled(sub(scaled(tt, cc), scaled(bb, ab)), 1.0 / det);
        let jb = scaled(sub(scaled(bb, aa), scaled(tt, ab)), 1.0 / det);
        let flat = |j: Vec3| sub(j, scaled(m, dot(j, m)));
        let (jt, jb) = (flat(jt), flat(jb));
        // The nearest rotation takes t and b to two perpendicular directions in that plane.
        let new_t = unit(add(jt, cross(jb, m)));
        if dot(new_t, new_t) == 0.0 {
            return None;
        }
        let new_b = cross(m, new_t);
        let rows =
            std::array::from_fn(|i| std::array::from_fn(|j| new_t[i] * t[j] + new_b[i] * b[j] + m[i] * n[j]));
        Some(rows)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::bumpy_sphere;
    use chladni_mesh::Frame as Place;
    use chladni_mesh::samples;
    use chladni_mesh::surface::vec3::distance;
    use chladni_mesh::surface::vertex_neighbors;
    use std::sync::Arc;

    #[test]
    fn a_one_sided_surface_has_no_normals_where_it_turns_over() {
        let strip = samples::moebius(0.5, 24, 1);
        let place = Place { center: [0.0; 3], scale: 1.0 };
        let surface = Surface::of(strip.positions.clone(), strip.triangles, place);
        let (common, any) = (common_normals(&surface, &strip.positions), surface.normals(&strip.positions));
        assert_eq!(common[..2], [[0.0; 3]; 2]);
        assert_eq!(common[2..], any[2..]);
    }

    /// A rigid motion of the smooth part takes the detail along.
    #[test]
    fn detail_turns_with_what_carries_it() {
        let (body, surface) = bumpy_sphere();
        let base = Base::new(body.basis.clone(), Arc::new(surface.clone()), body.positions.clone()).unwrap();
        let neighbors = vertex_neighbors(surface.vertices(), &surface.triangles);
        let harmonics = body.basis.harmonics();
        let smooth = smooth_part(&body.basis, harmonics, &body.positions);
        let (sin, cos) = 0.7_f64.sin_cos();
        let turn = |p: Vec3| [cos * p[0] - sin * p[1], sin * p[0] + cos * p[1], p[2]];
        // Only the smooth part is turned; the detail stays behind, as the sum of a filtered signal leaves it.
        let coefficients = body.basis.analyze(harmonics, |v| sub(turn(body.positions[v]), body.positions[v]));
        let displacement = body.basis.synthesize3(&coefficients);
        let result = turned(&base, &surface, &neighbors, harmonics, &displacement, None);
        let whole = |u: &[Vec3]| -> f64 {
            let at = |v: usize| distance(add(body.positions[v], u[v]), turn(body.positions[v]));
            (0..u.len()).map(at).sum::<f64>() / u.len() as f64
        };
        let detail: f64 = (0..smooth.len()).map(|v| distance(body.positions[v], smooth[v])).sum::<f64>()
            / smooth.len() as f64;
        let (before, after) = (whole(&displacement), whole(&result));
        assert!(before > 0.2 * detail && after < 0.5 * before, "{before}, {after}, {detail}");
        let untouched =
            turned(&base, &surface, &neighbors, harmonics, &displacement, Some(&vec![0.0; smooth.len()]));
        assert_eq!(untouched, displacement);
    }
}
