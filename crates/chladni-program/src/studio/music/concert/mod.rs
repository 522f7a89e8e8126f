//! A body that dances: instrument, synthesizer and the picture of all items.

mod apart;
mod backcloth;
mod drawing;
mod house;
mod marking;
mod pane;
mod piloted;
mod standing;
mod suggesting;

use chladni_mesh::surface::Detail;
use chladni_music::{
    Action, Ensemble, GalleryShape, Instrument, ItemId, Mapping, Moment, Parameter, Parameters, Preset,
    SAND_MODE, Settings, Show, Switch, Viewpoint, without_sand,
};
use chladni_synth::{Backend, Coefficients, SynthModel};
use chladni_view::{Device, Rect, RestShape, Topology};
use egui::Ui;

use apart::Apart;
use backcloth::Backcloth;
use drawing::on_device;
use house::House;
use pane::Pane;
use piloted::Piloted;
use standing::{Hand, camera_at, navigate, touches};
use suggesting::{Judging, Recent};

use super::close_up::{self, Draft};
use super::coarse;
use super::gallery;
use super::harmonics::Harmonics;
use super::listening::Listening;
use super::loading::Ready;
use super::outgoing::Outgoing;
use super::pace::Pace;
use super::song_title::SongTitle;
use super::stillness;
use super::view::View;
use super::wish::Wish;
use crate::studio::room::Shared;
use crate::studio::screen::Screen;
use crate::studio::theme;
use crate::studio::viewport;
use crate::studio::{PlayedFrame, Trace};
use crate::work::dancer::Dancing;
use crate::work::{Deformed, Error, Lag, SandTable, Staging, along, chooses_shots, look_on_stage, reaction};

/// Seed of the first gallery; every further one is shown to the user, too.
const FIRST_SEED: u64 = 2012;

/// Everything that moves on screen.
pub struct Concert {
    instrument: Instrument,
    /// The number of log lines that are saved.
    saved: usize,
    ensemble: Ensemble,
    deformed: Deformed,
    pane: Pane,
    /// The stage in a window of its own.
    apart: Option<Apart>,
    rest: RestShape,
    /// For small cells where the processor draws, from fine to coarse.
    details: Vec<(Detail, Topology)>,
    /// How many harmonics of each item are seen, where there are details.
    seen: Vec<usize>,
    /// Vertices that were drawn of a shape, in the mean.
    drawn_vertices: usize,
    staging: Staging,
    /// The name and the cover of the song that is heard.
    pub song_title: SongTitle,
    sand: SandTable,
    lag: Lag,
    backcloth: Backcloth,
    viewpoint: Viewpoint,
    hand: Hand,
    piloted: Option<Piloted>,
    /// Black and stillness on stage.
    pub house: House,
    /// The corners of the picture are being moved.
    pub adjusts: bool,
    /// Who else gets what the stage shows.
    pub outgoing: Outgoing,
    moving: bool,
    /// The pane that is drawn shows the stage.
    draws_stage: bool,
    seconds: f64,
    moment: Moment,
    /// The item that keys act on: under the pointer where it moves, else where arrows went.
    marked: Option<usize>,
    columns: usize,
    view: View,
    draft: Option<Draft>,
    tried_out: Option<(Mapping, Settings)>,
    recent: Recent,
    judging: Judging,
    harmonics: Harmonics,
    pace: Pace,
    voice_names: Vec<String>,
}

impl Concert {
    /// A gallery of twelve on what was loaded.
    pub fn new(screen: &Screen, ready: Ready) -> Result<Self, Error> {
        let bands = Parameter::Bands.initial() as usize;
        let Dancing { body, symmetry, dancer } = ready.dancing;
        let shape = GalleryShape { eigenvalues: dancer.eigenvalues.clone(), bands };
        let instrument = Instrument::new(FIRST_SEED, 12, shape)?;
        let model = SynthModel::new(&body)?;
        let pane = Pane::new(screen);
        let device = pane.viewport.device();
        let deformed = Deformed::new(device, &model, &body.triangles, Backend::Auto)?;
        let rest = model.rest_positions().to_vec();
        let vertices = rest.len();
        let along = along(&body, &dancer);
        let staging = Staging::new(dancer.clone(), rest, &body.triangles, along, ready.stands);
        let rest = staging.rest_on(device)?;
        let details = on_device(device, vertices, ready.details)?;
        let (voice_names, terms) = ready.voices.into_iter().unzip();
        let ensemble = Ensemble::new(dancer).with_voices(terms)?;
        let mut concert = Self {
            instrument,
            saved: 0,
            ensemble,
            deformed,
            rest,
            details,
            seen: Vec::new(),
            drawn_vertices: vertices,
            staging,
            pane,
            apart: None,
            song_title: SongTitle::default(),
            sand: SandTable::new(body.clone(), 0.0),
            lag: Lag::default(),
            backcloth: Backcloth::default(),
            viewpoint: ready.opening_view,
            hand: Hand::default(),
            piloted: None,
            house: House::default(),
            adjusts: false,
            outgoing: Outgoing::default(),
            moving: true,
            draws_stage: false,
            seconds: 0.0,
            moment: Moment::default(),
            marked: None,
            columns: 1,
            view: View::Gallery,
            draft: None,
            tried_out: None,
            recent: Recent::default(),
            judging: Judging::default(),
            harmonics: Harmonics::new(body, symmetry),
            pace: Pace::default(),
            voice_names,
        };
        concert.strew_on_sheets(false)?;
        Ok(concert)
    }

    /// Continues on another device, with the same dances.
    pub fn change_device(&mut self, screen: &Screen) -> Result<(), Error> {
        let pane = Pane::new(screen);
        let (device, vertices) = (pane.viewport.device(), self.staging.rest().len());
        self.deformed = self.deformed.on(device, self.harmonics.triangles(), Backend::Auto)?;
        self.rest = self.staging.rest_on(device)?;
        let details = std::mem::take(&mut self.details).into_iter().map(|(detail, _)| detail);
        self.details = on_device(device, vertices, details)?;
        self.harmonics.forget_device();
        (self.pane, self.apart) = (pane, None);
        self.outgoing.change_device();
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

    /// What deforms the shapes, and how they are drawn, in words.
    pub fn means(&self) -> String {
        format!("Deformed by {}. Drawn with {}.", self.deformed.device_name(), self.pane.viewport.drawn())
    }

    /// Whether the last frame showed something new.
    pub fn is_moving(&self) -> bool {
        self.moving
    }

    /// The window's device.
    pub fn device(&self) -> &Device {
        self.pane.viewport.device()
    }

    /// What keeps the frames coming.
    pub fn pace(&self) -> &Pace {
        &self.pace
    }

    /// Vertices of the shape, and how many of them were drawn last, in the mean.
    pub fn drawn_vertices(&self) -> (usize, usize) {
        (self.staging.rest().len(), self.drawn_vertices)
    }

    /// Applies an action at the moment being heard. Refuses to open or close the stage so often that the
    /// window would flash.
    pub fn act(&mut self, action: Action) -> Result<(), Error> {
        let opens = action.opens_stage();
        let curtain = if self.on_stage() { action == Action::LeaveStage } else { opens };
        let limited = self.instrument.parameters().is_on(Switch::FlashLimit);
        if curtain && limited && !self.pane.guard.may_step(self.seconds) {
            return Err(Error::input("The stage was held back: more would be a flash too many in a second."));
        }
        if action == Action::Breed && self.instrument.parameters().is_on(Switch::Suggest) {
            self.judging.want();
            return Ok(());
        }
        self.instrument.apply(self.moment, action)?;
        if curtain || opens {
            self.end_piloting()?;
        }
        let count = self.instrument.gallery().items().len();
        if matches!(self.view, View::CloseUp(item) if item >= count) {
            self.look_at(View::Gallery);
        }
        self.marked = self.marked.filter(|&item| item < count);
        Ok(())
    }

    /// Width and height of the picture that was drawn last, in pixels.
    pub fn picture_size(&self) -> [u32; 2] {
        self.pane.shown.as_ref().map_or([1280, 720], |shown| shown.staged.size())
    }

    /// Where the viewer stands.
    pub fn viewpoint(&self) -> Viewpoint {
        self.viewpoint
    }

    /// Recomputes the beats of all logged actions.
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

    /// Replays on this body all actions made on another.
    pub fn go_on_from(&mut self, before: &Self) -> Result<(), Error> {
        let viewpoint = self.viewpoint;
        self.replay(&Show::of(&before.instrument))?;
        self.saved = before.saved;
        self.viewpoint = viewpoint;
        self.strew_on_sheets(before.staging.is_flat())
    }

    /// Sets all up for sand where a flat sheet takes the place of a body, and takes that back where a body takes the place of
    /// a sheet.
    fn strew_on_sheets(&mut self, was_flat: bool) -> Result<(), Error> {
        let lies = self.instrument.parameters().is_on(Switch::Sand);
        let actions = match (was_flat, self.staging.is_flat()) {
            (false, true) if !lies => SAND_MODE.to_vec(),
            (true, false) if lies => without_sand(&Parameters::default()),
            _ => Vec::new(),
        };
        for action in actions {
            self.instrument.apply(self.moment, action)?;
        }
        Ok(())
    }

    /// Marks all actions as saved.
    pub fn mark_saved(&mut self) {
        self.saved = self.instrument.log().len();
    }

    /// Whether there are favorites, names or hand-drawn curves that are not saved.
    pub fn has_unsaved_work(&self) -> bool {
        let by_hand = |action: &Action| {
            matches!(
                action,
                Action::Favorite { .. }
                    | Action::Rename { .. }
                    | Action::SetTransfer { .. }
                    | Action::SetAmplification { .. }
                    | Action::SetStereoMu { .. }
                    | Action::SetItemGain { .. }
            )
        };
        self.instrument.log().iter().skip(self.saved).any(|line| by_hand(&line.action))
    }

    /// Plays a preset in the gallery's place in the next frame.
    pub fn try_out(&mut self, preset: &Preset) {
        self.tried_out = Some((preset.mapping_on(self.instrument.shape()), preset.settings.clone()));
    }

    /// Whether something is on stage.
    pub fn on_stage(&self) -> bool {
        self.instrument.scene(self.moment.at_beat).is_some()
    }

    /// Who is on stage, or is coming.
    pub fn on_stage_now(&self) -> Option<ItemId> {
        self.instrument.scene(self.moment.at_beat).map(|scene| scene.to)
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
        let whole = viewport::whole_pixels(ui);
        self.seconds = ui.input(|input| input.time);
        self.song_title.follow(listening, self.seconds);
        self.backcloth.follow(shared);
        self.moving = self.backcloth.moves();
        if listening.beats_changed() {
            self.count_beats(|at_secs| listening.beats_at(at_secs))?;
        }
        self.follow_bars(&listening.new_bars())?;
        self.judge(ui.ctx())?;
        let (sand, ensemble, instrument) = (&mut self.sand, &mut self.ensemble, &self.instrument);
        let before = |hearing: &mut _, at_secs| sand.follow(hearing, ensemble, instrument, at_secs);
        let heard = listening.hear(self.seconds, instrument.parameters(), before)?;
        self.moment = Moment { at_secs: heard.at_secs, at_beat: heard.beat.count };
        self.recent.hear(heard.at_secs, &heard.bands);
        let (beat, reaction) = (heard.beat, reaction(&self.instrument, heard.beat, heard.fading));
        let (mood, at_secs, is_known) = (heard.mood(), heard.at_secs, heard.is_known);
        let look = look_on_stage(&self.instrument).unwrap_or_else(|| shared.settings.music.look());
        let look = look.answering(&mood);
        let staged = self.on_stage();
        let is_apart = staged && shared.settings.music.own_window;
        if !staged {
            self.house.open();
        }
        let mut apart = self.apart.take();
        if is_apart {
            let apart = apart.get_or_insert_with(|| Apart::new(&self.pane, &self.ensemble));
            apart.play(&self.instrument, &heard.bands, beat)?;
            apart.lag(at_secs, look.feels_speed());
        }
        // What the window itself shows: where the stage has a window of its own, the gallery goes on.
        let on_stage = staged && !is_apart;
        self.draws_stage = staged;
        let solo = self.tried_out.take().or_else(|| self.close_up_mapping()).filter(|_| !on_stage);
        let mut items = match &solo {
            Some((mapping, settings)) => {
                self.ensemble.audition(&self.instrument, (mapping, settings), &heard.bands, beat)
            }
            None if is_apart => self.ensemble.play_gallery(&self.instrument, &heard.bands, beat),
            None => self.ensemble.play(&self.instrument, &heard.bands, beat),
        }?
        .to_vec();
        if let Some(apart) = &mut apart {
            if is_apart {
                let framing = listening.framing(self.instrument.seed());
                let framing = chooses_shots(&self.instrument, beat).then_some(framing);
                self.show_apart(ui.ctx(), shared, apart, (reaction, framing, at_secs), look, wishes)?;
            } else {
                apart.leave();
            }
        }
        self.apart = apart;
        self.draws_stage = on_stage;
        if let View::Harmonics(first) = self.view
            && !on_stage
        {
            let response = ui.allocate_rect(whole, egui::Sense::click_and_drag());
            navigate(ui, &response, &mut self.viewpoint, 1.0);
            let camera = camera_at(&self.viewpoint, self.staging.stands());
            if self.pane.shown.is_some() {
                self.harmonics.leave();
            }
            self.pane.forget();
            ui.painter().rect_filled(whole, 0.0, theme::palette(ui).stage);
            let (viewport, topology) = (&mut self.pane.viewport, &self.deformed.topology);
            self.moving |= self.harmonics.show(ui, viewport, topology, camera, whole, first)?;
            return Ok(());
        }
        if on_stage && self.house.frozen && self.pane.shown.is_some() {
            self.repaint(ui, shared.settings.music.projection, whole);
            return Ok(());
        }
        if let (Some(trace), Some(item)) = (trace, items.first()) {
            let coefficients = match item.terms.first().map(|term| &term.coefficients) {
                Some(Coefficients::Vector(c)) => c.as_flattened().to_vec(),
                Some(Coefficients::Normal(c)) => c.clone(),
                None => Vec::new(),
            };
            trace.borrow_mut().push(PlayedFrame { at_secs, is_known, on_stage, coefficients });
        }
        let settings = self.instrument.parameters().frame_settings();
        // Of what is not known beforehand only the present is heard.
        while self.sand.due(at_secs).is_some() {
            let stepping = self.apart.as_ref().filter(|_| is_apart).map_or(&items[..], Apart::items);
            self.sand.step(stepping, &self.instrument);
        }
        let count = items.len();
        self.lag.follow(&mut items, at_secs, look.feels_speed());
        let pose = stillness::pose(&items, settings.normal_blending) ^ self.sand.version();
        // Where another window is drawn, too, its shapes have taken the place of these.
        if is_apart || self.pane.shown.as_ref().is_none_or(|shown| shown.pose != pose) {
            self.deformed.synthesize(&items, &settings)?;
            self.seen.clear();
            if !self.details.is_empty() {
                self.seen.extend(items.iter().map(coarse::harmonics_seen));
            }
            let took = (shared.now)().saturating_duration_since(began);
            if let Some(message) = self.pace.frame(took, self.ensemble.dancer().harmonics()) {
                self.ensemble.use_at_most(self.pace.harmonics());
                shared.notices.warn(message);
            }
        }
        // Reported once; then the processor continues.
        if let Some(fallback) = self.deformed.take_fallback() {
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
        let before = self.viewpoint;
        navigate(ui, &response, &mut self.viewpoint, cells_high);
        let framing = (on_stage && chooses_shots(&self.instrument, beat)).then(|| {
            let chosen = listening.framing(self.instrument.seed());
            self.hand.over(self.seconds, (before, touches(ui)), &mut self.viewpoint, chosen)
        });
        self.draw(ui, shared, (rect, area), &cells, (reaction, framing, at_secs), look, pose)?;
        match self.view {
            View::CloseUp(item) if close_up => {
                let (spectrum, bands_hz) = listening.spectrum();
                let heard = close_up::HeardBands {
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
        let mapping = self.draft.as_ref().map_or(&item.genome, |draft| &draft.mapping);
        Some((mapping.clone(), Settings::default()))
    }
}
