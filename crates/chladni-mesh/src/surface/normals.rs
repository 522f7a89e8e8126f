//! Areas and normals.

use rayon::prelude::*;

use super::Rows;
use super::vec3::{Vec3, add, cross, length, sub, unit};

/// The normal that a vertex gets where none can be computed and a format or a shader needs one of unit length.
pub const STAND_IN_NORMAL: Vec3 = [0.0, 0.0, 1.0];

/// The positions of a triangle's corners.
pub fn corners(positions: &[Vec3], triangle: &[u32; 3]) -> [Vec3; 3] {
    triangle.map(|v| positions[v as usize])
}

/// (b − a) × (c − a): the normal of triangle (a, b, c), as long as twice its area.
pub fn doubled_area_normal([a, b, c]: [Vec3; 3]) -> Vec3 {
    cross(sub(b, a), sub(c, a))
}

/// Total area of the triangles, in squared units of `positions`.
///
/// # Panics
/// If a triangle names a vertex that is not there.
pub fn total_area(positions: &[Vec3], triangles: &[[u32; 3]]) -> f64 {
    triangles.iter().map(|t| 0.5 * length(doubled_area_normal(corners(positions, t)))).sum()
}

/// Unit normals of the vertices, N: the direction of the sum of their triangles' normals, each as long as its
/// area. Zero where the triangles around a vertex have no area or cancel; see [`STAND_IN_NORMAL`].
///
/// # Panics
/// If a triangle names a vertex that is not there.
pub fn vertex_normals(positions: &[Vec3], triangles: &[[u32; 3]]) -> Vec<Vec3> {
    let mut normals = vec![[0.0; 3]; positions.len()];
    for triangle in triangles {
        let normal = doubled_area_normal(corners(positions, triangle));
        for &v in triangle {
            normals[v as usize] = add(normals[v as usize], normal);
        }
    }
    normals.iter_mut().for_each(|n| *n = unit(*n));
    normals
}

/// [`vertex_normals`], to the last bit, on all threads: `around` is the surface's
/// [`vertex_triangles`](super::vertex_triangles), for computing normals of many poses.
///
/// # Panics
/// If a triangle names a vertex that is not there, or `around` is of another surface.
pub fn vertex_normals_around(positions: &[Vec3], triangles: &[[u32; 3]], around: &Rows) -> Vec<Vec3> {
    let faces: Vec<Vec3> = triangles.par_iter().map(|t| doubled_area_normal(corners(positions, t))).collect();
    let normal = |v| unit(around.row(v).iter().fold([0.0; 3], |sum, t| add(sum, faces[*t as usize])));
    (0..positions.len()).into_par_iter().map(normal).collect()
}

#[cfg(test)]
mod tests {
    use chladni_testdata::DoubleDouble;
    use proptest::prelude::*;

    use super::*;
    use crate::samples;
    use crate::surface::vec3::{distance, scaled};
    use crate::surface::vertex_triangles;

    #[test]
    fn a_tetrahedron_has_its_area() {
        let positions = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [7.0; 3]];
        let triangles = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
        assert!((total_area(&positions, &triangles) - (1.5 + 0.75_f64.sqrt())).abs() < 1e-15);
    }

    #[test]
    fn normals_of_a_sphere_look_outward_and_those_of_nothing_are_zero() {
        let ball = samples::icosphere(4);
        for (n, p) in vertex_normals(&ball.positions, &ball.triangles).iter().zip(&ball.positions) {
            assert!(distance(*n, *p) < 0.01);
        }
        // A vertex of its own, a triangle without area, and two that look against each other.
        let positions =
            [[9.0; 3], [0.0; 3], [1.0; 3], [2.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 5.0]];
        let triangles = [[1, 2, 3], [4, 5, 6], [4, 6, 5]];
        assert_eq!(vertex_normals(&positions, &triangles), [[0.0; 3]; 7]);
    }

    /// Each normal in twice the digits, and how far rounding may take a coordinate in doubles: half a last bit for each
    /// triangle and eight more, times as much as edges cancel.
    fn to_the_last_digit(positions: &[Vec3], triangles: &[[u32; 3]]) -> Vec<([DoubleDouble; 3], f64)> {
        let mut sums = vec![([DoubleDouble::default(); 3], 0.0, 0.0); positions.len()];
        for t in triangles {
            let [a, b, c] = corners(positions, t);
            let edge = |to: Vec3| [0, 1, 2].map(|i| DoubleDouble::from(to[i]) - a[i].into());
            let (u, w) = (edge(b), edge(c));
            for &v in t {
                let (sum, edges, count) = &mut sums[v as usize];
                for i in 0..3 {
                    let (j, k) = ((i + 1) % 3, (i + 2) % 3);
                    sum[i] = sum[i] + (u[j] * w[k] - u[k] * w[j]);
                }
                *edges += distance(b, a) * distance(c, a);
                *count += 1.0;
            }
        }
        let normal = |(sum, edges, count): ([DoubleDouble; 3], f64, f64)| {
            let length = sum.iter().map(|c| *c * *c).sum::<DoubleDouble>().sqrt();
            let bound = (count + 8.0) * 0.5 * f64::EPSILON * edges / length.rounded();
            (sum.map(|c| c / length), bound)
        };
        sums.into_iter().map(normal).collect()
    }

    /// How far the normals are from exact ones, as a share of the bound; those that rounding decides are left out.
    fn share_of_the_bound(positions: &[Vec3], triangles: &[[u32; 3]]) -> f64 {
        let found = vertex_normals(positions, triangles);
        let known = to_the_last_digit(positions, triangles);
        let pairs = found.iter().zip(&known).filter(|(_, (_, bound))| *bound < 1e-3);
        pairs
            .flat_map(|(n, (m, bound))| n.iter().zip(m).map(move |(n, m)| m.error_of(*n) / bound))
            .fold(0.0, f64::max)
    }

    #[test]
    fn normals_are_right_to_the_last_digits() {
        let shapes = ["octopus", "head", "bell"].map(|name| samples::sample(name).unwrap());
        for shape in shapes {
            // Squeezed and far away, its triangles are slivers, and their edges cancel.
            for (squeeze, away) in [(1.0, 0.0), (1e-6, 0.0), (1.0, 1e4)] {
                let moved = |p: &Vec3| [p[0] * squeeze + away, p[1], p[2] - away];
                let positions: Vec<Vec3> = shape.positions.iter().map(moved).collect();
                let share = share_of_the_bound(&positions, &shape.triangles);
                assert!(share > 0.0 && share <= 1.0, "{share}");
            }
        }
    }

    proptest! {
        #[test]
        fn normals_of_any_triangles_are_right_to_the_last_digits(
            positions in prop::collection::vec([-1.0..1.0, -1.0..1.0, -1.0..1.0_f64], 3..30),
            picks in prop::collection::vec([0_usize..30, 0..30, 0..30], 1..40),
        ) {
            let corner = |v: usize| (v % positions.len()) as u32;
            let triangles: Vec<[u32; 3]> = picks.iter().map(|t| t.map(corner)).collect();
            prop_assert!(share_of_the_bound(&positions, &triangles) <= 1.0);
        }

        #[test]
        fn both_ways_agree_to_the_last_bit_and_size_does_not_matter(
            positions in prop::collection::vec([-1.0..1.0, -1.0..1.0, -1.0..1.0_f64], 3..30),
            picks in prop::collection::vec([0_usize..30, 0..30, 0..30], 1..40),
        ) {
            let triangles: Vec<[u32; 3]> =
                picks.iter().map(|t| t.map(|v| (v % positions.len()) as u32)).collect();
            let normals = vertex_normals(&positions, &triangles);
            let around = vertex_triangles(positions.len(), &triangles);
            prop_assert_eq!(&vertex_normals_around(&positions, &triangles, &around), &normals);
            // Powers of two round nothing.
            let larger: Vec<_> = positions.iter().map(|p| scaled(*p, 1024.0)).collect();
            for (n, m) in normals.iter().zip(vertex_normals(&larger, &triangles)) {
                prop_assert!(distance(*n, m) < 1e-15);
            }
        }
    }
}
