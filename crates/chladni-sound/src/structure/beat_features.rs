//! The sound of one beat, and the signs that a bar begins with it.

use super::frame::{CLASSES, FRAME_RATE_HZ, Frame, OCTAVES, WINDOW_SECS};
use crate::{ONSET_RATE_HZ, Onset};

/// The number of parts into which a beat is divided for its rhythm.
const PARTS: usize = 4;

/// Features of the sound from one beat to the next.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct BeatFeatures {
    /// Pitch classes above the bass, as a unit vector, or 0 if there are none.
    pub chroma: [f32; CLASSES],
    /// Pitch classes of the bass, likewise.
    pub bass: [f32; CLASSES],
    /// Logarithms of the power of each octave.
    pub octaves: [f32; OCTAVES],
    /// Onsets in all bands and in the bass, for each quarter of the beat.
    pub rhythm: [[f32; PARTS]; 2],
    /// Mean square of the samples, the stroke on the beat included.
    pub power: f32,
}

impl BeatFeatures {
    /// Features from `begin_secs` to `end_secs`. Frames and onsets begin at time 0.
    pub fn between(begin_secs: f64, end_secs: f64, frames: &[Frame], onsets: &[Onset]) -> Self {
        let span = (end_secs - begin_secs).max(1e-3);
        let within = |from_secs: f64, to_secs: f64| {
            let at = |secs: f64| (secs * FRAME_RATE_HZ).round().max(0.0) as usize;
            let (from, to) = (at(from_secs), at(to_secs).max(at(from_secs) + 1));
            frames.get(from.min(frames.len())..to.min(frames.len())).unwrap_or_default()
        };
        // Skips the start of the beat, where the windows still overlap the sound before it.
        let heard = within(begin_secs + 0.2 * span, end_secs);
        // For power the stroke on the beat counts: all windows that reach it, but none that reaches the next one.
        let reach_secs = 0.5 * WINDOW_SECS;
        let struck = within(begin_secs - reach_secs, end_secs - reach_secs);
        let power = struck.iter().map(|frame| frame.power).sum::<f32>() / struck.len().max(1) as f32;
        let mut beat = Self { power, ..Self::default() };
        for frame in heard {
            let share = 1.0 / heard.len() as f32;
            beat.chroma.iter_mut().zip(frame.chroma).for_each(|(sum, note)| *sum += share * note);
            beat.bass.iter_mut().zip(frame.bass).for_each(|(sum, note)| *sum += share * note);
            beat.octaves.iter_mut().zip(frame.octaves).for_each(|(sum, power)| *sum += share * power);
        }
        beat.octaves.iter_mut().for_each(|power| *power = (1e-8 + *power).ln());
        (beat.chroma, beat.bass) = (unit(beat.chroma), unit(beat.bass));
        for part in 0..PARTS {
            let at = |share: f64| ((begin_secs + share * span) * ONSET_RATE_HZ).round().max(0.0) as usize;
            let (a, b) = (at((part as f64 - 0.4) / PARTS as f64), at((part as f64 + 0.6) / PARTS as f64));
            for onset in onsets.get(a.min(onsets.len())..b.min(onsets.len())).unwrap_or_default() {
                beat.rhythm[0][part] = beat.rhythm[0][part].max(onset.all);
                beat.rhythm[1][part] = beat.rhythm[1][part].max(onset.bass);
            }
        }
        beat
    }

    /// Similarity of the notes and rhythm of two beats, in [-1, 1].
    pub fn likeness(&self, other: &Self) -> f32 {
        let rhythm = cosine(self.rhythm.as_flattened(), other.rhythm.as_flattened());
        let notes = 0.5 * (cosine(&self.chroma, &other.chroma) + cosine(&self.bass, &other.bass));
        0.5 * (rhythm + notes)
    }
}

/// The number of beats on either side that are searched for a change of harmony: the longest bar.
pub(super) const CONTEXT: usize = 4;

/// Signs that a bar begins between `before` and `after`, the beats around it, nearest first: a change of
/// harmony, a change of bass, an onset in the bass, any onset.
pub(super) fn signs(before: &[&BeatFeatures], after: &[&BeatFeatures]) -> [f32; 4] {
    let sum = |beats: &[&BeatFeatures], of: fn(&BeatFeatures) -> &[f32; CLASSES]| {
        let mut sum = [0.0; CLASSES];
        beats.iter().for_each(|beat| sum.iter_mut().zip(of(beat)).for_each(|(s, note)| *s += note));
        sum
    };
    let change = |of: fn(&BeatFeatures) -> &[f32; CLASSES]| {
        let between = |beats: usize| {
            let near = |side: &[&BeatFeatures]| sum(&side[..beats.min(side.len())], of);
            1.0 - cosine(&near(before), &near(after))
        };
        between(2) + 0.5 * (3..=CONTEXT).map(between).sum::<f32>()
    };
    let struck = |row: usize| after.first().map_or(0.0, |beat| beat.rhythm[row][0]);
    [change(|beat| &beat.chroma), change(|beat| &beat.bass), struck(1), struck(0)]
}

fn unit(mut notes: [f32; CLASSES]) -> [f32; CLASSES] {
    let length = notes.iter().map(|note| note * note).sum::<f32>().sqrt();
    if length > 1e-6 {
        notes.iter_mut().for_each(|note| *note /= length);
    }
    notes
}

/// Cosine of the angle between two vectors; 1 if either is zero.
pub(super) fn cosine(a: &[f32], b: &[f32]) -> f32 {
    let dot = |a: &[f32], b: &[f32]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f32>();
    let lengths = (dot(a, a) * dot(b, b)).sqrt();
    if lengths > 1e-12 { dot(a, b) / lengths } else { 1.0 }
}
