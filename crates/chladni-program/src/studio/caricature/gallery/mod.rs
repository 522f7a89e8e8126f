//! The gallery of caricatures: twelve of the open shape, living, to be chosen from and bred.

use std::sync::Arc;

use chladni_caricature::{Group, Layer, Stack, Template, surprise};
use chladni_harmonics::Body;
use chladni_match::MatchSettings;
use chladni_task::Task;
use chladni_view::layout;
use egui::{RichText, Sense, Ui, vec2};

use super::edits::Edits;
use super::look::Portrayal;
use super::session::Session;
use crate::studio::author_id::AuthorId;
use crate::studio::icon::{self, Icon};
use crate::studio::job::{self, Job};
use crate::studio::keys::breeding::{
    BACK, BREED, LEAVE, MARK_ABOVE, MARK_BELOW, MARK_LEFT, MARK_RIGHT, SURPRISE,
};
use crate::studio::room::Shared;
use crate::studio::{theme, viewport};
use crate::work::{Aside, Error, Exhibition, FIRST_SEED, Step, hung, template_name};

mod cell;
mod of_shape;
mod wall;

pub use of_shape::ShapesGallery;

use cell::Wanted;
use of_shape::matched_template;
use wall::Wall;

/// A template that a gallery is given, and how it is matched.
type Given = (Template, MatchSettings);

/// The result of a job.
struct Brought {
    shown: Exhibition,
    /// Of one that was prepared: matches that the open project may use, too, and the template that it was given.
    prepared: Option<(Stack, Option<Given>)>,
}

/// The gallery in the place of the stage.
struct GalleryView {
    body: Arc<Body>,
    /// The renewals of templates when it was begun.
    renewals: usize,
    /// The template that it was given.
    given: Option<Given>,
    /// What was shown on other harmonics, until it is shown on these.
    before: Option<Exhibition>,
    work: Option<Job<Brought>>,
    taking: Option<Job<Vec<Layer>>>,
    shown: Option<Exhibition>,
    wall: Option<Wall>,
    marked: usize,
    seed: u64,
    /// How many surprises there were.
    surprises: u64,
}

impl GalleryView {
    /// Prepares the gallery of the open shape, with the generations of one `before` on other harmonics.
    fn begin(
        session: &Session,
        given: Option<Given>,
        before: Option<Exhibition>,
        ctx: &egui::Context,
    ) -> Self {
        Self {
            body: Arc::clone(session.stack.body()),
            renewals: session.renewals(),
            work: Some(prepare(session, given.clone(), before.clone(), ctx)),
            given,
            before,
            taking: None,
            shown: None,
            wall: None,
            marked: 0,
            seed: FIRST_SEED,
            surprises: 0,
        }
    }

    /// Whether it shows the shape of `session` with its harmonics and templates, or is about to.
    fn belongs_to(&self, session: &Session) -> bool {
        let is_same = Arc::ptr_eq(&self.body, session.stack.body()) && self.renewals == session.renewals();
        is_same && (self.shown.is_some() || self.work.is_some())
    }

    /// Draws it; false when it is to be left. A caricature that is taken becomes layers.
    fn show(
        &mut self,
        ui: &mut Ui,
        session: &mut Session,
        look: Portrayal,
        shared: &mut Shared<'_>,
        edits: &mut Edits,
    ) -> Result<bool, Error> {
        if let Some(brought) = self.work.as_ref().and_then(Job::ended) {
            self.work = None;
            match brought {
                Ok(Brought { shown, prepared }) => {
                    if let Some((stack, given)) = prepared {
                        session.learn(&stack);
                        (self.given, self.wall) = (given, None);
                    }
                    (self.shown, self.wall) = (Some(shown), self.wall.take().map(Wall::emptied));
                    self.before = None;
                }
                // The gallery on screen stays; a step that was cancelled needs no words.
                Err(why) if self.shown.is_some() && why.is_cancelled() => {}
                Err(why) if self.shown.is_some() => shared.notices.failed(why),
                Err(why) => return Err(why),
            }
        }
        if let Some(layers) = self.taking.as_ref().and_then(Job::ended) {
            self.taking = None;
            take(layers?, session, edits);
            return Ok(false);
        }
        if LEAVE.pressed(ui.ctx()) {
            return Ok(false);
        }
        if let Some(work) = &self.work {
            egui::Panel::bottom("gallery work").resizable(false).show(ui, |ui| job::show_progress(ui, work));
        }
        egui::Panel::top("gallery bar").resizable(false).show(ui, |ui| {
            ui.horizontal_wrapped(|ui| self.bar(ui, session));
        });
        if self.shown.is_none() {
            // Justified, two lines of words would be stretched from edge to edge.
            ui.add_space(0.4 * ui.available_height());
            egui::Frame::new().inner_margin(vec2(theme::GAP_LARGE, 0.0)).show(ui, |ui| {
                ui.vertical_centered(|ui| {
                    ui.label("Twelve caricatures appear here: click those that you like, then breed.")
                })
            });
            return Ok(true);
        }
        self.cells(ui, session, look, shared, edits)
    }

    /// The buttons above.
    fn bar(&mut self, ui: &mut Ui, session: &Session) {
        let ctx = ui.ctx().clone();
        let idle = self.work.is_none() && self.taking.is_none();
        let (chosen, first) = self.shown.as_ref().map_or((0, true), Exhibition::chosen);
        let name = if chosen == 0 { "Breed".into() } else { format!("Breed {chosen}") };
        let button = |ui: &mut Ui, mark: Icon, name: &str, tip: String, on: bool| {
            let on = on && idle;
            ui.add_enabled(on, egui::Button::new(icon::label(mark, name)))
                .on_hover_text(&tip)
                .on_disabled_hover_text(tip)
                .clicked()
        };
        let ready = self.shown.is_some();
        let tip = format!("{}: click at least one that you like", BREED.tooltip(&ctx));
        if button(ui, Icon::Heart, &name, tip, chosen > 0) || (chosen > 0 && idle && BREED.pressed(&ctx)) {
            self.start(Step::Breed, &ctx);
        }
        if button(ui, Icon::Undo2, "Back", BACK.tooltip(&ctx), ready && !first)
            || (ready && !first && idle && BACK.pressed(&ctx))
        {
            self.start(Step::Back, &ctx);
        }
        if button(ui, Icon::RefreshCw, "Others", "Twelve others; what is locked stays".into(), ready) {
            self.seed += 1;
            self.start(Step::Restart(self.seed), &ctx);
        }
        let tip = format!("{}: one random caricature, at once", SURPRISE.tooltip(&ctx));
        if button(ui, Icon::Dices, "Surprise me", tip, ready) || (ready && idle && SURPRISE.pressed(&ctx)) {
            self.surprise(&ctx);
        }
        let (given, project) = (matched_template(session), session.project());
        if let (Some((template, matching)), Some(shown)) = (&given, &self.shown)
            && !shown.sitter.compares_with(template, matching)
        {
            let name = format!("Against {}", template_name(template, project));
            let tip = "A new gallery, in which they are compared with the template of the topmost layer, too. \
                       The favorites of this one go.";
            if button(ui, Icon::GitCompareArrows, &name, tip.into(), true) {
                // This one stays until the new one is there: its template may not match.
                self.work = Some(prepare(session, given, None, &ctx));
                return;
            }
        }
        ui.separator();
        let mut taken = None;
        if let Some(shown) = &mut self.shown {
            ui.label(RichText::new(icon::text(Icon::Lock)).color(theme::palette(ui).weak));
            for group in Group::ALL {
                let locked = shown.gallery.is_locked(group);
                let tip = "Children have it from one parent unchanged";
                let button = egui::Button::selectable(locked, theme::capitalized(group.name()));
                let toggle = ui.add_enabled(idle, button).on_hover_text(tip);
                if toggle.author_id(format!("lock/{}", group.name())).clicked() {
                    shown.gallery.lock(group, !locked);
                }
            }
            if !shown.gallery.favorites().is_empty() {
                ui.menu_button(icon::label(Icon::Star, "Favorites"), |ui| {
                    for item in shown.gallery.favorites() {
                        if ui.button(shown.sitter.title(&item.genome)).clicked() {
                            taken = Some(item.genome.clone());
                        }
                    }
                });
            }
        }
        if let (Some(variant), Some(shown)) = (taken, &self.shown) {
            let sitter = Arc::clone(&shown.sitter);
            let work = move |_: &Task| Ok(sitter.portray_one(&variant)?.layers);
            self.taking = Some(Job::start("A favorite", &ctx, work));
        }
    }

    fn start(&mut self, step: Step, ctx: &egui::Context) {
        let Some(shown) = self.shown.clone() else { return };
        let work = move |task: &Task| after(shown, step, task);
        self.work = Some(Job::start("Breeding", ctx, work));
    }

    /// Begins with a random one, another each time.
    fn surprise(&mut self, ctx: &egui::Context) {
        let Some(shown) = &self.shown else { return };
        self.surprises += 1;
        let (sitter, seed) = (Arc::clone(&shown.sitter), self.seed ^ (self.surprises << 32));
        let work = move |_: &Task| Ok(surprise(seed, &sitter)?.1.layers);
        self.taking = Some(Job::start("A surprise", ctx, work));
    }

    /// Shows the twelve and handles clicks on them; false when one was taken.
    fn cells(
        &mut self,
        ui: &mut Ui,
        session: &Session,
        look: Portrayal,
        shared: &mut Shared<'_>,
        edits: &mut Edits,
    ) -> Result<bool, Error> {
        let rect = viewport::whole_pixels(ui);
        let Some(shown) = &mut self.shown else { return Ok(true) };
        let count = shown.portraits.len();
        let scale = ui.pixels_per_point();
        let canvas = viewport::area(ui, rect);
        let (rows, columns) = layout::rows_and_columns(canvas.width, canvas.height, count, 0.9);
        let cells = layout::grid(canvas, rows, columns, 2, count);
        let response = ui.allocate_rect(rect, Sense::click_and_drag());
        if self.wall.is_none() {
            self.wall = Some(Wall::new(shared.screen, shown, session)?);
        }
        let idle = self.work.is_none();
        let Some(wall) = &mut self.wall else { return Ok(true) };
        wall.stand(session.stands());
        wall.hang(shown);
        wall.show(ui, rect, &cells, &response, look)?;
        self.marked = marked_next(ui.ctx(), self.marked, columns, count);
        let (mut taken, mut changed) = (None, None);
        for (index, place) in cells.iter().enumerate() {
            let corner = rect.min + vec2(place.x as f32, place.y as f32) / scale;
            let size = vec2(place.width as f32, place.height as f32) / scale;
            let place = egui::Rect::from_min_size(corner, size);
            match cell::show(ui, place, index, &mut self.marked, shown, idle)? {
                Some(Wanted::Taken) => taken = Some(index),
                Some(Wanted::Changed) => changed = Some(index),
                None => {}
            }
        }
        if let Some(portrait) = taken.and_then(|index| shown.portraits.get(index)) {
            take(portrait.layers.clone(), session, edits);
            return Ok(false);
        }
        if let Some(index) = changed {
            self.start(Step::Change(index), ui.ctx());
        }
        Ok(true)
    }
}

/// Begins to prepare the gallery of the open shape, with the generations of one `before` on other harmonics.
fn prepare(
    session: &Session,
    given: Option<Given>,
    before: Option<Exhibition>,
    ctx: &egui::Context,
) -> Job<Brought> {
    let mesh = Arc::clone(&session.subject.mesh);
    let stack = session.stack.with_harmonics_of(Arc::clone(session.stack.body()));
    Job::start("Preparing the gallery", ctx, move |task: &Task| {
        let (mut stack, aside) = (stack?, Aside::new(task));
        let shown = Exhibition::open(before.as_ref(), &mesh, &mut stack, given.clone(), &aside)?;
        Ok(Brought { shown, prepared: Some((stack, given)) })
    })
}

/// The gallery after a step, unless that was cancelled meanwhile.
fn after(shown: Exhibition, step: Step, task: &Task) -> Result<Brought, Error> {
    let shown = shown.after(step)?;
    task.check()?;
    Ok(Brought { shown, prepared: None })
}

/// The one that is marked once the keys for it were heard.
fn marked_next(ctx: &egui::Context, mut marked: usize, columns: usize, count: usize) -> usize {
    let step = |right: isize, down: isize| right + down * columns as isize;
    for (key, by) in [
        (MARK_LEFT, step(-1, 0)),
        (MARK_RIGHT, step(1, 0)),
        (MARK_ABOVE, step(0, -1)),
        (MARK_BELOW, step(0, 1)),
    ] {
        if key.pressed(ctx) {
            marked = marked.checked_add_signed(by).filter(|next| *next < count).unwrap_or(marked);
        }
    }
    marked
}

/// Adds the layers of a caricature on top, as one step of the history.
fn take(layers: Vec<Layer>, session: &Session, edits: &mut Edits) {
    edits.together(hung(session.project(), layers));
}

#[cfg(test)]
mod tests {
    use super::*;
    use chladni_harmonics::BasisSettings;

    #[test]
    fn a_step_that_was_cancelled_brings_nothing() {
        let (mesh, task) = (chladni_mesh::samples::icosphere(3), Task::new());
        let body = Body::build(&mesh, &BasisSettings::new(20), &task).unwrap();
        let mut stack = Stack::new(Arc::new(body)).unwrap();
        let shown = Exhibition::open(None, &mesh, &mut stack, None, &Aside::new(&task)).unwrap();
        assert!(after(shown.clone(), Step::Restart(2), &task).is_ok());
        task.cancel();
        assert!(after(shown, Step::Restart(2), &task).is_err_and(|why| why.is_cancelled()));
    }
}
