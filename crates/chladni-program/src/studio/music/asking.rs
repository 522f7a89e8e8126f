//! Files that a person is asked for while the dance goes on, and what is done with them.

use std::path::{Path, PathBuf};

use chladni_music::{ItemId, Preset};

use super::MusicRoom;
use super::shows::write_show;
use crate::studio::choose::FileKind;
use crate::studio::file_window::Request;
use crate::studio::room::{Room, Shared};
use crate::work::Error;
use crate::work::formats::{LISTS, MESHES, PROJECT, SONGS, TEXT};
use crate::work::{FILMS, PANORAMAS, PICTURES};

/// What is done with the answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Then {
    /// The files are opened.
    Open,
    /// The film of the form is made.
    Film,
    /// The set is recorded from now on.
    Record,
    /// A dance is saved as a preset.
    SavePreset(ItemId),
    /// The show is saved.
    SaveShow,
    /// The background is this picture or film.
    Picture,
    /// The light is that of this panorama.
    Panorama,
}

impl MusicRoom {
    /// Asks for files of any that dance or sound, or for songs alone.
    pub(super) fn choose_files(&mut self, songs_only: bool, shared: &mut Shared<'_>) {
        let all: Vec<&str> = MESHES.into_iter().chain(self.extensions()).chain([PROJECT]).collect();
        let songs: Vec<&str> = SONGS.into_iter().chain(LISTS).collect();
        let kinds: [FileKind<'_>; 3] =
            [("All that dances or sounds", &all), ("Meshes", &MESHES), ("Songs and lists", &songs)];
        self.ask_for(
            Then::Open,
            Request::open_several(if songs_only { &kinds[2..] } else { &kinds }),
            shared,
        );
    }

    /// Asks for a text file to save to.
    pub(super) fn ask_where(&mut self, then: Then, suggested: &str, shared: &mut Shared<'_>) {
        self.ask_for(then, Request::save(&[("Text", &[TEXT])], Path::new(suggested)), shared);
    }

    /// Asks for a picture or film to be the background.
    pub(super) fn ask_for_picture(&mut self, shared: &mut Shared<'_>) {
        let kinds: Vec<&str> = PICTURES.into_iter().chain(FILMS).collect();
        self.ask_for(Then::Picture, Request::open(&[("Pictures and films", &kinds)]), shared);
    }

    /// Asks for a panorama whose light is that of the dance.
    pub(super) fn ask_for_panorama(&mut self, shared: &mut Shared<'_>) {
        self.ask_for(Then::Panorama, Request::open(&[("Panoramas", &PANORAMAS)]), shared);
    }

    /// Opens a dialog; the dance goes on meanwhile.
    pub(super) fn ask_for(&mut self, then: Then, request: Request, shared: &mut Shared<'_>) {
        if shared.chooser.begin(request) {
            self.asking = Some(then);
        } else {
            shared.notices.update("file dialog", "A file dialog is open already: answer that one first.");
        }
    }

    /// Does what files were asked for, once they are chosen.
    pub(super) fn follow_dialog(&mut self, shared: &mut Shared<'_>) {
        let Some(files) = shared.chooser.answer() else { return };
        let Some(then) = self.asking.take().filter(|_| !files.is_empty()) else { return };
        if let Err(why) = self.go_on(then, files, shared) {
            shared.notices.failed(why);
        }
    }

    fn go_on(&mut self, then: Then, files: Vec<PathBuf>, shared: &mut Shared<'_>) -> Result<(), Error> {
        if then == Then::Open {
            self.open(&files, shared);
            return Ok(());
        }
        let Some(path) = files.into_iter().next() else { return Ok(()) };
        match then {
            Then::Record => return self.record_to(&path, shared),
            Then::Film => return self.film_to(path, shared),
            Then::Picture => shared.settings.music.picture = path.to_string_lossy().into_owned(),
            Then::Panorama => shared.settings.music.panorama = path.to_string_lossy().into_owned(),
            Then::Open | Then::SavePreset(_) | Then::SaveShow => {}
        }
        let (Some(concert), Some(listening)) = (&mut self.concert, &self.listening) else { return Ok(()) };
        match then {
            Then::SaveShow => write_show(&path, concert, listening, &self.names, shared),
            Then::SavePreset(item) => {
                let Some(item) = concert.instrument().item(item) else { return Ok(()) };
                let preset = Preset::of(concert.instrument(), item, Vec::new());
                preset.save(&path).map_err(Error::unsaved)?;
                shared.notices.done(format!("Saved {}", path.display()));
                Ok(())
            }
            _ => Ok(()),
        }
    }
}
