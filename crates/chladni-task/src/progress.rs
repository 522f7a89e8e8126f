//! The handle that long work reports to and is cancelled through.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

/// The work was cancelled through its [`Task`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("cancelled")]
pub struct Cancelled;

/// The current stage of a [`Task`], and how far it is.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Progress {
    /// Name of the current stage; empty before the first one.
    pub stage: String,
    /// Steps done in this stage.
    pub done: u64,
    /// Steps this stage expects; 0 where the number is not known.
    pub total: u64,
}

impl Progress {
    /// Share of the stage that is done, in [0, 1]; `None` where the total is not known.
    pub fn fraction(&self) -> Option<f64> {
        (self.total > 0).then(|| (self.done as f64 / self.total as f64).min(1.0))
    }
}

/// Progress and cancellation of one piece of long work. Clones share one state, so that a
/// window keeps one while a worker thread holds another.
#[derive(Clone, Debug, Default)]
pub struct Task {
    shared: Arc<Shared>,
}

#[derive(Debug, Default)]
struct Shared {
    cancelled: AtomicBool,
    done: AtomicU64,
    total: AtomicU64,
    stage: Mutex<String>,
    listener: OnceLock<fn(&Progress)>,
}

impl Task {
    /// A task that is not cancelled.
    pub fn new() -> Self {
        Self::default()
    }

    /// Begins a stage of `total` steps (0 where the number is not known) and resets the count.
    pub fn stage(&self, name: &str, total: u64) -> Stage<'_> {
        *self.shared.stage.lock().unwrap_or_else(PoisonError::into_inner) = name.to_owned();
        self.shared.done.store(0, Ordering::Relaxed);
        self.shared.total.store(total, Ordering::Relaxed);
        self.shared.tell(|| self.progress());
        Stage { task: self }
    }

    /// Calls `listener` from now on at every step, on the thread that does the work. This is for programs
    /// in which no other thread can poll [`progress`](Self::progress), such as the worker of a web page. A
    /// task takes one listener: later calls have no effect.
    pub fn heard_by(&self, listener: fn(&Progress)) {
        let _ = self.shared.listener.set(listener);
    }

    /// Asks the work to stop at its next [`check`](Self::check).
    pub fn cancel(&self) {
        self.shared.cancelled.store(true, Ordering::Relaxed);
    }

    /// Whether [`cancel`](Self::cancel) was called.
    pub fn is_cancelled(&self) -> bool {
        self.shared.cancelled.load(Ordering::Relaxed)
    }

    /// `Err(Cancelled)` once the task was cancelled; call it between steps of long work.
    ///
    /// # Errors
    /// [`Cancelled`], where [`cancel`](Self::cancel) was called.
    pub fn check(&self) -> Result<(), Cancelled> {
        if self.is_cancelled() { Err(Cancelled) } else { Ok(()) }
    }

    /// A snapshot of the progress, for example for a progress bar.
    pub fn progress(&self) -> Progress {
        Progress {
            stage: self.shared.stage.lock().unwrap_or_else(PoisonError::into_inner).clone(),
            done: self.shared.done.load(Ordering::Relaxed),
            total: self.shared.total.load(Ordering::Relaxed),
        }
    }
}

impl Shared {
    fn tell(&self, progress: impl FnOnce() -> Progress) {
        if let Some(listener) = self.listener.get() {
            listener(&progress());
        }
    }
}

/// The current stage of a [`Task`]. Any thread may advance it.
#[derive(Debug)]
pub struct Stage<'a> {
    task: &'a Task,
}

impl Stage<'_> {
    /// Counts `steps` more steps as done.
    pub fn advance(&self, steps: u64) {
        self.task.shared.done.fetch_add(steps, Ordering::Relaxed);
        self.task.shared.tell(|| self.task.progress());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clones_share_cancellation_and_progress() {
        let task = Task::new();
        let worker = task.clone();
        let stage = worker.stage("solving", 4);
        stage.advance(3);
        assert_eq!(task.progress(), Progress { stage: "solving".into(), done: 3, total: 4 });
        assert_eq!(task.progress().fraction(), Some(0.75));
        task.cancel();
        assert_eq!(worker.check(), Err(Cancelled));
    }

    #[test]
    fn a_listener_hears_every_step() {
        static HEARD: Mutex<Vec<(String, u64)>> = Mutex::new(Vec::new());
        let task = Task::new();
        task.heard_by(|now| HEARD.lock().unwrap().push((now.stage.clone(), now.done)));
        let stage = task.stage("solving", 3);
        stage.advance(1);
        stage.advance(2);
        let expected = [0, 1, 3].map(|done| ("solving".to_owned(), done));
        assert_eq!(*HEARD.lock().unwrap(), expected);
    }
}
