//! The playlist, and a record of which song each part of the ring holds, and which parts were dropped.

use std::collections::{HashMap, VecDeque};
use std::ops::Range;
use std::path::PathBuf;

/// What happens after the last sample of a song.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Repeat {
    /// The next song plays, and nothing after the last one.
    #[default]
    Off,
    /// The same song plays again.
    Song,
    /// The next song plays, and the first one after the last.
    List,
}

/// The songs in order, and the index of the one that is being decoded.
#[derive(Default)]
pub(super) struct Playlist {
    /// How many lists there were before.
    pub number: u64,
    pub songs: Vec<PathBuf>,
    pub current: usize,
    pub repeat: Repeat,
}

impl Playlist {
    /// The song after the current one; `None` at the end of the list.
    pub fn after(&self, by_hand: bool) -> Option<usize> {
        let last = self.songs.len().checked_sub(1)?;
        match self.repeat {
            Repeat::Song if !by_hand => Some(self.current.min(last)),
            _ if self.current < last => Some(self.current + 1),
            Repeat::Off => None,
            _ => Some(0),
        }
    }

    /// For each song, its index in another list. Of a song that is in a list more than once, the first place is still the
    /// first, and so on; where the other list has fewer, the rest are the last there.
    pub fn places_in(&self, songs: &[PathBuf]) -> Vec<Option<usize>> {
        // A hash map, because the list may be long and playback waits for the result.
        let mut places: HashMap<&PathBuf, VecDeque<usize>> = HashMap::new();
        for (place, song) in songs.iter().enumerate() {
            places.entry(song).or_default().push_back(place);
        }
        let place = |song: &PathBuf| {
            let left = places.get_mut(song)?;
            if left.len() > 1 { left.pop_front() } else { left.front().copied() }
        };
        self.songs.iter().map(place).collect()
    }

    /// The song before the current one.
    pub fn before(&self) -> Option<usize> {
        let last = self.songs.len().checked_sub(1)?;
        match self.repeat {
            Repeat::List if self.current == 0 => Some(last),
            _ => Some(self.current.saturating_sub(1)),
        }
    }
}

/// From ring frame `ring_frame` on, the ring holds song `song` from the time `song_secs` on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Stretch {
    pub ring_frame: u64,
    /// Which list `song` counts in: how many there were before it.
    pub list: u64,
    pub song: usize,
    pub song_secs: f64,
    pub duration_secs: Option<f64>,
    /// How long the song before it fades into this one; from half of it before `ring_frame` to half after it.
    pub crossfade_secs: f64,
}

impl Stretch {
    /// The time in the song at a ring frame.
    pub fn secs_at(&self, ring_frame: f64, rate_hz: u32) -> f64 {
        self.song_secs + (ring_frame - self.ring_frame as f64).max(0.0) / f64::from(rate_hz)
    }
}

/// Stretches are kept for this long after they were heard: what is shown may lie behind what is heard.
const KEPT_SECS: f64 = 1.0;

/// The stretches that are heard now or later, or were a moment ago, in order.
#[derive(Default)]
pub(super) struct Stretches {
    list: VecDeque<Stretch>,
}

impl Stretches {
    pub fn clear(&mut self) {
        self.list.clear();
    }

    /// Renumbers songs that are in the next list, too. A song that was removed keeps its number in its own until it ends.
    pub fn renumber(&mut self, places: &[Option<usize>], from: u64) {
        for stretch in self.list.iter_mut().filter(|stretch| stretch.list == from) {
            if let Some(place) = places.get(stretch.song).copied().flatten() {
                (stretch.list, stretch.song) = (from + 1, place);
            }
        }
    }

    pub fn begin(&mut self, stretch: Stretch) {
        // A stretch that begins at the same frame replaces one that was never heard.
        while self.list.back().is_some_and(|last| last.ring_frame >= stretch.ring_frame) {
            self.list.pop_back();
        }
        self.list.push_back(stretch);
    }

    /// The stretch that contains a ring frame, and the time within its song. Frames a second before the latest one that
    /// was asked for are forgotten.
    pub fn at(&mut self, ring_frame: f64, rate_hz: u32) -> Option<(Stretch, f64)> {
        let kept = KEPT_SECS * f64::from(rate_hz);
        while self.list.get(1).is_some_and(|next| next.ring_frame as f64 + kept <= ring_frame) {
            self.list.pop_front();
        }
        let begun = self.list.iter().rev().find(|stretch| stretch.ring_frame as f64 <= ring_frame);
        let stretch = *begun.or_else(|| self.list.front())?;
        Some((stretch, stretch.secs_at(ring_frame, rate_hz)))
    }
}

/// Jumps that are remembered, each with sound that was heard before it: recordings fetch what was heard more often.
const MOST_JUMPS: usize = 64;

/// The parts of the ring that jumps dropped, in order: they were decoded, and never heard.
#[derive(Default)]
pub(super) struct Dropped {
    list: VecDeque<Range<u64>>,
}

impl Dropped {
    pub fn clear(&mut self) {
        self.list.clear();
    }

    pub fn add(&mut self, part: Range<u64>) {
        if part.is_empty() {
            return;
        }
        match self.list.back_mut() {
            // Nothing was heard between two jumps.
            Some(last) if last.end >= part.start => last.end = last.end.max(part.end),
            _ => self.list.push_back(part),
        }
        if self.list.len() > MOST_JUMPS {
            self.list.pop_front();
        }
    }

    /// The parts of `frames` that were heard, in order.
    pub fn heard_of(&self, frames: Range<u64>) -> impl Iterator<Item = Range<u64>> + Clone {
        let Range { start: mut from, end } = frames;
        let dropped = self.list.iter().filter(move |part| part.end > frames.start && part.start < end);
        // What was heard lies before each part that was dropped, and before the end.
        let before = dropped.cloned().chain(std::iter::once(end..end)).map(move |part| {
            let heard = from..part.start;
            from = part.end;
            heard
        });
        before.filter(|part| !part.is_empty())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn repeating_and_ending() {
        let songs = vec!["a".into(), "b".into()];
        let mut list = Playlist { songs, current: 1, ..Playlist::default() };
        assert_eq!(list.after(false), None);
        list.repeat = Repeat::List;
        assert_eq!(list.after(false), Some(0));
        list.repeat = Repeat::Song;
        assert_eq!((list.after(false), list.after(true)), (Some(1), Some(0)));
        assert_eq!(Playlist::default().after(true), None);
    }

    #[test]
    fn songs_keep_their_place_or_are_found_again() {
        let list = Playlist { songs: ["a", "b", "a", "c"].map(PathBuf::from).into(), ..Playlist::default() };
        let places = list.places_in(&["a", "c", "a"].map(PathBuf::from));
        assert_eq!(places, [Some(0), None, Some(2), Some(1)]);
        let mut stretches = Stretches::default();
        stretches.begin(Stretch {
            ring_frame: 0,
            list: 4,
            song: 3,
            song_secs: 0.0,
            duration_secs: None,
            crossfade_secs: 0.0,
        });
        let heard = |stretches: &mut Stretches| stretches.at(0.0, 48_000).map(|(s, _)| (s.list, s.song));
        stretches.renumber(&places, 4);
        assert_eq!(heard(&mut stretches), Some((5, 1)));
        stretches.renumber(&[Some(0), None], 5);
        stretches.renumber(&[Some(0), Some(0)], 6);
        assert_eq!(heard(&mut stretches), Some((5, 1)), "what was removed");
    }

    #[test]
    fn of_a_song_that_is_in_the_list_twice_each_place_is_found_again() {
        let places = |before: &[&str], after: &[&str]| {
            let songs = |names: &[&str]| names.iter().map(PathBuf::from).collect::<Vec<_>>();
            Playlist { songs: songs(before), ..Playlist::default() }.places_in(&songs(after))
        };
        assert_eq!(places(&["a", "b", "a"], &["a", "a"]), [Some(0), None, Some(1)]);
        assert_eq!(places(&["c", "a", "b", "a"], &["a", "b", "a"]), [None, Some(0), Some(1), Some(2)]);
        assert_eq!(places(&["a", "b", "a"], &["b", "a"]), [Some(1), Some(0), Some(1)], "one is left");
    }

    #[test]
    fn what_jumps_dropped_was_not_heard() {
        let mut dropped = Dropped::default();
        for part in [100..200, 200..250, 300..300, 400..500] {
            dropped.add(part);
        }
        let heard = |frames: Range<u64>| dropped.heard_of(frames).collect::<Vec<_>>();
        assert_eq!(heard(0..600), [0..100, 250..400, 500..600]);
        assert_eq!(heard(150..450), vec![Range { start: 250, end: 400 }]);
        assert_eq!(heard(250..400), vec![Range { start: 250, end: 400 }]);
        assert_eq!(heard(120..130), []);
        assert_eq!(heard(600..600), []);
    }

    #[test]
    fn positions_follow_seeks_and_songs() {
        let mut stretches = Stretches::default();
        let at = |ring_frame, song, song_secs| Stretch {
            ring_frame,
            list: 0,
            song,
            song_secs,
            duration_secs: None,
            crossfade_secs: 0.0,
        };
        stretches.begin(at(0, 0, 0.0));
        stretches.begin(at(48_000, 0, 30.0));
        stretches.begin(at(96_000, 1, 0.0));
        assert_eq!(stretches.at(24_000.0, 48_000).map(|(s, t)| (s.song, t)), Some((0, 0.5)));
        assert_eq!(stretches.at(72_000.0, 48_000).map(|(s, t)| (s.song, t)), Some((0, 30.5)));
        assert_eq!(stretches.at(100_800.0, 48_000).map(|(s, t)| (s.song, t)), Some((1, 0.1)));
        let before = stretches.at(93_600.0, 48_000).map(|(s, t)| (s.song, t));
        assert_eq!(before, Some((0, 30.95)), "a moment ago is still known");
        assert_eq!(stretches.at(192_000.0, 48_000).map(|(s, t)| (s.song, t)), Some((1, 2.0)));
        assert_eq!(stretches.at(93_600.0, 48_000).map(|(s, t)| (s.song, t)), Some((1, 0.0)));
    }
}
