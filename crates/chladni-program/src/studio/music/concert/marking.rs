//! The view, and the dances that are marked, chosen and loved.

use chladni_music::{Action, GalleryItem, ItemId, Origin, Parameter, experiment};

use super::super::view::View;
use super::Concert;

/// The marks of an item.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Marks {
    /// As a parent.
    pub chosen: bool,
    /// As a favorite.
    pub favorite: bool,
    /// As one that stays in its place.
    pub locked: bool,
}

impl Concert {
    /// The item that keys act on.
    pub fn marked(&self) -> Option<usize> {
        match self.view {
            View::CloseUp(item) => Some(item),
            View::Gallery => self.marked,
            View::Harmonics(_) => None,
        }
    }

    /// Marks the item that lies a number of columns to the right and rows below the one that is marked.
    pub fn mark_neighbor(&mut self, right: isize, down: isize) {
        let count = self.instrument.gallery().items().len();
        let step = right + down * self.columns as isize;
        let next = self.marked.map_or(Some(0), |item| item.checked_add_signed(step));
        self.marked = next.filter(|&item| item < count).or(self.marked);
    }

    /// The content of the middle.
    pub fn view(&self) -> View {
        self.view
    }

    /// Shows something else; an unfinished stroke is dropped.
    pub fn look_at(&mut self, view: View) {
        self.view = view;
        self.draft = None;
        self.marked = None;
        self.close_up = match view {
            View::CloseUp(place) => self.instrument.gallery().items().get(place).map(|item| item.id),
            View::Gallery | View::Harmonics(_) => None,
        };
    }

    /// The gallery may have changed: a close-up stays with its dance. Where that has gone, it shows the one in its place
    /// that a small change made of it, or of which it was made; else it ends.
    pub(super) fn follow_close_up(&mut self) {
        let (View::CloseUp(place), Some(shown)) = (self.view, self.close_up) else { return };
        let items = self.instrument.gallery().items();
        if let Some(place) = items.iter().position(|item| item.id == shown) {
            self.view = View::CloseUp(place);
            return;
        }
        let before = self.instrument.item(shown);
        let is_kin = |item: &&GalleryItem| {
            is_changed_from(item, shown) || before.is_some_and(|before| is_changed_from(before, item.id))
        };
        let kin = items.get(place).filter(is_kin).map(|item| item.id);
        match kin {
            Some(kin) => (self.close_up, self.draft) = (Some(kin), None),
            None => self.look_at(View::Gallery),
        }
    }

    /// The marks of an item.
    pub fn marks(&self, item: usize) -> Marks {
        let Some(item) = self.instrument.gallery().items().get(item) else { return Marks::default() };
        let favorite = self.instrument.is_favorite(item.id);
        Marks { chosen: item.chosen, favorite, locked: item.locked }
    }

    /// Actions that set this body up for Chladni's experiment.
    pub fn experiment(&self) -> Vec<Action> {
        let bands = self.instrument.parameters().get(Parameter::Bands).round() as usize;
        let dancer = self.ensemble.dancer();
        experiment(&dancer.eigenvalues, &dancer.classes, bands)
    }

    /// The action that brings the dance after or before the one on stage: of the gallery as it is now where the beat steps
    /// through a gallery, else of the favorites.
    pub fn next_in_turn(&self, forward: bool) -> Option<Action> {
        if !self.instrument.steps_through_gallery() {
            return self.next_favorite(forward);
        }
        let first = self.beside_the_one_on_stage(self.instrument.gallery().items(), forward)?;
        Some(Action::PerformGallery { first })
    }

    /// The action that puts the favorite after or before the one on stage there; none without favorites.
    pub fn next_favorite(&self, forward: bool) -> Option<Action> {
        let first = self.beside_the_one_on_stage(self.instrument.favorites(), forward)?;
        Some(Action::PerformFavorites { first })
    }

    /// Index of the dance after or before the one on stage; the first where that is none of these.
    fn beside_the_one_on_stage(&self, dances: &[GalleryItem], forward: bool) -> Option<usize> {
        let count = dances.len();
        let on_stage = self.on_stage_now();
        let now = dances.iter().position(|item| Some(item.id) == on_stage);
        let step = if forward { 1 } else { count.checked_sub(1)? };
        (count > 0).then(|| now.map_or(0, |now| (now + step) % count))
    }
}

fn is_changed_from(item: &GalleryItem, parent: ItemId) -> bool {
    item.origin == Origin::Mutated { parent }
}
