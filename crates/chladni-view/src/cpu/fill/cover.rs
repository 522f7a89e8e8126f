//! The samples that a triangle covers, sixteen at a time.

use super::edges::{Edge, Whole};
use super::plane::Plane;
use super::{Bias, NONE, Target};
use crate::cpu::project::{Corner, SUBPIXEL_BITS, SUBPIXELS};

/// Samples that are tested together.
pub(super) const LANES: usize = 16;

/// Where a pixel is sampled, sub-pixels from its upper left corner: as graphics cards take four, and
/// the middle.
const FOUR: [[i32; 2]; 4] = [[96, 32], [224, 96], [32, 160], [160, 224]];
const ONE: [[i32; 2]; 1] = [[SUBPIXELS / 2; 2]];

/// Pixels that are tested together: four in a row, and as many rows as there are lanes for.
pub(super) const PIXELS: usize = 4;

/// Offsets of the lanes: sixteen samples of four pixels, or of four times four.
const fn offsets<const PER: usize>(samples: [[i32; 2]; PER]) -> [[i32; LANES]; 2] {
    let mut lanes = [[0; LANES]; 2];
    let mut lane = 0;
    while lane < LANES {
        let (pixel, sample) = (lane / PER, samples[lane % PER]);
        lanes[0][lane] = (pixel % PIXELS) as i32 * SUBPIXELS + sample[0];
        lanes[1][lane] = (pixel / PIXELS) as i32 * SUBPIXELS + sample[1];
        lane += 1;
    }
    lanes
}

const OF_FOUR: [[i32; LANES]; 2] = offsets(FOUR);
const OF_ONE: [[i32; LANES]; 2] = offsets(ONE);

/// A triangle whose inside is where all its edge functions are positive.
pub(super) struct Setup {
    pub(super) corners: [Corner; 3],
    pub(super) area: i64,
}

impl Setup {
    /// Takes the samples of `target` that it covers and that nothing hides.
    #[inline(always)]
    pub(super) fn fill<const PER: usize, const SEEN: bool>(
        &self,
        target: &mut Target<'_>,
        id: u32,
        bias: Bias,
    ) {
        let [a, b, c] = self.corners;
        let (left, right) = (a.x.min(b.x).min(c.x), a.x.max(b.x).max(c.x));
        let (top, bottom) = (a.y.min(b.y).min(c.y), a.y.max(b.y).max(c.y));
        let low = [(left >> SUBPIXEL_BITS).max(target.low[0]), (top >> SUBPIXEL_BITS).max(target.low[1])];
        let high =
            [(right >> SUBPIXEL_BITS).min(target.high[0]), (bottom >> SUBPIXEL_BITS).min(target.high[1])];
        if low[0] > high[0] || low[1] > high[1] {
            return;
        }
        let plane = Plane::new(self.corners, self.area, bias);
        // Where differences have 14 bits, sums of two products have 30.
        if right - left < 1 << 14 && bottom - top < 1 << 14 {
            self.cover::<i32, PER, SEEN>(target, (low, high), &plane, id);
        } else {
            self.cover::<i64, PER, SEEN>(target, (low, high), &plane, id);
        }
    }

    #[inline(always)]
    fn cover<T: Whole, const PER: usize, const SEEN: bool>(
        &self,
        target: &mut Target<'_>,
        (low, high): ([i32; 2], [i32; 2]),
        plane: &Plane,
        id: u32,
    ) {
        let offsets = if PER == 4 { &OF_FOUR } else { &OF_ONE };
        // Rows of a block, which lie apart in the target unless there is but one.
        let rows = LANES / PER / PIXELS;
        // Blocks lie on a grid, so that what one triangle writes the next one reads in one piece.
        let left = low[0] - ((low[0] - target.origin[0]) & (PIXELS as i32 - 1));
        let start = [left << SUBPIXEL_BITS, low[1] << SUBPIXEL_BITS];
        let [a, b, c] = self.corners;
        let edges = [Edge::<T>::new(b, c, start), Edge::new(c, a, start), Edge::new(a, b, start)];
        let mut values: [[T; LANES]; 3] = [[T::of(0); LANES]; 3];
        for (values, edge) in values.iter_mut().zip(&edges) {
            for lane in 0..LANES {
                let [dx, dy] = [T::of(offsets[0][lane].into()), T::of(offsets[1][lane].into())];
                values[lane] = edge.value.plus(edge.across.times(dx)).plus(edge.down.times(dy));
            }
        }
        let mut depths = [0.0_f32; LANES];
        let first = plane.at(start);
        for lane in 0..LANES {
            depths[lane] =
                first + plane.across * offsets[0][lane] as f32 + plane.down * offsets[1][lane] as f32;
        }
        let step = |edge: &Edge<T>| {
            let of = |pixels: usize| T::of(pixels as i64 * i64::from(SUBPIXELS));
            (edge.across.times(of(PIXELS)), edge.down.times(of(rows)))
        };
        let steps = [step(&edges[0]), step(&edges[1]), step(&edges[2])];
        let depth_steps = [
            plane.across * (PIXELS as i32 * SUBPIXELS) as f32,
            plane.down * (rows as i32 * SUBPIXELS) as f32,
        ];
        let blocks = (high[0] - left) as usize / PIXELS + 1;
        let column = (left - target.origin[0]) as usize;
        for y in (low[1]..=high[1]).step_by(rows) {
            let row = (y - target.origin[1]) as usize * target.stride + column;
            let (mut e, mut z) = (values, depths);
            for block in 0..blocks {
                let at = (row + block * PIXELS) * PER;
                if SEEN {
                    let Some(depth) = target.depth[at..].first_chunk_mut() else { break };
                    let Some(seen) = target.seen[at..].first_chunk_mut() else { break };
                    take::<T, SEEN>(&e, &z, plane, depth, seen, id);
                } else {
                    let mut depth = [f32::NEG_INFINITY; LANES];
                    // The last rows of a block may lie below the target.
                    let part = |row: usize| at + row * target.stride..at + row * target.stride + PIXELS;
                    for (row, lanes) in depth.chunks_exact_mut(PIXELS).enumerate() {
                        if let Some(there) = target.depth.get(part(row)) {
                            lanes.copy_from_slice(there);
                        }
                    }
                    take::<T, SEEN>(&e, &z, plane, &mut depth, &mut [NONE; LANES], id);
                    for (row, lanes) in depth.chunks_exact(PIXELS).enumerate() {
                        if let Some(there) = target.depth.get_mut(part(row)) {
                            there.copy_from_slice(lanes);
                        }
                    }
                }
                for edge in 0..3 {
                    for lane in 0..LANES {
                        e[edge][lane] = e[edge][lane].plus(steps[edge].0);
                    }
                }
                for lane in 0..LANES {
                    z[lane] += depth_steps[0];
                }
            }
            for edge in 0..3 {
                for lane in 0..LANES {
                    values[edge][lane] = values[edge][lane].plus(steps[edge].1);
                }
            }
            for lane in 0..LANES {
                depths[lane] += depth_steps[1];
            }
        }
    }
}

/// Takes the samples that lie inside all edges and before the depths there.
#[inline(always)]
fn take<T: Whole, const SEEN: bool>(
    e: &[[T; LANES]; 3],
    z: &[f32; LANES],
    plane: &Plane,
    depth: &mut [f32; LANES],
    seen: &mut [u32; LANES],
    id: u32,
) {
    for lane in 0..LANES {
        let inside = T::none_negative(e[0][lane], e[1][lane], e[2][lane]);
        // Within the triangle's own depths, however thin it is.
        let mut here = z[lane];
        here = if here < plane.low { plane.low } else { here };
        here = if here > plane.high { plane.high } else { here };
        let nearer = inside & (here < depth[lane]);
        depth[lane] = if nearer { here } else { depth[lane] };
        if SEEN {
            seen[lane] = if nearer { id } else { seen[lane] };
        }
    }
}
