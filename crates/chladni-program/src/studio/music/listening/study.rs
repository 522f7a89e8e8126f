//! Songs of the playlist, read as a whole in the background: first their samples, then their beats.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::thread::{Builder, JoinHandle};

use chladni_sound::{Beats, Song, SongOptions, SongReader, SongTags, SoundError, track_beats};
use chladni_task::Task;
use chladni_view::Picture;

use egui::{Context, TextureHandle};

use crate::studio::pictures::upload;
use crate::work::{Error, KnownSong, cover_of, known_hash};

/// A finding about a song.
pub enum Learned {
    /// The contents of its tags.
    Tags(SongTags),
    /// The picture in its tags, or beside it in a file.
    Cover(SongCover),
    /// Its samples.
    Song(KnownSong),
    /// Its beats.
    Beats(Beats),
    /// Nothing, and why, unless the player reports the same.
    Nothing(Option<String>),
}

/// The cover of a song.
#[derive(Clone)]
pub struct SongCover {
    /// For the window.
    pub texture: TextureHandle,
    /// For pictures that other programs get.
    pub picture: Arc<Picture>,
    /// Where it lies beside the song.
    pub file: Option<PathBuf>,
}

/// One song that is being studied; dropping it ends that.
pub struct Study {
    /// Its number in the show.
    pub number: usize,
    task: Task,
    findings: Receiver<Learned>,
    /// Until it has ended.
    thread: Option<JoinHandle<()>>,
}

impl Study {
    /// Begins to read `path`; its beats are tracked where they are not `known` already.
    pub fn begin(number: usize, path: &Path, known: bool, ctx: &Context) -> Self {
        Self::on(Builder::new().name("song".into()), number, (path, known), ctx)
    }

    fn on(thread: Builder, number: usize, (path, known): (&Path, bool), ctx: &Context) -> Self {
        let (task, (teller, findings)) = (Task::new(), channel());
        let (path, worker) = (path.to_owned(), task.clone());
        let (ctx, refused) = (ctx.clone(), teller.clone());
        let thread = thread.spawn(move || {
            // Nobody listens any more where another song is studied.
            study(&path, known, &ctx, &worker, |learned| drop(teller.send(learned)));
            // A show names each file by its hash, also one that cannot be studied. Hashed here, it does not keep saving
            // waiting.
            if !worker.is_cancelled() {
                known_hash(&path);
            }
        });
        if let Err(why) = &thread {
            let why = format!("No thread can begin to read the song: {why}");
            let _ = refused.send(Learned::Nothing(Some(why)));
        }
        Self { number, task, findings, thread: thread.ok() }
    }

    /// The next finding, if there is one.
    pub fn learned(&mut self) -> Option<Learned> {
        match self.findings.try_recv() {
            Ok(learned) => Some(learned),
            Err(TryRecvError::Empty) => None,
            Err(TryRecvError::Disconnected) => {
                let broke_off = self.thread.take()?.join().is_err();
                let why = Error::BrokeOff("Reading the song".into());
                broke_off.then(|| Learned::Nothing(Some(why.to_string())))
            }
        }
    }
}

impl Drop for Study {
    fn drop(&mut self) {
        self.task.cancel();
    }
}

/// Reads the song at `path` and passes on what is learned; its beats are tracked where they are not `known` already.
fn study(path: &Path, known: bool, ctx: &Context, task: &Task, tell: impl Fn(Learned)) {
    let song = SongReader::open(path).and_then(|mut reader| {
        tell(Learned::Tags(reader.tags()));
        if let Some(cover) = cover_of(path, &mut reader) {
            let texture = upload(ctx, "cover", &cover.picture);
            let picture = Arc::new(cover.picture);
            tell(Learned::Cover(SongCover { texture, picture, file: cover.file }));
        }
        Song::read(&mut reader, &SongOptions::default(), task)
    });
    let song = match song {
        Ok(song) => Arc::new(song),
        Err(why @ SoundError::TooLong { .. }) => return tell(Learned::Nothing(Some(why.to_string()))),
        Err(_) => return tell(Learned::Nothing(None)),
    };
    match KnownSong::new(Arc::clone(&song)) {
        Ok(known) => tell(Learned::Song(known)),
        Err(why) => return tell(Learned::Nothing(Some(why.to_string()))),
    }
    if !known {
        match track_beats(&song, task) {
            Ok(beats) => tell(Learned::Beats(beats)),
            Err(why) => tell(Learned::Nothing(Some(why.to_string()))),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::time::{Duration, Instant, SystemTime};

    use super::*;
    use crate::work::file_hash;

    #[test]
    fn a_song_on_whose_study_a_thread_breaks_off_is_given_up_once() {
        let (teller, findings) = channel();
        let thread = std::thread::spawn(move || {
            teller.send(Learned::Tags(SongTags::default())).unwrap();
            panic!("a bug, on purpose");
        });
        let mut study = Study { number: 0, task: Task::new(), findings, thread: Some(thread) };
        let began = Instant::now();
        let mut next = || loop {
            assert!(began.elapsed() < chladni_testdata::HANGS);
            if let Some(learned) = study.learned() {
                return learned;
            }
            std::thread::yield_now();
        };
        assert!(matches!(next(), Learned::Tags(_)));
        assert!(matches!(next(), Learned::Nothing(Some(_))));
        assert!(study.learned().is_none());
    }

    #[test]
    fn a_song_for_which_no_thread_can_begin_is_given_up_once() {
        // No machine has this much memory for a stack.
        let thread = Builder::new().stack_size(1 << 62);
        let mut study = Study::on(thread, 0, (Path::new("song.wav"), false), &Context::default());
        assert!(matches!(study.learned(), Some(Learned::Nothing(Some(_)))));
        assert!(study.learned().is_none());
    }

    #[test]
    fn a_file_that_cannot_be_studied_is_known_by_its_hash_too() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("song.wav");
        let write = |content: &[u8]| {
            std::fs::write(&path, content).unwrap();
            let changed = SystemTime::UNIX_EPOCH + Duration::from_secs(1_000_000_000);
            std::fs::File::options().write(true).open(&path).unwrap().set_modified(changed).unwrap();
        };
        write(b"no music at all");
        let hash = file_hash(&path);
        let mut study = Study::begin(0, &path, false, &Context::default());
        let began = Instant::now();
        while study.thread.is_some() {
            assert!(began.elapsed() < chladni_testdata::HANGS);
            study.learned();
            std::thread::yield_now();
        }
        // Of the same length and time: it is not read again.
        write(b"no music so far");
        assert!(hash.is_some() && known_hash(&path) == hash);
    }
}
