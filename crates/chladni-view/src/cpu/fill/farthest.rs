//! The depth behind which everything is hidden already, block by block.

use super::Target;
use super::cover::LANES;
use crate::cpu::project::{Corner, SUBPIXEL_BITS};

/// Binary logarithm of the pixels of a block's side.
const BLOCK_BITS: u32 = 3;
const BLOCK: usize = 1 << BLOCK_BITS;

/// The farthest depth in each block of a target: most backs lie behind it, and need no second look.
#[derive(Debug, Default)]
pub(in crate::cpu) struct Farthest {
    /// Row by row; none before the first look.
    blocks: Vec<f32>,
    columns: usize,
}

impl Farthest {
    /// Nothing is known to be hidden.
    pub(in crate::cpu) fn forget(&mut self) {
        self.blocks.clear();
    }

    /// Looks at the first `width` pixels of each row of a target.
    pub(in crate::cpu) fn look<const PER: usize>(&mut self, target: &Target<'_>, width: usize) {
        self.forget();
        self.columns = width.div_ceil(BLOCK);
        for rows in target.depth.chunks(BLOCK * PER * target.stride) {
            for column in 0..self.columns {
                let mut farthest = [0.0_f32; LANES];
                for row in rows.chunks(PER * target.stride) {
                    let end = (PER * BLOCK * (column + 1)).min(row.len());
                    for depths in row[PER * BLOCK * column..end].chunks(LANES) {
                        for (far, depth) in farthest.iter_mut().zip(depths) {
                            *far = if *far > *depth { *far } else { *depth };
                        }
                    }
                }
                self.blocks.push(farthest.into_iter().fold(0.0, f32::max));
            }
        }
    }

    /// Whether all of a triangle lies behind the samples there.
    #[inline(always)]
    pub(super) fn hides(&self, target: &Target<'_>, [a, b, c]: &[Corner; 3]) -> bool {
        if self.blocks.is_empty() {
            return false;
        }
        let near = a.z.min(b.z).min(c.z);
        let span = |a: i32, b: i32, c: i32, axis: usize| {
            let low = (a.min(b).min(c) >> SUBPIXEL_BITS).max(target.low[axis]) - target.origin[axis];
            let high = (a.max(b).max(c) >> SUBPIXEL_BITS).min(target.high[axis]) - target.origin[axis];
            (low.max(0) as usize >> BLOCK_BITS, high.max(0) as usize >> BLOCK_BITS)
        };
        let ((left, right), (top, bottom)) = (span(a.x, b.x, c.x, 0), span(a.y, b.y, c.y, 1));
        // Large ones are looked at without this.
        right - left <= 2
            && bottom - top <= 2
            && (top..=bottom).all(|row| {
                (left..=right).all(|column| {
                    self.blocks.get(row * self.columns + column).is_some_and(|far| near >= *far)
                })
            })
    }
}
