//! A coarse graph over a surface whose nodes carry affine maps: *Embedded Deformation for Shape
//! Manipulation* (Sumner, Schmid, Pauly, SIGGRAPH 2007).

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::num::NonZeroUsize;

use chladni_mesh::surface::components;
use chladni_task::Task;
use glam::DVec3;
use kiddo::{ImmutableKdTree, SquaredEuclidean};
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rayon::prelude::*;

use crate::MatchError;
use crate::surface::UnitSurface;

/// The number of nodes whose maps are blended at a vertex.
const BLENDED: usize = 6;

/// The nodes, their neighbors, and how vertices follow them.
#[derive(Clone, Debug)]
pub(crate) struct Graph {
    /// Vertices that are nodes, at least `spacing` apart along the surface.
    pub nodes: Vec<u32>,
    /// Least distance between nodes.
    pub spacing: f64,
    /// For each vertex, up to six nodes and their weights, which sum to 1.
    pub blend: Vec<Vec<(u32, f64)>>,
    /// Pairs of nodes that should move alike, and the weight of that (1 along the surface).
    pub edges: Vec<(u32, u32, f64)>,
}

/// Distances as `f64`, ordered for a heap.
#[derive(PartialEq, Clone, Copy)]
struct Distance(f64);
impl Eq for Distance {}
impl PartialOrd for Distance {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}
impl Ord for Distance {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.0.total_cmp(&other.0)
    }
}

/// Visits the vertices around a vertex, along edges, up to a given distance.
struct Walker<'a> {
    surface: &'a UnitSurface,
    distance: Vec<f64>,
    touched: Vec<u32>,
    heap: BinaryHeap<(Reverse<Distance>, u32)>,
}

impl<'a> Walker<'a> {
    fn new(surface: &'a UnitSurface) -> Self {
        let distance = vec![f64::INFINITY; surface.points.len()];
        Self { surface, distance, touched: Vec::new(), heap: BinaryHeap::new() }
    }

    /// Calls `visit(vertex, distance)` for each vertex within `radius` of `from` (Dijkstra).
    fn ball(&mut self, from: u32, radius: f64, mut visit: impl FnMut(u32, f64)) {
        self.distance[from as usize] = 0.0;
        self.touched.push(from);
        self.heap.push((Reverse(Distance(0.0)), from));
        while let Some((Reverse(Distance(d)), v)) = self.heap.pop() {
            if d > self.distance[v as usize] {
                continue;
            }
            visit(v, d);
            let p = self.surface.points[v as usize];
            for &w in self.surface.neighbors(v as usize) {
                let next = d + p.distance(self.surface.points[w as usize]);
                if next < radius && next < self.distance[w as usize] {
                    if self.distance[w as usize] == f64::INFINITY {
                        self.touched.push(w);
                    }
                    self.distance[w as usize] = next;
                    self.heap.push((Reverse(Distance(next)), w));
                }
            }
        }
        for v in self.touched.drain(..) {
            self.distance[v as usize] = f64::INFINITY;
        }
    }
}

impl Graph {
    /// About `count` vertices, evenly spread along the surface, with at least one on every component.
    pub fn nodes_only(surface: &UnitSurface, count: usize, seed: u64) -> Vec<u32> {
        Self::scatter(&mut Walker::new(surface), Self::spacing(surface, count), seed)
    }

    fn spacing(surface: &UnitSurface, count: usize) -> f64 {
        // A maximal set of points with distance r on an area A has about 0.8 A/r² points.
        (0.8 * surface.area() / count.max(1) as f64).sqrt()
    }

    fn scatter(walker: &mut Walker, spacing: f64, seed: u64) -> Vec<u32> {
        let n = walker.distance.len();
        let mut order: Vec<u32> = (0..n as u32).collect();
        order.shuffle(&mut rand_chacha::ChaCha8Rng::seed_from_u64(seed));
        let mut covered = vec![false; n];
        let mut nodes = Vec::new();
        for v in order {
            if !covered[v as usize] {
                nodes.push(v);
                walker.ball(v, spacing, |w, _| covered[w as usize] = true);
            }
        }
        nodes
    }

    /// A graph of about `count` nodes, with at least one on every component.
    pub fn new(surface: &UnitSurface, count: usize, seed: u64, task: &Task) -> Result<Self, MatchError> {
        let n = surface.points.len();
        let spacing = Self::spacing(surface, count);
        let mut walker = Walker::new(surface);
        let nodes = Self::scatter(&mut walker, spacing, seed);
        let reach = 1.5 * spacing;
        let mut blend: Vec<Vec<(u32, f64)>> = vec![Vec::new(); n];
        for (j, &node) in nodes.iter().enumerate() {
            walker.ball(node, reach, |w, d| {
                blend[w as usize].push((j as u32, (1.0 - d / reach).powi(2).max(1e-6)));
            });
        }
        for list in &mut blend {
            list.sort_by(|a, b| b.1.total_cmp(&a.1));
            list.truncate(BLENDED);
            let total: f64 = list.iter().map(|b| b.1).sum();
            list.iter_mut().for_each(|b| b.1 /= total);
        }
        let edges = edges(surface, &nodes, &blend, task)?;
        Ok(Self { nodes, spacing, blend, edges })
    }
}

/// Pairs of nodes that share a vertex, and, where edges are too long for that, pairs along the edges. Nodes outside the
/// largest component are also paired with the nearest nodes of other components: eyes and teeth then follow their head.
fn edges(
    surface: &UnitSurface,
    nodes: &[u32],
    blend: &[Vec<(u32, f64)>],
    task: &Task,
) -> Result<Vec<(u32, u32, f64)>, MatchError> {
    let mut pairs: Vec<(u32, u32)> = Vec::new();
    for list in blend {
        for (i, a) in list.iter().enumerate() {
            pairs.extend(list[..i].iter().map(|b| (a.0.min(b.0), a.0.max(b.0))));
        }
    }
    pairs.extend(along_edges(surface, nodes.len(), blend, &pairs));
    pairs.sort_unstable();
    pairs.dedup();
    let mut edges: Vec<(u32, u32, f64)> = pairs.into_iter().map(|(i, j)| (i, j, 1.0)).collect();
    let components = surface.components();
    if components > 1 {
        let mut size = vec![0_usize; components];
        nodes.iter().for_each(|v| size[surface.component[*v as usize] as usize] += 1);
        let largest = (0..components).max_by_key(|c| size[*c]).unwrap_or(0) as u32;
        let others = Others::of(surface, nodes);
        let beside = (0..nodes.len() as u32).into_par_iter().filter(|i| others.component(*i) != largest);
        let ties = beside.map(|i| {
            task.check()?;
            Ok(others.nearest(i).into_iter().map(move |j| (i, j, 1.0)))
        });
        edges.extend(ties.collect::<Result<Vec<_>, MatchError>>()?.into_iter().flatten());
    }
    Ok(edges)
}

/// Pairs of the nodes that count most at the two ends of an edge, where no chain of `pairs` joins them: where edges are
/// longer than nodes reach, each vertex is a node of its own, which nothing else stiffens.
fn along_edges(
    surface: &UnitSurface,
    nodes: usize,
    blend: &[Vec<(u32, f64)>],
    pairs: &[(u32, u32)],
) -> Vec<(u32, u32)> {
    let joined: Vec<[u32; 3]> = pairs.iter().map(|&(i, j)| [i, j, j]).collect();
    let patch = components(nodes, &joined);
    let node = |v: usize| blend[v].first().map(|b| b.0);
    let mut along = Vec::new();
    for v in 0..surface.points.len() {
        for &w in surface.neighbors(v) {
            if let (Some(i), Some(j)) = (node(v), node(w as usize))
                && i < j
                && patch[i as usize] != patch[j as usize]
            {
                along.push((i, j));
            }
        }
    }
    along
}

/// The nodes in a tree, to find the nearest ones of other components.
struct Others<'a> {
    surface: &'a UnitSurface,
    nodes: &'a [u32],
    tree: Option<ImmutableKdTree<f64, 3>>,
}

impl<'a> Others<'a> {
    /// Two squared distances whose ratio is above this may be equal but for rounding.
    const SURE: f64 = 1.0 - 1e-9;
    /// The number of nodes of other components that one is paired with.
    const NEAREST: usize = 3;

    fn of(surface: &'a UnitSurface, nodes: &'a [u32]) -> Self {
        let points: Vec<[f64; 3]> = nodes.iter().map(|v| surface.points[*v as usize].to_array()).collect();
        Self { surface, nodes, tree: ImmutableKdTree::new_from_slice(&points).ok() }
    }

    fn point(&self, node: u32) -> DVec3 {
        self.surface.points[self.nodes[node as usize] as usize]
    }

    fn component(&self, node: u32) -> u32 {
        self.surface.component[self.nodes[node as usize] as usize]
    }

    /// The nearest nodes of other components, nearest first; of equally near ones the lowest.
    fn nearest(&self, node: u32) -> Vec<u32> {
        let Some(tree) = &self.tree else { return Vec::new() };
        let (own, p) = (self.component(node), self.point(node));
        let all = self.nodes.len();
        let mut count = 4 * Self::NEAREST;
        loop {
            let asked = NonZeroUsize::new(count.min(all)).unwrap_or(NonZeroUsize::MIN);
            let found = tree.query(&p.to_array()).nearest_n::<SquaredEuclidean<f64>>(asked).execute();
            let reach = found.iter().map(|f| self.point(f.item).distance_squared(p)).fold(0.0, f64::max);
            let others = found.iter().map(|f| f.item).filter(|j| self.component(*j) != own);
            let mut others: Vec<(f64, u32)> =
                others.map(|j| (self.point(j).distance_squared(p), j)).collect();
            others.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            // One as near as the last of those found may have been left out.
            let are_certain = others.get(Self::NEAREST - 1).is_some_and(|last| last.0 < Self::SURE * reach);
            if are_certain || count >= all {
                return others.into_iter().take(Self::NEAREST).map(|(_, j)| j).collect();
            }
            count *= 2;
        }
    }
}

/// An affine map of one node: y = g + t + A (x − g), as the rows of [A | t].
pub(crate) type NodeMap = [[f64; 4]; 3];

impl Graph {
    /// The bent position of each vertex.
    pub fn apply(&self, surface: &UnitSurface, maps: &[NodeMap]) -> Vec<DVec3> {
        surface
            .points
            .par_iter()
            .zip(&self.blend)
            .map(|(x, blend)| {
                blend
                    .iter()
                    .map(|(j, w)| {
                        let g = surface.points[self.nodes[*j as usize] as usize];
                        let d = *x - g;
                        let [r0, r1, r2] =
                            maps[*j as usize].map(|r| r[0] * d.x + r[1] * d.y + r[2] * d.z + r[3]);
                        (g + DVec3::new(r0, r1, r2)) * *w
                    })
                    .sum()
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use chladni_mesh::TriMesh;

    use super::*;
    use crate::Side;

    /// Small triangles at `places`, each a component, and a strip of large ones.
    fn scattered(places: &[DVec3]) -> UnitSurface {
        let mut positions = Vec::new();
        let mut triangles: Vec<[u32; 3]> = Vec::new();
        for p in places {
            let first = positions.len() as u32;
            positions.extend([DVec3::ZERO, DVec3::X * 1e-3, DVec3::Y * 1e-3].map(|d| (*p + d).to_array()));
            triangles.push([first, first + 1, first + 2]);
        }
        let first = positions.len() as u32;
        positions.extend((0..40).map(|i| [f64::from(i / 2), -5.0 + f64::from(i % 2), 0.0]));
        triangles.extend((0..38).map(|i| [first + i, first + i + 1, first + i + 2]));
        let mesh = TriMesh { positions, triangles, ..TriMesh::default() };
        UnitSurface::new(&mesh, Side::Shape).unwrap()
    }

    #[test]
    fn pieces_are_paired_with_the_nearest_of_others_also_where_many_are_equally_near() {
        let grid = (0..300).map(|i| DVec3::new(f64::from(i % 20), f64::from(i / 20), 0.0));
        let noise = |i: i32, k: i32| f64::from(i * 7919 * k % 104_729 % 1000) * 0.02;
        let random = (0..300).map(|i| DVec3::new(noise(i, 1), noise(i, 3), noise(i, 7)));
        for places in [grid.collect::<Vec<_>>(), random.collect()] {
            let surface = scattered(&places);
            let graph = Graph::new(&surface, 60, 1, &Task::new()).unwrap();
            let others = Others::of(&surface, &graph.nodes);
            let nodes = graph.nodes.len() as u32;
            assert!(nodes > 300);
            for i in 0..nodes {
                let mut all: Vec<(f64, u32)> = (0..nodes)
                    .filter(|j| others.component(*j) != others.component(i))
                    .map(|j| (others.point(j).distance_squared(others.point(i)), j))
                    .collect();
                all.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
                let nearest: Vec<u32> = all[..3].iter().map(|(_, j)| *j).collect();
                assert_eq!(others.nearest(i), nearest, "node {i}");
            }
        }
    }

    #[test]
    fn nodes_are_paired_along_edges_that_are_longer_than_they_reach_and_only_there() {
        let graph = |subdivisions: u32, count: usize| {
            let surface =
                UnitSurface::new(&chladni_mesh::samples::icosphere(subdivisions), Side::Shape).unwrap();
            Graph::new(&surface, count, 1, &Task::new()).unwrap()
        };
        // Each vertex is a node, which shares none: all 480 edges tie.
        let coarse = graph(2, 1000);
        assert_eq!((coarse.nodes.len(), coarse.edges.len()), (162, 480));
        assert!(coarse.blend.iter().all(|blend| blend.len() == 1));
        let fine = graph(4, 100);
        let share = |i: u32, j: u32| {
            fine.blend.iter().any(|blend| [i, j].iter().all(|node| blend.iter().any(|b| b.0 == *node)))
        };
        assert!(fine.edges.iter().all(|&(i, j, _)| share(i, j)));
    }

    #[test]
    fn pairing_pieces_ends_when_it_is_cancelled() {
        let places: Vec<DVec3> = (0..20).map(|i| DVec3::new(f64::from(i), 0.0, 0.0)).collect();
        let (surface, task) = (scattered(&places), Task::new());
        task.cancel();
        assert!(matches!(Graph::new(&surface, 60, 1, &task), Err(MatchError::Cancelled(_))));
    }
}
