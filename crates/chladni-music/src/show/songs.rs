//! The files of a show, and the stretches of its songs that were heard.

use serde::{Deserialize, Serialize};

use crate::{TappedBeats, Taps};

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
    /// How much later they are, within a minute.
    #[serde(default)]
    pub shift_secs: f64,
    /// Beats that take the place of those that were found.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tapped: Option<TappedBeats>,
}

impl BeatReading {
    /// Takes taps to a song whose beats were found at `found_secs` (ascending). Four or more even ones that these do not
    /// explain take their place; taps at their tempo, or at an octave of it, bring them back. True where the beats are
    /// those of the taps.
    pub fn hear(&mut self, taps: &Taps, found_secs: &[f64]) -> bool {
        let Some((beats, is_found)) = taps.over(found_secs) else { return false };
        if !is_found {
            *self = Self { tapped: Some(beats), ..Self::default() };
        } else if self.tapped.is_some() {
            *self = Self::default();
        }
        !is_found
    }

    /// Lets the beats come later by this much; all in all a minute at most.
    pub fn shift(&mut self, by_secs: f64) {
        if by_secs.is_finite() {
            self.shift_secs = (self.shift_secs + by_secs).clamp(-MOST_SHIFT_SECS, MOST_SHIFT_SECS);
        }
    }

    /// Doubles their tempo this often, or halves it where `by` is below 0; three times at most, all in all.
    pub fn change_octave(&mut self, by: i32) {
        self.octave = self.octave.saturating_add(by).clamp(-MOST_OCTAVES, MOST_OCTAVES);
    }

    /// The corrected beats (ascending), where bars were found to begin at `bars_secs` (ascending): those stay on which
    /// most bars begin where the tempo is halved. Beats that were tapped have bars of their own, and reach from the first
    /// to the last one that was found.
    pub fn of(self, beats_secs: &[f64], bars_secs: &[f64]) -> Vec<f64> {
        let begins_bar = |secs: f64| bars_secs.binary_search_by(|bar| bar.total_cmp(&secs)).is_ok();
        let beats: Vec<(f64, bool)> = match self.tapped {
            Some(tapped) => {
                tapped.among(beats_secs).into_iter().map(|(place, secs)| (secs, place == 0)).collect()
            }
            None => beats_secs.iter().map(|&secs| (secs, begins_bar(secs))).collect(),
        };
        let step = 1usize << self.octave.saturating_neg().clamp(0, MOST_OCTAVES);
        let each = |first: usize| beats.iter().skip(first).step_by(step);
        let bars = |first: &usize| each(*first).filter(|(_, begins)| *begins).count();
        // The earliest of equals.
        let first = (0..step).rev().max_by_key(bars).unwrap_or(0);
        let mut read: Vec<f64> = each(first).map(|(secs, _)| *secs).collect();
        for _ in 0..self.octave.clamp(0, MOST_OCTAVES) {
            let between = read.windows(2).map(|pair| 0.5 * (pair[0] + pair[1]));
            let mut both: Vec<f64> = read.iter().copied().chain(between).collect();
            both.sort_by(f64::total_cmp);
            read = both;
        }
        read.iter_mut().for_each(|beat| *beat += self.shift_secs);
        read
    }
}

/// A tempo is doubled or halved at most this often.
pub(super) const MOST_OCTAVES: i32 = 3;
/// Beats are shifted by at most this much.
pub(super) const MOST_SHIFT_SECS: f64 = 60.0;

/// From `at_secs` of the show on, a song plays from `song_secs`, or is paused there.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Stretch {
    /// Since the show began.
    pub at_secs: f64,
    /// Which of the show's songs; `None` is live input, which no recording has.
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

/// A recording of a set, as one of the show's songs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Recording<'a> {
    /// Its number among the songs.
    pub song: usize,
    /// Its beginning in seconds since the show began, each from a time of the show on (ascending): a show stands at pauses
    /// and jumps while a recording goes on.
    pub begins: &'a [(f64, f64)],
    /// Its length.
    pub duration_secs: f64,
}

impl Recording<'_> {
    /// Its beginning, by what is heard at `at_secs`.
    fn begins_secs(&self, at_secs: f64) -> Option<f64> {
        let known = self.begins.partition_point(|(from_secs, _)| *from_secs <= at_secs);
        self.begins.get(known.saturating_sub(1)).map(|(_, begins_secs)| *begins_secs)
    }
}

/// The same stretches (ascending), with live input heard from `recording` as far as that has it.
pub fn heard_again(stretches: &[Stretch], recording: Recording<'_>) -> Vec<Stretch> {
    let ends = stretches.iter().skip(1).map(|next| next.at_secs).chain([f64::INFINITY]);
    let mut again = Vec::with_capacity(stretches.len() + 2);
    for (stretch, end_secs) in stretches.iter().zip(ends) {
        let begins_secs = recording.begins_secs(stretch.at_secs).unwrap_or(f64::INFINITY);
        let from_secs = begins_secs.max(stretch.at_secs);
        let to_secs = (begins_secs + recording.duration_secs).min(end_secs);
        if stretch.song.is_some() || from_secs >= to_secs {
            again.push(*stretch);
            continue;
        }
        // Only its beginning is faded into.
        let plain = Stretch { crossfade_secs: 0.0, ..*stretch };
        let begins_with_it = from_secs == stretch.at_secs;
        again.extend((!begins_with_it).then_some(*stretch));
        let (song, song_secs) = (Some(recording.song), from_secs - begins_secs);
        let heard = if begins_with_it { *stretch } else { plain };
        again.push(Stretch { at_secs: from_secs, song, song_secs, playing: true, ..heard });
        again.extend((to_secs < end_secs).then_some(Stretch { at_secs: to_secs, ..plain }));
    }
    again
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn live_input_is_heard_from_what_was_recorded_of_it() {
        let stretch = |at_secs, song, song_secs| Stretch {
            at_secs,
            song,
            song_secs,
            playing: true,
            crossfade_secs: 0.0,
        };
        let heard = [stretch(0.0, Some(0), 7.0), stretch(10.0, None, 0.0), stretch(30.0, Some(1), 0.0)];
        let again = |heard: &[Stretch], song, at_secs, duration_secs| {
            heard_again(heard, Recording { song, begins: &[(at_secs, at_secs)], duration_secs })
        };
        assert_eq!(again(&heard, 2, 90.0, 0.0), heard);
        // Within the live input, over its beginning, over its end, and over all of it.
        let of = |at_secs, duration_secs| again(&heard, 2, at_secs, duration_secs);
        let [first, live, last] = heard;
        assert_eq!(of(12.0, 5.0), [first, live, stretch(12.0, Some(2), 0.0), stretch(17.0, None, 0.0), last]);
        assert_eq!(of(4.0, 10.0), [first, stretch(10.0, Some(2), 6.0), stretch(14.0, None, 0.0), last]);
        assert_eq!(of(25.0, 50.0), [first, live, stretch(25.0, Some(2), 0.0), last]);
        assert_eq!(of(2.0, 90.0), [first, stretch(10.0, Some(2), 8.0), last]);
        // Two recordings of an input that still goes on.
        let both = again(&again(&[live], 2, 11.0, 2.0), 3, 15.0, 1.0);
        let times: Vec<(f64, Option<usize>)> = both.iter().map(|s| (s.at_secs, s.song)).collect();
        let expected = [(10.0, None), (11.0, Some(2)), (13.0, None), (15.0, Some(3)), (16.0, None)];
        assert_eq!(times, expected);
        // The show stood for half a second of the recording before live input was heard for the second time.
        let heard = [stretch(10.0, None, 0.0), stretch(20.0, Some(0), 0.0), stretch(30.0, None, 0.0)];
        let begins = &[(12.0, 8.0), (20.0, 8.0), (30.0, 7.5)];
        let again = heard_again(&heard, Recording { song: 2, begins, duration_secs: 90.0 });
        let second = stretch(30.0, Some(2), 22.5);
        assert_eq!(again[..3], [stretch(10.0, Some(2), 2.0), heard[1], second]);
        assert_eq!(again[3], stretch(97.5, None, 0.0));
    }

    #[test]
    fn beats_are_read_twice_and_half_as_fast_and_later() {
        let read =
            |octave, shift_secs| BeatReading { octave, shift_secs, tapped: None }.of(&[1.0, 2.0, 3.0], &[]);
        assert_eq!(read(0, 0.0), [1.0, 2.0, 3.0]);
        assert_eq!(read(1, 0.25), [1.25, 1.75, 2.25, 2.75, 3.25]);
        assert_eq!(read(-1, 0.0), [1.0, 3.0]);
        assert_eq!((read(i32::MIN, 0.0), read(i32::MAX, 0.0)), (read(-3, 0.0), read(3, 0.0)));
        assert_eq!(BeatReading { octave: 3, ..BeatReading::default() }.of(&[], &[]), [0.0; 0]);
    }

    #[test]
    fn beats_read_half_as_fast_keep_those_that_begin_bars() {
        let beats_secs: Vec<f64> = (0..21).map(f64::from).collect();
        let read = |octave, tapped, first_bar: usize| {
            let bars_secs: Vec<f64> = beats_secs.iter().skip(first_bar).step_by(4).copied().collect();
            BeatReading { octave, shift_secs: 0.0, tapped }.of(&beats_secs, &bars_secs)
        };
        for first_bar in 0..4 {
            for (octave, step) in [(-1, 2), (-2, 4), (-3, 8)] {
                let read = read(octave, None, first_bar);
                let first = first_bar % step;
                assert_eq!(read, beats_secs.iter().skip(first).step_by(step).copied().collect::<Vec<f64>>());
            }
        }
        // Bars that were tapped begin elsewhere than those that were found.
        let tapped = Some(TappedBeats { per_found: 1.0, at_secs: 7.0 });
        assert_eq!(read(-2, tapped, 0), [3.0, 7.0, 11.0, 15.0, 19.0]);
    }

    /// The reading after taps at `bpm` from 20 s on, each 10 ms early or late, to a song that was found to have 93.
    fn after_taps(mut reading: BeatReading, bpm: f64, count: u32) -> BeatReading {
        let found_secs = found_secs();
        let mut taps = Taps::default();
        for n in 0..count {
            let off_secs = if n % 2 == 0 { 0.01 } else { -0.01 };
            taps.add(20.0 + f64::from(n) * 60.0 / bpm + off_secs);
            reading.hear(&taps, &found_secs);
        }
        reading
    }

    fn found_secs() -> Vec<f64> {
        (0..200).map(|n| 1.0 + f64::from(n) * 60.0 / 93.0).collect()
    }

    #[test]
    fn even_taps_at_another_tempo_give_a_song_that_tempo() {
        let found = BeatReading::default();
        assert_eq!(after_taps(found, 140.0, 3), found);
        for count in [4, 8, 30] {
            let reading = after_taps(BeatReading { octave: 1, shift_secs: 0.2, tapped: None }, 140.0, count);
            let tapped = reading.tapped.unwrap();
            assert_eq!(reading, BeatReading { tapped: Some(tapped), ..found });
            assert!(tapped.per_found == 1.5 && tapped.at_secs > 19.0, "{count}: {tapped:?}");
        }
        let tapped = after_taps(found, 140.0, 8);
        let read = tapped.of(&found_secs(), &[]);
        let gap_secs = 60.0 / (1.5 * 93.0);
        assert!(read.windows(2).all(|pair| (pair[1] - pair[0] - gap_secs).abs() < 1e-9));
        assert!(read.iter().any(|beat| (beat - 20.0).abs() < 0.02), "the first tap is a beat");
        assert!(read[0] - 1.0 < gap_secs && read.len() > 280);
        let twice = BeatReading { octave: 1, ..tapped }.of(&found_secs(), &[]);
        assert_eq!(twice.len(), 2 * read.len() - 1);
        // No simple ratio.
        let tapped = after_taps(found, 115.0, 16).tapped.unwrap();
        assert!((93.0 * tapped.per_found - 115.0).abs() < 0.5, "{tapped:?}");
        // Nothing was found: there is nothing that can be read otherwise.
        assert!(after_taps(found, 140.0, 8).of(&[3.0], &[]).is_empty());
    }

    #[test]
    fn taps_that_the_beats_explain_keep_them_and_bring_them_back() {
        let found = BeatReading::default();
        let other = after_taps(found, 140.0, 8);
        for bpm in [93.0, 46.5, 186.0, 94.5] {
            assert_eq!(after_taps(found, bpm, 8), found, "{bpm}");
            assert_eq!(after_taps(other, bpm, 8), found, "{bpm}");
        }
        // Neither even nor apart.
        let mut taps = Taps::default();
        for secs in [20.0, 20.3, 21.0, 21.4, 22.3, 22.6, f64::NAN, 22.65, 22.7] {
            taps.add(secs);
            assert_eq!(taps.over(&found_secs()), None, "{secs}");
        }
    }
}
