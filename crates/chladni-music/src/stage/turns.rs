//! Dances in turn, whose list and steps may change while one of them is shown.

use chladni_breeding::ItemId;

use super::{List, Scene, Shown, Stage};
use crate::gallery::GalleryItem;
use crate::{Parameter, Parameters, Switch};

/// The beats that each dance is shown.
pub(super) fn beats_per_step(parameters: &Parameters) -> f64 {
    f64::from(parameters.get(Parameter::BeatsPerStep).round()).max(1.0)
}

/// How many dances have gone by, `gone` beats after the first came on stage.
pub(super) fn steps(gone: f64, parameters: &Parameters) -> f64 {
    if parameters.is_on(Switch::BeatSteps) { (gone / beats_per_step(parameters)).floor() } else { 0.0 }
}

/// The place of a dance in the list of `count`, `step` after the `first`.
pub(super) fn index(first: usize, step: usize, count: usize) -> usize {
    // A show file may hold any beat; a sum of remainders cannot overflow.
    (first % count + step % count) % count
}

impl Stage {
    /// How many dances a list has.
    pub(super) fn count(&self, list: List, favorites: &[GalleryItem]) -> usize {
        match list {
            List::Favorites => favorites.len(),
            List::Gallery => self.gallery.len(),
        }
    }

    /// The dance at a place of a list.
    pub(super) fn at(&self, list: List, place: usize, favorites: &[GalleryItem]) -> Option<ItemId> {
        match list {
            List::Favorites => favorites.get(place).map(|item| item.id),
            List::Gallery => self.gallery.get(place).copied(),
        }
    }

    /// The place in its list of the dance that is shown in turn.
    pub(crate) fn place_in_turn(
        &self,
        beat: f64,
        favorites: &[GalleryItem],
        parameters: &Parameters,
    ) -> Option<usize> {
        let Some(Shown::InTurn(list, first)) = self.shown else { return None };
        let count = self.count(list, favorites);
        let step = steps((beat - self.since_beat).max(0.0), parameters);
        (count > 0).then(|| index(first, step as usize, count))
    }

    /// The stage of now, counted from the dance that is shown, and the scene; `None` where none are shown in turn. With
    /// both, [`go_on_after`](Self::go_on_after) stays with that dance.
    pub(crate) fn in_turn(
        &self,
        beat: f64,
        favorites: &[GalleryItem],
        parameters: &Parameters,
    ) -> Option<(Self, Scene)> {
        let Some(Shown::InTurn(list, first)) = self.shown else { return None };
        let scene = self.by_beats(beat, favorites, parameters)?;
        let mut stage = self.clone();
        let step = steps((beat - self.since_beat).max(0.0), parameters);
        if step >= 1.0 {
            let now = index(first, step as usize, self.count(list, favorites));
            stage.shown = Some(Shown::InTurn(list, now));
            stage.since_beat += step * beats_per_step(parameters);
            (stage.before, stage.comes_within) = (Some(scene.from), None);
        }
        stage.comes_within = Some(stage.transition_beats(parameters));
        Some((stage, scene))
    }

    /// Goes on with the dance of `scene` in a list, or with steps, that are different since; if it is in the list no
    /// more, with the one after it, and without any, the stage is left.
    pub(crate) fn go_on_after(
        &mut self,
        scene: Scene,
        beat: f64,
        favorites: &[GalleryItem],
        parameters: &Parameters,
    ) {
        let Some(Shown::InTurn(list, was)) = self.shown else { return };
        let count = self.count(list, favorites);
        if count == 0 {
            return self.clear();
        }
        let Some(is) = (0..count).find(|&place| self.at(list, place, favorites) == Some(scene.to)) else {
            self.shown = Some(Shown::InTurn(list, was % count));
            (self.since_beat, self.comes_within) = (beat, None);
            self.before = Some(if scene.weight < 0.5 { scene.from } else { scene.to });
            return;
        };
        self.shown = Some(Shown::InTurn(list, is));
        let gone = (beat - self.since_beat).max(0.0);
        if steps(gone, parameters) >= 1.0 {
            // It has been there for longer than a step is now. Cuts keep their place within the beat; where it is still
            // coming, it comes from its beginning.
            self.since_beat += gone.floor();
            (self.before, self.comes_within) = ((scene.weight < 1.0).then_some(scene.from), None);
        }
    }
}
