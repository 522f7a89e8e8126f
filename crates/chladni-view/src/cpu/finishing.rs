//! The finish of a picture on the processor: the passes of `finish.wgsl`, on rows.

use rayon::prelude::*;

use super::curves::{clamp, max, mix, smoothstep};
use super::instructions::{Instructions, Kernel};
use crate::Finish;
use crate::finish::{FinishUniform, SPREAD, step};

/// What is kept from picture to picture.
#[derive(Debug, Default)]
pub(super) struct Finishing {
    near: Small,
    far: Small,
    half: Vec<[f32; 3]>,
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
        }
        let trail = (uniform.trail[0] > 0.0).then_some(&self.last[..]);
        let light = (finish.bloom > 0.0).then_some(&self.near);
        pixels.par_chunks_mut(4 * width).enumerate().for_each_init(Vec::new, |lit, (y, pixels)| {
            lit.clear();
            if let Some(light) = light {
                light.row((y as f32 + 0.5) / uniform.step as f32, lit);
            }
            with.run(Row { uniform: &uniform, y, pixels, lit, trail });
        });
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

    /// What is brighter than the threshold in each square of a picture.
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

    /// The row at this height, between two.
    fn row(&self, y: f32, row: &mut Vec<[f32; 3]>) {
        let (above, below, share) = neighbours(y, self.height);
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
fn neighbours(at: f32, count: usize) -> (usize, usize, f32) {
    let last = count as f32 - 1.0;
    let at = clamp(at - 0.5, 0.0, last);
    let first = at as usize;
    (first, (first + 1).min(count - 1), at - first as f32)
}

#[inline(always)]
fn between(row: &[[f32; 3]], at: f32) -> [f32; 3] {
    let (left, right, share) = neighbours(at, row.len());
    blend(row[left], row[right], share)
}

/// A row of the picture.
struct Row<'a> {
    uniform: &'a FinishUniform,
    y: usize,
    pixels: &'a mut [u8],
    /// Light that spreads here; none where none does.
    lit: &'a [[f32; 3]],
    /// The picture before.
    trail: Option<&'a [u8]>,
}

impl Kernel for Row<'_> {
    #[inline(always)]
    fn run(self) {
        let Self { uniform, y, pixels, lit, trail } = self;
        let [width, height] = uniform.size;
        let [left, shrink] = uniform.trail;
        let scale = 1.0 / uniform.step as f32;
        let count = width as usize;
        let seen = |at: f32, size: f32| (at / size - 0.5) * shrink * size + 0.5 * size;
        let down = 0.72 * (2.0 * (y as f32 + 0.5) / height - 1.0);
        let (above, below, share) = neighbours(seen(y as f32 + 0.5, height), height as usize);
        let rows = trail.map(|last| [above, below].map(|y| &last[4 * count * y..4 * count * (y + 1)]));
        for (x, pixel) in pixels.as_chunks_mut::<4>().0.iter_mut().enumerate() {
            let middle = x as f32 + 0.5;
            let mut c = pixel.map(|c| f32::from(c) / 255.0);
            if !lit.is_empty() {
                let light = between(lit, middle * scale);
                for k in 0..3 {
                    let sum = (c[k] * c[k] + uniform.bloom[0] * light[k]).sqrt();
                    c[k] = if sum < 1.0 { sum } else { 1.0 };
                }
            }
            if let Some([above, below]) = rows {
                let (a, b, aside) = neighbours(seen(middle, width), count);
                for k in 0..4 {
                    let at = |row: &[u8]| mix(f32::from(row[4 * a + k]), f32::from(row[4 * b + k]), aside);
                    c[k] = max(c[k], (mix(at(above), at(below), share) * left - 0.7) / 255.0);
                }
            }
            let across = 0.72 * (2.0 * middle / width - 1.0);
            let dark = 1.0 - uniform.vignette * smoothstep(0.25, 1.05, across * across + down * down);
            let noise = uniform.grain * chance(x as u32, y as u32, uniform.moment) * c[3];
            let mut most = c[3];
            for k in 0..3 {
                c[k] = clamp(c[k] * dark + noise, 0.0, 1.0);
                most = max(most, c[k]);
            }
            c[3] = most;
            *pixel = c.map(|c| (c * 255.0 + 0.5) as u8);
        }
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
