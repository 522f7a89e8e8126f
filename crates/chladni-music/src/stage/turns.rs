//! Favorites in turn, whose list and steps may change while one of them is shown.

use super::{Scene, Shown, Stage};
use crate::gallery::GalleryItem;
use crate::{Parameter, Parameters, Switch};

/// The beats that each favorite is shown.
pub(super) fn beats_per_step(parameters: &Parameters) -> f64 {
    f64::from(parameters.get(Parameter::BeatsPerStep).round()).max(1.0)
}

/// How many favorites have gone by, `gone` beats after the first came on stage.
pub(super) fn steps(gone: f64, parameters: &Parameters) -> f64 {
    if parameters.is_on(Switch::BeatSteps) { (gone / beats_per_step(parameters)).floor() } else { 0.0 }
}

/// The place of a favorite in the list of `count`, `step` after the `first`.
pub(super) fn index(first: usize, step: usize, count: usize) -> usize {
    // A show file may hold any beat; a sum of remainders cannot overflow.
    (first % count + step % count) % count
}

impl Stage {
    /// The stage of now, counted from the favorite that is shown, and the scene; `None` where no favorites are shown in
    /// turn. With both, [`go_on_after`](Self::go_on_after) stays with that favorite.
    pub(crate) fn in_turn(
        &self,
        beat: f64,
        favorites: &[GalleryItem],
        parameters: &Parameters,
    ) -> Option<(Self, Scene)> {
        let Some(Shown::Favorites(first)) = self.shown else { return None };
        let scene = self.by_beats(beat, favorites, parameters)?;
        let mut stage = self.clone();
        let step = steps((beat - self.since_beat).max(0.0), parameters);
        if step >= 1.0 {
            stage.shown = Some(Shown::Favorites(index(first, step as usize, favorites.len())));
            stage.since_beat += step * beats_per_step(parameters);
            stage.before = Some(scene.from);
        }
        Some((stage, scene))
    }

    /// Goes on with the favorite of `scene` in a list, or with steps, that are different since; if it is in the list no
    /// more, with the one after it, and without any, the stage is left.
    pub(crate) fn go_on_after(
        &mut self,
        scene: Scene,
        beat: f64,
        favorites: &[GalleryItem],
        parameters: &Parameters,
    ) {
        let Some(Shown::Favorites(was)) = self.shown else { return };
        if favorites.is_empty() {
            return self.clear();
        }
        let Some(is) = favorites.iter().position(|item| item.id == scene.to) else {
            self.shown = Some(Shown::Favorites(was % favorites.len()));
            self.since_beat = beat;
            self.before = Some(if scene.weight < 0.5 { scene.from } else { scene.to });
            return;
        };
        self.shown = Some(Shown::Favorites(is));
        let gone = (beat - self.since_beat).max(0.0);
        if steps(gone, parameters) >= 1.0 {
            // It has been there for longer than a step is now. Cuts keep their place within the beat; where it is still coming,
            // it comes from its beginning.
            self.since_beat += gone.floor();
            self.before = (scene.weight < 1.0).then_some(scene.from);
        }
    }
}
