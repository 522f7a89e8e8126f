//! The middle of the room: the toolbar and the stage.

use chladni_caricature::{Brush, Limbs, Model, Property};
use egui::{RichText, Ui};

use super::CaricatureRoom;
use super::brush::BrushTool;
use super::edits::Edits;
use super::evaluating::Sight;
use super::heat::{Heat, Painting};
use super::lasso::LassoTool;
use super::look::{Portrayal, Show};
use super::session::Session;
use super::stage::{self, BrushInHand, Stage, StageResponse};
use crate::studio::choose::takes_drops;
use crate::studio::keys::caricature::COMPARE;
use crate::studio::room::Shared;
use crate::studio::{job, theme, viewport};
use crate::work::{Error, Quantity};

impl CaricatureRoom {
    /// Draws it.
    pub(super) fn center(&mut self, ui: &mut Ui, shared: &mut Shared<'_>, edits: &mut Edits) {
        let stage_fill = egui::Frame::new().fill(theme::palette(ui).stage);
        egui::CentralPanel::default().frame(stage_fill).show(ui, |ui| {
            if let Some(loading) = &self.loading {
                egui::Panel::bottom("loading").resizable(false).show(ui, |ui| {
                    ui.add_space(theme::GAP_SMALL);
                    job::show_progress(ui, loading);
                    ui.add_space(theme::GAP_SMALL);
                });
            }
            self.export.progress(ui);
            self.toolbar(ui, shared);
            // What is open is about to be replaced: no edit may be lost in between.
            if self.loading.is_some() {
                // A lost device takes the preview with it.
                if let Some(preview) = &mut self.preview
                    && let Err(why) = preview.show(ui, self.look, shared)
                {
                    shared.notices.failed(why);
                }
                return;
            }
            let (Some(session), Some(stage)) = (&mut self.session, &mut self.stage) else {
                return nothing_open(ui);
            };
            stage.stand(session.stands());
            // Thumbnails wait until no button is pressed.
            if !ui.input(|input| input.pointer.any_down()) {
                match self.thumbnails.update(shared.screen, stage, session) {
                    Ok(true) => shared.ctx.request_repaint(),
                    Ok(false) => {}
                    Err(error) => shared.notices.failed(error),
                }
            }
            let painting = if self.brush.smoothed { Painting::Smoothed } else { Painting::Raw };
            self.heat.paint(self.brush.active.then_some(painting));
            let mut limbs = None;
            if self.brush.active && self.brush.limbs.active {
                let (body, mesh) = (session.stack.body(), &session.subject.mesh);
                match self.limbs.of(body, mesh, self.brush.limbs.level, ui.ctx()) {
                    Ok(found) => limbs = found,
                    Err(why) => shared.notices.failed(why),
                }
            }
            self.brush.limbs.searching = self.limbs.is_searching();
            self.heat.point(limbs.as_deref().map(|limbs| self.brush.limbs.shown(limbs)));
            match self.gallery.show(ui, session, self.look, shared, edits) {
                Ok(true) => return,
                Ok(false) => {}
                Err(why) => return shared.notices.failed(why),
            }
            self.picking.take_if(|picking| !picking.belongs_to(session));
            if let Some(picking) = &mut self.picking {
                let confidence = self.heat.quantity() == Quantity::Confidence;
                if let Err(why) = picking.show(ui, session, edits, (self.look, confidence), shared) {
                    shared.notices.failed(why);
                    self.picking = None;
                }
                return;
            }
            if self.look.ink {
                egui::Panel::top("ink").resizable(false).show(ui, |ui| {
                    ui.add_space(2.0);
                    super::ink_panel::show(ui, &mut self.look.pen);
                    ui.add_space(2.0);
                });
            }
            // The toolbar or the layers may have chosen something else to be seen.
            let sight = Sight::of(session.selected, self.look);
            if let Err(why) = session.follow(&shared.ctx, sight, self.patience) {
                shared.notices.failed(why);
            }
            let shown =
                update_stage(session, stage, &mut self.heat, self.look, &mut self.stale).and_then(|()| {
                    let brush = (&mut self.brush, limbs.as_deref());
                    show_stage(ui, session, stage, brush, self.look, edits)
                });
            if let Err(why) = shown {
                shared.notices.failed(why);
            }
        });
    }
}

/// The hint where no shape is open.
fn nothing_open(ui: &mut Ui) {
    ui.centered_and_justified(|ui| {
        let hint = if takes_drops() {
            "Open a mesh or a project, or drop one here."
        } else {
            "Open a mesh or a project."
        };
        ui.label(RichText::new(hint).color(theme::palette(ui).weak));
    });
}

/// Copies the figures of a new evaluation to the stage, and paints what is shown.
pub(super) fn update_stage(
    session: &mut Session,
    stage: &mut Stage,
    heat: &mut Heat,
    look: Portrayal,
    stale: &mut bool,
) -> Result<(), Error> {
    if let Some(figures) = session.take_figures() {
        stage.take(figures)?;
        *stale = true;
    }
    if !std::mem::take(stale) && !heat.take_stale() {
        return Ok(());
    }
    stage.set_coating(heat.coating(session), look).map_err(Error::from)
}

fn show_stage(
    ui: &mut Ui,
    session: &mut Session,
    stage: &mut Stage,
    (brush, limbs): (&mut BrushTool, Option<&Limbs>),
    mut look: Portrayal,
    edits: &mut Edits,
) -> Result<(), Error> {
    let rect = viewport::whole_pixels(ui);
    if COMPARE.held(ui.ctx()) {
        look.show = Show::Original;
    }
    if brush.active {
        session.prepare_brush(ui.ctx());
    }
    let plane = session.known_mirror();
    let mirror = if brush.mirror { plane.flatten() } else { None };
    // One side of two is not painted while the plane between them is looked for.
    let waits = brush.mirror && plane.is_none();
    // Wholes need no ring but the smallest, which points at them.
    let radius = if brush.takes_wholes() { 0.005 } else { f64::from(brush.radius) };
    let surface = session.stack.surface();
    if !(brush.active && brush.lasso.active) {
        brush.lasso.let_go();
    }
    let held = Brush { radius, hardness: f64::from(brush.hardness), mirror };
    let in_hand = brush.active.then_some(BrushInHand { brush: held, surface });
    let StageResponse { response, presses, figure } = stage.show(ui, rect, look, in_hand)?;
    if let Some((layer, hand)) = session.selected.zip(in_hand).filter(|_| brush.lasso.active) {
        if !waits && let Some(line) = brush.lasso.follow(ui, &response) {
            let erase = brush.erase ^ ui.input(|input| input.modifiers.ctrl);
            let taken = stage.encircled(ui, rect, look.show, &line, hand);
            LassoTool::take(taken, brush.intensity, erase, layer, edits);
        }
    } else if let Some((layer, hand)) = session.selected.zip(in_hand) {
        if waits {
            return Ok(());
        }
        if let Some(limbs) = limbs
            && brush.limbs.point(presses.last(), &session.stack.body().triangles, limbs, mirror)
        {
            ui.ctx().request_repaint();
        }
        brush.paint(ui, &response, (&presses, hand), layer, limbs, edits);
    } else if response.clicked()
        && look.show == Show::Models
        && let Some(model) = figure.and_then(|figure| Model::ALL.get(figure.checked_sub(stage::MODELS)?))
        && let Some(layer) = session.selected
    {
        edits.set(layer, Property::Model(*model));
    }
    Ok(())
}
