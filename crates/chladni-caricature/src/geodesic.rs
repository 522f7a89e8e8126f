//! Distances along the surface, from a point out to a radius.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use crate::{Surface, SurfacePoint};
use chladni_mesh::surface::vec3::{Vec3, distance};

/// A vertex in the queue with its distance; the top of the heap is the nearest.
struct Front {
    distance: f64,
    vertex: u32,
}

impl Ord for Front {
    fn cmp(&self, other: &Self) -> Ordering {
        other.distance.total_cmp(&self.distance)
    }
}
impl PartialOrd for Front {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
impl PartialEq for Front {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}
impl Eq for Front {}

impl Surface {
    /// Where `point` lies at rest, working frame; `None` where there is no such triangle.
    pub fn position(&self, point: &SurfacePoint) -> Option<Vec3> {
        point.position(&self.triangles, |v| self.positions[v as usize])
    }

    /// The vertex nearest to `point` in space, as a point on the surface.
    pub fn nearest_vertex(&self, point: Vec3) -> Option<SurfacePoint> {
        self.nearest_corner(point, |_| true)
    }

    /// The same, as a corner of a `wanted` triangle where one around it is.
    pub(crate) fn nearest_corner(&self, point: Vec3, wanted: impl Fn(u32) -> bool) -> Option<SurfacePoint> {
        let squared = |v: usize| {
            let d = distance(self.positions[v], point);
            d * d
        };
        let v = (0..self.vertices()).min_by(|a, b| squared(*a).total_cmp(&squared(*b)))? as u32;
        let around = self.triangles_around(v);
        let triangle = *around.iter().find(|t| wanted(**t)).or(around.first())?;
        let corners = self.triangles.get(triangle as usize)?;
        corners.iter().position(|c| *c == v).map(|corner| SurfacePoint::at_corner(triangle, corner))
    }

    /// How far the vertices around `start` are from it along the surface, with every vertex where
    /// `at` puts it and only triangles that `passes` allows: those within `radius`, nearest first,
    /// then their neighbors beyond it. Empty where there is no such triangle.
    ///
    /// Fast marching (Kimmel & Sethian 1998) with each front edge unfolded about a virtual
    /// source: exact on flat parts, within a few percent elsewhere, and never shorter than the
    /// straight line by more than rounding.
    pub(crate) fn march(
        &self,
        start: &SurfacePoint,
        radius: f64,
        at: impl Fn(u32) -> Vec3,
        passes: impl Fn(u32) -> bool,
    ) -> Marched {
        let mut marched = Marched::default();
        let Some(origin) = start.position(&self.triangles, &at) else { return marched };
        let mut best = vec![f64::INFINITY; self.vertices()];
        let mut done = vec![false; self.vertices()];
        let mut front = BinaryHeap::new();
        let mut touched = Vec::new();
        for &v in &self.triangles[start.triangle as usize] {
            best[v as usize] = distance(origin, at(v));
            touched.push(v);
            front.push(Front { distance: best[v as usize], vertex: v });
        }
        while let Some(Front { distance: d, vertex: v }) = front.pop() {
            if done[v as usize] || d > best[v as usize] {
                continue;
            }
            if d > radius {
                break;
            }
            done[v as usize] = true;
            marched.distances.push((v, d));
            for &t in self.triangles_around(v).iter().filter(|t| passes(**t)) {
                marched.triangles.push(t);
                for &w in &self.triangles[t as usize] {
                    if done[w as usize] {
                        continue;
                    }
                    let candidate = self.through(t, v, w, &best, &done, &at);
                    if candidate < best[w as usize] {
                        if best[w as usize] == f64::INFINITY {
                            touched.push(w);
                        }
                        best[w as usize] = candidate;
                        front.push(Front { distance: candidate, vertex: w });
                    }
                }
            }
        }
        touched.sort_unstable();
        touched.dedup();
        let beyond = touched.into_iter().filter(|v| !done[*v as usize]);
        marched.distances.extend(beyond.map(|v| (v, best[v as usize])));
        marched.triangles.sort_unstable();
        marched.triangles.dedup();
        marched
    }

    /// The distance of `w` through triangle `t`. Its corner `v` is settled, and its third corner may be.
    fn through(&self, t: u32, v: u32, w: u32, best: &[f64], done: &[bool], at: &impl Fn(u32) -> Vec3) -> f64 {
        let along_edge = best[v as usize] + distance(at(v), at(w));
        let third = self.triangles[t as usize].into_iter().find(|u| *u != v && *u != w);
        let Some(u) = third.filter(|u| done[*u as usize]) else { return along_edge };
        let across = unfolded(at(v), at(u), at(w), best[v as usize], best[u as usize]);
        along_edge.min(across.unwrap_or(f64::INFINITY))
    }
}

/// The part of a surface that a march reached.
#[derive(Debug, Default)]
pub(crate) struct Marched {
    /// Vertices and their distances.
    pub distances: Vec<(u32, f64)>,
    /// The triangles that it passed through, ascending; all their corners have a distance.
    pub triangles: Vec<u32>,
}

/// The distance to `c` from the virtual source that lies at distances `da`, `db` from a and b in
/// the triangle's plane, on the far side of ab; `None` where the straight way misses ab.
fn unfolded(a: Vec3, b: Vec3, c: Vec3, da: f64, db: f64) -> Option<f64> {
    let (ab, ac, bc) = (distance(a, b), distance(a, c), distance(b, c));
    if ab <= 0.0 {
        return None;
    }
    let cx = (ac * ac - bc * bc + ab * ab) / (2.0 * ab);
    let cy = (ac * ac - cx * cx).max(0.0).sqrt();
    let sx = (da * da - db * db + ab * ab) / (2.0 * ab);
    let sy = (da * da - sx * sx).max(0.0).sqrt();
    let height = cy + sy;
    if height <= 0.0 {
        return None;
    }
    let crossing = sx + (cx - sx) * sy / height;
    (0.0..=ab).contains(&crossing).then(|| (cx - sx).hypot(height))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::icosphere;
    use chladni_mesh::Frame;
    use chladni_mesh::surface::vec3::{dot, scaled};

    const FILE: Frame = Frame { center: [0.0; 3], scale: 1.0 };

    fn within(surface: &Surface, start: &SurfacePoint, radius: f64) -> Vec<(u32, f64)> {
        let marched = surface.march(start, radius, |v| surface.positions[v as usize], |_| true);
        marched.distances.into_iter().filter(|(_, d)| *d <= radius).collect()
    }

    #[test]
    fn on_a_sphere_distances_are_arcs() {
        let (points, triangles) = icosphere(4);
        let surface = Surface::of(points, triangles, FILE);
        let start = SurfacePoint { triangle: 100, weights: [0.2, 0.5, 0.3] };
        let origin = surface.position(&start).unwrap();
        let origin = scaled(origin, 1.0 / dot(origin, origin).sqrt());
        let reached = within(&surface, &start, 2.0);
        assert!(reached.len() > 1000);
        assert!(reached.windows(2).all(|w| w[0].1 <= w[1].1));
        for (v, d) in reached {
            let arc = dot(surface.positions[v as usize], origin).clamp(-1.0, 1.0).acos();
            assert!((d - arc).abs() < 0.01 + 0.02 * arc, "{d} against {arc}");
        }
    }

    #[test]
    fn on_a_plane_distances_are_straight() {
        let side = 21_u32;
        let positions: Vec<Vec3> =
            (0..side * side).map(|i| [f64::from(i % side), f64::from(i / side), 0.0]).collect();
        let cells = (0..side - 1).flat_map(|y| (0..side - 1).map(move |x| y * side + x));
        let triangles = cells.flat_map(|v| [[v, v + 1, v + side + 1], [v, v + side + 1, v + side]]).collect();
        let surface = Surface::of(positions, triangles, FILE);
        let start = surface.nearest_vertex([10.2, 9.9, 3.0]).unwrap();
        let origin = surface.position(&start).unwrap();
        assert_eq!(origin, [10.0, 10.0, 0.0]);
        let reached = within(&surface, &start, 8.0);
        let expected = surface.positions.iter().filter(|p| distance(**p, origin) <= 7.8).count();
        assert!(reached.len() >= expected);
        for (v, d) in reached {
            let straight = distance(surface.positions[v as usize], origin);
            assert!(d >= straight - 1e-9 && d <= 1.03 * straight + 1e-9, "{d} against {straight}");
        }
    }
}
