//! Closest points on triangles, through a bounding volume hierarchy.

use glam::DVec3;

/// A point of a triangle mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SurfacePoint {
    /// Index of the triangle in the list the tree was built from.
    pub triangle: u32,
    /// Weights of its corners: ≥ 0, summing to 1.
    pub barycentric: [f64; 3],
    /// The point itself.
    pub point: DVec3,
    /// Squared distance from the query.
    pub distance_squared: f64,
}

/// Triangles of one tree leaf.
const LEAF: usize = 4;

#[derive(Clone, Debug)]
struct Node {
    low: DVec3,
    high: DVec3,
    /// Leaf: first slot in `order`. Inner: index of the right child (the left one follows).
    next: u32,
    /// Triangles of a leaf; 0 for an inner node.
    count: u32,
}

/// The tree, with the corners of its triangles in the order of the leaves.
#[derive(Clone, Debug)]
pub(crate) struct Bvh {
    nodes: Vec<Node>,
    order: Vec<u32>,
    corners: Vec<[DVec3; 3]>,
}

impl Bvh {
    /// Splits at the median of the longest axis of the centroids: depth ≤ ⌈log₂ m⌉ for any input.
    pub fn new(points: &[DVec3], triangles: &[[u32; 3]]) -> Self {
        let corner = |t: u32| triangles[t as usize].map(|v| points[v as usize]);
        let centroids: Vec<DVec3> = (0..triangles.len() as u32)
            .map(|t| {
                let [a, b, c] = corner(t);
                (a + b + c) / 3.0
            })
            .collect();
        let mut order: Vec<u32> = (0..triangles.len() as u32).collect();
        let mut nodes = Vec::with_capacity(2 * triangles.len() / LEAF + 1);
        if !order.is_empty() {
            split(&mut order, 0, &centroids, &corner, &mut nodes);
        }
        let corners = order.iter().map(|t| corner(*t)).collect();
        Self { nodes, order, corners }
    }

    /// The closest point nearer than `reach`; `None` where there is none.
    pub fn closest(&self, query: DVec3, reach: f64) -> Option<SurfacePoint> {
        let mut best_squared = reach * reach;
        let mut best = None;
        let mut stack = [0_u32; 64];
        let mut depth = usize::from(!self.nodes.is_empty());
        while depth > 0 {
            depth -= 1;
            let index = stack[depth] as usize;
            let node = &self.nodes[index];
            if box_distance_squared(node, query) >= best_squared {
                continue;
            }
            if node.count > 0 {
                let first = node.next as usize;
                for slot in first..first + node.count as usize {
                    let (point, barycentric) = closest_on_triangle(query, &self.corners[slot]);
                    let d = query.distance_squared(point);
                    if d < best_squared {
                        best_squared = d;
                        best = Some(SurfacePoint {
                            triangle: self.order[slot],
                            barycentric,
                            point,
                            distance_squared: d,
                        });
                    }
                }
                continue;
            }
            let (left, right) = (index as u32 + 1, node.next);
            let dl = box_distance_squared(&self.nodes[left as usize], query);
            let dr = box_distance_squared(&self.nodes[right as usize], query);
            let (near, far) = if dl <= dr { (left, right) } else { (right, left) };
            stack[depth] = far;
            stack[depth + 1] = near;
            depth += 2;
        }
        best
    }
}

fn split(
    order: &mut [u32],
    first: u32,
    centroids: &[DVec3],
    corner: &impl Fn(u32) -> [DVec3; 3],
    nodes: &mut Vec<Node>,
) {
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let (mut c_low, mut c_high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for &t in order.iter() {
        for p in corner(t) {
            low = low.min(p);
            high = high.max(p);
        }
        c_low = c_low.min(centroids[t as usize]);
        c_high = c_high.max(centroids[t as usize]);
    }
    let here = nodes.len();
    if order.len() <= LEAF {
        nodes.push(Node { low, high, next: first, count: order.len() as u32 });
        return;
    }
    nodes.push(Node { low, high, next: 0, count: 0 });
    let extent = c_high - c_low;
    let axis = (0..3).max_by(|&i, &j| extent[i].total_cmp(&extent[j])).unwrap_or(0);
    let middle = order.len() / 2;
    order.select_nth_unstable_by(middle, |&s, &t| {
        centroids[s as usize][axis].total_cmp(&centroids[t as usize][axis]).then(s.cmp(&t))
    });
    let (left, right) = order.split_at_mut(middle);
    split(left, first, centroids, corner, nodes);
    nodes[here].next = nodes.len() as u32;
    split(right, first + middle as u32, centroids, corner, nodes);
}

fn box_distance_squared(node: &Node, query: DVec3) -> f64 {
    (query - query.clamp(node.low, node.high)).length_squared()
}

/// The closest point of a triangle and its barycentric coordinates (Ericson, *Real-Time
/// Collision Detection*, 5.1.5). Triangles of zero area give a point of their longest edge.
pub(crate) fn closest_on_triangle(p: DVec3, &[a, b, c]: &[DVec3; 3]) -> (DVec3, [f64; 3]) {
    let (ab, ac, ap) = (b - a, c - a, p - a);
    let (d1, d2) = (ab.dot(ap), ac.dot(ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return (a, [1.0, 0.0, 0.0]);
    }
    let bp = p - b;
    let (d3, d4) = (ab.dot(bp), ac.dot(bp));
    if d3 >= 0.0 && d4 <= d3 {
        return (b, [0.0, 1.0, 0.0]);
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 && d1 > d3 {
        let t = d1 / (d1 - d3);
        return (a + ab * t, [1.0 - t, t, 0.0]);
    }
    let cp = p - c;
    let (d5, d6) = (ab.dot(cp), ac.dot(cp));
    if d6 >= 0.0 && d5 <= d6 {
        return (c, [0.0, 0.0, 1.0]);
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 && d2 > d6 {
        let t = d2 / (d2 - d6);
        return (a + ac * t, [1.0 - t, 0.0, t]);
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 >= d3 && d5 >= d6 && (d4 - d3) + (d5 - d6) > 0.0 {
        let t = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        return (b + (c - b) * t, [0.0, 1.0 - t, t]);
    }
    let total = va + vb + vc;
    if !(total > 0.0) {
        return (a, [1.0, 0.0, 0.0]);
    }
    let (v, w) = (vb / total, vc / total);
    (a + ab * v + ac * w, [1.0 - v - w, v, w])
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn vector() -> impl Strategy<Value = DVec3> {
        [-1.0..1.0, -1.0..1.0, -1.0..1.0].prop_map(DVec3::from_array)
    }

    proptest! {
        #[test]
        fn the_tree_agrees_with_trying_every_triangle(
            points in prop::collection::vec(vector(), 3..60),
            picks in prop::collection::vec([0usize..60, 0..60, 0..60], 1..80),
            query in vector(),
        ) {
            let triangles: Vec<[u32; 3]> =
                picks.iter().map(|t| t.map(|v| (v % points.len()) as u32)).collect();
            let found = Bvh::new(&points, &triangles).closest(query, f64::INFINITY).unwrap();
            let least = triangles
                .iter()
                .map(|t| closest_on_triangle(query, &t.map(|v| points[v as usize])).0)
                .map(|p| p.distance_squared(query))
                .fold(f64::INFINITY, f64::min);
            prop_assert!((found.distance_squared - least).abs() < 1e-14);
            let [a, b, c] = triangles[found.triangle as usize].map(|v| points[v as usize]);
            let [u, v, w] = found.barycentric;
            prop_assert!((a * u + b * v + c * w).distance(found.point) < 1e-12);
            prop_assert!(u >= -1e-12 && v >= 0.0 && w >= 0.0 && (u + v + w - 1.0).abs() < 1e-12);
        }

        #[test]
        fn no_sample_of_a_triangle_is_closer(
            t in [vector(), vector(), vector()], q in vector(), u in 0.0..1.0f64, v in 0.0..1.0f64,
        ) {
            let (closest, _) = closest_on_triangle(q, &t);
            let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
            let sample = t[0] + (t[1] - t[0]) * u + (t[2] - t[0]) * v;
            prop_assert!(q.distance(closest) <= q.distance(sample) + 1e-9);
        }
    }
}
