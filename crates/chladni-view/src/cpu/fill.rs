//! Which triangle is seen at each sample: edge functions in whole numbers, so that neighbours neither
//! overlap nor leave a gap, and the depth of the triangle's own plane.

use super::instructions::Kernel;
use super::project::{Chunk, Corner, SUBPIXEL_BITS, SUBPIXELS, area};

/// No triangle is seen.
pub(super) const NONE: u32 = u32::MAX;

/// Samples that are tested together.
const LANES: usize = 16;

/// Where a pixel is sampled, sub-pixels from its upper left corner: as graphics cards take four, and
/// the middle.
const FOUR: [[i32; 2]; 4] = [[96, 32], [224, 96], [32, 160], [160, 224]];
const ONE: [[i32; 2]; 1] = [[SUBPIXELS / 2; 2]];

/// Pixels that are tested together: four in a row, and as many rows as there are lanes for.
const PIXELS: usize = 4;

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

/// Pixels to the right of a row that lanes may touch.
pub(super) const MARGIN: usize = PIXELS;

/// Samples of a rectangle of pixels, and what of it is to be filled.
pub(super) struct Target<'a> {
    /// Depth of each sample; all samples of a pixel lie together.
    pub(super) depth: &'a mut [f32],
    /// What is seen at each sample; empty where only depth counts.
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
    /// Added to a triangle's index for what is seen.
    pub(super) base: u32,
    pub(super) bias: Bias,
    /// What is hidden already.
    pub(super) farthest: &'a Farthest,
}

/// Fills `PER` samples a pixel, of depth and, where `SEEN`, of what is seen.
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

/// Binary logarithm of the pixels of a block's side.
const BLOCK_BITS: u32 = 3;
const BLOCK: usize = 1 << BLOCK_BITS;

/// The farthest depth in each block of a target: most backs lie behind it, and need no second look.
#[derive(Debug, Default)]
pub(super) struct Farthest {
    /// Row by row; none before the first look.
    blocks: Vec<f32>,
    columns: usize,
}

impl Farthest {
    /// Nothing is known to be hidden.
    pub(super) fn forget(&mut self) {
        self.blocks.clear();
    }

    /// Looks at the first `width` pixels of each row of a target.
    pub(super) fn look<const PER: usize>(&mut self, target: &Target<'_>, width: usize) {
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

    #[inline(always)]
    fn hides(&self, target: &Target<'_>, [a, b, c]: &[Corner; 3]) -> bool {
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

/// A triangle whose inside is where all its edge functions are positive.
struct Setup {
    corners: [Corner; 3],
    area: i64,
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

impl Setup {
    #[inline(always)]
    fn fill<const PER: usize, const SEEN: bool>(&self, target: &mut Target<'_>, id: u32, bias: Bias) {
        let [a, b, c] = self.corners;
        let (left, right) = (a.x.min(b.x).min(c.x), a.x.max(b.x).max(c.x));
        let (top, bottom) = (a.y.min(b.y).min(c.y), a.y.max(b.y).max(c.y));
        let low = [(left >> SUBPIXEL_BITS).max(target.low[0]), (top >> SUBPIXEL_BITS).max(target.low[1])];
        let high =
            [(right >> SUBPIXEL_BITS).min(target.high[0]), (bottom >> SUBPIXEL_BITS).min(target.high[1])];
        if low[0] > high[0] || low[1] > high[1] {
            return;
        }
        let plane = Plane::new(self, bias);
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
        let edges = [(b, c), (c, a), (a, b)].map(|(from, to)| Edge::<T>::new(from, to, start));
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
        let steps = edges.map(|edge| {
            (
                edge.across.times(T::of(PIXELS as i64 * i64::from(SUBPIXELS))),
                edge.down.times(T::of(rows as i64 * i64::from(SUBPIXELS))),
            )
        });
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

/// Takes the samples that lie inside all edges and before what is there.
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

/// Depth over the screen.
struct Plane {
    corner: Corner,
    /// Per sub-pixel.
    across: f32,
    down: f32,
    bias: f32,
    low: f32,
    high: f32,
}

impl Plane {
    #[inline(always)]
    fn new(setup: &Setup, bias: Bias) -> Self {
        let [a, b, c] = setup.corners;
        let area = setup.area as f32;
        let (dx, dy) = ([(b.x - a.x) as f32, (c.x - a.x) as f32], [(b.y - a.y) as f32, (c.y - a.y) as f32]);
        let (db, dc) = (b.z - a.z, c.z - a.z);
        let across = (db * dy[1] - dc * dy[0]) / area;
        let down = (dc * dx[0] - db * dx[1]) / area;
        let low = if a.z < b.z { a.z } else { b.z };
        let high = if a.z > b.z { a.z } else { b.z };
        let (low, high) = (if low < c.z { low } else { c.z }, if high > c.z { high } else { c.z });
        // A unit in the last place of the farthest corner.
        let unit = f32::from_bits((high.to_bits() & 0x7f80_0000).saturating_sub(23 << 23));
        let steepest = if across.abs() > down.abs() { across.abs() } else { down.abs() };
        let bias = bias.units * unit + bias.slope * steepest * SUBPIXELS as f32;
        Self { corner: a, across, down, bias, low: low + bias, high: high + bias }
    }

    #[inline(always)]
    fn at(&self, [x, y]: [i32; 2]) -> f32 {
        let corner = self.corner;
        corner.z + self.bias + self.across * (x - corner.x) as f32 + self.down * (y - corner.y) as f32
    }
}

/// An edge function: positive, or zero on an edge that is the triangle's own, to the right of the edge.
#[derive(Clone, Copy)]
struct Edge<T> {
    across: T,
    down: T,
    /// At the start.
    value: T,
}

impl<T: Whole> Edge<T> {
    #[inline(always)]
    fn new(from: Corner, to: Corner, start: [i32; 2]) -> Self {
        let (across, down) = (i64::from(from.y) - i64::from(to.y), i64::from(to.x) - i64::from(from.x));
        let value = across * (i64::from(start[0]) - i64::from(from.x))
            + down * (i64::from(start[1]) - i64::from(from.y));
        // A sample on an edge belongs to the triangle that has it on its left or on its top.
        let own = across > 0 || (across == 0 && down > 0);
        Self { across: T::of(across), down: T::of(down), value: T::of(value - i64::from(!own)) }
    }
}

/// Whole numbers of one width.
trait Whole: Copy {
    fn of(value: i64) -> Self;
    fn plus(self, other: Self) -> Self;
    fn times(self, other: Self) -> Self;
    fn none_negative(a: Self, b: Self, c: Self) -> bool;
}

macro_rules! whole {
    ($type:ty) => {
        impl Whole for $type {
            #[inline(always)]
            fn of(value: i64) -> Self {
                value as $type
            }

            // Lanes beyond a triangle's box may go beyond the number; nobody looks at them.
            #[inline(always)]
            fn plus(self, other: Self) -> Self {
                self.wrapping_add(other)
            }

            #[inline(always)]
            fn times(self, other: Self) -> Self {
                self.wrapping_mul(other)
            }

            #[inline(always)]
            fn none_negative(a: Self, b: Self, c: Self) -> bool {
                (a | b | c) >= 0
            }
        }
    };
}
whole!(i32);
whole!(i64);

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

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: i32 = 40;

    /// How often each sample is covered by triangles of these corners, in sub-pixels.
    fn covered(triangles: &[[[i32; 2]; 3]]) -> Vec<u32> {
        let stride = SIZE as usize + MARGIN;
        let mut counts = vec![0; 4 * stride * SIZE as usize];
        for t in triangles {
            let (mut depth, mut seen) = (vec![1.0; counts.len()], vec![NONE; counts.len()]);
            let mut target = Target {
                depth: &mut depth,
                seen: &mut seen,
                stride,
                origin: [0; 2],
                low: [0; 2],
                high: [SIZE - 1; 2],
            };
            let corners = t.map(|[x, y]| Corner { x, y, z: 0.5 });
            FillOne { target: &mut target, corners, id: 7, bias: Bias::default() }.run();
            for (count, seen) in counts.iter_mut().zip(&seen) {
                *count += u32::from(*seen == 7);
            }
        }
        counts.chunks(4 * stride).flat_map(|row| row[..4 * SIZE as usize].to_vec()).collect()
    }

    /// A fan around a point, its rim far outside: every sample of the square once.
    #[test]
    fn a_fan_covers_every_sample_once() {
        // In the middle of a sample, on a corner, beside everything; near and far rims.
        for middle in [[96 + 20 * 256, 32 + 20 * 256], [5120, 5120], [4711, 3333]] {
            for reach in [1 << 14, 1 << 22] {
                let rim: Vec<[i32; 2]> = (0..11)
                    .map(|i| (f64::from(i) * std::f64::consts::TAU / 11.0).sin_cos())
                    .map(|(s, c)| {
                        [(c * f64::from(reach)) as i32 + 5000, (s * f64::from(reach)) as i32 + 5000]
                    })
                    .collect();
                let fan: Vec<_> = (0..11).map(|i| [middle, rim[i], rim[(i + 1) % 11]]).collect();
                assert!(covered(&fan).iter().all(|count| *count == 1), "{middle:?} {reach}");
            }
        }
    }

    /// Small cells of a jittered grid, whose corners lie on samples, too.
    #[test]
    fn a_fine_mesh_has_neither_gaps_nor_overlaps() {
        let mut state = 12345_u32;
        let mut chance = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 24) as i32
        };
        let side = 24;
        let points: Vec<[i32; 2]> = (0..side * side)
            .map(|i| {
                [(i % side) * 512 - 512 + chance() / 32 * 32, (i / side) * 512 - 512 + chance() / 32 * 32]
            })
            .collect();
        let at = |x: i32, y: i32| points[(y * side + x) as usize];
        let mesh: Vec<_> = (0..side - 1)
            .flat_map(|y| (0..side - 1).map(move |x| (x, y)))
            .flat_map(|(x, y)| {
                let quad = [at(x, y), at(x, y + 1), at(x + 1, y), at(x + 1, y + 1)];
                // Both windings.
                [[quad[0], quad[1], quad[2]], [quad[3], quad[2], quad[1]]]
            })
            .collect();
        assert!(covered(&mesh).iter().all(|count| *count == 1));
    }

    #[test]
    fn what_has_no_area_is_not_seen_and_nearer_goes_before() {
        assert!(covered(&[[[0, 0], [9000, 9000], [4500, 4500]], [[7, 7]; 3]]).iter().all(|c| *c == 0));
        let (mut depth, mut seen) = (vec![1.0_f32; 4 * 17 * 4], vec![NONE; 4 * 17 * 4]);
        let mut target = Target {
            depth: &mut depth,
            seen: &mut seen,
            stride: 17,
            origin: [0; 2],
            low: [0; 2],
            high: [0, 3],
        };
        let corners = |z| [[-9000, -9000], [9000, -9000], [0, 9000]].map(|[x, y]| Corner { x, y, z });
        for (id, z) in [(1, 0.5), (2, 0.25), (3, 0.75), (4, f32::NAN), (5, 1.0)] {
            FillOne { target: &mut target, corners: corners(z), id, bias: Bias::default() }.run();
        }
        assert_eq!((seen[0], depth[0]), (2, 0.25));
    }
}
