//! A shape that is read already, while its harmonics are being solved for.

use std::sync::Arc;
use std::sync::mpsc::Receiver;

use chladni_mesh::{Orientation, TriMesh};
use chladni_view::{Cell, Rect};
use egui::Ui;

use super::look::Portrayal;
use super::overlay::backdrop;
use crate::studio::room::Shared;
use crate::studio::viewport::{self, Viewport};
use crate::work::Error;
use crate::work::landmarks::Side;

/// The shape, as soon as it comes.
pub struct Preview {
    meshes: Receiver<(Arc<TriMesh>, Orientation)>,
    shown: Option<(Viewport, Side)>,
}

impl Preview {
    /// Shows the mesh that `meshes` will bring.
    pub fn of(meshes: Receiver<(Arc<TriMesh>, Orientation)>) -> Self {
        Self { meshes, shown: None }
    }

    /// Draws it into all of `ui`; names the shape being loaded while there is nothing yet.
    pub fn show(&mut self, ui: &mut Ui, look: Portrayal, shared: &Shared<'_>) -> Result<(), Error> {
        if let Ok((mesh, stands)) = self.meshes.try_recv() {
            let viewport = Viewport::new(shared.screen);
            let side = Side::new(viewport.device(), &mesh, stands)?;
            self.shown = Some((viewport, side));
        }
        let rect = viewport::whole_pixels(ui);
        let Some((viewport, side)) = &mut self.shown else {
            ui.centered_and_justified(|ui| ui.label("The shape appears here as soon as it is read."));
            return Ok(());
        };
        let response = ui.allocate_rect(rect, egui::Sense::click_and_drag());
        let aspect = rect.width() / rect.height().max(1.0);
        side.fit(aspect);
        if viewport::navigate_by(ui, &response, &mut side.camera, true) {
            viewport.invalidate();
        }
        let figures = [side.figure(look.material())];
        let (camera, lights, background) = (side.camera, look.lights(), backdrop(ui));
        let cell = |viewport: Rect| {
            vec![Cell { viewport, camera, lights, background, figures: &figures, markers: &[] }]
        };
        viewport.show(ui, rect, cell).map_err(Error::from)
    }
}
