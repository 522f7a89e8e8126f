//! Depth of field on the processor: the passes of `focus.wgsl`, on rows.

use rayon::prelude::*;

use super::curves::{clamp, max, min, mix, packed, smoothstep, unpacked};
use super::finishing::neighbours;
use super::instructions::{Instructions, Kernel};
use crate::focus::{Spread, most};

/// What is kept from picture to picture.
#[derive(Debug, Default)]
pub(super) struct Focusing {
    /// Of each pixel the radius of its circle of light, pixels of the small picture; below 0 before the focus.
    circles: Vec<f32>,
    small: Small,
    /// Light that has spread: the means of squares of the four channels, and how much of it lies before what is there.
    spread: Vec<f32>,
}

/// Numbers of each pixel of the small picture: the squares of its four channels, and its circle.
const PLANES: usize = 5;
const CIRCLE: usize = 4;

/// A small picture with a rim of its own last pixels, plane by plane.
#[derive(Debug, Default)]
struct Small {
    width: usize,
    height: usize,
    rim: usize,
    numbers: Vec<f32>,
}

/// What spread at a pixel of the small picture: as [`PLANES`], with what lies before it in the place of the circle.
const COVER: usize = 4;

/// Pixels that are computed together.
const BLOCK: usize = 64;

impl Focusing {
    /// The circles of a picture of this size, to be written.
    pub(super) fn circles(&mut self, [width, height]: [u32; 2]) -> &mut [f32] {
        self.circles.resize(width as usize * height as usize, 0.0);
        &mut self.circles
    }

    /// Spreads what is out of focus, by the circles that were written.
    pub(super) fn lay(&mut self, with: Instructions, size: [u32; 2], pixels: &mut [u8]) {
        let spread = Spread::new(size);
        let [width, height] = size.map(|side| side as usize);
        let step = spread.step as usize;
        self.small.shrink(step, most(size[1]), (pixels, &self.circles), [width, height]);
        let small = &self.small;
        let row = PLANES * small.width.next_multiple_of(BLOCK);
        self.spread.resize(row * small.height, 0.0);
        let rows = self.spread.par_chunks_mut(row).enumerate();
        rows.for_each(|(y, to)| with.run(Gather { small, spread: &spread, y, to }));
        let (spread, circles) = (&self.spread, &self.circles);
        let rows = pixels.par_chunks_mut(4 * width).zip(circles.par_chunks(width)).enumerate();
        rows.for_each_init(Vec::new, |wide, (y, (pixels, circles))| {
            let (above, below, share) = neighbours((y as f32 + 0.5) / step as f32, small.height);
            let part = |y: usize| &spread[row * y..row * (y + 1)];
            widen([part(above), part(below)], share, [step, small.width, width], wide);
            with.run(Compose { y, pixels, circles, wide });
        });
    }
}

impl Small {
    fn stride(&self) -> usize {
        // Blocks may reach beyond the last pixel.
        self.width.next_multiple_of(BLOCK) + 2 * self.rim
    }

    fn plane(&self) -> usize {
        self.stride() * (self.height + 2 * self.rim)
    }

    /// Each square of a picture as one pixel: the circle of what lies before the focus, else the largest one, and the
    /// color of what has such a circle.
    fn shrink(
        &mut self,
        step: usize,
        most: f32,
        (picture, circles): (&[u8], &[f32]),
        [width, height]: [usize; 2],
    ) {
        (self.width, self.height) = (width.div_ceil(step), height.div_ceil(step));
        // Taps are rounded.
        self.rim = most.ceil() as usize + 1;
        let (stride, plane, rim) = (self.stride(), self.plane(), self.rim);
        self.numbers.resize(PLANES * plane, 0.0);
        let mut planes: Vec<_> =
            self.numbers.chunks_mut(plane).map(|plane| plane.chunks_mut(stride)).collect();
        let all = std::iter::from_fn(|| {
            let mut row = planes.iter_mut().map(Iterator::next);
            Some([row.next()??, row.next()??, row.next()??, row.next()??, row.next()??])
        });
        let rows: Vec<[&mut [f32]; PLANES]> = all.collect();
        let (small_width, small_height) = (self.width, self.height);
        let squares: [f32; 256] = std::array::from_fn(|i| (i as f32 / 255.0).powi(2));
        rows.into_par_iter().enumerate().for_each(|(y, mut to)| {
            let y = y.saturating_sub(rim).min(small_height - 1);
            let rows = step * y..(step * (y + 1)).min(height);
            for x in 0..small_width {
                let columns = step * x..(step * (x + 1)).min(width);
                let each = rows.clone().flat_map(|y| columns.clone().map(move |x| width * y + x));
                let (mut low, mut high) = (f32::INFINITY, f32::NEG_INFINITY);
                for i in each.clone() {
                    (low, high) = (min(circles[i], low), max(circles[i], high));
                }
                let circle = if low < -0.5 { low } else { high };
                let (mut sum, mut all) = ([0.0; 4], 0.0);
                for i in each {
                    let weight = max(1.0 - (circles[i] - circle).abs(), 0.0) + 1.0 / 256.0;
                    for (sum, c) in sum.iter_mut().zip(&picture[4 * i..4 * i + 4]) {
                        *sum += squares[usize::from(*c)] * weight;
                    }
                    all += weight;
                }
                let [r, g, b, a] = sum.map(|c| c / all);
                for (to, number) in to.iter_mut().zip([r, g, b, a, circle]) {
                    to[rim + x] = number;
                }
            }
            for to in &mut to {
                let [first, last] = [to[rim], to[rim + small_width - 1]];
                to[..rim].fill(first);
                to[rim + small_width..].fill(last);
            }
        });
    }
}

/// Gathers a row of the small picture from the circles around.
struct Gather<'a> {
    small: &'a Small,
    spread: &'a Spread,
    y: usize,
    to: &'a mut [f32],
}

impl Kernel for Gather<'_> {
    #[inline(always)]
    fn run(self) {
        let Self { small, spread, y, to } = self;
        let (stride, plane) = (small.stride(), small.plane());
        let padded = to.len() / PLANES;
        for x in (0..padded).step_by(BLOCK) {
            let middle = stride * (y + small.rim) + small.rim + x;
            let part = |k: usize, at: usize| {
                small.numbers.get(k * plane + at..).and_then(<[f32]>::first_chunk::<BLOCK>)
            };
            let Some(circle) = part(CIRCLE, middle) else { return };
            // Without this the middle of what is sharp would take part in what is not, beside it.
            let (mut own, mut softness, mut all) = ([0.0; BLOCK], [0.0; BLOCK], [0.0; BLOCK]);
            for i in 0..BLOCK {
                own[i] = circle[i].abs();
                softness[i] = if circle[i] < 0.0 { 0.0 } else { 1.0 };
                all[i] = MIDDLE * soft(circle[i], softness[i]) / max(own[i] * own[i], 1.0);
            }
            let (mut sums, mut cover) = ([[0.0; BLOCK]; 4], [0.0; BLOCK]);
            for (k, sum) in sums.iter_mut().enumerate() {
                let Some(color) = part(k, middle) else { return };
                for i in 0..BLOCK {
                    sum[i] = color[i] * all[i];
                }
            }
            for [dx, dy, far, area] in spread.taps {
                let at = (middle as isize + dy as isize * stride as isize + dx as isize) as usize;
                let Some(there) = part(CIRCLE, at) else { return };
                let mut weight = [0.0; BLOCK];
                for i in 0..BLOCK {
                    // What lies behind is seen as far as what lies before it is spread.
                    let size = if there[i] > circle[i] { own[i] } else { there[i].abs() };
                    let share = clamp(size - far + 0.5, 0.0, 1.0) * area / max(size * size, 1.0);
                    cover[i] += if there[i] < 0.0 { share } else { 0.0 };
                    weight[i] = share * soft(there[i], softness[i]);
                    all[i] += weight[i];
                }
                for (k, sum) in sums.iter_mut().enumerate() {
                    let Some(color) = part(k, at) else { return };
                    for i in 0..BLOCK {
                        sum[i] += color[i] * weight[i];
                    }
                }
            }
            for (k, sum) in sums.iter().enumerate() {
                for (to, (sum, all)) in to[k * padded + x..].iter_mut().zip(sum.iter().zip(&all)) {
                    *to = sum / all;
                }
            }
            for (to, cover) in to[COVER * padded + x..].iter_mut().zip(&cover) {
                *to = min(*cover, 1.0);
            }
        }
    }
}

/// The part of the disc that a pixel's own color stands for.
const MIDDLE: f32 = 0.25;

/// How much a color takes part: what is sharp is drawn as it is, and does not spread onto what is soft, unless it is seen
/// through something before the focus.
#[inline(always)]
fn soft(circle: f32, softness: f32) -> f32 {
    mix(1.0, min(circle.abs(), 1.0) + 1.0 / 64.0, softness)
}

/// A row between two of the small picture, as wide as the picture.
fn widen([above, below]: [&[f32]; 2], share: f32, [step, small, width]: [usize; 3], wide: &mut Vec<f32>) {
    let padded = width.next_multiple_of(BLOCK);
    wide.resize(PLANES * padded, 0.0);
    let row = above.len() / PLANES;
    for (k, wide) in wide.chunks_mut(padded).enumerate() {
        let (above, below) = (&above[row * k..row * k + small], &below[row * k..row * k + small]);
        let at = |x: usize| mix(above[x], below[x], share);
        let mut right = at(0);
        for gap in 0..=small {
            let left = right;
            right = at(gap.min(small - 1));
            let first = (step * gap + step / 2).saturating_sub(step).min(width);
            let end = (step * gap + step / 2).min(width);
            // From the middle of the left one.
            let from = (first as f32 + 0.5) / step as f32 + 0.5 - gap as f32;
            for (i, number) in wide[first..end].iter_mut().enumerate() {
                *number = mix(left, right, from + i as f32 / step as f32);
            }
        }
    }
}

/// Lays what has spread over a row of the picture.
struct Compose<'a> {
    y: usize,
    pixels: &'a mut [u8],
    circles: &'a [f32],
    wide: &'a [f32],
}

impl Kernel for Compose<'_> {
    #[inline(always)]
    fn run(self) {
        let Self { y, pixels, circles, wide } = self;
        let padded = wide.len() / PLANES;
        let blocks = pixels.as_chunks_mut::<4>().0.chunks_mut(BLOCK).zip(circles.chunks(BLOCK));
        for (block, (pixels, circles)) in blocks.enumerate() {
            let x = BLOCK * block;
            let part = |k: usize| wide.get(k * padded + x..).and_then(<[f32]>::first_chunk::<BLOCK>);
            let (Some(r), Some(g), Some(b), Some(a), Some(cover)) =
                (part(0), part(1), part(2), part(3), part(COVER))
            else {
                return;
            };
            for (i, (pixel, circle)) in pixels.iter_mut().zip(circles).enumerate().take(BLOCK) {
                let share = max(smoothstep(0.1, 1.0, circle.abs()), cover[i]);
                let (px, py) = ((x + i) as u32 & 1, y as u32 & 1);
                // The dither of the background was averaged away.
                let dither = ((2 * (px ^ py) + py) as i32 as f32 - 1.5) / (4.0 * 255.0) * share;
                let bare = unpacked(*pixel);
                let seen = |k: usize, light: f32, dither: f32| {
                    clamp(mix(bare[k], light.sqrt(), share) + dither, 0.0, 1.0)
                };
                *pixel = packed([
                    seen(0, r[i], dither),
                    seen(1, g[i], dither),
                    seen(2, b[i], dither),
                    seen(3, a[i], 0.0),
                ]);
            }
        }
    }
}
