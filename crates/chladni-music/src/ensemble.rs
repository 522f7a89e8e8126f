//! The players of what is shown, kept in step with the instrument.

use std::sync::Arc;

use chladni_synth::Item;

use crate::gallery::{GalleryItem, ItemId};
use crate::{Bands, Dancer, Error, Instrument, Mapping, Player, Playing, blend};

/// Plays all items of the gallery that is shown, or the one on stage, for one dancer.
///
/// Players are compiled when an item, its mapping or a parameter has changed since the last
/// frame; a frame without changes allocates nothing.
#[derive(Clone, Debug)]
pub struct Ensemble {
    dancer: Arc<Dancer>,
    slots: Vec<Slot>,
    /// S items of the gallery, or the item on stage and the one that leaves it.
    items: Vec<Item>,
}

#[derive(Clone, Debug)]
struct Slot {
    id: ItemId,
    mapping: Mapping,
    playing: Playing,
    bands: usize,
    player: Player,
}

impl Ensemble {
    /// An ensemble for a dancer.
    pub fn new(dancer: Arc<Dancer>) -> Self {
        Self { dancer, slots: Vec::new(), items: Vec::new() }
    }

    /// The dancer.
    pub fn dancer(&self) -> &Arc<Dancer> {
        &self.dancer
    }

    /// What the sound does after `beat` beats: S items of the gallery in order, or one item
    /// while there is something on stage.
    pub fn play(&mut self, instrument: &Instrument, bands: &Bands<'_>, beat: f64) -> Result<&[Item], Error> {
        let playing = instrument.parameters().playing();
        let count = bands.mid.len();
        if let Some(scene) = instrument.scene(beat) {
            let cast = [scene.to, scene.from];
            let cast = if scene.weight < 1.0 { &cast[..] } else { &cast[..1] };
            for (slot, &id) in cast.iter().enumerate() {
                let found = instrument.item(id);
                let none = Error::NoSuch { what: "item with id", index: id as usize, count: 0 };
                self.seat(slot, found.ok_or(none)?, playing, count)?;
                self.slots[slot].player.play(bands, &mut self.items[slot])?;
            }
            if let [to, from, ..] = &mut self.items[..]
                && scene.weight < 1.0
            {
                blend(to, from, 1.0 - scene.weight)?;
            }
            return Ok(&self.items[..1]);
        }
        let shown = instrument.gallery().items();
        for (slot, item) in shown.iter().enumerate() {
            self.seat(slot, item, playing, count)?;
            self.slots[slot].player.play(bands, &mut self.items[slot])?;
        }
        Ok(&self.items[..shown.len()])
    }

    /// The players of what was played last, in the order of the items.
    pub fn players(&self) -> impl Iterator<Item = &Player> {
        self.slots.iter().map(|slot| &slot.player)
    }

    /// Makes sure that `slot` plays this item.
    fn seat(&mut self, slot: usize, item: &GalleryItem, playing: Playing, bands: usize) -> Result<(), Error> {
        if let Some(s) = self.slots.get(slot)
            && (s.id, s.bands, s.playing) == (item.id, bands, playing)
            && s.mapping == item.mapping
        {
            return Ok(());
        }
        let player = Player::new(&item.mapping, &self.dancer, bands, playing)?;
        let at_rest = player.item();
        let new = Slot { id: item.id, mapping: item.mapping.clone(), playing, bands, player };
        if slot < self.slots.len() {
            self.slots[slot] = new;
            self.items[slot] = at_rest;
        } else {
            self.slots.push(new);
            self.items.push(at_rest);
        }
        Ok(())
    }
}
