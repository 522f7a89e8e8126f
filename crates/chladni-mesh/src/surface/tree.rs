//! Trees of boxes: they find triangles near a point, on a ray, or crossing another one.

use super::vec3::{Vec3, add, dot, sub};
use super::{SurfacePoint, closest_on_triangle};

/// An axis-aligned box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Its lower corner.
    pub low: Vec3,
    /// Its upper corner.
    pub high: Vec3,
}

impl Bounds {
    /// The empty box.
    pub const EMPTY: Self = Self { low: [f64::INFINITY; 3], high: [f64::NEG_INFINITY; 3] };

    /// The least box around points.
    pub fn of(points: impl IntoIterator<Item = Vec3>) -> Self {
        points.into_iter().fold(Self::EMPTY, |bounds, p| bounds.around(&Self { low: p, high: p }))
    }

    /// The least box around both.
    pub fn around(&self, other: &Self) -> Self {
        Self {
            low: std::array::from_fn(|i| self.low[i].min(other.low[i])),
            high: std::array::from_fn(|i| self.high[i].max(other.high[i])),
        }
    }

    /// Whether they have a point in common.
    pub fn meets(&self, other: &Self) -> bool {
        (0..3).all(|i| self.low[i] <= other.high[i] && other.low[i] <= self.high[i])
    }

    /// The squared distance of `p` from the box; 0 inside. Infinite or NaN where the box is empty.
    pub fn distance_squared(&self, p: Vec3) -> f64 {
        let offset = std::array::from_fn(|i| p[i] - p[i].max(self.low[i]).min(self.high[i]));
        dot(offset, offset)
    }

    /// From corner to corner; 0 where the box is empty.
    pub fn diagonal(&self) -> f64 {
        let extent = sub(self.high, self.low);
        if extent[0] >= 0.0 { dot(extent, extent).sqrt() } else { 0.0 }
    }

    fn widest_axis(&self) -> usize {
        let extent = sub(self.high, self.low);
        (0..3).max_by(|i, j| extent[*i].total_cmp(&extent[*j])).unwrap_or(0)
    }
}

/// An inner node's left child follows it; a leaf covers `order[start..start + count]`.
#[derive(Clone, Debug)]
struct Node {
    bounds: Bounds,
    /// Right child of an inner node, first slot of a leaf.
    start: u32,
    /// Items of a leaf, 0 for an inner node.
    count: u32,
}

/// Items of a leaf, at most.
const LEAF: usize = 4;

/// A tree of boxes over items 0..m, such as triangles. Its shape is fixed when it is made; its boxes
/// [`fit`](Self::fit) wherever the items move, in linear time.
///
/// Halving at the median keeps the depth at ⌈log₂ m⌉ for any input, and ties go by index, so that the same items
/// give the same tree on every machine.
#[derive(Clone, Debug, Default)]
pub struct BoxTree {
    nodes: Vec<Node>,
    order: Vec<u32>,
}

impl BoxTree {
    /// The tree of the items with these `centers`, whose boxes `bounds` gives.
    pub fn new(centers: &[Vec3], bounds: impl Fn(u32) -> Bounds) -> Self {
        let mut order: Vec<u32> = (0..centers.len() as u32).collect();
        let mut nodes = Vec::with_capacity(2 * centers.len() / LEAF + 1);
        if !order.is_empty() {
            split(&mut order, 0, centers, &mut nodes);
        }
        let mut tree = Self { nodes, order };
        tree.fit(bounds);
        tree
    }

    /// The items in the order of the leaves: [`search`](Self::search) gives positions in it.
    pub fn order(&self) -> &[u32] {
        &self.order
    }

    /// The box around all items; empty where there are none.
    pub fn bounds(&self) -> Bounds {
        self.nodes.first().map_or(Bounds::EMPTY, |root| root.bounds)
    }

    /// Refits every box to the items' present bounds.
    pub fn fit(&mut self, bounds: impl Fn(u32) -> Bounds) {
        // Children come after their parent.
        for i in (0..self.nodes.len()).rev() {
            let Node { start, count, .. } = self.nodes[i];
            self.nodes[i].bounds = if count == 0 {
                self.nodes[i + 1].bounds.around(&self.nodes[start as usize].bounds)
            } else {
                let items = &self.order[start as usize..(start + count) as usize];
                items.iter().fold(Bounds::EMPTY, |all, item| all.around(&bounds(*item)))
            };
        }
    }

    /// A value for each node: of a leaf, what `leaf` makes of its items; of an inner node, `both` of its children's.
    pub fn gather<T: Copy>(&self, leaf: impl Fn(&[u32]) -> T, both: impl Fn(T, T) -> T) -> Vec<T> {
        let last = self.nodes.len().saturating_sub(1);
        // From the last node to the first.
        let mut gathered: Vec<T> = Vec::with_capacity(self.nodes.len());
        for (i, Node { start, count, .. }) in self.nodes.iter().enumerate().rev() {
            let start = *start as usize;
            gathered.push(if *count == 0 {
                both(gathered[last - (i + 1)], gathered[last - start])
            } else {
                leaf(&self.order[start..start + *count as usize])
            });
        }
        gathered.reverse();
        gathered
    }

    /// Visits the leaves whose boxes are `nearer` than a limit, the nearer of two children first.
    ///
    /// `nearness` of a box is a lower bound for everything in it, in any measure; [`f64::INFINITY`] skips it.
    /// `visit` gets a position in [`order`](Self::order) and the limit, and returns the new limit.
    pub fn search(
        &self,
        limit: f64,
        nearness: impl Fn(&Bounds) -> f64,
        visit: impl FnMut(usize, f64) -> f64,
    ) {
        self.search_nodes(limit, |_, bounds| nearness(bounds), visit);
    }

    /// As [`search`](Self::search); `nearness` also gets the node's index in what [`gather`](Self::gather) returned.
    pub fn search_nodes(
        &self,
        mut limit: f64,
        nearness: impl Fn(usize, &Bounds) -> f64,
        mut visit: impl FnMut(usize, f64) -> f64,
    ) {
        let Some(root) = self.nodes.first() else { return };
        // Depth is at most 32, and each level leaves one node behind.
        let mut waiting = [(0_u32, 0.0_f64); 64];
        waiting[0].1 = nearness(0, &root.bounds);
        let mut depth = 1;
        while depth > 0 {
            depth -= 1;
            let (index, near) = waiting[depth];
            if near >= limit {
                continue;
            }
            let Node { start, count, .. } = self.nodes[index as usize];
            if count > 0 {
                for slot in start as usize..(start + count) as usize {
                    limit = visit(slot, limit);
                }
                continue;
            }
            let child = |i: u32| (i, nearness(i as usize, &self.nodes[i as usize].bounds));
            let (left, right) = (child(index + 1), child(start));
            let (near, far) = if left.1 <= right.1 { (left, right) } else { (right, left) };
            (waiting[depth], waiting[depth + 1]) = (far, near);
            depth += 2;
        }
    }
}

/// Halves `order` at its median along the widest axis of the centers.
fn split(order: &mut [u32], first: u32, centers: &[Vec3], nodes: &mut Vec<Node>) {
    let here = nodes.len();
    let count = if order.len() <= LEAF { order.len() as u32 } else { 0 };
    nodes.push(Node { bounds: Bounds::EMPTY, start: first, count });
    if count > 0 {
        return;
    }
    let axis = Bounds::of(order.iter().map(|item| centers[*item as usize])).widest_axis();
    let middle = order.len() / 2;
    order.select_nth_unstable_by(middle, |s, t| {
        centers[*s as usize][axis].total_cmp(&centers[*t as usize][axis]).then(s.cmp(t))
    });
    let (left, right) = order.split_at_mut(middle);
    split(left, first, centers, nodes);
    nodes[here].start = nodes.len() as u32;
    split(right, first + middle as u32, centers, nodes);
}

/// The point of a surface closest to another point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Closest {
    /// On the surface.
    pub on: SurfacePoint,
    /// In space.
    pub point: Vec3,
    /// Squared distance from the point that was asked for.
    pub distance_squared: f64,
}

/// A [`BoxTree`] over triangles that do not move, with their corners in the order of the leaves.
#[derive(Clone, Debug)]
pub struct TriangleTree {
    tree: BoxTree,
    corners: Vec<[Vec3; 3]>,
}

impl TriangleTree {
    /// The tree of `triangles` over `positions`.
    ///
    /// # Panics
    /// If a triangle names a vertex that is not there.
    pub fn new(positions: &[Vec3], triangles: &[[u32; 3]]) -> Self {
        let corners = |t: u32| triangles[t as usize].map(|v| positions[v as usize]);
        let center = |t: u32| {
            let [a, b, c] = corners(t);
            add(add(a, b), c).map(|x| x / 3.0)
        };
        let centers: Vec<Vec3> = (0..triangles.len() as u32).map(center).collect();
        let tree = BoxTree::new(&centers, |t| Bounds::of(corners(t)));
        let corners = tree.order().iter().map(|t| corners(*t)).collect();
        Self { tree, corners }
    }

    /// The closest point nearer than `reach`; `None` where there is none.
    pub fn closest(&self, query: Vec3, reach: f64) -> Option<Closest> {
        let mut best = None;
        self.tree.search(
            reach * reach,
            |bounds| bounds.distance_squared(query),
            |slot, limit| {
                let (point, weights) = closest_on_triangle(query, &self.corners[slot]);
                let offset = sub(query, point);
                let distance_squared = dot(offset, offset);
                if distance_squared >= limit || distance_squared.is_nan() {
                    return limit;
                }
                let on = SurfacePoint { triangle: self.tree.order()[slot], weights };
                best = Some(Closest { on, point, distance_squared });
                distance_squared
            },
        );
        best
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::surface::{corners, mixed};

    fn vector() -> impl Strategy<Value = Vec3> {
        [-1.0..1.0, -1.0..1.0, -1.0..1.0]
    }

    fn soup() -> impl Strategy<Value = (Vec<Vec3>, Vec<[u32; 3]>)> {
        let picks = prop::collection::vec([0_usize..60, 0..60, 0..60], 1..80);
        (prop::collection::vec(vector(), 3..60), picks).prop_map(|(points, picks)| {
            let n = points.len();
            (points, picks.iter().map(|t| t.map(|v| (v % n) as u32)).collect())
        })
    }

    #[test]
    fn nothing_is_found_in_an_empty_tree_or_beyond_reach() {
        assert_eq!(TriangleTree::new(&[], &[]).closest([0.0; 3], f64::INFINITY), None);
        let one = TriangleTree::new(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], &[[0, 1, 2]]);
        assert_eq!(one.closest([0.2, 0.2, 2.0], 2.0), None);
        let found = one.closest([0.25, 0.25, 2.0], 2.1).unwrap();
        assert_eq!((found.point, found.on.triangle, found.distance_squared), ([0.25, 0.25, 0.0], 0, 4.0));
    }

    #[test]
    fn each_node_gathers_from_the_items_below_it() {
        let tree = BoxTree::new(&[[0.0; 3]; 11], |_| Bounds::EMPTY);
        let counts = tree.gather(<[u32]>::len, |left, right| left + right);
        assert_eq!((counts.len(), counts[0]), (tree.nodes.len(), 11));
        assert!(tree.nodes.iter().zip(&counts).all(|(node, n)| node.count == 0 || node.count as usize == *n));
        assert!(BoxTree::default().gather(<[u32]>::len, |left, _| left).is_empty());
    }

    proptest! {
        #[test]
        fn it_finds_what_trying_every_triangle_finds((points, triangles) in soup(), query in vector()) {
            let found = TriangleTree::new(&points, &triangles).closest(query, f64::INFINITY).unwrap();
            let distance_squared = |p: Vec3| dot(sub(query, p), sub(query, p));
            let least = triangles
                .iter()
                .map(|t| distance_squared(closest_on_triangle(query, &corners(&points, t)).0))
                .fold(f64::INFINITY, f64::min);
            prop_assert!((found.distance_squared - least).abs() < 1e-14);
            let there = mixed(corners(&points, &triangles[found.on.triangle as usize]), found.on.weights);
            prop_assert!(distance_squared(there) - least < 1e-12);
        }

        #[test]
        fn boxes_that_fit_again_find_all_that_meets_a_box(
            (mut points, triangles) in soup(), shift in vector(), a in vector(), b in vector(),
        ) {
            let bounds = |points: &[Vec3], t: u32| Bounds::of(corners(points, &triangles[t as usize]));
            let mut tree = BoxTree::new(&vec![[0.0; 3]; triangles.len()], |t| bounds(&points, t));
            points.iter_mut().step_by(2).for_each(|p| *p = add(*p, shift));
            tree.fit(|t| bounds(&points, t));
            let asked = Bounds::of([a, b]);
            let mut found = Vec::new();
            let nearness = |inner: &Bounds| if inner.meets(&asked) { 0.0 } else { f64::INFINITY };
            tree.search(f64::INFINITY, nearness, |slot, limit| {
                let item = tree.order()[slot];
                if bounds(&points, item).meets(&asked) {
                    found.push(item);
                }
                limit
            });
            found.sort_unstable();
            let all = 0..triangles.len() as u32;
            prop_assert_eq!(found, all.filter(|t| bounds(&points, *t).meets(&asked)).collect::<Vec<_>>());
        }
    }
}
