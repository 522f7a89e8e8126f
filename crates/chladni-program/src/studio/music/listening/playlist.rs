//! The songs, one after the other, how loud and where.

use std::path::{Path, PathBuf};

use chladni_sound::Repeat;

use super::study::SongCover;
use super::{Listening, ShowSong};

impl Listening {
    /// The playlist.
    pub fn songs(&self) -> &[PathBuf] {
        &self.songs
    }

    /// Adds songs at the end of the list and plays the first of them; the sample tune goes where it is all that there was.
    pub fn add(&mut self, songs: Vec<PathBuf>) {
        if songs.is_empty() {
            return;
        }
        if self.has_only_the_tune() {
            self.songs.clear();
        }
        let first = self.append(songs);
        // A window that is opened with songs and a live input goes on looking for that.
        self.leave_live();
        self.player.select(first);
    }

    /// Adds songs at the end of the list; what is heard goes on. Returns the number of the first.
    pub fn append(&mut self, songs: Vec<PathBuf>) -> usize {
        let first = self.songs.len();
        let files: Vec<PathBuf> = songs.iter().map(|song| self.file_of(song).to_owned()).collect();
        self.songs.extend(files);
        self.player.rearrange(self.songs.clone(), (0..first).map(Some).collect());
        first
    }

    /// Whether nobody has chosen a song yet.
    pub fn has_only_the_tune(&self) -> bool {
        self.songs == [self.tune.clone()]
    }

    /// Puts the songs in an order by chance; the one that is heard comes first, and goes on.
    pub fn shuffle(&mut self, seed: u64) {
        let places = self.shuffle_around(self.player.status().song, seed);
        self.player.rearrange(self.songs.clone(), places);
    }

    /// Returns where each song has gone.
    fn shuffle_around(&mut self, heard: usize, seed: u64) -> Vec<Option<usize>> {
        let mut order: Vec<usize> = (0..self.songs.len()).collect();
        let heard = heard.min(order.len().saturating_sub(1));
        order.swap(0, heard);
        let mut state = seed;
        for last in (2..order.len()).rev() {
            // Knuth's linear congruential generator: good enough to shuffle songs.
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            order.swap(last, 1 + (state >> 33) as usize % last);
        }
        self.songs = order.iter().map(|&from| self.songs[from].clone()).collect();
        let mut places = vec![None; order.len()];
        for (place, from) in order.into_iter().enumerate() {
            places[from] = Some(place);
        }
        places
    }

    /// Takes a song out of the list; the last one makes room for the sample tune.
    pub fn remove(&mut self, song: usize) {
        if song >= self.songs.len() {
            return;
        }
        self.songs.remove(song);
        let kept = |place: usize| (place != song).then(|| place - usize::from(place > song));
        let places = (0..=self.songs.len()).map(kept).collect();
        if self.songs.is_empty() {
            self.songs.push(self.tune.clone());
        }
        self.player.rearrange(self.songs.clone(), places);
    }

    /// Plays a song of the list.
    pub fn select(&mut self, song: usize) {
        self.stop_listening();
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

    /// Artist and title of a song of the list, once it has been heard and if it has them, or else its file's name.
    pub fn name_of(&self, song: usize) -> String {
        let tags = self.known(song).map(|known| &known.tags);
        let artist = tags.and_then(|tags| tags.artist.as_deref());
        match (artist, tags.and_then(|tags| tags.title.as_deref())) {
            (Some(artist), Some(title)) => format!("{artist} – {title}"),
            (None, Some(title)) => title.to_owned(),
            (_, None) => self.file_name_of(song),
        }
    }

    /// Its title alone, or its file's name.
    pub fn title_of(&self, song: usize) -> String {
        if let Some(title) = self.known(song).and_then(|known| known.tags.title.clone()) {
            return title;
        }
        self.file_name_of(song)
    }

    /// Its file's name, without the ending.
    pub fn file_name_of(&self, song: usize) -> String {
        let stem = self.songs.get(song).and_then(|path| path.file_stem());
        stem.map_or_else(String::new, |stem| stem.to_string_lossy().into_owned())
    }

    /// Who plays it, once it has been heard and if its tags say so.
    pub fn artist_of(&self, song: usize) -> Option<&str> {
        self.known(song)?.tags.artist.as_deref()
    }

    /// What was learned of a song of the list.
    fn known(&self, song: usize) -> Option<&ShowSong> {
        let path = self.songs.get(song)?;
        self.repertoire.iter().find(|known| known.path == *path)
    }

    /// The cover of a song of the list, once it has been heard and if it has one.
    pub fn cover_of(&self, song: usize) -> Option<&SongCover> {
        self.known(song)?.cover.as_ref()
    }

    /// The file of its cover, where that lies beside it.
    pub fn cover_file_of(&self, song: usize) -> Option<&Path> {
        self.cover_of(song)?.file.as_deref()
    }

    /// The cover of the song that is heard.
    pub fn source_cover(&self) -> Option<&SongCover> {
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

    /// Draws pictures so far ahead of what is heard, since they are seen so much later; behind it where negative.
    pub fn show_ahead(&mut self, secs: f64) {
        self.player.show_ahead(secs);
    }

    /// How far ahead of what is heard the moment of [`hear`](Self::hear) lies. Live input is not known before it is heard.
    pub fn ahead_secs(&self) -> f64 {
        if self.live.is_some() { 0.0 } else { self.player.shown_ahead_secs() }
    }

    /// Where in its song the sound is; the player's status is that of the moment that is shown.
    pub fn heard_secs(&self) -> f64 {
        (self.status().position_secs - self.player.shown_ahead_secs()).max(0.0)
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
        let plays = self.plays_songs();
        self.stop_listening();
        if plays {
            self.player.pause();
        } else {
            self.player.play();
        }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;
    use std::time::{Duration, Instant};

    use chladni_music::{BeatReading, ClockTrack, Moment, Parameters};
    use chladni_sound::{PlayerState, PlayerStatus};

    use super::*;
    use crate::work::formats::TUNE;

    fn listening() -> Listening {
        Listening::start(&egui::Context::default(), 1.0, None).unwrap()
    }

    fn until(listening: &Listening, mut is_it: impl FnMut(&PlayerStatus) -> bool) {
        let end = Instant::now() + chladni_testdata::HANGS;
        while !is_it(&listening.player().status()) {
            assert!(Instant::now() < end, "{:?}", listening.player().status());
            std::thread::sleep(Duration::from_millis(5));
        }
    }

    #[test]
    fn what_dances_is_the_moment_ahead_of_the_one_that_is_heard() {
        let mut listening = listening();
        let hear = |listening: &mut Listening, now_secs: f64| {
            let heard = listening.hear(now_secs, &Parameters::default(), |_, _| Ok(())).unwrap();
            heard.at_secs
        };
        until(&listening, |status| status.position_secs >= 0.3);
        listening.player().pause();
        // The position stands once the pause has reached the device.
        let (mut last, mut stood) = (-1.0, 0);
        until(&listening, |status| {
            stood = if status.position_secs == last { stood + 1 } else { 0 };
            last = status.position_secs;
            stood == 200
        });
        hear(&mut listening, 1.0);
        let before = hear(&mut listening, 1.0);
        listening.show_ahead(0.125);
        assert_eq!(listening.ahead_secs(), 0.125);
        let ahead_secs = listening.player().status().position_secs - listening.heard_secs();
        assert!((ahead_secs - 0.125).abs() < 1e-6, "{ahead_secs}");
        let after = hear(&mut listening, 1.0);
        assert!((after - before - 0.125).abs() < 1e-6, "{before} {after}");
        let (capture, _feed) = chladni_sound::Capture::fed(48_000).unwrap();
        listening.listen_on(capture, "feed".into());
        assert_eq!(listening.ahead_secs(), 0.0, "live input is not known before it is heard");
    }

    #[test]
    fn a_song_that_cannot_be_opened_has_neither_place_nor_length() {
        let folder = tempfile::tempdir().unwrap();
        let broken = folder.path().join("broken.wav");
        std::fs::write(&broken, b"no music").unwrap();
        let mut listening = listening();
        until(&listening, |status| status.duration_secs.is_some() && status.position_secs > 0.0);
        listening.add(vec![broken]);
        until(&listening, |status| status.state == PlayerState::Stopped);
        let status = listening.status();
        assert_eq!((status.position_secs, status.duration_secs), (0.0, None));
        assert_eq!((listening.heard_secs(), listening.source_name()), (0.0, "broken".into()));
    }

    #[test]
    fn the_sample_tune_is_a_song_by_its_name() {
        let mut listening = listening();
        listening.add(vec![PathBuf::from("gone.flac"), PathBuf::from(TUNE)]);
        assert_eq!(listening.songs, [PathBuf::from("gone.flac"), listening.tune.clone()]);
    }

    #[test]
    fn the_sample_tune_of_a_show_stays_before_songs_that_follow() {
        let mut listening = listening();
        let tune = ShowSong::new(TUNE.into(), BeatReading::default());
        listening.go_on(vec![tune], &[], ClockTrack::default(), Moment::default());
        assert_eq!(listening.append(vec!["after.flac".into()]), 1);
        assert_eq!(listening.songs, [listening.tune.clone(), "after.flac".into()]);
    }

    #[test]
    fn a_shuffled_list_has_each_song_once_and_begins_with_the_one_that_is_heard() {
        let mut listening = listening();
        let songs: Vec<PathBuf> = (0..40).map(|n| PathBuf::from(format!("{n}.flac"))).collect();
        for (heard, seed) in [(0, 1), (7, 2), (39, 3), (7, 4)] {
            listening.songs.clone_from(&songs);
            let places = listening.shuffle_around(heard, seed);
            assert!(places.iter().zip(&songs).all(|(to, song)| listening.songs[to.unwrap()] == *song));
            assert_eq!(listening.songs[0], songs[heard]);
            assert_eq!(listening.songs.iter().collect::<HashSet<_>>(), songs.iter().collect());
            assert_eq!(listening.songs.len(), songs.len());
            assert_ne!(listening.songs[1..], songs[1..]);
        }
    }
}
