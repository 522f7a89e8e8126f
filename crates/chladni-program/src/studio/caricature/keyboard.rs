//! Keys of this room.

use chladni_caricature::{Action, LayerId, MAX_MU, Model, PaintEdit, Property};
use egui::Context;

use super::edits::Edits;
use super::landmarks::Picking;
use super::look::Show;
use super::session::Session;
use super::{CaricatureRoom, as_far_as_it_goes, toggle_picking};
use crate::studio::keys::caricature::{
    ABOVE, ADD_MESH, BELOW, BRUSH, DELETE, DUPLICATE, ERASE, EXPORT, FIT, FURTHEST, GALLERY, HIDE, INK,
    INVERT, LANDMARKS, LARGER, LEAVE, LOWER, NEXT_MODEL, NEXT_SHOW, OPEN, RAISE, REDO, REDO_BY_Y, RENAME,
    SAVE, SAVE_AS, SMALLER, SOLO, STRONGER, UNDO, WEAKER, WIRE,
};
use crate::studio::room::Shared;

/// Presses that change μ by 1.
const MU_STEPS: f64 = 10.0;

impl CaricatureRoom {
    /// Does the actions of the pressed keys.
    pub(super) fn handle_keys(&mut self, shared: &mut Shared<'_>, edits: &mut Edits) {
        let ctx = shared.ctx.clone();
        self.file_keys(&ctx, shared);
        if self.session.is_none() || self.loading.is_some() {
            return;
        }
        // The gallery has keys of its own.
        if self.gallery.is_open() {
            return;
        }
        if GALLERY.pressed(&ctx) {
            self.gallery.open();
            return;
        }
        if REDO.pressed(&ctx) || REDO_BY_Y.pressed(&ctx) {
            self.travel(false);
        } else if UNDO.pressed(&ctx) {
            self.travel(true);
        }
        let Some(session) = &mut self.session else { return };
        if let Some(id) = session.selected {
            if DUPLICATE.pressed(&ctx) {
                self.layers.commit(edits);
                edits.once(Action::Duplicate(id));
            }
            layer_keys(&ctx, session, id, edits);
            if FURTHEST.pressed(&ctx) {
                as_far_as_it_goes(session, self.controls.may_fold(), edits, shared);
            }
        }
        self.stale |= list_keys(&ctx, session, edits);
        if let Some((id, layer)) = session.chosen()
            && RENAME.pressed(&ctx)
        {
            self.layers.rename(id, &layer);
        }
        self.brush_keys(&ctx);
        self.look_keys(&ctx);
        if LANDMARKS.pressed(&ctx)
            && let Some(session) = &mut self.session
        {
            toggle_picking(&mut self.picking, session, shared);
        }
        if (self.picking.is_some() || self.brush.active) && LEAVE.pressed(&ctx) {
            self.brush.active = false;
            if !self.picking.as_mut().is_some_and(Picking::drop_pending) {
                self.picking = None;
            }
        }
        if ADD_MESH.pressed(&ctx) {
            self.choose_template(shared);
        }
    }

    fn file_keys(&mut self, ctx: &Context, shared: &mut Shared<'_>) {
        if OPEN.pressed(ctx) {
            self.end_renaming(shared);
            self.choose_file(shared);
        }
        // The longer chord first: egui matches Ctrl+S inside Ctrl+Shift+S.
        if SAVE_AS.pressed(ctx) {
            self.save(true, shared);
        } else if SAVE.pressed(ctx) {
            self.save(false, shared);
        }
        if EXPORT.pressed(ctx) {
            self.end_renaming(shared);
            self.export();
        }
    }

    fn brush_keys(&mut self, ctx: &Context) {
        if BRUSH.pressed(ctx) {
            self.brush.active = !self.brush.active;
        }
        if ERASE.pressed(ctx) {
            self.brush.erase = !self.brush.erase;
        }
        if SMALLER.pressed(ctx) {
            self.brush.resize(1.0 / 1.15);
        }
        if LARGER.pressed(ctx) {
            self.brush.resize(1.15);
        }
    }

    fn look_keys(&mut self, ctx: &Context) {
        if NEXT_SHOW.pressed(ctx) {
            self.look.show = match self.look.show {
                Show::Result => Show::Models,
                Show::Models => Show::BeforeAfter,
                Show::BeforeAfter => Show::Template,
                Show::Template | Show::Original => Show::Result,
            };
            self.stale = true;
        }
        if self.picking.is_none()
            && FIT.pressed(ctx)
            && let Some(stage) = &mut self.stage
        {
            stage.fit();
        }
        if WIRE.pressed(ctx) {
            self.look.wire = !self.look.wire;
        }
        if INK.pressed(ctx) {
            self.look.ink = !self.look.ink;
        }
    }
}

/// The keys that move the selected layer in the list, and those that select the one above or below; true where another one
/// is selected.
fn list_keys(ctx: &Context, session: &mut Session, edits: &mut Edits) -> bool {
    let place = session.project().layers().iter().position(|(id, _)| Some(*id) == session.selected);
    let last = session.project().layers().len().saturating_sub(1);
    for (shortcut, step) in [(RAISE, 1), (LOWER, -1)] {
        let next = place.and_then(|place| place.checked_add_signed(step)).filter(|&next| next <= last);
        if shortcut.pressed(ctx)
            && let (Some(layer), Some(index)) = (session.selected, next)
        {
            edits.once(Action::Move { layer, index });
        }
    }
    let mut moved = false;
    for (shortcut, step) in [(ABOVE, 1), (BELOW, -1)] {
        let next = place.and_then(|place| place.checked_add_signed(step));
        if shortcut.pressed(ctx)
            && let Some((id, _)) = next.and_then(|next| session.project().layers().get(next))
        {
            session.selected = Some(*id);
            moved = true;
        }
    }
    moved
}

/// The keys that change one layer.
fn layer_keys(ctx: &Context, session: &Session, id: LayerId, edits: &mut Edits) {
    let Some(layer) = session.project().layer(id) else { return };
    if DELETE.pressed(ctx) {
        edits.once(Action::Remove(id));
    }
    if HIDE.pressed(ctx) {
        edits.set(id, Property::Enabled(!layer.enabled));
    }
    if SOLO.pressed(ctx) {
        edits.set(id, Property::Solo(!layer.solo));
    }
    if NEXT_MODEL.pressed(ctx) {
        let place = Model::ALL.iter().position(|model| *model == layer.model).unwrap_or(0);
        edits.set(id, Property::Model(Model::ALL[(place + 1) % Model::ALL.len()]));
    }
    for (shortcut, step) in [(STRONGER, -1.0), (WEAKER, 1.0)] {
        if shortcut.pressed(ctx) {
            // Steps end on round numbers.
            let mu = (layer.mu * MU_STEPS + step).round() / MU_STEPS;
            edits.set(id, Property::Mu(mu.clamp(-MAX_MU, MAX_MU)));
        }
    }
    if INVERT.pressed(ctx) {
        edits.once(Action::Paint { layer: id, edit: PaintEdit::Invert });
    }
}
