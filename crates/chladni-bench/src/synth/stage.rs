//! The device, and drawing on it.

use chladni_synth::DeviceFrame;
use chladni_view::{
    Background, Camera, Canvas, Cell, Figure, Gpu, ItemBuffers, Lights, Rect, Renderer, Topology, View,
    layout,
};
use eframe::wgpu;

use chladni_program::work::Error;

/// The papers' size of picture.
pub const SIZE_PX: (u32, u32) = (1024, 768);

/// Where frames are drawn.
pub struct Stage {
    pub gpu: Gpu,
    pub renderer: Renderer,
    pub canvas: Canvas,
}

impl Stage {
    /// Opens the device. Drawing is as in films and windows: with one sample a pixel where the processor
    /// draws.
    pub fn new() -> Result<Self, Error> {
        let gpu = Gpu::headless()?;
        let renderer = Renderer::new(&gpu);
        let canvas = Canvas::with_samples(&gpu, SIZE_PX.0, SIZE_PX.1, gpu.live_samples())?;
        Ok(Self { gpu, renderer, canvas })
    }
}

/// The items of a frame, side by side.
pub struct Scene {
    gpu: Gpu,
    topology: Topology,
    buffers: ItemBuffers,
    items: usize,
}

impl Scene {
    /// Of a frame on the device.
    pub fn new(gpu: &Gpu, frame: DeviceFrame<'_>, triangles: &[[u32; 3]]) -> Result<Self, Error> {
        let (vertices, items) = (frame.vertices as usize, frame.items as usize);
        let topology = Topology::new(gpu, vertices, triangles)?;
        let buffers = ItemBuffers::borrowed(frame.positions.clone(), frame.normals.clone(), vertices, items)?;
        Ok(Self { gpu: gpu.clone(), topology, buffers, items })
    }

    /// Draws all items and waits.
    pub fn draw(&self, renderer: &mut Renderer, canvas: &Canvas) -> Result<(), Error> {
        let figures: Vec<_> =
            (0..self.items).map(|item| Figure::new(&self.topology, &self.buffers, item)).collect();
        let (rows, columns) = layout::rows_and_columns(SIZE_PX.0, SIZE_PX.1, self.items, 1.0);
        let viewports = layout::grid(Rect::of_size(SIZE_PX.0, SIZE_PX.1), rows, columns, 0, self.items);
        let camera = Camera::looking(View::ThreeQuarter);
        let cells: Vec<_> = viewports
            .into_iter()
            .zip(&figures)
            .map(|(viewport, figure)| Cell {
                viewport,
                camera,
                // The papers' pictures have no shadows.
                lights: Lights { shadow: 0.0, ..Lights::default() },
                background: Background::default(),
                figures: std::slice::from_ref(figure),
                markers: &[],
            })
            .collect();
        renderer.draw(canvas, &cells)?;
        wait(&self.gpu)
    }
}

/// Waits until the device has finished its work.
pub fn wait(gpu: &Gpu) -> Result<(), Error> {
    gpu.device.poll(wgpu::PollType::wait_indefinitely()).map_err(Error::other)?;
    gpu.check().map_err(Error::other)
}
