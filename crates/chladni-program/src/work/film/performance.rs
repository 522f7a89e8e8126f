//! A performance, frame after frame: actions, sound, shape, picture.

mod shooting;

use std::ops::Range;
use std::time::Instant;

use chladni_harmonics::Body;
use chladni_mesh::Orientation;
use chladni_music::{Action, Ensemble, Form, Framing, Instrument, LoggedAction, Moment, Reaction, Stretch};
use chladni_synth::{Item, SynthModel};
use chladni_task::Task;
use chladni_view::{FrameRate, Look, Mood};

pub use self::shooting::{Drawn, Means};
use super::Seconds;
use super::record::Recording;
use super::titles::Titles;
use crate::work::{
    Error, Hearing, Lag, OwnLook, Programme, SandTable, Staging, along, chooses_shots, look_on_stage,
};

/// The result.
#[derive(Default)]
pub struct Done {
    pub recording: Recording,
    /// Unknown where the positions never leave the device.
    pub largest_displacement: Option<f32>,
    /// The device that drew, and how; none where nothing was drawn.
    pub drawn: Option<Drawn>,
    /// Warnings.
    pub warnings: Vec<String>,
    pub most_flashes: usize,
    pub longest_stripes_secs: f64,
    pub damped_frames: usize,
}

/// The effect of beat and sound on one picture.
struct Shot {
    /// In the film.
    time_secs: f64,
    reaction: Reaction,
    /// The framing of a shot that the camera chose.
    framing: Option<Framing>,
    mood: Mood,
    /// How many shapes are seen.
    count: usize,
}

/// All that changes from frame to frame.
pub struct Performance {
    hearing: Hearing,
    heard: std::iter::Peekable<std::vec::IntoIter<Stretch>>,
    instrument: Instrument,
    script: std::iter::Peekable<std::vec::IntoIter<LoggedAction>>,
    ensemble: Ensemble,
    staging: Staging,
    sand: SandTable,
    lag: Lag,
    /// The look of the film.
    look: Look,
    model: SynthModel,
    triangles: Vec<[u32; 3]>,
    start_secs: f64,
    rate: FrameRate,
    /// More than three a second.
    pub flashes_allowed: bool,
    /// Flashes are counted in any field of view of 10°, too.
    pub fields_judged: bool,
    /// The shape at rest is shown, too, as dots.
    pub shows_rest: bool,
    /// Songs are named as they begin.
    pub titles: Titles,
    programme: Option<Programme>,
}

impl Performance {
    /// Before its first frame, with `script` and the sounds `heard` still to come.
    ///
    /// # Errors
    /// A body that [`SynthModel::new`] refuses.
    pub fn new(
        (body, stands): (&Body, Orientation),
        ensemble: Ensemble,
        hearing: Hearing,
        (instrument, script): (Instrument, Vec<LoggedAction>),
        heard: Vec<Stretch>,
        start_secs: f64,
        rate: FrameRate,
    ) -> Result<Self, Error> {
        let (model, dancer) = (SynthModel::new(body)?, ensemble.dancer());
        let staging = Staging::new(
            dancer.clone(),
            model.rest_positions().to_vec(),
            &body.triangles,
            along(body, dancer),
            stands,
        );
        let mut performance = Self {
            hearing,
            heard: heard.into_iter().peekable(),
            staging,
            sand: SandTable::new(body.clone(), start_secs),
            lag: Lag::default(),
            look: Look::PLAIN,
            instrument,
            script: script.into_iter().peekable(),
            ensemble,
            model,
            triangles: body.triangles.clone(),
            start_secs,
            rate,
            flashes_allowed: false,
            fields_judged: false,
            shows_rest: false,
            titles: Titles::default(),
            programme: None,
        };
        performance.hearing.tune(0.0, performance.instrument.parameters());
        Ok(performance)
    }

    pub fn instrument(&self) -> &Instrument {
        &self.instrument
    }

    /// The body has these colors of its own.
    pub fn color(&mut self, own: Option<OwnLook>) {
        self.staging.color(own);
    }

    /// Dances and strength change with the music, and looks, from the film's own on, unless that is kept; another `draw`,
    /// other ones.
    /// The `held` changes stay in all of them.
    ///
    /// # Errors
    /// Where a dance of the repertoire cannot be read, and where the instrument refuses an action.
    pub fn pilot(&mut self, own: &Look, keeps_look: bool, held: Vec<Action>, draw: u64) -> Result<(), Error> {
        let programme = Programme::new(&self.instrument, Vec::new(), self.start_secs, draw)?;
        let programme = programme.on_sheet(self.staging.is_flat()).opening_in(own);
        let mut programme = programme.keeping_look(keeps_look).keeping(held);
        let at_secs = self.start_secs;
        for action in programme.step(at_secs, true, &self.instrument) {
            self.instrument.apply(Moment { at_secs, at_beat: 0.0 }, action)?;
        }
        self.hearing.tune(0.0, self.instrument.parameters());
        self.programme = Some(programme);
        Ok(())
    }

    /// Replays actions and sound in order, up to a time of the show.
    fn go_to(&mut self, at_secs: f64) -> Result<(), Error> {
        loop {
            let begins = self.heard.peek().map(|stretch| stretch.at_secs).filter(|begins| *begins <= at_secs);
            let done = self.script.peek().map(|line| line.moment.at_secs).filter(|done| *done <= at_secs);
            // A stretch begins before the actions of its time: an action is done at its beat.
            let stretch_first = begins.is_some_and(|begins| done.is_none_or(|done| begins <= done));
            if stretch_first && let Some(stretch) = self.heard.next() {
                self.hearing.begin(stretch)?;
            } else if let Some(line) = self.script.next_if(|_| done.is_some()) {
                // Beats are those of the whole song, which the window may not have known yet.
                self.act_at(line.moment.at_secs, line.action)?;
            } else {
                return self.follow_programme(at_secs);
            }
        }
    }

    /// Does the autopilot's actions up to a time of the show.
    fn follow_programme(&mut self, now_secs: f64) -> Result<(), Error> {
        let Some(programme) = &mut self.programme else { return Ok(()) };
        let bars = self.hearing.bars_between(programme.heard_secs(), now_secs);
        for (at_secs, action) in programme.hear(&bars, now_secs, &self.instrument) {
            self.act_at(at_secs, action)?;
        }
        Ok(())
    }

    /// Does an action at its beat.
    fn act_at(&mut self, at_secs: f64, action: Action) -> Result<(), Error> {
        let at_beat = self.hearing.beat_at(at_secs).count;
        self.instrument.apply(Moment { at_secs, at_beat }, action)?;
        self.hearing.tune(at_secs, self.instrument.parameters());
        Ok(())
    }

    /// Plays a frame: the effects on its picture, and the items to deform.
    fn play(&mut self, frame: u64, seconds: &mut Seconds) -> Result<(Shot, Vec<Item>), Error> {
        let time_secs = self.rate.start_secs(frame);
        let at_secs = self.start_secs + time_secs;
        let listening = Instant::now();
        while let Some(step_secs) = self.sand.due(at_secs) {
            self.go_to(step_secs)?;
            self.sand.follow(&mut self.hearing, &mut self.ensemble, &self.instrument, None, step_secs)?;
            // The sound of before the film is not always known: no sand is poured until it is.
            if self.sand.due(step_secs).is_some() {
                self.sand.step(&[], &self.instrument);
            }
        }
        self.go_to(at_secs)?;
        let unheard = || Error::other(format!("nothing is known of what is heard at {at_secs} s"));
        let framing = self.hearing.framing_at(at_secs, |secs| self.instrument.seed_at(secs));
        let heard = self.hearing.hear(at_secs)?.ok_or_else(unheard)?;
        seconds.analysis += listening.elapsed().as_secs_f64();
        let mapping = Instant::now();
        let framing = Some(framing).filter(|_| chooses_shots(&self.instrument, heard.beat));
        let (reaction, mood) = (heard.reaction(&self.instrument), heard.mood());
        let mut items = self.ensemble.play(&self.instrument, &heard.bands, heard.beat)?.to_vec();
        let shot = Shot { time_secs, reaction, framing, mood, count: items.len() };
        let wanted = look_on_stage(&self.instrument, self.look).feels_speed();
        self.lag.follow(&mut items, at_secs, wanted);
        seconds.mapping += mapping.elapsed().as_secs_f64();
        Ok((shot, items))
    }

    /// Plays without drawing; `each` is called with the form and items of each of `frames`. The coefficients are kept
    /// where `recording` is wanted.
    ///
    /// # Errors
    /// Cancelled; a sound or a dance that fails; the first error that `each` gives.
    pub fn rehearse(
        &mut self,
        frames: Range<u64>,
        recording: bool,
        seconds: &mut Seconds,
        task: &Task,
        mut each: impl FnMut(Form, &[Item]) -> Result<(), Error>,
    ) -> Result<Done, Error> {
        self.play_until(frames.start, seconds, task)?;
        let stage = task.stage("dancing", frames.end - frames.start);
        let mut done = Done::default();
        for frame in frames {
            task.check()?;
            let (Shot { time_secs, count, .. }, mut items) = self.play(frame, seconds)?;
            // Where they were is for pictures alone.
            items.truncate(count);
            let form = self.instrument.parameters().form;
            each(form, &items)?;
            if recording {
                done.recording.push(time_secs, form, items.first().unwrap_or(&Item::default()));
            }
            stage.advance(1);
        }
        Ok(done)
    }

    /// Plays the frames before `end`, on which the others depend.
    fn play_until(&mut self, end: u64, seconds: &mut Seconds, task: &Task) -> Result<(), Error> {
        let stage = task.stage("dancing", end);
        for frame in 0..end {
            task.check()?;
            self.play(frame, seconds)?;
            stage.advance(1);
        }
        Ok(())
    }
}
