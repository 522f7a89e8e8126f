//! The caricature room: layers on the left, the shape in the middle, controls on the right.

mod brush;
mod controls;
mod curve;
mod edits;
mod export;
mod heat;
mod layers;
mod matches;
mod session;
mod stage;
mod toolbar;

use std::path::PathBuf;

use chladni_caricature::{Action, Layer, LayerId, Model, Project, Property, ShapeSource, Template};
use eframe::egui_wgpu::RenderState;
use egui::{Key, Ui};

pub use self::export::MESHES;

use self::brush::BrushTool;
use self::controls::{Controls, Measured, Wish};
use self::edits::Edits;
use self::heat::Heat;
use self::layers::LayerList;
use self::session::{Loaded, Session};
use self::stage::{Look, Show, Stage};
use super::icon::Icon;
use super::job::{self, Job, Outcome};
use super::room::{Room, Shared};
use super::shortcut::Shortcut;
use super::theme;

const OPEN: Shortcut = Shortcut::command(Key::O, "Open a mesh or project");
const SAVE: Shortcut = Shortcut::command(Key::S, "Save the project");
const SAVE_AS: Shortcut = Shortcut::command_shift(Key::S, "Save under another name");
const EXPORT: Shortcut = Shortcut::command(Key::E, "Export");
const UNDO: Shortcut = Shortcut::command(Key::Z, "Undo");
const REDO: Shortcut = Shortcut::command_shift(Key::Z, "Redo");
const DUPLICATE: Shortcut = Shortcut::command(Key::D, "Duplicate the layer");
const DELETE: Shortcut = Shortcut::key(Key::Delete, "Delete the layer");
const BRUSH: Shortcut = Shortcut::key(Key::B, "Paint the region");
const ERASE: Shortcut = Shortcut::key(Key::X, "Paint or erase");
const SMALLER: Shortcut = Shortcut::key(Key::OpenBracket, "Smaller brush");
const LARGER: Shortcut = Shortcut::key(Key::CloseBracket, "Larger brush");
const COMPARE: Shortcut = Shortcut::key(Key::C, "Hold to see the original");
const NEXT_SHOW: Shortcut = Shortcut::key(Key::V, "Result, three models, before and after");
const WIRE: Shortcut = Shortcut::key(Key::W, "Edges of triangles");
const KEYS: [Shortcut; 20] = [
    OPEN,
    SAVE,
    SAVE_AS,
    EXPORT,
    UNDO,
    REDO,
    DUPLICATE,
    DELETE,
    BRUSH,
    ERASE,
    SMALLER,
    LARGER,
    COMPARE,
    NEXT_SHOW,
    WIRE,
    super::viewport::VIEW_KEYS[0],
    super::viewport::VIEW_KEYS[1],
    super::viewport::VIEW_KEYS[2],
    super::viewport::VIEW_KEYS[3],
    super::viewport::VIEW_KEYS[4],
];

/// The room: at most one open project.
#[derive(Default)]
pub struct CaricatureRoom {
    loading: Option<Job<Result<Loaded, String>>>,
    session: Option<Session>,
    stage: Option<Stage>,
    layers: LayerList,
    controls: Controls,
    brush: BrushTool,
    heat: Heat,
    look: Look,
    stale: bool,
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
        &KEYS
    }

    fn show(&mut self, ui: &mut Ui, shared: &mut Shared<'_>) {
        if self.session.is_none() && self.loading.is_none() {
            self.open_sample(shared);
        }
        self.poll(shared);
        self.handle_keys(shared);
        let mut edits = Edits::default();
        self.panels(ui, shared, &mut edits);
        self.center(ui, shared, &mut edits);
        let requests = edits.take();
        if let Some(session) = &mut self.session {
            match session.apply(requests) {
                Ok(changed) => self.stale |= changed,
                Err(why) => shared.notices.error(why),
            }
        }
    }

    fn open(&mut self, paths: &[PathBuf], shared: &mut Shared<'_>) {
        for path in paths {
            let project = path.extension().is_some_and(|extension| extension == "chladni");
            // The first mesh is the shape; the next ones are templates for it.
            match (&self.session, project) {
                (Some(_), false) if paths.len() == 1 || Some(path) != paths.first() => {
                    self.add_template(path.clone(), shared)
                }
                _ => self.load(path.clone(), project, shared),
            }
            shared.settings.remember(path);
        }
    }

    fn unsaved(&self) -> Option<String> {
        let session = self.session.as_ref()?;
        (session.history.is_modified() && !session.project().layers().is_empty())
            .then(|| format!("The caricature “{}” has changes that are not saved.", session.name()))
    }
}

impl CaricatureRoom {
    fn open_sample(&mut self, shared: &mut Shared<'_>) {
        let mut project = Project::new(ShapeSource::Sample("head".into()), shared.settings.harmonics);
        let mut first = Layer::new("Character", Template::Sample("template".into()));
        first.mu = -0.8;
        if let Err(error) = project.push(first) {
            shared.notices.error(error.to_string());
        }
        self.start(project, None, shared);
    }

    fn load(&mut self, path: PathBuf, project: bool, shared: &mut Shared<'_>) {
        if project {
            match Project::load(&path) {
                Ok(project) => self.start(project, Some(path), shared),
                Err(error) => shared.notices.error(error.to_string()),
            }
        } else {
            let project = Project::new(ShapeSource::File(path), shared.settings.harmonics);
            self.start(project, None, shared);
        }
    }

    fn start(&mut self, project: Project, path: Option<PathBuf>, shared: &Shared<'_>) {
        let label = format!("Opening {}", project.shape);
        self.loading = Some(Job::start(label, &shared.ctx, move |task| session::load(project, path, task)));
    }

    fn add_template(&mut self, path: PathBuf, shared: &mut Shared<'_>) {
        let Some(session) = &mut self.session else { return };
        let name =
            path.file_stem().map_or_else(|| "Template".into(), |stem| stem.to_string_lossy().into_owned());
        let index = session.project().layers().len();
        let layer = Box::new(Layer::new(name, Template::File(path)));
        match session.apply(vec![edits::Edit::Once(Action::Add { index, layer })]) {
            Ok(changed) => self.stale |= changed,
            Err(why) => shared.notices.error(why),
        }
    }

    /// Takes in what jobs have finished.
    fn poll(&mut self, shared: &mut Shared<'_>) {
        let outcome = self.loading.as_ref().map(Job::poll);
        match outcome {
            Some(Outcome::Done(Ok(loaded))) => {
                self.loading = None;
                self.take_in(loaded, shared);
            }
            Some(Outcome::Done(Err(why))) => {
                self.loading = None;
                shared.notices.error(why);
            }
            Some(Outcome::Lost) => {
                self.loading = None;
                shared.notices.error("Opening broke off; this is a bug.");
            }
            Some(Outcome::Running) | None => {}
        }
        if let Some(session) = &mut self.session {
            let (message, changed) = session.pump_matches(&shared.ctx);
            if let Some(message) = message {
                shared.notices.warn(message);
            }
            self.stale |= changed;
        }
    }

    fn take_in(&mut self, loaded: Loaded, shared: &mut Shared<'_>) {
        for warning in &loaded.warnings {
            shared.notices.warn(warning.clone());
        }
        if let Some(warning) = &loaded.report.cache_warning {
            shared.notices.warn(warning.clone());
        }
        let session = match Session::new(loaded) {
            Ok(session) => session,
            Err(why) => return shared.notices.error(why),
        };
        let positions = single(&session.stack.body().positions);
        match Stage::new(shared.gpu, &positions, &session.stack.body().triangles) {
            Ok(stage) => {
                self.stage = Some(stage);
                self.session = Some(session);
                self.stale = true;
            }
            Err(error) => shared.notices.error(error.to_string()),
        }
    }

    fn handle_keys(&mut self, shared: &mut Shared<'_>) {
        let ctx = shared.ctx.clone();
        if OPEN.pressed(&ctx) {
            self.choose_file(shared);
        }
        // The longer chord first: egui matches Ctrl+S inside Ctrl+Shift+S.
        if SAVE_AS.pressed(&ctx) {
            self.save(true, shared);
        } else if SAVE.pressed(&ctx) {
            self.save(false, shared);
        }
        if EXPORT.pressed(&ctx) {
            self.export(shared);
        }
        let Some(session) = &mut self.session else { return };
        if REDO.pressed(&ctx) {
            self.stale |= session.travel(false).is_some();
        } else if UNDO.pressed(&ctx) {
            self.stale |= session.travel(true).is_some();
        }
        let selected = session.selected;
        let mut act = |shortcut: Shortcut, action: fn(LayerId) -> Action| {
            if let Some(layer) = selected.filter(|_| shortcut.pressed(&ctx)) {
                match session.apply(vec![edits::Edit::Once(action(layer))]) {
                    Ok(changed) => self.stale |= changed,
                    Err(why) => shared.notices.error(why),
                }
            }
        };
        act(DUPLICATE, Action::Duplicate);
        act(DELETE, Action::Remove);
        if BRUSH.pressed(&ctx) {
            self.brush.active = !self.brush.active;
        }
        if ERASE.pressed(&ctx) {
            self.brush.erase = !self.brush.erase;
        }
        if SMALLER.pressed(&ctx) {
            self.brush.resize(1.0 / 1.15);
        }
        if LARGER.pressed(&ctx) {
            self.brush.resize(1.15);
        }
        if NEXT_SHOW.pressed(&ctx) {
            self.look.show = match self.look.show {
                Show::Result => Show::Models,
                Show::Models => Show::BeforeAfter,
                Show::BeforeAfter | Show::Original => Show::Result,
            };
            self.stale = true;
        }
        if WIRE.pressed(&ctx) {
            self.look.wire = !self.look.wire;
        }
    }

    fn panels(&mut self, ui: &mut Ui, shared: &mut Shared<'_>, edits: &mut Edits) {
        let Some(session) = &mut self.session else { return };
        egui::Panel::left("layers").exact_size(theme::PANEL_WIDTH - 40.0).show(ui, |ui| {
            egui::ScrollArea::vertical().show(ui, |ui| {
                let mut selected = session.selected;
                self.layers.show(ui, session.project(), &mut selected, edits);
                if selected != session.selected {
                    session.selected = selected;
                    self.stale = true;
                }
                ui.add_space(theme::GAP_LARGE);
                matches::show(ui, session, edits, shared);
            });
        });
        egui::Panel::right("controls").exact_size(theme::PANEL_WIDTH).show(ui, |ui| {
            egui::ScrollArea::vertical().show(ui, |ui| {
                let Some((id, layer)) =
                    session.selected.and_then(|id| Some((id, session.project().layer(id)?.clone())))
                else {
                    ui.label("Add a layer to see its controls.");
                    return;
                };
                let spectrum = heat::spectrum(session);
                let harmonics = session.stack.body().basis.harmonics();
                let measured = Measured { spectrum: &spectrum, harmonics, folds: session.folds_of(id) };
                if self.controls.show(ui, id, &layer, &measured, edits) == Some(Wish::AsFarAsItGoes) {
                    match session.furthest_mu() {
                        Some(mu) => edits.set(id, Property::Mu(mu)),
                        None => shared
                            .notices
                            .warn("This layer never folds in that direction, or does not act yet."),
                    }
                }
                ui.add_space(theme::GAP);
                self.brush.show(ui);
            });
        });
    }

    fn center(&mut self, ui: &mut Ui, shared: &mut Shared<'_>, edits: &mut Edits) {
        egui::CentralPanel::default().frame(egui::Frame::new()).show(ui, |ui| {
            if let Some(loading) = &self.loading {
                egui::Panel::bottom("loading").show(ui, |ui| {
                    ui.add_space(theme::GAP_SMALL);
                    job::show_progress(ui, loading);
                    ui.add_space(theme::GAP_SMALL);
                });
            }
            self.toolbar(ui, shared);
            let (Some(session), Some(stage)) = (&mut self.session, &mut self.stage) else {
                ui.centered_and_justified(|ui| ui.label("The shape appears here as soon as it is read."));
                return;
            };
            let shown = update_stage(session, stage, &mut self.heat, self.look, &mut self.stale)
                .and_then(|()| show_stage(ui, shared, session, stage, &mut self.brush, self.look, edits));
            if let Err(why) = shown {
                shared.notices.error(why);
            }
        });
    }
}

/// Brings the figures on the stage up to date with the evaluation.
fn update_stage(
    session: &mut Session,
    stage: &mut Stage,
    heat: &mut Heat,
    look: Look,
    stale: &mut bool,
) -> Result<(), String> {
    if !std::mem::take(stale) && !heat.take_stale() {
        return Ok(());
    }
    let result = &session.evaluation.result;
    stage
        .set_figure(stage::RESULT, &single(&result.positions), &single(result.normals()))
        .map_err(|error| error.to_string())?;
    if look.show == Show::Models {
        let project = session.project().clone();
        let models = session.selected.and_then(|layer| session.stack.three_models(&project, layer));
        for (index, _) in Model::ALL.iter().enumerate() {
            let positions = match &models {
                Some(models) => &models[index],
                None => &result.positions,
            };
            let normals = single(&session.stack.surface().normals(positions));
            stage
                .set_figure(stage::MODELS + index, &single(positions), &normals)
                .map_err(|error| error.to_string())?;
        }
    }
    let values = heat.values(session);
    stage
        .set_heat(values.as_ref().map(|(values, scale)| (values.as_slice(), *scale)))
        .map_err(|error| error.to_string())
}

fn show_stage(
    ui: &mut Ui,
    shared: &mut Shared<'_>,
    session: &Session,
    stage: &mut Stage,
    brush: &mut BrushTool,
    mut look: Look,
    edits: &mut Edits,
) -> Result<(), String> {
    let rect = ui.available_rect_before_wrap();
    if ui.ctx().input(|input| input.key_down(Key::C)) && !ui.ctx().egui_wants_keyboard_input() {
        look.show = Show::Original;
    }
    let gpu: &RenderState = shared.gpu;
    let ring = brush.active.then_some(brush.radius);
    let (response, touch) = stage.show(ui, gpu, rect, look, ring, &[]).map_err(|error| error.to_string())?;
    if let Some(layer) = session.selected.filter(|_| brush.active) {
        brush.paint(ui, &response, touch, layer, session, edits);
    } else if response.clicked()
        && let Some(at) = response.interact_pointer_pos()
        && let Some((layer, model)) = session.selected.zip(stage::model_at(rect, look.show, at))
    {
        edits.set(layer, Property::Model(Model::ALL[model]));
    }
    Ok(())
}

/// Positions or normals in the precision of pictures.
fn single(points: &[[f64; 3]]) -> Vec<[f32; 3]> {
    points.iter().map(|point| point.map(|c| c as f32)).collect()
}
