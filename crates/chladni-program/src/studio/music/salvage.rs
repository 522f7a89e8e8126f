//! Recordings of the stage that a crash cut off: each is noted while it is made, and those whose program is gone are made
//! into films at the next start.

use std::io;
use std::path::{Path, PathBuf};

use chladni_view::film::CutOff;

use crate::studio::job::Job;
use crate::studio::room::Shared;
use crate::work::Error;

/// The folder of the notes, in that of recovery copies.
const NOTES: &str = "recordings";

/// The note of a recording. Dropped, it is gone: the recording has ended.
pub struct Note(PathBuf);

impl Note {
    /// Notes that something is recorded in `recording`.
    pub fn write(recovery: &Path, recording: &Path) -> io::Result<Self> {
        let notes = recovery.join(NOTES);
        chladni_task::create_folder(&notes)?;
        let recording = std::path::absolute(recording)?;
        let note = notes.join(recording.file_name().unwrap_or_default());
        chladni_task::write_atomic(&note, recording.to_string_lossy().as_bytes())?;
        Ok(Self(note))
    }
}

impl Note {
    /// The recording failed: the note stays.
    pub fn leave(self) {
        std::mem::forget(self);
    }
}

impl Drop for Note {
    fn drop(&mut self) {
        // One that stays names a folder that is gone, and is removed at the next start.
        let _ = std::fs::remove_file(&self.0);
    }
}

/// One recording that was cut off: the film it was to be, and where it is now.
struct Saved {
    was: PathBuf,
    film: Result<PathBuf, Error>,
}

/// Looks for recordings that were cut off, once unless asked.
#[derive(Default)]
pub struct Salvage {
    looked: bool,
    work: Option<Job<Vec<Saved>>>,
}

impl Salvage {
    /// Something was cut off just now.
    pub fn look_again(&mut self) {
        self.looked = false;
    }

    /// Begins where there is something, and tells what came of it.
    pub fn follow(&mut self, shared: &mut Shared<'_>) {
        if self.work.is_none()
            && !std::mem::replace(&mut self.looked, true)
            && let Some(recovery) = &shared.folders.recovery
        {
            let found = find(&recovery.join(NOTES));
            if !found.is_empty() {
                let save = move |_: &_| Ok(found.into_iter().map(save).collect());
                self.work = Some(Job::start("Saving what was recorded", &shared.ctx, save));
            }
        }
        let Some(ended) = self.work.as_ref().and_then(Job::ended) else { return };
        self.work = None;
        let saved = ended.unwrap_or_else(|why| {
            shared.notices.failed(why);
            Vec::new()
        });
        for Saved { was, film } in saved {
            let was = was.display();
            match film {
                Ok(film) => shared.notices.warn(format!(
                    "The recording of {was} was cut off. What there was of it is now {}",
                    film.display()
                )),
                Err(why) => shared.notices.failed(why.of(was.to_string())),
            }
        }
    }
}

/// Recordings with a note that no program writes any more. Notes of missing recordings are removed.
fn find(notes: &Path) -> Vec<(PathBuf, CutOff)> {
    let entries = std::fs::read_dir(notes).into_iter().flatten().filter_map(Result::ok);
    let mut found = Vec::new();
    for note in entries.map(|entry| entry.path()) {
        let Ok(folder) = std::fs::read_to_string(&note).map(PathBuf::from) else { continue };
        if let Some(recording) = CutOff::find(&folder) {
            found.push((note, recording));
        } else if !folder.exists() {
            // One that cannot be removed does no harm.
            let _ = std::fs::remove_file(&note);
        }
    }
    found
}

fn save((note, recording): (PathBuf, CutOff)) -> Saved {
    let was = recording.film().to_owned();
    let film = recording.save().map_err(Error::from);
    if film.is_ok() {
        let _ = std::fs::remove_file(&note);
    }
    Saved { was, film }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_note_lasts_as_long_as_its_recording() {
        let home = tempfile::tempdir().unwrap();
        let (recovery, recording) = (home.path().join("recovery"), home.path().join(".chladni-abc"));
        std::fs::create_dir(&recording).unwrap();
        let notes = || std::fs::read_dir(recovery.join(NOTES)).unwrap().count();
        let note = Note::write(&recovery, &recording).unwrap();
        assert_eq!(notes(), 1);
        // Nothing was recorded there: it is left alone, and so is its note.
        assert!(find(&recovery.join(NOTES)).is_empty());
        assert_eq!(notes(), 1);
        drop(note);
        assert_eq!(notes(), 0);
        let note = Note::write(&recovery, &recording).unwrap();
        std::mem::forget(note);
        std::fs::remove_dir(&recording).unwrap();
        assert!(find(&recovery.join(NOTES)).is_empty());
        assert_eq!(notes(), 0);
    }

    #[test]
    fn what_a_crash_left_is_found() {
        let home = tempfile::tempdir().unwrap();
        let (recovery, recording) = (home.path().join("recovery"), home.path().join(".chladni-abc"));
        std::fs::create_dir(&recording).unwrap();
        std::fs::write(recording.join("recording.txt"), "48000\nset.mp4\n").unwrap();
        std::mem::forget(Note::write(&recovery, &recording).unwrap());
        let mut found = find(&recovery.join(NOTES));
        assert_eq!(found.len(), 1);
        let saved = save(found.remove(0));
        assert_eq!(saved.was, home.path().join("set.mp4"));
        // It has no picture: the folder stays for a person to look at.
        assert!(saved.film.is_err() && recording.exists());
    }
}
