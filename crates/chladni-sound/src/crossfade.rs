//! From one song to the next.

use std::f32::consts::FRAC_PI_2;

/// The longest crossfade between songs.
pub const LONGEST_CROSSFADE_SECS: f64 = 12.0;

/// How loud the song that begins is at this share of a crossfade, in [0, 1]; the one that ends is as loud
/// as this at the rest of it. The powers of both add up to one.
pub fn crossfade_gain(share: f64) -> f32 {
    (FRAC_PI_2 * share.clamp(0.0, 1.0) as f32).sin()
}
