//! Nested dissection of a surface's graph: an elimination order with little fill.

use std::collections::{BinaryHeap, VecDeque};

use crate::SymmetricSparse;

/// Parts of at most this many vertices are eliminated as they are: one dense front each.
const LEAF: usize = 40;
/// Parts larger than this are dissected side by side on two threads.
const PARALLEL: usize = 3000;

/// An order of elimination, as the old index of each new one. Does not depend on threads.
pub(crate) fn nested_dissection(matrix: &SymmetricSparse) -> Vec<u32> {
    let n = matrix.size();
    let mut graph = Graph {
        starts: vec![0],
        neighbors: Vec::with_capacity(matrix.rows.len() - n),
        name: (0..n as u32).collect(),
    };
    for j in 0..n {
        graph.neighbors.extend(matrix.column(j).filter(|(i, _)| *i != j).map(|(i, _)| i as u32));
        graph.starts.push(graph.neighbors.len());
    }
    let mut order = vec![0; n];
    dissect(&graph, &mut order);
    order
}

/// A part of the whole graph under local names.
struct Graph {
    starts: Vec<usize>,
    neighbors: Vec<u32>,
    /// The vertex of the whole graph that each local one is.
    name: Vec<u32>,
}

/// Which side of a cut a vertex is on.
const LEFT: u8 = 0;
const RIGHT: u8 = 1;
const SEPARATOR: u8 = 2;

impl Graph {
    fn size(&self) -> usize {
        self.name.len()
    }

    fn of(&self, v: u32) -> &[u32] {
        &self.neighbors[self.starts[v as usize]..self.starts[v as usize + 1]]
    }

    /// The subgraph of the vertices where `part` is `which`.
    fn part(&self, part: &[u8], which: u8) -> Self {
        let mut local = vec![u32::MAX; self.size()];
        let mut name = Vec::new();
        for v in 0..self.size() {
            if part[v] == which {
                local[v] = name.len() as u32;
                name.push(self.name[v]);
            }
        }
        let mut starts = Vec::with_capacity(name.len() + 1);
        starts.push(0);
        let mut neighbors = Vec::new();
        for v in (0..self.size()).filter(|&v| part[v] == which) {
            neighbors.extend(self.of(v as u32).iter().map(|&u| local[u as usize]).filter(|&u| u != u32::MAX));
            starts.push(neighbors.len());
        }
        Self { starts, neighbors, name }
    }

    /// Distances in edges from `source`, and the vertices in the order they are reached.
    fn distances(&self, source: u32, distance: &mut [u32], reached: &mut Vec<u32>) {
        distance.fill(u32::MAX);
        reached.clear();
        distance[source as usize] = 0;
        reached.push(source);
        let mut next = 0;
        while let Some(&v) = reached.get(next) {
            next += 1;
            for &u in self.of(v) {
                if distance[u as usize] == u32::MAX {
                    distance[u as usize] = distance[v as usize] + 1;
                    reached.push(u);
                }
            }
        }
    }
}

/// Writes the names of `graph` in order of elimination: left part, right part, separator.
fn dissect(graph: &Graph, order: &mut [u32]) {
    let n = graph.size();
    if n <= LEAF {
        order.copy_from_slice(&graph.name);
        return;
    }
    let mut part = split(graph);
    refine(graph, &mut part);
    let (left, right) = (graph.part(&part, LEFT), graph.part(&part, RIGHT));
    let (first, rest) = order.split_at_mut(left.size());
    let (second, separator) = rest.split_at_mut(right.size());
    let names = (0..n).filter(|&v| part[v] == SEPARATOR).map(|v| graph.name[v]);
    separator.iter_mut().zip(names).for_each(|(slot, name)| *slot = name);
    if left.size() == n || right.size() == n {
        // Nothing was split off; keep the order as it is rather than recurse for ever.
        order.copy_from_slice(&graph.name);
    } else if n > PARALLEL {
        rayon::join(|| dissect(&left, first), || dissect(&right, second));
    } else {
        dissect(&left, first);
        dissect(&right, second);
    }
}

/// A first cut: what is nearer to one end of the graph than to the other, the two in balance.
/// Components are never cut while they can be dealt out whole.
fn split(graph: &Graph) -> Vec<u8> {
    let n = graph.size();
    let (mut from_a, mut from_b) = (vec![0; n], vec![0; n]);
    let mut reached = Vec::with_capacity(n);
    graph.distances(0, &mut from_a, &mut reached);
    if reached.len() < n {
        return deal_components(graph);
    }
    let a = reached[n - 1];
    graph.distances(a, &mut from_a, &mut reached);
    let b = reached[n - 1];
    graph.distances(b, &mut from_b, &mut reached);
    let nearness = |v: usize| i64::from(from_a[v]) - i64::from(from_b[v]);
    // The median by counting; vertices at the median itself go left in order of distance.
    let mut sorted: Vec<(i64, u32, u32)> = (0..n).map(|v| (nearness(v), from_a[v], v as u32)).collect();
    let half = n / 2;
    sorted.select_nth_unstable(half);
    let mut part = vec![RIGHT; n];
    for &(_, _, v) in &sorted[..half] {
        part[v as usize] = LEFT;
    }
    // The separator: vertices of the right that touch the left.
    for v in 0..n {
        if part[v] == RIGHT && graph.of(v as u32).iter().any(|&u| part[u as usize] == LEFT) {
            part[v] = SEPARATOR;
        }
    }
    part
}

/// Whole components to the emptier side, the largest first.
fn deal_components(graph: &Graph) -> Vec<u8> {
    let n = graph.size();
    let mut component = vec![u32::MAX; n];
    let mut sizes: Vec<(usize, u32)> = Vec::new();
    let mut queue = VecDeque::new();
    for start in 0..n {
        if component[start] != u32::MAX {
            continue;
        }
        let number = sizes.len() as u32;
        let mut size = 0;
        component[start] = number;
        queue.push_back(start as u32);
        while let Some(v) = queue.pop_front() {
            size += 1;
            for &u in graph.of(v) {
                if component[u as usize] == u32::MAX {
                    component[u as usize] = number;
                    queue.push_back(u);
                }
            }
        }
        sizes.push((size, number));
    }
    sizes.sort_by(|a, b| b.cmp(a));
    let mut side = vec![LEFT; sizes.len()];
    let mut filled = [0_usize; 2];
    for (size, number) in sizes {
        let emptier = u8::from(filled[1] < filled[0]);
        side[number as usize] = emptier;
        filled[emptier as usize] += size;
    }
    component.into_iter().map(|c| side[c as usize]).collect()
}

/// Makes the separator smaller by moving its vertices to a side, each pulling its neighbours
/// of the other side into the separator, best moves first, also through worse states
/// (Fiduccia & Mattheyses 1982; Hendrickson & Rothberg 1998). Sides stay in balance.
fn refine(graph: &Graph, part: &mut [u8]) {
    let n = graph.size();
    let mut count = [0_usize; 3];
    for &p in part.iter() {
        count[p as usize] += 1;
    }
    if count[2] == 0 {
        return;
    }
    let largest_side = n * 11 / 20;
    let mut moved_in_pass = vec![0_u32; n];
    for pass in 1..=4 {
        let before = count[2];
        improve_once(graph, part, &mut count, largest_side, pass, &mut moved_in_pass);
        if count[2] == before {
            break;
        }
    }
}

fn improve_once(
    graph: &Graph,
    part: &mut [u8],
    count: &mut [usize; 3],
    largest_side: usize,
    pass: u32,
    moved: &mut [u32],
) {
    // What moving v out of the separator to `side` wins: itself, less those it pulls in.
    let gain = |part: &[u8], v: u32, side: u8| {
        1 - graph.of(v).iter().filter(|&&u| part[u as usize] == 1 - side).count() as i32
    };
    let mut heap = BinaryHeap::new();
    let push = |heap: &mut BinaryHeap<(i32, u32, u8)>, part: &[u8], v: u32| {
        for side in [LEFT, RIGHT] {
            heap.push((gain(part, v, side), v, side));
        }
    };
    for v in 0..part.len() as u32 {
        if part[v as usize] == SEPARATOR {
            push(&mut heap, part, v);
        }
    }
    let imbalance = |count: &[usize; 3]| count[0].abs_diff(count[1]);
    let mut log: Vec<(u32, u8)> = Vec::new();
    let mut best = (count[2], imbalance(count), 0);
    let patience = 60 + count[2] / 4;
    while let Some((claimed, v, side)) = heap.pop() {
        let at = v as usize;
        if part[at] != SEPARATOR || moved[at] == pass || log.len() > best.2 + patience {
            continue;
        }
        let now = gain(part, v, side);
        if now != claimed {
            // Stale: it comes back under its true gain.
            heap.push((now, v, side));
            continue;
        }
        if count[side as usize] + 1 > largest_side {
            continue;
        }
        log.push((v, part[at]));
        part[at] = side;
        moved[at] = pass;
        count[2] -= 1;
        count[side as usize] += 1;
        for &u in graph.of(v) {
            if part[u as usize] == 1 - side {
                log.push((u, part[u as usize]));
                part[u as usize] = SEPARATOR;
                count[2] += 1;
                count[1 - side as usize] -= 1;
                push(&mut heap, part, u);
                for &w in graph.of(u) {
                    if part[w as usize] == SEPARATOR {
                        push(&mut heap, part, w);
                    }
                }
            }
        }
        let state = (count[2], imbalance(count), log.len());
        if (state.0, state.1) < (best.0, best.1) {
            best = state;
        }
    }
    for (v, was) in log.drain(best.2..).rev() {
        count[part[v as usize] as usize] -= 1;
        count[was as usize] += 1;
        part[v as usize] = was;
    }
}
