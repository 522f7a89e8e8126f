//! Triangles for points that come without any.

use std::num::NonZeroUsize;

use kiddo::{ImmutableKdTree, SquaredEuclidean};
use rayon::prelude::*;

use super::vec3::{Vec3, add, dot, scaled, sub};
use crate::eigen::symmetric_eigen;

/// Below this share of the lengths involved an angle or a distance counts as zero, near the origin.
const NOTHING: f64 = 1e-9;
/// Far from the origin, below as many times the rounding of the coordinates.
const ROUNDINGS: f64 = 64.0;

/// The stars of all points: for each of them the triangles at it in the Delaunay triangulation of its `neighbors`
/// nearest points, projected along the normal of the plane that fits these best. Each begins with its point.
///
/// Where a surface is sampled well, neighbors agree, and each triangle comes three times, once from each corner.
/// Points in the place of another one have no part in that one's star. Fewer than three points have no triangles.
pub fn delaunay_stars(points: &[Vec3], neighbors: NonZeroUsize) -> Vec<[u32; 3]> {
    if points.len() < 3 {
        return Vec::new();
    }
    let Ok(tree) = ImmutableKdTree::<f64, 3>::new_from_slice(points) else { return Vec::new() };
    // The point itself is among those that are found. The tree makes room for as many as are asked for.
    let count = neighbors.saturating_add(1).min(NonZeroUsize::new(points.len()).unwrap_or(neighbors));
    let star = |v: usize| {
        let found = tree.query(&points[v]).nearest_n::<SquaredEuclidean<f64>>(count).execute();
        let around: Vec<u32> = found.iter().map(|n| n.item).filter(|u| *u as usize != v).collect();
        star(points, v as u32, &around)
    };
    (0..points.len()).into_par_iter().flat_map_iter(star).collect()
}

/// A neighbor in the plane around the point in the middle, at its place inverted in the unit circle.
#[derive(Clone, Copy)]
struct Inverted {
    vertex: u32,
    at: [f64; 2],
}

/// The triangles at `v`. Inversion turns a circle through the middle into a line, and its inside into the side away from
/// the middle, so that the Delaunay neighbors are the corners of the convex hull of the inverted points and the middle.
fn star(points: &[Vec3], v: u32, around: &[u32]) -> Vec<[u32; 3]> {
    let [x, y] = plane(points, around);
    let offset = |u: &u32| sub(points[*u as usize], points[v as usize]);
    let farthest = around.iter().map(|u| dot(offset(u), offset(u))).fold(0.0, f64::max).sqrt();
    if farthest == 0.0 {
        return Vec::new();
    }
    let coordinates = points[v as usize].into_iter().chain(around.iter().flat_map(|u| points[*u as usize]));
    let largest = coordinates.fold(0.0, |largest: f64, x| largest.max(x.abs()));
    let nothing = NOTHING.max(ROUNDINGS * f64::EPSILON * largest / farthest);
    let inverted = |u: &u32| {
        let offset = scaled(offset(u), 1.0 / farthest);
        let (x, y) = (dot(offset, x), dot(offset, y));
        let square = x * x + y * y;
        (square > nothing * nothing).then(|| Inverted { vertex: *u, at: [x / square, y / square] })
    };
    let mut seen: Vec<Inverted> = around.iter().filter_map(inverted).collect();
    let middle = Inverted { vertex: v, at: [0.0; 2] };
    seen.push(middle);
    let hull = convex_hull(&mut seen, nothing);
    let next = hull.iter().skip(1).chain(hull.first());
    let mut fan = Vec::with_capacity(hull.len());
    for (a, b) in hull.iter().zip(next) {
        // A side through the middle is a border: the fan is open there.
        if turns_left(nothing, *a, *b, middle) {
            let ring = side(&seen, v, [*a, *b], nothing);
            fan.extend(ring.windows(2).map(|pair| [v, pair[0], pair[1]]));
        }
    }
    fan
}

/// Two directions at right angles that span the plane of best fit.
fn plane(points: &[Vec3], around: &[u32]) -> [Vec3; 2] {
    let sum = around.iter().fold([0.0; 3], |sum, u| add(sum, points[*u as usize]));
    let center = scaled(sum, 1.0 / around.len().max(1) as f64);
    let mut spread = [[0.0; 3]; 3];
    for u in around {
        let d = sub(points[*u as usize], center);
        (0..3).for_each(|i| (0..3).for_each(|j| spread[i][j] += d[i] * d[j]));
    }
    let (_, [x, y, _]) = symmetric_eigen(spread);
    [x, y]
}

/// Whether a, b and c turn left by more than `least`, the sine of an angle.
fn turns_left(least: f64, a: Inverted, b: Inverted, c: Inverted) -> bool {
    let [u, v] = [(a, b), (b, c)].map(|(p, q)| [q.at[0] - p.at[0], q.at[1] - p.at[1]]);
    u[0] * v[1] - u[1] * v[0] > least * (u[0].hypot(u[1]) * v[0].hypot(v[1]))
}

/// The corners of the convex hull, counterclockwise (Andrew 1979), where an angle whose sine is `nothing` is none; sorts the
/// points.
fn convex_hull(points: &mut [Inverted], nothing: f64) -> Vec<Inverted> {
    points.sort_by(|a, b| {
        a.at[0].total_cmp(&b.at[0]).then(a.at[1].total_cmp(&b.at[1])).then(a.vertex.cmp(&b.vertex))
    });
    let mut hull: Vec<Inverted> = Vec::new();
    let mut half = |points: &mut dyn Iterator<Item = &Inverted>| {
        let first = hull.len();
        for point in points {
            while let [.., a, b] = hull[first..] {
                if turns_left(0.0, a, b, *point) {
                    break;
                }
                hull.pop();
            }
            hull.push(*point);
        }
        hull.pop();
    };
    half(&mut points.iter());
    half(&mut points.iter().rev());
    // Points on one side are sorted out of order where rounding alone tells their x apart. With a tolerance above they would
    // take true corners out, so corners that are none but for rounding go afterward.
    while hull.len() > 3 {
        let n = hull.len();
        let is_none = |i: &usize| !turns_left(nothing, hull[(i + n - 1) % n], hull[*i], hull[(i + 1) % n]);
        let Some(i) = (0..n).find(is_none) else { break };
        hull.remove(i);
    }
    hull
}

/// The ring from a to b along a side of the hull. Points on the side lie on one circle with a, b and the middle `v`; of
/// the polygon that all of them form, every star takes the same triangles: those at its vertex of least number.
fn side(seen: &[Inverted], v: u32, [a, b]: [Inverted; 2], nothing: f64) -> Vec<u32> {
    let mut ring = vec![a.vertex, b.vertex];
    let [u, w] = [b.at[0] - a.at[0], b.at[1] - a.at[1]];
    let square = u * u + w * w;
    let mut between: Vec<(f64, u32)> = seen
        .iter()
        .filter(|point| ![v, a.vertex, b.vertex].contains(&point.vertex))
        .filter_map(|point| {
            let [x, y] = [point.at[0] - a.at[0], point.at[1] - a.at[1]];
            let along = (x * u + y * w) / square;
            let is_on_it = (x * w - y * u).abs() < nothing * square;
            (is_on_it && along > nothing && along < 1.0 - nothing).then_some((along, point.vertex))
        })
        .collect();
    between.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    between.dedup_by(|a, b| a.0 - b.0 < nothing);
    let least = between.iter().map(|(_, vertex)| *vertex).chain([a.vertex, b.vertex, v]).min();
    let kept = between.iter().map(|(_, vertex)| *vertex);
    ring.splice(1..1, kept.filter(|vertex| least == Some(v) || least == Some(*vertex)));
    ring
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples;
    use crate::surface::{doubled_area_normal, vec3::length};

    fn stars(points: &[Vec3]) -> Vec<[u32; 3]> {
        delaunay_stars(points, NonZeroUsize::new(30).unwrap())
    }

    fn area(points: &[Vec3], triangles: &[[u32; 3]]) -> f64 {
        let of = |t: &[u32; 3]| 0.5 * length(doubled_area_normal(t.map(|v| points[v as usize])));
        triangles.iter().map(of).sum()
    }

    /// How often each triangle comes, whatever corner it begins with.
    fn counts(triangles: &[[u32; 3]]) -> std::collections::HashMap<[u32; 3], usize> {
        let mut counts = std::collections::HashMap::new();
        for triangle in triangles {
            let mut sorted = *triangle;
            sorted.sort_unstable();
            *counts.entry(sorted).or_insert(0) += 1;
        }
        counts
    }

    /// In one plane all stars see the same circles: they are the Delaunay triangulation, which covers the square once.
    #[test]
    fn stars_of_a_plane_agree_also_where_many_points_lie_on_one_circle() {
        let grid: Vec<Vec3> = (0..225)
            .map(|i| [f64::from(i % 15) * 0.6, f64::from(i / 15) * 0.6, f64::from(i % 15) * 0.8])
            .collect();
        let jittered = |p: &Vec3, i: usize| {
            let by = 0.3 * ((i * 7919) as f64).sin();
            [p[0] + 0.6 * by, p[1] + 0.2 * ((i * 104_729) as f64).sin(), p[2] + 0.8 * by]
        };
        let jittered: Vec<Vec3> = grid.iter().enumerate().map(|(i, p)| jittered(p, i)).collect();
        let whole = 14.0 * 14.0 * 0.6;
        for (points, expected) in [(&grid, Some(whole)), (&jittered, None)] {
            let triangles = stars(points);
            let counts = counts(&triangles);
            // Along the border of a jittered grid lie slivers that reach beyond 30 neighbors.
            let thrice = counts.values().filter(|count| **count == 3).count();
            match expected {
                Some(expected) => {
                    assert!(counts.values().all(|count| *count == 3) && counts.len() == 2 * 14 * 14);
                    assert!((area(points, &triangles) / 3.0 - expected).abs() < 1e-9 * expected);
                }
                None => assert!(thrice as f64 > 0.95 * counts.len() as f64, "{thrice} of {}", counts.len()),
            }
        }
    }

    #[test]
    fn stars_of_a_grid_agree_however_far_from_the_origin_it_lies() {
        for far in [1e4, 1e6, 1e8] {
            let points: Vec<Vec3> = (0..225)
                .map(|i| [f64::from(i % 15) / 10.0, f64::from(i / 15) / 10.0])
                .map(|[x, y]| [2.0 * x - y, 2.0 * x + 2.0 * y, 2.0 * y - x].map(|c| c / 3.0))
                .map(|[x, y, z]| [x + 0.3 * far, y + 0.7 * far, z - 0.1 * far])
                .collect();
            let counts = counts(&stars(&points));
            assert!(counts.values().all(|count| *count == 3) && counts.len() == 2 * 14 * 14, "{far}");
        }
    }

    #[test]
    fn stars_of_a_sphere_cover_it_and_points_in_one_place_do_no_harm() {
        let sphere = samples::icosphere(4).positions;
        let triangles = stars(&sphere);
        assert!((area(&sphere, &triangles) / 3.0 / (4.0 * std::f64::consts::PI) - 1.0).abs() < 0.01);
        let mut twice = sphere.clone();
        twice.extend(&sphere[..50]);
        assert!(stars(&twice).iter().all(|t| t[0] != t[1] && t[1] != t[2] && t[2] != t[0]));
        assert!(stars(&sphere[..2]).is_empty());
        let line: Vec<Vec3> = (0..40).map(|i| [f64::from(i), 0.0, 0.0]).collect();
        assert!(stars(&line).is_empty(), "a line has no triangles");
        assert!(stars(&[[1.0; 3]; 40]).is_empty(), "one place has no triangles");
    }

    #[test]
    fn more_neighbors_than_there_are_points_are_all_of_them() {
        let sphere = samples::icosphere(1).positions;
        let all = delaunay_stars(&sphere, NonZeroUsize::new(sphere.len() - 1).unwrap());
        assert!(!all.is_empty());
        for neighbors in [NonZeroUsize::new(1_000_000_000_000_000).unwrap(), NonZeroUsize::MAX] {
            assert_eq!(delaunay_stars(&sphere, neighbors), all);
        }
    }
}
