//! How long the title of a song is shown on stage after it has begun.

use chladni_music::smooth;

/// The size of its letters, and how far it is from the left and from the bottom, where 720 is the shorter side
/// of the picture.
pub const TITLE: [f32; 3] = [26.0, 32.0, 48.0];

/// The longer side of the cover before it, in sizes of its letters.
pub const COVER: f32 = 2.5;
/// The gap between the two, in sizes of its letters.
pub const GAP: f32 = 0.6;

/// How far the dark halo of letters reaches on all sides, in sizes of the letters.
const HALO: f32 = 0.05;

/// Where letters of this size are laid in black, beside the place where they are then laid in white: on light grounds, white
/// alone cannot be read.
pub fn halo_offsets(size: f32) -> [[f32; 2]; 8] {
    let far = (HALO * size).max(1.0);
    let sides: [[i8; 2]; 8] = [[-1, -1], [0, -1], [1, -1], [-1, 0], [1, 0], [-1, 1], [0, 1], [1, 1]];
    sides.map(|at| at.map(|side| f32::from(side) * far))
}

/// How opaque each of these is, for letters as opaque as this. They overlap, and would be seen before the letters were.
pub fn halo_opacity(opacity: f32) -> f32 {
    0.7 * opacity * opacity
}

/// How opaque it is: in within a second, there for four, out within two.
pub fn title_opacity(age_secs: f64) -> f32 {
    smooth(age_secs.min(0.5 * (7.0 - age_secs)).clamp(0.0, 1.0) as f32)
}

#[cfg(test)]
mod tests {
    use super::title_opacity;

    #[test]
    fn a_title_fades_in_and_out() {
        assert_eq!([0.0, 1.0, 3.0, 5.0, 7.0, 60.0].map(title_opacity), [0.0, 1.0, 1.0, 1.0, 0.0, 0.0]);
        let steps = (0..700)
            .map(|i| (title_opacity(f64::from(i + 1) * 0.01) - title_opacity(f64::from(i) * 0.01)).abs());
        assert!(steps.fold(0.0, f32::max) < 0.02);
    }
}
