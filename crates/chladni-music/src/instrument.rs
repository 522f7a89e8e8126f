//! The state that actions change, and the log that replays them.

mod dances;
mod past;

use std::collections::{BTreeMap, VecDeque};

use chladni_breeding::{ItemId, Origin, item_name};

use self::past::Past;
use crate::breeding::{SILENT, mutate_plainly};
use crate::gallery::{Gallery, GalleryItem, GalleryShape, initial};
use crate::stage::{Scene, Stage};
use crate::symmetry::spare_constants;
use crate::text_file::FORMAT_VERSION;
use crate::{
    Action, Ancestor, LoggedAction, Mapping, Moment, MusicError, Parameter, Parameters, Preset, Settings,
    Switch, VoiceSettings,
};

/// The longest name of a look, in characters.
const LOOK_NAME: usize = 64;

/// The longest lineage that is stored.
const MAX_LINEAGE: usize = 256;

/// The most voices that can be changed.
const MAX_VOICES: usize = 256;

/// The instrument's whole state: a pure function of shape, seed, size, the initial settings, and the actions
/// so far.
#[derive(Clone, Debug, PartialEq)]
pub struct Instrument {
    shape: GalleryShape,
    seed: u64,
    size: usize,
    /// The seeds that came after it, and since when.
    later_seeds: Vec<(Moment, u64)>,
    gallery: Gallery,
    favorites: Vec<GalleryItem>,
    beginning: Parameters,
    parameters: Parameters,
    /// Voices that were changed; the others do what [`VoiceSettings::initial`] says.
    voices: BTreeMap<usize, VoiceSettings>,
    stage: Stage,
    /// Items that the stage still names although they may have left the gallery, as they were then.
    staying: Vec<GalleryItem>,
    /// Of dances that were taken from presets, or have outlived their gallery.
    pasts: BTreeMap<ItemId, Past>,
    /// How often the sand was swept.
    sweeps: u32,
    /// The look that [`Action::SetLook`] put over the stage; empty if none.
    look: String,
    log: Vec<LoggedAction>,
}

impl Instrument {
    /// The initial gallery of `size` items for a body.
    ///
    /// # Errors
    /// A size that a gallery cannot have.
    pub fn new(seed: u64, size: usize, shape: GalleryShape) -> Result<Self, MusicError> {
        Self::beginning_with(Parameters::default(), seed, size, shape)
    }

    /// The same, with the knobs where `parameters` say.
    ///
    /// # Errors
    /// A size that a gallery cannot have.
    pub fn beginning_with(
        parameters: Parameters,
        seed: u64,
        size: usize,
        shape: GalleryShape,
    ) -> Result<Self, MusicError> {
        Ok(Self {
            gallery: Gallery::new(seed, size, initial(size, &shape))?,
            shape,
            seed,
            size,
            later_seeds: Vec::new(),
            favorites: Vec::new(),
            beginning: parameters.clone(),
            parameters,
            voices: BTreeMap::new(),
            stage: Stage::default(),
            staying: Vec::new(),
            pasts: BTreeMap::new(),
            sweeps: 0,
            look: String::new(),
            log: Vec::new(),
        })
    }

    /// The seed of all that is random from now on: that of the gallery.
    pub fn seed(&self) -> u64 {
        self.gallery.seed()
    }

    /// The seed at a time of the show, so far as it has gone.
    pub fn seed_at(&self, at_secs: f64) -> u64 {
        self.seed_since(|moment| moment.at_secs <= at_secs)
    }

    /// The seed that draws what a beat does. A new one holds from the next beat on, so that no movement is changed on its
    /// way.
    pub fn seed_of_beat(&self, beat: u64) -> u64 {
        self.seed_since(|moment| moment.at_beat <= beat as f64)
    }

    fn seed_since(&self, has_begun: impl Fn(Moment) -> bool) -> u64 {
        let last = self.later_seeds.iter().rev().find(|(since, _)| has_begun(*since));
        last.map_or(self.seed, |(_, seed)| *seed)
    }

    /// The seed it began with, from which its log is replayed.
    pub fn first_seed(&self) -> u64 {
        self.seed
    }

    /// The size it began with.
    pub fn size(&self) -> usize {
        self.size
    }

    /// The body that it plays on.
    pub fn shape(&self) -> &GalleryShape {
        &self.shape
    }

    /// Where the knobs stood in the beginning.
    pub fn beginning(&self) -> Settings {
        self.beginning.settings()
    }

    /// The gallery and its generations.
    pub fn gallery(&self) -> &Gallery {
        &self.gallery
    }

    /// Favorites in the order they were added.
    pub fn favorites(&self) -> &[GalleryItem] {
        &self.favorites
    }

    /// Whether an item is one of them.
    pub fn is_favorite(&self, id: ItemId) -> bool {
        self.favorites.iter().any(|known| known.id == id)
    }

    /// All knobs and switches.
    pub fn parameters(&self) -> &Parameters {
        &self.parameters
    }

    /// The driver and gain of a voice.
    pub fn voice(&self, voice: usize) -> VoiceSettings {
        self.voices.get(&voice).copied().unwrap_or_else(|| VoiceSettings::initial(voice))
    }

    /// How often the sand was swept off and poured anew.
    pub fn sweeps(&self) -> u32 {
        self.sweeps
    }

    /// The name of the look of the dance on stage; `None` where that is the show's own.
    pub fn look(&self) -> Option<&str> {
        Some(self.look.as_str()).filter(|look| !look.is_empty())
    }

    /// All that was done, oldest first.
    pub fn log(&self) -> &[LoggedAction] {
        &self.log
    }

    /// The scene on stage after `beat` beats; `None` while the gallery is shown.
    pub fn scene(&self, beat: f64) -> Option<Scene> {
        self.stage.scene(beat, &self.favorites, &self.parameters)
    }

    /// The place, among favorites or in the gallery on stage, of the dance that is shown there in turn after `beat`
    /// beats; `None` where none are shown in turn.
    pub fn place_in_turn(&self, beat: f64) -> Option<usize> {
        self.stage.place_in_turn(beat, &self.favorites, &self.parameters)
    }

    /// Whether a gallery is on stage through which the beat steps.
    pub fn steps_through_gallery(&self) -> bool {
        self.stage.shows_gallery() && self.parameters.is_on(Switch::BeatSteps)
    }

    /// The next item on stage, and how far the fader has brought it, in [0, 1].
    pub fn next_on_stage(&self) -> Option<(ItemId, f32)> {
        self.stage.next()
    }

    /// Where the fader stands, in [0, 1].
    pub fn fader(&self) -> f32 {
        self.stage.fader()
    }

    /// An item by id, among all generations, those on stage and favorites.
    pub fn item(&self, id: ItemId) -> Option<&GalleryItem> {
        let elsewhere = || self.staying.iter().chain(&self.favorites).find(|item| item.id == id);
        self.gallery.find(id).or_else(elsewhere)
    }

    /// The origin of `item`, then those of its ancestors, newest first; at most 256 entries.
    pub fn lineage(&self, item: &GalleryItem) -> Vec<Ancestor> {
        let mut lineage: Vec<Ancestor> = Vec::new();
        let mut queue = VecDeque::from([item.id]);
        while let Some(id) = queue.pop_front() {
            if lineage.len() == MAX_LINEAGE || lineage.iter().any(|a| a.id == id) {
                continue;
            }
            let found = if id == item.id { Some(item) } else { self.item(id) };
            let Some(found) = found else { continue };
            match found.origin {
                Origin::Bred { parents } => queue.extend(parents),
                Origin::Mutated { parent } => queue.push_back(parent),
                Origin::Initial { .. } | Origin::Loaded { .. } => {}
            }
            let (name, origin) = (found.name.clone(), found.origin.clone());
            lineage.push(Ancestor { id, name, edited: found.edited, origin });
        }
        lineage
    }

    /// A preset of an item, with its lineage and the knobs where they stand; [`tags`](Self::tags) has those of the
    /// preset that it was taken from. An item without a name gets one of its id, from 1: its place in the first gallery.
    pub fn preset(&self, item: &GalleryItem, tags: Vec<String>) -> Preset {
        let Past { seed, lineage, .. } = self.past(item);
        let number = item.id + 1;
        Preset {
            format_version: FORMAT_VERSION,
            name: if item.name.is_empty() { format!("item {number}") } else { item.name.clone() },
            tags,
            seed,
            lineage,
            mapping: Mapping {
                amplification: item.genome.amplification_on(self.shape.eigenvalues.len()),
                ..item.genome.clone()
            },
            waves_per_size: self.shape.waves_per_size(),
            settings: self.parameters.of_a_dance(),
        }
    }

    /// Does `action` and logs it, unless it puts a knob, a switch, a choice or the fader where it stands. On error nothing
    /// changes and nothing is logged.
    ///
    /// # Errors
    /// The action names a missing thing, or a value out of its range; or the gallery refuses, as where
    /// nothing was chosen to breed.
    pub fn apply(&mut self, moment: Moment, action: Action) -> Result<(), MusicError> {
        if self.changes_nothing(&action) {
            return Ok(());
        }
        self.act(moment, &action)?;
        self.log.push(LoggedAction { moment, action });
        Ok(())
    }

    /// Whether `action` changes nothing: a controller that repeats its value would fill the log.
    fn changes_nothing(&self, action: &Action) -> bool {
        match *action {
            // From their moment on, turns and transitions may be counted anew.
            Action::Set { parameter: Parameter::BeatsPerStep | Parameter::TransitionBeats, .. }
            | Action::Switch { switch: Switch::BeatSteps, .. } => false,
            Action::Set { parameter, value } => self.parameters.get(parameter).to_bits() == value.to_bits(),
            Action::Switch { switch, on } => self.parameters.is_on(switch) == on,
            Action::SetForm { form } => self.parameters.form == form,
            Action::SetChoir { choir } => self.parameters.choir == choir,
            Action::SetHarmonics { harmonics } => self.parameters.harmonics.unwrap_or(0) == harmonics,
            Action::Crossfade { share } => self.stage.rests_at(share),
            _ => false,
        }
    }

    /// All actions replayed, with the beat of each recomputed by `beats` from its moment: for a song whose
    /// beats become known while it plays.
    ///
    /// # Errors
    /// Bugs only: all of these actions were done before.
    pub fn with_beats(&self, beats: impl Fn(Moment) -> f64) -> Result<Self, MusicError> {
        let mut again =
            Self::beginning_with(self.beginning.clone(), self.seed, self.size, self.shape.clone())?;
        for line in &self.log {
            let moment = Moment { at_beat: beats(line.moment), ..line.moment };
            again.apply(moment, line.action.clone())?;
        }
        Ok(again)
    }

    fn act(&mut self, moment: Moment, action: &Action) -> Result<(), MusicError> {
        let waited = self.stage.next().is_some();
        match *action {
            Action::Choose { item, on } => self.gallery.choose(item, on)?,
            Action::Breed => self.gallery.breed()?,
            Action::BreedFrom { ref candidates } => self.gallery.breed_from(candidates)?,
            Action::ForgetPreference => self.gallery.forget_preference(),
            Action::BreedFromPlainly { ref candidates } => {
                self.gallery.breed_from_by(candidates, |parent, amount, rng| {
                    let mutant = mutate_plainly(parent, amount, rng);
                    if mutant.loudness() > 0.0 { mutant } else { parent.clone() }
                })?;
            }
            Action::Mutate { item, amount } => {
                let spare = spare_constants(&self.shape.eigenvalues) as u32;
                let is_seen = |mutant: &Mapping| mutant.loudness_from(spare + 1) >= SILENT;
                self.gallery.mutate_until(item, amount, is_seen)?;
            }
            Action::MutatePlainly { item, amount } => self.gallery.mutate_by(item, amount, mutate_plainly)?,
            Action::Lock { item, on } => self.gallery.item_mut(item)?.locked = on,
            Action::Favorite { item, on } => {
                let item = self.gallery.item_mut(item)?.clone();
                self.staying_in_turn(moment.at_beat, |instrument| {
                    instrument.favorites.retain(|f| f.id != item.id);
                    if on {
                        instrument.favorites.push(item);
                    }
                    Ok(())
                })?;
            }
            Action::Rename { item, ref name } => {
                let (id, name) = (self.gallery.item_mut(item)?.id, item_name(name));
                if let Some(own) = self.pasts.get_mut(&id).and_then(|past| past.lineage.first_mut()) {
                    own.name.clone_from(&name);
                }
                self.copies_mut(id).for_each(|copy| copy.name.clone_from(&name));
            }
            Action::GoTo { generation } => self.gallery.go_to(generation)?,
            Action::NewGallery { seed, size } => {
                let gallery = self.gallery.restart(seed, size, initial(size, &self.shape))?;
                if seed != self.seed() {
                    self.later_seeds.push((moment, seed));
                }
                self.keep_staged();
                self.keep_pasts();
                self.gallery = gallery;
            }
            Action::SetTransfer { item, ref transfer } => {
                self.edit(item, |m| m.transfer.clone_from(transfer))?;
            }
            Action::SetAmplification { item, ref amplification } => {
                self.edit(item, |m| m.amplification.clone_from(amplification))?;
            }
            Action::SetStereoMu { item, stereo_mu } => self.edit(item, |m| m.stereo_mu = stereo_mu)?,
            Action::SetItemGain { item, gain } => self.edit(item, |m| m.gain = gain)?,
            Action::Load { item, ref name, ref mapping } => {
                mapping.validate()?;
                self.load(item, name, mapping.clone())?;
            }
            Action::Take { item, ref preset } => {
                preset.validate()?;
                let mapping = preset.mapping_on(&self.shape);
                mapping.validate()?;
                self.load(item, &preset.name, mapping)?;
                self.pasts.insert(self.gallery.item_mut(item)?.id, Past::of(preset));
                self.parameters.apply(&preset.settings)?;
            }
            Action::Set { parameter: parameter @ Parameter::BeatsPerStep, value } => {
                self.staying_in_turn(moment.at_beat, |instrument| {
                    instrument.parameters.set(parameter, value)
                })?;
            }
            Action::Set { parameter: parameter @ Parameter::TransitionBeats, value } => {
                parameter.check(value)?;
                self.stage.keep_transition(moment.at_beat, &self.favorites, &self.parameters);
                self.parameters.set(parameter, value)?;
            }
            Action::Set { parameter, value } => self.parameters.set(parameter, value)?,
            Action::Switch { switch: switch @ Switch::BeatSteps, on } => {
                self.staying_in_turn(moment.at_beat, |instrument| {
                    instrument.parameters.switch(switch, on);
                    Ok(())
                })?;
            }
            Action::Switch { switch, on } => self.parameters.switch(switch, on),
            Action::SetForm { form } => self.parameters.form = form,
            Action::SetChoir { choir } => self.parameters.choir = choir,
            Action::SetHarmonics { harmonics } => {
                self.parameters.harmonics = (harmonics > 0).then_some(harmonics);
            }
            Action::SetVoice { voice, settings } => {
                if voice >= MAX_VOICES {
                    return Err(MusicError::NoSuch { what: "voice", index: voice, count: MAX_VOICES });
                }
                settings.validate()?;
                self.voices.insert(voice, settings);
            }
            Action::Perform { item } => {
                let id = self.gallery.item_mut(item)?.id;
                self.stage.show_item(id, moment.at_beat, &self.favorites, &self.parameters);
            }
            Action::PerformGallery { first } => {
                self.gallery.item_mut(first)?;
                let items = self.gallery.items().iter().map(|item| item.id).collect();
                let (favorites, parameters) = (&self.favorites, &self.parameters);
                self.stage.show_gallery(items, first, moment.at_beat, favorites, parameters);
            }
            Action::PerformFavorites { first } => {
                let count = self.favorites.len();
                if first >= count {
                    return Err(MusicError::NoSuch { what: "favorite", index: first, count });
                }
                self.stage.show_favorites(first, moment.at_beat, &self.favorites, &self.parameters);
            }
            Action::CueUp { item } => self.stage.cue_up(self.gallery.item_mut(item)?.id),
            Action::Go => {
                let Some((id, _)) = self.stage.next() else { return Err(MusicError::NothingNext) };
                self.stage.go(id, moment.at_beat, &self.favorites, &self.parameters);
            }
            Action::Crossfade { share } if share.is_finite() => self.stage.fade(share, moment.at_beat),
            Action::Crossfade { share } => {
                let (value, range) = (f64::from(share), "the finite numbers".to_owned());
                return Err(MusicError::OutOfRange { name: "the fader", value, range });
            }
            Action::LeaveStage => self.stage.clear(),
            Action::Sweep => self.sweeps = self.sweeps.wrapping_add(1),
            Action::SetLook { ref look } => {
                self.look = look.chars().filter(|c| !c.is_control()).take(LOOK_NAME).collect();
            }
        }
        // Another dance comes in the show's own look; who wants another says so afterwards.
        let is_faded_in = matches!(action, Action::Crossfade { .. }) && waited && self.stage.next().is_none();
        if action.opens_stage() || *action == Action::LeaveStage || is_faded_in {
            self.look.clear();
        }
        self.staying.retain(|item| self.stage.items().any(|id| id == item.id));
        Ok(())
    }
}
