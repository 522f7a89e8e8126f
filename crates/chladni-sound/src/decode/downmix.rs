//! Mixes any number of channels down to two.
//!
//! Gains follow ITU-R BS.775-3, annex 4 (center and surrounds at −3 dB, low-frequency effects
//! left out), then the larger of the two sums is scaled to 1 so that the mix cannot clip
//! where its source did not.

use symphonia::core::audio::{ChannelLabel, Channels, Position, layouts};

use crate::windowed::sounding;

/// −3 dB as an amplitude.
const MINUS_3_DB: f32 = std::f32::consts::FRAC_1_SQRT_2;

/// One pair of gains (to left, to right) for each channel.
pub(crate) struct Downmix {
    gains: Vec<[f32; 2]>,
}

impl Downmix {
    /// The mix for `channels`; `None` if there are none.
    pub fn new(channels: &Channels) -> Option<Self> {
        let count = channels.count();
        let mut gains: Vec<[f32; 2]> = match (count, channels) {
            (0, _) => return None,
            (1, _) => vec![[1.0, 1.0]],
            (2, _) => vec![[1.0, 0.0], [0.0, 1.0]],
            (_, Channels::Positioned(positions)) => meant(*positions).iter().map(gains_at).collect(),
            (_, Channels::Custom(labels)) => labels
                .iter()
                .enumerate()
                .map(|(i, label)| match label {
                    ChannelLabel::Positioned(position) => gains_at(*position),
                    _ => alternate(i),
                })
                .collect(),
            // The first Ambisonic component is the sound without direction, the second is
            // (left − right): a pair of virtual microphones facing to the sides.
            (_, Channels::Ambisonic(_)) => (0..count)
                .map(|i| match i {
                    0 => [0.5, 0.5],
                    1 => [0.5, -0.5],
                    _ => [0.0, 0.0],
                })
                .collect(),
            _ => (0..count).map(alternate).collect(),
        };
        let sum = |side: usize| gains.iter().map(|g| g[side].abs()).sum::<f32>();
        let largest = sum(0).max(sum(1));
        if largest > 1.0 {
            for gain in &mut gains {
                gain[0] /= largest;
                gain[1] /= largest;
            }
        }
        Some(Self { gains })
    }

    /// Appends frames `range` of `interleaved` (as many channels as the mix has) to `stereo`.
    /// Samples that are no sound ([`sounding`]) become 0.
    pub fn append(&self, interleaved: &[f32], range: std::ops::Range<usize>, stereo: &mut Vec<f32>) {
        let channels = self.gains.len();
        let frames = interleaved.chunks_exact(channels).take(range.end).skip(range.start);
        stereo.reserve(2 * range.len());
        for frame in frames {
            let mut mixed = [0.0f32; 2];
            for (&sample, gain) in frame.iter().zip(&self.gains) {
                let sample = sounding(sample);
                mixed[0] += gain[0] * sample;
                mixed[1] += gain[1] * sample;
            }
            stereo.extend_from_slice(&mixed);
        }
    }
}

/// The usual speakers of this number of channels, in WAVE order; those of eight for more. Opus has them, too (mapping
/// family 1).
pub(super) fn usual(channels: usize) -> Channels {
    match channels {
        1 => layouts::CHANNEL_LAYOUT_MONO,
        2 => layouts::CHANNEL_LAYOUT_STEREO,
        3 => layouts::CHANNEL_LAYOUT_3P0,
        4 => layouts::CHANNEL_LAYOUT_4P0_QUAD,
        5 => layouts::CHANNEL_LAYOUT_5P0,
        6 => layouts::CHANNEL_LAYOUT_5P1,
        7 => layouts::CHANNEL_LAYOUT_6P1,
        _ => layouts::CHANNEL_LAYOUT_7P1,
    }
}

/// A WAV file that names no speakers is read with the first ones of the mask. No layout of five or seven channels has
/// those; the usual one is meant.
fn meant(positions: Position) -> Position {
    let is_unnamed = |count| Position::from_count(count) == Some(positions);
    let count = [5_u16, 7].into_iter().find(|count| is_unnamed(u32::from(*count)));
    match count.map(|count| usual(count.into())) {
        Some(Channels::Positioned(usual)) => usual,
        _ => positions,
    }
}

/// Channels without a known position: even ones go left, odd ones right.
fn alternate(index: usize) -> [f32; 2] {
    if index.is_multiple_of(2) { [1.0, 0.0] } else { [0.0, 1.0] }
}

fn gains_at(position: Position) -> [f32; 2] {
    let left_at_full = Position::FRONT_LEFT | Position::FRONT_LEFT_WIDE | Position::FRONT_LEFT_CENTER;
    let right_at_full = Position::FRONT_RIGHT | Position::FRONT_RIGHT_WIDE | Position::FRONT_RIGHT_CENTER;
    let left = Position::REAR_LEFT
        | Position::SIDE_LEFT
        | Position::TOP_FRONT_LEFT
        | Position::TOP_REAR_LEFT
        | Position::TOP_SIDE_LEFT
        | Position::BOTTOM_FRONT_LEFT;
    let right = Position::REAR_RIGHT
        | Position::SIDE_RIGHT
        | Position::TOP_FRONT_RIGHT
        | Position::TOP_REAR_RIGHT
        | Position::TOP_SIDE_RIGHT
        | Position::BOTTOM_FRONT_RIGHT;
    if position.intersects(Position::LFE1 | Position::LFE2) {
        [0.0, 0.0]
    } else if position.intersects(left_at_full) {
        [1.0, 0.0]
    } else if position.intersects(right_at_full) {
        [0.0, 1.0]
    } else if position.intersects(left) {
        [MINUS_3_DB, 0.0]
    } else if position.intersects(right) {
        [0.0, MINUS_3_DB]
    } else if position.intersects(Position::FRONT_CENTER | Position::BOTTOM_FRONT_CENTER) {
        [MINUS_3_DB, MINUS_3_DB]
    } else {
        // Center channels behind or above: half the power of a surround to each side.
        [0.5, 0.5]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mix(channels: Channels, frame: &[f32]) -> Vec<f32> {
        let mut out = Vec::new();
        Downmix::new(&channels).unwrap().append(frame, 0..1, &mut out);
        out
    }

    #[test]
    fn mono_is_heard_on_both_sides_and_stereo_is_left_alone() {
        assert_eq!(mix(Channels::Discrete(1), &[0.5]), [0.5, 0.5]);
        assert_eq!(mix(Channels::Discrete(2), &[0.25, -0.75]), [0.25, -0.75]);
    }

    #[test]
    fn five_one_follows_bs_775() {
        let five_one = Position::FRONT_LEFT
            | Position::FRONT_RIGHT
            | Position::FRONT_CENTER
            | Position::LFE1
            | Position::REAR_LEFT
            | Position::REAR_RIGHT;
        let scale = 1.0 / (1.0 + 2.0 * MINUS_3_DB);
        let close = |a: Vec<f32>, b: [f32; 2]| {
            assert!((a[0] - b[0]).abs() < 1e-6 && (a[1] - b[1]).abs() < 1e-6, "{a:?} {b:?}")
        };
        let at = |i: usize| {
            let mut frame = [0.0; 6];
            frame[i] = 1.0;
            mix(Channels::Positioned(five_one), &frame)
        };
        close(at(0), [scale, 0.0]);
        close(at(1), [0.0, scale]);
        close(at(2), [scale * MINUS_3_DB, scale * MINUS_3_DB]);
        close(at(3), [0.0, 0.0]);
        close(at(4), [scale * MINUS_3_DB, 0.0]);
        close(at(5), [0.0, scale * MINUS_3_DB]);
    }

    #[test]
    fn five_and_seven_channels_without_names_lose_none() {
        let heard = |count: u32, at: usize| {
            let mut frame = vec![0.0; count as usize];
            frame[at] = 1.0;
            let mixed = mix(Channels::Positioned(Position::from_count(count).unwrap()), &frame);
            [mixed[0] > 0.1, mixed[1] > 0.1]
        };
        let (left, right, both, neither) = ([true, false], [false, true], [true, true], [false, false]);
        assert_eq!([0, 1, 2, 3, 4].map(|at| heard(5, at)), [left, right, both, left, right]);
        let seven = [0, 1, 2, 3, 4, 5, 6].map(|at| heard(7, at));
        assert_eq!(seven, [left, right, both, neither, both, left, right]);
    }

    #[test]
    fn what_is_not_a_number_becomes_silence() {
        assert_eq!(mix(Channels::Discrete(2), &[f32::NAN, f32::INFINITY]), [0.0, 0.0]);
        assert_eq!(mix(Channels::Discrete(2), &[3e30, -0.5]), [0.0, -0.5], "no sound is so loud");
    }
}
