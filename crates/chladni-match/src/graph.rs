//! A coarse graph over a surface whose nodes carry affine maps: *Embedded Deformation for Shape
//! Manipulation* (Sumner, Schmid, Pauly, SIGGRAPH 2007).

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use glam::DVec3;
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rayon::prelude::*;

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
    pub fn new(surface: &UnitSurface, count: usize, seed: u64) -> Self {
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
        let edges = edges(surface, &nodes, &blend);
        Self { nodes, spacing, blend, edges }
    }
}

/// Pairs of nodes that share a vertex. Nodes outside the largest component are also paired with the nearest
/// nodes of other components: eyes and teeth then follow their head.
fn edges(surface: &UnitSurface, nodes: &[u32], blend: &[Vec<(u32, f64)>]) -> Vec<(u32, u32, f64)> {
    let mut pairs: Vec<(u32, u32)> = Vec::new();
    for list in blend {
        for (i, a) in list.iter().enumerate() {
            pairs.extend(list[..i].iter().map(|b| (a.0.min(b.0), a.0.max(b.0))));
        }
    }
    pairs.sort_unstable();
    pairs.dedup();
    let mut edges: Vec<(u32, u32, f64)> = pairs.into_iter().map(|(i, j)| (i, j, 1.0)).collect();
    let components = surface.components();
    if components > 1 {
        let mut size = vec![0_usize; components];
        nodes.iter().for_each(|v| size[surface.component[*v as usize] as usize] += 1);
        let largest = (0..components).max_by_key(|c| size[*c]).unwrap_or(0) as u32;
        let place = |j: usize| (surface.points[nodes[j] as usize], surface.component[nodes[j] as usize]);
        let beside = (0..nodes.len()).into_par_iter().filter(|i| place(*i).1 != largest);
        let ties = beside.flat_map_iter(|i| {
            let (p, component) = place(i);
            let mut nearest = [(f64::INFINITY, u32::MAX); 3];
            for j in (0..nodes.len()).filter(|j| place(*j).1 != component) {
                let distance = place(j).0.distance_squared(p);
                let after = nearest.partition_point(|(known, _)| *known <= distance);
                if after < nearest.len() {
                    nearest[after..].rotate_right(1);
                    nearest[after] = (distance, j as u32);
                }
            }
            nearest.into_iter().filter(|(_, j)| *j != u32::MAX).map(move |(_, j)| (i as u32, j, 1.0))
        });
        edges.par_extend(ties);
    }
    edges
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
