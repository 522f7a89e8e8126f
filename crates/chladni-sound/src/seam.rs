//! Sounds that do not follow from each other, joined without a click.

/// Sounds that do not follow from each other, at a jump, a pause or a change of volume, are joined within this time:
/// without, they would click.
pub const SEAM_SECS: f32 = 0.008;

/// Joins two sounds that do not follow from each other, at a jump in a song or an edge of silence: the last frame of the
/// first fades into the second, so that the seam is never louder than the louder one.
///
/// ```
/// use chladni_sound::Seam;
///
/// let mut seam = Seam::new(48_000);
/// seam.begin();
/// let heard: Vec<[f32; 2]> = (0..1000).map(|_| seam.over([0.5; 2])).collect();
/// assert!(heard.windows(2).all(|pair| pair[1][0] - pair[0][0] < 0.01));
/// assert_eq!((heard[0], heard[999]), ([0.0; 2], [0.5; 2]));
/// ```
pub struct Seam {
    last: [f32; 2],
    /// The frame that fades.
    held: [f32; 2],
    /// Remaining frames of the fade, and the frames of a whole fade.
    left: u32,
    length: u32,
}

impl Seam {
    /// For sound at `rate_hz`, with silence before it.
    pub fn new(rate_hz: u32) -> Self {
        let length = ((SEAM_SECS * rate_hz as f32) as u32).max(1);
        Self { last: [0.0; 2], held: [0.0; 2], left: 0, length }
    }

    /// How many frames a fade takes.
    pub fn frames(&self) -> u32 {
        self.length
    }

    /// The next frame does not follow from the last.
    pub fn begin(&mut self) {
        (self.held, self.left) = (self.last, self.length);
    }

    /// Whether nothing fades any more.
    pub fn is_over(&self) -> bool {
        self.left == 0
    }

    /// The next frame, as it is heard.
    pub fn over(&mut self, frame: [f32; 2]) -> [f32; 2] {
        let share = self.left as f32 / self.length as f32;
        self.left = self.left.saturating_sub(1);
        let blend = |frame: f32, held: f32| (1.0 - share) * frame + share * held;
        self.last = [blend(frame[0], self.held[0]), blend(frame[1], self.held[1])];
        self.last
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_seam_is_no_louder_than_what_it_joins_and_steps_no_farther_than_a_fade() {
        // Eleven periods are 1200 frames.
        let tone = |n: u32| 0.5 * (std::f32::consts::TAU * 440.0 * (n % 1_200) as f32 / 48_000.0).sin();
        let mut seam = Seam::new(48_000);
        // From the tone to another place in it, again and again, in the midst of a fade, too.
        let (mut at, mut before) = (0, 0.0_f32);
        for n in 0..20_000_u32 {
            if n.is_multiple_of(1_031) || n.is_multiple_of(1_709) {
                seam.begin();
                at += 12_345;
            }
            let [left, right] = seam.over([tone(at + n), -0.25]);
            assert!(left.abs() <= 0.5 + 1e-6 && right.abs() <= 0.25 + 1e-6, "{n}: {left} {right}");
            // The slope of the tone, and a fade over twice its amplitude.
            assert!((left - before).abs() < 0.029 + 1.0 / 384.0, "{n}: {before} {left}");
            before = left;
        }
    }
}
