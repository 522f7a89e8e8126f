//! From items to a finished picture.

use std::time::Instant;

use chladni_synth::{AutoSynthesizer, Backend, FrameSettings, Item, SynthModel, Synthesizer};
use chladni_view::{Background, Camera, Cell, Figure, ItemBuffers, Lights, Rect, Topology, View, layout};

use crate::synth::stage::{Stage, wait};
use chladni_program::work::Error;

/// A shape that is deformed and drawn as the program does it: on the graphics card where there is one.
pub struct Projector {
    synthesizer: AutoSynthesizer,
    topology: Topology,
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
    pub fn new(stage: &Stage, model: SynthModel, triangles: &[[u32; 3]]) -> Result<Self, Error> {
        let topology = Topology::new(&stage.gpu, model.vertices(), triangles)?;
        let mut camera = Camera::looking(View::ThreeQuarter);
        camera.fit(model.rest_positions().iter().copied(), 1.0, 0.8);
        let synthesizer = AutoSynthesizer::new(&stage.context, model, Backend::Auto);
        Ok(Self { synthesizer, topology, camera })
    }

    /// Who looks at the first of `items` cells, and where that is.
    pub fn view(&self, stage: &Stage, items: usize) -> (Camera, Rect) {
        (self.camera, cells(stage, items).first().copied().unwrap_or_default())
    }

    /// Deforms and draws `items` in the papers' size.
    pub fn show(&mut self, stage: &mut Stage, items: &[Item]) -> Result<Secs, Error> {
        let start = Instant::now();
        self.synthesizer.synthesize_positions(items)?;
        let moved = start.elapsed().as_secs_f64();
        self.synthesizer.synthesize_normals(&FrameSettings::default())?;
        let lit = start.elapsed().as_secs_f64();
        let buffers = ItemBuffers::of_frame(&self.synthesizer.frame())?;
        let figures: Vec<Figure<'_>> =
            (0..buffers.items()).map(|item| Figure::new(&self.topology, &buffers, item)).collect();
        // The papers' pictures have no shadows.
        let lights = Lights { shadow: 0.0, ..Lights::default() };
        let area = Rect::of_size(stage.canvas.width(), stage.canvas.height());
        let placed = cells(stage, figures.len()).into_iter().zip(&figures);
        let cells = Cell::gallery(area, Background::default(), self.camera, lights, placed);
        stage.renderer.draw(&stage.canvas, &cells)?;
        wait(&stage.gpu)?;
        let drawn = start.elapsed().as_secs_f64();
        Ok(Secs { synthesis: moved, normals: lit - moved, drawing: drawn - lit })
    }
}

fn cells(stage: &Stage, items: usize) -> Vec<Rect> {
    let area = Rect::of_size(stage.canvas.width(), stage.canvas.height());
    let (rows, columns) = layout::rows_and_columns(area.width, area.height, items, 1.0);
    layout::grid(area, rows, columns, 0, items)
}
