//! Points on a surface.

use serde::{Deserialize, Serialize};

use super::vec3::{Vec3, add, dot, scaled, sub};

/// A point on a surface of triangles: in a triangle, on its edge where one weight is 0, at its corner where two are.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SurfacePoint {
    /// The triangle, < m.
    pub triangle: u32,
    /// Barycentric weights of its corners; they sum to 1.
    pub weights: Vec3,
}

impl SurfacePoint {
    /// Corner `corner` < 3 of `triangle`.
    pub fn at_corner(triangle: u32, corner: usize) -> Self {
        Self { triangle, weights: std::array::from_fn(|i| f64::from(u8::from(i == corner))) }
    }

    /// Where the point lies with every vertex where `at` puts it; `None` where there is no such triangle.
    pub fn position(&self, triangles: &[[u32; 3]], at: impl Fn(u32) -> Vec3) -> Option<Vec3> {
        Some(mixed(triangles.get(self.triangle as usize)?.map(at), self.weights))
    }
}

/// Σ w_i x_i over the corners of a triangle.
pub fn mixed(at: [Vec3; 3], weights: Vec3) -> Vec3 {
    add(add(scaled(at[0], weights[0]), scaled(at[1], weights[1])), scaled(at[2], weights[2]))
}

/// The point of triangle `[a, b, c]` closest to `p`, and its barycentric weights (Ericson, *Real-Time Collision
/// Detection*, 5.1.5), which are not negative. A triangle without area gives a point of its longest edge.
pub fn closest_on_triangle(p: Vec3, &[a, b, c]: &[Vec3; 3]) -> (Vec3, Vec3) {
    let along = |from: Vec3, way: Vec3, t: f64| add(from, scaled(way, t));
    let (ab, ac, ap) = (sub(b, a), sub(c, a), sub(p, a));
    let (d1, d2) = (dot(ab, ap), dot(ac, ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return (a, [1.0, 0.0, 0.0]);
    }
    let bp = sub(p, b);
    let (d3, d4) = (dot(ab, bp), dot(ac, bp));
    if d3 >= 0.0 && d4 <= d3 {
        return (b, [0.0, 1.0, 0.0]);
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 && d1 > d3 {
        let t = d1 / (d1 - d3);
        return (along(a, ab, t), [1.0 - t, t, 0.0]);
    }
    let cp = sub(p, c);
    let (d5, d6) = (dot(ab, cp), dot(ac, cp));
    if d6 >= 0.0 && d5 <= d6 {
        return (c, [0.0, 0.0, 1.0]);
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 && d2 > d6 {
        let t = d2 / (d2 - d6);
        return (along(a, ac, t), [1.0 - t, 0.0, t]);
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 >= d3 && d5 >= d6 && (d4 - d3) + (d5 - d6) > 0.0 {
        let t = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        return (along(b, sub(c, b), t), [0.0, 1.0 - t, t]);
    }
    let total = va + vb + vc;
    // Nor where it is NaN.
    if total.partial_cmp(&0.0) != Some(std::cmp::Ordering::Greater) {
        return (a, [1.0, 0.0, 0.0]);
    }
    let (v, w) = (vb / total, vc / total);
    let weights = [1.0 - v - w, v, w];
    if weights.iter().all(|weight| *weight >= 0.0) {
        return (add(along(a, ab, v), scaled(ac, w)), weights);
    }
    // Rounding can lead out of a sliver.
    let within = weights.map(|weight| weight.max(0.0));
    let weights = within.map(|weight| weight / within.iter().sum::<f64>());
    (mixed([a, b, c], weights), weights)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::surface::vec3::distance;

    fn vector() -> impl Strategy<Value = Vec3> {
        [-1.0..1.0, -1.0..1.0, -1.0..1.0]
    }

    #[test]
    fn a_point_of_a_surface_lies_where_its_triangle_is() {
        let positions = [[0.0; 3], [4.0, 0.0, 0.0], [0.0, 8.0, 0.0]];
        let triangles = [[0, 1, 2]];
        let place = |point: SurfacePoint| point.position(&triangles, |v| positions[v as usize]);
        assert_eq!(place(SurfacePoint { triangle: 0, weights: [0.25, 0.5, 0.25] }), Some([2.0, 2.0, 0.0]));
        assert_eq!(place(SurfacePoint::at_corner(0, 2)), Some(positions[2]));
        assert_eq!(place(SurfacePoint::at_corner(1, 0)), None);
    }

    #[test]
    fn above_inside_edge_and_corner_the_closest_point_is_known() {
        let triangle = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        for (p, closest) in [
            ([0.25, 0.25, 3.0], [0.25, 0.25, 0.0]),
            ([0.5, -2.0, 1.0], [0.5, 0.0, 0.0]),
            ([1.0, 1.0, 0.0], [0.5, 0.5, 0.0]),
            ([3.0, -1.0, 0.5], [1.0, 0.0, 0.0]),
        ] {
            assert_eq!(closest_on_triangle(p, &triangle).0, closest);
        }
    }

    proptest! {
        #[test]
        fn no_other_point_of_the_triangle_is_closer(
            t in [vector(), vector(), vector()], q in vector(), u in 0.0..1.0_f64, v in 0.0..1.0_f64,
        ) {
            let (closest, weights) = closest_on_triangle(q, &t);
            let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
            let sample = mixed(t, [1.0 - u - v, u, v]);
            prop_assert!(distance(q, closest) <= distance(q, sample) + 1e-9);
            prop_assert!(distance(mixed(t, weights), closest) < 1e-12);
            prop_assert!(weights.iter().all(|w| *w >= 0.0) && (weights.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        }

        #[test]
        fn the_closest_point_of_a_sliver_lies_in_it(
            a in vector(), b in vector(), off in vector(), share in -0.5..1.5_f64, thinness in -18..-4_i32, q in vector(),
        ) {
            let c = add(mixed([a, b, a], [1.0 - share, share, 0.0]), scaled(off, 10f64.powi(thinness)));
            for triangle in [[a, b, c], [b, c, a], [c, b, a]] {
                let (closest, weights) = closest_on_triangle(q, &triangle);
                prop_assert!(weights.iter().all(|w| *w >= 0.0), "{:?}", weights);
                prop_assert!((weights.iter().sum::<f64>() - 1.0).abs() < 1e-12);
                prop_assert!(distance(mixed(triangle, weights), closest) < 1e-12);
            }
        }
    }
}
