//! What of the show no file has.

use chladni_music::{Action, LoggedAction, MusicError};

use super::Concert;

impl Concert {
    /// Marks all actions as saved.
    pub fn mark_saved(&mut self) {
        (self.saved, self.is_of_a_file) = (self.instrument.log().len(), true);
    }

    /// No file of the user has any of the actions, though a copy had.
    pub fn mark_unsaved(&mut self) {
        (self.saved, self.is_of_a_file) = (0, true);
        self.changed = self.instrument.log().len();
    }

    /// Applies an action of a person, and notes it where it changes how the show plays.
    pub(super) fn apply_by_hand(&mut self, action: Action) -> Result<(), MusicError> {
        let (changes, count) = (changes_playing(&action), self.instrument.log().len());
        self.instrument.apply(self.moment, action)?;
        let now = self.instrument.log().len();
        // A knob that is put where it stands is not logged.
        if changes && now > count {
            self.changed = now;
        }
        Ok(())
    }

    /// Whether there are favorites, names or hand-drawn curves that are not saved; of a show that has a file, also
    /// whether there are children, or a person has changed how it plays.
    pub fn has_unsaved_work(&self) -> bool {
        self.has_unsaved_work_since(0)
    }

    /// The same of what was done after this number of actions.
    pub fn has_unsaved_work_since(&self, count: usize) -> bool {
        let since = count.max(self.saved);
        let differs = self.is_of_a_file && (since < self.changed || self.has_since(since, Action::is_bred));
        differs || self.has_since(since, is_by_hand)
    }

    /// Whether there is anything that was not saved and would be missed.
    pub fn has_changed(&self) -> bool {
        let counts = |action: &Action| is_by_hand(action) || action.is_bred();
        self.saved < self.changed || self.has_since(self.saved, counts)
    }

    /// Whether another gallery would take away dances that no file has. Favorites would stay.
    pub fn has_unsaved_gallery(&self) -> bool {
        self.has_since(gallery_since(self.instrument.log()).max(self.saved), is_of_gallery)
    }

    fn has_since(&self, count: usize, counts: impl Fn(&Action) -> bool) -> bool {
        self.instrument.log().iter().skip(count).any(|line| counts(&line.action))
    }
}

/// The number of actions that came before the gallery that is shown.
fn gallery_since(log: &[LoggedAction]) -> usize {
    log.iter().rposition(|line| matches!(line.action, Action::NewGallery { .. })).map_or(0, |last| last + 1)
}

/// Whether what an action makes goes with the gallery.
fn is_of_gallery(action: &Action) -> bool {
    action.is_bred() || is_by_hand(action) && !matches!(action, Action::Favorite { .. })
}

fn is_by_hand(action: &Action) -> bool {
    matches!(
        action,
        Action::Favorite { .. }
            | Action::Rename { .. }
            | Action::SetTransfer { .. }
            | Action::SetAmplification { .. }
            | Action::SetStereoMu { .. }
            | Action::SetItemGain { .. }
    )
}

/// Whether an action changes how the show plays, whatever comes on stage.
fn changes_playing(action: &Action) -> bool {
    matches!(
        action,
        Action::Set { .. }
            | Action::Switch { .. }
            | Action::SetForm { .. }
            | Action::SetChoir { .. }
            | Action::SetHarmonics { .. }
            | Action::SetVoice { .. }
            | Action::NewGallery { .. }
            | Action::Load { .. }
            | Action::Take { .. }
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use chladni_music::{Moment, Parameter, Show};
    use chladni_view::Look;

    #[test]
    fn knobs_that_a_person_turned_are_copied_and_asked_about_where_the_show_has_a_file() {
        let mut concert = Concert::of_ball(32).unwrap();
        let turn = |concert: &mut Concert, value| {
            concert.act(Action::Set { parameter: Parameter::Gain, value }).unwrap();
        };
        let state = |concert: &Concert| (concert.has_changed(), concert.has_unsaved_work());
        assert_eq!(state(&concert), (false, false));
        turn(&mut concert, 7.0);
        assert_eq!(state(&concert), (true, false), "it has no file");
        concert.mark_saved();
        turn(&mut concert, 7.0);
        assert_eq!(state(&concert), (false, false), "it stood there");
        // The autopilot turns knobs, too, and turns them back.
        concert.pilot(Vec::new(), &Look::AURORA).unwrap();
        assert!(concert.is_piloted());
        concert.end_piloting().unwrap();
        assert_eq!(state(&concert), (false, false), "nobody did anything");
        turn(&mut concert, 3.0);
        assert_eq!(state(&concert), (true, true));
        let mut other = Concert::of_ball(32).unwrap();
        other.go_on_from(&concert).unwrap();
        assert_eq!(state(&other), (true, true), "on another shape");
        let show = Show::of(concert.instrument());
        concert.replay(&show).unwrap();
        assert_eq!(state(&concert), (false, false), "it was only opened");
        concert.mark_unsaved();
        assert_eq!(state(&concert), (true, true), "recovered");
    }

    #[test]
    fn what_was_bred_since_a_gallery_began_goes_with_it_and_favorites_do_not() {
        let begin = Action::NewGallery { seed: 2, size: 6 };
        let favorite = Action::Favorite { item: 0, on: true };
        let log = [Action::Breed, begin, favorite.clone(), Action::Breed];
        let log = log.map(|action| LoggedAction { moment: Moment::default(), action });
        let since = [1, 2, 4].map(|count| gallery_since(log.get(..count).unwrap()));
        assert_eq!(since, [0, 2, 2]);
        let renamed = Action::Rename { item: 0, name: "squid".into() };
        assert!(is_of_gallery(&Action::Breed) && is_of_gallery(&renamed) && !is_of_gallery(&favorite));
    }
}
