//! What is known of dances that come from elsewhere: from presets, and from galleries that are gone.

use chladni_breeding::ItemId;

use super::Instrument;
use crate::gallery::GalleryItem;
use crate::{Ancestor, Preset};

/// What a preset of a dance says of its past.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Past {
    /// The seed of its gallery.
    pub seed: u64,
    /// Keywords to find it by.
    pub tags: Vec<String>,
    /// Its origin, then those of its ancestors, newest first.
    pub lineage: Vec<Ancestor>,
}

impl Past {
    /// That of the dance of a preset.
    pub fn of(preset: &Preset) -> Self {
        Self { seed: preset.seed, tags: preset.tags.clone(), lineage: preset.lineage.clone() }
    }
}

impl Instrument {
    /// The keywords of the preset that a dance was taken from; none for other dances.
    pub fn tags(&self, item: ItemId) -> Vec<String> {
        self.pasts.get(&item).map_or_else(Vec::new, |past| past.tags.clone())
    }

    pub(super) fn past(&self, item: &GalleryItem) -> Past {
        let Some(known) = self.pasts.get(&item.id) else {
            return Past { seed: self.seed(), tags: Vec::new(), lineage: self.lineage(item) };
        };
        let mut past = known.clone();
        match past.lineage.first_mut() {
            Some(own) => own.edited |= item.edited,
            // Presets of the repertoire have no ancestors.
            None => past.lineage = self.lineage(item),
        }
        past
    }

    /// Keeps the past of the dances that outlive their gallery: favorites, and those on stage.
    pub(super) fn keep_pasts(&mut self) {
        let outliving = self.favorites.iter().chain(&self.staying);
        self.pasts = outliving.map(|item| (item.id, self.past(item))).collect();
    }
}
