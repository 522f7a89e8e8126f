//! Nested dissection of a surface's graph: an elimination order with little fill.

use std::collections::VecDeque;

use super::separator::{Graph, LEFT, RIGHT, SEPARATOR, separate};
use crate::SymmetricSparse;

/// Parts of at most this many vertices are ordered by minimum degree.
const LEAF: usize = 400;
/// Parts larger than this are dissected in parallel on two threads.
const PARALLEL: usize = 3000;

/// An elimination order, as the old index for each new one. It does not depend on the number of threads.
pub(crate) fn nested_dissection(matrix: &SymmetricSparse) -> Vec<u32> {
    let n = matrix.size();
    let mut graph = Graph { starts: vec![0], neighbors: Vec::with_capacity(matrix.rows.len() - n) };
    for j in 0..n {
        graph.neighbors.extend(matrix.column(j).filter(|(i, _)| *i != j).map(|(i, _)| i as u32));
        graph.starts.push(graph.neighbors.len());
    }
    let mut order = vec![0; n];
    let whole = Part { graph, name: (0..n as u32).collect() };
    dissect(&whole.graph, &whole, &mut order);
    order
}

/// A part of the graph with local vertex indices.
struct Part {
    graph: Graph,
    /// For each local vertex its index in the whole graph.
    name: Vec<u32>,
}

impl Part {
    /// The subgraph of the vertices where `part` is `which`.
    fn side(&self, part: &[u8], which: u8) -> Self {
        let n = self.name.len();
        let mut local = vec![u32::MAX; n];
        let mut name = Vec::new();
        for v in (0..n).filter(|&v| part[v] == which) {
            local[v] = name.len() as u32;
            name.push(self.name[v]);
        }
        let mut graph = Graph { starts: Vec::with_capacity(name.len() + 1), neighbors: Vec::new() };
        graph.starts.push(0);
        for v in (0..n).filter(|&v| part[v] == which) {
            let kept = self.graph.of(v as u32).iter().map(|&u| local[u as usize]).filter(|&u| u != u32::MAX);
            graph.neighbors.extend(kept);
            graph.starts.push(graph.neighbors.len());
        }
        Self { graph, name }
    }
}

/// Writes the vertices of `part` in elimination order: left part, right part, separator.
fn dissect(whole: &Graph, part: &Part, order: &mut [u32]) {
    let n = part.name.len();
    if n <= LEAF {
        order_by_degree(whole, &part.name, order);
        return;
    }
    if part.graph.neighbors.len() > n * n / 2 {
        // Nearly all are joined to each other: no order fills less, and looking for one would take long.
        order.copy_from_slice(&part.name);
        return;
    }
    let sides = split(&part.graph);
    let (left, right) = (part.side(&sides, LEFT), part.side(&sides, RIGHT));
    let (first, rest) = order.split_at_mut(left.name.len());
    let (second, separator) = rest.split_at_mut(right.name.len());
    let names = (0..n).filter(|&v| sides[v] == SEPARATOR).map(|v| part.name[v]);
    separator.iter_mut().zip(names).for_each(|(slot, name)| *slot = name);
    if left.name.len() == n || right.name.len() == n {
        // Nothing was split off: keep the order instead of recursing forever.
        order.copy_from_slice(&part.name);
    } else if n > PARALLEL {
        rayon::join(|| dissect(whole, &left, first), || dissect(whole, &right, second));
    } else {
        dissect(whole, &left, first);
        dissect(whole, &right, second);
    }
}

/// Orders a small part by minimum degree. Neighbors in the surrounding separators count too, although they
/// are eliminated later.
fn order_by_degree(whole: &Graph, part: &[u32], order: &mut [u32]) {
    // One side of a clique's separator is empty.
    if part.is_empty() {
        return;
    }
    let mut around: Vec<u32> = part.iter().flat_map(|&v| whole.of(v)).copied().collect();
    around.sort_unstable();
    around.dedup();
    let inside: Vec<(u32, usize)> = {
        let mut named: Vec<(u32, usize)> = part.iter().enumerate().map(|(i, &v)| (v, i)).collect();
        named.sort_unstable();
        named
    };
    let mut outside = part.len();
    // The index of each vertex around: its local one inside the part, the next free one outside.
    let number: Vec<usize> = around
        .iter()
        .map(|&v| {
            inside.binary_search_by_key(&v, |e| e.0).map_or_else(
                |_| {
                    outside += 1;
                    outside - 1
                },
                |at| inside[at].1,
            )
        })
        .collect();
    let words = outside.div_ceil(64);
    // Row i of the bit matrix holds the neighbors of vertex i of the part, without itself.
    let mut joined = vec![0_u64; words * part.len()];
    for (row, (i, &v)) in joined.chunks_exact_mut(words).zip(part.iter().enumerate()) {
        for at in whole.of(v).iter().filter_map(|u| around.binary_search(u).ok()) {
            row[number[at] / 64] |= 1 << (number[at] % 64);
        }
        row[i / 64] &= !(1 << (i % 64));
    }
    let count = |row: &[u64]| row.iter().map(|word| word.count_ones()).sum::<u32>();
    let mut degree: Vec<u32> = joined.chunks_exact(words).map(count).collect();
    let mut pivot = vec![0; words];
    for slot in order.iter_mut() {
        let Some(v) = (0..part.len()).min_by_key(|&v| degree[v]) else { return };
        *slot = part[v];
        degree[v] = u32::MAX;
        pivot.copy_from_slice(&joined[v * words..(v + 1) * words]);
        let neighbors = (0..part.len()).filter(|&u| pivot[u / 64] >> (u % 64) & 1 == 1);
        for u in neighbors {
            // The neighbors of an eliminated vertex become a clique.
            let row = &mut joined[u * words..(u + 1) * words];
            row.iter_mut().zip(&pivot).for_each(|(word, new)| *word |= new);
            row[u / 64] &= !(1 << (u % 64));
            row[v / 64] &= !(1 << (v % 64));
            degree[u] = count(row);
        }
    }
}

/// A separator; or, if there are several components, a partition of them that cuts none.
fn split(graph: &Graph) -> Vec<u8> {
    let mut met = vec![false; graph.size()];
    let mut queue = vec![0];
    met[0] = true;
    let mut reached = 0;
    while let Some(v) = queue.pop() {
        reached += 1;
        queue.extend(graph.of(v).iter().filter(|&&u| !std::mem::replace(&mut met[u as usize], true)));
    }
    if reached < graph.size() { deal_components(graph) } else { separate(graph) }
}

/// Assigns whole components, largest first, to the side that is lighter so far.
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
