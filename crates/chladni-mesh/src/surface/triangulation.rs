//! Triangles of a polygon.

use super::doubled_area_normal;
use super::vec3::{Vec3, add, cross, dot, length, sub, unit};

/// A polygon of more corners is not searched for ears: that may take as many steps as the square of their number.
pub(crate) const MOST_CORNERS: usize = 1024;

/// Of polygons scaled to an extent of 1: what is less is rounding.
const ROUNDING: f64 = 1e-12;

/// How a polygon is divided into triangles, two fewer than it has corners.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Triangulation {
    /// A fan from the first corner, of which no triangle is turned over; for all convex polygons.
    Fan,
    /// Triangles that are not a fan from the first corner, of which none is turned over: corners are counted from 0 and
    /// ascend in each.
    Corners(Vec<[u32; 3]>),
    /// A fan from the first corner that folds over: the polygon crosses itself, or has more than [`MOST_CORNERS`] corners.
    FoldedFan,
}

/// Divides the polygon whose corners are these vertices. A triangle is turned over where it looks away from the polygon's
/// normal, which is Newell's (Sutherland, Sproull & Schumacker, ACM Computing Surveys 6(1), 1974): polygons need not be
/// flat. Triangles of which none is turned over cover each place as often as the border runs around it: once, where the
/// border does not cross itself.
///
/// # Panics
/// If a corner is a vertex that is not there.
pub(crate) fn triangulation(positions: &[Vec3], corners: &[u32]) -> Triangulation {
    if corners.len() <= 3 || looks_one_way(positions, corners) {
        return Triangulation::Fan;
    }
    let Some(polygon) = Polygon::of(positions, corners) else { return Triangulation::Fan };
    if polygon.is_covered_by((2..corners.len() as u32).map(|i| [0, i - 1, i])) {
        return Triangulation::Fan;
    }
    let Some(normal) = polygon.normal.filter(|_| corners.len() <= MOST_CORNERS) else {
        return Triangulation::FoldedFan;
    };
    let triangles = ears(&polygon.in_plane(normal));
    if polygon.is_covered_by(triangles.iter().copied()) {
        Triangulation::Corners(triangles)
    } else {
        Triangulation::FoldedFan
    }
}

/// Whether every triangle of the fan from the first corner looks along the sum of all, which holds for most polygons and is
/// found quickly. Numbers are not scaled: `false` where they are too small says nothing.
fn looks_one_way(positions: &[Vec3], corners: &[u32]) -> bool {
    let at = |v: u32| positions[v as usize];
    let first = at(corners[0]);
    let sides =
        || corners[1..].windows(2).map(|ends| cross(sub(at(ends[0]), first), sub(at(ends[1]), first)));
    let normal = sides().fold([0.0; 3], add);
    sides().all(|own| dot(own, normal) > 0.0)
}

struct Polygon<'a> {
    positions: &'a [Vec3],
    corners: &'a [u32],
    /// The largest coordinate of a corner as seen from the first one; positive.
    extent: f64,
    /// Of unit length; `None` where the polygon has no area.
    normal: Option<Vec3>,
}

impl<'a> Polygon<'a> {
    /// `None` where all corners lie in one place.
    fn of(positions: &'a [Vec3], corners: &'a [u32]) -> Option<Self> {
        let mut polygon = Self { positions, corners, extent: 1.0, normal: None };
        let count = corners.len() as u32;
        let extent = (0..count).flat_map(|i| polygon.corner(i)).fold(0.0_f64, |most, x| most.max(x.abs()));
        if extent == 0.0 {
            return None;
        }
        polygon.extent = extent;
        let sides = (2..count).map(|i| cross(polygon.corner(i - 1), polygon.corner(i)));
        let normal = sides.fold([0.0; 3], add);
        polygon.normal = (length(normal) > ROUNDING).then(|| unit(normal));
        Some(polygon)
    }

    /// Corner `i` as seen from the first one, scaled to an extent of 1.
    fn corner(&self, i: u32) -> Vec3 {
        let at = |i: usize| self.positions[self.corners[i] as usize];
        sub(at(i as usize), at(0)).map(|x| x / self.extent)
    }

    /// Whether none of `triangles` is turned over; of a polygon without area, whether they have none.
    fn is_covered_by(&self, mut triangles: impl Iterator<Item = [u32; 3]>) -> bool {
        triangles.all(|triangle| {
            let own = doubled_area_normal(triangle.map(|i| self.corner(i)));
            self.normal.map_or(length(own) <= ROUNDING, |normal| dot(own, normal) >= -ROUNDING)
        })
    }

    /// The corners in the plane across `normal`, counterclockwise.
    fn in_plane(&self, normal: Vec3) -> Vec<Point> {
        let across = if normal[0].abs() < 0.6 { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] };
        let u = unit(cross(across, normal));
        let v = cross(normal, u);
        (0..self.corners.len() as u32).map(|i| self.corner(i)).map(|p| [dot(p, u), dot(p, v)]).collect()
    }
}

type Point = [f64; 2];

/// Twice the area of the triangle (a, b, c), positive where it turns left.
fn turn(a: Point, b: Point, c: Point) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// Cuts ears off a polygon, at whose corners lie `points`, until a triangle is left (G. H. Meisters, "Polygons Have Ears",
/// American Mathematical Monthly 82, 1975). What is left without ears becomes a fan.
fn ears(points: &[Point]) -> Vec<[u32; 3]> {
    let mut ring: Vec<u32> = (0..points.len() as u32).collect();
    let mut ears: Vec<bool> = (0..ring.len()).map(|i| is_ear(points, &ring, i)).collect();
    let mut triangles = Vec::with_capacity(ring.len() - 2);
    // The search goes on after the neighbor of the last ear: many ears of one neighbor would be thin.
    let mut from = 0;
    while ring.len() > 3 {
        let count = ring.len();
        let Some(i) = (from..from + count).map(|i| i % count).find(|i| ears[*i]) else { break };
        let mut triangle = [ring[(i + count - 1) % count], ring[i], ring[(i + 1) % count]];
        triangle.sort_unstable();
        triangles.push(triangle);
        ring.remove(i);
        ears.remove(i);
        let count = ring.len();
        for near in i + count - 2..i + count + 2 {
            ears[near % count] = is_ear(points, &ring, near % count);
        }
        from = i + 1;
    }
    triangles.extend((2..ring.len()).map(|i| [ring[0], ring[i - 1], ring[i]]));
    triangles
}

/// Whether the `i`th corner in the ring can be cut off: it turns left, and the line between its neighbors lies within the
/// polygon. A corner in one place with its neighbor, or at the tip of a line that is run along to and fro, always can.
fn is_ear(points: &[Point], ring: &[u32], i: usize) -> bool {
    let count = ring.len();
    let [y, a, b, c, d] =
        [count - 2, count - 1, 0, 1, 2].map(|step| points[ring[(i + step) % count] as usize]);
    if a == b || b == c || c == a {
        return true;
    }
    let slack = ROUNDING * (c[0] - a[0]).hypot(c[1] - a[1]);
    // From either end the other one lies within the corner. The points alone do not say so where the border meets itself.
    let is_left_at_a = turn(y, a, b) < 0.0 || turn(y, a, c) >= 0.0;
    let is_left_at_c = turn(b, c, d) < 0.0 || turn(c, d, a) >= 0.0;
    let is_inside = |p: Point| {
        // The line that would be cut along comes first: most corners lie beyond it.
        turn(c, a, p) >= -slack && turn(a, b, p) >= 0.0 && turn(b, c, p) >= 0.0 && ![a, b, c].contains(&p)
    };
    turn(a, b, c) > slack
        && is_left_at_a
        && is_left_at_c
        && !ring.iter().any(|corner| is_inside(points[*corner as usize]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::vec3::scaled;
    use proptest::prelude::*;

    /// Twice the areas of a polygon's triangles as vectors; `None` where they fold over.
    fn normals(positions: &[Vec3], face: &[u32]) -> Option<Vec<Vec3>> {
        let corners: Vec<[u32; 3]> = match triangulation(positions, face) {
            Triangulation::Fan => (2..face.len() as u32).map(|i| [0, i - 1, i]).collect(),
            Triangulation::Corners(corners) => corners,
            Triangulation::FoldedFan => return None,
        };
        assert!(corners.iter().all(|[a, b, c]| a < b && b < c), "{corners:?}");
        let at = |corner: u32| positions[face[corner as usize] as usize];
        Some(corners.into_iter().map(|triangle| doubled_area_normal(triangle.map(at))).collect())
    }

    fn flat(points: &[Point]) -> Vec<Vec3> {
        points.iter().map(|[x, y]| [*x, *y, 0.0]).collect()
    }

    /// Whether triangles cover this counterclockwise polygon of an area once, from whichever corner it begins, and mirrored.
    fn is_covered(points: &[Point], face: &[u32], area: f64) -> bool {
        let mut face = face.to_vec();
        (0..2 * face.len()).all(|i| {
            face.rotate_left(1);
            if i == face.len() {
                face.reverse();
            }
            let side = if i < face.len() { 0.5 } else { -0.5 };
            let areas: Vec<f64> =
                normals(&flat(points), &face).unwrap_or_default().iter().map(|n| side * n[2]).collect();
            areas.len() == face.len() - 2
                && areas.iter().all(|a| *a >= 0.0)
                && (areas.iter().sum::<f64>() - area).abs() < 1e-12
        })
    }

    const ARROWHEAD: [Point; 4] = [[0.0, 2.0], [-2.0, -1.0], [0.0, 0.0], [2.0, -1.0]];

    #[test]
    fn an_arrowhead_is_divided_along_the_diagonal_inside() {
        assert!(is_covered(&ARROWHEAD, &[0, 1, 2, 3], 4.0));
        let divided = |face: [u32; 4]| triangulation(&flat(&ARROWHEAD), &face);
        assert_eq!(divided([0, 1, 2, 3]), Triangulation::Fan);
        assert_eq!(divided([2, 3, 0, 1]), Triangulation::Fan);
        for face in [[1, 2, 3, 0], [3, 0, 1, 2]] {
            let Triangulation::Corners(mut corners) = divided(face) else { panic!("{face:?}") };
            corners.sort_unstable();
            assert_eq!(corners, [[0, 1, 3], [1, 2, 3]]);
        }
        // So small that the squares of areas are 0, and as large as coordinates may be.
        for scale in [1e-200, 1e74] {
            let positions: Vec<Vec3> = flat(&ARROWHEAD).into_iter().map(|p| scaled(p, scale)).collect();
            assert!(matches!(triangulation(&positions, &[1, 2, 3, 0]), Triangulation::Corners(_)));
            assert_eq!(triangulation(&positions, &[2, 3, 0, 1]), Triangulation::Fan);
        }
    }

    #[test]
    fn notches_and_holes_stay_open() {
        let notched: [Point; 6] = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]];
        assert!(is_covered(&notched, &[0, 1, 2, 3, 4, 5], 3.0));
        // A corner named twice in a row, and one within an edge.
        let more = [&notched[..], &[[0.5, 2.0]]].concat();
        assert!(is_covered(&more, &[0, 1, 2, 3, 3, 4, 6, 5], 3.0));
        // A frame: the border runs along the line from vertex 0 to 4 and back.
        let outer: [Point; 4] = [[0.0, 0.0], [3.0, 0.0], [3.0, 3.0], [0.0, 3.0]];
        let inner: [Point; 4] = [[1.0, 1.0], [1.0, 2.0], [2.0, 2.0], [2.0, 1.0]];
        assert!(is_covered(&[outer, inner].concat(), &[0, 1, 2, 3, 0, 4, 5, 6, 7, 4], 8.0));
    }

    #[test]
    fn a_convex_polygon_is_a_fan_however_many_corners_it_has() {
        let round = |i: u32| {
            let (sin, cos) = (f64::from(i) * 0.001).sin_cos();
            [1e60 * cos, 1e60 * sin, 3e59]
        };
        let positions: Vec<Vec3> = (0..6000).map(round).collect();
        let face: Vec<u32> = (0..6000).collect();
        assert_eq!(triangulation(&positions, &face), Triangulation::Fan);
        // Without area, or with three of the corners in one line.
        let line: Vec<Vec3> = (0..5).map(|i| [f64::from(i), 0.1 * f64::from(i), 7.0]).collect();
        assert_eq!(triangulation(&line, &[0, 2, 1, 4]), Triangulation::Fan);
        assert_eq!(triangulation(&line, &[3; 5]), Triangulation::Fan);
        assert_eq!(triangulation(&[&line[..3], &[[1.0; 3]]].concat(), &[0, 1, 2, 3]), Triangulation::Fan);
    }

    #[test]
    fn what_cannot_be_covered_once_is_said() {
        let bow = flat(&[[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]]);
        let star = (0..5).map(|i| (f64::from(i) * 0.8 * std::f64::consts::PI).sin_cos());
        let star: Vec<Vec3> = star.map(|(sin, cos)| [cos, sin, 0.0]).collect();
        assert_eq!(triangulation(&bow, &[0, 1, 2, 3]), Triangulation::FoldedFan);
        assert_eq!(triangulation(&star, &[0, 1, 2, 3, 4]), Triangulation::FoldedFan);
        let comb = |corners: u32| {
            let positions: Vec<Vec3> = (0..corners)
                .map(|i| [f64::from(i), -f64::from(i % 2), 0.0])
                .chain([[0.0, 9.0, 0.0]])
                .collect();
            triangulation(&positions, &(0..=corners).collect::<Vec<u32>>())
        };
        assert!(matches!(comb(1001), Triangulation::Corners(corners) if corners.len() == 1000));
        assert_eq!(comb(2001), Triangulation::FoldedFan);
    }

    proptest! {
        #[test]
        fn a_star_shaped_polygon_is_covered_once_wherever_it_lies(
            radii in prop::collection::vec(0.05..1.0_f64, 4..40),
            up in [-1.0..1.0_f64, -1.0..1.0, 0.1..1.0],
            center in [-9.0..9.0_f64, -9.0..9.0, -9.0..9.0],
        ) {
            let up = unit(up);
            let u = unit(cross([1.0, 0.0, 0.0], up));
            let v = cross(up, u);
            let step = std::f64::consts::TAU / radii.len() as f64;
            let corner = |(i, r): (usize, &f64)| {
                let (sin, cos) = (step * i as f64).sin_cos();
                add(center, add(scaled(u, r * cos), scaled(v, r * sin)))
            };
            let positions: Vec<Vec3> = radii.iter().enumerate().map(corner).collect();
            let face: Vec<u32> = (0..radii.len() as u32).collect();
            let normals = normals(&positions, &face);
            prop_assert!(normals.is_some());
            let areas: Vec<f64> = normals.into_iter().flatten().map(|n| 0.5 * dot(n, up)).collect();
            prop_assert_eq!(areas.len(), radii.len() - 2);
            prop_assert!(areas.iter().all(|a| *a > -1e-11), "{:?}", areas);
            let next = radii.iter().cycle().skip(1);
            let whole = 0.5 * step.sin() * radii.iter().zip(next).map(|(r, s)| r * s).sum::<f64>();
            prop_assert!((areas.iter().sum::<f64>() - whole).abs() < 1e-12);
        }
    }
}
