//! Facts about songs that become known while they play: title and cover, samples, beats.

use std::path::Path;

use chladni_music::BeatReading;
use chladni_sound::PlayerStatus;

use super::super::study::{Learned, Study};
use super::{Listening, ShowSong};
use crate::studio::pictures::upload;
use crate::work::read_beats;
use crate::work::source::TUNE;

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

    /// The show's number of the song that is heard. One that was taken out of the list sounds on for a moment.
    pub(super) fn number_of_heard(&mut self, status: &PlayerStatus) -> Option<usize> {
        if status.is_listed { self.number_of(status.song) } else { self.clock.stretch()?.song }
    }

    /// Reads the song that is heard, and takes in the findings.
    pub(super) fn learn(&mut self, status: &PlayerStatus) {
        let heard = if self.live.is_some() { None } else { self.number_of_heard(status) };
        while let Some((number, learned)) =
            self.study.as_ref().and_then(|study| Some((study.number, study.learned()?)))
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
                    self.warnings.extend(why.map(|why| format!("{why}. {message}.")));
                }
            }
        }
        let Some(number) = heard else { return };
        let has_samples = self.hearing.song(number).is_some_and(|known| known.song.frames() > 0);
        let studied = self.study.as_ref().is_some_and(|study| study.number == number);
        let Some(song) = self.repertoire.get(number).filter(|song| !song.given_up) else { return };
        if !has_samples && !studied {
            let path = if song.path == Path::new(TUNE) { &self.tune } else { &song.path };
            self.study = Some(Study::begin(number, path, song.beats.is_some(), &self.ctx));
        }
    }
}
