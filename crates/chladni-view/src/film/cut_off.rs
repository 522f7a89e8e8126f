//! The folder of a recording while it is made, and the recording of a program that ended first.

use std::fs::File;
use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::process::Stdio;

use chladni_task::{folder_of, persist_new, private_folder};
use tempfile::{NamedTempFile, TempDir};

use super::ffmpeg::{add_input, ffmpeg, ffmpeg_is_there, file_argument, unwritten_by_ffmpeg};
use super::whole::{UNFINISHED, is_whole};
use super::{beside, persist};
use crate::ViewError;

/// How the folders are called, beside the films that are to be.
const PREFIX: &str = ".chladni-";
const PICTURE: &str = "picture.mp4";
const SOUND: &str = "sound.raw";
/// Says which film it is to be, and the rate of its sound; locked while it is recorded.
const NOTE: &str = "recording.txt";
/// No note is longer.
const MOST_BYTES: u64 = 64 << 10;

/// Where a recording is made. Dropped, it is gone.
#[derive(Debug)]
pub(super) struct RecordingFolder {
    folder: TempDir,
    film: PathBuf,
    /// A film was there before, whose place it takes.
    replaces: bool,
    sound_hz: u32,
    /// Holds the lock.
    _note: File,
}

impl RecordingFolder {
    /// Makes one beside `film`.
    pub(super) fn create(film: &Path, sound_hz: u32) -> std::io::Result<Self> {
        let folder = private_folder(PREFIX, folder_of(film))?;
        let name = film.file_name().unwrap_or_default().to_string_lossy();
        let mut note = File::create(folder.path().join(NOTE))?;
        // Where the file system has no locks, it is recorded all the same, and left alone afterwards.
        let _ = note.lock();
        writeln!(note, "{sound_hz}\n{name}")?;
        // Not every volume can flush; without it, only a power cut would lose the note.
        let _ = note.sync_all();
        let replaces = film.symlink_metadata().is_ok();
        Ok(Self { folder, film: film.to_owned(), replaces, sound_hz, _note: note })
    }

    pub(super) fn path(&self) -> &Path {
        self.folder.path()
    }

    /// The film that it is to be.
    pub(super) fn film(&self) -> &Path {
        &self.film
    }

    /// The film without sound.
    pub(super) fn picture(&self) -> PathBuf {
        self.path().join(PICTURE)
    }

    /// Pairs of 32-bit floats.
    pub(super) fn sound(&self) -> PathBuf {
        self.path().join(SOUND)
    }

    /// Puts picture and sound together into the film, which lasts `secs`; returns where it is. If that fails, the folder
    /// stays.
    pub(super) fn join(self, secs: f64) -> Result<PathBuf, ViewError> {
        let file = join((&self.picture(), &self.sound(), self.sound_hz), Some(secs), &self.film);
        let joined = file.and_then(|file| self.name(file));
        if joined.is_err() {
            self.keep();
        }
        joined
    }

    /// Gives the film its name, or one with a number where a file has come there since it began: another window may have
    /// recorded under the same name.
    fn name(&self, file: NamedTempFile) -> Result<PathBuf, ViewError> {
        if self.replaces {
            persist(file, &self.film)?;
            return Ok(self.film.clone());
        }
        persist_new(file, free_names(&self.film, None)).map_err(ViewError::at(&self.film))
    }

    /// It stays, for [`CutOff`].
    pub(super) fn keep(self) {
        let _ = self.folder.keep();
    }
}

/// A recording whose program or encoder ended before it did, as its folder has it.
#[derive(Debug)]
pub struct CutOff {
    folder: PathBuf,
    film: PathBuf,
    sound_hz: u32,
    /// Holds the lock, so that nobody else takes it.
    _note: File,
}

impl CutOff {
    /// The unfinished film in a [`LiveFilm::folder`](super::LiveFilm::folder); `None` where the folder is gone, is
    /// another kind of folder, or is still being recorded to.
    pub fn find(folder: &Path) -> Option<Self> {
        if !folder.file_name()?.to_str()?.starts_with(PREFIX) || !folder.symlink_metadata().ok()?.is_dir() {
            return None;
        }
        // NFS locks only what may be written.
        let note = File::options().read(true).write(true).open(folder.join(NOTE)).ok()?;
        note.try_lock().ok()?;
        let mut text = String::new();
        (&note).take(MOST_BYTES).read_to_string(&mut text).ok()?;
        let (sound_hz, name) = text.trim_end_matches('\n').split_once('\n')?;
        // A name, not a way to another folder.
        let name = Path::new(Path::new(name).file_name()?);
        let film = folder.parent()?.join(name);
        Some(Self { folder: folder.to_owned(), film, sound_hz: sound_hz.parse().ok()?, _note: note })
    }

    /// Where it lies.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// The film that it was to be.
    pub fn film(&self) -> &Path {
        &self.film
    }

    /// Whether nothing was recorded, so that there is nothing to make a film of.
    pub fn is_empty(&self) -> bool {
        !has_bytes(&self.folder.join(PICTURE))
    }

    /// Makes a film of what was recorded, beside the one that it was to be, and removes the folder; where the film is.
    /// The last second may be missing.
    ///
    /// # Errors
    /// [`ViewError::NoFfmpeg`], [`ViewError::Film`] where it has no picture, [`ViewError::Ffmpeg`] and
    /// [`ViewError::File`]. The folder stays.
    pub fn save(self) -> Result<PathBuf, ViewError> {
        if self.is_empty() {
            let folder = self.folder.display();
            return Err(ViewError::Film(format!("no picture was recorded; the rest is in {folder}")));
        }
        if !ffmpeg_is_there() {
            return Err(ViewError::NoFfmpeg);
        }
        let (picture, sound) = (self.folder.join(PICTURE), self.folder.join(SOUND));
        let file = join((&picture, &sound, self.sound_hz), None, &self.film)?;
        let film = persist_new(file, free_names(&self.film, Some("cut off")));
        let film = film.map_err(ViewError::at(&self.film))?;
        std::fs::remove_dir_all(&self.folder).map_err(ViewError::at(&self.folder))?;
        Ok(film)
    }
}

/// `set.mp4` or, with a note, `set (note).mp4`; then those with a number, as `set (2).mp4` or `set (note 2).mp4`.
fn free_names(film: &Path, note: Option<&str>) -> impl Iterator<Item = PathBuf> {
    let stem = film.file_stem().unwrap_or_default().to_string_lossy();
    let with = move |words: &str| film.with_file_name(format!("{stem} ({words}).mp4"));
    let first = note.map_or_else(|| film.to_owned(), &with);
    let rest = (2_u32..).map(move |number| match note {
        Some(note) => with(&format!("{note} {number}")),
        None => with(&number.to_string()),
    });
    std::iter::once(first).chain(rest)
}

fn has_bytes(path: &Path) -> bool {
    path.metadata().is_ok_and(|file| file.len() > 0)
}

/// Puts a picture and its sound together, with silence up to `secs` where that is known, in a file beside `film`.
fn join(
    (picture, sound, sound_hz): (&Path, &Path, u32),
    secs: Option<f64>,
    film: &Path,
) -> Result<NamedTempFile, ViewError> {
    let file = beside(film)?;
    let mut command = ffmpeg();
    command.args(["-y", "-nostdin", "-loglevel", "error"]);
    add_input(&mut command, picture, &["mov"]);
    if has_bytes(sound) || secs.is_some() {
        command.args(["-f", "f32le", "-ar", &sound_hz.to_string(), "-ac", "2"]);
        add_input(&mut command, sound, &["f32le"]);
        command.args(["-map", "0:v", "-map", "1:a", "-c:a", "aac", "-b:a", "192k"]);
    }
    if let Some(secs) = secs {
        // Cut by hand: with copied pictures, -shortest would let the sound run on.
        command.args(["-af", "apad", "-t", &format!("{secs:.6}")]);
    }
    command.args(["-c:v", "copy", "-movflags", "+faststart", "-f", "mp4"]).arg(file_argument(file.path()));
    let said = command.stdin(Stdio::null()).output().map_err(|why| ViewError::Ffmpeg(why.to_string()))?;
    let is_whole = said.status.success()
        && is_whole(&mut file.reopen().map_err(ViewError::at(film))?).map_err(ViewError::at(film))?;
    if !is_whole {
        let words = String::from_utf8_lossy(&said.stderr);
        let words = if words.trim().is_empty() { UNFINISHED } else { words.trim() };
        return Err(unwritten_by_ffmpeg(words.to_owned(), film));
    }
    Ok(file)
}
