//! Beats, bars and framing of a show by its songs.

use chladni_music::{BarLine, Beat, Director, Framing, Stretch};
use chladni_sound::Beats;

use super::{Hearing, SongDirector};
use crate::work::bars::{bar_lines, bar_lines_among};

/// Music whose beat lags behind the count by up to this much is waited for: otherwise the count would leap by almost a beat.
/// No loop is cut to its beats exactly.
const STILL_BEATS: f64 = 0.25;

/// How the count of beats goes on where other music begins.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Seam {
    /// The beats gone by before it, below which the count does not fall.
    pub gone: f64,
    /// The whole beats to add to those of the music.
    pub added: f64,
}

impl Seam {
    /// After `gone` beats, with music whose own count begins at `count`.
    pub fn after(gone: f64, count: f64) -> Self {
        Self { gone, added: (gone - count - STILL_BEATS).ceil() }
    }

    /// The beats gone by where those of the music are `count`.
    pub fn count(self, count: f64) -> f64 {
        (count + self.added).max(self.gone)
    }
}

impl Hearing {
    /// The stretch that is heard at `at_secs`, and how the count goes on with it; before the first one, that.
    pub(super) fn stretch_at(&self, at_secs: f64) -> Option<(Stretch, Seam)> {
        let begun = self.stretches.partition_point(|(stretch, _)| stretch.at_secs <= at_secs);
        self.stretches.get(begun.saturating_sub(1)).copied()
    }

    /// Beats of the songs gone by at any time of the show so far.
    pub(super) fn beat_by_songs(&self, at_secs: f64) -> Beat {
        let Some((stretch, seam)) = self.stretch_at(at_secs) else { return Beat::default() };
        let beat = self.beat_of_song(stretch, stretch.song_secs_at(at_secs));
        Beat { count: seam.count(beat.count), ..beat }
    }

    /// How the camera frames the shape then: by the bars of the song that is heard, and the seeds of their times.
    pub(super) fn framing_by_songs(&mut self, at_secs: f64, seed_at: impl Fn(f64) -> u64) -> Framing {
        let Some((stretch, _)) = self.stretch_at(at_secs) else { return Framing::default() };
        let song_secs = stretch.song_secs_at(at_secs);
        let Some(number) = stretch.song else { return Framing::default() };
        let (since_secs, seed) = (stretch.at_secs, seed_at(f64::INFINITY));
        let known = self.directors.get(&number);
        if known.is_none_or(|known| known.since_secs != since_secs || known.seed != seed) {
            let mut director = Director::of_song(seed, 0.0);
            let beats = self.songs.get(&number).and_then(|song| song.beats.as_ref());
            for bar in beats.into_iter().flat_map(bar_lines) {
                let seed = seed_at(since_secs + (bar.at_secs - stretch.song_secs).max(0.0));
                // Another song is filmed in another way.
                director.set_seed(seed.wrapping_add(number as u64));
                director.hear(bar);
            }
            self.directors.insert(number, SongDirector { since_secs, seed, director });
        }
        self.directors.get(&number).map_or_else(Framing::default, |known| known.director.at(song_secs))
    }

    /// The stretch that plays at `at_secs`, and its song's beats; `None` in a pause, and where these are not known.
    fn playing_at(&self, at_secs: f64) -> Option<(Stretch, &Beats)> {
        let (stretch, _) = self.stretch_at(at_secs).filter(|(stretch, _)| stretch.playing)?;
        Some((stretch, self.songs.get(&stretch.song?)?.beats.as_ref()?))
    }

    /// The bars of the songs that have begun after `from_secs` of the show, up to `to_secs`, in the stretch that is
    /// heard then.
    pub(super) fn bars_of_songs(&self, from_secs: f64, to_secs: f64) -> Vec<BarLine> {
        let Some((stretch, beats)) = self.playing_at(to_secs) else { return Vec::new() };
        // A bar with which the stretch begins has begun with it.
        let from_secs = from_secs.max(stretch.at_secs - 1e-9);
        let later_secs = stretch.at_secs - stretch.song_secs;
        let begun = |by_secs: f64| beats.bars.partition_point(|bar| bar.at_secs + later_secs <= by_secs);
        let bars = bar_lines_among(beats, begun(from_secs)..begun(to_secs));
        bars.map(|bar| BarLine { at_secs: bar.at_secs + later_secs, ..bar }).collect()
    }

    /// The energy of the bar of the song that is heard then; 0 in a pause, and where no bars are known.
    pub(super) fn energy_by_songs(&self, at_secs: f64) -> f32 {
        let Some((stretch, beats)) = self.playing_at(at_secs) else { return 0.0 };
        let song_secs = stretch.song_secs_at(at_secs);
        let begun = beats.bars.partition_point(|bar| bar.at_secs <= song_secs);
        bar_lines_among(beats, begun.saturating_sub(1)..begun).last().map_or(0.0, |bar| bar.energy)
    }

    fn beat_of_song(&self, stretch: Stretch, song_secs: f64) -> Beat {
        let beats = stretch.song.and_then(|song| self.songs.get(&song)?.beats.as_ref());
        beats.map_or_else(Beat::default, |beats| {
            Beat::among(&beats.beats_secs, beats.confidence as f32, song_secs)
        })
    }

    /// How the count goes on in `stretch`, so that no beat gone by before comes back.
    pub(super) fn seam(&self, before: &[(Stretch, Seam)], stretch: Stretch) -> Seam {
        let Some((last, seam)) = before.last() else { return Seam::default() };
        let gone = seam.count(self.beat_of_song(*last, last.song_secs_at(stretch.at_secs)).count);
        Seam::after(gone, self.beat_of_song(stretch, stretch.song_secs).count)
    }

    pub(super) fn count_again(&mut self) {
        for i in 0..self.stretches.len() {
            let (before, stretch) = (&self.stretches[..i], self.stretches[i].0);
            self.stretches[i].1 = self.seam(before, stretch);
        }
    }
}
