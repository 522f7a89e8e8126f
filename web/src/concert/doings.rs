//! Actions of a person in a concert.

use chladni_music::{
    Action, Describer, Instrument, Looks, Moment, Switch, experiment, suggest, without_sand,
};
use chladni_program::work::{Error, Programme, look_named, opening_looks, opening_view};
use chladni_view::Camera;
use wasm_bindgen::prelude::*;

use super::Concert;

/// A wheel's step brings the viewer so much nearer.
const STEP: f32 = 0.9;
/// How near and how far the viewer may be, in multiples of where the whole shape is seen.
const DISTANCES: (f32, f32) = (0.25, 4.0);

#[wasm_bindgen]
impl Concert {
    /// Does an action of the instrument, as a line of a show file says it: `{"do": "choose", "item": 3, "on": true}`.
    /// The autopilot ends where the stage is taken or left by it.
    ///
    /// # Errors
    /// Text that is not an action, and an action that cannot be done.
    #[wasm_bindgen(js_name = "act")]
    pub fn act_text(&mut self, action: &str) -> Result<(), JsError> {
        let action: Action = serde_json::from_str(action)?;
        let ends_piloting = action.opens_stage() || action == Action::LeaveStage;
        if self.programme.as_ref().is_some_and(|programme| programme.ends_before(&action, &self.instrument)) {
            self.end_piloting()?;
        }
        self.act(action)?;
        if ends_piloting {
            self.end_piloting()?;
        }
        Ok(())
    }

    /// Begins anew with `size` dances, of the same seed or of another one.
    ///
    /// # Errors
    /// A size that no gallery has.
    pub fn new_gallery(&mut self, size: usize, other_seed: bool) -> Result<(), JsError> {
        let gallery = self.instrument.gallery();
        let seed = if other_seed { gallery.next_seed() } else { gallery.seed() };
        Ok(self.act(Action::NewGallery { seed, size })?)
    }

    /// Begins anew with the form, the knobs and the switches of another concert, and with as many dances. What sand and the
    /// autopilot have set there is as it was before them. A look that was chosen there stays, but not the one in which its
    /// shape was shown first, nor that of the `front`, as a show file names it. Effects that were left out stay out of any.
    ///
    /// # Errors
    /// Text that says no look, and bugs.
    pub fn go_on_from(&mut self, before: &Concert, front: &str) -> Result<(), JsError> {
        let unchosen = [opening_looks(&before.name), serde_json::from_str(front)?];
        // A copy, so that no show has these actions.
        let mut set_back = before.instrument.clone();
        let piloted = before.programme.iter().flat_map(|programme| programme.end(&before.instrument));
        for action in piloted {
            set_back.apply(Moment::default(), action)?;
        }
        if set_back.parameters().is_on(Switch::Sand) {
            for action in without_sand(&before.before_sand.clone().unwrap_or_default()) {
                set_back.apply(Moment::default(), action)?;
            }
        }
        let (seed, size) = (self.instrument.seed(), set_back.gallery().items().len());
        let shape = self.instrument.shape().clone();
        self.instrument = Instrument::beginning_with(set_back.parameters().clone(), seed, size, shape)?;
        self.hearing.tune(0.0, self.instrument.parameters());
        if !unchosen.contains(&Looks { without: Vec::new(), ..before.looks.clone() }) {
            self.looks.clone_from(&before.looks);
        }
        self.looks.without.clone_from(&before.looks.without);
        Ok(())
    }

    /// Breeds the chosen dances; where children are suggested, the best of two hundred, which takes a second or more.
    ///
    /// # Errors
    /// No dance is chosen, or too few.
    pub fn breed(&mut self) -> Result<(), JsError> {
        let parameters = self.instrument.parameters();
        if !parameters.is_on(Switch::Suggest) {
            return Ok(self.act(Action::Breed)?);
        }
        let moments = self.recent.moments(self.instrument.shape().bands);
        let describer = Describer::new(self.ensemble.dancer().clone(), parameters.playing(), moments)?;
        let candidates = suggest(self.instrument.gallery(), &describer)?;
        Ok(self.act(Action::BreedFrom { candidates })?)
    }

    /// Sand lies on the shape, which vibrates as a plate does; or all is as it was before. Of a show that was opened with
    /// sand it is not known how it was: knobs then stand where they stand first. The autopilot ends.
    ///
    /// # Errors
    /// Bugs only.
    pub fn sand(&mut self, on: bool) -> Result<(), JsError> {
        // Before knobs are set, since this returns them to where they were.
        self.end_piloting()?;
        let actions = match (on, self.before_sand.take()) {
            (true, before) => {
                self.before_sand = before.or_else(|| Some(self.instrument.parameters().clone()));
                let dancer = self.ensemble.dancer();
                experiment(&dancer.eigenvalues, &dancer.classes, self.instrument.shape().bands)
            }
            (false, before) => {
                let mut actions = without_sand(&before.unwrap_or_default());
                actions.push(Action::LeaveStage);
                actions
            }
        };
        for action in actions {
            self.act(action)?;
        }
        Ok(())
    }

    /// The autopilot chooses dances, favorites among them, and looks, or lets go.
    ///
    /// # Errors
    /// Bugs only.
    pub fn autopilot(&mut self, on: bool) -> Result<(), JsError> {
        if !on {
            if self.programme.is_some() {
                self.act(Action::LeaveStage)?;
            }
            return Ok(self.end_piloting()?);
        }
        let at_secs = self.clock.at_secs();
        // Another evening, another programme.
        let draw = js_sys::Date::now() as u64;
        let favorites = self.instrument.favorites().iter();
        let favorites =
            favorites.map(|item| self.instrument.preset(item, self.instrument.tags(item.id))).collect();
        let programme = Programme::new(&self.instrument, favorites, at_secs, draw)?;
        let own = look_named(&self.looks).0;
        let mut programme = programme.on_sheet(self.staging.is_flat()).opening_in(&own);
        let actions = programme.step(at_secs, true, &self.instrument);
        self.programme = Some(programme);
        for action in actions {
            self.act(action)?;
        }
        Ok(())
    }

    /// Shows a look by its names, as a show file has them: `{"look": "ember"}`. The autopilot shows its own.
    ///
    /// # Errors
    /// Text that says no look.
    pub fn set_look(&mut self, looks: &str) -> Result<(), JsError> {
        self.looks = serde_json::from_str(looks)?;
        Ok(())
    }

    /// Turns the viewer by a drag in pixels.
    pub fn turn(&mut self, dx: f32, dy: f32) {
        let view = &mut self.viewpoint;
        let mut camera = Camera { yaw_rad: view.yaw_rad, pitch_rad: view.pitch_rad, ..Camera::default() };
        camera.orbit(dx, dy);
        (view.yaw_rad, view.pitch_rad) = (camera.yaw_rad, camera.pitch_rad);
    }

    /// Brings the viewer nearer by steps of a wheel.
    pub fn zoom(&mut self, steps: f32) {
        let distance = self.viewpoint.distance * STEP.powf(steps);
        self.viewpoint.distance = distance.clamp(DISTANCES.0, DISTANCES.1);
    }

    /// Shifts the picture, in heights of a cell.
    pub fn shift(&mut self, right: f32, down: f32) {
        let [x, y] = self.viewpoint.shift;
        self.viewpoint.shift = [(x + right).clamp(-2.0, 2.0), (y + down).clamp(-2.0, 2.0)];
    }

    /// Shows the whole shape from where it was seen first.
    pub fn fit(&mut self) {
        self.viewpoint = opening_view(&self.name);
    }
}

impl Concert {
    /// Does an action now. A show that is played is the user's own from then on.
    pub(super) fn act(&mut self, action: Action) -> Result<(), Error> {
        self.leave_script();
        self.act_at(self.clock.at_secs(), action)
    }

    pub(super) fn act_at(&mut self, at_secs: f64, action: Action) -> Result<(), Error> {
        let at_beat = self.beat_at(at_secs);
        self.instrument.apply(Moment { at_secs, at_beat }, action)?;
        self.hearing.tune(at_secs, self.instrument.parameters());
        Ok(())
    }

    /// The autopilot ends: gallery and knobs are as they were before it.
    fn end_piloting(&mut self) -> Result<(), Error> {
        let Some(programme) = self.programme.take() else { return Ok(()) };
        programme.end(&self.instrument).into_iter().try_for_each(|action| self.act(action))
    }

    /// Does the autopilot's actions up to a time of the show.
    pub(super) fn follow_programme(&mut self, now_secs: f64) -> Result<(), Error> {
        let Some(programme) = &mut self.programme else { return Ok(()) };
        let bars = match &mut self.live {
            Some(live) => live.new_bars(now_secs),
            None => self.hearing.bars_between(programme.heard_secs(), now_secs),
        };
        for (at_secs, action) in programme.hear(&bars, now_secs, &self.instrument) {
            self.act_at(at_secs, action)?;
        }
        Ok(())
    }
}
