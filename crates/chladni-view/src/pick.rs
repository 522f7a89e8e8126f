//! Which triangle lies under a pixel: a bounding-volume hierarchy that follows a moving mesh.

use chladni_mesh::surface::{Bounds, BoxTree};
use glam::Vec3;

/// A half-line; the direction is of length 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Where it starts.
    pub origin: [f32; 3],
    /// Where it goes.
    pub direction: [f32; 3],
}

/// Where a [`Ray`] meets a mesh first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Index of the triangle.
    pub triangle: u32,
    /// Weights of the triangle's corners; not negative, sum 1.
    pub barycentric: [f32; 3],
    /// Along the ray from its origin.
    pub distance: f32,
}

impl Hit {
    /// The corner of the triangle nearest to the hit, by weight.
    pub fn nearest_corner(&self) -> usize {
        let [a, b, c] = self.barycentric;
        if a >= b && a >= c {
            0
        } else if b >= c {
            1
        } else {
            2
        }
    }

    /// The point hit.
    pub fn point(&self, ray: &Ray) -> [f32; 3] {
        (Vec3::from(ray.origin) + Vec3::from(ray.direction) * self.distance).to_array()
    }
}

/// A tree of boxes over the triangles of one mesh. Its shape is fixed when it is built;
/// [`refit`](Self::refit) follows the vertices in linear time.
#[derive(Clone, Debug)]
pub struct PickTree {
    tree: BoxTree,
}

/// How much nearer a box is taken to be than it is, as a share: distances of hits are f32.
const SLACK: f64 = 1e-6;
/// How far in front of a point of the surface its view begins, so that its own triangles do not hide it; a
/// share of the size of the shape.
const CLEARANCE: f64 = 2e-3;

impl PickTree {
    /// The tree of `triangles` at `positions`. A triangle with an index out of range, or a
    /// coordinate that is not finite, can never be hit.
    pub fn new(positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> Self {
        let center = |t: &[u32; 3]| {
            let center = corners(positions, *t).map_or(Vec3::ZERO, |[a, b, c]| (a + b + c) / 3.0);
            (if center.is_finite() { center } else { Vec3::ZERO }).as_dvec3().to_array()
        };
        let centers: Vec<[f64; 3]> = triangles.iter().map(center).collect();
        Self { tree: BoxTree::new(&centers, |t| bounds(t, positions, triangles)) }
    }

    /// Follows the vertices to `positions`; `triangles` are those the tree was built with.
    pub fn refit(&mut self, positions: &[[f32; 3]], triangles: &[[u32; 3]]) {
        self.tree.fit(|t| bounds(t, positions, triangles));
    }

    /// The first triangle on `ray`, from either side. `positions` are those of the last
    /// [`refit`](Self::refit).
    pub fn pick(&self, ray: &Ray, positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> Option<Hit> {
        let (origin, direction) = (Vec3::from(ray.origin), Vec3::from(ray.direction));
        let sheared = Shear::new(origin, direction);
        let origin = origin.as_dvec3().to_array();
        // Finite, so that a ray in the plane of a box's side gives 0 and not 0 · ∞.
        let inverse = direction.as_dvec3().to_array().map(|d| d.recip().clamp(-1e30, 1e30));
        let mut nearest: Option<Hit> = None;
        self.tree.search(
            f64::INFINITY,
            |bounds| entry(bounds, origin, inverse),
            |slot, limit| {
                let triangle = self.tree.order()[slot];
                let at = triangles.get(triangle as usize).and_then(|t| corners(positions, *t));
                if let Some((distance, barycentric)) = at.and_then(|at| sheared.meet(at))
                    && nearest.is_none_or(|hit| distance < hit.distance)
                {
                    nearest = Some(Hit { triangle, barycentric, distance });
                    return f64::from(distance);
                }
                limit
            },
        );
        nearest
    }

    /// Whether a triangle stands between `eye` and `point` on the surface, other than those right at the
    /// point. `positions` are those of the last [`refit`](Self::refit).
    pub fn blocks(
        &self,
        eye: [f64; 3],
        point: [f64; 3],
        positions: &[[f32; 3]],
        triangles: &[[u32; 3]],
    ) -> bool {
        let Some((ray, distance)) = self.view(eye, point) else { return false };
        let hit = self.pick(&ray, positions, triangles);
        hit.is_some_and(|hit| f64::from(hit.distance) < distance)
    }

    /// The triangle that `eye` sees right at `point` on the surface, of those that [`blocks`](Self::blocks) passes
    /// over; `None` where it sees past them. `positions` are those of the last [`refit`](Self::refit).
    pub fn seen_at(
        &self,
        eye: [f64; 3],
        point: [f64; 3],
        positions: &[[f32; 3]],
        triangles: &[[u32; 3]],
    ) -> Option<u32> {
        let (Ray { origin, direction }, _) = self.view(eye, point)?;
        let ray = Ray { origin, direction: direction.map(|x| -x) };
        let hit = self.pick(&ray, positions, triangles)?;
        // A triangle of the point itself is met there, but for rounding.
        (f64::from(hit.distance) < 1.001 * self.clearance()).then_some(hit.triangle)
    }

    /// The half-line from right in front of `point` toward `eye`, and how far that is; `None` where it is at the point.
    fn view(&self, eye: [f64; 3], point: [f64; 3]) -> Option<(Ray, f64)> {
        let [eye, point] = [eye, point].map(glam::DVec3::from);
        let (way, clearance) = (eye - point, self.clearance());
        let direction = way.try_normalize().filter(|_| way.length() > clearance)?;
        let ray = Ray {
            origin: (point + direction * clearance).as_vec3().to_array(),
            direction: direction.as_vec3().to_array(),
        };
        Some((ray, way.length() - clearance))
    }

    fn clearance(&self) -> f64 {
        CLEARANCE * self.tree.bounds().diagonal()
    }
}

fn bounds(triangle: u32, positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> Bounds {
    let at = triangles.get(triangle as usize).and_then(|t| corners(positions, *t));
    let finite = at.into_iter().flatten().filter(|p| p.is_finite());
    Bounds::of(finite.map(|p| p.as_dvec3().to_array()))
}

fn corners(positions: &[[f32; 3]], triangle: [u32; 3]) -> Option<[Vec3; 3]> {
    let at = |v: u32| positions.get(v as usize).copied().map(Vec3::from);
    Some([at(triangle[0])?, at(triangle[1])?, at(triangle[2])?])
}

/// How far along the ray a box begins, by its slabs; infinite where the ray misses it.
fn entry(bounds: &Bounds, origin: [f64; 3], inverse: [f64; 3]) -> f64 {
    let (mut enter, mut leave) = (0.0_f64, f64::INFINITY);
    for i in 0..3 {
        let a = (bounds.low[i] - origin[i]) * inverse[i];
        let b = (bounds.high[i] - origin[i]) * inverse[i];
        (enter, leave) = (enter.max(a.min(b)), leave.min(a.max(b)));
    }
    if enter * (1.0 - SLACK) <= leave { enter * (1.0 - SLACK) } else { f64::INFINITY }
}

/// A ray turned so that it runs along +z, for tests that let nothing through between two
/// triangles: Woop, Benthin & Wald, "Watertight Ray/Triangle Intersection", JCGT 2013.
struct Shear {
    origin: Vec3,
    /// Which coordinate becomes x, y and z.
    axes: [usize; 3],
    shear: Vec3,
}

impl Shear {
    fn new(origin: Vec3, direction: Vec3) -> Self {
        let z = direction.abs().max_position();
        let axes = [(z + 1) % 3, (z + 2) % 3, z];
        let d = axes.map(|i| direction[i]);
        Self { origin, axes, shear: Vec3::new(d[0] / d[2], d[1] / d[2], 1.0 / d[2]) }
    }

    /// Distance and barycentric weights where the ray meets a triangle, from either side.
    fn meet(&self, corners: [Vec3; 3]) -> Option<(f32, [f32; 3])> {
        let p = corners.map(|corner| {
            let v = corner - self.origin;
            let [x, y, z] = self.axes.map(|i| v[i]);
            Vec3::new(x - self.shear.x * z, y - self.shear.y * z, self.shear.z * z)
        });
        // Doubled areas in f64, which represents these products exactly: neighbors agree on
        // which side of their edge the ray passes.
        let edge = |a: Vec3, b: Vec3| f64::from(a.x) * f64::from(b.y) - f64::from(a.y) * f64::from(b.x);
        let weights = [edge(p[1], p[2]), edge(p[2], p[0]), edge(p[0], p[1])];
        let sum: f64 = weights.iter().sum();
        let inside = weights.iter().all(|w| *w >= 0.0) || weights.iter().all(|w| *w <= 0.0);
        if !inside || sum == 0.0 || !sum.is_finite() {
            return None;
        }
        let barycentric = weights.map(|w| (w / sum) as f32);
        let distance: f32 = (0..3).map(|i| barycentric[i] * p[i].z).sum();
        (distance > 0.0).then_some((distance, barycentric))
    }
}
