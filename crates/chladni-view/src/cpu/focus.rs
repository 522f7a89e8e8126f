//! Depth of field on the processor: the passes of `focus.wgsl`, on rows.

use rayon::prelude::*;

use super::curves::{clamp, max, min, mix, packed, smoothstep};
use super::finishing::{neighbours, unpack};
use super::instructions::{Instructions, Kernel};
use crate::focus::{CONTINUED, LEAST, PIXEL, Spread, most};

/// What is kept from picture to picture.
#[derive(Debug, Default)]
pub(super) struct Focusing {
    /// Of each pixel the radius of its circle of light, pixels of the small picture; below 0 before the focus.
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

/// What spread at a pixel of the small picture: the four channels of what lies in the focus or behind it, of what lies
/// before it, by how much it covers, and that.
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

    /// Spreads what is out of focus, by the circles that were written.
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
                let (above, below, share) = neighbours((y as f32 + 0.5) / step as f32, small.height);
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

    /// Each square of a picture as one pixel: the circle of what is nearest, and the color of what has such a circle.
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
        let row = to.len() / LAYERS;
        for x in (0..row - 2).step_by(BLOCK) {
            let middle = stride * (y + small.rim) + small.rim + x;
            let part = |k: usize, at: usize| {
                small.numbers.get(k * plane + at..).and_then(<[f32]>::first_chunk::<BLOCK>)
            };
            let Some(circle) = part(CIRCLE, middle) else { return };
            let mut own = [0.0; BLOCK];
            // Whether the pixel is before the focus: then colors count for as much as they are.
            let (mut reach, mut whole) = (own, own);
            // What lies before the focus, and all else.
            let (mut before, mut behind) = (own, own);
            for i in 0..BLOCK {
                own[i] = circle[i].abs();
                whole[i] = softness(-circle[i]);
                let continued = max(own[i], CONTINUED * (1.0 - 2.0 * own[i]));
                reach[i] = mix(continued, own[i], whole[i]);
                let mine = PIXEL / max(own[i] * own[i], 1.0);
                before[i] = mine * whole[i];
                behind[i] = mine * (1.0 - whole[i]) * soft(circle[i], whole[i]);
            }
            let (mut near, mut far) = ([[0.0; BLOCK]; 4], [[0.0; BLOCK]; 4]);
            for (k, (near, far)) in near.iter_mut().zip(&mut far).enumerate() {
                let Some(color) = part(k, middle) else { return };
                for i in 0..BLOCK {
                    near[i] = color[i] * before[i];
                    far[i] = color[i] * behind[i];
                }
            }
            for [dx, dy, away, area] in spread.taps[y & 1] {
                let at = (middle as isize + dy as isize * stride as isize + dx as isize) as usize;
                let Some(there) = part(CIRCLE, at) else { return };
                let (mut nearer, mut weight) = ([0.0; BLOCK], [0.0; BLOCK]);
                for i in 0..BLOCK {
                    // What lies behind is seen as far as what lies before it is spread, and is continued where that is
                    // sharp.
                    let size = if there[i] > circle[i] { reach[i] } else { there[i].abs() };
                    let share = clamp(size - away + 0.5, 0.0, 1.0) * area / max(size * size, 1.0);
                    nearer[i] = share * softness(-there[i]);
                    weight[i] = (share - nearer[i]) * soft(there[i], whole[i]);
                    before[i] += nearer[i];
                    behind[i] += weight[i];
                }
                for (k, (near, far)) in near.iter_mut().zip(&mut far).enumerate() {
                    let Some(color) = part(k, at) else { return };
                    for i in 0..BLOCK {
                        near[i] += color[i] * nearer[i];
                        far[i] += color[i] * weight[i];
                    }
                }
            }
            let mut cover = [0.0; BLOCK];
            for i in 0..BLOCK {
                cover[i] = mix(min(before[i], 1.0), before[i] / (before[i] + behind[i]), whole[i]);
                // Behind what covers all is taken to be the same.
                behind[i] += before[i] * HIDDEN + 1e-9;
                before[i] = cover[i] / max(before[i], 1e-9);
            }
            for k in 0..NEAR {
                let at = k * row + 1 + x;
                let (Some(to), both) = (to[at..].first_chunk_mut::<BLOCK>(), (&near[k], &far[k])) else {
                    return;
                };
                for i in 0..BLOCK {
                    to[i] = (both.1[i] + both.0[i] * HIDDEN) / behind[i];
                }
            }
            for (k, near) in near.iter().enumerate() {
                let at = (NEAR + k) * row + 1 + x;
                let Some(to) = to[at..].first_chunk_mut::<BLOCK>() else { return };
                for i in 0..BLOCK {
                    to[i] = near[i] * before[i];
                }
            }
            if let Some(to) = to[COVER * row + 1 + x..].first_chunk_mut::<BLOCK>() {
                *to = cover;
            }
        }
        for to in to.chunks_mut(row) {
            (to[0], to[small.width + 1]) = (to[1], to[small.width]);
        }
    }
}

/// The mean of what has spread in a row and around it, of like softness: of the taps of two rows.
struct Even<'a> {
    small: &'a Small,
    /// The rows above, here and below.
    from: [&'a [f32]; 3],
    y: usize,
    to: &'a mut [f32],
}

impl Kernel for Even<'_> {
    #[inline(always)]
    fn run(self) {
        let Self { small, from, y, to } = self;
        let (stride, padded, row) = (small.stride(), to.len() / LAYERS, from[0].len() / LAYERS);
        let circles = &small.numbers[CIRCLE * small.plane() + stride * (y + small.rim - 1) + small.rim - 1..];
        for x in (0..padded).step_by(BLOCK) {
            let circle = |dx: usize, dy: usize| {
                circles.get(stride * dy + x + dx..).and_then(<[f32]>::first_chunk::<BLOCK>)
            };
            let part = |k: usize, dx: usize, dy: usize| {
                from[dy].get(row * k + x + dx..).and_then(<[f32]>::first_chunk::<BLOCK>)
            };
            let Some(middle) = circle(1, 1) else { return };
            let (mut sums, mut all) = ([[0.0; BLOCK]; LAYERS], [0.0; BLOCK]);
            for (dx, dy) in (0..9).map(|i| (i % 3, i / 3)) {
                let (Some(there), tent) = (circle(dx, dy), TENT[dx] * TENT[dy]) else { return };
                let mut weight = [tent; BLOCK];
                if (dx, dy) != (1, 1) {
                    for i in 0..BLOCK {
                        weight[i] = tent * clamp(min(middle[i].abs(), there[i].abs()) - 1.0, 0.0, 1.0);
                    }
                }
                for (k, sum) in sums.iter_mut().enumerate() {
                    let Some(from) = part(k, dx, dy) else { return };
                    for i in 0..BLOCK {
                        sum[i] += from[i] * if k < NEAR { weight[i] } else { tent };
                    }
                }
                for i in 0..BLOCK {
                    all[i] += weight[i];
                }
            }
            for (k, sum) in sums.iter().enumerate() {
                for (to, (sum, all)) in to[k * padded + x..].iter_mut().zip(sum.iter().zip(&all)) {
                    *to = if k < NEAR { sum / all } else { *sum };
                }
            }
        }
    }
}

/// What is before the focus counts for so little behind itself.
const HIDDEN: f32 = 1e-3;

/// How much of the sharp picture goes where the circle has this radius.
#[inline(always)]
fn softness(radius: f32) -> f32 {
    smoothstep(LEAST, 1.0, radius)
}

/// Weights of three pixels in a row.
const TENT: [f32; 3] = [0.25, 0.5, 0.25];

/// How much a color counts: what is sharp is drawn as it is, and does not spread onto what is soft, unless it is seen
/// through something before the focus, where `whole` is 1.
#[inline(always)]
fn soft(circle: f32, whole: f32) -> f32 {
    mix(min(circle.abs(), 1.0) + 1.0 / 64.0, 1.0, whole)
}

/// A row between two of the small picture, as wide as the picture.
struct Widen<'a> {
    above: &'a [f32],
    below: &'a [f32],
    /// How near it is to the row below.
    share: f32,
    /// Pixels in one of the small picture, and in a row of it.
    step: usize,
    small: usize,
    /// Of one plane of the row, with a pixel more on either side.
    between: &'a mut Vec<f32>,
    wide: &'a mut [f32],
}

impl Kernel for Widen<'_> {
    #[inline(always)]
    fn run(self) {
        let Self { above, below, share, step, small, between, wide } = self;
        let (row, padded) = (above.len() / LAYERS, wide.len() / LAYERS);
        between.resize(small + 2, 0.0);
        for (k, wide) in wide.chunks_mut(padded).enumerate() {
            let both = above[row * k..][..small].iter().zip(&below[row * k..][..small]);
            for (to, (above, below)) in between[1..].iter_mut().zip(both) {
                *to = mix(*above, *below, share);
            }
            (between[0], between[small + 1]) = (between[1], between[small]);
            // Loops of a known length become vectors.
            match step {
                1 => wide[..small].copy_from_slice(&between[1..=small]),
                2 => ramps(wide.as_chunks_mut::<2>().0, between),
                3 => ramps(wide.as_chunks_mut::<3>().0, between),
                4 => ramps(wide.as_chunks_mut::<4>().0, between),
                _ => {
                    for (to, around) in wide.chunks_mut(step).zip(between.windows(3)) {
                        for (i, to) in to.iter_mut().enumerate() {
                            *to = ramp(around, i, step);
                        }
                    }
                }
            }
        }
    }
}

#[inline(always)]
fn ramps<const STEP: usize>(wide: &mut [[f32; STEP]], between: &[f32]) {
    for (to, around) in wide.iter_mut().zip(between.windows(3)) {
        for (i, to) in to.iter_mut().enumerate() {
            *to = ramp(around, i, STEP);
        }
    }
}

/// Pixel `i` of the `step` that are the middle one of three small ones.
#[inline(always)]
fn ramp(around: &[f32], i: usize, step: usize) -> f32 {
    let at = (i as f32 + 0.5) / step as f32 - 0.5;
    if at < 0.0 { mix(around[0], around[1], 1.0 + at) } else { mix(around[1], around[2], at) }
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
        let padded = wide.len() / LAYERS;
        let blocks = pixels.as_chunks_mut::<4>().0.chunks_mut(BLOCK).zip(circles.chunks(BLOCK));
        for (block, (pixels, circles)) in blocks.enumerate() {
            let x = BLOCK * block;
            let part = |k: usize| wide.get(k * padded + x..).and_then(<[f32]>::first_chunk::<BLOCK>);
            let Some(cover) = part(COVER) else { return };
            let (mut soft, mut shares) = ([0.0; BLOCK], [0.0; BLOCK]);
            for (i, circle) in circles.iter().enumerate().take(BLOCK) {
                soft[i] = softness(circle.abs());
                shares[i] = 1.0 - (1.0 - soft[i]) * (1.0 - cover[i]);
            }
            let mut c = [[0.0; BLOCK]; 4];
            unpack(pixels, &mut c);
            for (k, c) in c.iter_mut().enumerate() {
                let (Some(far), Some(near)) = (part(k), part(NEAR + k)) else { return };
                for i in 0..BLOCK {
                    let light = mix(c[i] * c[i], far[i], soft[i]) * (1.0 - cover[i]) + near[i];
                    c[i] = light.sqrt();
                }
            }
            let [r, g, b, a] = &c;
            for (i, pixel) in pixels.iter_mut().enumerate().take(BLOCK) {
                let (px, py) = ((x + i) as u32 & 1, y as u32 & 1);
                // The dither of the background was averaged away.
                let dither = ((2 * (px ^ py) + py) as i32 as f32 - 1.5) / (4.0 * 255.0) * shares[i];
                let seen = |c: f32| clamp(c + dither, 0.0, 1.0);
                *pixel = packed([seen(r[i]), seen(g[i]), seen(b[i]), clamp(a[i], 0.0, 1.0)]);
            }
        }
    }
}
