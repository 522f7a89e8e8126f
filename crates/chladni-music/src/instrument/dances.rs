//! Dances that are kept in several places: in generations, among the favorites and on stage.

use chladni_breeding::ItemId;

use super::Instrument;
use crate::gallery::GalleryItem;
use crate::{Mapping, MusicError};

impl Instrument {
    /// Loads a mapping, which may take the place of an item where there is no room for another generation.
    pub(super) fn load(&mut self, index: usize, name: &str, mapping: Mapping) -> Result<(), MusicError> {
        self.gallery.item_mut(index)?;
        self.keep_staged();
        Ok(self.gallery.load(index, name, mapping)?)
    }

    /// Keeps what the stage names, so that a dance goes on there whatever becomes of the gallery.
    pub(super) fn keep_staged(&mut self) {
        let staged: Vec<GalleryItem> = self.stage.items().filter_map(|id| self.item(id).cloned()).collect();
        self.staying = staged;
    }

    /// A dance wherever it is kept, because it is one: in all generations, as a favorite, and on stage.
    pub(super) fn copies_mut(&mut self, id: ItemId) -> impl Iterator<Item = &mut GalleryItem> {
        let elsewhere = self.favorites.iter_mut().chain(&mut self.staying);
        self.gallery.copies_mut(id).chain(elsewhere.filter(move |item| item.id == id))
    }

    pub(super) fn edit(&mut self, index: usize, change: impl Fn(&mut Mapping)) -> Result<(), MusicError> {
        let item = self.gallery.item_mut(index)?;
        let mut mapping = item.genome.clone();
        change(&mut mapping);
        mapping.validate()?;
        let id = item.id;
        for copy in self.copies_mut(id) {
            change(&mut copy.genome);
            copy.edited = true;
        }
        Ok(())
    }

    /// Changes the favorites, or how dances follow each other. The one that is shown in turn stays on stage.
    pub(super) fn staying_in_turn(
        &mut self,
        beat: f64,
        change: impl FnOnce(&mut Self) -> Result<(), MusicError>,
    ) -> Result<(), MusicError> {
        let shown = self.stage.in_turn(beat, &self.favorites, &self.parameters);
        change(self)?;
        if let Some((stage, scene)) = shown {
            self.stage = stage;
            self.stage.go_on_after(scene, beat, &self.favorites, &self.parameters);
            if self.stage.is_empty() {
                self.look.clear();
            }
        }
        Ok(())
    }
}
