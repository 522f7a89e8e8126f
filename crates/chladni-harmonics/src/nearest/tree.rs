//! A tree over points, which finds the nearest ones where most can be excluded.
//!
//! Vertices that are neighbors on a surface are close in all coordinates of such an embedding at once. Each
//! node of the tree therefore keeps the bounding box of its points in all dimensions: beyond ten
//! dimensions, bounds from the splitting planes alone exclude hardly anything.

use rayon::prelude::*;

use super::total;
use crate::ldlt::Row;
use crate::simd::{Kernel, Lanes, dispatch};

/// The largest number of points in a leaf.
const LEAF: usize = 16;
/// How many rows of eight coordinates are summed between two checks whether a point is too far already.
const STRETCH: usize = 4;
/// A binary tree over points. Each node splits its points in half along the dimension in which they spread
/// most.
pub(super) struct PointTree {
    /// The number of rows of eight in a point; the last row is padded with zeros.
    width: usize,
    /// The points in the order of the leaves, their original indices, and the place of each index.
    points: Vec<Row>,
    numbers: Vec<u32>,
    places: Vec<u32>,
    nodes: Vec<Node>,
    /// For each node the lower and upper bounds of its box, row by row.
    boxes: Vec<[Row; 2]>,
}

/// The points `first .. end`. In an inner node, the first half belongs to the next node and the rest to
/// `above`.
struct Node {
    first: usize,
    end: usize,
    above: Option<usize>,
}

impl PointTree {
    /// A tree of at least one point; `points` holds `dimensions` ≥ 1 finite coordinates of each, one point
    /// after the other, and `rows` the same, padded.
    pub fn new(points: &[f64], dimensions: usize, rows: &[Row]) -> Self {
        let count = points.len() / dimensions;
        let width = dimensions.div_ceil(8);
        let mut numbers: Vec<u32> = (0..count as u32).collect();
        let mut nodes = Vec::new();
        grow(points, dimensions, &mut numbers, 0, &mut nodes);
        let of = |number: u32| &rows[number as usize * width..][..width];
        let points: Vec<Row> = numbers.iter().flat_map(|number| of(*number)).copied().collect();
        let mut places = vec![0; count];
        numbers.iter().enumerate().for_each(|(place, number)| places[*number as usize] = place as u32);
        let around = |node: &Node| {
            let mut ends = vec![[[f64::INFINITY; 8], [f64::NEG_INFINITY; 8]]; width];
            for point in points[node.first * width..node.end * width].chunks_exact(width) {
                for ([low, high], row) in ends.iter_mut().zip(point) {
                    for i in 0..8 {
                        (low[i], high[i]) = (low[i].min(row[i]), high[i].max(row[i]));
                    }
                }
            }
            ends
        };
        let boxes = nodes.par_iter().flat_map_iter(around).collect();
        Self { width, points, numbers, places, nodes, boxes }
    }

    /// For each of `queries`, as padded rows, the nearest point, and the first of several at the same
    /// distance. `guesses`, one per query or empty, only speed up the search. Each search begins where the one before
    /// ended. Returns `false`, and leaves `found` unfinished, once more than `most` points had to be looked at.
    pub fn nearest(&self, queries: &[Row], guesses: &[u32], most: usize, found: &mut [u32]) -> bool {
        dispatch(Search { tree: self, queries, guesses, most, found })
    }
}

/// Splits `numbers`, the first of which is at position `first`, and appends their nodes.
fn grow(points: &[f64], dimensions: usize, numbers: &mut [u32], first: usize, nodes: &mut Vec<Node>) {
    let at = |v: u32, axis: usize| points[v as usize * dimensions + axis];
    let mut spread = vec![(f64::INFINITY, f64::NEG_INFINITY); dimensions];
    for v in numbers.iter() {
        for (axis, (low, high)) in spread.iter_mut().enumerate() {
            (*low, *high) = (low.min(at(*v, axis)), high.max(at(*v, axis)));
        }
    }
    let width = |axis: &usize| spread[*axis].1 - spread[*axis].0;
    let widest = (0..dimensions).max_by(|a, b| width(a).total_cmp(&width(b))).unwrap_or(0);
    let here = nodes.len();
    nodes.push(Node { first, end: first + numbers.len(), above: None });
    if numbers.len() <= LEAF || width(&widest) <= 0.0 {
        return;
    }
    let middle = numbers.len() / 2;
    numbers.select_nth_unstable_by(middle, |a, b| at(*a, widest).total_cmp(&at(*b, widest)).then(a.cmp(b)));
    let (below, above) = numbers.split_at_mut(middle);
    grow(points, dimensions, below, first, nodes);
    nodes[here].above = Some(nodes.len());
    grow(points, dimensions, above, first + middle, nodes);
}

/// A chunk of queries and their answers.
struct Search<'a> {
    tree: &'a PointTree,
    queries: &'a [Row],
    guesses: &'a [u32],
    most: usize,
    found: &'a mut [u32],
}

impl Kernel for Search<'_> {
    type Output = bool;

    #[inline(always)]
    fn run<L: Lanes>(self, _lanes: L) -> bool {
        let Self { tree, queries, guesses, most, found } = self;
        let (mut before, mut looked_at) = (0, 0);
        // The nodes to visit, and the squared distances of their boxes.
        let mut waiting: Vec<(f64, usize)> = Vec::new();
        for (q, (query, found)) in queries.chunks_exact(tree.width).zip(found).enumerate() {
            // The smallest squared distance so far, and the point that has it.
            let mut best = (f64::INFINITY, u32::MAX);
            consider(tree, query, before, &mut best);
            if let Some(guess) = guesses.get(q).and_then(|guess| tree.places.get(*guess as usize)) {
                consider(tree, query, *guess as usize, &mut best);
            }
            waiting.push((0.0, 0));
            while let Some((gap, at)) = waiting.pop() {
                // The margin keeps rounding from excluding a point at the same distance.
                if gap > best.0 * (1.0 + 1e-12) {
                    continue;
                }
                if looked_at > most {
                    return false;
                }
                let node = &tree.nodes[at];
                let Some(above) = node.above else {
                    looked_at += node.end - node.first;
                    (node.first..node.end).for_each(|place| consider(tree, query, place, &mut best));
                    continue;
                };
                let (near, far) = (
                    (distance_to_box(tree, query, at + 1), at + 1),
                    (distance_to_box(tree, query, above), above),
                );
                let (near, far) = if near.0 <= far.0 { (near, far) } else { (far, near) };
                looked_at += 2;
                waiting.extend([far, near]);
            }
            *found = best.1;
            before = tree.places[best.1 as usize] as usize;
        }
        true
    }
}

#[inline(always)]
fn consider(tree: &PointTree, query: &[Row], place: usize, best: &mut (f64, u32)) {
    let point = &tree.points[place * tree.width..][..tree.width];
    let mut sums = [0.0; 8];
    for (query, point) in query.chunks(STRETCH).zip(point.chunks(STRETCH)) {
        for (a, b) in query.iter().zip(point) {
            for i in 0..8 {
                sums[i] += (a[i] - b[i]) * (a[i] - b[i]);
            }
        }
        if total(&sums) > best.0 {
            return;
        }
    }
    let found = (total(&sums), tree.numbers[place]);
    if found < *best {
        *best = found;
    }
}

/// Squared distance from the box; 0 inside.
#[inline(always)]
fn distance_to_box(tree: &PointTree, query: &[Row], node: usize) -> f64 {
    let mut sums = [0.0; 8];
    for (q, [low, high]) in query.iter().zip(&tree.boxes[node * tree.width..][..tree.width]) {
        for i in 0..8 {
            let gap = (low[i] - q[i]).max(q[i] - high[i]).max(0.0);
            sums[i] += gap * gap;
        }
    }
    total(&sums)
}

#[cfg(test)]
mod tests {
    use super::super::{padded, squared_distance};
    use super::*;
    use crate::simd::{alike, run_for};

    #[test]
    fn the_first_of_the_nearest_is_found_on_every_kind_of_processor() {
        for dimensions in [3, 20] {
            let mut chance = chladni_testdata::chance(dimensions as u64);
            // Some of them equal, and many at the same distance.
            let mut points = |count: usize| -> Vec<f64> {
                (0..count * dimensions).map(|_| ((chance() >> 40) % 5) as f64 / 4.0).collect()
            };
            let (points, queries) = (points(600), points(200));
            let (rows, asked) = (padded(&points, dimensions), padded(&queries, dimensions));
            let tree = PointTree::new(&points, dimensions, &rows);
            let found = alike(|processor| {
                let mut found = vec![0; 200];
                let search = Search {
                    tree: &tree,
                    queries: &asked,
                    guesses: &[],
                    most: usize::MAX,
                    found: &mut found,
                };
                run_for(processor, search)?.then_some(found)
            });
            for (query, found) in asked.chunks(tree.width).zip(found) {
                let to = |(i, point)| (squared_distance(query, point), i);
                let all = rows.chunks(tree.width).enumerate().map(to);
                let first = all.min_by(|a: &(f64, usize), b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
                assert_eq!(first.unwrap().1, found as usize);
            }
        }
    }
}
