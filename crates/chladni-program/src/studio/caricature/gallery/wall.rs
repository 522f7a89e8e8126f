//! The twelve caricatures on the device, swelling together.

use std::sync::Arc;

use chladni_caricature::Portrait;
use chladni_synth::{Coefficients, CpuSynthesizer, FrameSettings, Item, Residual, Synthesizer, Term};
use chladni_view::{Camera, Cell, ItemBuffers, Paint, Rect, Topology, View};
use egui::Ui;

use super::super::look::Portrayal;
use super::super::overlay::backdrop;
use super::super::session::Session;
use crate::studio::screen::Screen;
use crate::studio::viewport::{self, Viewport};
use crate::work::{Error, Exhibition};

/// One swelling from the shape to the caricature and back.
const BREATH_SECS: f64 = 4.0;

/// The twelve on the device.
pub struct Wall {
    viewport: Viewport,
    camera: Camera,
    topology: Topology,
    buffers: ItemBuffers,
    synthesizer: CpuSynthesizer,
    items: Vec<Item>,
    fitted: bool,
    /// How far the figures have swollen, 0 to 1, as they are on the device.
    swollen: Option<f32>,
}

impl Wall {
    pub fn new(screen: &Screen, shown: &Exhibition, session: &Session) -> Result<Self, Error> {
        let (body, model) = (shown.sitter.body(), shown.sitter.model().clone());
        let vertices = body.positions.len();
        let device = screen.device();
        Ok(Self {
            topology: Topology::new(device, vertices, &body.triangles)?,
            buffers: ItemBuffers::new(device, vertices, shown.portraits.len()),
            viewport: Viewport::new(screen),
            camera: Camera::on(session.stands(), View::ThreeQuarter),
            synthesizer: CpuSynthesizer::new(model),
            items: Vec::new(),
            fitted: false,
            swollen: None,
        })
    }

    /// Others are to be hung.
    pub fn emptied(self) -> Self {
        Self { items: Vec::new(), swollen: None, ..self }
    }

    /// Hangs what is shown, where it does not hang already.
    pub fn hang(&mut self, shown: &Exhibition) {
        if !self.items.is_empty() {
            return;
        }
        let rest = shown.sitter.model().rest_positions();
        let item = |portrait: &Portrait| {
            let moved = portrait.positions.iter().zip(rest);
            let moved: Arc<[[f32; 3]]> =
                moved.map(|(a, b): (&[f32; 3], &[f32; 3])| [a[0] - b[0], a[1] - b[1], a[2] - b[2]]).collect();
            let residual = Some(Residual::Vector(moved));
            let coefficients = Coefficients::Vector(Vec::new());
            Item { terms: vec![Term { coefficients, residual, residual_gain: 1.0, mask: None }] }
        };
        self.items = shown.portraits.iter().map(item).collect();
    }

    /// Swells all of them together, in one frame of the synthesizer.
    fn swell(&mut self, share: f32) -> Result<(), Error> {
        if self.swollen == Some(share) {
            return Ok(());
        }
        self.items.iter_mut().flat_map(|item| &mut item.terms).for_each(|term| term.residual_gain = share);
        self.synthesizer.synthesize(&self.items, &FrameSettings::default())?;
        self.buffers.take_frame(self.viewport.device(), &self.synthesizer)?;
        self.swollen = Some(share);
        self.viewport.invalidate();
        Ok(())
    }

    pub fn show(
        &mut self,
        ui: &mut Ui,
        rect: egui::Rect,
        cells: &[Rect],
        response: &egui::Response,
        look: Portrayal,
    ) -> Result<(), Error> {
        let time_secs = ui.input(|input| input.time);
        if !self.fitted {
            self.swell(1.0)?;
            let aspect = cells.first().map_or(1.0, Rect::aspect);
            self.camera.fit(self.synthesizer.all_positions().iter().copied(), aspect, 0.84);
            self.fitted = true;
        }
        let turn = std::f64::consts::TAU * time_secs / BREATH_SECS;
        self.swell((0.5 - 0.5 * turn.cos()) as f32)?;
        ui.ctx().request_repaint();
        if viewport::navigate_by(ui, response, &mut self.camera, true) {
            self.viewport.invalidate();
        }
        let figures: Vec<_> = (0..cells.len())
            .map(|item| [look.figure(&self.topology, &self.buffers, item, Paint::Material)])
            .collect();
        let (camera, lights, background) = (self.camera, look.lights(), backdrop(ui));
        self.viewport.show(ui, rect, |_| {
            let all = cells.iter().zip(&figures);
            all.map(|(viewport, figures)| Cell {
                viewport: *viewport,
                camera,
                lights,
                background,
                figures,
                markers: &[],
            })
            .collect()
        })?;
        Ok(())
    }
}
