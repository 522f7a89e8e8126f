//! A copy of the show, kept in the background: a crash loses seconds of it, and the next start offers the rest.

use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::time::{Duration, Instant, SystemTime};

use chladni_mesh::Orientation;
use chladni_music::{BeatReading, Looks, Show, Viewpoint};
use chladni_task::RecoveryCopy;
use egui::RichText;

use super::MusicRoom;
use super::concert::Concert;
use super::listening::Listening;
use crate::studio::age::changed_ago;
use crate::studio::author_id::AuthorId;
use crate::studio::copying::{INTERVAL_SECS, WITHIN_SECS, pause_secs};
use crate::studio::room::Shared;
use crate::studio::theme;

/// A long show takes time to put together, too, for which the window waits: it is copied a second later for so many actions.
const ACTIONS_PER_SEC: f64 = 20_000.0;
/// A copy lacks no more than this of a show in which sound goes on and nothing else is done.
const HEARD_SECS: f64 = 30.0;
/// Beginning and ending of a copy's name.
const NAMES: (&str, &str) = ("show", "toml");

/// A copy that was written, or why not.
struct Written {
    /// `None` where it could not be begun.
    copy: Option<RecoveryCopy>,
    failure: Option<String>,
    took_secs: f64,
}

/// How long after a copy that took so long to write the next one of a show with so many actions may be due.
fn interval_secs(took_secs: f64, actions: usize) -> f64 {
    pause_secs(took_secs, actions as f64 / ACTIONS_PER_SEC, [INTERVAL_SECS, WITHIN_SECS])
}

/// What a copy has of a show that goes on. Where any of it is another by now, a new copy is due.
#[derive(Clone, Debug, Default, PartialEq)]
struct Kept {
    actions: usize,
    body: PathBuf,
    stands: Option<Orientation>,
    stretches: usize,
    /// Those of the songs that were heard.
    readings: Vec<BeatReading>,
    /// Sets that were recorded.
    recorded: usize,
    looks: Looks,
    viewpoint: Viewpoint,
    /// Marks of the outer clock.
    clock_marks: usize,
    /// While sound is heard, how many times [`HEARD_SECS`] have gone by.
    heard: Option<u64>,
}

impl Kept {
    fn of(concert: &Concert, listening: &Listening, body: &Path, looks: Looks) -> Self {
        let (heard, songs) = listening.heard();
        Self {
            actions: concert.instrument().log().len(),
            body: body.to_owned(),
            stands: concert.standing().given,
            stretches: heard.len(),
            readings: songs.iter().map(|song| song.reading).collect(),
            recorded: concert.outgoing.recorded.len(),
            looks,
            viewpoint: concert.viewpoint(),
            clock_marks: listening.clock().marks().len(),
            heard: heard_of(listening),
        }
    }
}

/// How many times [`HEARD_SECS`] of the show have gone by; `None` where nothing is heard.
fn heard_of(listening: &Listening) -> Option<u64> {
    let hears = listening.live().is_some() || listening.plays_songs();
    hears.then(|| (listening.at_secs() / HEARD_SECS) as u64)
}

/// The copy of this window's show, and those that were found.
#[derive(Default)]
pub struct Keepsake {
    /// `None` until one was begun, and while it is written; an error once there is to be none any more.
    copy: Option<Result<RecoveryCopy, ()>>,
    /// The write in progress and what it keeps; below, what the copy has.
    writing: Option<(Receiver<Written>, Kept)>,
    kept: Option<Kept>,
    last_secs: f64,
    /// How long the last copy took to write.
    took_secs: f64,
    /// Why the last copy could not be written: reported once, and tried again.
    failure: Option<String>,
    /// Copies that earlier windows left, once they were looked for.
    found: Option<Vec<PathBuf>>,
    /// One that is being opened in this window; it stays where that fails.
    opening: Option<PathBuf>,
    /// One that is open in this window again; it goes once our own copy is on the disk.
    adopted: Option<PathBuf>,
}

impl Keepsake {
    /// Takes in the finished write, or `waits` for it; returns a new error, if there is one.
    fn settle(&mut self, waits: bool) -> Option<String> {
        let (written, kept) = self.writing.as_ref()?;
        let written =
            if waits { written.recv().map_err(|_| TryRecvError::Disconnected) } else { written.try_recv() };
        let (copy, failure, took_secs) = match written {
            Err(TryRecvError::Empty) => return None,
            Err(TryRecvError::Disconnected) => (Some(Err(())), Some("its thread ended".to_owned()), 0.0),
            Ok(Written { copy, failure, took_secs }) => (copy.map(Ok), failure, took_secs),
        };
        self.took_secs = took_secs;
        if failure.is_none() {
            self.kept = Some(kept.clone());
            self.release_adopted();
        }
        (self.copy, self.writing) = (copy, None);
        self.news(failure)
    }

    /// Remembers how the last copy ended; returns a failure that was not reported yet.
    fn news(&mut self, failure: Option<String>) -> Option<String> {
        let is_news = failure.is_some() && failure != self.failure;
        self.failure.clone_from(&failure);
        failure.filter(|_| is_news)
    }

    /// Discards the copy that is open again: what it holds is safe elsewhere, or was given up.
    fn release_adopted(&mut self) {
        self.adopted.take().iter().for_each(|old| RecoveryCopy::discard(old));
    }

    /// Writes `show`, of which it then has `kept`, to a copy in `folder` on a thread, which `spawn` starts; returns a new
    /// error, if there is one.
    fn write(
        &mut self,
        show: Show,
        kept: Kept,
        folder: &Path,
        spawn: impl FnOnce(Work) -> std::io::Result<()>,
    ) -> Option<String> {
        if self.keeps_no_more() {
            return None;
        }
        let copy = self.copy.take().and_then(Result::ok);
        // A thread that cannot start would take the copy with it.
        let (give, given) = channel::<Option<RecoveryCopy>>();
        let (done, written) = channel();
        let folder = folder.to_owned();
        let work = move || {
            let Ok(mut copy) = given.recv() else { return };
            let began = Instant::now();
            let saved = keep(&mut copy, &folder, &show);
            let took_secs = began.elapsed().as_secs_f64();
            // If nobody waits any longer, the window is gone, and the copy stays.
            let _ = done.send(Written { copy, failure: saved.err(), took_secs });
        };
        match spawn(Box::new(work)) {
            Ok(()) => {
                // A thread that ended already is noticed when its result is asked for.
                let _ = give.send(copy);
                self.writing = Some((written, kept));
                None
            }
            Err(why) => {
                self.copy = copy.map(Ok);
                self.news(Some(why.to_string()))
            }
        }
    }

    /// Whether there is to be no copy any more.
    fn keeps_no_more(&self) -> bool {
        matches!(self.copy, Some(Err(())))
    }
}

/// Writes `show` to `copy`, which is begun in `folder` where there is none yet.
fn keep(copy: &mut Option<RecoveryCopy>, folder: &Path, show: &Show) -> Result<(), String> {
    let copy = match copy {
        Some(copy) => copy,
        none => {
            let begun = RecoveryCopy::start(folder, NAMES.0, NAMES.1, std::process::id());
            none.insert(begun.map_err(|why| format!("{}: {why}", folder.display()))?)
        }
    };
    let text = show.to_text().map_err(|why| why.to_string())?;
    copy.keep(text.as_bytes()).map_err(|why| why.to_string())
}

/// What a thread does that writes a copy.
type Work = Box<dyn FnOnce() + Send>;

/// Starts a thread that writes a copy.
fn in_background(work: Work) -> std::io::Result<()> {
    std::thread::Builder::new().name("show copy".into()).spawn(work).map(drop)
}

impl MusicRoom {
    /// Keeps a copy of what of the show no file has, and drops it once all is saved.
    pub(super) fn keep_show(&mut self, at_once: bool, shared: &mut Shared<'_>) {
        let keepsake = &mut self.keepsake;
        if let Some(why) = keepsake.settle(at_once) {
            shared.notices.warn(format!("No copy of the show could be kept: {why}"));
        }
        let (Some(concert), Some(listening)) = (&self.concert, &self.listening) else { return };
        let Some(folder) = &shared.folders.recovery else { return };
        let now_secs = shared.ctx.input(|input| input.time);
        let interval_secs = interval_secs(keepsake.took_secs, concert.instrument().log().len());
        let wait_secs = keepsake.last_secs + interval_secs - now_secs;
        if keepsake.writing.is_some() || !at_once && wait_secs > 0.0 {
            // In another room nothing else may bring the frame that keeps the rest.
            if self.pass != shared.ctx.cumulative_pass_nr() && concert.has_changed() {
                shared.ctx.request_repaint_after(Duration::from_secs_f64(wait_secs.max(0.0) + 0.05));
            }
            return;
        }
        keepsake.last_secs = now_secs;
        if !concert.has_changed() {
            keepsake.release_adopted();
            if keepsake.kept.is_some()
                && let Some(Ok(copy)) = &keepsake.copy
            {
                copy.clear();
                keepsake.kept = None;
            }
            return;
        }
        let now = Kept::of(concert, listening, &self.body, shared.settings.music.looks());
        // The last copy of all has the last moment, too.
        if !at_once && keepsake.kept.as_ref() == Some(&now) {
            return;
        }
        // Where no copy is kept, the show need not be put together, either.
        if !keepsake.keeps_no_more()
            && let Some(show) = self.the_copy(shared)
            && let Some(why) = self.keepsake.write(show, now, folder, in_background)
        {
            shared.notices.warn(format!("No copy of the show could be kept: {why}"));
        }
    }

    /// The program must end: unsaved work is written before that, and stays.
    pub(super) fn leave_show(&mut self, shared: &mut Shared<'_>) {
        self.keep_show(true, shared);
        // It is too late to tell anybody what went wrong. Where no copy could be written, the recovered one stays.
        let _ = self.keepsake.settle(true);
        self.keepsake.adopted = None;
        self.keepsake.copy = Some(Err(()));
    }

    /// The window closes, and all that matters is saved or given up.
    pub(super) fn drop_show(&mut self) {
        let _ = self.keepsake.settle(true);
        self.keepsake.release_adopted();
        if let Some(Ok(copy)) = self.keepsake.copy.take() {
            copy.finish();
        }
    }

    /// Offers shows that a crash left behind; true if one is to be opened.
    pub(super) fn offer_show(&mut self, shared: &mut Shared<'_>) -> bool {
        let folder = &shared.folders.recovery;
        let left = || folder.as_ref().map_or_else(Vec::new, |folder| found_in(folder));
        let found = self.keepsake.found.get_or_insert_with(left);
        let Some(newest) = found.last().cloned() else { return false };
        let mut answer = None;
        let ((), dismissed) = theme::modal(&shared.ctx, "The last show did not end well", 460.0, |ui| {
            let weak = theme::palette(ui).weak;
            let what = "What was bred or changed is still there. Recover it, or throw it away.";
            ui.label(RichText::new(what).color(weak));
            if let Some(age) = changed_ago(changed(&newest)) {
                ui.label(RichText::new(theme::capitalized(&age)).color(weak));
            }
            ui.add_space(theme::GAP);
            ui.horizontal(|ui| {
                if theme::primary_button(ui, "Recover").author_id("recover-show").clicked() {
                    answer = Some(true);
                }
                if ui.button("Throw away").author_id("discard-show").clicked() {
                    answer = Some(false);
                }
                if ui.button("Ask again next time").clicked() {
                    found.clear();
                }
            });
        });
        if dismissed {
            found.clear();
        }
        match answer {
            None => false,
            Some(wanted) => {
                found.pop();
                if wanted {
                    // The others are asked about the next time: one show is played at a time.
                    found.clear();
                    self.keepsake.opening = Some(newest.clone());
                    self.waiting.push(newest);
                } else {
                    RecoveryCopy::discard(&newest);
                }
                wanted
            }
        }
    }
}

impl Keepsake {
    /// Whether the file at `path` is a copy that is being recovered.
    pub fn is_opening(&self, path: &Path) -> bool {
        self.opening.as_deref() == Some(path)
    }

    /// The show at `path` is open now; whether that is a copy which is recovered: a show that no file of the user has.
    pub fn opened(&mut self, path: &Path) -> bool {
        let recovered = self.opening.take_if(|opening| *opening == path);
        let is_recovered = recovered.is_some();
        self.adopted = recovered.or(self.adopted.take());
        is_recovered
    }
}

/// The copies in `folder`, the newest last.
fn found_in(folder: &Path) -> Vec<PathBuf> {
    let mut found = RecoveryCopy::left_behind(folder, NAMES.0, NAMES.1);
    found.sort_by_key(|path| changed(path));
    found
}

fn changed(path: &Path) -> Option<SystemTime> {
    std::fs::metadata(path).and_then(|about| about.modified()).ok()
}

#[cfg(test)]
mod crash_tests;

#[cfg(test)]
mod tests {
    use super::*;
    use chladni_music::Parameters;

    #[test]
    fn copies_of_any_date_are_found_the_newest_last() {
        let folder = tempfile::tempdir().unwrap();
        let year = Duration::from_secs(365 * 86_400);
        let now = SystemTime::now();
        let dates = [now + year, SystemTime::UNIX_EPOCH, now];
        for (id, written) in dates.into_iter().enumerate() {
            let path = folder.path().join(format!("{}-{id}.{}", NAMES.0, NAMES.1));
            std::fs::write(&path, "seed = 5\n").unwrap();
            std::fs::File::options().write(true).open(&path).unwrap().set_modified(written).unwrap();
        }
        let order = [1, 2, 0].map(|id| folder.path().join(format!("{}-{id}.{}", NAMES.0, NAMES.1)));
        assert_eq!(found_in(folder.path()), order);
    }

    #[test]
    fn a_folder_that_cannot_be_is_said_once_and_tried_again() {
        let home = tempfile::tempdir().unwrap();
        let folder = home.path().join("recovery");
        let show = || Show::from_text("format_version = 1\nseed = 5\nsize = 6\n").unwrap();
        std::fs::write(&folder, "in its place").unwrap();
        let mut keepsake = Keepsake::default();
        assert_eq!(keepsake.write(show(), Kept::default(), &folder, in_background), None);
        let said = keepsake.settle(true).unwrap();
        assert!(said.contains(folder.to_str().unwrap()), "{said}");
        assert_eq!(keepsake.write(show(), Kept::default(), &folder, in_background), None);
        assert_eq!(keepsake.settle(true), None, "said once");
        assert!(keepsake.copy.is_none() && keepsake.kept.is_none());
        std::fs::remove_file(&folder).unwrap();
        assert_eq!(keepsake.write(show(), Kept::default(), &folder, in_background), None);
        assert!(keepsake.settle(true).is_none() && keepsake.kept.is_some());
        drop(keepsake);
        assert!(Show::from_text(&std::fs::read_to_string(left(&folder)).unwrap()).is_ok());
    }

    #[test]
    fn the_window_waits_for_no_folder() {
        let home = tempfile::tempdir().unwrap();
        let folder = home.path().join("recovery");
        let show = Show::from_text("format_version = 1\nseed = 5\nsize = 6\n").unwrap();
        let (mut keepsake, mut ordered) = (Keepsake::default(), None::<Work>);
        let later = |work: Work| {
            ordered = Some(work);
            Ok(())
        };
        assert_eq!(keepsake.write(show, Kept::default(), &folder, later), None);
        assert!(!folder.exists() && keepsake.settle(false).is_none());
        ordered.unwrap()();
        assert!(keepsake.settle(true).is_none() && keepsake.kept.is_some());
        assert!(matches!(&keepsake.copy, Some(Ok(copy)) if copy.path().starts_with(&folder)));
    }

    /// The copy that was left, once no program that another test starts just now holds its lock, too.
    pub(super) fn left(folder: &Path) -> PathBuf {
        let began = Instant::now();
        loop {
            if let Some(copy) = found_in(folder).pop() {
                return copy;
            }
            assert!(began.elapsed() < chladni_testdata::HANGS);
            std::thread::sleep(Duration::from_millis(2));
        }
    }

    #[test]
    fn nothing_is_begun_once_the_window_is_leaving() {
        let home = tempfile::tempdir().unwrap();
        let mut keepsake = Keepsake { copy: Some(Err(())), ..Keepsake::default() };
        let show = Show::from_text("format_version = 1\nseed = 5\nsize = 6\n").unwrap();
        assert_eq!(keepsake.write(show, Kept::default(), home.path(), in_background), None);
        assert!(matches!(keepsake.copy, Some(Err(()))) && keepsake.writing.is_none());
    }

    #[test]
    fn a_copy_whose_thread_cannot_start_is_tried_again() {
        let folder = tempfile::tempdir().unwrap();
        let copy = RecoveryCopy::start(folder.path(), NAMES.0, NAMES.1, std::process::id()).unwrap();
        let path = copy.path().to_owned();
        let mut keepsake = Keepsake { copy: Some(Ok(copy)), ..Keepsake::default() };
        let show = || Show::from_text("format_version = 1\nseed = 5\nsize = 6\n").unwrap();
        let no_thread = |_: Work| Err(std::io::Error::other("no more threads"));
        let mut refused = || keepsake.write(show(), Kept::default(), folder.path(), no_thread);
        assert_eq!([refused(), refused()], [Some("no more threads".to_owned()), None], "said once");
        assert!(matches!(keepsake.copy, Some(Ok(_))) && keepsake.writing.is_none());
        assert_eq!(keepsake.write(show(), Kept::default(), folder.path(), in_background), None);
        assert!(keepsake.settle(true).is_none() && keepsake.kept.is_some() && path.exists());
    }

    #[test]
    fn copies_that_take_long_come_less_often() {
        assert!(interval_secs(0.01, 100) < 1.01 * INTERVAL_SECS);
        assert!(interval_secs(0.2, 0) > 3.9 && interval_secs(0.0, 20_000) > 2.9);
        // But none so seldom that more than five seconds could be lost.
        for took_secs in [0.0, 0.2, 0.5, 1.0, 2.5] {
            let most_secs = [0, 20_000, 200_000].map(|actions| took_secs + interval_secs(took_secs, actions));
            assert!(most_secs.iter().all(|secs| *secs < 5.0), "{most_secs:?}");
        }
        let folder = tempfile::tempdir().unwrap();
        let copy = RecoveryCopy::start(folder.path(), NAMES.0, NAMES.1, std::process::id()).unwrap();
        let (done, written) = channel();
        let mut keepsake = Keepsake { writing: Some((written, Kept::default())), ..Keepsake::default() };
        assert!(done.send(Written { copy: Some(copy), failure: None, took_secs: 1.5 }).is_ok());
        assert!(keepsake.settle(true).is_none() && keepsake.took_secs > 1.0);
    }

    #[test]
    fn a_show_in_which_nothing_is_done_while_sound_goes_on_is_copied_now_and_then() {
        let mut listening = Listening::start(&egui::Context::default(), 1.0, None).unwrap();
        let (capture, _feed) = chladni_sound::Capture::fed(48_000).unwrap();
        listening.listen_on(capture, "Built-in microphone".into());
        let mut heard = |at_secs: f64| {
            listening.hear(at_secs, &Parameters::default(), |_, _| Ok(())).unwrap();
            heard_of(&listening)
        };
        let begun = heard(1.0);
        assert!(begun.is_some() && heard(2.0) == begun);
        assert_ne!(heard(2.0 + HEARD_SECS), begun);
    }

    #[test]
    fn a_recovered_show_that_was_saved_or_given_up_is_not_offered_again() {
        let folder = tempfile::tempdir().unwrap();
        let left = folder.path().join("left.toml");
        std::fs::write(&left, "seed = 5\n").unwrap();
        let keepsake = Keepsake { adopted: Some(left.clone()), ..Keepsake::default() };
        let mut room = MusicRoom { keepsake, ..MusicRoom::default() };
        room.drop_show();
        assert!(!left.exists());
    }

    #[test]
    fn only_a_copy_that_was_opened_is_adopted() {
        let mut keepsake = Keepsake { opening: Some("left.toml".into()), ..Keepsake::default() };
        assert!(!keepsake.opened(Path::new("other.toml")) && keepsake.adopted.is_none());
        assert!(keepsake.opened(Path::new("left.toml")));
        assert_eq!(keepsake.adopted.as_deref(), Some(Path::new("left.toml")));
        assert!(!keepsake.opened(Path::new("left.toml")), "opened again by hand");
    }
}
