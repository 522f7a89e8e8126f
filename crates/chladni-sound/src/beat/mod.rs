//! Tempo and beats, of a whole song or while listening.

mod follow;
mod meter;
mod score;
mod track;

pub use follow::{BeatFollower, BeatMoment};
pub use score::{BeatScore, beat_score};
pub use track::{Beats, track_beats, track_beats_causally};
