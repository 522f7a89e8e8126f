//! What of the show no file has.

use chladni_music::{Action, LoggedAction};

use super::Concert;

impl Concert {
    /// Marks all actions as saved.
    pub fn mark_saved(&mut self) {
        (self.saved, self.is_of_a_file) = (self.instrument.log().len(), true);
    }

    /// No file of the user has any of the actions, though a copy had.
    pub fn mark_unsaved(&mut self) {
        (self.saved, self.is_of_a_file) = (0, true);
    }

    /// Whether there are favorites, names or hand-drawn curves that are not saved; of a show that has a file, also
    /// whether there are children.
    pub fn has_unsaved_work(&self) -> bool {
        self.has_unsaved_work_since(0)
    }

    /// The same of what was done after this number of actions.
    pub fn has_unsaved_work_since(&self, count: usize) -> bool {
        self.has_since(count.max(self.saved), |action| {
            is_by_hand(action) || self.is_of_a_file && action.is_bred()
        })
    }

    /// Whether there is anything that was not saved and would be missed.
    pub fn has_changed(&self) -> bool {
        self.has_since(self.saved, |action| is_by_hand(action) || action.is_bred())
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

#[cfg(test)]
mod tests {
    use super::*;
    use chladni_music::Moment;

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
