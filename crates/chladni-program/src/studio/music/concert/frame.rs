//! A frame of the music room before it is danced.

use std::time::Instant;

use chladni_music::{Beat, Framing, Instrument, Mapping, Reaction, Settings};
use chladni_view::Look;

use super::super::listening::Listening;
use crate::work::chooses_shots;

/// The sound of a frame, and how it is to look.
pub(super) struct Frame {
    pub began: Instant,
    pub at_secs: f64,
    pub is_known: bool,
    pub beat: Beat,
    pub reaction: Reaction,
    pub look: Look,
    /// Something is on stage.
    pub staged: bool,
    /// The stage has a window of its own.
    pub is_apart: bool,
    /// Played in the gallery's place: a preset that is tried out, or the item of the close-up.
    pub solo: Option<(Mapping, Settings)>,
}

impl Frame {
    /// The window itself shows the stage. Where that has a window of its own, the gallery goes on.
    pub fn shows_stage(&self) -> bool {
        self.staged && !self.is_apart
    }

    /// The shot that the camera chooses now, where it does.
    pub fn framing(&self, instrument: &Instrument, listening: &mut Listening) -> Option<Framing> {
        let seed_at = |at_secs| instrument.seed_at(at_secs);
        chooses_shots(instrument, self.beat).then(|| listening.framing(seed_at))
    }
}
