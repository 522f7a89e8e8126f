//! Draws cells of figures on a canvas, on either device.

use crate::buffers::Held;
use crate::{Camera, Canvas, Cell, Device, Finish, Rect, Surroundings, ViewError, cpu, gpu};

/// Uniforms and targets, or bins and tiles, that one device keeps from picture to picture. Make one and keep it.
/// Pipelines are compiled when a picture first needs them, once for all renderers of a graphics device.
#[derive(Debug)]
pub struct Renderer {
    pub(crate) device: Device,
    pub(crate) held: Held<Box<cpu::Renderer>, Box<gpu::Renderer>>,
    /// Where the first cell of the last picture lay, and from where it was seen.
    pub(crate) seen: Option<(Rect, Camera)>,
}

impl Renderer {
    /// A renderer for pictures ([`Canvas::new`]).
    pub fn new(on: impl Into<Device>) -> Self {
        let device = on.into();
        let held = match &device {
            Device::Graphics(gpu) => Held::Gpu(Box::new(gpu::Renderer::for_pictures(gpu))),
            Device::Processor => Held::Cpu(Box::default()),
        };
        Self { device, held, seen: None }
    }

    /// The device that draws.
    pub fn device(&self) -> &Device {
        &self.device
    }

    /// From the next picture on, all cells stand in these surroundings.
    ///
    /// # Errors
    /// [`ViewError::Shape`] where they were made for another device.
    pub fn surround(&mut self, surroundings: &Surroundings) -> Result<(), ViewError> {
        match &mut self.held {
            Held::Cpu(renderer) => renderer.surround(surroundings),
            Held::Gpu(renderer) => renderer.surround(surroundings),
        }
    }

    /// Draws `cells` on `canvas`; a graphics device does not wait until it is done. Pixels that no cell covers
    /// are transparent.
    ///
    /// # Errors
    /// [`ViewError::Shape`] where a cell leaves the canvas, a figure's topology, buffers and paint do
    /// not belong together, or any of it was made for another device; [`ViewError::Device`] where the
    /// device has failed.
    pub fn draw(&mut self, canvas: &Canvas, cells: &[Cell<'_>]) -> Result<(), ViewError> {
        self.draw_finished(canvas, cells, &Finish::NOTHING, 0.0)
    }

    /// As [`draw`](Self::draw), with a finish over the whole picture, which is that of `at_secs`. Trails come
    /// of the picture that this renderer drew before; across a cut there are none.
    ///
    /// # Errors
    /// As [`draw`](Self::draw); [`ViewError::Shape`] for a finish on a canvas of another format than
    /// [`Canvas::new`] gives.
    pub fn draw_finished(
        &mut self,
        canvas: &Canvas,
        cells: &[Cell<'_>],
        finish: &Finish,
        at_secs: f64,
    ) -> Result<(), ViewError> {
        let seen = cells.first().map(|cell| (cell.viewport, cell.camera));
        let cut = self.seen.zip(seen).is_some_and(|((place, before), (now_place, now))| {
            place != now_place || now.is_cut_from(&before)
        });
        self.seen = seen;
        let finish = &Finish { trail_secs: if cut { 0.0 } else { finish.trail_secs }, ..*finish };
        match &mut self.held {
            Held::Cpu(renderer) => renderer.draw(canvas.held.cpu()?, cells, (finish, at_secs)),
            Held::Gpu(renderer) => renderer.draw(canvas.held.gpu()?, cells, (finish, at_secs)),
        }
    }
}
