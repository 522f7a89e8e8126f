//! From a figure's visible places to light in pixels, a batch at a time.

use std::ops::Range;

use super::super::batch::{Light, LightMap, PLACES, Pack, Place, Setting};
use super::super::curves::{clamp, max, min};
use super::super::fill::NONE;
use super::super::prepared::PreparedFigure;
use super::super::shadow::AskKey;
use super::super::subjects::Coat;
use super::{SAMPLES, Tile};

impl Tile<'_, '_> {
    /// Shades the visible places of a figure, whose triangles are `ids`.
    pub(super) fn surface(&mut self, figure: usize, ids: Range<u32>) {
        let (all, depth) = (std::mem::take(&mut self.scratch.seen), std::mem::take(&mut self.scratch.depth));
        for y in self.low[1]..=self.high[1] {
            let row = self.row(&all, y).zip(self.row(&depth, y));
            for ((x, seen), (_, depths)) in row.filter(|((_, seen), _)| **seen != [NONE; SAMPLES]) {
                // Most pixels show nothing but one triangle.
                if *seen == [seen[0]; SAMPLES] {
                    if ids.contains(&seen[0]) {
                        self.place(figure, seen[0] - ids.start, [x, y], SAMPLES);
                    }
                    continue;
                }
                let (mut low, mut high, mut count, mut first) = (f32::INFINITY, f32::NEG_INFINITY, 0, NONE);
                for (id, depth) in seen.iter().zip(depths) {
                    let mine = ids.contains(id);
                    low = if mine { min(low, *depth) } else { low };
                    high = if mine { max(high, *depth) } else { high };
                    count += usize::from(mine);
                    first = if mine && first == NONE { *id } else { first };
                }
                if count == 0 {
                    continue;
                }
                // One surface is shaded once, though its triangles are many; others each for itself.
                if high - low <= self.cell.one_surface {
                    self.place(figure, first - ids.start, [x, y], count);
                    continue;
                }
                for (s, id) in seen.iter().enumerate().filter(|(_, id)| ids.contains(*id)) {
                    if !seen[..s].contains(id) {
                        let count = seen.iter().filter(|other| *other == id).count();
                        self.place(figure, id - ids.start, [x, y], count);
                    }
                }
            }
        }
        (self.scratch.seen, self.scratch.depth) = (all, depth);
        self.shade(figure);
    }

    /// Puts a triangle's share of a pixel into the batch.
    fn place(&mut self, figure: usize, triangle: u32, [x, y]: [i32; 2], samples: usize) {
        if self.scratch.batch.count == PLACES {
            self.shade(figure);
        }
        self.put(triangle, [x, y], samples);
    }

    pub(super) fn put(&mut self, triangle: u32, [x, y]: [i32; 2], samples: usize) {
        let pixel = self.pixel(x, y) as u32;
        let batch = &mut *self.scratch.batch;
        let i = batch.count;
        batch.pixel[i] = pixel;
        batch.triangle[i] = triangle;
        batch.share[i] = samples as f32 / SAMPLES as f32;
        (batch.screen[0][i], batch.screen[1][i]) = (x as f32, y as f32);
        batch.count += 1;
    }

    /// Fetches the corners of the batch's triangles and finds the places on them.
    pub(super) fn locate<const EDGES: bool>(&mut self, figure: usize, triangles: &[[u32; 3]]) {
        let (prepared, subject) = (&self.picture.prepared.figures[figure], &self.picture.subjects[figure]);
        let setting = self.setting(prepared);
        let batch = &mut *self.scratch.batch;
        for i in 0..batch.count {
            for (corner, v) in triangles[batch.triangle[i] as usize].into_iter().enumerate() {
                let (p, n) = (subject.positions[v as usize], subject.normals[v as usize]);
                for k in 0..3 {
                    batch.positions[corner][k][i] = p[k];
                    batch.normals[corner][k][i] = n[k];
                }
            }
        }
        self.picture.instructions.run(Place::<EDGES>(&setting, batch));
    }

    fn setting<'s>(&self, figure: &'s PreparedFigure) -> Setting<'s>
    where
        Self: 's,
    {
        Setting {
            cell: &self.cell.uniform,
            figure: &figure.uniform,
            clip: figure.clip,
            view: figure.view,
            map: figure.map,
            shadows: self.cell.shadows,
        }
    }

    /// Shades the batch and empties it.
    fn shade(&mut self, figure: usize) {
        if self.scratch.batch.count == 0 {
            return;
        }
        let subject = &self.picture.subjects[figure];
        let prepared = &self.picture.prepared.figures[figure];
        let wired = prepared.uniform.wire_width[0] > 0.0;
        let lined = matches!(subject.coat, Coat::Answer(..)) && prepared.uniform.lines[3] > 0.0;
        if wired || lined || matches!(subject.coat, Coat::Skin(_)) {
            self.locate::<true>(figure, subject.triangles);
        } else {
            self.locate::<false>(figure, subject.triangles);
        }
        self.colors(figure);
        let setting = self.setting(prepared);
        let (instructions, cell) = (self.picture.instructions, self.cell);
        let batch = &mut *self.scratch.batch;
        if matches!(subject.coat, Coat::Values(_)) {
            instructions.run(LightMap(&setting, batch));
        } else {
            batch.key.fill(1.0);
            if cell.shadows {
                instructions.run(AskKey { map: &cell.map, strength: cell.uniform.shadow_map[0], batch });
            }
            if let Some(around) = self.picture.around {
                batch.surround(&cell.uniform, around, prepared.uniform.material[0]);
            }
            match (prepared.uniform.material[3] > 0.0, self.picture.around.is_some()) {
                (false, false) => instructions.run(Light::<false, false>(&setting, batch)),
                (true, false) => instructions.run(Light::<true, false>(&setting, batch)),
                (false, true) => instructions.run(Light::<false, true>(&setting, batch)),
                (true, true) => instructions.run(Light::<true, true>(&setting, batch)),
            }
        }
        if lined {
            self.nodal_lines(figure);
        }
        if wired {
            self.wire(&prepared.uniform.wire, prepared.uniform.wire_width[0]);
        }
        self.lay(clamp(subject.opacity, 0.0, 1.0));
    }

    /// Adds the batch's colors to their pixels.
    fn lay(&mut self, opacity: f32) {
        let batch = &mut *self.scratch.batch;
        self.picture.instructions.run(Pack { opacity, batch });
        for i in 0..batch.count {
            let at = batch.pixel[i] as usize;
            for (channel, c) in self.pixels[at..at + 4].iter_mut().zip(batch.packed[i]) {
                *channel = channel.saturating_add(c);
            }
        }
        batch.count = 0;
    }
}
