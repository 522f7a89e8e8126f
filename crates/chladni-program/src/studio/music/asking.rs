//! Files that a person is asked for while the dance goes on, and their use.

use std::path::{Path, PathBuf};

use chladni_music::ItemId;
use chladni_task::counted;

use super::MusicRoom;
use super::lineage;
use super::wish::Then;
use crate::studio::choose::{FileKind, with_ending};
use crate::studio::file_window::Request;
use crate::studio::room::{Room, Shared};
use crate::work::formats::{LISTS, MESHES, PROJECT, SONGS, TEXT};
use crate::work::{Error, FILMS, PANORAMAS, PICTURES};

/// Pictures and sound of a film, in a folder that is to be named.
const FRAMES: FileKind<'static> = ("A new folder of PNG frames and WAV", &[]);
/// Files of bindings.
const BINDINGS: FileKind<'static> = ("Bindings", &[TEXT]);

impl MusicRoom {
    /// Opens a dialog; the dance goes on meanwhile.
    pub(super) fn ask_for(&mut self, then: Then, shared: &mut Shared<'_>) {
        if shared.chooser.begin(self.request(then)) {
            self.asking = Some(then);
        } else {
            shared.notices.update("file dialog", "A file dialog is open already: answer that one first.");
        }
    }

    /// The question.
    fn request(&self, then: Then) -> Request {
        let songs: Vec<&str> = SONGS.into_iter().chain(LISTS).collect();
        let songs: FileKind<'_> = ("Songs and lists", &songs);
        let text = |suggested: &str| Request::save(&[("Text", &[TEXT])], Path::new(suggested));
        match then {
            Then::Open => {
                let all: Vec<&str> = MESHES.into_iter().chain(self.extensions()).chain([PROJECT]).collect();
                Request::open_several(&[("All that dances or sounds", &all), ("Meshes", &MESHES), songs])
            }
            Then::AddSongs => Request::open_several(&[songs]),
            Then::Film => self.filming.where_to(),
            Then::Frames => Request::save(&[FRAMES], Path::new("dance")),
            Then::Record => Request::save(&[("Films", &["mp4"])], Path::new("set.mp4")),
            Then::SavePreset(_) => text("dance.toml"),
            Then::SaveShow | Then::SaveShowFirst => text("show.toml"),
            Then::Picture => {
                let kinds: Vec<&str> = PICTURES.into_iter().chain(FILMS).collect();
                Request::open(&[("Pictures and films", &kinds)])
            }
            Then::Panorama => Request::open(&[("Panoramas", &PANORAMAS)]),
            Then::ExportBindings => Request::save(&[BINDINGS], Path::new("bindings.toml")),
            Then::ImportBindings => Request::open(&[BINDINGS]),
        }
    }

    /// Does what files were asked for, once they are chosen.
    pub(super) fn follow_dialog(&mut self, shared: &mut Shared<'_>) {
        let Some(mut files) = shared.chooser.answer() else { return };
        let (Some(then), Some(first)) = (self.asking.take(), files.first_mut()) else { return };
        let endings: &[&str] = match then {
            Then::SavePreset(_) | Then::SaveShow | Then::SaveShowFirst | Then::ExportBindings => &[TEXT],
            Then::Record => &["mp4", "m4v"],
            _ => &[],
        };
        if let Some(ending) = endings.first() {
            // Under another ending, as in `gig 3.5`, it would not open again.
            let (path, is_added) = with_ending(first.clone(), endings, ending);
            first.clone_from(&path);
            if is_added && path.exists() {
                // The dialog, which asks before it replaces a file, did not know this name.
                if shared.chooser.begin(Request { start: path, ..self.request(then) }) {
                    self.asking = Some(then);
                }
                return;
            }
        }
        let first = first.clone();
        if let Err(why) = self.go_on(then, &first, &files, shared) {
            shared.notices.failed(why);
        }
    }

    fn go_on(
        &mut self,
        then: Then,
        first: &Path,
        files: &[PathBuf],
        shared: &mut Shared<'_>,
    ) -> Result<(), Error> {
        match then {
            Then::Open => self.open(files, shared),
            Then::AddSongs => self.append_songs(files, shared),
            Then::Film | Then::Frames => self.film_to(first, then == Then::Frames, shared)?,
            Then::Record => self.record_to(first, None, shared)?,
            Then::SavePreset(item) => self.save_preset(item, first, shared)?,
            Then::SaveShow | Then::SaveShowFirst => {
                self.write_show(first, shared)?;
                if then == Then::SaveShowFirst {
                    self.replace(shared);
                }
            }
            Then::Picture => shared.settings.music.picture = first.to_string_lossy().into_owned(),
            Then::Panorama => shared.settings.music.panorama = first.to_string_lossy().into_owned(),
            Then::ExportBindings => {
                self.drawers.remote.export(first)?;
                shared.notices.done(format!("Wrote {}", first.display()));
            }
            Then::ImportBindings => {
                let count = self.drawers.remote.import(first)?;
                let bindings = counted(count, "binding", "bindings");
                shared.notices.done(format!("{bindings} of {}", first.display()));
            }
        }
        Ok(())
    }

    fn save_preset(&self, item: ItemId, path: &Path, shared: &mut Shared<'_>) -> Result<(), Error> {
        let Some(instrument) = self.concert.as_ref().map(|concert| concert.instrument()) else {
            return Ok(());
        };
        let Some(item) = instrument.item(item) else { return Ok(()) };
        let mut preset = instrument.preset(item, instrument.tags(item.id));
        preset.name = lineage::called(instrument, item);
        preset.save(path).map_err(Error::unsaved)?;
        shared.notices.done(format!("Saved {}", path.display()));
        Ok(())
    }
}
