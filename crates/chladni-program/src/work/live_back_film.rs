//! A film as the background of a live dance, decoded on its own thread; nobody waits for it.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

use chladni_view::Picture;

use super::Error;
use super::back_film::BackFilm;

/// How often the thread checks which picture is wanted: a third of the time that one is shown.
const PERIOD: Duration = Duration::from_millis(13);

/// The newest picture of a film for the time that its user names. When it is dropped, its thread ends.
#[derive(Debug)]
pub struct LiveBackFilm {
    common: Arc<Common>,
    thread: Option<JoinHandle<Result<(), Error>>>,
    /// Why there is no thread.
    unspawned: Option<Error>,
    picture: Picture,
    number: u64,
}

#[derive(Debug, Default)]
struct Common {
    /// The bits of the time that is shown.
    wanted_secs: AtomicU64,
    /// The newest picture, where it was not taken yet.
    newest: Mutex<(Picture, bool)>,
    ends: AtomicBool,
}

impl LiveBackFilm {
    /// Opens the film on another thread; errors are returned by [`trouble`](Self::trouble).
    pub fn open(name: String, longest_side: usize) -> Self {
        let common = Arc::new(Common::default());
        let shared = Arc::clone(&common);
        let spawned = std::thread::Builder::new()
            .name("film behind".into())
            .spawn(move || shared.decode(&name, longest_side));
        let (thread, unspawned) = match spawned {
            Ok(thread) => (Some(thread), None),
            Err(why) => (None, Some(Error::other(format!("no thread for the film behind: {why}")))),
        };
        Self { common, thread, unspawned, picture: Picture::default(), number: 0 }
    }

    /// The newest picture there is for `at_secs`, with a number that changes with it; 0 before the first.
    pub fn at(&mut self, at_secs: f64) -> (u64, &Picture) {
        self.common.wanted_secs.store(at_secs.to_bits(), Ordering::Relaxed);
        // The other thread swaps pictures under this lock and does nothing else.
        let mut newest = self.common.newest.lock().unwrap_or_else(PoisonError::into_inner);
        if std::mem::replace(&mut newest.1, false) {
            std::mem::swap(&mut newest.0, &mut self.picture);
            self.number += 1;
        }
        drop(newest);
        (self.number, &self.picture)
    }

    /// Why it stands still, once it does.
    pub fn trouble(&mut self) -> Option<Error> {
        if let Some(why) = self.unspawned.take() {
            return Some(why);
        }
        let ended = self.thread.take_if(|thread| thread.is_finished())?.join();
        ended.unwrap_or_else(|_| Err(Error::other("the film behind cannot be read"))).err()
    }
}

impl Drop for LiveBackFilm {
    fn drop(&mut self) {
        // It ends within a period and a picture; nobody waits for that.
        self.common.ends.store(true, Ordering::Relaxed);
    }
}

impl Common {
    fn decode(&self, name: &str, longest_side: usize) -> Result<(), Error> {
        let mut film = BackFilm::open(name, longest_side)?;
        let (mut is_new, mut copy) = (true, Picture::default());
        let goes_on = || !self.ends.load(Ordering::Relaxed);
        while goes_on() {
            let wanted_secs = f64::from_bits(self.wanted_secs.load(Ordering::Relaxed));
            is_new |= film.go_to(wanted_secs, goes_on)?;
            if std::mem::take(&mut is_new) {
                copy.clone_from(film.picture());
                let mut newest = self.newest.lock().unwrap_or_else(PoisonError::into_inner);
                std::mem::swap(&mut newest.0, &mut copy);
                newest.1 = true;
            } else {
                std::thread::sleep(PERIOD);
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use std::time::Instant;

    use super::*;

    #[test]
    fn the_newest_picture_comes_by_itself_and_a_bad_file_says_so() {
        let until = |what: &str, ready: &mut dyn FnMut() -> bool| {
            let began = Instant::now();
            while !ready() {
                assert!(began.elapsed() < chladni_testdata::HANGS, "{what}");
                std::thread::sleep(Duration::from_millis(5));
            }
        };
        let mut gone = LiveBackFilm::open("gone.mp4".into(), 64);
        let mut why = None;
        until("it says so", &mut || {
            why = gone.trouble();
            why.is_some()
        });
        assert!(why.unwrap().to_string().contains("gone.mp4") && gone.at(1.0).0 == 0);
        let folder = tempfile::tempdir().unwrap();
        // Ten pictures.
        let film = chladni_testdata::brightening_film(folder.path(), [128, 64], 0.4, 20);
        let Some(path) = film else { return };
        let mut film = LiveBackFilm::open(path.to_string_lossy().into_owned(), 64);
        until("the first picture", &mut || film.at(0.0).0 > 0);
        let (_, first) = film.at(0.0);
        assert_eq!((first.width, first.height), (64, 32));
        let dark = first.rgba[0];
        until("a brighter one", &mut || film.at(0.3).1.rgba[0] > dark + 60);
        until("the first again", &mut || film.at(0.4).1.rgba[0] == dark);
        assert!(film.trouble().is_none());
    }
}
