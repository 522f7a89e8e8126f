//! Playing: a thread that decodes, a ring without locks, a device, and a position that is
//! that of the sample being heard.

mod clock;
mod engine;
mod handle;
mod output;
mod queue;

pub use engine::PlayerEvent;
pub use handle::{Player, PlayerSettings, PlayerState, PlayerStatus, Repeat};
pub use output::{OutputDevice, output_devices};
