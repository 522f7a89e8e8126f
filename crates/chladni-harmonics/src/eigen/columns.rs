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
