//! Playback: a decoding thread, a lock-free ring buffer, a device, and the position that is being heard.

mod clock;
mod decoding;
mod engine;
mod hand_out;
mod handle;
mod output;
mod queue;
mod settings;
mod shared;
mod tail;

pub use engine::PlayerEvent;
pub use handle::{HeardTo, MOST_AHEAD_SECS, Player, PlayerState, PlayerStatus};
pub use output::{OutputDevice, output_devices};
pub use queue::Repeat;
pub use settings::PlayerSettings;
