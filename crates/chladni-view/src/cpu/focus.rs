//! Depth of field on the processor: the passes of `focus.wgsl`, on rows.

mod compose;
mod gather;

use rayon::prelude::*;

use self::compose::{Compose, Widen};
use self::gather::{Even, Gather};
use super::curves::{max, min};
use super::finishing::neighbors;
use super::instructions::Instructions;
use crate::focus::{Spread, most};

/// Buffers that are kept from picture to picture.
#[derive(Debug, Default)]
pub(super) struct Focusing {
    /// The radius of each pixel's circle of light, in pixels of the small picture; below 0 before the focus.
    circles: Vec<f32>,
    small: Small,
    /// Light that has spread.
    spread: Vec<f32>,
    /// The same, evened out.
    even: Vec<f32>,
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

/// Channels of a pixel of the small picture after spreading: four colors of all in or behind the focus; from [`NEAR`]
/// on four of all before the focus, times their cover; and that cover.
const LAYERS: usize = 9;
const NEAR: usize = 4;
const COVER: usize = 8;

/// Pixels that are computed together.
const BLOCK: usize = 64;

impl Focusing {
    /// The circles of a picture of this size, to be written.
    pub(super) fn circles(&mut self, [width, height]: [u32; 2]) -> &mut [f32] {
        self.circles.resize(width as usize * height as usize, 0.0);
        &mut self.circles
    }

    /// Spreads light that is out of focus, by the circles that were written.
    pub(super) fn lay(&mut self, with: Instructions, size: [u32; 2], pixels: &mut [u8]) {
        let spread = Spread::new(size);
        let [width, height] = size.map(|side| side as usize);
        let step = spread.step as usize;
        self.small.shrink(step, most(size[1]), (pixels, &self.circles), [width, height]);
        let small = &self.small;
        let padded = small.width.next_multiple_of(BLOCK);
        // With a pixel more on either side.
        let margined = LAYERS * (padded + 2);
        self.spread.resize(margined * small.height, 0.0);
        let rows = self.spread.par_chunks_mut(margined).enumerate();
        rows.for_each(|(y, to)| with.run(Gather { small, spread: &spread, y, to }));
        let row = LAYERS * padded;
        self.even.resize(row * small.height, 0.0);
        let rows = self.even.par_chunks_mut(row).enumerate();
        rows.for_each(|(y, to)| {
            let around = [y.saturating_sub(1), y, (y + 1).min(small.height - 1)];
            let from = around.map(|y| &self.spread[margined * y..margined * (y + 1)]);
            with.run(Even { small, from, y, to });
        });
        let (even, circles) = (&self.even, &self.circles);
        let rows = pixels.par_chunks_mut(4 * width).zip(circles.par_chunks(width)).enumerate();
        rows.for_each_init(
            Default::default,
            |(between, wide): &mut (Vec<_>, Vec<_>), (y, (pixels, circles))| {
                let (above, below, share) = neighbors((y as f32 + 0.5) / step as f32, small.height);
                let part = |y: usize| &even[row * y..row * (y + 1)];
                let (above, below, small) = (part(above), part(below), small.width);
                // Whole squares, and whole blocks.
                wide.resize(LAYERS * (step * small).next_multiple_of(BLOCK), 0.0);
                with.run(Widen { above, below, share, step, small, between, wide });
                with.run(Compose { y, pixels, circles, wide });
            },
        );
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

    /// Each square of a picture as one pixel: the circle of the nearest thing in it, and the color of all pixels with
    /// such a circle.
    fn shrink(
        &mut self,
        step: usize,
        most: f32,
        (picture, circles): (&[u8], &[f32]),
        [width, height]: [usize; 2],
    ) {
        (self.width, self.height) = (width.div_ceil(step), height.div_ceil(step));
        // Taps are rounded.
        self.rim = (most.ceil() as usize).max(2) + 1;
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
                let circle = each.clone().fold(f32::INFINITY, |nearest, i| min(circles[i], nearest));
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
