//! The songs of a film: read, tracked, and laid one after the other as they were heard.

use std::sync::Arc;

use chladni_music::{BeatReading, Stretch};
use chladni_sound::{Beats, Song, StereoResampler, track_beats};

use crate::work::{Error, Hearing, KnownSong, Watcher, read_beats, source};

/// Sampling rate of a film's sound without any song.
const SILENT_RATE_HZ: u32 = 44_100;

/// All songs of a show that its film needs.
pub struct Songs {
    /// By their numbers; none of those that are not heard.
    songs: Vec<Option<KnownSong>>,
    readings: Vec<BeatReading>,
    heard: Vec<Stretch>,
    start_secs: f64,
    film_secs: f64,
}

impl Songs {
    /// Reads those that are heard in `range`: where the film begins, and how much of the show is filmed.
    pub fn open(
        names: &[(String, BeatReading)],
        mut heard: Vec<Stretch>,
        show_secs: Option<f64>,
        range: (f64, Option<f64>),
        watcher: &impl Watcher,
    ) -> Result<Self, Error> {
        if heard.is_empty() {
            heard.push(Stretch { at_secs: 0.0, song: Some(0), song_secs: 0.0, playing: true });
        }
        let (start_secs, wanted_secs) = range;
        let end_secs = wanted_secs.map_or(f64::INFINITY, |secs| start_secs + secs);
        let ends = heard.iter().skip(1).map(|next| next.at_secs).chain([f64::INFINITY]);
        // A jump fades from what was heard before it.
        let reached = heard
            .iter()
            .zip(ends)
            .filter(|(stretch, end)| stretch.at_secs < end_secs && *end + 1.0 > start_secs);
        let numbers: Vec<usize> = reached.filter_map(|(stretch, _)| stretch.song).collect();
        let mut songs = Vec::new();
        for (number, (name, _)) in names.iter().enumerate() {
            let song = if numbers.contains(&number) {
                let song = Arc::new(source::song(name, 0.0, None, watcher)?);
                Some(KnownSong::new(song)?)
            } else {
                None
            };
            songs.push(song);
        }
        let last = heard.last().copied();
        let length = |song: usize| songs.get(song)?.as_ref().map(|known| known.song.duration_secs());
        let last_song_secs = last.and_then(|last| Some(last.at_secs + length(last.song?)? - last.song_secs));
        let show_secs = show_secs.or(last_song_secs).unwrap_or(0.0);
        let film_secs = end_secs.min(show_secs) - start_secs;
        if film_secs <= 0.0 {
            return Err(Error::Input(format!("what is heard ends after {show_secs:.1} s")));
        }
        let readings = names.iter().map(|(_, reading)| *reading).collect();
        Ok(Self { songs, readings, heard, start_secs, film_secs })
    }

    /// How long the film is.
    pub fn film_secs(&self) -> f64 {
        self.film_secs
    }

    /// Which song is heard when.
    pub fn stretches(&self) -> &[Stretch] {
        &self.heard
    }

    /// Finds the beats of each.
    pub fn track_beats(&mut self, watcher: &impl Watcher) -> Result<(), Error> {
        for (known, reading) in self.songs.iter_mut().zip(&self.readings) {
            let Some(known) = known else { continue };
            let beats = watcher.watch("tracking the beat", |task| track_beats(&known.song, task));
            known.beats = Some(read_beats(&beats?, *reading));
        }
        Ok(())
    }

    /// Tempo and confidence of the song that the film begins with.
    pub fn tempo(&self) -> (f64, f64) {
        let begun = self.heard.partition_point(|stretch| stretch.at_secs <= self.start_secs);
        let song = self.heard.get(begun.saturating_sub(1)).and_then(|stretch| stretch.song);
        let beats: Option<&Beats> = song.and_then(|song| self.songs.get(song)?.as_ref()?.beats.as_ref());
        beats.map_or((0.0, 0.0), |beats| (beats.tempo_bpm, beats.confidence))
    }

    /// Hands them over.
    pub fn tell(&self, hearing: &mut Hearing) {
        for (number, known) in self.songs.iter().enumerate() {
            if let Some(known) = known {
                hearing.know(number, known.clone());
            }
        }
    }

    /// The sound of the film: pauses are silent, and so is live input.
    pub fn sound(&self) -> Result<Song, Error> {
        let rate_hz = self.songs.iter().flatten().map(|known| known.song.rate_hz).next();
        let rate_hz = rate_hz.unwrap_or(SILENT_RATE_HZ);
        let frames = |secs: f64| (secs * f64::from(rate_hz)).round() as usize;
        let silence = vec![0.0; frames(self.film_secs)];
        let mut sound = Song { rate_hz, left: silence.clone(), right: silence };
        let mut resampled: Vec<Option<Arc<Song>>> = Vec::new();
        for known in &self.songs {
            resampled.push(known.as_ref().map(|known| at_rate(&known.song, rate_hz)).transpose()?);
        }
        let ends = self.heard.iter().skip(1).map(|next| next.at_secs).chain([f64::INFINITY]);
        for (stretch, end_secs) in self.heard.iter().zip(ends) {
            let song = stretch.song.and_then(|song| resampled.get(song)?.as_ref());
            let Some(song) = song.filter(|_| stretch.playing) else { continue };
            let from_secs = stretch.at_secs.max(self.start_secs);
            let to_secs = end_secs.min(self.start_secs + self.film_secs);
            if to_secs <= from_secs {
                continue;
            }
            let from = frames(from_secs - self.start_secs).min(sound.left.len());
            let to = frames(to_secs - self.start_secs).min(sound.left.len());
            let end = frames(stretch.song_secs_at(from_secs)) as i64 + (to - from) as i64;
            let Song { left, right, .. } = &mut sound;
            song.window_ending_at(end, &mut left[from..to], &mut right[from..to]);
        }
        Ok(sound)
    }
}

fn at_rate(song: &Arc<Song>, rate_hz: u32) -> Result<Arc<Song>, Error> {
    if song.rate_hz == rate_hz {
        return Ok(Arc::clone(song));
    }
    let mut resampler = StereoResampler::new(song.rate_hz, rate_hz)?;
    let mut stereo = Vec::new();
    let interleaved: Vec<f32> = song.left.iter().zip(&song.right).flat_map(|(l, r)| [*l, *r]).collect();
    resampler.process(&interleaved, &mut stereo)?;
    resampler.finish(&mut stereo)?;
    let (left, right) = stereo.as_chunks().0.iter().map(|[l, r]: &[f32; 2]| (*l, *r)).unzip();
    Ok(Arc::new(Song { rate_hz, left, right }))
}
