//! The twelve caricatures on the device, swelling together.

use chladni_mesh::Orientation;
use chladni_view::{Camera, Cell, ItemBuffers, Paint, Rect, Topology, View};
use egui::Ui;

use super::super::look::Portrayal;
use super::super::overlay::backdrop;
use super::super::session::Session;
use crate::studio::screen::Screen;
use crate::studio::viewport::{self, Viewport};
use crate::work::{Error, Exhibition, Swelling, swollen_at};

/// The twelve on the device.
pub struct Wall {
    viewport: Viewport,
    camera: Camera,
    topology: Topology,
    buffers: ItemBuffers,
    swelling: Swelling,
    fitted: bool,
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
            swelling: Swelling::new(model),
            fitted: false,
        })
    }

    /// Others are to be hung.
    pub fn emptied(mut self) -> Self {
        self.swelling.clear();
        self
    }

    /// Turns the view when the shape's orientation changes.
    pub fn stand(&mut self, stands: Orientation) {
        if self.camera.stands != stands {
            self.camera.stands = stands;
            self.fitted = false;
            self.viewport.invalidate();
        }
    }

    /// Hangs the exhibition, unless it hangs already.
    pub fn hang(&mut self, shown: &Exhibition) {
        if self.swelling.is_empty() {
            self.swelling.hang(shown.portraits.iter().map(|portrait| &*portrait.positions));
        }
    }

    /// Swells all of them together.
    fn swell(&mut self, share: f32) -> Result<(), Error> {
        if let Some(frame) = self.swelling.swell(share)? {
            self.buffers.take_frame(self.viewport.device(), frame)?;
            self.viewport.invalidate();
        }
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
            self.camera.fit(self.swelling.positions().iter().copied(), aspect, 0.84);
            self.fitted = true;
        }
        self.swell(swollen_at(time_secs))?;
        ui.ctx().request_repaint();
        if viewport::navigate_by(ui, response, &mut self.camera, true) {
            self.viewport.invalidate();
        }
        let scale = ui.pixels_per_point();
        let figures: Vec<_> = (0..cells.len())
            .map(|item| [look.figure(&self.topology, &self.buffers, item, Paint::Material, scale)])
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
