//! Exact nearest neighbors in any number of dimensions, as of vertices among the rows of a spectral embedding.

use rayon::prelude::*;

/// Points in a leaf.
const LEAF: usize = 16;
/// Coordinates between two looks at whether a point is too far already.
const STRETCH: usize = 8;
/// Queries that are answered one after the other, each beginning with the answer to the one before.
const CHUNK: usize = 256;

/// Points in a tree of halves, each split where its points spread most.
pub(crate) struct PointTree<'a> {
    points: &'a [f64],
    dimensions: usize,
    order: Vec<u32>,
    nodes: Vec<Node>,
}

enum Node {
    /// Places in the order.
    Leaf(usize, usize),
    /// Points below `at` along `axis` lie in the node after this one, the others in node `above`.
    Split { axis: usize, at: f64, above: usize },
}

impl<'a> PointTree<'a> {
    /// A tree of `points`, one after the other with `dimensions` ≥ 1 finite coordinates each; at least one.
    pub fn new(points: &'a [f64], dimensions: usize) -> Self {
        let order = (0..(points.len() / dimensions) as u32).collect();
        let mut tree = Self { points, dimensions, order, nodes: Vec::new() };
        tree.grow(0, tree.order.len());
        tree
    }

    fn grow(&mut self, first: usize, end: usize) {
        let (points, dimensions) = (self.points, self.dimensions);
        let order = &mut self.order[first..end];
        let at = |v: u32, axis: usize| points[v as usize * dimensions + axis];
        let mut spread = vec![(f64::INFINITY, f64::NEG_INFINITY); dimensions];
        for v in order.iter() {
            for (axis, (low, high)) in spread.iter_mut().enumerate() {
                (*low, *high) = (low.min(at(*v, axis)), high.max(at(*v, axis)));
            }
        }
        let width = |axis: &usize| spread[*axis].1 - spread[*axis].0;
        let widest = (0..dimensions).max_by(|a, b| width(a).total_cmp(&width(b))).unwrap_or(0);
        if order.len() <= LEAF || width(&widest) <= 0.0 {
            self.nodes.push(Node::Leaf(first, end));
            return;
        }
        let middle = order.len() / 2;
        let by_place = |a: &u32, b: &u32| at(*a, widest).total_cmp(&at(*b, widest)).then(a.cmp(b));
        let split = at(*order.select_nth_unstable_by(middle, by_place).1, widest);
        let here = self.nodes.len();
        self.nodes.push(Node::Split { axis: widest, at: split, above: 0 });
        self.grow(first, first + middle);
        let after = self.nodes.len();
        if let Node::Split { above, .. } = &mut self.nodes[here] {
            *above = after;
        }
        self.grow(first + middle, end);
    }

    /// For each of `queries` the point nearest to it, the first of several. `guesses`, one per query or none, only
    /// make it quicker.
    pub fn nearest(&self, queries: &[f64], guesses: &[u32]) -> Vec<u32> {
        let count = queries.len() / self.dimensions;
        let chunks = (0..count.div_ceil(CHUNK)).into_par_iter().map(|chunk| {
            let mut search =
                Search { tree: self, query: &[], offsets: vec![0.0; self.dimensions], best: (0.0, 0) };
            let mut before = self.order[0];
            let queries = (chunk * CHUNK..count.min((chunk + 1) * CHUNK)).map(|q| {
                search.query = &queries[q * self.dimensions..(q + 1) * self.dimensions];
                search.best = (f64::INFINITY, u32::MAX);
                search.offsets.fill(0.0);
                search.consider(before);
                guesses.get(q).into_iter().for_each(|guess| search.consider(*guess));
                search.visit(0, 0.0);
                before = search.best.1;
                before
            });
            queries.collect::<Vec<u32>>()
        });
        chunks.flatten_iter().collect()
    }
}

struct Search<'a, 'b> {
    tree: &'b PointTree<'a>,
    query: &'b [f64],
    /// How far the node that is looked at lies from the query, along each axis.
    offsets: Vec<f64>,
    /// The smallest squared distance so far, and whose it is.
    best: (f64, u32),
}

impl Search<'_, '_> {
    fn consider(&mut self, point: u32) {
        let at = point as usize * self.tree.dimensions;
        let coordinates = &self.tree.points[at..at + self.tree.dimensions];
        let mut sum = 0.0;
        for (a, b) in self.query.chunks(STRETCH).zip(coordinates.chunks(STRETCH)) {
            sum += a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>();
            if sum > self.best.0 {
                return;
            }
        }
        if (sum, point) < self.best {
            self.best = (sum, point);
        }
    }

    /// Looks at a node that is `distance` (squared) away.
    fn visit(&mut self, node: usize, distance: f64) {
        // Rounding must not hide a point that is as near.
        if distance > self.best.0 * (1.0 + 1e-12) {
            return;
        }
        match self.tree.nodes[node] {
            Node::Leaf(first, end) => {
                for at in first..end {
                    self.consider(self.tree.order[at]);
                }
            }
            Node::Split { axis, at, above } => {
                let gap = self.query[axis] - at;
                let (near, far) = if gap < 0.0 { (node + 1, above) } else { (above, node + 1) };
                self.visit(near, distance);
                let old = std::mem::replace(&mut self.offsets[axis], gap);
                self.visit(far, distance - old * old + gap * gap);
                self.offsets[axis] = old;
            }
        }
    }
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
            // Whole numbers, so that there are many ties and equal points.
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
