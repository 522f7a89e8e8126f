//! The players of the shown items, kept in step with the instrument.

use std::sync::Arc;

use chladni_synth::{Item, Term};

use crate::voice::{Voice, VoiceSettings, Voices};
use crate::{
    Bands, Beat, Dancer, Instrument, Mapping, MusicError, Parameter, Player, Playing, Settings, blend,
};
use chladni_breeding::ItemId;

/// Plays all items of the gallery that is shown, or the one on stage, for one dancer.
///
/// Players are compiled when an item, its mapping or a parameter has changed since the last
/// frame; a frame without changes allocates nothing, but for the voices of each item.
#[derive(Clone, Debug)]
pub struct Ensemble {
    dancer: Arc<Dancer>,
    slots: Vec<Slot>,
    /// S items of the gallery, or the item on stage and the one leaving it.
    items: Vec<Item>,
    /// Plays the mapping that is tried out.
    soloist: Option<(Slot, [Item; 1])>,
    voices: Voices,
    voice_item: Item,
    most_harmonics: Option<u32>,
    wanted: u32,
}

#[derive(Clone, Debug)]
struct Slot {
    /// `None` for a mapping that is not in the gallery.
    id: Option<ItemId>,
    mapping: Mapping,
    playing: Playing,
    bands: usize,
    player: Player,
}

impl Ensemble {
    /// An ensemble for a dancer.
    pub fn new(dancer: Arc<Dancer>) -> Self {
        let voices = Voices::silent(&dancer);
        Self {
            dancer,
            slots: Vec::new(),
            items: Vec::new(),
            soloist: None,
            voices,
            voice_item: Item::default(),
            most_harmonics: None,
            wanted: 0,
        }
    }

    /// Adds deformations of the dancer, such as the layers of a caricature, as voices: they move
    /// every item on top of its mapping, as [`Instrument::voice`] says.
    ///
    /// # Errors
    /// A term has more coefficients than the dancer has harmonics.
    pub fn with_voices(mut self, terms: Vec<Term>) -> Result<Self, MusicError> {
        let settings = VoiceSettings::initial;
        let voices = terms.into_iter().enumerate();
        let voices = voices.map(|(i, term)| Voice { term, settings: settings(i) }).collect();
        self.voices = Voices::new(voices, &self.dancer, Parameter::Limit.initial())?;
        self.voice_item = self.voices.item();
        Ok(self)
    }

    /// The dancer.
    pub fn dancer(&self) -> &Arc<Dancer> {
        &self.dancer
    }

    /// Gives all parts to `dancer`, of the same body, which may stand otherwise. Mappings are compiled anew for it.
    pub fn give_to(&mut self, dancer: Arc<Dancer>) {
        (self.dancer, self.soloist) = (dancer, None);
        self.slots.clear();
        self.items.clear();
    }

    /// Limits the number of harmonics of mappings and voices, whatever the instrument asks for, on a machine that does not
    /// keep up. `None` removes the limit.
    pub fn use_at_most(&mut self, harmonics: Option<u32>) {
        self.most_harmonics = harmonics;
    }

    /// How many harmonics the items that were played last use without the limit of [`use_at_most`](Self::use_at_most),
    /// counted up to the highest. Only a limit below that saves work: harmonics without weight cost nothing.
    pub fn harmonics_wanted(&self) -> u32 {
        self.wanted
    }

    /// The items that `bands` and `beat` drive: S items of the gallery in order, or one while something is on
    /// stage.
    ///
    /// # Errors
    /// As [`play_gallery`](Self::play_gallery).
    pub fn play(
        &mut self,
        instrument: &Instrument,
        bands: &Bands<'_>,
        beat: Beat,
    ) -> Result<&[Item], MusicError> {
        let Some(scene) = instrument.scene(beat.count) else {
            return self.play_gallery(instrument, bands, beat);
        };
        let playing = self.within(instrument.parameters().playing());
        self.play_voices(instrument, playing.limit, bands, beat)?;
        let cast = [scene.to, scene.from];
        let cast = if scene.weight < 1.0 { &cast[..] } else { &cast[..1] };
        for (slot, &id) in cast.iter().enumerate() {
            let none = MusicError::NoSuch { what: "item with id", index: id as usize, count: 0 };
            let found = instrument.item(id).ok_or(none)?;
            self.play_slot(slot, id, &found.genome, playing, bands)?;
        }
        self.wanted = wanted(&self.slots[..cast.len()], instrument.parameters().harmonics, &self.voices);
        if let [to, from, ..] = &mut self.items[..]
            && scene.weight < 1.0
        {
            blend(to, from, 1.0 - scene.weight)?;
        }
        Ok(self.voiced(1))
    }

    /// The items of the gallery, whatever is on stage.
    ///
    /// # Errors
    /// Bands of another number than the mappings were compiled for, or another dancer's mappings.
    pub fn play_gallery(
        &mut self,
        instrument: &Instrument,
        bands: &Bands<'_>,
        beat: Beat,
    ) -> Result<&[Item], MusicError> {
        let playing = self.within(instrument.parameters().playing());
        self.play_voices(instrument, playing.limit, bands, beat)?;
        let shown = instrument.gallery().items();
        for (slot, item) in shown.iter().enumerate() {
            self.play_slot(slot, item.id, &item.genome, playing, bands)?;
        }
        self.wanted = wanted(&self.slots[..shown.len()], instrument.parameters().harmonics, &self.voices);
        Ok(self.voiced(shown.len()))
    }

    /// The first `count` items, with the voices.
    fn voiced(&mut self, count: usize) -> &[Item] {
        for item in &mut self.items[..count] {
            self.voices.join(&self.voice_item, item);
        }
        &self.items[..count]
    }

    /// Plays a mapping that is not in a gallery, to try it out, with the knobs set to `settings`: one item.
    ///
    /// # Errors
    /// A mapping or a setting out of its ranges.
    pub fn audition(
        &mut self,
        instrument: &Instrument,
        (mapping, settings): (&Mapping, &Settings),
        bands: &Bands<'_>,
        beat: Beat,
    ) -> Result<&[Item], MusicError> {
        let mut parameters = instrument.parameters().clone();
        parameters.apply(settings)?;
        let playing = self.within(parameters.playing());
        self.play_voices(instrument, playing.limit, bands, beat)?;
        let soloist = self.soloist.take().filter(|(slot, _)| slot.plays(None, mapping, playing, bands));
        let (mut slot, mut items) = match soloist {
            Some(ready) => ready,
            None => {
                let slot = Slot::new(None, mapping, &self.dancer, playing, bands)?;
                let item = slot.player.item();
                (slot, [item])
            }
        };
        self.wanted = wanted(std::slice::from_ref(&slot), parameters.harmonics, &self.voices);
        items[0].terms.truncate(slot.player.terms());
        slot.player.play(bands, &mut items[0])?;
        self.voices.join(&self.voice_item, &mut items[0]);
        Ok(&self.soloist.insert((slot, items)).1)
    }

    /// `playing`, limited to the harmonics that the machine can keep up with.
    fn within(&self, playing: Playing) -> Playing {
        let harmonics = match (playing.harmonics, self.most_harmonics) {
            (Some(asked), Some(most)) => Some(asked.min(most)),
            (asked, most) => asked.or(most),
        };
        Playing { harmonics, ..playing }
    }

    fn play_voices(
        &mut self,
        instrument: &Instrument,
        limit: f32,
        bands: &Bands<'_>,
        beat: Beat,
    ) -> Result<(), MusicError> {
        if self.voices.count() == 0 {
            return Ok(());
        }
        self.voices.set_limit(limit)?;
        // The harmonics of a unison are left out together, as in mappings.
        let most = self.most_harmonics.filter(|most| (*most as usize) < self.dancer.harmonics());
        self.voices.use_at_most(most.map(|most| self.dancer.unison(most).start as usize));
        for voice in 0..self.voices.count() {
            self.voices.tune(voice, instrument.voice(voice))?;
        }
        self.voices.play(bands, beat, &mut self.voice_item)?;
        Ok(())
    }

    /// Compiles the mapping into `slot` if it has changed, and plays it.
    fn play_slot(
        &mut self,
        slot: usize,
        id: ItemId,
        mapping: &Mapping,
        playing: Playing,
        bands: &Bands<'_>,
    ) -> Result<(), MusicError> {
        if !self.slots.get(slot).is_some_and(|s| s.plays(Some(id), mapping, playing, bands)) {
            let new = Slot::new(Some(id), mapping, &self.dancer, playing, bands)?;
            let at_rest = new.player.item();
            if slot < self.slots.len() {
                self.slots[slot] = new;
                self.items[slot] = at_rest;
            } else {
                self.slots.push(new);
                self.items.push(at_rest);
            }
        }
        let (player, item) = (&mut self.slots[slot].player, &mut self.items[slot]);
        // Drop the voices of the previous frame.
        item.terms.truncate(player.terms());
        player.play(bands, item)?;
        Ok(())
    }
}

/// How many harmonics these mappings, which may use `asked` of them, and the voices use, counted up to the highest.
fn wanted(slots: &[Slot], asked: Option<u32>, voices: &Voices) -> u32 {
    let highest = slots.iter().map(|slot| slot.player.harmonics_wanted()).max().unwrap_or(0);
    highest.min(asked.unwrap_or(u32::MAX)).max(voices.harmonics_wanted())
}

impl Slot {
    fn new(
        id: Option<ItemId>,
        mapping: &Mapping,
        dancer: &Arc<Dancer>,
        playing: Playing,
        bands: &Bands<'_>,
    ) -> Result<Self, MusicError> {
        let bands = bands.mid.len();
        let player = Player::new(mapping, dancer, bands, playing)?;
        Ok(Self { id, mapping: mapping.clone(), playing, bands, player })
    }

    fn plays(&self, id: Option<ItemId>, mapping: &Mapping, playing: Playing, bands: &Bands<'_>) -> bool {
        (self.id, self.bands, self.playing) == (id, bands.mid.len(), playing) && self.mapping == *mapping
    }
}
