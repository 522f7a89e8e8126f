//! Playback: a decoding thread, a lock-free ring buffer, a device, and the position that is being heard.

mod clock;
mod decoding;
mod engine;
mod hand_out;
mod handle;
mod output;
mod queue;
mod tail;

pub use engine::PlayerEvent;
pub use handle::{Player, PlayerSettings, PlayerState, PlayerStatus, Repeat};
pub use output::{OutputDevice, output_devices};
