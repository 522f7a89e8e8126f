//! Actions, the state they change, and the log that replays them.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use chladni_breeding::ItemId;

use crate::gallery::{Gallery, GalleryItem, GalleryShape, initial};
use crate::stage::{Scene, Stage};
use crate::{
    Choir, Form, Mapping, MusicError, Parameter, Parameters, Preset, Settings, Switch, VoiceSettings,
};

/// Everything a user can do to the instrument. The window emits these; only
/// [`Instrument::apply`] changes state. Items are named by their place in the gallery shown.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "do", rename_all = "kebab-case", deny_unknown_fields)]
#[allow(missing_docs, reason = "the fields say what the variants do")]
pub enum Action {
    /// Chooses a parent, or unchooses it.
    Choose { item: usize, on: bool },
    /// Replaces all items that are not locked by children of the chosen ones.
    Breed,
    /// Replaces all items that are not locked by the candidates of these numbers, one for each place
    /// ([`Gallery::candidates`], [`suggest`](crate::suggest)).
    BreedFrom { candidates: Vec<u16> },
    /// Choices made so far no longer count when children are suggested.
    ForgetPreference,
    /// Changes one item a little at random; amount in [0, 1].
    Mutate { item: usize, amount: f32 },
    /// Locks an item in its place, or unlocks it.
    Lock { item: usize, on: bool },
    /// Adds an item to the favorites, or removes it.
    #[serde(alias = "favourite")]
    Favorite { item: usize, on: bool },
    /// Names an item.
    Rename { item: usize, name: String },
    /// Shows a generation, counted from 0.
    GoTo { generation: usize },
    /// Starts over with another seed and size.
    NewGallery { seed: u64, size: usize },
    /// Draws t by hand.
    SetTransfer { item: usize, transfer: Vec<f32> },
    /// Draws a by hand.
    SetAmplification { item: usize, amplification: Vec<f32> },
    /// Turns an item's μ.
    SetStereoMu { item: usize, stereo_mu: f32 },
    /// Turns an item's own gain.
    SetItemGain { item: usize, gain: f32 },
    /// Puts a mapping made for this body in an item's place.
    Load { item: usize, name: String, mapping: Mapping },
    /// Puts a preset in an item's place, and sets the knobs that it was made with.
    Take { item: usize, preset: Box<Preset> },
    /// Turns a knob.
    Set { parameter: Parameter, value: f32 },
    /// Turns a switch.
    Switch { switch: Switch, on: bool },
    /// Chooses the form.
    SetForm { form: Form },
    /// Chooses which harmonics may sound.
    SetChoir { choir: Choir },
    /// Uses only the first `harmonics` harmonics; 0 is all.
    SetHarmonics { harmonics: u32 },
    /// Lets a voice, such as a layer of a caricature, listen to something else.
    SetVoice { voice: usize, settings: VoiceSettings },
    /// Puts an item of the gallery on stage.
    Perform { item: usize },
    /// Puts the favorites on stage, beginning with one.
    #[serde(alias = "perform-favourites")]
    PerformFavorites { first: usize },
    /// Says which item of the gallery comes on stage next.
    CueUp { item: usize },
    /// Brings the next one on stage, within the beats of a transition.
    Go,
    /// Moves the fader between the one on stage and the next; share in [0, 1].
    Crossfade { share: f32 },
    /// Back to the gallery.
    LeaveStage,
    /// Sweeps the sand off the shape and pours it anew.
    Sweep,
    /// Puts a look of that name over the dance on stage, until something else comes there or the stage is left. An
    /// empty name is the show's own look.
    SetLook { look: String },
}

impl Action {
    /// Whether it brings something on stage.
    pub fn opens_stage(&self) -> bool {
        matches!(self, Self::Perform { .. } | Self::PerformFavorites { .. } | Self::Go)
    }
}

/// The longest name of a look, in characters.
const LOOK_NAME: usize = 64;

/// The most voices that can be changed.
const MAX_VOICES: usize = 256;

/// When something was done: in seconds of the show, and in beats.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Moment {
    /// Since the show began, whatever songs played meanwhile.
    pub at_secs: f64,
    /// Beats since then.
    pub at_beat: f64,
}

/// One line of the log.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LoggedAction {
    /// When.
    #[serde(flatten)]
    pub moment: Moment,
    /// What.
    #[serde(flatten)]
    pub action: Action,
}

/// The instrument's whole state: a pure function of shape, seed, size, the initial settings, and the actions
/// so far.
#[derive(Clone, Debug, PartialEq)]
pub struct Instrument {
    shape: GalleryShape,
    seed: u64,
    size: usize,
    gallery: Gallery,
    favorites: Vec<GalleryItem>,
    beginning: Parameters,
    parameters: Parameters,
    /// Voices that were changed; the others do what [`VoiceSettings::initial`] says.
    voices: BTreeMap<usize, VoiceSettings>,
    stage: Stage,
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
            favorites: Vec::new(),
            beginning: parameters.clone(),
            parameters,
            voices: BTreeMap::new(),
            stage: Stage::default(),
            sweeps: 0,
            look: String::new(),
            log: Vec::new(),
        })
    }

    /// The seed it began with.
    pub fn seed(&self) -> u64 {
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

    /// Favorites in the order they were added, as they were then.
    pub fn favorites(&self) -> &[GalleryItem] {
        &self.favorites
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

    /// The next item on stage, and how far the fader has brought it, in [0, 1].
    pub fn next_on_stage(&self) -> Option<(ItemId, f32)> {
        self.stage.next()
    }

    /// Where the fader stands, in [0, 1].
    pub fn fader(&self) -> f32 {
        self.stage.fader()
    }

    /// An item by id, among favorites and all generations.
    pub fn item(&self, id: ItemId) -> Option<&GalleryItem> {
        self.gallery.find(id).or_else(|| self.favorites.iter().find(|item| item.id == id))
    }

    /// Does `action` and logs it. On error nothing changes and nothing is logged.
    ///
    /// # Errors
    /// The action names a missing thing, or a value out of its range; or the gallery refuses, as where
    /// nothing was chosen to breed.
    pub fn apply(&mut self, moment: Moment, action: Action) -> Result<(), MusicError> {
        self.act(moment, &action)?;
        self.log.push(LoggedAction { moment, action });
        Ok(())
    }

    /// All actions replayed, with the beat of each recomputed by `beats` from its time: for a song whose
    /// beats become known while it plays.
    ///
    /// # Errors
    /// Bugs only: all of these actions were done before.
    pub fn with_beats(&self, beats: impl Fn(f64) -> f64) -> Result<Self, MusicError> {
        let mut again =
            Self::beginning_with(self.beginning.clone(), self.seed, self.size, self.shape.clone())?;
        for line in &self.log {
            let moment = Moment { at_beat: beats(line.moment.at_secs), ..line.moment };
            again.apply(moment, line.action.clone())?;
        }
        Ok(again)
    }

    fn act(&mut self, moment: Moment, action: &Action) -> Result<(), MusicError> {
        match *action {
            Action::Choose { item, on } => self.gallery.item_mut(item)?.chosen = on,
            Action::Breed => self.gallery.breed()?,
            Action::BreedFrom { ref candidates } => self.gallery.breed_from(candidates)?,
            Action::ForgetPreference => self.gallery.forget_preference(),
            Action::Mutate { item, amount } => self.gallery.mutate(item, amount)?,
            Action::Lock { item, on } => self.gallery.item_mut(item)?.locked = on,
            Action::Favorite { item, on } => {
                let item = self.gallery.item_mut(item)?.clone();
                self.favorites.retain(|f| f.id != item.id);
                if on {
                    self.favorites.push(item);
                }
            }
            Action::Rename { item, ref name } => {
                let item = self.gallery.item_mut(item)?;
                item.name = name.chars().filter(|c| !c.is_control()).take(200).collect();
                let (id, name) = (item.id, item.name.clone());
                self.favorites.iter_mut().filter(|f| f.id == id).for_each(|f| f.name.clone_from(&name));
            }
            Action::GoTo { generation } => self.gallery.go_to(generation)?,
            Action::NewGallery { seed, size } => {
                self.gallery = self.gallery.restart(seed, size, initial(size, &self.shape))?;
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
                self.gallery.load(item, name, mapping.clone())?;
            }
            Action::Take { item, ref preset } => {
                preset.validate()?;
                let mapping = preset.mapping_on(&self.shape);
                mapping.validate()?;
                self.gallery.load(item, &preset.name, mapping)?;
                self.parameters.apply(&preset.settings)?;
            }
            Action::Set { parameter, value } => self.parameters.set(parameter, value)?,
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
                self.stage.show_item(id, moment.at_beat, &self.favorites, &self.parameters);
            }
            Action::Crossfade { share } => self.stage.fade(share),
            Action::LeaveStage => self.stage.clear(),
            Action::Sweep => self.sweeps = self.sweeps.wrapping_add(1),
            Action::SetLook { ref look } => {
                self.look = look.chars().filter(|c| !c.is_control()).take(LOOK_NAME).collect();
            }
        }
        // Another dance comes in the show's own look; who wants another says so afterwards.
        if action.opens_stage() || *action == Action::LeaveStage {
            self.look.clear();
        }
        Ok(())
    }

    fn edit(&mut self, index: usize, change: impl FnOnce(&mut Mapping)) -> Result<(), MusicError> {
        let item = self.gallery.item_mut(index)?;
        let mut mapping = item.genome.clone();
        change(&mut mapping);
        mapping.validate()?;
        item.genome = mapping;
        item.edited = true;
        Ok(())
    }
}
