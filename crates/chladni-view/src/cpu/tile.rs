//! A tile of a picture: the visible triangles, layer after layer, and their colors.

mod circles;
mod colors;
mod ring;
mod shading;

use std::ops::Range;

use super::batch::Batch;
use super::curves::clamp;
use super::fill::{Bias, Farthest, Fill, MARGIN, NONE, Target, Triangles};
use super::instructions::Instructions;
use super::prepared::{Prepared, PreparedCell, PreparedFigure};
use super::project::TILE_BITS;
use super::subjects::Subject;
use crate::buffers::Pyramid;
use crate::focus::Circle;

const WIDTH: usize = 1 << TILE_BITS[0];
const HEIGHT: usize = 1 << TILE_BITS[1];
const STRIDE: usize = WIDTH + MARGIN;

/// Samples a pixel.
const SAMPLES: usize = 4;

/// Working memory of one thread.
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

/// Data that all tiles draw from.
pub(super) struct Picture<'a> {
    pub(super) instructions: Instructions,
    pub(super) prepared: &'a Prepared,
    pub(super) subjects: &'a [Subject<'a>],
    pub(super) maps: &'a [[[f32; 3]; 256]],
    /// The panorama that shines on all figures.
    pub(super) around: Option<&'a Pyramid>,
    /// Each cell's lens; none where everything is sharp.
    pub(super) circles: &'a [Circle],
    /// Pixels in a row of the canvas.
    pub(super) width: usize,
}

/// Surfaces that are drawn in one pass: their samples are found together and hide each other.
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
            for (i, cell) in self.prepared.cells.iter().enumerate() {
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
    cell: &'a PreparedCell,
    /// Among those of the cell's grid.
    index: usize,
    /// First pixel of the tile.
    origin: [i32; 2],
    /// First and last pixels of the cell in it, inclusive.
    low: [i32; 2],
    high: [i32; 2],
    /// The canvas's rows from the tile's first.
    pixels: &'p mut [u8],
    /// The circles of light, where there is depth of field: from depths, and where they are written.
    circles: Option<(Circle, &'p mut [f32])>,
    scratch: &'p mut Scratch,
}

impl Tile<'_, '_> {
    fn draw(mut self) {
        self.backdrop();
        let here = |figure: &PreparedFigure| figure.projected.chunks.iter().any(|c| !c.is_empty(self.index));
        let any = self.picture.prepared.figures[self.cell.figures.clone()].iter().any(here);
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
        // Parts of backs that fronts hide are not drawn again.
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
        for (figure, subject) in
            picture.prepared.figures[figures.clone()].iter().zip(&picture.subjects[figures])
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
        // Those that are seen lie over all that are hidden.
        let discs =
            [true, false].into_iter().flat_map(|hidden| cell.discs.iter().map(move |disc| (disc, hidden)));
        for (disc, hidden) in discs {
            let ([left, right], [top, bottom]) = (disc.span(0), disc.span(1));
            for y in top.max(self.low[1])..=bottom.min(self.high[1]) {
                for x in left.max(self.low[0])..=right.min(self.high[0]) {
                    let at = self.sample(x, y);
                    let depths = std::array::from_fn(|s| self.scratch.depth[at + s]);
                    let at = self.pixel(x, y);
                    over(&mut self.pixels[at..], disc.color(x, y, depths, hidden));
                }
            }
        }
    }
}

/// Lays a premultiplied color over the pixel that begins here.
fn over(pixel: &mut [u8], color: [f32; 4]) {
    for (channel, c) in pixel.iter_mut().zip(color) {
        *channel = (f32::from(*channel) * (1.0 - color[3]) + 255.0 * c + 0.5) as u8;
    }
}
