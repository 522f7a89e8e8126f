//! A tile of a picture: what is seen in it, layer after layer, and its colours.

mod circles;
mod colors;

use std::ops::Range;

use super::batch::{Batch, Light, LightMap, PLACES, Pack, Place, Setting};
use super::curves::{clamp, max, min, smoothstep};
use super::fill::{Bias, Farthest, Fill, FillOne, MARGIN, NONE, Target, Triangles};
use super::shadow::AskKey;
use super::stage::{Coat, Stage, StagedCell, StagedFigure, Subject};
use super::{Instructions, Pyramid};
use crate::focus::Circle;

/// Binary logarithms of a tile's width and height: its samples fit the first cache.
pub(super) const TILE_BITS: [u32; 2] = [5, 5];

const WIDTH: usize = 1 << TILE_BITS[0];
const HEIGHT: usize = 1 << TILE_BITS[1];
const STRIDE: usize = WIDTH + MARGIN;

/// Samples a pixel.
const SAMPLES: usize = 4;

/// A brush's ring lies on a surface that is there already, as the graphics device's pipeline has it.
const RING: Bias = Bias { units: -2.0, slope: -1.0 };

/// What one thread works with.
#[derive(Debug)]
pub(super) struct Scratch {
    depth: Vec<f32>,
    seen: Vec<u32>,
    farthest: Farthest,
    batch: Box<Batch>,
}

impl Scratch {
    pub(super) fn new() -> Self {
        let samples = SAMPLES * STRIDE * HEIGHT;
        Self {
            depth: vec![1.0; samples],
            seen: vec![NONE; samples],
            farthest: Farthest::default(),
            batch: Batch::new(),
        }
    }
}

/// What all tiles draw.
pub(super) struct Picture<'a> {
    pub(super) instructions: Instructions,
    pub(super) stage: &'a Stage,
    pub(super) subjects: &'a [Subject<'a>],
    pub(super) maps: &'a [[[f32; 3]; 256]],
    /// The panorama that shines on all figures.
    pub(super) around: Option<&'a Pyramid>,
    /// What each cell has in focus; none where everything is sharp.
    pub(super) circles: &'a [Circle],
    /// Pixels in a row of the canvas.
    pub(super) width: usize,
}

/// What is seen at once: its samples are found together and hide each other.
enum Layer {
    Opaque(Range<usize>),
    /// The fronts of a translucent figure, or its backs.
    Side(usize, bool),
    Ring(usize),
}

impl Picture<'_> {
    /// Draws the tiles of a row, and the circles of light of its pixels, where they are asked for.
    pub(super) fn draw_band(
        &self,
        row: i32,
        (pixels, circles): (&mut [u8], &mut [f32]),
        scratch: &mut Scratch,
    ) {
        pixels.fill(0);
        circles.fill(0.0);
        let (top, rows) = (row << TILE_BITS[1], pixels.len() / (4 * self.width));
        for column in 0..self.width.div_ceil(WIDTH) as i32 {
            let left = column << TILE_BITS[0];
            for (i, cell) in self.stage.cells.iter().enumerate() {
                let grid = &cell.grid;
                let low = [grid.low[0].max(left), grid.low[1].max(top)];
                let high =
                    [grid.high[0].min(left + WIDTH as i32 - 1), grid.high[1].min(top + rows as i32 - 1)];
                if low[0] <= high[0] && low[1] <= high[1] {
                    let tile = Tile {
                        picture: self,
                        cell,
                        index: grid.tile(column, row),
                        origin: [left, top],
                        low,
                        high,
                        pixels,
                        circles: self.circles.get(i).map(|circle| (*circle, &mut *circles)),
                        scratch,
                    };
                    tile.draw();
                }
            }
        }
    }
}

/// The part of a cell that lies in a tile.
struct Tile<'a, 'p> {
    picture: &'a Picture<'a>,
    cell: &'a StagedCell,
    /// Among those of the cell's grid.
    index: usize,
    /// First pixel of the tile.
    origin: [i32; 2],
    /// First and last pixels of the cell in it, inclusive.
    low: [i32; 2],
    high: [i32; 2],
    /// The canvas's rows from the tile's first.
    pixels: &'p mut [u8],
    /// Where what is drawn is out of focus: how depths say so, and where it is written.
    circles: Option<(Circle, &'p mut [f32])>,
    scratch: &'p mut Scratch,
}

impl Tile<'_, '_> {
    fn draw(mut self) {
        self.backdrop();
        let stage = self.picture.stage;
        let here = |figure: &StagedFigure| figure.projected.chunks.iter().any(|c| !c.is_empty(self.index));
        let any = stage.figures[self.cell.figures.clone()].iter().any(here);
        if !any && self.cell.discs.is_empty() && self.cell.grains.is_empty(self.index) {
            return self.focus(false);
        }
        self.scratch.depth.fill(1.0);
        if any {
            let mut first = self.cell.figures.start;
            while first < self.cell.figures.end {
                first = self.figures_from(first);
            }
        }
        self.grains();
        self.markers();
        self.focus(any);
    }

    /// Draws the layers of the figures from `first` on that hide each other; those after them are next.
    fn figures_from(&mut self, first: usize) -> usize {
        let subjects = self.picture.subjects;
        let solid = |i: usize| subjects[i].opacity >= 1.0;
        let mut next = first + 1;
        if solid(first) {
            // A ring comes before the figures behind it in the list.
            while next < self.cell.figures.end && solid(next) && subjects[next - 1].ring.is_none() {
                next += 1;
            }
            self.layer(&Layer::Opaque(first..next));
        } else {
            self.layer(&Layer::Side(first, false));
            self.layer(&Layer::Side(first, true));
        }
        if subjects[next - 1].ring.is_some() {
            self.layer(&Layer::Ring(next - 1));
        }
        next
    }

    fn backdrop(&mut self) {
        let opacity = self.cell.uniform.background_center[3];
        if opacity <= 0.0 {
            return;
        }
        let [x, y] = [self.low[0] - self.cell.grid.low[0], self.low[1] - self.cell.grid.low[1]];
        let width = 4 * (self.high[0] - self.low[0] + 1) as usize;
        for row in 0..=(self.high[1] - self.low[1]) {
            let from = &self.cell.backdrop.row(x as usize, (y + row) as usize)[..width];
            let at = self.pixel(self.low[0], self.low[1] + row);
            let to = &mut self.pixels[at..at + width];
            if opacity >= 1.0 {
                to.copy_from_slice(from);
            } else {
                for (to, from) in to.iter_mut().zip(from) {
                    *to = from.saturating_add((f32::from(*to) * (1.0 - opacity) + 0.5) as u8);
                }
            }
        }
    }

    /// Where the four bytes of a pixel are.
    fn pixel(&self, x: i32, y: i32) -> usize {
        4 * ((y - self.origin[1]) as usize * self.picture.width + x as usize)
    }

    /// Where the samples of a pixel are.
    fn sample(&self, x: i32, y: i32) -> usize {
        SAMPLES * ((y - self.origin[1]) as usize * STRIDE + (x - self.origin[0]) as usize)
    }

    fn layer(&mut self, layer: &Layer) {
        self.scratch.seen.fill(NONE);
        let (figures, side) = match layer {
            Layer::Opaque(figures) => (figures.clone(), None),
            Layer::Side(figure, front) => (*figure..*figure + 1, Some(*front)),
            Layer::Ring(figure) => return self.ring(*figure),
        };
        self.scratch.farthest.forget();
        // What fronts hide of the backs is not looked at twice.
        for front in [true, false] {
            if side.is_none_or(|side| side == front) {
                self.find(figures.clone(), front);
            }
            if side.is_none() && front {
                let mut farthest = std::mem::take(&mut self.scratch.farthest);
                farthest.look::<SAMPLES>(&self.target(), WIDTH);
                self.scratch.farthest = farthest;
            }
        }
        let opacity = self.picture.subjects[figures.start].opacity;
        self.uncover(clamp(opacity, 0.0, 1.0));
        let mut base = 0;
        for i in figures {
            let triangles = self.picture.subjects[i].triangles;
            self.surface(i, base..base.saturating_add(triangles.len() as u32));
            base = base.saturating_add(triangles.len() as u32);
        }
    }

    /// Finds where the fronts of figures are seen, or their backs.
    fn find(&mut self, figures: Range<usize>, front: bool) {
        let (picture, tile) = (self.picture, self.index);
        let farthest = std::mem::take(&mut self.scratch.farthest);
        let mut target = self.target();
        let mut base = 0_u32;
        for (figure, subject) in picture.stage.figures[figures.clone()].iter().zip(&picture.subjects[figures])
        {
            for chunk in figure.projected.chunks.iter().filter(|chunk| !chunk.tile(tile, front).is_empty()) {
                let (triangles, corners) = (subject.triangles, &figure.projected.corners);
                let bias = Bias::default();
                let list =
                    Triangles { chunk, tile, front, triangles, corners, base, bias, farthest: &farthest };
                picture.instructions.run(Fill::<SAMPLES, true>(&mut target, list));
            }
            base = base.saturating_add(subject.triangles.len() as u32);
        }
        self.scratch.farthest = farthest;
    }

    fn target(&mut self) -> Target<'_> {
        Target {
            depth: &mut self.scratch.depth,
            seen: &mut self.scratch.seen,
            stride: STRIDE,
            origin: self.origin,
            low: self.low,
            high: self.high,
        }
    }

    /// Samples of the pixels in a row.
    fn row<'s, T>(
        &self,
        samples: &'s [T],
        y: i32,
    ) -> impl Iterator<Item = (i32, &'s [T; SAMPLES])> + use<'s, T> {
        let pixels = samples[self.sample(self.low[0], y)..].as_chunks().0;
        (self.low[0]..=self.high[0]).zip(pixels)
    }

    /// Takes from each pixel the share that the layer covers.
    fn uncover(&mut self, opacity: f32) {
        let all = std::mem::take(&mut self.scratch.seen);
        for y in self.low[1]..=self.high[1] {
            for (x, seen) in self.row(&all, y).filter(|(_, seen)| **seen != [NONE; SAMPLES]) {
                let covered: u32 = seen.iter().map(|id| u32::from(*id != NONE)).sum();
                let at = self.pixel(x, y);
                let pixel = &mut self.pixels[at..at + 4];
                if covered == SAMPLES as u32 && opacity >= 1.0 {
                    pixel.fill(0);
                    continue;
                }
                let left = 1.0 - opacity * covered as f32 / SAMPLES as f32;
                for channel in pixel {
                    *channel = (f32::from(*channel) * left + 0.5) as u8;
                }
            }
        }
        self.scratch.seen = all;
    }

    /// Shades what is seen of a figure, whose triangles are `ids`.
    fn surface(&mut self, figure: usize, ids: Range<u32>) {
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

    fn put(&mut self, triangle: u32, [x, y]: [i32; 2], samples: usize) {
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
    fn locate<const EDGES: bool>(&mut self, figure: usize, triangles: &[[u32; 3]]) {
        let (staged, subject) = (&self.picture.stage.figures[figure], &self.picture.subjects[figure]);
        let setting = self.setting(staged);
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

    fn setting<'s>(&self, figure: &'s StagedFigure) -> Setting<'s>
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
        let staged = &self.picture.stage.figures[figure];
        let wired = staged.uniform.wire_width[0] > 0.0;
        let lined = matches!(subject.coat, Coat::Answer(..)) && staged.uniform.lines[3] > 0.0;
        if wired || lined || matches!(subject.coat, Coat::Skin(_)) {
            self.locate::<true>(figure, subject.triangles);
        } else {
            self.locate::<false>(figure, subject.triangles);
        }
        self.colors(figure);
        let setting = self.setting(staged);
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
                batch.surround(&cell.uniform, around, staged.uniform.material[0]);
            }
            match (staged.uniform.material[3] > 0.0, self.picture.around.is_some()) {
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
            self.wire(&staged.uniform.wire, staged.uniform.wire_width[0]);
        }
        self.lay(clamp(subject.opacity, 0.0, 1.0));
    }

    /// Adds the batch's colours to their pixels.
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

    /// Lays a brush's ring, and a breath of its colour, over a figure that is there.
    fn ring(&mut self, figure: usize) {
        let (staged, subject) = (&self.picture.stage.figures[figure], &self.picture.subjects[figure]);
        let Some((triangles, reach)) = subject.ring else { return };
        let instructions = self.picture.instructions;
        for (id, triangle) in (0..).zip(triangles) {
            for corners in staged.projected.pieces(&staged.lens, subject.positions, *triangle) {
                let mut target = self.target();
                instructions.run(FillOne { target: &mut target, corners, id, bias: RING });
            }
        }
        let [r, g, b, radius] = staged.uniform.brush;
        let lay = |tile: &mut Self| {
            tile.locate::<true>(figure, triangles);
            let batch = &mut *tile.scratch.batch;
            for i in 0..batch.count {
                let corners =
                    triangles[batch.triangle[i] as usize].map(|v| f32::from_ne_bytes(reach[v as usize]));
                let at =
                    |weights: &[[f32; PLACES]; 3]| (0..3).map(|k| weights[k][i] * corners[k]).sum::<f32>();
                let here = at(&batch.weights);
                let step = (at(&batch.right) - here).abs() + (at(&batch.below) - here).abs();
                let ring = 1.0 - smoothstep(0.7, 1.7, (here - radius).abs() / max(step, 1e-9));
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

    fn grains(&mut self) {
        let (cell, tile, bounds) = (self.cell, self.index, (self.low, self.high));
        let [x, y, ..] = cell.uniform.lights[0][0];
        let lay = |[x, y]: [i32; 2], color: &dyn Fn([f32; 4]) -> [f32; 4]| {
            let at = self.sample(x, y);
            let depths = std::array::from_fn(|s| self.scratch.depth[at + s]);
            let at = self.pixel(x, y);
            over(&mut self.pixels[at..], color(depths));
        };
        cell.grains.draw(tile, bounds, lay, [x, y]);
    }

    fn markers(&mut self) {
        let cell = self.cell;
        for disc in &cell.discs {
            let ([left, right], [top, bottom]) = (disc.span(0), disc.span(1));
            for y in top.max(self.low[1])..=bottom.min(self.high[1]) {
                for x in left.max(self.low[0])..=right.min(self.high[0]) {
                    let at = self.sample(x, y);
                    let depths = std::array::from_fn(|s| self.scratch.depth[at + s]);
                    let at = self.pixel(x, y);
                    over(&mut self.pixels[at..], disc.color(x, y, depths));
                }
            }
        }
    }
}

/// Lays a premultiplied colour over the pixel that begins here.
fn over(pixel: &mut [u8], color: [f32; 4]) {
    for (channel, c) in pixel.iter_mut().zip(color) {
        *channel = (f32::from(*channel) * (1.0 - color[3]) + 255.0 * c + 0.5) as u8;
    }
}
