//! What can be done to the instrument, and when it was done.

use serde::{Deserialize, Serialize};

use crate::{Choir, Form, Mapping, Parameter, Preset, Switch, Timbre, VoiceSettings};

/// Everything a user can do to the instrument. The window emits these; only
/// [`Instrument::apply`](crate::Instrument::apply) changes state. Items are named by their place in the gallery shown.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "do", rename_all = "kebab-case", deny_unknown_fields)]
#[allow(missing_docs, reason = "the fields say what the variants do")]
pub enum Action {
    /// Chooses a parent, or unchooses it.
    Choose { item: usize, on: bool },
    /// Replaces all items that are not locked by children of the chosen ones.
    Breed,
    /// Replaces all items that are not locked by the candidates of these numbers, one for each place
    /// ([`Gallery::candidates`](crate::Gallery::candidates), [`suggest`](crate::suggest)).
    BreedFrom { candidates: Vec<u16> },
    /// The same, as shows before version 4 did it: see [`MutatePlainly`](Self::MutatePlainly).
    BreedFromPlainly { candidates: Vec<u16> },
    /// Choices made so far no longer count when children are suggested.
    ForgetPreference,
    /// Changes one item a little at random; amount in [0, 1].
    Mutate { item: usize, amount: f32 },
    /// The same, as shows before version 4 did it: bands may end on the constant harmonic, and the gain does not follow.
    MutatePlainly { item: usize, amount: f32 },
    /// Locks an item in its place, or unlocks it.
    Lock { item: usize, on: bool },
    /// Adds an item to the favorites, or removes it.
    #[serde(alias = "favourite")]
    Favorite { item: usize, on: bool },
    /// Names an item.
    Rename { item: usize, name: String },
    /// Shows a generation, counted from 0.
    GoTo { generation: usize },
    /// Starts over with another seed and size. What else is random follows the seed from then on.
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
    /// Puts an item of the gallery on stage, alone.
    Perform { item: usize },
    /// Puts an item of the gallery on stage; where the beat steps, the others follow it in their order.
    PerformGallery { first: usize },
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
        matches!(
            self,
            Self::Perform { .. } | Self::PerformGallery { .. } | Self::PerformFavorites { .. } | Self::Go
        )
    }

    /// Whether it makes dances of others by chance.
    pub fn is_bred(&self) -> bool {
        matches!(
            self,
            Self::Breed
                | Self::BreedFrom { .. }
                | Self::BreedFromPlainly { .. }
                | Self::Mutate { .. }
                | Self::MutatePlainly { .. }
        )
    }

    /// The action that did the same in shows before version 4.
    pub(crate) fn of_version_3(self) -> Self {
        match self {
            Self::BreedFrom { candidates } => Self::BreedFromPlainly { candidates },
            Self::Mutate { item, amount } => Self::MutatePlainly { item, amount },
            other => other,
        }
    }

    /// The actions that set the knobs to a timbre.
    pub fn for_timbre(timbre: &Timbre) -> [Self; 6] {
        let set = |parameter, value| Self::Set { parameter, value };
        [
            Self::Switch { switch: Switch::Resonate, on: true },
            set(Parameter::Damping, timbre.damping),
            set(Parameter::TuningHz, timbre.tuning_hz),
            set(Parameter::Stretch, timbre.stretch),
            set(Parameter::Strike, timbre.strike),
            set(Parameter::Hold, timbre.hold),
        ]
    }
}

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
