//! The ring of a brush.

use super::super::batch::PLACES;
use super::super::curves::{max, smoothstep};
use super::super::fill::{Bias, FillOne, NONE};
use super::{Tile, over};

/// A brush's ring lies on a surface that is there already, as the graphics device's pipeline has it.
const RING: Bias = Bias { units: -2.0, slope: -1.0 };

impl Tile<'_, '_> {
    /// Lays a brush's ring, and a breath of its color, over a figure that is there.
    pub(super) fn ring(&mut self, figure: usize) {
        let (prepared, subject) = (&self.picture.prepared.figures[figure], &self.picture.subjects[figure]);
        let Some((triangles, reach)) = subject.ring else { return };
        let instructions = self.picture.instructions;
        for (id, triangle) in (0..).zip(triangles) {
            for corners in prepared.projected.pieces(&prepared.lens, subject.positions, *triangle) {
                let mut target = self.target();
                instructions.run(FillOne { target: &mut target, corners, id, bias: RING });
            }
        }
        let [r, g, b, radius] = prepared.uniform.brush;
        let lay = |tile: &mut Self| {
            tile.locate::<true>(figure, triangles);
            let batch = &mut *tile.scratch.batch;
            for i in 0..batch.count {
                let corners =
                    triangles[batch.triangle[i] as usize].map(|v| f32::from_ne_bytes(reach[v as usize]));
                let (here, slope) = batch.value_and_slope(i, corners);
                let ring = 1.0 - smoothstep(0.7, 1.7, (here - radius).abs() / max(slope, 1e-9));
                let inside = if here < radius { 0.13 } else { 0.0 };
                let alpha = max(ring, inside) * batch.share[i];
                over(&mut tile.pixels[batch.pixel[i] as usize..], [r * alpha, g * alpha, b * alpha, alpha]);
            }
            batch.count = 0;
        };
        let all = std::mem::take(&mut self.scratch.seen);
        for y in self.low[1]..=self.high[1] {
            for (x, seen) in self.row(&all, y) {
                let samples = seen.iter().filter(|id| **id != NONE).count();
                if let Some(triangle) = seen.iter().copied().find(|id| *id != NONE) {
                    if self.scratch.batch.count == PLACES {
                        lay(self);
                    }
                    self.put(triangle, [x, y], samples);
                }
            }
        }
        self.scratch.seen = all;
        lay(self);
    }
}
