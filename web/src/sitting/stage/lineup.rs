//! The chosen layer in its three models, and the shape as it was, beside each other: seen by one viewer, in the same
//! colors.

use chladni_caricature::Surface;
use chladni_mesh::surface::vec3::single;
use chladni_program::work::Error;
use chladni_view::{Background, ItemBuffers, Rect, layout};

use super::{Placed, Stage, draw};

/// The three models and the original.
pub const FIGURES: usize = 4;

/// Figures that stand beside each other.
pub(super) struct Lineup {
    buffers: ItemBuffers,
    /// Positions of all of them, one after the other.
    positions: Vec<[f32; 3]>,
    cells: Vec<Rect>,
}

impl Stage {
    /// These stand beside each other from now on, in the place of the figure.
    pub fn line_up(&mut self, figures: [&[[f64; 3]]; FIGURES], surface: &Surface) -> Result<(), Error> {
        let device = self.screen.device();
        let vertices = self.positions.len();
        let is_new = self.lineup.is_none();
        let mut lineup = self.lineup.take().unwrap_or_else(|| Lineup {
            buffers: ItemBuffers::new(device, vertices, FIGURES),
            positions: Vec::new(),
            cells: Vec::new(),
        });
        lineup.positions.clear();
        for (item, positions) in figures.into_iter().enumerate() {
            let (positions, normals) = (single(positions), single(&surface.normals(positions)));
            lineup.buffers.write(device, item, &positions, &normals)?;
            lineup.positions.extend(positions);
        }
        self.lineup = Some(lineup);
        self.stale = true;
        if is_new {
            self.fit();
        }
        Ok(())
    }

    /// The figure alone.
    pub fn stand_alone(&mut self) {
        if self.lineup.take().is_some() {
            self.fit();
        }
    }

    /// The cells of those that stood beside each other in the last picture.
    pub fn lineup_cells(&self) -> &[Rect] {
        self.lineup.as_ref().map_or(&[], |lineup| &lineup.cells)
    }

    /// Draws them.
    pub(super) fn draw_lineup(&mut self, mut lineup: Lineup) -> Result<(), Error> {
        lineup.cells = layout::arranged(self.area(), FIGURES, 0.8, 2);
        self.aim(&lineup.positions, lineup.cells.first().map_or(1.0, Rect::aspect));
        let placed = |(item, viewport): (usize, &Rect)| Placed {
            viewport: *viewport,
            camera: self.camera,
            figures: vec![self.model.figure_in(&lineup.buffers, item)],
            markers: Vec::new(),
        };
        let placed: Vec<Placed<'_>> = lineup.cells.iter().enumerate().map(placed).collect();
        draw(&mut self.renderer, self.screen.canvas(), &placed, Background::SLATE)?;
        drop(placed);
        self.lineup = Some(lineup);
        self.shown()
    }
}
