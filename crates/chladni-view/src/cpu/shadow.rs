//! The key light's map of one cell: depth as it sees it, and what share of it reaches a place.

use rayon::prelude::*;

use super::batch::{Batch, PLACES};
use super::curves::{clamp, each, mix, whole};
use super::fill::{Bias, Farthest, Fill, MARGIN, Target, Triangles};
use super::instructions::{Instructions, Kernel};
use super::project::Grid;
use super::projected::Projected;

/// Rows of a map that are filled together.
const BAND_BITS: u32 = 6;

/// As the graphics device's pipeline has it.
const BIAS: Bias = Bias { units: 2.0, slope: 1.5 };

/// Vogel's spiral, as `gpu/shader` writes it out, in texels.
const DISC: [[f32; 2]; 16] = scaled([
    [0.1768, 0.0],
    [-0.2258, 0.2068],
    [0.0346, -0.3938],
    [0.2846, 0.3712],
    [-0.5222, -0.0924],
    [0.4947, -0.3147],
    [-0.1655, 0.6155],
    [-0.3156, -0.6076],
    [0.6846, 0.25],
    [-0.7123, 0.294],
    [0.3434, -0.7337],
    [0.2537, 0.8089],
    [-0.7647, -0.4432],
    [0.8971, -0.1972],
    [-0.5475, 0.7788],
    [-0.1265, -0.9761],
]);

/// The middle of the disc, and its last ones, which lie around it.
const NINE: [[f32; 2]; 9] =
    [[0.0, 0.0], DISC[8], DISC[9], DISC[10], DISC[11], DISC[12], DISC[13], DISC[14], DISC[15]];

const fn scaled(mut points: [[f32; 2]; 16]) -> [[f32; 2]; 16] {
    let mut i = 0;
    while i < 16 {
        points[i] = [3.6 * points[i][0], 3.6 * points[i][1]];
        i += 1;
    }
    points
}

/// One cell's map.
#[derive(Debug, Default)]
pub(super) struct ShadowMap {
    size: usize,
    /// Rows of `size` texels and a margin.
    depth: Vec<f32>,
}

impl ShadowMap {
    /// The tiles of a map of `size` texels a side: its bands.
    pub(super) fn grid(size: u32) -> Grid {
        Grid { low: [0; 2], high: [size as i32 - 1; 2], bits: [30, BAND_BITS] }
    }

    /// Draws `figures`, each with its triangles.
    pub(super) fn draw(&mut self, with: Instructions, size: u32, figures: &[(&Projected, &[[u32; 3]])]) {
        self.size = size as usize;
        let (stride, grid) = (self.size + MARGIN, Self::grid(size));
        self.depth.resize(stride * self.size, 1.0);
        self.depth.par_chunks_mut(stride << BAND_BITS).enumerate().for_each(|(band, depth)| {
            depth.fill(1.0);
            let first = (band << BAND_BITS) as i32;
            let mut target = Target {
                depth,
                seen: &mut [],
                stride,
                origin: [0, first],
                low: [0, first],
                high: [grid.high[0], grid.high[1].min(first + (1 << BAND_BITS) - 1)],
            };
            let mut farthest = Farthest::default();
            for front in [true, false] {
                for (projected, triangles) in figures {
                    for chunk in projected.chunks.iter().filter(|chunk| !chunk.tile(band, front).is_empty()) {
                        let (triangles, corners, farthest) = (*triangles, &projected.corners, &farthest);
                        let (tile, base, bias) = (band, 0, BIAS);
                        let list = Triangles { chunk, tile, front, triangles, corners, base, bias, farthest };
                        with.run(Fill::<1, false>(&mut target, list));
                    }
                }
                if front {
                    farthest.look::<1>(&target, size as usize);
                }
            }
        });
    }

    /// Where a texel is, or the nearest one in the map.
    #[inline(always)]
    fn texel(&self, x: i32, y: i32) -> i32 {
        let last = self.size as i32 - 1;
        y.max(0).min(last) * (last + 1 + MARGIN as i32) + x.max(0).min(last)
    }

    #[inline(always)]
    fn lit_texel(&self, at: i32, depth: f32) -> bool {
        self.depth.get(at as usize).is_some_and(|nearest| depth <= *nearest)
    }

    /// How many of [`NINE`] texels around each of `N` places, texels and depth, the key light reaches.
    #[inline(always)]
    fn lit_of_nine<const N: usize>(&self, [x, y, depth]: &[[f32; N]; 3]) -> [i32; N] {
        let mut lit = [0; N];
        for [dx, dy] in NINE {
            // Places and comparisons are vectors; what lies between them is fetched one by one.
            let (last, stride) = (self.size as f32 - 1.0, (self.size + MARGIN) as i32);
            let mut at = [0; N];
            for i in 0..N {
                let (x, y) = (clamp(x[i] + dx, 0.0, last), clamp(y[i] + dy, 0.0, last));
                at[i] = whole(y) * stride + whole(x);
            }
            let mut nearest = [f32::NEG_INFINITY; N];
            for (nearest, at) in nearest.iter_mut().zip(at) {
                *nearest = self.depth.get(at as usize).copied().unwrap_or(f32::NEG_INFINITY);
            }
            for i in 0..N {
                lit[i] += i32::from(depth[i] <= nearest[i]);
            }
        }
        lit
    }

    /// Share of a disc around `at`, texels and depth, that the key light reaches.
    #[inline(always)]
    pub(super) fn lit_disc(&self, at: [f32; 3]) -> f32 {
        let [lit] = self.lit_of_nine(&each(at, |c| [c]));
        self.share(lit, at)
    }

    /// The share of a disc that is lit, from how many of its nine texels are: where they agree, so does nearly always what lies
    /// between them.
    #[inline(always)]
    fn share(&self, lit: i32, [x, y, depth]: [f32; 3]) -> f32 {
        match lit {
            0 => 0.0,
            9 => 1.0,
            _ => {
                let mut sum = 0.0;
                for [dx, dy] in DISC {
                    sum += self.lit_at([x + dx, y + dy], depth);
                }
                sum / DISC.len() as f32
            }
        }
    }

    /// As a comparing sampler filters: the share of the four texels around.
    #[inline(always)]
    fn lit_at(&self, [x, y]: [f32; 2], depth: f32) -> f32 {
        let (x, y) = (x - 0.5, y - 0.5);
        let (left, top) = (x.floor(), y.floor());
        let (fx, fy) = (x - left, y - top);
        let (left, top) = (left as i32, top as i32);
        let lit = |dx: i32, dy: i32| {
            if self.lit_texel(self.texel(left + dx, top + dy), depth) { 1.0 } else { 0.0 }
        };
        let (above, below) =
            (lit(0, 0) * (1.0 - fx) + lit(1, 0) * fx, lit(0, 1) * (1.0 - fx) + lit(1, 1) * fx);
        above * (1.0 - fy) + below * fy
    }
}

/// Asks a map for the key light's share of the places in a batch, where it matters.
pub(super) struct AskKey<'a, 'b> {
    pub(super) map: &'a ShadowMap,
    /// How dark shadows are.
    pub(super) strength: f32,
    pub(super) batch: &'b mut Batch,
}

impl Kernel for AskKey<'_, '_> {
    #[inline(always)]
    fn run(self) {
        let Self { map, strength, batch } = self;
        if !batch.keyed[..batch.count].iter().any(|keyed| *keyed > 0.0) {
            return;
        }
        let lit = map.lit_of_nine(&batch.map);
        for i in 0..batch.count.min(PLACES) {
            if batch.keyed[i] > 0.0 {
                let at = [batch.map[0][i], batch.map[1][i], batch.map[2][i]];
                batch.key[i] = mix(1.0, map.share(lit[i], at), strength);
            }
        }
    }
}
