//! Which triangle is seen at each sample: edge functions in whole numbers, so that neighbors neither
//! overlap nor leave a gap, and the depth of the triangle's own plane.

mod cover;
mod edges;
mod farthest;
mod plane;
#[cfg(test)]
mod tests;

use self::cover::{PIXELS, Setup};
pub(super) use self::farthest::Farthest;
use super::instructions::Kernel;
use super::project::{Chunk, Corner, area};

/// No triangle is seen.
pub(super) const NONE: u32 = u32::MAX;

/// Pixels to the right of a row that lanes may touch.
pub(super) const MARGIN: usize = PIXELS;

/// Samples of a rectangle of pixels, and what of it is to be filled.
pub(super) struct Target<'a> {
    /// Depth of each sample; all samples of a pixel lie together.
    pub(super) depth: &'a mut [f32],
    /// The triangle visible at each sample; empty where only depth counts.
    pub(super) seen: &'a mut [u32],
    /// Pixels from row to row, [`MARGIN`] of them spare.
    pub(super) stride: usize,
    /// The first pixel of the arrays.
    pub(super) origin: [i32; 2],
    /// First and last pixels to be filled, inclusive.
    pub(super) low: [i32; 2],
    pub(super) high: [i32; 2],
}

/// How far a triangle is pushed away: by units in the last place of its depth, and by what its depth
/// changes over a pixel.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Bias {
    pub(super) units: f32,
    pub(super) slope: f32,
}

/// Triangles of one figure that lie in a tile.
pub(super) struct Triangles<'a> {
    pub(super) chunk: &'a Chunk,
    pub(super) tile: usize,
    /// The fronts, or the backs.
    pub(super) front: bool,
    pub(super) triangles: &'a [[u32; 3]],
    pub(super) corners: &'a [Corner],
    /// Added to a triangle's index in `seen`.
    pub(super) base: u32,
    pub(super) bias: Bias,
    /// Depths behind which everything is hidden already.
    pub(super) farthest: &'a Farthest,
}

/// Fills `PER` samples a pixel, with depths and, where `SEEN`, with visible triangles.
pub(super) struct Fill<'a, 'b, const PER: usize, const SEEN: bool>(
    pub(super) &'b mut Target<'a>,
    pub(super) Triangles<'b>,
);

impl<const PER: usize, const SEEN: bool> Kernel for Fill<'_, '_, PER, SEEN> {
    #[inline(always)]
    fn run(self) {
        let Self(target, list) = self;
        for reference in list.chunk.tile(list.tile, list.front) {
            let (corners, triangle) = list.chunk.resolve(*reference, list.triangles, list.corners);
            if !list.farthest.hides(target, &corners) {
                fill::<PER, SEEN>(&corners, target, list.base.wrapping_add(triangle), list.bias);
            }
        }
    }
}

/// One triangle over four samples a pixel, for the few that lie in no bin.
pub(super) struct FillOne<'a, 'b> {
    pub(super) target: &'b mut Target<'a>,
    pub(super) corners: [Corner; 3],
    pub(super) id: u32,
    pub(super) bias: Bias,
}

impl Kernel for FillOne<'_, '_> {
    #[inline(always)]
    fn run(self) {
        fill::<4, true>(&self.corners, self.target, self.id, self.bias);
    }
}

/// Fills one triangle.
#[inline(always)]
fn fill<const PER: usize, const SEEN: bool>(
    corners: &[Corner; 3],
    target: &mut Target<'_>,
    id: u32,
    bias: Bias,
) {
    let (&[a, b, c], area) = (corners, area(corners));
    if area != 0 {
        let corners = if area > 0 { [a, b, c] } else { [a, c, b] };
        Setup { corners, area: area.abs() }.fill::<PER, SEEN>(target, id, bias);
    }
}
