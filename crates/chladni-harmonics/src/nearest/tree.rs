//! Exact nearest neighbors in any number of dimensions, for example among the rows of a spectral embedding.
//!
//! Vertices that are neighbors on a surface are close in all coordinates of such an embedding at once. Each
//! node of the tree therefore keeps the bounding box of its points in all dimensions: beyond ten
//! dimensions, bounds from the splitting planes alone exclude hardly anything.

use rayon::prelude::*;

use crate::ldlt::Row;
use crate::simd::{Kernel, Lanes, dispatch};

/// The largest number of points in a leaf.
const LEAF: usize = 16;
/// How many rows of eight coordinates are summed between two checks whether a point is too far already.
const STRETCH: usize = 4;
/// How many queries are answered in sequence; each starts with the answer to the previous one.
const CHUNK: usize = 256;

/// A binary tree over points. Each node splits its points in half along the dimension in which they spread
/// most.
pub(crate) struct PointTree {
    dimensions: usize,
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
    /// after the other.
    pub fn new(points: &[f64], dimensions: usize) -> Self {
        let count = points.len() / dimensions;
        let width = dimensions.div_ceil(8);
        let mut numbers: Vec<u32> = (0..count as u32).collect();
        let mut nodes = Vec::new();
        grow(points, dimensions, &mut numbers, 0, &mut nodes);
        let rows = padded(points, dimensions, width);
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
        Self { dimensions, width, points, numbers, places, nodes, boxes }
    }

    /// For each of `queries` the nearest point, and the first of several at the same distance. `guesses`,
    /// one per query or empty, only speed up the search.
    pub fn nearest(&self, queries: &[f64], guesses: &[u32]) -> Vec<u32> {
        let queries = padded(queries, self.dimensions, self.width);
        let mut found = vec![0; queries.len() / self.width];
        found.par_chunks_mut(CHUNK).enumerate().for_each(|(chunk, found)| {
            let first = chunk * CHUNK;
            let queries = &queries[first * self.width..(first + found.len()) * self.width];
            dispatch(Search {
                tree: self,
                queries,
                guesses: guesses.get(first..).unwrap_or_default(),
                found,
            });
        });
        found
    }
}

/// Splits values into rows of eight, padded with zeros.
fn padded(values: &[f64], dimensions: usize, width: usize) -> Vec<Row> {
    let mut rows = vec![[0.0; 8]; values.len() / dimensions * width];
    rows.par_chunks_exact_mut(width).zip(values.par_chunks_exact(dimensions)).for_each(|(rows, values)| {
        rows.as_flattened_mut()[..dimensions].copy_from_slice(values);
    });
    rows
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
    found: &'a mut [u32],
}

impl Kernel for Search<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, _lanes: L) {
        let Self { tree, queries, guesses, found } = self;
        let mut before = 0;
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
                let node = &tree.nodes[at];
                let Some(above) = node.above else {
                    (node.first..node.end).for_each(|place| consider(tree, query, place, &mut best));
                    continue;
                };
                let (near, far) = (
                    (distance_to_box(tree, query, at + 1), at + 1),
                    (distance_to_box(tree, query, above), above),
                );
                let (near, far) = if near.0 <= far.0 { (near, far) } else { (far, near) };
                waiting.extend([far, near]);
            }
            *found = best.1;
            before = tree.places[best.1 as usize] as usize;
        }
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

#[inline(always)]
fn total(sums: &Row) -> f64 {
    ((sums[0] + sums[4]) + (sums[2] + sums[6])) + ((sums[1] + sums[5]) + (sums[3] + sums[7]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(64) })]
        #[test]
        fn it_finds_what_looking_at_all_points_finds(
            dimensions in 1..20_usize,
            values in prop::collection::vec(-4..4_i8, 20..2000),
            queries in prop::collection::vec(-9..9_i8, 20..200),
            guess in 0..1_usize,
        ) {
            // Integer coordinates give many ties and equal points.
            let cut = |values: &[i8]| -> Vec<f64> {
                values[..values.len() / dimensions * dimensions].iter().map(|x| f64::from(*x) / 2.0).collect()
            };
            let (points, queries) = (cut(&values), cut(&queries));
            let tree = PointTree::new(&points, dimensions);
            let guesses = vec![guess as u32; queries.len() / dimensions];
            let found = tree.nearest(&queries, &guesses);
            let distance = |q: &[f64], p: &[f64]| q.iter().zip(p).map(|(a, b)| (a - b) * (a - b)).sum::<f64>();
            for (query, found) in queries.chunks(dimensions).zip(&found) {
                let all = points.chunks(dimensions).enumerate();
                let best = all.map(|(i, p)| (distance(query, p), i as u32)).min_by(|a, b| a.partial_cmp(b).unwrap());
                prop_assert_eq!(best.unwrap().1, *found);
            }
        }
    }
}
