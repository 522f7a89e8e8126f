//! A body that dances: instrument, synthesizer and the picture of all items.

mod apart;
mod backcloth;
mod coarse;
mod drawing;
mod frame;
mod glimpse;
mod house;
mod marking;
mod pace;
mod pane;
mod piloted;
mod preview;
mod show;
mod standing;
mod stillness;
mod suggesting;
mod unsaved;
mod viewpoint;

use chladni_mesh::surface::Detail;
use chladni_music::{
    Action, Ensemble, GalleryShape, Instrument, ItemId, Mapping, Moment, Parameter, Parameters, Preset,
    SAND_MODE, Settings, Show, Switch, Viewpoint, without_sand,
};
use chladni_synth::{Backend, SynthModel};
use chladni_view::{Device, Topology};

use apart::Apart;
use backcloth::Backcloth;
use drawing::on_device;
use house::House;
use pace::Pace;
use pane::Pane;
use suggesting::Judging;
use viewpoint::Hand;

use super::close_up::Draft;
use super::harmonics::Harmonics;
use super::loading::Ready;
use super::outgoing::Outgoing;
use super::song_title::SongTitle;
use super::view::View;
use crate::studio::screen::Screen;
use crate::studio::standing::Standing;
use crate::work::dancer::Dancing;
use crate::work::{Deformed, Error, Lag, Programme, Recent, SandTable, Staging, Wardrobe, along};

/// Seed of the first gallery; every further one is shown to the user, too.
const FIRST_SEED: u64 = 2012;

/// Everything that moves on screen.
pub struct Concert {
    instrument: Instrument,
    /// The number of log lines that are saved.
    saved: usize,
    /// The show was read from a file, or saved.
    is_of_a_file: bool,
    /// The number of log lines up to the last in which a person changed how it plays.
    changed: usize,
    ensemble: Ensemble,
    deformed: Deformed,
    pane: Pane,
    /// The stage in a window of its own.
    apart: Option<Apart>,
    wardrobe: Wardrobe,
    /// For small cells where the processor draws, from fine to coarse.
    details: Vec<(Detail, Topology)>,
    /// How many harmonics of each item are seen, where there are details.
    seen: Vec<usize>,
    /// Vertices that were drawn of a shape, in the mean.
    drawn_vertices: usize,
    staging: Staging,
    standing: Standing,
    /// The name and the cover of the song that is heard.
    pub song_title: SongTitle,
    sand: SandTable,
    lag: Lag,
    backcloth: Backcloth,
    viewpoint: Viewpoint,
    hand: Hand,
    piloted: Option<Programme>,
    /// Black and stillness on stage.
    pub house: House,
    /// The corners of the picture are being moved.
    pub adjusts: bool,
    /// The other receivers of the stage's pictures.
    pub outgoing: Outgoing,
    /// A person taps to clicks and flashes, also in the second window.
    pub calibrates: bool,
    /// The second window shows the flashes.
    pub flashes: bool,
    moving: bool,
    /// The pane that is drawn shows the stage.
    draws_stage: bool,
    seconds: f64,
    moment: Moment,
    /// The item that keys act on: under the pointer where it moves, else where arrows went.
    marked: Option<usize>,
    columns: usize,
    view: View,
    /// The item of the close-up, whatever place it has.
    close_up: Option<ItemId>,
    draft: Option<Draft>,
    tried_out: Option<(Mapping, Settings)>,
    recent: Recent,
    judging: Judging,
    harmonics: Harmonics,
    pace: Pace,
    voice_names: Vec<String>,
}

impl Concert {
    /// A gallery of twelve on the loaded body.
    pub fn new(screen: &Screen, ready: Ready) -> Result<Self, Error> {
        let bands = Parameter::Bands.initial() as usize;
        let Dancing { body, symmetry, dancer } = ready.dancing;
        let shape = GalleryShape { eigenvalues: dancer.eigenvalues.clone(), bands };
        let instrument = Instrument::new(FIRST_SEED, 12, shape)?;
        let model = SynthModel::new(&body)?;
        let pane = Pane::new(screen);
        let device = pane.viewport.device();
        let rest = model.rest_positions().to_vec();
        let vertices = rest.len();
        let along = along(&body, &dancer);
        let mut staging = Staging::new(dancer.clone(), rest, &body.triangles, along, ready.stands);
        staging.color(ready.own);
        let topology = staging.topology(device, &body.triangles, None)?;
        let deformed = Deformed::new(device, &model, topology, Backend::Auto);
        let wardrobe = staging.wardrobe(device)?;
        let details = on_device(device, (&staging, &body.triangles), ready.details)?;
        let standing = Standing { found: ready.stands, in_doubt: ready.in_doubt, given: None };
        let (voice_names, terms) = ready.voices.into_iter().unzip();
        let ensemble = Ensemble::new(dancer).with_voices(terms)?;
        let mut concert = Self {
            instrument,
            saved: 0,
            is_of_a_file: false,
            changed: 0,
            ensemble,
            deformed,
            wardrobe,
            details,
            seen: Vec::new(),
            drawn_vertices: vertices,
            staging,
            standing,
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
            calibrates: false,
            flashes: false,
            moving: true,
            draws_stage: false,
            seconds: 0.0,
            moment: Moment::default(),
            marked: None,
            columns: 1,
            view: View::Gallery,
            close_up: None,
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
        let (device, triangles) = (pane.viewport.device(), self.harmonics.triangles());
        let topology = self.staging.topology(device, triangles, None)?;
        self.deformed = self.deformed.on(device, topology, Backend::Auto);
        self.wardrobe = self.staging.wardrobe(device)?;
        let details = std::mem::take(&mut self.details).into_iter().map(|(detail, _)| detail);
        self.details = on_device(device, (&self.staging, triangles), details)?;
        self.harmonics.forget_device();
        (self.pane, self.apart) = (pane, None);
        self.outgoing.change_device();
        self.song_title.change_device();
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

    /// The means by which shapes are deformed and drawn, in words.
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

    /// The pace of the frames.
    pub fn pace(&self) -> &Pace {
        &self.pace
    }

    /// Whether the shape has colors of its own.
    pub fn has_own_colors(&self) -> bool {
        self.staging.has_own_colors()
    }

    /// Vertices of the shape, and how many of them were drawn last, in the mean.
    pub fn drawn_vertices(&self) -> (usize, usize) {
        (self.staging.rest().len(), self.drawn_vertices)
    }

    /// Applies an action at the moment being heard. Refuses to open or close the stage so often that the
    /// window would flash.
    pub fn act(&mut self, action: Action) -> Result<(), Error> {
        self.may_draw(std::slice::from_ref(&action))?;
        self.apply(action)
    }

    /// Does all of `actions`, or none where the flash guard holds the stage back.
    pub fn act_all(&mut self, actions: Vec<Action>) -> Result<(), Error> {
        self.may_draw(&actions)?;
        actions.into_iter().try_for_each(|action| self.apply(action))
    }

    /// Applies an action that [`may_draw`](Self::may_draw) has let pass.
    fn apply(&mut self, action: Action) -> Result<(), Error> {
        let ends_piloting = action.opens_stage() || self.draws_curtain(&action);
        if action == Action::Breed && self.instrument.parameters().is_on(Switch::Suggest) {
            self.judging.want();
            return Ok(());
        }
        if self.piloted.as_ref().is_some_and(|piloted| piloted.ends_before(&action, &self.instrument)) {
            self.end_piloting()?;
        }
        let next = self.instrument.next_on_stage().map(|(id, _)| id);
        let fades = matches!(action, Action::Crossfade { .. }) && next.is_some();
        // One that was chosen in the gallery to be next is still that once something is on stage.
        let waits = next.filter(|_| !self.on_stage() && action.opens_stage() && action != Action::Go);
        self.apply_by_hand(action)?;
        if ends_piloting || fades && self.instrument.next_on_stage().is_none() {
            self.end_piloting()?;
        }
        if let Some(id) = waits.filter(|id| self.on_stage_now() != Some(*id))
            && let Some(item) = self.instrument.gallery().items().iter().position(|known| known.id == id)
        {
            self.instrument.apply(self.moment, Action::CueUp { item })?;
        }
        self.follow_close_up();
        let count = self.instrument.gallery().items().len();
        self.marked = self.marked.filter(|&item| item < count);
        Ok(())
    }

    /// Whether an action opens or closes the stage.
    fn draws_curtain(&self, action: &Action) -> bool {
        if self.on_stage() { *action == Action::LeaveStage } else { action.opens_stage() }
    }

    /// Refuses `actions` where one of them draws the curtain and that would be a flash too many; else counts it.
    fn may_draw(&mut self, actions: &[Action]) -> Result<(), Error> {
        let draws = actions.iter().any(|action| self.draws_curtain(action));
        let limited = self.instrument.parameters().is_on(Switch::FlashLimit);
        if draws && limited && !self.pane.guard.may_step(self.seconds) {
            return Err(Error::input("The stage was held back: more would be a flash too many in a second."));
        }
        Ok(())
    }

    /// The room was not shown for a while, and its second window is gone.
    pub fn come_back(&mut self) {
        self.apart.iter_mut().for_each(Apart::leave);
    }

    /// A picture was drawn.
    pub fn has_picture(&self) -> bool {
        self.pane.shown.is_some()
    }

    /// Width and height of the picture that others get, in pixels: that of the stage, also where it has a window of its
    /// own; else that of the gallery.
    pub fn picture_size(&self) -> [u32; 2] {
        let on_stage = self.apart.as_ref().and_then(|apart| apart.pane.shown.as_ref());
        on_stage.or(self.pane.shown.as_ref()).map_or([1280, 720], |shown| shown.staged.size())
    }

    /// Where the viewer stands, but for what a hand has moved that gives it back to the camera.
    pub fn viewpoint(&self) -> Viewpoint {
        self.hand.home(self.viewpoint)
    }

    /// Recomputes the beats of all logged actions, and of now.
    pub fn count_beats(&mut self, beats: impl Fn(Moment) -> f64) -> Result<(), Error> {
        self.instrument = self.instrument.with_beats(&beats)?;
        self.moment.at_beat = beats(self.moment);
        Ok(())
    }

    /// Replaces the gallery by that of a show, as it was in the end, on a body that stands as in the show.
    pub fn replay(&mut self, show: &Show) -> Result<(), Error> {
        let bands = Parameter::Bands.initial() as usize;
        let shape = GalleryShape { eigenvalues: self.ensemble.dancer().eigenvalues.clone(), bands };
        self.instrument = show.replay(shape)?;
        self.stand(show.stands);
        // It played the other show.
        (self.piloted, self.marked) = (None, None);
        // Items of another show may have the same numbers.
        (self.judging, self.draft) = (Judging::default(), None);
        self.outgoing.change_show();
        self.changed = 0;
        self.mark_saved();
        self.view = View::Gallery;
        (self.viewpoint, self.hand) = (show.viewpoint, Hand::default());
        Ok(())
    }

    /// What is done from now on is done at this moment of the show, until a frame tells a later one.
    pub fn go_on_at(&mut self, moment: Moment) {
        self.moment = moment;
    }

    /// Replays on this body, however it stands, all actions made on another.
    pub fn go_on_from(&mut self, before: &Self) -> Result<(), Error> {
        let viewpoint = self.viewpoint;
        self.moment = before.moment;
        self.replay(&Show::of(&before.instrument))?;
        (self.saved, self.is_of_a_file) = (before.saved, before.is_of_a_file);
        self.changed = before.changed;
        self.viewpoint = viewpoint;
        self.strew_on_sheets(before.staging.is_flat())
    }

    /// What goes on around the dance goes on as it did before.
    pub fn go_on_as(&mut self, before: Self) {
        if before.is_judging() {
            self.judging.want();
        }
        let is_flat = self.staging.is_flat();
        self.piloted = before.piloted.map(|programme| programme.on_sheet(is_flat));
        (self.outgoing, self.house, self.backcloth) = (before.outgoing, before.house, before.backcloth);
        self.song_title = before.song_title;
    }

    /// Sets all up for sand where a flat sheet takes the place of a body, and takes that back where a body takes the place
    /// of a sheet.
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

    /// Plays a preset in the gallery's place in the next frame.
    pub fn try_out(&mut self, preset: &Preset) {
        self.tried_out = Some((preset.mapping_on(self.instrument.shape()), preset.settings.clone()));
    }

    /// Whether something is on stage.
    pub fn on_stage(&self) -> bool {
        self.instrument.scene(self.moment.at_beat).is_some()
    }

    /// The place of the dance on stage among those that are shown in turn.
    pub fn place_in_turn(&self) -> Option<usize> {
        self.instrument.place_in_turn(self.moment.at_beat)
    }

    /// The item on stage, or the one that is coming.
    pub fn on_stage_now(&self) -> Option<ItemId> {
        self.instrument.scene(self.moment.at_beat).map(|scene| scene.to)
    }
}

#[cfg(test)]
impl Concert {
    /// A ball with this many harmonics, which dances unseen.
    pub fn of_ball(harmonics: usize) -> Result<Self, Error> {
        use chladni_harmonics::{BasisSettings, Body};
        use chladni_mesh::{Orientation, samples};

        let (mesh, task) = (samples::icosphere(2), chladni_task::Task::new());
        let body = Body::build(&mesh, &BasisSettings::new(harmonics), &task)?;
        let symmetry = crate::work::dancer::classes(&body, false, &task)?;
        let ready = Ready {
            dancing: Dancing::new(&body, symmetry, &Orientation::Y_UP)?,
            stands: Orientation::Y_UP,
            in_doubt: false,
            opening_view: Viewpoint::default(),
            voices: Vec::new(),
            details: Vec::new(),
            own: None,
            warnings: Vec::new(),
        };
        Self::new(&Screen::unseen(&Device::Processor), ready)
    }
}
