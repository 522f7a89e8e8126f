//! Wishes of the bars and drawers of the room.

use std::path::PathBuf;

use chladni_mesh::Orientation;
use chladni_music::{Action, ItemId, Preset, Target};

use super::view::View;

/// How much a dance changes that is changed a little.
pub const A_LITTLE: f32 = 0.2;

/// One wish; the room fulfills it after the frame's panels are drawn.
#[derive(Clone, Debug)]
pub enum Wish {
    /// An action of the instrument.
    Do(Action),
    /// What a control does to a dance of the gallery.
    Dance(Target, usize),
    /// Set all up for sand on the shape, as in Chladni's experiment.
    Experiment,
    /// Open this file, or a sample.
    Open(PathBuf),
    /// Choose files.
    Choose(Then),
    /// Ask where to record the set as it is played; or end that.
    Record,
    /// The same, without a question.
    RecordAtOnce,
    /// Let a person tap, to find how much later the picture is seen than the sound is heard; or no longer.
    Calibrate,
    /// Ask for a film of the dance.
    Film,
    /// Show the gallery, one item or the harmonics.
    Show(View),
    /// Let the shape stand so, or as it does by itself.
    Stand(Option<Orientation>),
    /// Plays this preset in the gallery's place for one frame, to try it out.
    TryOut(Box<Preset>),
    /// Ask for name and tags, to keep an item on the shelf.
    Keep(ItemId),
    /// Take a preset of the shelf into the gallery.
    Take(Box<Preset>),
    /// Delete a preset of the shelf.
    Discard(PathBuf),
    /// Mark the item a number of columns to the right and rows below.
    #[allow(missing_docs, reason = "the words above say it")]
    Mark { right: isize, down: isize },
    /// The stage goes black, or comes back.
    Black,
    /// The picture of the stage stands still, or goes on.
    Freeze,
    /// Lean back, or no longer.
    Autopilot,
    /// The autopilot keeps the current dance and look, or goes on.
    Hold,
    /// Press a button of a controller.
    Press(Target),
    /// On stage: the favorite after (true) or before the one that plays.
    StepFavorite(bool),
    /// The same, or the dance of the gallery where the beat steps through one.
    StepInTurn(bool),
}

/// The use of the file that a person is asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Then {
    /// All that dances or sounds is opened.
    Open,
    /// Songs are added to the list.
    AddSongs,
    /// The film of the form is made.
    Film,
    /// The same, as pictures in a folder and their sound.
    Frames,
    /// The set is recorded from now on.
    Record,
    /// A dance is saved as a preset.
    SavePreset(ItemId),
    /// The show is saved.
    SaveShow,
    /// The show is saved, and makes room for the one, or the gallery, that waits.
    SaveShowFirst,
    /// The background is this picture or film.
    Picture,
    /// The light is that of this panorama.
    Panorama,
    /// All bindings of controllers are written there.
    ExportBindings,
    /// The bindings of a file are added.
    ImportBindings,
}
