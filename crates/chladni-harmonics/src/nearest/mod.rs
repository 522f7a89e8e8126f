//! Exact nearest neighbors in any number of dimensions, for example among the rows of a spectral embedding.

mod blocks;
mod tree;

use std::sync::atomic::{AtomicUsize, Ordering};

use chladni_task::{Cancelled, Task};
use rayon::prelude::*;

use crate::ldlt::Row;
use blocks::Points;
use tree::PointTree;

/// How many queries are answered in sequence.
const CHUNK: usize = 256;
/// The most dimensions in which a tree always excludes most points.
const FEW: usize = 8;
/// A tree is given up where it leaves more than one in this many points: then multiplying with all is faster.
const SHARE: usize = 16;
/// After this many chunks in which the tree was given up, it is not tried again.
const FUTILE: usize = 3;

/// For each of `queries` the nearest of at least one of `points`, and the first of several at the same distance. Both
/// have `dimensions` ≥ 1 finite coordinates, one point after the other. `guesses`, one per query or empty, only
/// speed up the search.
///
/// The two ways to search find the same points bit for bit: it does not matter which is taken where.
pub(crate) fn nearest(
    points: &[f64],
    queries: &[f64],
    dimensions: usize,
    guesses: &[u32],
    task: &Task,
) -> Result<Vec<u32>, Cancelled> {
    let (rows, query_rows) = (padded(points, dimensions), padded(queries, dimensions));
    let (count, width) = (points.len() / dimensions, dimensions.div_ceil(8));
    let tree = PointTree::new(points, dimensions, &rows);
    let all = Points::new(points, dimensions, &rows);
    let futile = AtomicUsize::new(0);
    let mut found = vec![0; queries.len() / dimensions];
    found.par_chunks_mut(CHUNK).enumerate().try_for_each(|(chunk, found)| {
        task.check()?;
        let first = chunk * CHUNK;
        let last = first + found.len();
        let rows = &query_rows[first * width..last * width];
        let most = if dimensions <= FEW { usize::MAX } else { found.len() * (count / SHARE).max(CHUNK) };
        if futile.load(Ordering::Relaxed) < FUTILE {
            if tree.nearest(rows, guesses.get(first..).unwrap_or_default(), most, found) {
                return Ok(());
            }
            futile.fetch_add(1, Ordering::Relaxed);
        }
        all.nearest(&queries[first * dimensions..last * dimensions], rows, found);
        Ok(())
    })?;
    Ok(found)
}

/// Splits values into rows of eight, each point padded with zeros.
fn padded(values: &[f64], dimensions: usize) -> Vec<Row> {
    let width = dimensions.div_ceil(8);
    let mut rows = vec![[0.0; 8]; values.len() / dimensions * width];
    rows.par_chunks_exact_mut(width).zip(values.par_chunks_exact(dimensions)).for_each(|(rows, values)| {
        rows.as_flattened_mut()[..dimensions].copy_from_slice(values);
    });
    rows
}

/// |a − b|², summed as the tree sums it.
#[inline(always)]
fn squared_distance(a: &[Row], b: &[Row]) -> f64 {
    let mut sums = [0.0; 8];
    for (a, b) in a.iter().zip(b) {
        for i in 0..8 {
            sums[i] += (a[i] - b[i]) * (a[i] - b[i]);
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
            let guesses = vec![guess as u32; queries.len() / dimensions];
            let found = nearest(&points, &queries, dimensions, &guesses, &Task::new()).unwrap();
            let (rows, asked) = (padded(&points, dimensions), padded(&queries, dimensions));
            let mut in_blocks = vec![0; found.len()];
            Points::new(&points, dimensions, &rows).nearest(&queries, &asked, &mut in_blocks);
            prop_assert_eq!(&in_blocks, &found);
            let distance = |q: &[f64], p: &[f64]| q.iter().zip(p).map(|(a, b)| (a - b) * (a - b)).sum::<f64>();
            for (query, found) in queries.chunks(dimensions).zip(&found) {
                let all = points.chunks(dimensions).enumerate();
                let best = all.map(|(i, p)| (distance(query, p), i as u32)).min_by(|a, b| a.partial_cmp(b).unwrap());
                prop_assert_eq!(best.unwrap().1, *found);
            }
        }
    }
    #[test]
    fn points_without_order_are_found_in_blocks() {
        // Neighbors in forty dimensions, of which a tree excludes hardly any.
        let mut state = 7_u64;
        let mut random = |count: usize| -> Vec<f64> {
            let mut next = || {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                (state >> 11) as f64 / (1_u64 << 53) as f64
            };
            (0..count).map(|_| next()).collect()
        };
        let (d, points, queries) = (40, random(40 * 3000), random(40 * 700));
        let rows = padded(&points, d);
        let tree = PointTree::new(&points, d, &rows);
        let asked = padded(&queries, d);
        let mut found = vec![0; 700];
        assert!(!tree.nearest(&asked, &[], 700 * 3000 / SHARE, &mut found));
        assert!(tree.nearest(&asked, &[], usize::MAX, &mut found));
        assert_eq!(nearest(&points, &queries, d, &[], &Task::new()).unwrap(), found);
        let cancelled = Task::new();
        cancelled.cancel();
        assert!(nearest(&points, &queries, d, &[], &cancelled).is_err());
    }
}
