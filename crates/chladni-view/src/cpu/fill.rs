//! Which triangle is seen at each sample: edge functions in whole numbers, so that neighbours neither
//! overlap nor leave a gap, and the depth of the triangle's own plane.

use super::instructions::Kernel;
use super::project::{Chunk, Corner, SUBPIXEL_BITS, SUBPIXELS};

/// No triangle is seen.
pub(super) const NONE: u32 = u32::MAX;

/// Samples that are tested together.
const LANES: usize = 16;

/// Where a pixel is sampled, sub-pixels from its upper left corner: as graphics cards take four, and
/// the middle.
const FOUR: [[i32; 2]; 4] = [[96, 32], [224, 96], [32, 160], [160, 224]];
const ONE: [[i32; 2]; 1] = [[SUBPIXELS / 2; 2]];

/// Offsets of the lanes: sixteen samples of four or sixteen pixels in a row.
const fn offsets<const PER: usize>(samples: [[i32; 2]; PER]) -> [[i32; LANES]; 2] {
    let mut lanes = [[0; LANES]; 2];
    let mut lane = 0;
    while lane < LANES {
        lanes[0][lane] = (lane / PER) as i32 * SUBPIXELS + samples[lane % PER][0];
        lanes[1][lane] = samples[lane % PER][1];
        lane += 1;
    }
    lanes
}

const OF_FOUR: [[i32; LANES]; 2] = offsets(FOUR);
const OF_ONE: [[i32; LANES]; 2] = offsets(ONE);

/// Pixels to the right of a row that lanes may touch, where a pixel has `per` samples.
pub(super) const fn margin(per: usize) -> usize {
    LANES / per
}

/// Samples of a rectangle of pixels, and what of it is to be filled.
pub(super) struct Target<'a> {
    /// Depth of each sample; all samples of a pixel lie together.
    pub(super) depth: &'a mut [f32],
    /// What is seen at each sample; empty where only depth counts.
    pub(super) seen: &'a mut [u32],
    /// Pixels from row to row, [`margin`] of them spare.
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
    pub(super) triangles: &'a [[u32; 3]],
    pub(super) corners: &'a [Corner],
    /// Added to a triangle's index for what is seen.
    pub(super) base: u32,
    /// True for fronts alone, false for backs.
    pub(super) side: Option<bool>,
}

/// Four samples a pixel, of depth and of what is seen.
pub(super) struct FillTile<'a, 'b>(pub(super) &'b mut Target<'a>, pub(super) Triangles<'b>);

impl Kernel for FillTile<'_, '_> {
    #[inline(always)]
    fn run(self) {
        let Self(target, list) = self;
        for reference in list.chunk.tile(list.tile) {
            let (corners, triangle) = list.chunk.resolve(*reference, list.triangles, list.corners);
            let Some(setup) = Setup::new(corners, list.side) else { continue };
            setup.fill::<4, true>(target, list.base + triangle, Bias::default());
        }
    }
}

/// One sample a pixel, of depth alone.
pub(super) struct FillDepth<'a, 'b>(pub(super) &'b mut Target<'a>, pub(super) Triangles<'b>, pub(super) Bias);

impl Kernel for FillDepth<'_, '_> {
    #[inline(always)]
    fn run(self) {
        let Self(target, list, bias) = self;
        for reference in list.chunk.tile(list.tile) {
            let (corners, _) = list.chunk.resolve(*reference, list.triangles, list.corners);
            let Some(setup) = Setup::new(corners, None) else { continue };
            setup.fill::<1, false>(target, 0, bias);
        }
    }
}

/// A triangle whose inside is where all its edge functions are positive.
struct Setup {
    corners: [Corner; 3],
    area: i64,
}

impl Setup {
    /// `None` for a triangle without area, or of the other side.
    #[inline(always)]
    fn new([a, b, c]: [Corner; 3], side: Option<bool>) -> Option<Self> {
        let wide = |a: i32, b: i32| i64::from(b) - i64::from(a);
        let area = wide(a.x, b.x) * wide(a.y, c.y) - wide(a.y, b.y) * wide(a.x, c.x);
        // Fronts are wound counter-clockwise where y goes up, and here it goes down.
        if area == 0 || side.is_some_and(|front| front != (area < 0)) {
            return None;
        }
        let corners = if area > 0 { [a, b, c] } else { [a, c, b] };
        Some(Self { corners, area: area.abs() })
    }

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
        let pixels = LANES / PER;
        let start = [low[0] << SUBPIXEL_BITS, low[1] << SUBPIXEL_BITS];
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
                edge.across.times(T::of(pixels as i64 * i64::from(SUBPIXELS))),
                edge.down.times(T::of(SUBPIXELS.into())),
            )
        });
        let depth_steps = [plane.across * (pixels as i32 * SUBPIXELS) as f32, plane.down * SUBPIXELS as f32];
        let blocks = (high[0] - low[0]) as usize / pixels + 1;
        let column = (low[0] - target.origin[0]) as usize;
        for y in low[1]..=high[1] {
            let row = (y - target.origin[1]) as usize * target.stride + column;
            let (mut e, mut z) = (values, depths);
            for block in 0..blocks {
                let at = (row + block * pixels) * PER;
                let Some(depth) = target.depth[at..].first_chunk_mut::<LANES>() else { break };
                let mut nobody = [NONE; LANES];
                let all_seen = if SEEN { &mut target.seen[at..] } else { &mut nobody[..] };
                let Some(seen) = all_seen.first_chunk_mut::<LANES>() else { break };
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
        if let Some(setup) = Setup::new(self.corners, None) {
            setup.fill::<4, true>(self.target, self.id, self.bias);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: i32 = 40;

    /// How often each sample is covered by triangles of these corners, in sub-pixels.
    fn covered(triangles: &[[[i32; 2]; 3]]) -> Vec<u32> {
        let stride = SIZE as usize + margin(4);
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
