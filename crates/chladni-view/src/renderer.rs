//! Draws cells of figures on a canvas, whoever draws.

use crate::buffers::Held;
use crate::{Canvas, Cell, Device, Finish, Gpu, ViewError, cpu, gpu};

/// What one device keeps from picture to picture: pipelines and uniforms, or bins and tiles. Make one
/// and keep it.
#[derive(Debug)]
pub struct Renderer {
    device: Device,
    held: Held<Box<cpu::Renderer>, Box<gpu::Renderer>>,
}

impl Renderer {
    /// A renderer for pictures ([`Canvas::FORMAT`]).
    pub fn new(on: impl Into<Device>) -> Self {
        match on.into() {
            Device::Graphics(gpu) => Self::with_format(&gpu, Canvas::FORMAT),
            Device::Processor => Self { device: Device::Processor, held: Held::Cpu(Box::default()) },
        }
    }

    /// A renderer of a graphics device for canvases of another eight-bit format.
    pub fn with_format(gpu: &Gpu, format: wgpu::TextureFormat) -> Self {
        Self { device: gpu.into(), held: Held::Gpu(Box::new(gpu::Renderer::new(gpu, format))) }
    }

    /// Who draws.
    pub fn device(&self) -> &Device {
        &self.device
    }

    /// Draws `cells` on `canvas`; a graphics device does not wait until it is done. What no cell covers
    /// is transparent.
    ///
    /// # Errors
    /// [`ViewError::Shape`] where a cell leaves the canvas, a figure's topology, buffers and paint do
    /// not belong together, or any of it was made for another device; [`ViewError::Device`] where the
    /// device has failed.
    pub fn draw(&mut self, canvas: &Canvas, cells: &[Cell<'_>]) -> Result<(), ViewError> {
        self.draw_finished(canvas, cells, &Finish::NOTHING, 0.0)
    }

    /// As [`draw`](Self::draw), with a finish over the whole picture, which is that of `at_secs`. Trails come
    /// of the picture that this renderer drew before.
    ///
    /// # Errors
    /// As [`draw`](Self::draw); [`ViewError::Shape`] for a finish on a canvas of a format that is not
    /// [`Canvas::FORMAT`].
    pub fn draw_finished(
        &mut self,
        canvas: &Canvas,
        cells: &[Cell<'_>],
        finish: &Finish,
        at_secs: f64,
    ) -> Result<(), ViewError> {
        match &mut self.held {
            Held::Cpu(renderer) => renderer.draw(canvas.held.cpu()?, cells, (finish, at_secs)),
            Held::Gpu(renderer) => renderer.draw(canvas.held.gpu()?, cells, (finish, at_secs)),
        }
    }
}
