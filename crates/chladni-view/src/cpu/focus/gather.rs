//! Gathers the light that reaches each pixel of the small picture.

use super::super::curves::{clamp, max, min, mix, smoothstep};
use super::super::instructions::Kernel;
use super::{BLOCK, CIRCLE, COVER, LAYERS, NEAR, Small};
use crate::focus::{CONTINUED, LEAST, PIXEL, Spread};

/// Gathers a row of the small picture from the circles around.
pub(super) struct Gather<'a> {
    pub(super) small: &'a Small,
    pub(super) spread: &'a Spread,
    pub(super) y: usize,
    pub(super) to: &'a mut [f32],
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
            // Weights of light from before the focus, and of all other light.
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
                    // A neighbor behind this pixel reaches as far as this pixel's own circle, and at least
                    // [`CONTINUED`] where the pixel is sharp. A neighbor before it reaches as far as the neighbor's
                    // circle.
                    let size = if there[i] > circle[i] { reach[i] } else { there[i].abs() };
                    let share = clamp(size - away + 0.5, 0.0, 1.0) * area / max(size * size, 1.0);
                    nearer[i] = share * softness(-there[i]);
                    weight[i] = (share - nearer[i]) * soft(there[i], whole[i]);
                    before[i] += nearer[i];
                    behind[i] += weight[i];
                }
                for (sums, weights) in [(&mut near, &nearer), (&mut far, &weight)] {
                    // Most places are reached by one of both, or by none.
                    if is_nothing(weights) {
                        continue;
                    }
                    for (k, sum) in sums.iter_mut().enumerate() {
                        let Some(color) = part(k, at) else { return };
                        for i in 0..BLOCK {
                            sum[i] += color[i] * weights[i];
                        }
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

/// Whether all numbers are 0.
#[inline(always)]
fn is_nothing(numbers: &[f32; BLOCK]) -> bool {
    numbers.iter().fold(0, |all, number| all | number.to_bits()) == 0
}

/// The mean of the spread light of like softness in a row and around it, over the taps of two rows.
pub(super) struct Even<'a> {
    pub(super) small: &'a Small,
    /// The rows above, here and below.
    pub(super) from: [&'a [f32]; 3],
    pub(super) y: usize,
    pub(super) to: &'a mut [f32],
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

/// Weight, in the far layer, of color before the focus: it counts there only where it covers all else.
const HIDDEN: f32 = 1e-3;

/// How much of the sharp picture goes where the circle has this radius.
#[inline(always)]
pub(super) fn softness(radius: f32) -> f32 {
    smoothstep(LEAST, 1.0, radius)
}

/// Weights of three pixels in a row.
const TENT: [f32; 3] = [0.25, 0.5, 0.25];

/// The weight of a neighbor's color. Sharp neighbors weigh little, so that they do not spread onto soft ones, except
/// for a pixel before the focus, where `whole` is 1 and all colors weigh the same.
#[inline(always)]
fn soft(circle: f32, whole: f32) -> f32 {
    mix(min(circle.abs(), 1.0) + 1.0 / 64.0, 1.0, whole)
}
