//! What is behind the figures of a cell, painted once and kept.

use rayon::prelude::*;

use super::curves::{clamp, mix, smoothstep};
use super::instructions::{Instructions, Kernel};
use crate::uniforms::CellUniform;
use crate::{Background, Rect};

/// The painted background of one cell, premultiplied.
#[derive(Debug, Default)]
pub(super) struct Backdrop {
    of: Option<(Background, Rect)>,
    pixels: Vec<u8>,
}

impl Backdrop {
    /// Paints the cell's background, unless it is there.
    pub(super) fn paint(&mut self, with: Instructions, cell: &CellUniform, of: (Background, Rect)) {
        if self.of == Some(of) {
            return;
        }
        let (width, height) = (of.1.width as usize, of.1.height as usize);
        self.of = Some(of);
        self.pixels.resize(4 * width * height, 0);
        let rows = self.pixels.par_chunks_mut(4 * width).enumerate();
        rows.for_each(|(y, pixels)| with.run(Row { cell, y, pixels }));
    }

    /// Pixels from `x` on in row `y` of the cell.
    pub(super) fn row(&self, x: usize, y: usize) -> &[u8] {
        let width = self.of.map_or(0, |(_, rect)| rect.width as usize);
        &self.pixels[4 * (y * width + x)..4 * (y + 1) * width]
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
        let (center, corner) = (self.cell.background_center, self.cell.background_corner);
        let y = 1.0 - 2.0 * (self.y as f32 + 0.5) / height - 0.1;
        let row = top as u32 + self.y as u32;
        for (i, pixel) in self.pixels.as_chunks_mut::<4>().0.iter_mut().enumerate() {
            let x = 2.0 * (i as f32 + 0.5) / width - 1.0;
            let share = smoothstep(0.1, 1.5, (x * x + y * y).sqrt());
            // An ordered dither hides the steps of eight bits, and unlike noise it compresses well.
            let (px, py) = ((left as u32 + i as u32) & 1, row & 1);
            let dither = ((2 * (px ^ py) + py) as f32 - 1.5) / (4.0 * 255.0);
            for k in 0..3 {
                let c = mix(center[k], corner[k], share) + dither;
                pixel[k] = (clamp(c, 0.0, 1.0) * center[3] * 255.0 + 0.5) as u8;
            }
            pixel[3] = (center[3] * 255.0 + 0.5) as u8;
        }
    }
}
