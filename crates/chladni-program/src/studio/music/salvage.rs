//! Recordings of the stage that a crash cut off: each is noted while it is made, and those whose program is gone are made
//! into films at the next start.

use std::ffi::OsString;
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
        chladni_task::create_private_folder(recovery)?;
        chladni_task::create_private_folder(&notes)?;
        let recording = std::path::absolute(recording)?;
        let note = notes.join(recording.file_name().unwrap_or_default());
        chladni_task::write_atomic_private(&note, recording.as_os_str().as_encoded_bytes())?;
        Ok(Self(note))
    }

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
    /// Its folder, where the next start may make a film of it.
    waits: Option<PathBuf>,
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
        for Saved { was, film, waits } in saved {
            let was = was.display();
            match film {
                Ok(film) => shared.notices.warn(format!(
                    "The recording of {was} was cut off. What there was of it is now {}",
                    film.display()
                )),
                Err(why) => {
                    shared.notices.failed(why.of(was.to_string()));
                    if let Some(folder) = waits {
                        shared.notices.warn(format!(
                            "What there is of {was} lies in {}: the next start tries again to make a film of it",
                            folder.display()
                        ));
                    }
                }
            }
        }
    }
}

/// Recordings with a note that no program writes any more. Notes of recordings that are gone are removed; those whose disk is
/// not there stay, whatever their age: the clock may be wrong, and the recording is not.
fn find(notes: &Path) -> Vec<(PathBuf, CutOff)> {
    let entries = std::fs::read_dir(notes).into_iter().flatten().filter_map(Result::ok);
    let mut found = Vec::new();
    for note in entries.map(|entry| entry.path()) {
        let Some(folder) = std::fs::read(&note).ok().and_then(path_of) else { continue };
        if let Some(recording) = CutOff::find(&folder) {
            found.push((note, recording));
        } else if folder.try_exists().is_ok_and(|is_there| !is_there) && is_mounted(&folder) {
            // One that cannot be removed does no harm.
            let _ = std::fs::remove_file(&note);
        }
    }
    found
}

/// The path whose bytes a note holds; on Unix they need not be text.
fn path_of(bytes: Vec<u8>) -> Option<PathBuf> {
    #[cfg(unix)]
    let path = Some(<OsString as std::os::unix::ffi::OsStringExt>::from_vec(bytes));
    #[cfg(not(unix))]
    let path = String::from_utf8(bytes).ok().map(OsString::from);
    path.map(PathBuf::from)
}

/// Whether the disk of a recording is there. Where none is mounted, the folder around it is missing or empty.
fn is_mounted(recording: &Path) -> bool {
    let around = recording.parent().and_then(|around| std::fs::read_dir(around).ok());
    around.is_some_and(|mut entries| entries.next().is_some())
}

fn save((note, recording): (PathBuf, CutOff)) -> Saved {
    let (was, folder) = (recording.film().to_owned(), recording.folder().to_owned());
    let is_empty = recording.is_empty();
    let film = recording.save().map_err(Error::from);
    // Where there is nothing to save, that is said once; what fails otherwise may succeed at the next start.
    let waits = film.is_err() && !is_empty;
    if !waits {
        let _ = std::fs::remove_file(&note);
    }
    Saved { was, film, waits: waits.then_some(folder) }
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

    #[cfg(unix)]
    #[test]
    fn a_note_can_be_read_by_its_owner_alone() {
        use std::os::unix::fs::PermissionsExt;
        let home = tempfile::tempdir().unwrap();
        let recovery = home.path().join("recovery");
        let note = Note::write(&recovery, &home.path().join(".chladni-abc")).unwrap();
        let paths = [&recovery, &recovery.join(NOTES), &note.0];
        let modes = paths.map(|path| path.metadata().unwrap().permissions().mode() & 0o777);
        assert_eq!(modes, [0o700, 0o700, 0o600]);
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
        // It has no picture: the folder stays for a person to look at, and is named once.
        let said = saved.film.unwrap_err().to_string();
        assert!(said.contains(&recording.display().to_string()) && recording.exists(), "{said}");
        assert_eq!(saved.waits, None);
        assert!(find(&recovery.join(NOTES)).is_empty());
        assert_eq!(std::fs::read_dir(recovery.join(NOTES)).unwrap().count(), 0);
    }

    #[test]
    fn what_cannot_be_saved_now_waits_for_the_next_start() {
        let home = tempfile::tempdir().unwrap();
        let (recovery, recording) = (home.path().join("recovery"), home.path().join(".chladni-abc"));
        std::fs::create_dir(&recording).unwrap();
        std::fs::write(recording.join("recording.txt"), "48000\nset.mp4\n").unwrap();
        std::fs::write(recording.join("picture.mp4"), "no picture that ffmpeg knows").unwrap();
        std::mem::forget(Note::write(&recovery, &recording).unwrap());
        let saved = save(find(&recovery.join(NOTES)).remove(0));
        assert!(saved.film.is_err() && recording.exists());
        assert_eq!(saved.waits, Some(recording));
        assert_eq!(std::fs::read_dir(recovery.join(NOTES)).unwrap().count(), 1);
    }

    #[test]
    fn a_note_waits_for_a_disk_that_is_not_mounted() {
        let home = tempfile::tempdir().unwrap();
        let (recovery, disk) = (home.path().join("recovery"), home.path().join("disk"));
        let recording = disk.join(".chladni-abc");
        std::fs::create_dir_all(&recording).unwrap();
        std::mem::forget(Note::write(&recovery, &recording).unwrap());
        let is_kept = || {
            assert!(find(&recovery.join(NOTES)).is_empty());
            recovery.join(NOTES).join(".chladni-abc").exists()
        };
        std::fs::remove_dir_all(&recording).unwrap();
        assert!(is_kept(), "an empty place to mount it at");
        std::fs::remove_dir(&disk).unwrap();
        assert!(is_kept(), "no place");
        // A clock that jumps makes notes of any age.
        let note = std::fs::File::options().write(true).open(recovery.join(NOTES).join(".chladni-abc"));
        let note = note.unwrap();
        let now = std::time::SystemTime::now();
        for written in [std::time::SystemTime::UNIX_EPOCH, now + std::time::Duration::from_secs(1 << 25)] {
            note.set_modified(written).unwrap();
            assert!(is_kept(), "{written:?}");
        }
        // One that is long at work is no recording that is missing.
        std::fs::create_dir_all(&recording).unwrap();
        assert!(is_kept());
        std::fs::remove_dir(&recording).unwrap();
        std::fs::write(disk.join("set.mp4"), "another").unwrap();
        assert!(!is_kept(), "the disk is there, the recording is not");
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_folder_need_not_be_text() {
        use std::os::unix::ffi::OsStrExt;
        let home = tempfile::tempdir().unwrap();
        let folder = home.path().join(std::ffi::OsStr::from_bytes(b"caf\xe9"));
        let (recovery, recording) = (home.path().join("recovery"), folder.join(".chladni-abc"));
        std::fs::create_dir_all(&recording).unwrap();
        std::fs::write(recording.join("recording.txt"), "48000\nset.mp4\n").unwrap();
        std::mem::forget(Note::write(&recovery, &recording).unwrap());
        let found = find(&recovery.join(NOTES));
        assert_eq!(found.first().map(|(_, recording)| recording.film()), Some(&*folder.join("set.mp4")));
    }
}
