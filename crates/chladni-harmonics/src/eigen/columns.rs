//! Writes the columns of a tall block as separate vectors.

use super::tall::BLOCK;
use crate::ldlt::Row;
use crate::simd::{Kernel, Lanes, dispatch};

/// Writes each column of a block with the rows in another order and a factor per row: for an entry (row,
/// factor) of `places`, the column gets factor times that row of the block.
pub(super) fn write_columns(block: &[Row], places: &[(u32, f64)], columns: &mut [Option<&mut [f64]>; BLOCK]) {
    dispatch(WriteColumns { block, places, columns });
}

struct WriteColumns<'a, 'b> {
    block: &'a [Row],
    places: &'a [(u32, f64)],
    columns: &'a mut [Option<&'b mut [f64]>; BLOCK],
}

impl Kernel for WriteColumns<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) {
        let Self { block, places, columns } = self;
        let (eights, rest) = places.as_chunks::<8>();
        for (at, places) in eights.iter().enumerate() {
            let rows =
                places.map(|(row, factor)| lanes.mul(lanes.splat(factor), lanes.load(&block[row as usize])));
            for (values, column) in lanes.transpose(rows).into_iter().zip(columns.iter_mut()) {
                if let Some(eight) = column.as_mut().and_then(|c| c[8 * at..].first_chunk_mut()) {
                    lanes.store(values, eight);
                }
            }
        }
        for (at, &(row, factor)) in rest.iter().enumerate() {
            for (value, column) in block[row as usize].iter().zip(columns.iter_mut()) {
                if let Some(column) = column {
                    column[8 * eights.len() + at] = factor * value;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simd::{alike, run_for};

    #[test]
    fn columns_are_written_on_every_kind_of_processor() {
        let block: Vec<Row> = (0..19).map(|i| std::array::from_fn(|j| (8 * i + j) as f64)).collect();
        let places: Vec<(u32, f64)> = (0..19).map(|i| ((5 * i + 2) % 19, 1.0 / f64::from(i + 3))).collect();
        let columns = alike(|processor| {
            let mut columns = vec![vec![0.0; 19]; BLOCK];
            let mut views: Vec<Option<&mut [f64]>> = columns.iter_mut().map(|c| Some(&mut c[..])).collect();
            // One column is left out.
            views[5] = None;
            let columns_of = views.as_mut_slice().try_into().ok()?;
            run_for(processor, WriteColumns { block: &block, places: &places, columns: columns_of })?;
            Some(columns)
        });
        for (j, column) in columns.iter().enumerate() {
            for (value, &(row, factor)) in column.iter().zip(&places) {
                let exact = if j == 5 { 0.0 } else { factor * block[row as usize][j] };
                assert_eq!(*value, exact, "column {j}");
            }
        }
    }
}
