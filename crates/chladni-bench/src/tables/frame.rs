//! From items to a finished picture.

use std::time::Instant;

use crate::synth::stage::{SIZE_PX, wait};
use chladni_program::work::Deformed;
use chladni_program::work::Error;
use chladni_synth::{Backend, FrameSettings, Item, SynthModel};
use chladni_view::{
    Background, Camera, Canvas, Cell, Device, Draw, Figure, Lights, Rect, Renderer, Topology, View, layout,
};

/// Where pictures are drawn as the program draws its films: on a graphics card where there is one.
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
}

/// A shape that is deformed and drawn.
pub struct Projector {
    deformed: Deformed,
    camera: Camera,
}

/// Seconds of a frame.
pub struct Secs {
    pub synthesis: f64,
    pub normals: f64,
    /// With the upload where the processor deforms, until the picture is there.
    pub drawing: f64,
}

impl Projector {
    pub fn new(easel: &Easel, model: &SynthModel, triangles: &[[u32; 3]]) -> Result<Self, Error> {
        let mut camera = Camera::looking(View::ThreeQuarter);
        camera.fit(model.rest_positions().iter().copied(), 1.0, 0.8);
        let topology = Topology::new(&easel.device, model.vertices(), triangles)?;
        let deformed = Deformed::new(&easel.device, model, topology, Backend::Auto);
        Ok(Self { deformed, camera })
    }

    /// The camera and the viewport of the first of `items` cells.
    pub fn view(&self, items: usize) -> (Camera, Rect) {
        (self.camera, cells(items).first().copied().unwrap_or_default())
    }

    /// Deforms and draws `items` in the papers' size.
    pub fn show(&mut self, easel: &mut Easel, items: &[Item]) -> Result<Secs, Error> {
        let [synthesis, normals] = self.deformed.synthesize(items, &FrameSettings::default())?;
        let start = Instant::now();
        let buffers = self.deformed.buffers()?;
        let figures: Vec<Figure<'_>> =
            (0..buffers.items()).map(|item| Figure::new(&self.deformed.topology, &buffers, item)).collect();
        // The papers' pictures have no shadows.
        let lights = Lights { shadow: 0.0, ..Lights::default() };
        let area = Rect::of_size(SIZE_PX.0, SIZE_PX.1);
        let placed = cells(figures.len()).into_iter().zip(&figures);
        let cells = Cell::gallery(area, Background::default(), self.camera, lights, placed);
        easel.renderer.draw(&easel.canvas, &cells)?;
        if let Some(gpu) = easel.device.gpu() {
            wait(gpu)?;
        }
        let drawing = start.elapsed().as_secs_f64();
        Ok(Secs { synthesis, normals, drawing })
    }
}

fn cells(items: usize) -> Vec<Rect> {
    let (rows, columns) = layout::rows_and_columns(SIZE_PX.0, SIZE_PX.1, items, 1.0);
    layout::grid(Rect::of_size(SIZE_PX.0, SIZE_PX.1), rows, columns, 0, items)
}
