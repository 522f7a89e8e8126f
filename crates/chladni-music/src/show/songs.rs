//! The files of a show, and the stretches of its songs that were heard.

use serde::{Deserialize, Serialize};

/// An external file that a show needs.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FileRef {
    /// A path, or `sample:NAME`. A relative one starts from the show's own folder.
    pub path: String,
    /// The file's BLAKE3 hash when the show was saved, in hexadecimal digits; `None` for a sample.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub blake3: Option<String>,
}

/// A song of a show: its file, and how its beats were corrected by hand.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SongRef {
    /// As a [`FileRef`] has it.
    pub path: String,
    /// As a [`FileRef`] has it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub blake3: Option<String>,
    /// How its beats are to be read.
    #[serde(default)]
    pub reading: BeatReading,
}

impl SongRef {
    /// A song in a file, its beats as they are found.
    pub fn of(FileRef { path, blake3 }: FileRef) -> Self {
        Self { path, blake3, reading: BeatReading::default() }
    }

    /// Its file.
    pub fn file(&self) -> FileRef {
        FileRef { path: self.path.clone(), blake3: self.blake3.clone() }
    }
}

/// Corrections of a song's detected beats by the user.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BeatReading {
    /// How often their tempo is doubled; below 0 it is halved.
    #[serde(default)]
    pub octave: i32,
    /// How much later they are.
    #[serde(default)]
    pub shift_secs: f64,
}

impl BeatReading {
    /// The corrected beats (ascending).
    pub fn of(self, beats_secs: &[f64]) -> Vec<f64> {
        let mut read = beats_secs.to_vec();
        for _ in 0..self.octave.clamp(0, MOST_OCTAVES) {
            let between = read.windows(2).map(|pair| 0.5 * (pair[0] + pair[1]));
            let mut both: Vec<f64> = read.iter().copied().chain(between).collect();
            both.sort_by(f64::total_cmp);
            read = both;
        }
        for _ in 0..(-self.octave).clamp(0, MOST_OCTAVES) {
            read = read.into_iter().step_by(2).collect();
        }
        read.iter_mut().for_each(|beat| *beat += self.shift_secs);
        read
    }
}

/// A tempo is doubled or halved at most this often.
pub(super) const MOST_OCTAVES: i32 = 3;

/// From `at_secs` of the show on, a song plays from `song_secs`, or is paused there.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Stretch {
    /// Since the show began.
    pub at_secs: f64,
    /// Which of the show's songs; `None` is live input, which is not recorded.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub song: Option<usize>,
    /// Where in the song.
    #[serde(default)]
    pub song_secs: f64,
    /// False: it is paused.
    pub playing: bool,
    /// How long the stretch before fades into this one, from half of it before `at_secs` to half after it.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub crossfade_secs: f64,
}

#[allow(clippy::trivially_copy_pass_by_ref, reason = "serde asks for it")]
fn is_zero(secs: &f64) -> bool {
    *secs == 0.0
}

impl Stretch {
    /// The song's time at `at_secs` of the show, within this stretch.
    pub fn song_secs_at(&self, at_secs: f64) -> f64 {
        if self.playing { self.song_secs + (at_secs - self.at_secs) } else { self.song_secs }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn beats_are_read_twice_and_half_as_fast_and_later() {
        let read = |octave, shift_secs| BeatReading { octave, shift_secs }.of(&[1.0, 2.0, 3.0]);
        assert_eq!(read(0, 0.0), [1.0, 2.0, 3.0]);
        assert_eq!(read(1, 0.25), [1.25, 1.75, 2.25, 2.75, 3.25]);
        assert_eq!(read(-1, 0.0), [1.0, 3.0]);
        assert_eq!(BeatReading { octave: 3, shift_secs: 0.0 }.of(&[]), [0.0; 0]);
    }
}
