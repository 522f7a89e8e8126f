//! The autopilot in the window.

use std::time::{SystemTime, UNIX_EPOCH};

use chladni_music::{Action, BarLine, Preset};
use chladni_view::Look;

use super::Concert;
use crate::work::{Error, Programme};

impl Concert {
    /// Whether the autopilot chooses the dance on stage.
    pub fn is_piloted(&self) -> bool {
        self.piloted.is_some()
    }

    /// Whether it keeps the current dance and look.
    pub fn is_held(&self) -> bool {
        self.piloted.as_ref().is_some_and(Programme::holds)
    }

    /// Puts the autopilot on stage, at first in the show's `own` look, with the dances that are kept as favorites; or ends
    /// it.
    pub fn pilot(&mut self, kept: Vec<Preset>, own: &Look) -> Result<(), Error> {
        if self.piloted.is_some() {
            return self.act(Action::LeaveStage);
        }
        let favorites = self.instrument.favorites().iter();
        let favorites = favorites.map(|item| self.instrument.preset(item, self.instrument.tags(item.id)));
        let favorites = favorites.chain(kept).collect();
        // Another evening, another program: its actions are written down in the show.
        let now = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs());
        let programme = Programme::new(&self.instrument, favorites, self.moment.at_secs, now)?;
        let mut programme = programme.on_sheet(self.staging.is_flat()).opening_in(own);
        let actions = programme.step(self.moment.at_secs, true, &self.instrument);
        let changed = self.changed;
        self.act_all(actions)?;
        // What it has set is set back in the end.
        (self.piloted, self.changed) = (Some(programme), changed);
        Ok(())
    }

    /// Keeps the current dance and look, or goes on.
    pub fn hold(&mut self) {
        if let Some(programme) = &mut self.piloted {
            let holds = programme.holds();
            programme.hold(!holds);
        }
    }

    /// The next dance of the autopilot, or the one before.
    pub fn overrule(&mut self, forward: bool) -> Result<(), Error> {
        let Some(programme) = &mut self.piloted else { return Ok(()) };
        let actions = programme.step(self.moment.at_secs, forward, &self.instrument);
        self.do_piloted(actions)
    }

    /// These bars have begun.
    pub(super) fn follow_bars(&mut self, bars: &[BarLine]) -> Result<(), Error> {
        let Some(programme) = &mut self.piloted else { return Ok(()) };
        let actions = programme.hear(bars, self.moment.at_secs, &self.instrument);
        self.do_piloted(actions.into_iter().map(|(_, action)| action))
    }

    /// The stage is left or taken by hand: back to the gallery as it was.
    pub fn end_piloting(&mut self) -> Result<(), Error> {
        let Some(programme) = self.piloted.take() else { return Ok(()) };
        let actions = programme.end(&self.instrument);
        self.do_piloted(actions)
    }

    fn do_piloted(&mut self, actions: impl IntoIterator<Item = Action>) -> Result<(), Error> {
        let done = actions.into_iter().try_for_each(|action| self.instrument.apply(self.moment, action));
        self.follow_close_up();
        Ok(done?)
    }
}
