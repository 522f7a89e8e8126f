//! Songs of the playlist, read as a whole in the background: first their samples, then their beats.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, channel};

use chladni_sound::{Beats, Song, SongOptions, SongReader, SongTags, SoundError, track_beats};
use chladni_task::Task;
use chladni_view::Picture;

use egui::{Context, TextureHandle};

use crate::studio::pictures::upload;
use crate::work::{KnownSong, cover_of};

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
}

impl Study {
    /// Begins to read `path`; its beats are tracked where they are not `known` already.
    pub fn begin(number: usize, path: &Path, known: bool, ctx: &Context) -> Self {
        let (task, (teller, findings)) = (Task::new(), channel());
        let (path, worker) = (path.to_owned(), task.clone());
        let ctx = ctx.clone();
        std::thread::spawn(move || {
            // Nobody listens any more where another song is studied.
            let tell = |learned| drop(teller.send(learned));
            let options = SongOptions::default();
            let song = SongReader::open(&path).and_then(|mut reader| {
                tell(Learned::Tags(reader.tags()));
                if let Some(cover) = cover_of(&path, &mut reader) {
                    let texture = upload(&ctx, "cover", &cover.picture);
                    let picture = Arc::new(cover.picture);
                    tell(Learned::Cover(SongCover { texture, picture, file: cover.file }));
                }
                Song::read(&mut reader, &options, &worker)
            });
            let song = match song {
                Ok(song) => Arc::new(song),
                Err(why @ SoundError::TooLong { .. }) => {
                    return tell(Learned::Nothing(Some(why.to_string())));
                }
                Err(_) => return tell(Learned::Nothing(None)),
            };
            match KnownSong::new(Arc::clone(&song)) {
                Ok(known) => tell(Learned::Song(known)),
                Err(why) => return tell(Learned::Nothing(Some(why.to_string()))),
            }
            if known {
                return;
            }
            match track_beats(&song, &worker) {
                Ok(beats) => tell(Learned::Beats(beats)),
                Err(why) => tell(Learned::Nothing(Some(why.to_string()))),
            }
        });
        Self { number, task, findings }
    }

    /// The next finding, if there is one.
    pub fn learned(&self) -> Option<Learned> {
        self.findings.try_recv().ok()
    }
}

impl Drop for Study {
    fn drop(&mut self) {
        self.task.cancel();
    }
}
