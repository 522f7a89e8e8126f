//! A body that dances: instrument, synthesizer and the picture of all items.

use chladni_mesh::Orientation;
use chladni_music::{
    Action, Ensemble, FlashGuard, GalleryShape, Instrument, Mapping, Moment, Parameter, Preset, Reaction,
    Settings, Show, Switch, Veil, Viewpoint,
};
use chladni_synth::{
    AutoSynthesizer, Backend, Coefficients, FrameSettings, GpuContext, SynthModel, Synthesizer,
};
use chladni_view::{Camera, Figure, Gpu, ItemBuffers, Rect, Topology};
use eframe::egui_wgpu::RenderState;
use egui::{Color32, Ui};

use super::close_up::{self, Draft};
use super::coarse::{self, Level};
use super::gallery;
use super::glimpse::Glimpse;
use super::harmonics::Harmonics;
use super::listening::Listening;
use super::loading::Ready;
use super::pace::Pace;
use super::stillness::{self, Shown};
use super::wish::Wish;
use crate::studio::room::Shared;
use crate::studio::theme;
use crate::studio::viewport::{self, Viewport};
use crate::studio::{PlayedFrame, Trace};
use crate::work::dancer::Dancing;
use crate::work::{Error, FIRST_VIEW, Look, Staging, reaction};

/// Seed of the first gallery; every further one is shown to the user, too.
const FIRST_SEED: u64 = 2012;

/// What the middle of the room shows while nothing is on stage.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum View {
    /// All items.
    #[default]
    Gallery,
    /// One item of the gallery, with its curves.
    CloseUp(usize),
    /// The harmonics of the body from this one on, and their symmetry.
    Harmonics(usize),
}

/// What an item is marked as.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Marks {
    /// As a parent.
    pub chosen: bool,
    /// As a favourite.
    pub favourite: bool,
    /// As one that stays in its place.
    pub locked: bool,
}

/// Everything that moves on screen.
pub struct Concert {
    instrument: Instrument,
    /// So many lines of its log are in a file.
    saved: usize,
    ensemble: Ensemble,
    synthesizer: AutoSynthesizer,
    viewport: Viewport,
    topology: Topology,
    /// For small cells where the processor draws, from fine to coarse.
    levels: Vec<(Level, Topology)>,
    /// How many harmonics of each item are seen, where there are levels.
    seen: Vec<usize>,
    /// Vertices that were drawn of a shape, in the mean.
    drawn_vertices: usize,
    staging: Staging,
    viewpoint: Viewpoint,
    glimpse: Glimpse,
    guard: FlashGuard,
    /// The last picture; `None` where something else was shown.
    shown: Option<Shown>,
    moving: bool,
    /// How bright the picture is that was kept is known.
    judged: bool,
    seconds: f64,
    moment: Moment,
    /// The item that keys act on: under the pointer where it moves, else where arrows went.
    marked: Option<usize>,
    columns: usize,
    view: View,
    draft: Option<Draft>,
    tried_out: Option<(Mapping, Settings)>,
    harmonics: Harmonics,
    pace: Pace,
    voice_names: Vec<String>,
}

impl Concert {
    /// A gallery of twelve on what was loaded.
    pub fn new(state: &RenderState, ready: Ready) -> Result<Self, Error> {
        let bands = Parameter::Bands.initial() as usize;
        let Dancing { body, symmetry, dancer } = ready.dancing;
        let shape = GalleryShape { eigenvalues: dancer.eigenvalues.clone(), bands };
        let instrument = Instrument::new(FIRST_SEED, 12, shape)?;
        let model = SynthModel::new(&body)?;
        let viewport = Viewport::new(state);
        let gpu = viewport.gpu();
        let topology = Topology::new(gpu, model.vertices(), &body.triangles)?;
        let context = GpuContext::new(&gpu.device, &gpu.queue, gpu.loss());
        let rest = model.rest_positions().to_vec();
        let vertices = rest.len();
        let staging = Staging::new(dancer.clone(), rest, ready.stands);
        let levels = on_device(gpu, vertices, ready.levels)?;
        let (voice_names, terms) = ready.voices.into_iter().unzip();
        let ensemble = Ensemble::new(dancer).with_voices(terms)?;
        Ok(Self {
            instrument,
            saved: 0,
            ensemble,
            synthesizer: AutoSynthesizer::new(&context, model, Backend::Auto),
            topology,
            levels,
            seen: Vec::new(),
            drawn_vertices: vertices,
            staging,
            viewport,
            viewpoint: FIRST_VIEW,
            glimpse: Glimpse::default(),
            guard: FlashGuard::default(),
            shown: None,
            moving: true,
            judged: false,
            seconds: 0.0,
            moment: Moment::default(),
            marked: None,
            columns: 1,
            view: View::Gallery,
            draft: None,
            tried_out: None,
            harmonics: Harmonics::new(body, symmetry),
            pace: Pace::default(),
            voice_names,
        })
    }

    /// Goes on on another device, with the same dances.
    pub fn change_device(&mut self, state: &RenderState) -> Result<(), Error> {
        let viewport = Viewport::new(state);
        let (gpu, vertices) = (viewport.gpu(), self.staging.rest().len());
        self.topology = Topology::new(gpu, vertices, self.harmonics.triangles())?;
        let levels = std::mem::take(&mut self.levels).into_iter().map(|(level, _)| level);
        self.levels = on_device(gpu, vertices, levels)?;
        let context = GpuContext::new(&gpu.device, &gpu.queue, gpu.loss());
        self.synthesizer = AutoSynthesizer::new(&context, self.synthesizer.model().clone(), Backend::Auto);
        self.harmonics.forget_device();
        (self.glimpse, self.judged, self.shown) = (Glimpse::default(), false, None);
        self.viewport = viewport;
        Ok(())
    }

    /// The state that the panels read.
    pub fn instrument(&self) -> &Instrument {
        &self.instrument
    }

    /// The body's harmonics and their symmetry.
    pub fn harmonics(&self) -> &Harmonics {
        &self.harmonics
    }

    /// The layers of the caricature that this body came with.
    pub fn voice_names(&self) -> &[String] {
        &self.voice_names
    }

    /// Who deforms the shapes, and how they are drawn, in words.
    pub fn means(&self) -> String {
        format!("Deformed by {}. Drawn with {}.", self.synthesizer.device_name(), self.viewport.drawn())
    }

    /// Whether the last frame showed something new.
    pub fn is_moving(&self) -> bool {
        self.moving
    }

    /// What keeps the frames coming.
    pub fn pace(&self) -> &Pace {
        &self.pace
    }

    /// Vertices of the shape, and how many of them were drawn last, in the mean.
    pub fn drawn_vertices(&self) -> (usize, usize) {
        (self.staging.rest().len(), self.drawn_vertices)
    }

    /// Does what the user asked, at the moment that is heard. A stage that would open and close
    /// so often that the window flashes is refused.
    pub fn act(&mut self, action: Action) -> Result<(), Error> {
        let opens = matches!(action, Action::Perform { .. } | Action::PerformFavourites { .. });
        let curtain = if self.on_stage() { action == Action::LeaveStage } else { opens };
        let limited = self.instrument.parameters().is_on(Switch::FlashLimit);
        if curtain && limited && !self.guard.may_step(self.seconds) {
            return Err(Error::input("The stage was held back: more would be a flash too many in a second."));
        }
        self.instrument.apply(self.moment, action)?;
        let count = self.instrument.gallery().items().len();
        if matches!(self.view, View::CloseUp(item) if item >= count) {
            self.look_at(View::Gallery);
        }
        self.marked = self.marked.filter(|&item| item < count);
        Ok(())
    }

    /// Width and height of the picture that was drawn last, in pixels.
    pub fn picture_size(&self) -> [u32; 2] {
        self.shown.as_ref().map_or([1280, 720], |shown| shown.staged.size())
    }

    /// Where the viewer stands.
    pub fn viewpoint(&self) -> Viewpoint {
        self.viewpoint
    }

    /// Counts the beats of all that was done anew.
    pub fn count_beats(&mut self, beats: impl Fn(f64) -> f64) -> Result<(), Error> {
        self.instrument = self.instrument.with_beats(beats)?;
        Ok(())
    }

    /// Replaces the gallery by that of a show, as it was in the end.
    pub fn replay(&mut self, show: &Show) -> Result<(), Error> {
        let bands = Parameter::Bands.initial() as usize;
        let shape = GalleryShape { eigenvalues: self.ensemble.dancer().eigenvalues.clone(), bands };
        self.instrument = show.replay(shape)?;
        self.saved = self.instrument.log().len();
        self.view = View::Gallery;
        self.viewpoint = show.viewpoint;
        Ok(())
    }

    /// Does on this body all that was done on another.
    pub fn go_on_from(&mut self, before: &Self) -> Result<(), Error> {
        self.replay(&Show::of(&before.instrument))?;
        self.saved = before.saved;
        self.viewpoint = FIRST_VIEW;
        Ok(())
    }

    /// All that was done is in a file now.
    pub fn mark_saved(&mut self) {
        self.saved = self.instrument.log().len();
    }

    /// Whether dances that were marked, named or drawn by hand are in no file.
    pub fn has_unsaved_work(&self) -> bool {
        let by_hand = |action: &Action| {
            matches!(
                action,
                Action::Favourite { .. }
                    | Action::Rename { .. }
                    | Action::SetTransfer { .. }
                    | Action::SetAmplification { .. }
                    | Action::SetStereoMu { .. }
                    | Action::SetItemGain { .. }
            )
        };
        self.instrument.log().iter().skip(self.saved).any(|line| by_hand(&line.action))
    }

    /// The item that keys act on.
    pub fn marked(&self) -> Option<usize> {
        match self.view {
            View::CloseUp(item) => Some(item),
            View::Gallery => self.marked,
            View::Harmonics(_) => None,
        }
    }

    /// Marks the item so many columns to the right and rows below the one that is marked.
    pub fn mark_neighbour(&mut self, right: isize, down: isize) {
        let count = self.instrument.gallery().items().len();
        let step = right + down * self.columns as isize;
        let next = self.marked.map_or(Some(0), |item| item.checked_add_signed(step));
        self.marked = next.filter(|&item| item < count).or(self.marked);
    }

    /// What the middle shows.
    pub fn view(&self) -> View {
        self.view
    }

    /// Shows something else; what was being drawn is given up.
    pub fn look_at(&mut self, view: View) {
        self.view = view;
        self.draft = None;
        self.marked = None;
    }

    /// Plays a preset in the gallery's place in the next frame.
    pub fn try_out(&mut self, preset: &Preset) {
        self.tried_out = Some((preset.mapping_on(self.instrument.shape()), preset.settings.clone()));
    }

    /// What an item is marked as.
    pub fn marks(&self, item: usize) -> Marks {
        let Some(item) = self.instrument.gallery().items().get(item) else { return Marks::default() };
        let favourite = self.instrument.favourites().iter().any(|favourite| favourite.id == item.id);
        Marks { chosen: item.chosen, favourite, locked: item.locked }
    }

    /// Whether something is on stage.
    pub fn on_stage(&self) -> bool {
        self.instrument.scene(self.moment.at_beat).is_some()
    }

    /// Index of the favourite after or before the one on stage.
    pub fn next_favourite(&self, forward: bool) -> Option<usize> {
        let count = self.instrument.favourites().len();
        let on_stage = self.instrument.scene(self.moment.at_beat).map(|scene| scene.to);
        let now = self.instrument.favourites().iter().position(|item| Some(item.id) == on_stage);
        let step = if forward { 1 } else { count.checked_sub(1)? };
        (count > 0).then(|| now.map_or(0, |now| (now + step) % count))
    }

    /// Hears, deforms and draws one frame, and handles clicks on what is shown.
    pub fn show(
        &mut self,
        ui: &mut Ui,
        shared: &mut Shared<'_>,
        listening: &mut Listening,
        trace: Option<&Trace>,
        wishes: &mut Vec<Wish>,
    ) -> Result<(), Error> {
        let began = (shared.now)();
        let whole = ui.available_rect_before_wrap();
        self.seconds = ui.input(|input| input.time);
        if listening.beats_changed() {
            self.count_beats(|at_secs| listening.beats_at(at_secs))?;
        }
        let heard = listening.hear(self.seconds, self.instrument.parameters())?;
        self.moment = Moment { at_secs: heard.at_secs, at_beat: heard.beat.count };
        let (beat, reaction) = (heard.beat, reaction(&self.instrument, heard.beat, heard.fading));
        let on_stage = self.on_stage();
        if let View::Harmonics(first) = self.view
            && !on_stage
        {
            let response = ui.allocate_rect(whole, egui::Sense::click_and_drag());
            navigate(ui, &response, &mut self.viewpoint, 1.0);
            let camera = camera_at(&self.viewpoint, self.staging.stands());
            if self.shown.take().is_some() {
                self.harmonics.leave();
            }
            (self.glimpse, self.judged) = (Glimpse::default(), false);
            ui.painter().rect_filled(whole, 0.0, theme::palette(ui).stage);
            let (viewport, topology) = (&mut self.viewport, &self.topology);
            self.moving = self.harmonics.show(ui, shared, viewport, topology, camera, whole, first)?;
            return Ok(());
        }
        let solo = self.tried_out.take().or_else(|| self.close_up_mapping()).filter(|_| !on_stage);
        let items = match &solo {
            Some((mapping, settings)) => {
                self.ensemble.audition(&self.instrument, (mapping, settings), &heard.bands, beat)
            }
            None => self.ensemble.play(&self.instrument, &heard.bands, beat),
        }?;
        if let (Some(trace), Some(item)) = (trace, items.first()) {
            let coefficients = match item.terms.first().map(|term| &term.coefficients) {
                Some(Coefficients::Vector(c)) => c.as_flattened().to_vec(),
                Some(Coefficients::Normal(c)) => c.clone(),
                None => Vec::new(),
            };
            let (at_secs, is_known) = (heard.at_secs, heard.is_known);
            trace.borrow_mut().push(PlayedFrame { at_secs, is_known, on_stage, coefficients });
        }
        // Full blending is the paper's: the mean of the exact and the rest normal.
        let normal_blending = 0.5 * self.instrument.parameters().get(Parameter::NormalBlending);
        let count = items.len();
        let pose = stillness::pose(items, normal_blending);
        if self.shown.as_ref().is_none_or(|shown| shown.pose != pose) {
            self.synthesizer.synthesize(items, &FrameSettings { normal_blending })?;
            self.seen.clear();
            if !self.levels.is_empty() {
                self.seen.extend(items.iter().map(coarse::harmonics_seen));
            }
            let took = (shared.now)().saturating_duration_since(began);
            if let Some(told) = self.pace.frame(took, self.ensemble.dancer().harmonics()) {
                self.ensemble.use_at_most(self.pace.harmonics());
                shared.notices.warn(told);
            }
        }
        // Once, and then the processor goes on.
        if let Some(fallback) = self.synthesizer.take_fallback() {
            shared.notices.warn(fallback.to_string());
        }
        let close_up = matches!(self.view, View::CloseUp(_)) && !on_stage;
        let (rect, bench) = if close_up { close_up::split(whole) } else { (whole, whole) };
        let response = ui.allocate_rect(rect, egui::Sense::click_and_drag());
        let pixels = |points: f32| ((points * ui.pixels_per_point()).round() as u32).max(1);
        let area = Rect::of_size(pixels(rect.width()), pixels(rect.height()));
        let (cells, columns) = Staging::cells(area, count);
        self.columns = columns;
        let cells_high = cells.first().map_or(1.0, |cell| area.height as f32 / cell.height.max(1) as f32);
        navigate(ui, &response, &mut self.viewpoint, cells_high);
        let look = shared.settings.music.look();
        self.draw(ui, shared, (rect, area), &cells, reaction, look, pose)?;
        match self.view {
            View::CloseUp(item) if close_up => {
                let (spectrum, bands_hz) = listening.spectrum();
                let heard = close_up::Heard {
                    mid: &spectrum.mid,
                    bands_hz,
                    eigenvalues: &self.ensemble.dancer().eigenvalues,
                };
                close_up::show(ui, bench, &self.instrument, item, &mut self.draft, &heard, wishes);
            }
            View::Gallery if !on_stage && solo.is_none() => {
                let places: Vec<egui::Rect> =
                    cells.iter().map(|cell| viewport::to_points(ui, rect, *cell)).collect();
                let (hovered, focused) = gallery::overlay(ui, &places, &self.instrument, self.marked, wishes);
                let moved = ui
                    .input(|input| input.pointer.delta() != egui::Vec2::ZERO || input.pointer.any_pressed());
                // A pointer that rests does not take the mark from the arrow keys.
                if focused.is_some() {
                    self.marked = focused;
                } else if moved || self.marked.is_none() {
                    self.marked = hovered;
                }
            }
            _ => {}
        }
        Ok(())
    }

    /// What the close-up plays: the stroke that is being drawn, or the item as it is.
    fn close_up_mapping(&self) -> Option<(Mapping, Settings)> {
        let View::CloseUp(item) = self.view else { return None };
        let item = self.instrument.gallery().items().get(item)?;
        let mapping = self.draft.as_ref().map_or(&item.mapping, |draft| &draft.mapping);
        Some((mapping.clone(), Settings::default()))
    }

    fn draw(
        &mut self,
        ui: &mut Ui,
        shared: &Shared<'_>,
        (rect, area): (egui::Rect, Rect),
        cells: &[Rect],
        reaction: Reaction,
        look: Look,
        pose: u64,
    ) -> Result<(), Error> {
        let limited = self.instrument.parameters().is_on(Switch::FlashLimit);
        let staged = self.staging.set(area, cells.len(), &self.viewpoint, &look, reaction, &self.instrument);
        let material = staged.material;
        let shown = Shown { pose, staged: staged.clone() };
        self.moving = self.shown.as_ref() != Some(&shown);
        if self.moving {
            self.viewport.invalidate();
        }
        let buffers = ItemBuffers::of_frame(&self.synthesizer.frame())?;
        let mut drawn_vertices = 0;
        let figures: Vec<Figure<'_>> = (0..)
            .zip(cells)
            .map(|(item, cell)| {
                let pixels = cell.width as usize * cell.height as usize;
                let seen = self.seen.get(item).copied().unwrap_or(0);
                let needed = coarse::vertices_needed(seen, pixels);
                let level = self.levels.iter().rev().find(|(level, _)| level.vertices >= needed);
                drawn_vertices += level.map_or(self.staging.rest().len(), |(level, _)| level.vertices);
                let topology = level.map_or(&self.topology, |(_, topology)| topology);
                Figure { material, ..Figure::new(topology, &buffers, item) }
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
            return Ok(());
        }
        // The picture is shown once it is known how bright it is; until then the one before is, and no other
        // one is begun.
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
        Ok(())
    }
}

/// A camera that stands at a viewpoint of a picture whose size nobody knows yet.
fn camera_at(viewpoint: &Viewpoint, stands: Orientation) -> Camera {
    let Viewpoint { yaw_rad, pitch_rad, .. } = *viewpoint;
    let camera = Camera { yaw_rad, pitch_rad, stands, ..Camera::default() };
    let mut camera = Camera { distance: viewpoint.distance * camera.distance, ..camera };
    camera.pan(viewpoint.shift[0], viewpoint.shift[1], 1.0);
    camera
}

/// Moves the viewer by pointer and keys on `response`, which is so many cells high.
fn navigate(ui: &Ui, response: &egui::Response, viewpoint: &mut Viewpoint, cells_high: f32) {
    // A viewpoint is relative to how the shape stands: any stance gives the same.
    let before = camera_at(viewpoint, Orientation::Y_UP);
    let mut camera = before;
    if viewport::navigate(ui, response, &mut camera) {
        let shift = camera.shift_since(before.target);
        // It comes nearer to the middle of the picture, not to that of the shape.
        let nearer = before.distance / camera.distance;
        *viewpoint = Viewpoint {
            yaw_rad: camera.yaw_rad,
            pitch_rad: camera.pitch_rad,
            distance: camera.distance / Camera::default().distance,
            shift: std::array::from_fn(|i| nearer * viewpoint.shift[i] + cells_high * shift[i]),
        };
    }
    let asks = response.hovered() || response.has_focus();
    if asks && viewport::VIEW_KEYS[4].pressed(ui.ctx()) {
        *viewpoint = Viewpoint { distance: 1.0, shift: [0.0; 2], ..*viewpoint };
    }
}

/// Levels of a shape of `vertices` vertices, with their triangles on the device.
fn on_device(
    gpu: &Gpu,
    vertices: usize,
    levels: impl IntoIterator<Item = Level>,
) -> Result<Vec<(Level, Topology)>, Error> {
    let upload =
        |level: Level| Topology::new(gpu, vertices, &level.triangles).map(|topology| (level, topology));
    Ok(levels.into_iter().map(upload).collect::<Result<_, _>>()?)
}
