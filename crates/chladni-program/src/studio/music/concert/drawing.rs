//! The picture of all items, which is shown once its brightness is known.

use chladni_music::{Framing, Reaction, Switch, Veil};
use chladni_view::{Figure, Gpu, ItemBuffers, Look, Rect, Topology};
use egui::{Color32, Ui};

use super::super::coarse::{self, Detail};
use super::super::glimpse::Glimpse;
use super::super::stillness::StillPicture;
use super::Concert;
use crate::studio::room::Shared;
use crate::studio::theme;
use crate::work::Error;

impl Concert {
    pub(super) fn draw(
        &mut self,
        ui: &mut Ui,
        shared: &Shared<'_>,
        (rect, area): (egui::Rect, Rect),
        cells: &[Rect],
        (reaction, framing, at_secs): (Reaction, Option<Framing>, f64),
        look: Look,
        pose: u64,
    ) -> Result<(), Error> {
        let limited = self.instrument.parameters().is_on(Switch::FlashLimit);
        let from = (&self.viewpoint, framing.as_ref());
        let staged = self.staging.set(area, cells.len(), from, &look, reaction, &self.instrument);
        self.viewport.finish(staged.look.finish, at_secs);
        let shown = StillPicture { pose, staged: staged.clone() };
        self.moving = self.shown.as_ref() != Some(&shown);
        if self.moving {
            self.viewport.invalidate();
        }
        let buffers = ItemBuffers::of_frame(&self.synthesizer.frame())?;
        let grains = self.sand.drawn();
        let mut drawn_vertices = 0;
        let figures: Vec<Figure<'_>> = (0..)
            .zip(cells)
            .map(|(item, cell)| {
                let pixels = cell.width as usize * cell.height as usize;
                let seen = self.seen.get(item).copied().unwrap_or(0);
                let needed = coarse::vertices_needed(seen, pixels);
                let detail = self.details.iter().rev().find(|(detail, _)| detail.vertices >= needed);
                drawn_vertices += detail.map_or(self.staging.rest().len(), |(detail, _)| detail.vertices);
                let topology = detail.map_or(&self.topology, |(_, topology)| topology);
                Figure { grains, ..staged.figure(topology, &buffers, item, &self.rest) }
            })
            .collect();
        self.drawn_vertices = drawn_vertices / cells.len().max(1);
        let behind = theme::palette(ui).stage;
        ui.painter().rect_filled(rect, 0.0, behind);
        if !limited {
            if self.glimpse.is_coming() {
                (self.glimpse, self.judged) = (Glimpse::default(), false);
            }
            self.viewport.draw(ui, shared.gpu, rect, |_| staged.cells(&figures))?;
            self.shown = Some(shown);
            self.viewport.paint(ui, rect);
            self.moving |= self.house.cover(ui, rect, self.seconds);
            return Ok(());
        }
        // The picture is shown once its brightness is known; until then the previous one is shown, and no new
        // one is started.
        if self.glimpse.look(self.viewport.gpu())? {
            self.viewport.keep();
            self.judged = true;
        }
        if !self.glimpse.is_coming() {
            let drawn = self.viewport.draw(ui, shared.gpu, rect, |_| staged.cells(&figures));
            if drawn? && let Some(canvas) = self.viewport.canvas() {
                self.glimpse.begin(self.viewport.gpu(), canvas, behind);
            }
            self.shown = Some(shown);
        }
        let veil =
            if self.judged { self.guard.veil(self.seconds, self.glimpse.histogram()) } else { Veil::Clear };
        self.moving |= self.glimpse.is_coming() || veil != Veil::Clear;
        self.viewport.paint_kept(ui, rect);
        match veil {
            Veil::Clear => {}
            Veil::Black(opacity) => {
                ui.painter().rect_filled(rect, 0.0, Color32::from_black_alpha(opacity));
            }
            Veil::White(opacity) => {
                ui.painter().rect_filled(rect, 0.0, Color32::from_white_alpha(opacity));
            }
        }
        self.moving |= self.house.cover(ui, rect, self.seconds);
        Ok(())
    }

    /// Shows the last picture again.
    pub(super) fn repaint(&mut self, ui: &mut Ui, rect: egui::Rect) {
        ui.allocate_rect(rect, egui::Sense::hover());
        if self.instrument.parameters().is_on(Switch::FlashLimit) {
            self.viewport.paint_kept(ui, rect);
        } else {
            self.viewport.paint(ui, rect);
        }
        self.moving = self.house.cover(ui, rect, self.seconds);
    }
}

/// Levels of a shape of `vertices` vertices, with their triangles on the device.
pub fn on_device(
    gpu: &Gpu,
    vertices: usize,
    details: impl IntoIterator<Item = Detail>,
) -> Result<Vec<(Detail, Topology)>, Error> {
    let upload =
        |detail: Detail| Topology::new(gpu, vertices, &detail.triangles).map(|topology| (detail, topology));
    Ok(details.into_iter().map(upload).collect::<Result<_, _>>()?)
}
