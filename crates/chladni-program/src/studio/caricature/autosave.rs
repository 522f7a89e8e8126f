//! Keeps a recovery copy of the open project in the background, so that a crash loses only seconds of work.

use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::JoinHandle;
use std::time::Instant;

use chladni_caricature::{CaricatureError, History, Project, Recovered, Recovery};

use crate::studio::copying::{INTERVAL_SECS, WITHIN_SECS, pause_secs};
use crate::work::Error;

/// The recovery copy of this window. The disk is only touched on a thread of its own, which does all orders before it
/// ends; of copies that wait, the last alone is written.
pub struct Autosave {
    orders: Option<Sender<Order>>,
    reports: Receiver<Report>,
    thread: Option<JoinHandle<()>>,
    /// The least time between two copies, and the time within which a change is to be in one.
    between_secs: [f64; 2],
    /// How long the last copy took to write.
    took_secs: f64,
    /// The project in the copy; `None` where there is no copy.
    kept: Option<Project>,
    last_secs: f64,
    /// Why the last copy could not be written: it is tried again, and reported once.
    failure: Option<String>,
}

enum Order {
    Keep(Box<Project>, Option<PathBuf>),
    Clear,
    /// Our own copy now includes this recovered one.
    Discard(Box<Recovered>),
    Finish,
}

/// A copy that was written, or why not.
struct Report {
    /// The number of its order, counted from 0: those before it are done, too.
    kept: Result<usize, CaricatureError>,
    took_secs: f64,
}

impl Autosave {
    /// Copies go to `folder`. Where that cannot be written, [`tick`](Self::tick) says so, and it is tried again.
    pub fn start(folder: &Path) -> Result<Self, Error> {
        Self::every([INTERVAL_SECS, WITHIN_SECS], folder)
    }

    /// The same, with other times between two copies.
    fn every(between_secs: [f64; 2], folder: &Path) -> Result<Self, Error> {
        let folder = folder.to_owned();
        let ((orders, inbox), (report, reports)) = (channel(), channel());
        let thread = std::thread::Builder::new()
            .name("autosave".into())
            .spawn(move || work(&folder, &inbox, &report))
            .map_err(|error| Error::other(format!("no thread to keep copies on: {error}")))?;
        let last_secs = f64::NEG_INFINITY;
        let (orders, thread) = (Some(orders), Some(thread));
        let (took_secs, kept, failure) = (0.0, None, None);
        Ok(Self { orders, reports, thread, between_secs, took_secs, kept, last_secs, failure })
    }

    /// Keeps the project where it has unsaved changes that no copy holds yet, or drops the copy
    /// where all is saved. `path` is where it was saved; `now_secs` may start anywhere. Returns
    /// what went wrong since the last call.
    pub fn tick(&mut self, history: &History, path: Option<&Path>, now_secs: f64) -> Option<String> {
        let news = self.news();
        if !history.is_modified() {
            if self.kept.take().is_some() {
                self.order(Order::Clear);
            }
        } else if self.is_behind(history) && now_secs - self.last_secs >= self.interval_secs() {
            let project = history.project().clone();
            self.order(Order::Keep(Box::new(project.clone()), path.map(Path::to_owned)));
            (self.kept, self.last_secs) = (Some(project), now_secs);
        }
        news
    }

    /// The time between two copies.
    fn interval_secs(&self) -> f64 {
        pause_secs(self.took_secs, 0.0, self.between_secs)
    }

    /// A new error, if there is one.
    fn news(&mut self) -> Option<String> {
        let mut news = None;
        for report in self.reports.try_iter() {
            self.took_secs = report.took_secs;
            let failure = report.kept.err().map(|why| format!("No recovery copy could be kept: {why}"));
            if failure.is_some() && failure != self.failure {
                news.clone_from(&failure);
            }
            self.failure = failure;
        }
        news
    }

    /// Whether there are changes that no copy holds.
    fn is_behind(&self, history: &History) -> bool {
        let is_kept = self.failure.is_none() && self.kept.as_ref() == Some(history.project());
        history.is_modified() && !is_kept
    }

    /// Seconds until [`tick`](Self::tick) has something to keep; `None` where it has nothing.
    pub fn due_secs(&self, history: &History, now_secs: f64) -> Option<f64> {
        self.is_behind(history).then(|| (self.last_secs + self.interval_secs() - now_secs).max(0.0))
    }

    /// The next [`tick`](Self::tick) keeps all changes, however soon.
    pub fn hurry(&mut self) {
        self.last_secs = f64::NEG_INFINITY;
    }

    /// Another project was opened in its place.
    pub fn forget(&mut self) {
        self.kept = None;
        self.last_secs = f64::NEG_INFINITY;
        self.order(Order::Clear);
    }

    /// Drops a copy that is open in this window again, once our own copy is on the disk.
    pub fn adopt(&mut self, recovered: Recovered, history: &History, now_secs: f64) -> Option<String> {
        self.last_secs = f64::NEG_INFINITY;
        let error = self.tick(history, recovered.original.as_deref(), now_secs);
        self.order(Order::Discard(Box::new(recovered)));
        error
    }

    /// The window closes normally: nothing is left to recover.
    pub fn finish(self) {
        self.order(Order::Finish);
    }

    fn order(&self, order: Order) {
        if let Some(orders) = &self.orders {
            // If the thread has ended, it has reported why.
            let _ = orders.send(order);
        }
    }
}

impl Drop for Autosave {
    fn drop(&mut self) {
        self.orders = None;
        if let Some(thread) = self.thread.take() {
            // It ends by itself once its orders are done; a panic there adds no information.
            let _ = thread.join();
        }
    }
}

fn work(folder: &Path, inbox: &Receiver<Order>, reports: &Sender<Report>) {
    // Begun with the first copy, and tried again with the next one where that fails.
    let mut recovery: Option<Recovery> = None;
    // Copies that were ordered so far.
    let mut orders = 0_usize;
    let mut whole = true;
    while let Ok(first) = inbox.recv() {
        let mut waiting = std::iter::once(first).chain(inbox.try_iter()).peekable();
        while let Some(order) = waiting.next() {
            orders += usize::from(matches!(order, Order::Keep(..)));
            match order {
                // On a slow disk the next copy takes its place, or none is needed any longer.
                Order::Keep(..) if replaces_a_copy(waiting.peek()) => {}
                Order::Keep(project, path) => {
                    let began = Instant::now();
                    let kept = keep(&mut recovery, folder, &project, path.as_deref()).map(|()| orders - 1);
                    whole = kept.is_ok();
                    let took_secs = began.elapsed().as_secs_f64();
                    // The window may have gone meanwhile.
                    let _ = reports.send(Report { kept, took_secs });
                }
                Order::Clear => recovery.iter().for_each(Recovery::clear),
                Order::Discard(recovered) if whole => recovered.discard(),
                Order::Discard(_) => {}
                Order::Finish => return recovery.into_iter().for_each(Recovery::finish),
            }
        }
    }
}

fn keep(
    recovery: &mut Option<Recovery>,
    folder: &Path,
    project: &Project,
    path: Option<&Path>,
) -> Result<(), CaricatureError> {
    let recovery = match recovery {
        Some(recovery) => recovery,
        none => none.insert(Recovery::start(folder, std::process::id())?),
    };
    recovery.keep(project, path)
}

/// Whether the copy ordered before `next` need not be written. Where an older copy is discarded next, it must be written
/// first.
fn replaces_a_copy(next: Option<&Order>) -> bool {
    matches!(next, Some(Order::Keep(..) | Order::Clear | Order::Finish))
}

#[cfg(test)]
mod crash_tests;
#[cfg(all(test, target_os = "linux"))]
#[allow(clippy::unwrap_used, clippy::print_stdout, reason = "tests print, and fail by a panic")]
mod disk_tests;

#[cfg(test)]
mod tests {
    use chladni_caricature::{Action, Layer, ShapeSource, Template};
    use chladni_testdata::HANGS;

    use super::*;

    pub(super) fn changed() -> History {
        let mut history = History::new(Project::new(ShapeSource::Sample("head".into()), 8));
        let layer = Box::new(Layer::new("nose", Template::Ellipsoid));
        history.apply(&Action::Add { index: 0, layer }, None).unwrap();
        history
    }

    /// The copies that were left, once no program that another test starts just now holds their locks, too.
    pub(super) fn found(folder: &Path) -> Vec<Recovered> {
        let start = Instant::now();
        loop {
            let (found, unreadable) = Recovery::find(folder);
            assert!(unreadable.is_empty());
            if !found.is_empty() {
                return found;
            }
            assert!(start.elapsed() < HANGS);
            std::thread::sleep(std::time::Duration::from_millis(5));
        }
    }

    #[test]
    fn a_crash_leaves_the_work_and_an_orderly_end_leaves_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let mut history = changed();
        let mut autosave = Autosave::start(folder.path()).unwrap();
        let original = std::path::absolute("/a/b.chladni").unwrap();
        assert_eq!(autosave.tick(&history, Some(&original), 10.0), None);
        // Too soon for another copy: the first is what a crash leaves.
        history.apply(&Action::Remove(chladni_caricature::LayerId(1)), None).unwrap();
        autosave.tick(&history, None, 10.5);
        drop(autosave);
        let first = found(folder.path());
        assert_eq!((first.len(), first[0].project.layers().len()), (1, 1));
        assert_eq!(first[0].original.as_ref(), Some(&original));

        let mut next = Autosave::start(folder.path()).unwrap();
        let recovered = History::recovered(first[0].project.clone());
        next.adopt(first[0].clone(), &recovered, 0.0);
        drop(next);
        let second = found(folder.path());
        assert_eq!(second.len(), 1, "the adopted copy is gone, our own is there");

        let mut last = Autosave::start(folder.path()).unwrap();
        last.adopt(second[0].clone(), &recovered, 0.0);
        last.finish();
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }

    #[test]
    fn what_could_not_be_kept_is_said_once_and_kept_later() {
        let home = tempfile::tempdir().unwrap();
        let (folder, elsewhere) = (home.path().join("recovery"), home.path().join("elsewhere"));
        let mut history = changed();
        let mut autosave = Autosave::start(&folder).unwrap();
        let mut fails_and_recovers = |history: &History, free: &dyn Fn()| {
            let message = tick_until(&mut autosave, history, |message| message.is_some());
            assert!(message.unwrap().contains("recovery copy"));
            for _ in 0..5 {
                assert_eq!(tick_until(&mut autosave, history, |_| true), None, "reported already");
            }
            assert!(autosave.due_secs(history, 0.0).is_some());
            free();
            tick_until(&mut autosave, history, |_| folder.is_dir() && copies(&folder) > 0);
        };
        // Before the first copy the folder cannot be made.
        std::fs::write(&folder, "in its place").unwrap();
        fails_and_recovers(&history, &|| std::fs::remove_file(&folder).unwrap());
        // After it, the folder goes.
        std::fs::rename(&folder, &elsewhere).unwrap();
        history.apply(&Action::SetHarmonics(9), None).unwrap();
        fails_and_recovers(&history, &|| {
            std::fs::remove_dir_all(&elsewhere).unwrap();
            std::fs::create_dir(&folder).unwrap();
        });
        drop(autosave);
        assert_eq!(found(&folder)[0].project.harmonics, 9);
    }

    /// Lets the window's clock go on until a tick answers so: the disk works on a thread of its own. Each tick is due.
    pub(super) fn tick_until(
        autosave: &mut Autosave,
        history: &History,
        done: impl Fn(Option<&str>) -> bool,
    ) -> Option<String> {
        let start = Instant::now();
        let mut secs = autosave.last_secs.max(0.0);
        while start.elapsed() < HANGS {
            secs += 3.0 * INTERVAL_SECS;
            let message = autosave.tick(history, None, secs);
            if done(message.as_deref()) {
                return message;
            }
            std::thread::sleep(std::time::Duration::from_millis(1));
        }
        panic!("the disk never answered");
    }

    pub(super) fn copies(folder: &Path) -> usize {
        let names = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
        names.filter(|path| path.extension().is_some_and(|ending| ending == "chladni")).count()
    }

    #[test]
    fn no_copy_is_older_than_five_seconds() {
        let folder = tempfile::tempdir().unwrap();
        let mut autosave = Autosave::start(folder.path()).unwrap();
        let mut history = changed();
        let layer = history.project().layers()[0].0;
        // Since when there is a change that no copy holds.
        let (mut since_secs, mut chance) = (None, chladni_testdata::chance(7));
        for frame in 0..6000_u32 {
            let now = f64::from(frame) / 30.0;
            // Bursts of edits, and pauses.
            if chance() >> 60 < if frame % 400 < 200 { 9 } else { 1 } {
                let to = chladni_caricature::Property::Mu(now / 10.0);
                history.apply_live(&Action::Set { layer, to }, None).unwrap();
                since_secs = since_secs.or(Some(now));
            }
            autosave.tick(&history, None, now);
            since_secs = since_secs.filter(|_| autosave.is_behind(&history));
            // Longer where the disk is slow.
            let most_secs = autosave.interval_secs() + 3.0;
            assert!(since_secs.is_none_or(|since| now - since < most_secs), "at {now} s");
        }
    }

    #[test]
    fn of_copies_that_wait_for_a_slow_disk_the_last_alone_is_written() {
        let folder = tempfile::tempdir().unwrap();
        let ((orders, inbox), (report, reports)) = (channel(), channel());
        for harmonics in [8, 9, 10] {
            let project = Project::new(ShapeSource::Sample("head".into()), harmonics);
            orders.send(Order::Keep(Box::new(project), None)).unwrap();
        }
        drop(orders);
        work(folder.path(), &inbox, &report);
        let numbers: Vec<usize> = reports.try_iter().map(|report| report.kept.unwrap()).collect();
        assert_eq!(numbers, [2], "the two before it have no reports of their own");
        assert_eq!(found(folder.path())[0].project.harmonics, 10);
    }

    #[test]
    fn saving_drops_the_copy() {
        let folder = tempfile::tempdir().unwrap();
        let mut history = changed();
        let mut autosave = Autosave::start(folder.path()).unwrap();
        autosave.tick(&history, None, 0.0);
        history.mark_saved();
        autosave.tick(&history, None, 0.1);
        drop(autosave);
        assert!(Recovery::find(folder.path()).0.is_empty());
    }
}
