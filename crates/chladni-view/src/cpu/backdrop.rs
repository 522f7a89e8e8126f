//! The background of a cell, painted once and kept.

use std::sync::Arc;

use rayon::prelude::*;

use super::curves::{clamp, each, max, min, mix, packed, smoothstep};
use super::instructions::{Instructions, Kernel};
use super::shade::{to_srgb, wing};
use crate::Rect;
use crate::buffers::Pyramid;
use crate::uniforms::CellUniform;

/// The painted background of one cell, premultiplied.
#[derive(Debug, Default)]
pub(super) struct Backdrop {
    of: Option<Painted>,
    /// The picture that was laid, held so that no other can be taken for it.
    behind: Option<Arc<Pyramid>>,
    pixels: Vec<u8>,
}

/// All that a background depends on but a picture.
type Painted = (Rect, [[f32; 4]; 6], [f32; 2], [[f32; 4]; 4]);

impl Backdrop {
    /// Paints the cell's background, unless it is there.
    pub(super) fn paint(
        &mut self,
        with: Instructions,
        cell: &CellUniform,
        rect: Rect,
        behind: Option<&Arc<Pyramid>>,
    ) {
        let [x_axis, z_axis] = cell.floor_axes;
        let (center, corner, floor) = (cell.background_center, cell.background_corner, cell.floor);
        let [.., left, right] = cell.wings;
        let colors = [center, corner, floor, cell.floor_plane, x_axis, z_axis];
        let of = match behind {
            None => (rect, colors, [left, right], cell.projection),
            // A picture stays as it is, whatever light there is.
            Some(_) => (rect, [[center[3]; 4]; 6], [0.0; 2], [[0.0; 4]; 4]),
        };
        let is_same = match (behind, &self.behind) {
            (Some(picture), Some(laid)) => Arc::ptr_eq(picture, laid),
            (picture, laid) => picture.is_none() && laid.is_none(),
        };
        if is_same && self.of == Some(of) {
            return;
        }
        let (width, height) = (rect.width as usize, rect.height as usize);
        (self.of, self.behind) = (Some(of), behind.cloned());
        self.pixels.resize(4 * width * height, 0);
        let rows = self.pixels.par_chunks_mut(4 * width).enumerate();
        match behind {
            Some(picture) => rows.for_each(|(y, pixels)| pictured(cell, picture, y, pixels)),
            None => rows.for_each(|(y, pixels)| with.run(Row { cell, y, pixels })),
        }
    }

    /// Pixels from `x` on in row `y` of the cell.
    pub(super) fn row(&self, x: usize, y: usize) -> &[u8] {
        let width = self.of.map_or(0, |(rect, ..)| rect.width as usize);
        &self.pixels[4 * (y * width + x)..4 * (y + 1) * width]
    }
}

/// A row of a picture that fills the cell, as `pictured` of `gpu/shader`.
fn pictured(cell: &CellUniform, picture: &Pyramid, y: usize, pixels: &mut [u8]) {
    let [.., width, height] = cell.viewport;
    let ratio = width / (height * cell.output[1]);
    let scale = [0.5 * min(ratio, 1.0), 0.5 * min(1.0 / ratio, 1.0)];
    let (right, down) = ([2.0 * scale[0] / width, 0.0], [0.0, 2.0 * scale[1] / height]);
    let opacity = 255.0 * cell.background_center[3];
    for (x, pixel) in pixels.as_chunks_mut::<4>().0.iter_mut().enumerate() {
        let at = [2.0 * (x as f32 + 0.5) / width - 1.0, 2.0 * (y as f32 + 0.5) / height - 1.0];
        let light = picture.sample_within([0.5 + scale[0] * at[0], 0.5 + scale[1] * at[1]], right, down);
        for k in 0..3 {
            pixel[k] = (clamp(to_srgb(light[k]), 0.0, 1.0) * opacity + 0.5) as u8;
        }
        pixel[3] = (opacity + 0.5) as u8;
    }
}

struct Row<'a> {
    cell: &'a CellUniform,
    y: usize,
    pixels: &'a mut [u8],
}

impl Kernel for Row<'_> {
    #[inline(always)]
    fn run(self) {
        let [left, top, width, height] = self.cell.viewport;
        let opacity = clamp(self.cell.background_center[3], 0.0, 1.0);
        let (center, corner) = (self.cell.background_center, self.cell.background_corner);
        let [.., strength_left, strength_right] = self.cell.wings;
        let at_y = 1.0 - 2.0 * (self.y as f32 + 0.5) / height;
        let (y, gradient) = (at_y - 0.1, corner[3]);
        let row = top as u32 + self.y as u32;
        let floor = self.cell.floor_plane[..3].iter().any(|axis| *axis != 0.0);
        for (i, pixel) in self.pixels.as_chunks_mut::<4>().0.iter_mut().enumerate() {
            let x = 2.0 * (i as f32 + 0.5) / width - 1.0;
            let r = (x * x + y * y).sqrt();
            let (round, halo) = (smoothstep(0.1, 1.5, r), smoothstep(0.0, 1.1, r));
            let share = if gradient > 1.5 { halo } else { round };
            let share = if (gradient - 1.0).abs() < 0.5 { 0.5 + 0.5 * at_y } else { share };
            let share = 1.0 - (1.0 - share) * wing(strength_left, strength_right, x);
            let mut behind = [0.0; 3];
            for k in 0..3 {
                behind[k] = mix(center[k], corner[k], share);
            }
            if floor {
                behind = floored(self.cell, behind, [x, at_y]);
            }
            // An ordered dither hides the steps of eight bits, and unlike noise it compresses well.
            let (px, py) = ((left as u32 + i as u32) & 1, row & 1);
            let dither = ((2 * (px ^ py) + py) as f32 - 1.5) / (4.0 * 255.0);
            let [r, g, b] = each(behind, |c| clamp(c + dither, 0.0, 1.0) * opacity);
            *pixel = packed([r, g, b, opacity]);
        }
    }
}

/// The floor over a background, as `floored` of `gpu/shader`.
#[inline(always)]
fn floored(cell: &CellUniform, behind: [f32; 3], [x, y]: [f32; 2]) -> [f32; 3] {
    let CellUniform { projection, floor, floor_plane, floor_axes, .. } = cell;
    let ray = [x / projection[0][0], y / projection[1][1], -1.0];
    let dot = |a: &[f32; 4], b: [f32; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let down = -dot(floor_plane, ray);
    let way = floor_plane[3] / max(down, 1e-6);
    let p = each(ray, |c| c * way);
    let x = dot(&floor_axes[0], p) + floor_axes[0][3];
    let z = dot(&floor_axes[1], p) + floor_axes[1][3];
    let from = min(x * x + z * z, 1e6);
    let shadow = 1.0 / (1.0 + 4.0 * from * from);
    let there = if down > 1e-6 { 1.0 / (1.0 + 0.06 * from) } else { 0.0 };
    let mut all = [0.0; 3];
    for k in 0..3 {
        all[k] = mix(behind[k], floor[k] * (1.0 - floor[3] * shadow), there);
    }
    all
}
