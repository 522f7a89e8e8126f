//! The songs, one after the other, how loud and where.

use std::path::PathBuf;

use chladni_sound::{PlayerState, Repeat};
use egui::TextureHandle;

use super::Listening;

impl Listening {
    /// The playlist.
    pub fn songs(&self) -> &[PathBuf] {
        &self.songs
    }

    /// Adds songs at the end of the list and plays the first of them; the sample tune goes.
    pub fn add(&mut self, songs: Vec<PathBuf>) {
        if songs.is_empty() {
            return;
        }
        self.songs.retain(|song| *song != self.tune);
        let first = self.songs.len();
        self.songs.extend(songs);
        self.player.set_songs(self.songs.clone());
        self.select(first);
    }

    /// Puts the songs in an order by chance; the one that is heard comes first, and goes on.
    pub fn shuffle(&mut self, seed: u64) {
        let heard = self.player.status().song.min(self.songs.len().saturating_sub(1));
        self.songs.swap(0, heard);
        let mut state = seed;
        for last in (2..self.songs.len()).rev() {
            // Knuth's linear congruential generator: good enough to shuffle songs.
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            self.songs.swap(last, 1 + (state >> 33) as usize % last);
        }
        self.player.set_songs(self.songs.clone());
    }

    /// Takes a song out of the list; the last one makes room for the sample tune.
    pub fn remove(&mut self, song: usize) {
        if song >= self.songs.len() {
            return;
        }
        self.songs.remove(song);
        if self.songs.is_empty() {
            self.songs.push(self.tune.clone());
        }
        self.player.set_songs(self.songs.clone());
    }

    /// Plays a song of the list.
    pub fn select(&mut self, song: usize) {
        self.live = None;
        self.player.select(song);
    }

    /// The choice at the end of a song.
    pub fn repeat(&self) -> Repeat {
        self.repeat
    }

    /// Changes the choice at the end of a song.
    pub fn set_repeat(&mut self, repeat: Repeat) {
        self.repeat = repeat;
        self.player.repeat(repeat);
    }

    /// The title of a song of the list, once it has been heard and if it has one, or else its file's name.
    pub fn name_of(&self, song: usize) -> String {
        let path = self.songs.get(song);
        let title =
            path.and_then(|path| self.repertoire.iter().find(|known| known.path == *path)?.title.clone());
        if let Some(title) = title {
            return title;
        }
        let stem = path.and_then(|path| path.file_stem());
        stem.map_or_else(String::new, |stem| stem.to_string_lossy().into_owned())
    }

    /// The cover of a song of the list, once it has been heard and if it has one.
    pub fn cover_of(&self, song: usize) -> Option<&TextureHandle> {
        let path = self.songs.get(song)?;
        self.repertoire.iter().find(|known| known.path == *path)?.cover.as_ref()
    }

    /// The cover of the song that is heard.
    pub fn source_cover(&self) -> Option<&TextureHandle> {
        if self.live.is_some() { None } else { self.cover_of(self.player.status().song) }
    }

    /// Loudness in [0, 1].
    pub fn volume(&self) -> f32 {
        self.volume
    }

    /// Makes it louder or softer; the shapes dance the same.
    pub fn set_volume(&mut self, volume: f32) {
        self.volume = volume;
        self.player.set_volume(volume);
    }

    /// How long one song fades into the next.
    pub fn song_fade_secs(&self) -> f64 {
        self.song_fade_secs
    }

    /// Changes that.
    pub fn set_song_fade_secs(&mut self, secs: f64) {
        self.song_fade_secs = secs;
        self.player.set_crossfade_secs(secs);
    }

    /// The device that was chosen; `None` is the system's own.
    pub fn device(&self) -> Option<&str> {
        self.device.as_deref()
    }

    /// Chooses another one; the song goes on.
    pub fn set_device(&mut self, device: Option<String>) {
        self.device.clone_from(&device);
        self.player.set_device(device);
    }

    /// Plays or pauses; leaves live input.
    pub fn toggle(&mut self) {
        if self.live.take().is_some() {
            return self.player.play();
        }
        if self.player.status().state == PlayerState::Playing {
            self.player.pause();
        } else {
            self.player.play();
        }
    }
}
