//! The finish of a picture on the processor: the passes of `finish.wgsl`, on rows.

use rayon::prelude::*;

use super::curves::{clamp, max, min, mix, packed, smoothstep, unpacked};
use super::instructions::{Instructions, Kernel};
use crate::Finish;
use crate::finish::{FinishUniform, SPREAD, step};

/// Buffers that are kept from picture to picture.
#[derive(Debug, Default)]
pub(super) struct Finishing {
    near: Small,
    far: Small,
    half: Vec<[f32; 3]>,
    /// `near` as wide as the picture: for each of its rows, the pixels of each channel, whole blocks of them.
    wide: Vec<f32>,
    /// Which columns of the picture before are seen in each of this one, and how near to the second.
    columns: Vec<(usize, usize, f32)>,
    /// The picture before, where it shows on, with its size.
    last: Vec<u8>,
    before: Option<([u32; 2], f64)>,
}

/// A small picture of light.
#[derive(Debug, Default)]
struct Small {
    width: usize,
    height: usize,
    pixels: Vec<[f32; 3]>,
}

impl Finishing {
    /// A picture had no finish: the next one has no trail of those before it.
    pub(super) fn forget(&mut self) {
        self.before = None;
    }

    /// Lays a finish for a moment over a picture of this size.
    pub(super) fn lay(
        &mut self,
        with: Instructions,
        (finish, at_secs): (&Finish, f64),
        size: [u32; 2],
        pixels: &mut [u8],
    ) {
        let before_secs = self.before.filter(|(of, _)| *of == size).map(|(_, secs)| secs);
        let uniform = finish.uniform(size, at_secs, before_secs);
        let [width, height] = size.map(|side| side as usize);
        if finish.bloom > 0.0 {
            self.near.brighten(&uniform, pixels, [width, height]);
            self.near.spread(&mut self.half);
            self.far.shrink(&self.near);
            self.far.spread(&mut self.half);
            self.near.add(&self.far);
            self.near.widen([uniform.step as usize, width], &mut self.wide);
        }
        let trail = (uniform.trail[0] > 0.0).then_some(&self.last[..]);
        let light = (finish.bloom > 0.0).then_some((&self.wide[..], self.near.height));
        let shrink = uniform.trail[1];
        self.columns.clear();
        self.columns
            .extend((0..width).map(|x| neighbors(grown(x as f32 + 0.5, width as f32, shrink), width)));
        let columns = &self.columns;
        pixels.par_chunks_mut(4 * width).enumerate().for_each_init(
            Beside::default,
            |beside: &mut Beside, (y, pixels)| {
                let light =
                    light.map(|(wide, rows)| Light::new(wide, rows, (y as f32 + 0.5) / uniform.step as f32));
                beside.trail.clear();
                if let Some(last) = trail {
                    beside.trail(last, y, columns, &uniform);
                }
                with.run(Row { uniform: &uniform, y, pixels, light, trail: &beside.trail });
            },
        );
        self.before = (finish.trail_secs > 0.0).then_some((size, at_secs));
        if self.before.is_some() {
            self.last.clear();
            self.last.extend_from_slice(pixels);
        }
    }
}

impl Small {
    fn resize(&mut self, width: usize, height: usize) {
        (self.width, self.height) = (width, height);
        self.pixels.resize(width * height, [0.0; 3]);
    }

    /// The light above the threshold in each square of a picture.
    fn brighten(&mut self, finish: &FinishUniform, picture: &[u8], [width, height]: [usize; 2]) {
        let (step, from) = (step(height as u32) as usize, finish.bloom[1]);
        self.resize(width.div_ceil(step), height.div_ceil(step));
        // Of eight bits: what each value gives where it is the brightest of three, and its square.
        let squares: [f32; 256] = std::array::from_fn(|i| (i as f32 / 255.0).powi(2));
        let shares: [f32; 256] = std::array::from_fn(|i| (i as f32 / 255.0 - from).max(0.0) / (1.0 - from));
        self.pixels.par_chunks_mut(self.width).enumerate().for_each(|(row, small)| {
            let rows = step * row..(step * (row + 1)).min(height);
            small.fill([0.0; 3]);
            for y in rows.clone() {
                let line = picture[4 * width * y..4 * width * (y + 1)].as_chunks::<4>().0;
                for (sum, square) in small.iter_mut().zip(line.chunks(step)) {
                    for [r, g, b, _] in square {
                        let share = shares[usize::from(*r.max(g).max(b))];
                        if share > 0.0 {
                            for (sum, c) in sum.iter_mut().zip([r, g, b]) {
                                *sum += squares[usize::from(*c)] * share;
                            }
                        }
                    }
                }
            }
            for (i, sum) in small.iter_mut().enumerate() {
                let columns = (step * (i + 1)).min(width) - step * i;
                *sum = sum.map(|c| c / (columns * rows.len()) as f32);
            }
        });
    }

    /// The mean of each 4 × 4 pixels.
    fn shrink(&mut self, of: &Self) {
        self.resize(of.width.div_ceil(4), of.height.div_ceil(4));
        self.pixels.par_chunks_mut(self.width).enumerate().for_each(|(row, small)| {
            let rows = 4 * row..(4 * row + 4).min(of.height);
            for (i, pixel) in small.iter_mut().enumerate() {
                let columns = 4 * i..(4 * i + 4).min(of.width);
                let mut sum = [0.0; 3];
                for y in rows.clone() {
                    for c in &of.pixels[of.width * y..][columns.clone()] {
                        sum = add(sum, *c, 1.0);
                    }
                }
                *pixel = sum.map(|c| c / (columns.len() * rows.len()) as f32);
            }
        });
    }

    /// Spreads light across, then down.
    fn spread(&mut self, half: &mut Vec<[f32; 3]>) {
        let (width, height) = (self.width, self.height);
        half.resize(width * height, [0.0; 3]);
        let from = &self.pixels;
        half.par_chunks_mut(width).zip(from.par_chunks(width)).for_each(|(to, from)| {
            for (x, to) in to.iter_mut().enumerate() {
                *to = from[x].map(|c| c * SPREAD[0]);
                for (i, weight) in SPREAD.iter().enumerate().skip(1) {
                    let both = add(from[x.saturating_sub(i)], from[(x + i).min(width - 1)], 1.0);
                    *to = add(*to, both, *weight);
                }
            }
        });
        let from = &half[..];
        self.pixels.par_chunks_mut(width).enumerate().for_each(|(y, to)| {
            let row = |y: usize| &from[width * y..width * (y + 1)];
            for (to, from) in to.iter_mut().zip(row(y)) {
                *to = from.map(|c| c * SPREAD[0]);
            }
            for (i, weight) in SPREAD.iter().enumerate().skip(1) {
                let (above, below) = (row(y.saturating_sub(i)), row((y + i).min(height - 1)));
                for ((to, above), below) in to.iter_mut().zip(above).zip(below) {
                    *to = add(*to, add(*above, *below, 1.0), *weight);
                }
            }
        });
    }

    /// Adds a picture of a quarter of the size.
    fn add(&mut self, far: &Self) {
        self.pixels.par_chunks_mut(self.width).enumerate().for_each_init(Vec::new, |lit, (y, pixels)| {
            lit.clear();
            far.row(0.25 * (y as f32 + 0.5), lit);
            for (x, pixel) in pixels.iter_mut().enumerate() {
                *pixel = add(*pixel, between(lit, 0.25 * (x as f32 + 0.5)), 1.0);
            }
        });
    }

    /// Makes it as wide as a picture, where its pixels are `step` wide.
    fn widen(&self, [step, width]: [usize; 2], wide: &mut Vec<f32>) {
        let padded = width.next_multiple_of(BLOCK);
        wide.resize(3 * padded * self.height, 0.0);
        let last = self.width - 1;
        wide.par_chunks_mut(3 * padded).zip(self.pixels.par_chunks(self.width)).for_each(|(wide, row)| {
            for gap in 0..=self.width {
                let (left, right) = (row[gap.saturating_sub(1)], row[gap.min(last)]);
                let first = (step * gap + step / 2).saturating_sub(step).min(width);
                let end = (step * gap + step / 2).min(width);
                // From the middle of the left one.
                let from = (first as f32 + 0.5) / step as f32 + 0.5 - gap as f32;
                for (k, plane) in wide.chunks_mut(padded).enumerate() {
                    let slope = (right[k] - left[k]) / step as f32;
                    let at_first = left[k] + (right[k] - left[k]) * from;
                    for (i, light) in plane[first..end].iter_mut().enumerate() {
                        *light = at_first + slope * i as f32;
                    }
                }
            }
        });
    }

    /// The row at this height, between two.
    fn row(&self, y: f32, row: &mut Vec<[f32; 3]>) {
        let (above, below, share) = neighbors(y, self.height);
        let at = |y: usize| self.pixels[self.width * y..self.width * (y + 1)].iter();
        row.extend(at(above).zip(at(below)).map(|(a, b)| blend(*a, *b, share)));
    }
}

#[inline(always)]
fn add(a: [f32; 3], b: [f32; 3], weight: f32) -> [f32; 3] {
    [a[0] + b[0] * weight, a[1] + b[1] * weight, a[2] + b[2] * weight]
}

#[inline(always)]
fn blend(a: [f32; 3], b: [f32; 3], share: f32) -> [f32; 3] {
    [mix(a[0], b[0], share), mix(a[1], b[1], share), mix(a[2], b[2], share)]
}

/// The two of `count` pixels around a place, and how near it is to the second.
#[inline(always)]
pub(super) fn neighbors(at: f32, count: usize) -> (usize, usize, f32) {
    let last = count as f32 - 1.0;
    let at = clamp(at - 0.5, 0.0, last);
    let first = at as usize;
    (first, (first + 1).min(count - 1), at - first as f32)
}

#[inline(always)]
fn between(row: &[[f32; 3]], at: f32) -> [f32; 3] {
    let (left, right, share) = neighbors(at, row.len());
    blend(row[left], row[right], share)
}

/// Pixels that are computed together: enough that loops over them become vectors, and few enough for the first cache.
const BLOCK: usize = 128;

type Block = [f32; BLOCK];

/// Light that spreads on a row of the picture: between two rows of [`Finishing::wide`].
struct Light<'a> {
    above: &'a [f32],
    below: &'a [f32],
    share: f32,
}

impl<'a> Light<'a> {
    /// At this height of `rows` rows.
    fn new(wide: &'a [f32], rows: usize, at: f32) -> Self {
        let (above, below, share) = neighbors(at, rows);
        let length = wide.len() / rows;
        let row = |y: usize| &wide[length * y..length * (y + 1)];
        Self { above: row(above), below: row(below), share }
    }

    /// A block of channel `k`, from `x` on, above and below.
    #[inline(always)]
    fn part(&self, k: usize, x: usize) -> Option<[&[f32; BLOCK]; 2]> {
        let at = self.above.len() / 3 * k + x;
        Some([self.above.get(at..)?.first_chunk()?, self.below.get(at..)?.first_chunk()?])
    }
}

/// The part of the last picture that is still visible in a row, and buffers to compute it.
#[derive(Default)]
struct Beside {
    between: Vec<f32>,
    /// Whole blocks, or nothing.
    trail: Vec<[u8; 4]>,
}

impl Beside {
    /// Takes what of the picture before shows on in row `y`; `columns` as [`Finishing::lay`] has them.
    fn trail(&mut self, last: &[u8], y: usize, columns: &[(usize, usize, f32)], uniform: &FinishUniform) {
        let [_, height] = uniform.size;
        let [left, shrink] = uniform.trail;
        let (above, below, share) = neighbors(grown(y as f32 + 0.5, height, shrink), height as usize);
        let row = |y: usize| &last[4 * columns.len() * y..4 * columns.len() * (y + 1)];
        let both = row(above).iter().zip(row(below));
        let kept =
            |(a, b): (&u8, &u8)| (mix(f32::from(*a), f32::from(*b), share) * left - uniform.fade) / 255.0;
        self.between.clear();
        self.between.extend(both.map(kept));
        let between = self.between.as_chunks::<4>().0;
        self.trail.extend(columns.iter().map(|(a, b, aside)| {
            let (a, b) = (between[*a], between[*b]);
            packed(std::array::from_fn(|k| max(mix(a[k], b[k], *aside), 0.0)))
        }));
        self.trail.resize(columns.len().next_multiple_of(BLOCK), [0; 4]);
    }
}

/// Where in the last picture to look up the coordinate `at`: the trail grows from the middle by 1 / `shrink`.
#[inline(always)]
fn grown(at: f32, size: f32, shrink: f32) -> f32 {
    (at / size - 0.5) * shrink * size + 0.5 * size
}

/// A row of the picture.
struct Row<'a> {
    uniform: &'a FinishUniform,
    y: usize,
    pixels: &'a mut [u8],
    light: Option<Light<'a>>,
    trail: &'a [[u8; 4]],
}

impl Kernel for Row<'_> {
    #[inline(always)]
    fn run(self) {
        let Self { uniform, y, pixels, light, trail } = self;
        for (block, pixels) in pixels.as_chunks_mut::<4>().0.chunks_mut(BLOCK).enumerate() {
            finish(uniform, [BLOCK * block, y], pixels, (light.as_ref(), trail));
        }
    }
}

/// Finishes at most a block of pixels, from `x` on of row `y`.
#[inline(always)]
fn finish(
    uniform: &FinishUniform,
    [x, y]: [usize; 2],
    pixels: &mut [[u8; 4]],
    (light, trail): (Option<&Light<'_>>, &[[u8; 4]]),
) {
    let [width, height] = uniform.size;
    let mut c = [[0.0; BLOCK]; 4];
    unpack(pixels, &mut c);
    for k in 0..3 {
        if let Some((light, [above, below])) = light.and_then(|light| Some((light, light.part(k, x)?))) {
            glow(&mut c[k], [above, below], (light.share, uniform.bloom[0]));
        }
    }
    if let Some(trail) = trail.get(x..).and_then(<[[u8; 4]]>::first_chunk::<BLOCK>) {
        let mut left = [[0.0; BLOCK]; 4];
        unpack(trail, &mut left);
        for k in 0..4 {
            for i in 0..BLOCK {
                c[k][i] = max(c[k][i], left[k][i]);
            }
        }
    }
    let (scale, down) = (1.44 / width, 0.72 * (2.0 * (y as f32 + 0.5) / height - 1.0));
    let mut dark = [0.0; BLOCK];
    for (i, dark) in dark.iter_mut().enumerate() {
        let across = scale * ((x + i) as i32 as f32 + 0.5) - 0.72;
        *dark = 1.0 - uniform.vignette * smoothstep(0.25, 1.05, across * across + down * down);
    }
    let mut noise = [0.0; BLOCK];
    if uniform.grain > 0.0 {
        for (i, noise) in noise.iter_mut().enumerate() {
            *noise = uniform.grain * chance((x + i) as u32, y as u32, uniform.moment) * c[3][i];
        }
    }
    let [r, g, b, a] = &c;
    for (i, pixel) in pixels.iter_mut().enumerate().take(BLOCK) {
        let seen = |c: &Block| clamp(c[i] * dark[i] + noise[i], 0.0, 1.0);
        let (r, g, b) = (seen(r), seen(g), seen(b));
        *pixel = packed([r, g, b, max(max(r, g), max(b, a[i]))]);
    }
}

#[inline(always)]
pub(super) fn unpack<const N: usize>(pixels: &[[u8; 4]], [r, g, b, a]: &mut [[f32; N]; 4]) {
    for (i, pixel) in pixels.iter().enumerate().take(N) {
        [r[i], g[i], b[i], a[i]] = unpacked(*pixel);
    }
}

/// Adds light between two rows of it.
#[inline(always)]
fn glow(c: &mut Block, [above, below]: [&Block; 2], (share, strength): (f32, f32)) {
    for i in 0..BLOCK {
        let light = mix(above[i], below[i], share);
        c[i] = min((c[i] * c[i] + strength * light).sqrt(), 1.0);
    }
}

/// A number in [−½, ½) for a pixel and a moment (O'Neill's PCG, 2014).
#[inline(always)]
fn chance(x: u32, y: u32, moment: u32) -> f32 {
    let seed = x
        .wrapping_mul(1_664_525)
        .wrapping_add(y.wrapping_mul(1_013_904_223))
        .wrapping_add(moment.wrapping_mul(69_069))
        .wrapping_mul(747_796_405)
        .wrapping_add(2_891_336_453);
    let word = ((seed >> ((seed >> 28) + 4)) ^ seed).wrapping_mul(277_803_737);
    let word = (word >> 22) ^ word;
    (word >> 8) as f32 / 16_777_216.0 - 0.5
}
