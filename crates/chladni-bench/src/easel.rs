//! Where pictures are drawn, in the papers' size.

use chladni_program::work::Error;
use chladni_view::{
    Background, Camera, Canvas, Cell, Device, Draw, Figure, Gpu, ItemBuffers, Lights, Rect, Renderer,
    Topology, layout,
};
use eframe::wgpu;

/// Pixels.
const SIZE_PX: (u32, u32) = (1024, 768);

/// Draws as the program draws its films: on a graphics card where there is one, else on the processor.
pub struct Easel {
    pub device: Device,
    renderer: Renderer,
    canvas: Canvas,
}

impl Easel {
    pub fn new() -> Result<Self, Error> {
        let device = Device::open(Draw::Auto)?;
        let renderer = Renderer::new(&device);
        let canvas = Canvas::with_samples(&device, SIZE_PX.0, SIZE_PX.1, device.live_samples())?;
        Ok(Self { device, renderer, canvas })
    }

    /// Draws all items side by side and waits until the picture is there.
    pub fn draw(&mut self, topology: &Topology, buffers: &ItemBuffers, camera: Camera) -> Result<(), Error> {
        let figures: Vec<Figure<'_>> =
            (0..buffers.items()).map(|item| Figure::new(topology, buffers, item)).collect();
        // The papers' pictures have no shadows.
        let lights = Lights { shadow: 0.0, ..Lights::default() };
        let area = Rect::of_size(SIZE_PX.0, SIZE_PX.1);
        let placed = viewports(figures.len()).into_iter().zip(&figures);
        let cells = Cell::gallery(area, Background::default(), camera, lights, placed);
        self.renderer.draw(&self.canvas, &cells)?;
        self.device.gpu().map_or(Ok(()), wait)
    }
}

/// Where each of `items` is drawn.
pub fn viewports(items: usize) -> Vec<Rect> {
    layout::arranged(Rect::of_size(SIZE_PX.0, SIZE_PX.1), items, 1.0, 0)
}

/// Waits until the device has finished its work.
pub fn wait(gpu: &Gpu) -> Result<(), Error> {
    gpu.device.poll(wgpu::PollType::wait_indefinitely()).map_err(Error::other)?;
    gpu.check().map_err(Error::other)
}
