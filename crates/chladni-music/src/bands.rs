//! The sound at one moment, as bands of its spectrum.

use crate::Ringing;

/// f at one moment: amplitudes of the sound bands, four slices of length #ω, about [0, 1], which belong to
/// one pair of channels: |S|² + |U|² = ½ (|L|² + |R|²).
#[derive(Clone, Copy, Debug)]
pub struct Bands<'a> {
    /// |L(ω)|.
    pub left: &'a [f32],
    /// |R(ω)|.
    pub right: &'a [f32],
    /// f_s = |L + R| / 2.
    pub mid: &'a [f32],
    /// f_u = |L − R| / 2, already amplified by the side gain.
    pub side: &'a [f32],
    /// g, the side gain.
    pub side_gain: f32,
    /// The state of these bands' resonators. Where this or the timbre of the dance is `None`, harmonics
    /// follow the level.
    pub ringing: Option<&'a Ringing>,
}
