//! From items to a finished picture.

use std::time::Instant;

use crate::easel::{Easel, viewports};
use chladni_program::work::Deformed;
use chladni_program::work::Error;
use chladni_synth::{Backend, FrameSettings, Item, SynthModel};
use chladni_view::{Camera, Rect, Topology, View};

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
        (self.camera, viewports(items).first().copied().unwrap_or_default())
    }

    /// Deforms and draws `items` in the papers' size.
    pub fn show(&mut self, easel: &mut Easel, items: &[Item]) -> Result<Secs, Error> {
        let [synthesis, normals] = self.deformed.synthesize(items, &FrameSettings::default())?;
        let start = Instant::now();
        easel.draw(&self.deformed.topology, &self.deformed.buffers()?, self.camera)?;
        let drawing = start.elapsed().as_secs_f64();
        Ok(Secs { synthesis, normals, drawing })
    }
}
