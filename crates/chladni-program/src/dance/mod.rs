//! A dance as window, film and command hear and see it: the one place where a show becomes what is heard at
//! a moment, and where what is heard becomes a picture.

mod clock;
mod files;
mod hearing;
mod staging;

pub use clock::{Playing, ShowClock};
pub use files::{refer, resolve};
pub use hearing::{Heard, Hearing, KnownSong, bands_of, read_beats, spectrum_settings};
pub use staging::{FIRST_VIEW, Look, Staged, Staging, look_named, reaction};

/// K where nobody says otherwise, in the window and on the command line.
pub const HARMONICS: usize = 512;
