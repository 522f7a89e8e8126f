//! Drawing on the processor, the twin of the graphics device: the same cells, figures and formulas.
//!
//! Vertices are projected onto a grid of sub-pixels and triangles sorted into tiles. A tile first finds
//! the visible triangle at four samples of each pixel, and then shades once a pixel, or once for each of
//! the surfaces that meet there. Tiles are drawn by whichever thread comes; every pixel is computed by
//! one thread in one order, so that the number of threads changes no bit.
//!
//! Layers are drawn one over the other: opaque figures together, sides of translucent
//! figures, brush rings, grains, markers. Depth of field and the rest of the finish come after these.

mod backdrop;
mod batch;
mod chroma;
mod curves;
mod fill;
mod finishing;
mod focus;
mod grains;
mod instructions;
mod markers;
mod prepared;
mod project;
mod projected;
mod shade;
mod shadow;
mod subjects;
mod tile;

use std::sync::{Mutex, MutexGuard, PoisonError};

use rayon::prelude::*;

pub(crate) use chroma::halved as halved_chroma;
pub(crate) use instructions::Instructions;

use self::finishing::Finishing;
use self::focus::Focusing;
use self::prepared::Prepared;
use self::project::TILE_BITS;
use self::subjects::Locks;
use self::tile::Scratch;
use crate::focus::Circle;
use crate::style::linear;
use crate::{Cell, ColorMap, Finish, Palette, Surroundings, ViewError};

/// Pixels in memory: sRGB-encoded, premultiplied, rows from the top.
#[derive(Debug)]
pub(crate) struct Canvas {
    pub(crate) width: u32,
    pub(crate) height: u32,
    pixels: Mutex<Vec<u8>>,
}

impl Canvas {
    pub(crate) fn new(width: u32, height: u32) -> Self {
        Self { width, height, pixels: Mutex::new(vec![0; 4 * width as usize * height as usize]) }
    }

    pub(crate) fn pixels(&self) -> MutexGuard<'_, Vec<u8>> {
        self.pixels.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Buffers that are kept from picture to picture, so that a warm one allocates nothing of its size.
#[derive(Debug)]
pub(crate) struct Renderer {
    instructions: Instructions,
    prepared: Prepared,
    finishing: Finishing,
    focusing: Focusing,
    surroundings: Surroundings,
    /// Linear light of the color maps, then of the palettes, one a row.
    maps: Vec<[[f32; 3]; 256]>,
    /// For the threads to take.
    scratch: Mutex<Vec<Scratch>>,
}

impl Default for Renderer {
    fn default() -> Self {
        let row = |color: &dyn Fn(f32) -> [u8; 3]| std::array::from_fn(|i| linear(color(i as f32 / 255.0)));
        let maps = ColorMap::ALL.iter().map(|map| row(&|t| map.color(t)));
        let palettes = Palette::ALL.iter().map(|palette| row(&|t| palette.color(t)));
        Self {
            instructions: Instructions::fastest(),
            prepared: Prepared::default(),
            finishing: Finishing::default(),
            focusing: Focusing::default(),
            surroundings: Surroundings::default(),
            maps: maps.chain(palettes).collect(),
            scratch: Mutex::default(),
        }
    }
}

impl Renderer {
    pub(crate) fn surround(&mut self, surroundings: &Surroundings) -> Result<(), ViewError> {
        for skin in surroundings.behind.iter().map(|(skin, _)| skin).chain(&surroundings.around) {
            skin.held.cpu()?;
        }
        self.surroundings = surroundings.clone();
        Ok(())
    }

    pub(crate) fn draw(
        &mut self,
        canvas: &Canvas,
        cells: &[Cell<'_>],
        (finish, at_secs): (&Finish, f64),
    ) -> Result<(), ViewError> {
        let locks = Locks::of(cells)?;
        let subjects = locks.subjects(cells)?;
        self.prepared.prepare(self.instructions, canvas, (cells, &self.surroundings), &subjects)?;
        let around = self.surroundings.around.as_ref();
        let size = [canvas.width, canvas.height];
        let circles: Vec<Circle> = if finish.blur > 0.0 {
            cells.iter().map(|cell| Circle::new(finish, cell, canvas.height)).collect()
        } else {
            Vec::new()
        };
        let picture = tile::Picture {
            instructions: self.instructions,
            prepared: &self.prepared,
            subjects: &subjects,
            maps: &self.maps,
            around: around.map(|skin| skin.held.cpu()).transpose()?.map(|pyramid| &**pyramid),
            circles: &circles,
            width: canvas.width as usize,
        };
        let scratch = &self.scratch;
        let pool = || scratch.lock().unwrap_or_else(PoisonError::into_inner);
        let band = (4 * picture.width) << TILE_BITS[1];
        let mut pixels = canvas.pixels();
        let draw = |row: usize, pixels: &mut [u8], circles: &mut [f32]| {
            let mut own = pool().pop().unwrap_or_else(Scratch::new);
            picture.draw_band(row as i32, (pixels, circles), &mut own);
            pool().push(own);
        };
        let bands = pixels.par_chunks_mut(band).enumerate();
        if circles.is_empty() {
            bands.for_each(|(row, pixels)| draw(row, pixels, &mut []));
        } else {
            let each = bands.zip(self.focusing.circles(size).par_chunks_mut(band / 4));
            each.for_each(|((row, pixels), circles)| draw(row, pixels, circles));
            self.focusing.lay(self.instructions, size, &mut pixels);
        }
        if !finish.is_nothing() {
            self.finishing.lay(self.instructions, (finish, at_secs), size, &mut pixels);
        } else {
            self.finishing.forget();
        }
        Ok(())
    }

    /// For comparing instruction sets.
    #[cfg(test)]
    fn with(instructions: Instructions) -> Self {
        Self { instructions, ..Self::default() }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a panic is how a test fails")]
mod tests {
    use super::*;
    use crate::{Background, Camera, Device, Figure, ItemBuffers, Lights, Material, Rect, Topology};

    /// A wavy sheet, lit so that shadows fall on it.
    #[test]
    fn every_instruction_set_draws_the_same_bits() {
        let side = 40_u32;
        let positions: Vec<[f32; 3]> = (0..side * side)
            .map(|i| [(i % side) as f32 / 20.0 - 1.0, (i / side) as f32 / 20.0 - 1.0])
            .map(|[x, y]| [x, y, 0.2 * (7.0 * x).sin() * (5.0 * y).cos()])
            .collect();
        let triangles: Vec<[u32; 3]> = (0..side * (side - 1))
            .filter(|i| i % side != side - 1)
            .flat_map(|i| [[i, i + 1, i + side], [i + 1, i + side + 1, i + side]])
            .collect();
        let normals = crate::smooth_normals(&positions, &triangles);
        let topology = Topology::new(Device::Processor, positions.len(), &triangles).unwrap();
        let buffers = ItemBuffers::new(Device::Processor, positions.len(), 1);
        buffers.write(Device::Processor, 0, &positions, &normals).unwrap();
        let figure = Figure { material: Material::PEARL, ..Figure::new(&topology, &buffers, 0) };
        let cell = Cell {
            viewport: Rect::of_size(150, 90),
            camera: Camera::default(),
            lights: Lights::DRAMATIC,
            background: Background::PAPER,
            figures: &[figure],
            markers: &[],
        };
        let finish = Finish { blur: 0.6, bloom: 0.8, vignette: 0.5, grain: 0.1, ..Finish::NOTHING };
        let pictures = Instructions::available().iter().map(|instructions| {
            let canvas = Canvas::new(150, 90);
            Renderer::with(*instructions).draw(&canvas, &[cell], (&finish, 0.5)).unwrap();
            canvas.pixels.into_inner().unwrap()
        });
        let pictures: Vec<Vec<u8>> = pictures.collect();
        assert!(pictures.iter().all(|picture| *picture == pictures[0]));
    }
}
