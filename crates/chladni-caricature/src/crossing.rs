//! Self-intersections: triangles that pass through others.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::sync::atomic::Ordering::Relaxed;

use chladni_mesh::surface::vec3::{Vec3, add, cross, dot, scaled, sub};
use chladni_mesh::surface::{Bounds, BoxTree, corners, doubled_area_normal};
use chladni_task::{Cancelled, Task};
use rayon::prelude::*;

use crate::Surface;

/// Finds triangles of a surface that pass through others, wherever its vertices are moved to.
///
/// A tree of boxes over the triangles is built once, for the surface at rest; each search only refits its
/// boxes to the vertices, in linear time.
#[derive(Clone, Debug)]
pub struct Crossings {
    surface: Arc<Surface>,
    tree: BoxTree,
    /// Of each node of the tree, the corners that all its triangles share; [`NONE`] fills up.
    shared: Vec<[u32; 3]>,
}

/// In place of a corner.
const NONE: u32 = u32::MAX;
/// Triangles between two checks for cancellation.
const PIECE: usize = 1024;

impl Crossings {
    /// Prepares the search on `surface`.
    pub fn of(surface: Arc<Surface>) -> Self {
        let center = |t: &[u32; 3]| {
            let [a, b, c] = corners(&surface.positions, t);
            scaled(add(add(a, b), c), 1.0 / 3.0)
        };
        let centers: Vec<Vec3> = surface.triangles.iter().map(center).collect();
        let tree = BoxTree::new(&centers, |t| bounds(&surface, t, &surface.positions));
        let in_both = |s: [u32; 3], t: [u32; 3]| s.map(|v| if t.contains(&v) { v } else { NONE });
        let of_leaf = |leaf: &[u32]| {
            leaf.iter().map(|t| surface.triangles[*t as usize]).reduce(in_both).unwrap_or([NONE; 3])
        };
        let shared = tree.gather(of_leaf, in_both);
        Self { surface, tree, shared }
    }

    /// The triangles that pass through another when the vertices lie at `positions` (N, finite),
    /// ascending. Triangles that only touch, that lie in one plane, or that share an edge do not
    /// pass through each other; neither do those without area.
    ///
    /// # Errors
    /// [`Cancelled`] through `task`.
    pub fn triangles(&self, positions: &[Vec3], task: &Task) -> Result<Vec<u32>, Cancelled> {
        const POINT: f64 = 1e-9;
        let mut tree = self.tree.clone();
        tree.fit(|t| bounds(&self.surface, t, positions));
        // Of a shape that is a point but for rounding, each triangle would be compared with each other one.
        if tree.bounds().diagonal() <= POINT * self.tree.bounds().diagonal() {
            return Ok(Vec::new());
        }
        // A mark per triangle: on a crumpled surface a list of pairs could fill the memory.
        let crossed: Vec<AtomicBool> = tree.order().iter().map(|_| AtomicBool::new(false)).collect();
        let slots: Vec<usize> = (0..crossed.len()).collect();
        slots.par_chunks(PIECE).try_for_each(|slots| {
            task.check()?;
            slots.iter().for_each(|slot| self.mark_crossed_by(*slot, positions, &tree, &crossed));
            Ok(())
        })?;
        let marks = crossed.into_iter().map(AtomicBool::into_inner).zip(0..);
        Ok(marks.filter_map(|(is_crossed, triangle)| is_crossed.then_some(triangle)).collect())
    }

    /// Marks the triangle in `slot` and those that it passes through: those in later slots and, of the ones that share a
    /// corner with it, those that its own edge goes through.
    fn mark_crossed_by(&self, slot: usize, positions: &[Vec3], tree: &BoxTree, crossed: &[AtomicBool]) {
        let here = tree.order()[slot];
        let s = self.surface.triangles[here as usize];
        let around = bounds(&self.surface, here, positions);
        self.search_near(s, &around, positions, tree, |other, limit| {
            let there = tree.order()[other];
            let t = self.surface.triangles[there as usize];
            let touch = s.iter().any(|v| t.contains(v));
            if other == slot || (other < slot && !touch) {
                return limit;
            }
            let marks = [here, there].map(|t| &crossed[t as usize]);
            // A mark that is read too early only costs another test.
            if marks.iter().all(|mark| mark.load(Relaxed)) {
                return limit;
            }
            let crosses = if touch {
                goes_into(s, t, positions)
            } else {
                around.meets(&bounds(&self.surface, there, positions))
                    && (goes_into(s, t, positions) || goes_into(t, s, positions))
            };
            if crosses {
                marks.iter().for_each(|mark| mark.store(true, Relaxed));
            }
            limit
        });
    }

    /// Visits the leaves of `tree` that triangle `s`, whose box is `around`, may cross.
    fn search_near(
        &self,
        s: [u32; 3],
        around: &Bounds,
        positions: &[Vec3],
        tree: &BoxTree,
        visit: impl FnMut(usize, f64) -> f64,
    ) {
        let nearness = |node: usize, inner: &Bounds| {
            let is_near = match s.iter().position(|v| self.shared[node].contains(v)) {
                // In a fan every box meets every other, but the edge opposite the shared corner meets few.
                Some(i) => {
                    let opposite = [s[(i + 1) % 3], s[(i + 2) % 3]];
                    Bounds::of(opposite.map(|v| positions[v as usize])).meets(inner)
                }
                None => inner.meets(around),
            };
            if is_near { 0.0 } else { f64::INFINITY }
        };
        tree.search_nodes(f64::INFINITY, nearness, visit);
    }
}

fn bounds(surface: &Surface, triangle: u32, positions: &[Vec3]) -> Bounds {
    Bounds::of(corners(positions, &surface.triangles[triangle as usize]))
}

/// Whether an edge of `triangle` goes through the inside of `face`. Edges at a shared corner cannot.
fn goes_into(triangle: [u32; 3], face: [u32; 3], positions: &[Vec3]) -> bool {
    (0..3).any(|i| {
        let (p, q) = (triangle[i], triangle[(i + 1) % 3]);
        !face.contains(&p) && !face.contains(&q) && goes_through(p, q, face, positions)
    })
}

/// Whether the segment pq goes through the inside of `face`.
fn goes_through(p: u32, q: u32, face: [u32; 3], positions: &[Vec3]) -> bool {
    let at = |v: u32| positions[v as usize];
    let [a, b, c] = face.map(at);
    let (p, q) = (at(p), at(q));
    let normal = doubled_area_normal([a, b, c]);
    let (above, below) = (dot(normal, sub(p, a)), dot(normal, sub(q, a)));
    let both_sides = above * below < 0.0;
    // The sides on which the line pq passes the three edges: the volumes of pq with each.
    let side = |a: Vec3, b: Vec3| dot(sub(q, p), cross(sub(a, p), sub(b, p)));
    let sides = [side(a, b), side(b, c), side(c, a)];
    both_sides && (sides.iter().all(|s| *s > 0.0) || sides.iter().all(|s| *s < 0.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::icosphere;
    use proptest::prelude::*;

    fn crossings(positions: Vec<Vec3>, triangles: Vec<[u32; 3]>) -> Vec<u32> {
        let frame = chladni_mesh::Frame { center: [0.0; 3], scale: 1.0 };
        let surface = Arc::new(Surface::of(positions, triangles, frame));
        Crossings::of(surface.clone()).triangles(&surface.positions, &Task::new()).unwrap()
    }

    /// Two spheres of radius 1 whose centers lie `apart`.
    fn two_spheres(apart: f64) -> (Vec<Vec3>, Vec<[u32; 3]>) {
        let (points, triangles) = icosphere(3);
        let n = points.len() as u32;
        // Turned a little, so that no two edges lie in one plane.
        let (sin, cos) = 0.3_f64.sin_cos();
        let turned = |p: &Vec3| [p[0], cos * p[1] - sin * p[2], sin * p[1] + cos * p[2]];
        let second = points.iter().map(|p| add(turned(p), [apart, 0.01, 0.02]));
        let both = points.iter().copied().chain(second).collect();
        let shifted = triangles.iter().map(|t| t.map(|v| v + n));
        (both, triangles.iter().copied().chain(shifted).collect())
    }

    #[test]
    fn nothing_crosses_in_a_shape_that_is_a_point_but_for_rounding() {
        let (points, triangles) = two_spheres(1.2);
        let frame = chladni_mesh::Frame { center: [0.0; 3], scale: 1.0 };
        let surface = Arc::new(Surface::of(points.clone(), triangles, frame));
        let crossings = Crossings::of(surface);
        let near = |by: f64| -> Vec<Vec3> { points.iter().map(|p| add([0.3; 3], scaled(*p, by))).collect() };
        let count = |by: f64| crossings.triangles(&near(by), &Task::new()).unwrap().len();
        assert!(count(1e-5) > 40 && count(1e-12) == 0);
    }

    #[test]
    fn two_spheres_cross_in_a_ring_that_lies_where_the_spheres_meet() {
        assert_eq!(crossings(two_spheres(2.1).0, two_spheres(2.1).1), Vec::<u32>::new());
        let (points, triangles) = two_spheres(1.2);
        let found = crossings(points.clone(), triangles.clone());
        // The spheres meet in a circle at x = 0.6; an edge is at most 0.2 long.
        assert!(found.len() > 40 && found.len() < 400, "{}", found.len());
        for t in &found {
            let xs = triangles[*t as usize].map(|v| points[v as usize][0]);
            assert!(xs.iter().any(|x| (x - 0.6).abs() < 0.2), "{xs:?}");
        }
        let first = triangles.len() as u32 / 2;
        let here = found.iter().filter(|t| **t < first).count();
        assert!(here > 20 && found.len() - here > 20, "both spheres are found");
    }

    #[test]
    fn a_sphere_pushed_through_its_own_wall_is_seen_though_nothing_turned_over_at_the_tip() {
        let (points, triangles) = icosphere(3);
        assert!(crossings(points.clone(), triangles.clone()).is_empty());
        // A cap is pushed out through the other side.
        let pushed = |p: &Vec3| if p[2] > 0.9 { [p[0], p[1], p[2] - 2.3] } else { *p };
        let moved: Vec<Vec3> = points.iter().map(pushed).collect();
        assert!(crossings(moved, triangles).len() > 10);
    }

    #[test]
    fn a_cancelled_search_ends() {
        let (points, triangles) = icosphere(2);
        let frame = chladni_mesh::Frame { center: [0.0; 3], scale: 1.0 };
        let surface = Arc::new(Surface::of(points, triangles, frame));
        let task = Task::new();
        task.cancel();
        assert!(Crossings::of(surface.clone()).triangles(&surface.positions, &task).is_err());
    }

    #[test]
    fn a_large_fan_is_searched_by_its_rim() {
        let n = 50_000_u32;
        let on_rim = |i: u32| {
            let (sin, cos) = (std::f64::consts::TAU * f64::from(i) / f64::from(n)).sin_cos();
            [cos, sin, 0.0]
        };
        let tip = [[0.0, 0.0, 0.3]];
        let mut points: Vec<Vec3> = tip.into_iter().chain((0..n).map(on_rim)).collect();
        let mut triangles: Vec<[u32; 3]> = (0..n).map(|i| [0, 1 + i, 1 + (i + 1) % n]).collect();
        assert!(crossings(points.clone(), triangles.clone()).is_empty());
        let frame = chladni_mesh::Frame { center: [0.0; 3], scale: 1.0 };
        let search = Crossings::of(Arc::new(Surface::of(points.clone(), triangles.clone(), frame)));
        for t in (0..n).step_by(997) {
            let mut visits = 0;
            let around = bounds(&search.surface, t, &points);
            search.search_near(triangles[t as usize], &around, &points, &search.tree, |_, limit| {
                visits += 1;
                limit
            });
            assert!(visits < 100, "{visits} for triangle {t}");
        }
        // A needle through the middle of the tenth triangle.
        let middle = scaled(corners(&points, &triangles[10]).into_iter().fold([0.0; 3], add), 1.0 / 3.0);
        points.extend([0.5, -0.5, -0.5].map(|z| add(middle, [0.0, 0.0, z])));
        points[n as usize + 3][0] += 1e-7;
        triangles.push([n + 1, n + 2, n + 3]);
        assert_eq!(crossings(points, triangles), [10, n]);
    }

    fn by_trying_all_pairs(points: &[Vec3], triangles: &[[u32; 3]]) -> Vec<u32> {
        let mut expected = Vec::new();
        for i in 0..triangles.len() {
            for j in 0..i {
                let (s, t) = (triangles[i], triangles[j]);
                if goes_into(s, t, points) || goes_into(t, s, points) {
                    expected.extend([i as u32, j as u32]);
                }
            }
        }
        expected.sort_unstable();
        expected.dedup();
        expected
    }

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(64) })]
        #[test]
        fn the_tree_finds_what_trying_all_pairs_finds(
            points in prop::collection::vec([-1.0..1.0_f64, -1.0..1.0, -1.0..1.0], 4..40),
            picks in prop::collection::vec([0_usize..40, 0..40, 0..40], 1..50),
        ) {
            let triangles: Vec<[u32; 3]> =
                picks.iter().map(|t| t.map(|v| (v % points.len()) as u32)).collect();
            let expected = by_trying_all_pairs(&points, &triangles);
            prop_assert_eq!(crossings(points, triangles), expected);
        }

        #[test]
        fn so_it_does_in_two_crumpled_fans(
            points in prop::collection::vec([-1.0..1.0_f64, -1.0..1.0, -1.0..1.0], 8..60),
        ) {
            let n = points.len() as u32;
            let triangles: Vec<[u32; 3]> = (2..n - 1).flat_map(|i| [[0, i, i + 1], [1, i + 1, i]]).collect();
            let expected = by_trying_all_pairs(&points, &triangles);
            prop_assert_eq!(crossings(points, triangles), expected);
        }

        #[test]
        fn a_crossing_has_a_point_in_common(
            p in prop::array::uniform6([-1.0..1.0_f64, -1.0..1.0, -1.0..1.0]),
        ) {
            // Against sampling: an edge that goes through leaves samples on both sides, and the
            // point where it meets the plane has positive weights.
            let through = goes_through(0, 1, [2, 3, 4], &p);
            let normal = doubled_area_normal([p[2], p[3], p[4]]);
            let (above, below) = (dot(normal, sub(p[0], p[2])), dot(normal, sub(p[1], p[2])));
            let t = above / (above - below);
            let meets = add(p[0], scaled(sub(p[1], p[0]), t));
            let weight = |a: Vec3, b: Vec3| dot(normal, cross(sub(b, a), sub(meets, a)));
            let inside = [weight(p[2], p[3]), weight(p[3], p[4]), weight(p[4], p[2])];
            let clear = inside.iter().all(|w| w.abs() > 1e-9) && above.abs() > 1e-9 && below.abs() > 1e-9;
            prop_assume!(clear);
            prop_assert_eq!(through, (0.0..1.0).contains(&t) && inside.iter().all(|w| *w > 0.0));
        }
    }
}
