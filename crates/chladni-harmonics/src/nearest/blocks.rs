//! The nearest points among all, by products of matrices: |p − q|² = |p|² − 2 p·q + |q|².

use faer::linalg::matmul::matmul;
use faer::{Accum, MatMut, MatRef, Par};

use super::squared_distance;
use crate::ldlt::Row;

/// How many points are multiplied at once: with 256 queries, 1 MB of products.
const BLOCK: usize = 512;

/// Points to look among.
pub(super) struct Points<'a> {
    values: &'a [f64],
    dimensions: usize,
    rows: &'a [Row],
    /// |p|² of each.
    squares: Vec<f64>,
    /// The largest |p|.
    farthest: f64,
}

impl<'a> Points<'a> {
    /// `values` holds `dimensions` coordinates of each point, and `rows` the same padded.
    pub fn new(values: &'a [f64], dimensions: usize, rows: &'a [Row]) -> Self {
        let squares: Vec<f64> = values.chunks_exact(dimensions).map(square).collect();
        let farthest = squares.iter().copied().fold(0.0, f64::max).sqrt();
        Self { values, dimensions, rows, squares, farthest }
    }

    /// For each query (`queries` as values, `query_rows` padded) the nearest point, and the first of several at the
    /// same distance.
    ///
    /// Products of matrices round differently than a sum of squares does. They only choose the points whose distances
    /// are then summed: all that rounding may have put behind the nearest.
    pub fn nearest(&self, queries: &[f64], query_rows: &[Row], found: &mut [u32]) {
        let (d, count) = (self.dimensions, found.len());
        let width = d.div_ceil(8);
        let columns = MatRef::from_column_major_slice(queries, d, count);
        let margins: Vec<f64> = queries.chunks_exact(d).map(|q| self.margin(q)).collect();
        // The least |p|² − 2 p·q, and the least distance with the point that has it.
        let mut least = vec![(f64::INFINITY, (f64::INFINITY, 0)); count];
        let mut products = vec![0.0; BLOCK.min(self.squares.len()) * count];
        for (block, squares) in self.squares.chunks(BLOCK).enumerate() {
            let (first, size) = (block * BLOCK, squares.len());
            let points = MatRef::from_row_major_slice(&self.values[first * d..(first + size) * d], size, d);
            let into = MatMut::from_column_major_slice_mut(&mut products[..size * count], size, count);
            matmul(into, Accum::Replace, points, columns, -2.0, Par::Seq);
            for (q, products) in products[..size * count].chunks_exact(size).enumerate() {
                let (bound, best) = &mut least[q];
                let lowest = lowest(squares, products);
                if lowest > *bound + margins[q] {
                    continue;
                }
                *bound = bound.min(lowest);
                let limit = *bound + margins[q];
                let query = &query_rows[q * width..(q + 1) * width];
                for (i, (square, product)) in squares.iter().zip(products).enumerate() {
                    if square + product <= limit {
                        let p = first + i;
                        let point = &self.rows[p * width..(p + 1) * width];
                        let distance = (squared_distance(query, point), p as u32);
                        *best = if distance < *best { distance } else { *best };
                    }
                }
            }
        }
        found.iter_mut().zip(least).for_each(|(found, (_, (_, p)))| *found = p);
    }

    /// More than rounding can change an order by: that of the products, and that of the sums of squares.
    fn margin(&self, query: &[f64]) -> f64 {
        let reach = self.farthest + square(query).sqrt();
        4.0 * (self.dimensions + 4) as f64 * f64::EPSILON * reach * reach + f64::MIN_POSITIVE
    }
}

fn square(x: &[f64]) -> f64 {
    x.iter().map(|x| x * x).sum()
}

/// The least of the sums.
fn lowest(a: &[f64], b: &[f64]) -> f64 {
    let mut least = [f64::INFINITY; 8];
    let (a8, a1) = a.as_chunks::<8>();
    let (b8, b1) = b.as_chunks::<8>();
    for (a, b) in a8.iter().zip(b8) {
        for i in 0..8 {
            let sum = a[i] + b[i];
            least[i] = if sum < least[i] { sum } else { least[i] };
        }
    }
    a1.iter().zip(b1).map(|(a, b)| a + b).chain(least).fold(f64::INFINITY, f64::min)
}
