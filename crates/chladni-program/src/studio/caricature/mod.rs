//! The caricature room: layers on the left, the shape in the middle, controls on the right.

mod analytic;
mod autosave;
mod brush;
mod center;
mod controls;
mod crossings;
mod curve;
mod edits;
mod evaluating;
mod export;
mod files;
mod footer;
mod gallery;
mod head_sliders;
mod health;
mod heat;
mod ink_panel;
mod keyboard;
mod landmarks;
mod lasso;
mod layers;
mod limb_tool;
mod loading;
mod look;
mod mask_menu;
mod matches;
mod moved;
mod named_parts;
mod overlay;
mod preview;
mod recover;
mod rehearsal;
mod session;
mod shelf;
mod shot;
mod stage;
mod thumbnails;
mod toolbar;

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use chladni_caricature::{Property, Recovered};
use chladni_mesh::surface::vec3::single;
use egui::Ui;

pub use self::evaluating::PATIENCE;
pub use self::rehearsal::Rehearsal;

use self::autosave::Autosave;
use self::brush::{BrushTool, one_way};
use self::controls::{Controls, Measured, Wish};
use self::edits::{Edit, Edits};
use self::evaluating::Sight;
use self::export::Export;
use self::files::Arranged;
use self::gallery::ShapesGallery;
use self::health::Health;
use self::heat::Heat;
use self::landmarks::Picking;
use self::layers::LayerList;
use self::limb_tool::KnownLimbs;
use self::loading::{Candidate, Loaded};
use self::look::Portrayal;
use self::preview::Preview;
use self::recover::Offer;
use self::session::Session;
use self::stage::Stage;
use self::thumbnails::Thumbnails;
use super::dropping::named;
use super::icon::Icon;
use super::job::Job;
use super::room::{Room, Shared};
use super::shortcut::Shortcut;
use super::{keys, theme};
use crate::work::formats::{MESHES, PROJECT, opened_together};
use crate::work::{Error, Quantity, shown_name};

/// The room: at most one open project.
#[derive(Default)]
pub struct CaricatureRoom {
    loading: Option<Job<Loaded>>,
    /// The shape that is being loaded, to be seen before its harmonics are there.
    preview: Option<Preview>,
    session: Option<Session>,
    /// What was found in the file of its shape.
    health: Health,
    /// Waits until the user has decided about unsaved work.
    candidate: Option<Candidate>,
    export: Export,
    offer: Offer,
    /// A recovery copy whose project is open; dropped as soon as our own copy is on the disk.
    adopting: Option<Recovered>,
    /// `None` until it is needed; an error where it cannot be.
    autosave: Option<Result<Autosave, ()>>,
    stage: Option<Stage>,
    layers: LayerList,
    thumbnails: Thumbnails,
    controls: Controls,
    /// Meshes that become layers as soon as the shape being loaded is there.
    templates: Vec<PathBuf>,
    brush: BrushTool,
    limbs: KnownLimbs,
    /// Landmarks of the selected layer are picked.
    picking: Option<Picking>,
    /// Twelve caricatures to choose from stand in the place of the shape.
    gallery: ShapesGallery,
    heat: Heat,
    look: Portrayal,
    /// What colors the shape may have changed.
    stale: bool,
    /// How long a frame waits for the newest evaluation.
    patience: Duration,
    /// Opening failed: do not open the sample automatically.
    refused: bool,
    /// The shape that is open, or being opened, is the sample that nobody asked for.
    unasked: bool,
}

impl Room for CaricatureRoom {
    fn name(&self) -> &'static str {
        "Caricature"
    }

    fn icon(&self) -> Icon {
        Icon::Drama
    }

    fn invitation(&self) -> &'static str {
        "Exaggerate what makes a shape itself: paint a nose, bend a curve, stack the layers."
    }

    fn shortcuts(&self) -> &'static [Shortcut] {
        if self.gallery.is_open() { keys::breeding::ALL } else { keys::caricature::ALL }
    }

    fn show(&mut self, ui: &mut Ui, shared: &mut Shared<'_>) {
        if self.session.is_none() && self.loading.is_none() && !self.refused {
            self.open_sample("head", shared);
            self.unasked = true;
        }
        self.poll(shared);
        let mut edits = Edits::default();
        let before = self.tools();
        self.handle_keys(shared, &mut edits);
        self.follow(shared);
        self.panels(ui, shared, &mut edits);
        // A click in the toolbar may end a name that was being written, and save it or take it back. A drag can wait until
        // the frame is drawn.
        if !shared.ctx.input(|input| input.pointer.any_down()) {
            self.carry_out(edits.take(), shared);
        }
        self.center(ui, shared, &mut edits);
        self.show_export(ui, shared);
        self.keep_one_tool(before);
        self.carry_out(edits.take(), shared);
        if let Some(session) = &mut self.session {
            // It is evaluated while this frame is brought to the screen.
            session.hand_over(&shared.ctx, Sight::of(session.selected, self.look));
        }
    }

    fn open(&mut self, paths: &[PathBuf], shared: &mut Shared<'_>) {
        self.open_together(paths, false, shared);
    }

    fn open_anew(&mut self, paths: &[PathBuf], shared: &mut Shared<'_>) {
        self.open_together(paths, true, shared);
    }

    fn drop_does(&self, paths: &[PathBuf], anew: bool) -> Option<String> {
        let Arranged { opened, templates, .. } = self.arranged(opened_together(paths).0, anew);
        match (opened, named(&templates)) {
            (Some(path), None) => Some(format!("Open {}", shown_name(&path))),
            (Some(path), Some(with)) => {
                Some(format!("Open {}, and compare it with {with}", shown_name(&path)))
            }
            (None, with) => Some(format!("Compare with {}", with?)),
        }
    }

    fn extensions(&self) -> Vec<&'static str> {
        [PROJECT].into_iter().chain(MESHES).collect()
    }

    fn show_over(&mut self, shared: &mut Shared<'_>) {
        // Also where the tool that began a drag was put away, or a key has led to another room.
        if shared.ctx.input(|input| input.pointer.any_released())
            && let Some(session) = &mut self.session
        {
            session.history.finish();
        }
        // A window that closes waits for it, whichever room is on screen.
        self.export.poll(shared);
        self.keep_copy(shared);
        self.ask_to_replace(shared);
    }

    fn recovers(&mut self, shared: &mut Shared<'_>) -> bool {
        self.offer_recovery(shared)
    }

    fn unsaved(&self) -> Option<String> {
        let session = self.session.as_ref().filter(|_| self.has_unsaved_work());
        session.map(|session| format!("The caricature “{}” has changes that are not saved.", session.name()))
    }

    fn being_made(&self) -> Option<&str> {
        self.export.unfinished()
    }

    fn save_all(&mut self, shared: &mut Shared<'_>) -> bool {
        self.end_renaming(shared);
        !self.has_unsaved_work() || self.save(false, shared)
    }

    fn change_device(&mut self, shared: &mut Shared<'_>) {
        (self.preview, self.thumbnails, self.stale) = (None, Thumbnails::default(), true);
        self.gallery.change_device();
        if let Some(session) = &mut self.session {
            // The context that it would wake is gone.
            session.evaluate_anew();
        }
        let stage = self.stage.take().map(|stage| stage.on(shared.screen));
        match stage.transpose() {
            Ok(stage) => self.stage = stage,
            Err(error) => shared.notices.failed(error),
        }
        // Only half a pair is lost; complete landmarks are in the project.
        if self.picking.take().is_some()
            && let Some(session) = &mut self.session
        {
            toggle_picking(&mut self.picking, session, shared);
        }
    }

    fn interrupt(&mut self, shared: &mut Shared<'_>) {
        if let Some(Ok(autosave)) = &mut self.autosave {
            autosave.hurry();
        }
        self.keep_copy(shared);
        // Dropping the autosave writes its last copy to disk and keeps the file.
        self.autosave = Some(Err(()));
    }

    fn leave(&mut self) {
        self.export.stop();
        if let Some(Ok(autosave)) = self.autosave.take() {
            autosave.finish();
        }
    }
}

impl CaricatureRoom {
    /// A room whose frames wait this long for what their edits make.
    pub fn waiting(patience: Duration) -> Self {
        Self { patience, ..Self::default() }
    }

    /// Whether the brush, the picking of landmarks and the gallery have the stage.
    fn tools(&self) -> [bool; 3] {
        [self.brush.active, self.picking.is_some(), self.gallery.is_open()]
    }

    /// The tool that was taken up since `before` ends the others: a click on the stage can mean only one thing.
    fn keep_one_tool(&mut self, before: [bool; 3]) {
        let [paints, picks, breeds] = one_way(before, self.tools());
        self.brush.active = paints;
        self.picking.take_if(|_| !picks);
        if self.gallery.is_open() && !breeds {
            self.gallery.close();
        }
    }

    /// Does what panels and tools have asked for.
    fn carry_out(&mut self, requests: Vec<Edit>, shared: &mut Shared<'_>) {
        let Some(session) = &mut self.session else { return };
        match session.apply(requests) {
            Ok(changed) => self.stale |= changed,
            Err(why) => {
                self.stale = true;
                shared.notices.failed(why);
            }
        }
    }

    /// Gives a layer the name that is being typed, before it is saved or left by a key.
    fn end_renaming(&mut self, shared: &mut Shared<'_>) {
        let mut edits = Edits::default();
        self.layers.commit(&mut edits);
        self.carry_out(edits.take(), shared);
    }

    /// Takes the results of finished jobs.
    fn poll(&mut self, shared: &mut Shared<'_>) {
        if let Some(loaded) = self.loading.as_ref().and_then(Job::ended) {
            (self.loading, self.preview) = (None, None);
            let templates = std::mem::take(&mut self.templates);
            match loaded.and_then(|loaded| self.take_in(loaded, shared)) {
                Ok(()) => templates.into_iter().for_each(|path| self.add_template(path, shared)),
                Err(why) => self.fall_back(why, shared),
            }
        }
        if let Some(session) = &mut self.session {
            let before = session.solved_harmonics();
            match session.pump_harmonics(&shared.ctx) {
                Ok(None) => {}
                Ok(Some(warnings)) => {
                    self.stale = true;
                    // One that was solved is one for shapes opened later, too.
                    if session.solved_harmonics() != before {
                        shared.settings.harmonics = session.solved_harmonics();
                    }
                    warnings.into_iter().for_each(|warning| shared.notices.warn(warning));
                }
                Err(why) => shared.notices.failed(why),
            }
            let (message, changed) = session.pump_matches(&shared.ctx);
            if let Some(message) = message {
                shared.notices.warn(message);
            }
            self.stale |= changed;
        }
        if let Err(why) = self.health.poll() {
            shared.notices.failed(why);
        }
    }

    /// Shows the document as it is now, and finds what can be found while the hand rests.
    fn follow(&mut self, shared: &mut Shared<'_>) {
        if let Some(session) = &mut self.session {
            let sight = Sight::of(session.selected, self.look);
            if let Err(why) = session.follow(&shared.ctx, sight, self.patience) {
                shared.notices.failed(why);
            }
            let resting = !shared.ctx.input(|input| input.pointer.any_down());
            self.stale |= session.pump_keeping(&shared.ctx, resting);
            match session.pump_crossings(&shared.ctx, resting) {
                Ok(new) => self.stale |= new && self.heat.quantity() == Quantity::Crossings,
                Err(why) => shared.notices.failed(why),
            }
        }
    }

    /// Replaces the open project with the loaded one; on an error it stays as it is.
    fn take_in(&mut self, mut loaded: Loaded, shared: &mut Shared<'_>) -> Result<(), Error> {
        for warning in &loaded.warnings {
            shared.notices.warn(warning.clone());
        }
        let recovered = loaded.recovered.take();
        let (look, is_carried) = (loaded.look.take(), loaded.is_carried);
        let opened = loaded.path.as_deref().or(loaded.project.shape.file()).map(Path::to_owned);
        let unexamined = std::mem::take(&mut loaded.unexamined);
        let session = Session::new(loaded);
        let body = session.stack.body();
        let positions = single(&body.positions);
        let stage = Stage::new(shared.screen, &positions, &body.triangles, look)?;
        self.heat.start(stage.has_own_look());
        self.thumbnails.clear();
        // Layers of another project, or of this one on another shape, may have the same names.
        (self.picking, self.layers, self.limbs) = (None, LayerList::default(), KnownLimbs::default());
        self.gallery = ShapesGallery::default();
        self.controls.named.forget();
        self.stage = Some(stage);
        self.health = unexamined.begin(&shared.ctx);
        let earlier = self.session.replace(session);
        self.unasked &= earlier.is_none();
        if is_carried {
            let stays = earlier.and_then(|earlier| earlier.path).map_or_else(String::new, |path| {
                format!(" The earlier project stays as it was saved in {}.", path.display())
            });
            shared.notices.done(format!("The layers begin a new history on this shape.{stays}"));
        }
        self.stale = true;
        if let Some(Ok(autosave)) = &mut self.autosave {
            autosave.forget();
        }
        self.adopting = recovered;
        shared.notices.outdate_errors();
        if let Some(path) = opened {
            shared.settings.remember(&path);
        }
        self.picture_new_shape(shared);
        Ok(())
    }

    fn panels(&mut self, ui: &mut Ui, shared: &mut Shared<'_>, edits: &mut Edits) {
        // The project being loaded will replace the open one: no edit may be lost in between.
        let Some(session) = self.session.as_mut().filter(|_| self.loading.is_none()) else { return };
        let mut wants_mesh = false;
        egui::Panel::left("layers").resizable(false).exact_size(theme::PANEL_WIDTH - 40.0).show(ui, |ui| {
            egui::Panel::bottom("shape")
                .resizable(false)
                .show(ui, |ui| footer::show(ui, session, &self.health, edits));
            egui::ScrollArea::vertical().show(ui, |ui| {
                let mut selected = session.selected;
                let failed = session.failed_layers();
                self.layers.show(ui, session, &self.thumbnails, &failed, &mut selected, edits);
                if selected != session.selected {
                    session.selected = selected;
                    self.stale = true;
                    // A number that was being typed is one step, also where its field is gone.
                    edits.finish();
                }
                wants_mesh = self.layers.takes_mesh();
                ui.add_space(theme::GAP_LARGE);
                let (was, mut picking) = (self.picking.is_some(), self.picking.is_some());
                if matches::show(ui, session, &mut picking, edits, shared) {
                    self.heat.toggle(Quantity::Confidence);
                }
                if picking != was {
                    toggle_picking(&mut self.picking, session, shared);
                }
            });
        });
        egui::Panel::right("controls").resizable(false).exact_size(theme::PANEL_WIDTH).show(ui, |ui| {
            egui::ScrollArea::vertical().show(ui, |ui| {
                let Some((id, layer)) = session.chosen() else {
                    ui.add_space(theme::GAP_SMALL);
                    let hint = "The controls of the selected layer appear here.";
                    ui.label(egui::RichText::new(hint).color(theme::palette(ui).weak));
                    return;
                };
                let crossings = session.crossings.count(&session.shown.evaluation);
                let folds = session.folds_of(id).filter(|_| !session.failed_layers().contains(&id));
                let mirror = session.known_mirror();
                let kept = session.kept();
                let channels: Vec<String> = session.subject.mesh.channels().map(str::to_owned).collect();
                if self.controls.named.wants_search() {
                    self.controls.named.search(session, &shared.ctx);
                }
                let shown = Arc::clone(&session.shown);
                let spectrum = &shown.spectrum;
                let waits = session.is_waiting(id);
                let measured =
                    Measured { spectrum, mirror, folds, waits, crossings, kept, channels: &channels };
                // A number that is being typed never goes on in another layer.
                let wish = ui.push_id(id.0, |ui| {
                    self.controls.show(ui, id, &layer, &measured, &mut self.brush, edits)
                });
                match wish.inner {
                    Some(Wish::AsFarAsItGoes) => {
                        as_far_as_it_goes(session, self.controls.may_fold(), edits, shared);
                    }
                    Some(Wish::SeeWhere(quantity)) => self.heat.toggle(quantity),
                    Some(Wish::Mask(wish)) => {
                        if let Err(why) = mask_menu::fulfil(wish, id, session, edits, shared) {
                            shared.notices.failed(why);
                        }
                    }
                    None => {}
                }
            });
        });
        if wants_mesh {
            self.choose_template(shared);
        }
    }
}

/// Moves μ of the selected layer to where it folds no more than a share of the triangles.
fn as_far_as_it_goes(session: &mut Session, may_fold: f64, edits: &mut Edits, shared: &mut Shared<'_>) {
    if let Err(why) = session.catch_up(&shared.ctx) {
        return shared.notices.failed(why);
    }
    if let Some((_, layer)) = session.chosen()
        && layer.effective_mu() == 0.0
    {
        let why =
            "Nothing moves at a μ or strength of 0. Set both, μ a little to the side on which it is to grow.";
        return shared.notices.warn(why);
    }
    match (session.selected, session.furthest_mu(may_fold)) {
        (Some(layer), Some(mu)) => edits.set(layer, Property::Mu(mu)),
        _ => shared.notices.warn("This layer never folds in that direction, or does not act yet."),
    }
}

/// Opens or leaves the view of both shapes.
fn toggle_picking(picking: &mut Option<Picking>, session: &mut Session, shared: &mut Shared<'_>) {
    if picking.take().is_some() {
        return;
    }
    // Landmarks are vertices of the file as it is now.
    if let Some((_, layer)) = session.chosen() {
        matches::renew(session, &layer.template, shared);
    }
    match Picking::begin(session, shared) {
        Some(Ok(begun)) => *picking = Some(begun),
        Some(Err(why)) => shared.notices.failed(why),
        None => shared.notices.warn("Landmarks need a layer whose template is a mesh."),
    }
}
