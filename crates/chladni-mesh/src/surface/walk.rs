//! Walking on a surface: straight ahead, over edges.

use std::num::NonZeroI8;

use super::SurfacePoint;
use super::adjacency::sorted_half_edges;
use super::normals::corners;
use super::vec3::{Vec3, dot, length, scaled, sub};

/// Changes of a weight below this count as none, so that a walk along a border does not press against it.
const STILL: f64 = 1e-12;

/// A surface made ready for walking on it. Directions and slopes on a triangle have two coordinates in its own
/// plane: x from its first corner to its second, y toward its third.
///
/// Edges of one triangle, of more than two, and those of triangles without area are borders. A walk that reaches a
/// border follows it.
#[derive(Clone, Debug, Default)]
pub struct Ground {
    tiles: Vec<Tile>,
    /// The area of each triangle and of all before it.
    areas: Vec<f64>,
}

/// A triangle, in single precision, so that it is one line of a processor's cache: walkers jump about in memory.
#[derive(Clone, Debug, Default)]
#[repr(align(64))]
struct Tile {
    /// Gradients of the three barycentric weights.
    gradients: [[f32; 2]; 3],
    /// Cosine and sine that turn directions into the plane beyond the edge opposite each corner.
    turns: [[f32; 2]; 3],
    /// The triangle there.
    beyond: [u32; 3],
    gates: [Gate; 3],
}

/// The way over an edge: one more than the number of the corner opposite to it beyond, below 0 where the triangle there
/// looks to the other side. None is a border.
type Gate = Option<NonZeroI8>;

const _: () = assert!(size_of::<Tile>() == 64);

impl Ground {
    /// The ground that `triangles` over `positions` are.
    ///
    /// # Panics
    /// If a triangle names a vertex that is not there.
    pub fn new(positions: &[Vec3], triangles: &[[u32; 3]]) -> Self {
        let planes: Vec<Option<Plane>> = triangles.iter().map(|t| Plane::of(corners(positions, t))).collect();
        let mut tiles: Vec<Tile> = planes
            .iter()
            .map(|plane| Tile {
                gradients: plane.as_ref().map_or([[0.0; 2]; 3], |p| p.gradients.map(single)),
                ..Tile::default()
            })
            .collect();
        let sides = sorted_half_edges(triangles.iter().map(|t| &t[..]));
        for edge in sides.chunk_by(|a, b| a.ends == b.ends) {
            let [one, other] = edge else { continue };
            let pair = [one.face as usize, other.face as usize];
            let [Some(here), Some(there)] = pair.map(|t| planes[t].as_ref()) else { continue };
            for ([from, to], [here, there]) in [(pair, [here, there]), ([pair[1], pair[0]], [there, here])] {
                let Some((opposite, gate, turn)) =
                    between((&triangles[from], here), (&triangles[to], there), edge[0].ends)
                else {
                    continue;
                };
                let tile = &mut tiles[from];
                (tile.gates[opposite], tile.turns[opposite], tile.beyond[opposite]) =
                    (Some(gate), turn, to as u32);
            }
        }
        let mut total = 0.0;
        let areas = planes.iter().map(|plane| {
            total += plane.as_ref().map_or(0.0, |plane| plane.area);
            total
        });
        Self { areas: areas.collect(), tiles }
    }

    /// Whether every triangle lacks an area to stand on.
    pub fn is_empty(&self) -> bool {
        self.areas.last().is_none_or(|total| *total <= 0.0)
    }

    /// The point before which a `share` of the area lies, in [0, 1), somewhere in its triangle as two numbers
    /// in [0, 1] say: points of even shares and numbers lie evenly on the surface. `None` where it
    /// [is empty](Self::is_empty).
    pub fn point_at(&self, share: f64, [u, v]: [f64; 2]) -> Option<SurfacePoint> {
        let total = *self.areas.last().filter(|total| **total > 0.0)?;
        let area = share.clamp(0.0, 1.0) * total;
        // The last one with an area, where rounding led past it.
        let end = self.areas.partition_point(|a| *a < total);
        let triangle = self.areas.partition_point(|a| *a <= area).min(end);
        let root = u.clamp(0.0, 1.0).sqrt();
        let weights = [1.0 - root, root * (1.0 - v), root * v];
        Some(SurfacePoint { triangle: triangle as u32, weights })
    }

    /// The gradient of the linear function with these `values` at the corners of a triangle.
    ///
    /// # Panics
    /// If there is no such triangle.
    pub fn slope(&self, triangle: u32, values: [f64; 3]) -> [f64; 2] {
        let gradients = self.tiles[triangle as usize].gradients.map(double);
        [0, 1].map(|i| (0..3).map(|c| gradients[c][i] * values[c]).sum())
    }

    /// Where one arrives who walks from a point in a direction, straight ahead, as far as the direction is
    /// long, but over `edges` edges at most; and the rest of the way, in the plane of the triangle there. The point lies in a
    /// triangle, its weights in [0, 1] with sum 1.
    ///
    /// # Panics
    /// If the point's triangle is not there.
    pub fn walk(&self, from: SurfacePoint, mut way: [f64; 2], edges: usize) -> (SurfacePoint, [f64; 2]) {
        let mut at = from;
        if !way.iter().all(|x| x.is_finite()) {
            return (at, [0.0; 2]);
        }
        for _ in 0..edges {
            let tile = &self.tiles[at.triangle as usize];
            let gradients = tile.gradients.map(double);
            let change = gradients.map(|g| g[0] * way[0] + g[1] * way[1]);
            let (mut share, mut exit) = (1.0, None);
            for corner in 0..3 {
                if change[corner] < -STILL && at.weights[corner] < -share * change[corner] {
                    (share, exit) = (at.weights[corner] / -change[corner], Some(corner));
                }
            }
            for corner in 0..3 {
                at.weights[corner] = (at.weights[corner] + share * change[corner]).max(0.0);
            }
            if let Some(corner) = exit {
                at.weights[corner] = 0.0;
            }
            let sum: f64 = at.weights.iter().sum();
            at.weights = at.weights.map(|w| w / sum);
            let Some(corner) = exit else { return (at, [0.0; 2]) };
            way = way.map(|x| (1.0 - share) * x);
            match tile.gates[corner] {
                Some(gate) => {
                    let (mirrored, opposite) = (gate.get() < 0, usize::from(gate.get().unsigned_abs()) - 1);
                    let kept = [1, 2].map(|i| at.weights[(corner + i) % 3]);
                    at = SurfacePoint { triangle: tile.beyond[corner], weights: [0.0; 3] };
                    // Triangles that look to the same side go along their common edge in opposite directions.
                    let [first, second] = if mirrored { [1, 2] } else { [2, 1] };
                    at.weights[(opposite + first) % 3] = kept[0];
                    at.weights[(opposite + second) % 3] = kept[1];
                    let ([cos, sin], y) =
                        (double(tile.turns[corner]), if mirrored { -way[1] } else { way[1] });
                    way = [cos * way[0] - sin * y, sin * way[0] + cos * y];
                }
                None => {
                    let g = gradients[corner];
                    let across = (g[0] * way[0] + g[1] * way[1]) / (g[0] * g[0] + g[1] * g[1]);
                    way = [0, 1].map(|i| way[i] - across * g[i]);
                }
            }
        }
        (at, way)
    }
}

fn single(v: [f64; 2]) -> [f32; 2] {
    v.map(|x| x as f32)
}

fn double(v: [f32; 2]) -> [f64; 2] {
    v.map(f64::from)
}

/// A triangle of an area, in its own plane.
struct Plane {
    corners: [[f64; 2]; 3],
    gradients: [[f64; 2]; 3],
    area: f64,
}

impl Plane {
    fn of([a, b, c]: [Vec3; 3]) -> Option<Self> {
        let (ab, ac) = (sub(b, a), sub(c, a));
        let base = length(ab);
        let along = scaled(ab, 1.0 / base);
        let x = dot(ac, along);
        let height = length(sub(ac, scaled(along, x)));
        let there = base > 0.0 && height > 1e-12 * length(ac).max(base) && (base * height).is_finite();
        let third = [0.0, 1.0 / height];
        let second = [1.0 / base, -x / (base * height)];
        let first = [0, 1].map(|i| -second[i] - third[i]);
        there.then_some(Self {
            corners: [[0.0; 2], [base, 0.0], [x, height]],
            gradients: [first, second, third],
            area: 0.5 * base * height,
        })
    }

    /// Unit vectors along the edge from one corner to another, and across it into the triangle, whose third
    /// corner is `opposite`.
    fn edge(&self, from: usize, to: usize, opposite: usize) -> [[f64; 2]; 2] {
        let unit = |v: [f64; 2]| v.map(|x| x / v[0].hypot(v[1]));
        let (a, b) = (self.corners[from], self.corners[to]);
        [unit([b[0] - a[0], b[1] - a[1]]), unit(self.gradients[opposite])]
    }
}

/// The corner opposite to the edge between the vertices `ends`, the way over that edge, and the turn there; `None` where a
/// triangle has one of them twice.
fn between(
    (from, here): (&[u32; 3], &Plane),
    (to, there): (&[u32; 3], &Plane),
    ends: [u32; 2],
) -> Option<(usize, NonZeroI8, [f32; 2])> {
    let opposite = from.iter().position(|v| !ends.contains(v))?;
    let beyond = to.iter().position(|v| !ends.contains(v))?;
    let [one, two] = [(opposite + 1) % 3, (opposite + 2) % 3];
    let place = |corner: usize| to.iter().position(|v| *v == from[corner]);
    let (first, second) = (place(one)?, place(two)?);
    let [along, inward] = here.edge(one, two, opposite);
    let [along_there, inward_there] = there.edge(first, second, beyond);
    // Unfolds the neighbor into this triangle's plane: a direction leaving one triangle enters the other, even
    // where their normals point to opposite sides.
    let [[a, b], [c, d]] =
        [0, 1].map(|i| [0, 1].map(|j| along_there[i] * along[j] - inward_there[i] * inward[j]));
    let corner = beyond as i8 + 1;
    let gate = NonZeroI8::new(if a * d < b * c { -corner } else { corner })?;
    Some((opposite, gate, single([a, c])))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::samples;
    use crate::surface::vec3::{cross, distance, unit};

    fn place(mesh: &crate::TriMesh, at: &SurfacePoint) -> Vec3 {
        at.position(&mesh.triangles, |v| mesh.positions[v as usize]).unwrap()
    }

    /// A direction of space in the plane of a triangle.
    fn in_plane(mesh: &crate::TriMesh, triangle: u32, way: Vec3) -> [f64; 2] {
        let [a, b, c] = corners(&mesh.positions, &mesh.triangles[triangle as usize]);
        let x = unit(sub(b, a));
        let n = unit(cross(sub(b, a), sub(c, a)));
        [dot(way, x), dot(way, cross(n, x))]
    }

    /// More edges than any walk here crosses.
    const ALL: usize = 64;

    #[test]
    fn on_a_plane_a_walk_is_straight_and_a_border_leads_along_itself() {
        let square = samples::grid_square(17);
        let ground = Ground::new(&square.positions, &square.triangles);
        for i in 0..200 {
            let from = ground.point_at(f64::from(i) / 200.0, [0.3, 0.6]).unwrap();
            let start = place(&square, &from);
            let (dy, dx) = (0.37 * f64::from(i)).sin_cos();
            let way = [0.7 * dx, 0.7 * dy, 0.0];
            let end = place(&square, &ground.walk(from, in_plane(&square, from.triangle, way), ALL).0);
            let goal = [0, 1, 2].map(|k| (start[k] + way[k]).clamp(0.0, 1.0));
            let inside = (0..2).all(|k| (start[k] + way[k] - goal[k]).abs() < 1e-12);
            assert!(end.iter().all(|x| (-1e-9..=1.0 + 1e-9).contains(x)), "{end:?}");
            if inside {
                assert!(distance(end, goal) < 1e-6, "{end:?} is not {goal:?}");
            }
            // Straight on to the border, then along it.
            let one_border = (0..2).filter(|&k| (start[k] + way[k] - goal[k]).abs() > 1e-12).count() == 1;
            if one_border {
                assert!(distance(end, goal) < 1e-6, "{end:?} is not {goal:?}");
            }
        }
    }

    #[test]
    fn a_walk_in_parts_arrives_where_a_whole_one_does() {
        let ball = samples::icosphere(4);
        let ground = Ground::new(&ball.positions, &ball.triangles);
        for i in 0..100 {
            let from = ground.point_at(f64::from(i) / 100.0, [0.2, 0.7]).unwrap();
            let (y, x) = f64::from(i).sin_cos();
            let (whole, nothing) = ground.walk(from, [0.8 * x, 0.8 * y], ALL);
            assert_eq!(nothing, [0.0; 2]);
            let (mut at, mut way, mut parts) = (from, [0.8 * x, 0.8 * y], 0);
            while way != [0.0; 2] {
                (at, way) = ground.walk(at, way, 5);
                parts += 1;
            }
            assert!(parts > 2);
            assert_eq!(at, whole);
        }
    }

    #[test]
    fn around_a_sphere_one_comes_back() {
        let ball = samples::icosphere(5);
        let ground = Ground::new(&ball.positions, &ball.triangles);
        let from = ground.point_at(0.31, [0.4, 0.5]).unwrap();
        // In steps; the heading is that of the great circle.
        let axis = unit(cross(place(&ball, &from), [0.3, 1.0, 0.2]));
        let mut at = from;
        let steps = 400;
        for _ in 0..steps {
            let way = scaled(unit(cross(axis, place(&ball, &at))), std::f64::consts::TAU / f64::from(steps));
            at = ground.walk(at, in_plane(&ball, at.triangle, way), ALL).0;
        }
        assert!(distance(place(&ball, &at), place(&ball, &from)) < 0.03);
    }

    #[test]
    fn even_shares_lie_evenly() {
        let square = samples::grid_square(4);
        let ground = Ground::new(&square.positions, &square.triangles);
        let points: Vec<Vec3> = (0..4000)
            .map(|i| (f64::from(i), f64::from(i) * 0.618_034 % 1.0, f64::from(i) * 0.754_878 % 1.0))
            .map(|(i, u, v)| place(&square, &ground.point_at((i + 0.5) / 4000.0, [u, v]).unwrap()))
            .collect();
        let left = points.iter().filter(|p| p[0] < 0.5).count();
        let low = points.iter().filter(|p| p[0] < 0.25 && p[1] < 0.25).count();
        assert!((1950..=2050).contains(&left) && (230..=270).contains(&low), "{left}, {low}");
        assert!(Ground::new(&[[0.0; 3]; 3], &[[0, 1, 2]]).point_at(0.5, [0.5; 2]).is_none());
        assert!(Ground::default().is_empty());
    }

    proptest! {
        #[test]
        fn nobody_leaves_the_surface(
            share in 0.0..1.0_f64, u in 0.0..1.0_f64, v in 0.0..1.0_f64,
            ways in prop::collection::vec([-1.0..1.0_f64, -1.0..1.0_f64], 1..20),
            which in 0_usize..3,
        ) {
            // One side only; a border; triangles without area, and edges of three.
            let mut mesh = [samples::moebius(0.5, 24, 3), samples::grid_square(3), samples::icosphere(1)][which].clone();
            if which == 2 {
                mesh.triangles.extend([[0, 0, 5], [0, 1, 2], [3, 4, 3]]);
            }
            let ground = Ground::new(&mesh.positions, &mesh.triangles);
            let mut at = ground.point_at(share, [u, v]).unwrap();
            for way in ways {
                at = ground.walk(at, way, ALL).0;
                prop_assert!((at.triangle as usize) < mesh.triangles.len());
                prop_assert!(at.weights.iter().all(|w| (0.0..=1.0).contains(w)));
                prop_assert!((at.weights.iter().sum::<f64>() - 1.0).abs() < 1e-12);
            }
        }

        #[test]
        fn a_walk_is_as_long_as_its_way_and_its_slope_is_what_it_climbs(
            share in 0.0..1.0_f64, angle in 0.0..6.3_f64)
        {
            let square = samples::grid_square(9);
            let ground = Ground::new(&square.positions, &square.triangles);
            let from = ground.point_at(share, [0.5, 0.5]).unwrap();
            let way = [1e-3 * angle.cos(), 1e-3 * angle.sin()];
            let to = ground.walk(from, way, ALL).0;
            let (a, b) = (place(&square, &from), place(&square, &to));
            prop_assert!((distance(a, b) - 1e-3).abs() < 1e-9);
            let height = |p: Vec3| 3.0 * p[0] - 2.0 * p[1];
            let values = square.triangles[from.triangle as usize].map(|v| height(square.positions[v as usize]));
            let slope = ground.slope(from.triangle, values);
            let climbed = slope[0] * way[0] + slope[1] * way[1];
            prop_assert!((height(b) - height(a) - climbed).abs() < 1e-9);
        }
    }
}
