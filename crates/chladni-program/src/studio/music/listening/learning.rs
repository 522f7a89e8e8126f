//! Facts about songs that become known while they play: title and cover, samples, beats.

use std::path::Path;

use chladni_music::BeatReading;
use chladni_sound::PlayerStatus;

use super::study::{Learned, Study};
use super::{Listening, ShowSong};
use crate::studio::pictures::upload;
use crate::work::formats::TUNE;
use crate::work::read_beats;

impl Listening {
    /// The show's number of a song of the list.
    pub(super) fn number_of(&mut self, song: usize) -> Option<usize> {
        let path = self.songs.get(song)?;
        let path = if *path == self.tune { Path::new(TUNE) } else { path };
        if let Some(number) = self.repertoire.iter().position(|known| known.path == path) {
            return Some(number);
        }
        let path = path.to_owned();
        self.repertoire.push(ShowSong::new(path, BeatReading::default()));
        Some(self.repertoire.len() - 1)
    }

    /// Another window shows the covers.
    pub fn change_window(&mut self, ctx: &egui::Context) {
        self.ctx = ctx.clone();
        for cover in self.repertoire.iter_mut().filter_map(|song| song.cover.as_mut()) {
            cover.texture = upload(ctx, "cover", &cover.picture);
        }
    }

    /// The show's number of the song that is heard; none of live input. One that was taken out of the list sounds on for a
    /// moment.
    pub(super) fn number_of_heard(&mut self, status: &PlayerStatus) -> Option<usize> {
        if self.live.is_some() {
            None
        } else if status.is_listed {
            self.number_of(status.song)
        } else {
            self.clock.stretch()?.song
        }
    }

    /// Reads the song that is heard, and takes in the findings.
    pub(super) fn learn(&mut self, status: &PlayerStatus) {
        let heard = self.number_of_heard(status);
        while let Some((number, learned)) =
            self.study.as_mut().and_then(|study| Some((study.number, study.learned()?)))
        {
            let Some(song) = self.repertoire.get_mut(number) else { break };
            match learned {
                Learned::Song(mut known) => {
                    known.beats = song.beats.as_ref().map(|beats| read_beats(beats, song.reading));
                    self.hearing.know(number, known);
                    self.hearing.forget_samples_but(heard.unwrap_or(number));
                }
                Learned::Beats(beats) => {
                    self.hearing.know_beats(number, read_beats(&beats, song.reading));
                    let (ringing, harmony) = (self.hearing.ringing().clone(), self.hearing.harmony());
                    let heard = (self.spectrum().0.clone(), ringing, harmony);
                    self.hearing.fade_from(self.clock.at_secs(), heard, self.last_beat);
                    if let Some(song) = self.repertoire.get_mut(number) {
                        song.beats = Some(beats);
                    }
                    self.beats_changed = true;
                }
                Learned::Tags(tags) => song.tags = tags,
                Learned::Cover(cover) => song.cover = Some(cover),
                Learned::Nothing(why) => {
                    song.given_up = true;
                    let message = "Until another song plays it is heard as live input is";
                    let why = why.filter(|_| heard == Some(number));
                    self.warnings.extend(why.map(|why| format!("{why}. {message}.")));
                }
            }
        }
        if std::mem::replace(&mut self.learned_of, heard) != heard {
            // Its file may have come back, as a drive that is plugged in again has.
            let song = heard.and_then(|number| self.repertoire.get_mut(number));
            if song.is_some_and(|song| std::mem::take(&mut song.given_up)) {
                self.study = None;
            }
        }
        let Some(number) = heard else { return };
        let has_samples = self.hearing.song(number).is_some_and(|known| known.song.frames() > 0);
        let studied = self.study.as_ref().is_some_and(|study| study.number == number);
        let Some(song) = self.repertoire.get(number) else { return };
        if has_samples || song.given_up {
            self.study_those_before();
        } else if !studied {
            self.study =
                Some(Study::begin(number, self.file_of(&song.path), song.beats.is_some(), &self.ctx));
        }
    }

    /// Finds the beats of songs that were heard before, so that they count as they do in a film.
    fn study_those_before(&mut self) {
        let is_done = |number: usize| {
            self.repertoire.get(number).is_none_or(|song| song.beats.is_some() || song.given_up)
        };
        if self.study.as_ref().is_some_and(|study| !is_done(study.number)) {
            return;
        }
        let number = self.hearing.stretches().filter_map(|stretch| stretch.song).find(|n| !is_done(*n));
        if let Some((number, song)) = number.and_then(|n| Some((n, self.repertoire.get(n)?))) {
            self.study = Some(Study::begin(number, self.file_of(&song.path), false, &self.ctx));
        }
    }

    /// The file of the song that a show names so.
    pub(super) fn file_of<'a>(&'a self, named: &'a Path) -> &'a Path {
        if named == Path::new(TUNE) { &self.tune } else { named }
    }
}

#[cfg(test)]
mod tests {
    use std::time::{Duration, Instant};

    use chladni_music::{ClockTrack, Moment, Parameters, Stretch};
    use chladni_sound::{WavSample, sample_tune, write_wav};

    use super::*;

    #[test]
    fn a_song_that_was_given_up_is_read_again_where_it_is_heard_anew() {
        let mut listening = Listening::start(&egui::Context::default(), 1.0, None).unwrap();
        let number = listening.number_of(0).unwrap();
        listening.repertoire[number].given_up = true;
        let status = PlayerStatus { is_listed: true, ..PlayerStatus::default() };
        listening.learn(&status);
        assert!(!listening.repertoire[number].given_up);
        assert!(listening.study.take().is_some_and(|study| study.number == number));
        // Once, while it is heard.
        listening.repertoire[number].given_up = true;
        listening.learn(&status);
        assert!(listening.repertoire[number].given_up && listening.study.is_none());
    }

    #[test]
    fn the_beats_of_songs_that_were_heard_before_are_found_too() {
        let folder = tempfile::tempdir().unwrap();
        let songs = ["first.wav", "second.wav"].map(|name| {
            let path = folder.path().join(name);
            write_wav(&path, &sample_tune(), WavSample::Int16).unwrap();
            ShowSong::new(path, BeatReading::default())
        });
        let mut listening = Listening::start(&egui::Context::default(), 1.0, None).unwrap();
        let stretch = |at_secs: f64, song: usize| Stretch {
            at_secs,
            song: Some(song),
            song_secs: 0.0,
            playing: true,
            crossfade_secs: 0.0,
        };
        let at = Moment { at_secs: 20.0, at_beat: 0.0 };
        listening.go_on(Vec::from(songs), &[stretch(0.0, 1), stretch(10.0, 0)], ClockTrack::default(), at);
        let (began, mut last_beat) = (Instant::now(), 0.0);
        while listening.repertoire.iter().any(|song| song.beats.is_none()) {
            let gone_secs = began.elapsed();
            assert!(gone_secs < chladni_testdata::HANGS, "they are not looked for");
            let now_secs = gone_secs.as_secs_f64();
            let heard = listening.hear(now_secs, &Parameters::default(), |_, _| Ok(())).unwrap();
            let beat = heard.beat.count;
            // What was done before is not yet counted anew.
            assert!(!listening.beats_changed() || beat == last_beat, "{beat} after {last_beat}");
            last_beat = beat;
            std::thread::sleep(Duration::from_millis(5));
        }
        // As in a film of the show, which knows both.
        let beats = listening.hearing.beat_at(10.0).count;
        assert!(beats > 10.0, "{beats}");
    }
}
