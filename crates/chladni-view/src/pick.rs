//! Which triangle lies under a pixel: a bounding-volume hierarchy that follows a moving mesh.

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
    nodes: Vec<Node>,
    /// Triangle indices in the order of the leaves.
    order: Vec<u32>,
}

/// An inner node's left child follows it; a leaf covers `order[start..start + count]`.
#[derive(Clone, Copy, Debug)]
struct Node {
    low: Vec3,
    high: Vec3,
    /// Right child of an inner node, first triangle of a leaf.
    start: u32,
    /// Triangles of a leaf, 0 for an inner node.
    count: u32,
}

const LEAF: usize = 4;

impl PickTree {
    /// The tree of `triangles` at `positions`. A triangle with an index out of range, or a
    /// coordinate that is not finite, can never be hit.
    pub fn new(positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> Self {
        let mut order: Vec<u32> = (0..triangles.len() as u32).collect();
        let centers: Vec<Vec3> = triangles
            .iter()
            .map(|t| corners(positions, *t).map_or(Vec3::ZERO, |[a, b, c]| (a + b + c) / 3.0))
            .map(|c| if c.is_finite() { c } else { Vec3::ZERO })
            .collect();
        let mut tree = Self { nodes: Vec::with_capacity(triangles.len().max(1)), order: Vec::new() };
        if !order.is_empty() {
            tree.split(&mut order, 0, &centers);
        }
        tree.order = order;
        tree.refit(positions, triangles);
        tree
    }

    /// Halves `order` at its median along the widest axis, so that depth is log₂ of the count.
    fn split(&mut self, order: &mut [u32], first: u32, centers: &[Vec3]) {
        let node = self.nodes.len();
        let leaf = order.len() <= LEAF;
        self.nodes.push(Node {
            low: Vec3::INFINITY,
            high: Vec3::NEG_INFINITY,
            start: first,
            count: if leaf { order.len() as u32 } else { 0 },
        });
        if leaf {
            return;
        }
        let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        for &t in order.iter() {
            (low, high) = (low.min(centers[t as usize]), high.max(centers[t as usize]));
        }
        let axis = (high - low).max_position();
        let half = order.len() / 2;
        order.select_nth_unstable_by(half, |a, b| {
            centers[*a as usize][axis].total_cmp(&centers[*b as usize][axis])
        });
        let (left, right) = order.split_at_mut(half);
        self.split(left, first, centers);
        self.nodes[node].start = self.nodes.len() as u32;
        self.split(right, first + half as u32, centers);
    }

    /// Follows the vertices to `positions`; `triangles` are those the tree was built with.
    pub fn refit(&mut self, positions: &[[f32; 3]], triangles: &[[u32; 3]]) {
        // Children come after their parent.
        for i in (0..self.nodes.len()).rev() {
            let node = self.nodes[i];
            let (low, high) = if node.count == 0 {
                let (left, right) = (self.nodes[i + 1], self.nodes[node.start as usize]);
                (left.low.min(right.low), left.high.max(right.high))
            } else {
                let leaf = &self.order[node.start as usize..(node.start + node.count) as usize];
                let mut bounds = (Vec3::INFINITY, Vec3::NEG_INFINITY);
                for t in leaf.iter().filter_map(|t| triangles.get(*t as usize)) {
                    for p in corners(positions, *t).into_iter().flatten().filter(|p| p.is_finite()) {
                        bounds = (bounds.0.min(p), bounds.1.max(p));
                    }
                }
                bounds
            };
            (self.nodes[i].low, self.nodes[i].high) = (low, high);
        }
    }

    /// The first triangle on `ray`, from either side. `positions` are those of the last
    /// [`refit`](Self::refit).
    pub fn pick(&self, ray: &Ray, positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> Option<Hit> {
        let (origin, direction) = (Vec3::from(ray.origin), Vec3::from(ray.direction));
        // Finite, so that a ray in the plane of a box's side gives 0 and not 0 · ∞.
        let inverse = direction.recip().clamp(Vec3::splat(-1e30), Vec3::splat(1e30));
        let sheared = Shear::new(origin, direction);
        let mut nearest: Option<Hit> = None;
        // The median split keeps the depth below 33 for any u32 count.
        let mut stack = [0_u32; 64];
        let mut waiting = usize::from(!self.nodes.is_empty());
        while waiting > 0 {
            waiting -= 1;
            let index = stack[waiting] as usize;
            let node = &self.nodes[index];
            let limit = nearest.map_or(f32::INFINITY, |hit| hit.distance);
            if !meets(node, origin, inverse, limit) {
                continue;
            }
            if node.count == 0 {
                stack[waiting] = node.start;
                stack[waiting + 1] = index as u32 + 1;
                waiting += 2;
                continue;
            }
            for &t in &self.order[node.start as usize..(node.start + node.count) as usize] {
                let Some(at) = triangles.get(t as usize).and_then(|c| corners(positions, *c)) else {
                    continue;
                };
                if let Some((distance, barycentric)) = sheared.meet(at)
                    && nearest.is_none_or(|hit| distance < hit.distance)
                {
                    nearest = Some(Hit { triangle: t, barycentric, distance });
                }
            }
        }
        nearest
    }
}

fn corners(positions: &[[f32; 3]], triangle: [u32; 3]) -> Option<[Vec3; 3]> {
    let at = |v: u32| positions.get(v as usize).copied().map(Vec3::from);
    Some([at(triangle[0])?, at(triangle[1])?, at(triangle[2])?])
}

/// Slab test against a box, up to `limit` along the ray.
fn meets(node: &Node, origin: Vec3, inverse: Vec3, limit: f32) -> bool {
    let (a, b) = ((node.low - origin) * inverse, (node.high - origin) * inverse);
    let (enter, leave) = (a.min(b), a.max(b));
    let enter = enter.x.max(enter.y).max(enter.z).max(0.0);
    let leave = leave.x.min(leave.y).min(leave.z).min(limit);
    // Ize, "Robust BVH Ray Traversal", JCGT 2013: the far side is moved by the rounding error.
    enter <= leave * 1.000_001 + f32::MIN_POSITIVE
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
        // Doubled areas in f64, which represents these products exactly: neighbours agree on
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
