//! Structure of music: the bars and sections that beats form, and the energy.

mod bars;
mod beat_features;
mod energy;
mod follow;
mod frame;
mod sections;

use chladni_task::Task;

use crate::{Onset, Song, SoundError};
use beat_features::BeatFeatures;
use frame::FrameReader;

pub use energy::ENERGY_RATE_HZ;
pub(crate) use follow::BarFollower;
pub use follow::HeardBar;
pub(crate) use sections::section_name;

/// A bar of a song.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Bar {
    /// When its first beat falls, in seconds.
    pub at_secs: f64,
    /// The number of its beats: 3 or 4, or fewer if it is cut short.
    pub beats: u8,
}

/// A part of a song that sounds unlike the one before it.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Section {
    /// When its first bar begins, in seconds.
    pub at_secs: f64,
    /// A letter, the same for sections that sound alike: A to Z, then a to z; a 53rd kind has the first letter again.
    pub name: char,
    /// Its mean energy, in [0, 1].
    pub energy: f32,
}

/// The bars and sections of a song.
pub(crate) struct Structure {
    pub bars: Vec<Bar>,
    pub sections: Vec<Section>,
    pub energy: Vec<f32>,
}

/// The structure of a whole song, given its beats and onsets.
pub(crate) fn structure(
    song: &Song,
    beats_secs: &[f64],
    onsets: &[Onset],
    task: &Task,
) -> Result<Structure, SoundError> {
    let mut reader = FrameReader::new(song.rate_hz)?;
    let mut frames = Vec::new();
    song.in_blocks(1 << 16, "hearing bars and sections", task, |left, right| {
        reader.push(left, right, &mut frames);
    })?;
    let silence = song.silence_after(reader.latency_secs());
    reader.push(&silence, &silence, &mut frames);
    let energy = energy::energy(&frames, onsets);
    // The last beat is assumed to last as long as the one before it.
    let last =
        beats_secs.last().zip(beats_secs.iter().rev().nth(1)).map(|(last, before)| 2.0 * last - before);
    let ends = beats_secs.iter().skip(1).copied().chain(last);
    let heard: Vec<BeatFeatures> =
        beats_secs.iter().zip(ends).map(|(&a, b)| BeatFeatures::between(a, b, &frames, onsets)).collect();
    let bars = bars::bars(beats_secs, &heard);
    let first_beats: Vec<usize> =
        bars.iter().map(|bar| beats_secs.partition_point(|&beat| beat < bar.at_secs)).collect();
    let energy_between = |from, to| energy::between(&energy, from, to);
    let sections = sections::sections(&first_beats, beats_secs, &heard, energy_between);
    Ok(Structure { bars, sections, energy })
}
