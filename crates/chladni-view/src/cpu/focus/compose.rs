//! Lays the spread light over the sharp picture.

use super::super::curves::{clamp, mix, packed};
use super::super::finishing::unpack;
use super::super::instructions::Kernel;
use super::gather::softness;
use super::{BLOCK, COVER, LAYERS, NEAR};

/// A row between two of the small picture, as wide as the picture.
pub(super) struct Widen<'a> {
    pub(super) above: &'a [f32],
    pub(super) below: &'a [f32],
    /// How near it is to the row below.
    pub(super) share: f32,
    /// Pixels in one of the small picture, and in a row of it.
    pub(super) step: usize,
    pub(super) small: usize,
    /// One plane of the row, with a pixel more on either side.
    pub(super) between: &'a mut Vec<f32>,
    pub(super) wide: &'a mut [f32],
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

/// Lays the spread light over a row of the picture.
pub(super) struct Compose<'a> {
    pub(super) y: usize,
    pub(super) pixels: &'a mut [u8],
    pub(super) circles: &'a [f32],
    pub(super) wide: &'a [f32],
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
