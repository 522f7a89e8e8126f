//! Passes that draw only depths: those that the key light sees, and, where a device cannot read the samples of a
//! picture's own depths, those that the viewer sees.

use super::Renderer;
use crate::gpu::focus::FINE;
use crate::gpu::pipelines::{Kind, Part};
use crate::gpu::screen::depth_pass;
use crate::uniforms::casts_shadows;
use crate::{Cell, Figure, Samples, ViewError};

impl Renderer {
    /// The maps of all cells whose key light casts shadows.
    pub(super) fn draw_shadows(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        cells: &[Cell<'_>],
    ) -> Result<(), ViewError> {
        if !cells.iter().any(casts_shadows) {
            return Ok(());
        }
        let mut pass = self.images.shadows.pass(encoder);
        let (mut first_figure, mut map) = (0, 0);
        for (cell_index, cell) in cells.iter().enumerate() {
            if casts_shadows(cell) {
                let ([x, y], size) = (self.images.shadows.corner(map), self.images.shadows.size);
                map += 1;
                pass.set_viewport(x as f32, y as f32, size as f32, size as f32, 0.0, 1.0);
                pass.set_scissor_rect(x, y, size, size);
                let solid = |figure: &Figure<'_>| figure.opacity >= 1.0;
                self.draw_depths(&mut pass, (cell_index, cell, first_figure), Part::Shadow, solid)?;
            }
            first_figure += cell.figures.len();
        }
        Ok(())
    }

    /// The depths that the viewer sees, at [`FINE`] times the canvas's resolution.
    pub(super) fn draw_seen_depths(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        target: &wgpu::TextureView,
        cells: &[Cell<'_>],
    ) -> Result<(), ViewError> {
        let mut pass = depth_pass(encoder, "seen depths", target);
        let mut first_figure = 0;
        for (cell_index, cell) in cells.iter().enumerate() {
            let r = cell.viewport;
            let [x, y, width, height] = [r.x, r.y, r.width, r.height].map(|side| FINE * side);
            pass.set_viewport(x as f32, y as f32, width as f32, height as f32, 0.0, 1.0);
            pass.set_scissor_rect(x, y, width, height);
            self.draw_depths(&mut pass, (cell_index, cell, first_figure), Part::Depth, |_| true)?;
            first_figure += cell.figures.len();
        }
        Ok(())
    }

    /// Those figures of a cell that are asked for.
    fn draw_depths(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        (cell_index, cell, first_figure): (usize, &Cell<'_>, usize),
        part: Part,
        is_drawn: impl Fn(&Figure<'_>) -> bool,
    ) -> Result<(), ViewError> {
        pass.set_bind_group(0, &self.cells.group, &[self.cells.offset(cell_index)]);
        for (i, figure) in cell.figures.iter().enumerate() {
            if figure.topology.triangles == 0 || !is_drawn(figure) {
                continue;
            }
            pass.set_pipeline(&self.pipeline(Kind::new(part, Samples::One)));
            pass.set_bind_group(1, &self.figures.group, &[self.figures.offset(first_figure + i)]);
            let (items, triangles) = (figure.buffers.held.gpu()?, figure.topology.held.gpu()?);
            pass.set_vertex_buffer(0, items.positions.slice(figure.buffers.item_bytes(figure.item)));
            pass.set_index_buffer(triangles.indices.slice(..), wgpu::IndexFormat::Uint32);
            pass.draw_indexed(0..3 * figure.topology.triangles as u32, 0, 0..1);
        }
        Ok(())
    }
}
