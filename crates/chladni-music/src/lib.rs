//! A shape that dances: from the spectrum of a song to the coefficients of harmonics.
//!
//! ```
//! use chladni_music::{Action, GalleryShape, Instrument, Moment, Preset};
//!
//! // The initial gallery of twelve mappings, for a body of 64 harmonics and 32 sound bands.
//! let shape = GalleryShape { eigenvalues: (0..64).map(f64::from).collect(), bands: 32 };
//! let mut instrument = Instrument::new(2012, 12, shape)?;
//!
//! // Choose two, breed, keep the first child.
//! let now = Moment { at_secs: 3.5, at_beat: 7.0 };
//! for item in [1, 4] {
//!     instrument.apply(now, Action::Choose { item, on: true })?;
//! }
//! instrument.apply(now, Action::Breed)?;
//! let child = instrument.gallery().items()[0].clone();
//! let text = instrument.preset(&child, vec!["calm".into()]).to_text()?;
//! assert_eq!(Preset::from_text(&text)?.mapping, child.genome);
//! # Ok::<(), chladni_music::MusicError>(())
//! ```
//!
//! The window reads an [`Instrument`] and emits [`Action`]s; each frame a [`Player`] turns the
//! bands of sound into an [`Item`](chladni_synth::Item) for the synthesizer. Nothing here
//! reads a clock, draws or makes a sound.
//!
//! Not guaranteed: that the soft limit of displacement and steepness holds at every vertex (it is measured at
//! a few probes); that symmetry classes are right on a shape without a mirror plane; bit-identical
//! coefficients between machines of different floating-point behavior.

#![warn(clippy::missing_errors_doc)]

mod action;
mod autopilot;
mod bands;
mod breeding;
mod calibration;
mod clock;
mod clock_track;
mod control;
mod cue;
mod dancer;
mod descriptor;
mod director;
mod ensemble;
mod error;
mod flash;
mod flash_area;
mod flash_field;
mod flash_guard;
mod gallery;
mod harmony;
mod histogram;
mod instrument;
mod mapping;
mod osc;
mod paper_mode;
mod parameter;
mod parameters;
mod player;
mod playing;
mod preset;
mod probes;
mod pulses;
mod repertoire;
mod resonance;
mod ringing;
mod sand;
mod sand_mode;
mod settings;
mod show;
mod sides;
mod stage;
mod steepness;
mod stereo;
mod stripes;
mod swelling;
mod swing;
mod symmetry;
mod taps;
mod target;
mod tempo;
mod text_file;
mod timbre;
mod touch;
mod unison;
mod veil;
mod voice;

pub use action::{Action, LoggedAction, Moment};
pub use autopilot::{Autopilot, Candidate, REPEAT_SECS, Turn};
pub use bands::Bands;
pub use breeding::{breed, mutate};
pub use calibration::{
    CALIBRATION_PERIOD_SECS, CALIBRATION_TAPS, Calibration, Latency, Signal, calibration_flash,
};
pub use chladni_breeding::{
    BreedingError, CANDIDATES, ChaCha8Rng, Describe, Descriptor, GALLERY_SIZES, Generation, Genome, ItemId,
    Origin, SeedableRng, suggest,
};
pub use chladni_mesh::MirrorPlane;
pub use clock::{ClockMessage, ClockOut, TICKS_PER_QUARTER};
pub use clock_track::{ClockBar, ClockMark, ClockTrack};
pub use control::{Binding, Bindings, Standing};
pub use cue::{Cue, Which, osc_cue, preceding, setting};
pub use dancer::Dancer;
pub use descriptor::{Describer, Moments};
pub use director::{BarLine, Director, Framing, SHOTS};
pub use ensemble::Ensemble;
pub use error::MusicError;
pub use flash::{FLASH_DARK, FLASH_STEP, FlashLimiter, MAX_FLASHES, most_flashes_per_second};
pub use flash_field::FlashArea;
pub use flash_guard::{FlashCount, FlashGuard};
pub use gallery::{Gallery, GalleryItem, GalleryShape};
pub use harmony::Harmony;
pub use histogram::Histogram;
pub use instrument::Instrument;
pub use mapping::{MAX_GENES, Mapping, direct_transfer};
pub use osc::{LONGEST_OSC_PACKET, OscMessage};
pub use paper_mode::PAPER_MODE;
pub use parameter::{Parameter, Switch};
pub use parameters::Parameters;
pub use player::{Player, blend};
pub use playing::{Choir, Control as FormControl, Form, Playing};
pub use preset::{Ancestor, Preset};
pub use repertoire::repertoire;
pub use resonance::Resonators;
pub use ringing::Ringing;
pub use sand::{Grain, SAND_STEP_SECS, Sand, Tray};
pub use sand_mode::{SAND_MODE, experiment, without_sand};
pub use settings::Settings;
pub use show::{BeatReading, FileRef, Looks, Recording, Show, SongRef, Stretch, Viewpoint, heard_again};
pub use sides::{SideSource, Sides};
pub use stage::{Beat, Reaction, Scene, Stage, react, smooth};
pub use symmetry::{Class, Rotation, Symmetry, SymmetryMethod, SymmetrySettings};
pub use taps::{TappedBeats, Taps};
pub use target::{CHOIRS, FORMS, Kind, REPEATS, Target, controls_page};
pub use tempo::Tempo;
pub use text_file::FORMAT_VERSION;
pub use timbre::{TONES, Timbre};
pub use touch::{Control, Touch};
pub use veil::Veil;
pub use voice::{Driver, Voice, VoiceSettings, Voices};

/// The examples of README.md, compiled.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
pub struct Readme;
