//! Colors of the shaded places of a tile: values, palettes, skins, wires and nodal lines.

use super::super::batch::{Answered, PLACES};
use super::super::curves::{clamp, max, min, mix, smoothstep};
use super::super::subjects::Coat;
use super::Tile;
use crate::style::LINEAR;

impl Tile<'_, '_> {
    /// The bare colors of the batch, linear light.
    pub(super) fn colors(&mut self, figure: usize) {
        let (prepared, subject) = (&self.picture.prepared.figures[figure], &self.picture.subjects[figure]);
        let batch = &mut *self.scratch.batch;
        let [low, scale, map, _] = prepared.uniform.scale;
        let linear: &[f32; 256] = &LINEAR;
        batch.glow.fill(prepared.uniform.glow[0]);
        for i in 0..batch.count {
            let triangle = batch.triangle[i] as usize;
            let weights: [f32; 3] = std::array::from_fn(|k| batch.weights[k][i]);
            let color = match subject.coat {
                Coat::Material => {
                    let [r, g, b, _] = prepared.uniform.color;
                    [r, g, b]
                }
                Coat::Values(values) => {
                    let corners = subject.triangles[triangle].map(|v| f32::from_ne_bytes(values[v as usize]));
                    let value = (0..3).map(|k| weights[k] * corners[k]).sum::<f32>();
                    self.picture
                        .maps
                        .get(map as usize)
                        .map_or([0.0; 3], |map| map_color(map, (value - low) * scale))
                }
                Coat::Colors(colors) => {
                    let corners = subject.triangles[triangle].map(|v| colors[v as usize]);
                    let light = |k: usize, channel: usize| linear[usize::from(corners[k][channel])];
                    std::array::from_fn(|channel| (0..3).map(|k| weights[k] * light(k, channel)).sum())
                }
                Coat::Answer(..) => return self.answered(figure),
                Coat::Skin(image) => {
                    let uvs: [[f32; 2]; 3] = std::array::from_fn(|k| subject.uvs[3 * triangle + k]);
                    let at = |weights: [f32; 3]| {
                        // Images begin at the top, v at the bottom.
                        let sum = |axis: usize| (0..3).map(|k| weights[k] * uvs[k][axis]).sum::<f32>();
                        [sum(0), 1.0 - sum(1)]
                    };
                    let here = at(weights);
                    let from_here = |other: [f32; 3]| {
                        let other = at(other);
                        [other[0] - here[0], other[1] - here[1]]
                    };
                    let (right, below) = (&batch.right, &batch.below);
                    let right = from_here(std::array::from_fn(|k| right[k][i]));
                    let below = from_here(std::array::from_fn(|k| below[k][i]));
                    image.sample(here, right, below)
                }
            };
            for k in 0..3 {
                batch.color[k][i] = color[k];
            }
        }
    }

    /// The same by palette, which has much to compute.
    fn answered(&mut self, figure: usize) {
        let (prepared, subject) = (&self.picture.prepared.figures[figure], &self.picture.subjects[figure]);
        let batch = &mut *self.scratch.batch;
        let mut answers = [[0.0; PLACES]; 2];
        let phase = prepared.uniform.figured[2];
        for i in 0..batch.count {
            let corners = subject.triangles[batch.triangle[i] as usize];
            let weights: [f32; 3] = std::array::from_fn(|corner| batch.weights[corner][i]);
            let at = |of: &[[f32; 2]]| {
                let ([a, b, c], [u, v, w]) = (corners.map(|corner| &of[corner as usize]), weights);
                [u * a[0] + v * b[0] + w * c[0], u * a[1] + v * b[1] + w * c[1]]
            };
            let [mut place, own] = at(&prepared.answers);
            if phase != 0.0 {
                let [x, y] = at(&prepared.outward);
                place += phase * turns_of(x, y, PHASED * prepared.uniform.line[1]);
            }
            (answers[0][i], answers[1][i]) = (place, own);
        }
        let (figure, answers) = (&prepared.uniform, &answers);
        if let Some(map) = self.picture.maps.get(figure.scale[2] as usize) {
            self.picture.instructions.run(Answered { figure, map, answers, batch });
        }
    }

    /// Lays wires over the batch's colors.
    pub(super) fn wire(&mut self, color: &[f32; 4], width: f32) {
        let batch = &mut *self.scratch.batch;
        for i in 0..batch.count {
            let distance = |k: usize| {
                let here = batch.weights[k][i];
                let change = (batch.right[k][i] - here).abs() + (batch.below[k][i] - here).abs();
                here / max(change, 1e-9)
            };
            let near = min(distance(0), min(distance(1), distance(2)));
            let line = 1.0 - smoothstep(width - 0.5, width + 0.5, near);
            for k in 0..3 {
                batch.color[k][i] = mix(batch.color[k][i], color[k], color[3] * line);
            }
        }
    }

    /// Lays nodal lines over the batch's colors.
    pub(super) fn nodal_lines(&mut self, figure: usize) {
        let (prepared, subject) = (&self.picture.prepared.figures[figure], &self.picture.subjects[figure]);
        let [width, farthest, ..] = prepared.uniform.line;
        let width = max(width * self.cell.uniform.viewport[3], 0.6);
        let batch = &mut *self.scratch.batch;
        for i in 0..batch.count {
            let corners =
                subject.triangles[batch.triangle[i] as usize].map(|v| prepared.outward[v as usize][0]);
            let (here, slope) = batch.value_and_slope(i, corners);
            let near = 1.0 - smoothstep(width - 0.5, width + 0.5, here.abs() / max(slope, 1e-12));
            let stirred = smoothstep(STILL * farthest, STIRRED * farthest, slope);
            for k in 0..3 {
                let line = prepared.uniform.lines[3] * near * stirred;
                batch.color[k][i] = mix(batch.color[k][i], prepared.uniform.lines[k], line);
            }
        }
    }
}

/// Below this share of the farthest displacement, the phase fades out.
const PHASED: f32 = 0.04;
/// A displacement that changes by less than these shares of the farthest from pixel to pixel has no nodal lines, or
/// faint ones.
const STILL: f32 = 2e-5;
const STIRRED: f32 = 1e-4;

/// The angle of (x, y) in turns, by the way along a square; less of it where the square is smaller than `whole`.
fn turns_of(x: f32, y: f32, whole: f32) -> f32 {
    let size = x.abs() + y.abs();
    let p = y / max(size, 1e-12);
    0.25 * if x >= 0.0 { p } else { 2.0 - p } * min(size / whole, 1.0)
}

/// The color of `t` in [0, 1], between the map's 256.
fn map_color(map: &[[f32; 3]; 256], t: f32) -> [f32; 3] {
    let at = clamp(t, 0.0, 1.0) * 255.0;
    let left = (at as usize).min(254);
    let share = at - left as f32;
    std::array::from_fn(|k| mix(map[left][k], map[left + 1][k], share))
}
