//! Work that is always about the newest state of something, on another thread.

use std::time::{Duration, Instant};

use egui::Context;

use super::job::Job;
use crate::work::Error;

/// Work that takes longer is slow.
const LONG: Duration = Duration::from_millis(300);

/// One job at a time, always on the newest state: states that come and go while one runs are skipped.
pub struct Newest<T> {
    running: Option<Running<T>>,
    /// Something has changed since the last job began.
    due: bool,
}

struct Running<T> {
    job: Job<T>,
    began: Instant,
    /// A frame has waited this long for it.
    waited: Duration,
    outcome: Option<Result<T, Error>>,
}

impl<T> Default for Newest<T> {
    fn default() -> Self {
        Self { running: None, due: false }
    }
}

impl<T: Send + 'static> Newest<T> {
    /// Something has changed.
    pub fn outdate(&mut self) {
        self.due = true;
    }

    /// Drops the running job: its result must not be taken in.
    pub fn give_up(&mut self) {
        (self.running, self.due) = (None, true);
    }

    /// Whether a newer result than the last one is to come.
    pub fn is_behind(&self) -> bool {
        self.due || self.running.is_some()
    }

    /// Whether a job may begin: something has changed, and none runs.
    pub fn is_due(&self) -> bool {
        self.due && self.running.is_none()
    }

    /// Begins a job on the state as it is now.
    pub fn begin(&mut self, ctx: &Context, work: impl FnOnce() -> Result<T, Error> + Send + 'static) {
        let job = Job::start("Evaluating", ctx, move |_| work());
        self.running = Some(Running { job, began: Instant::now(), waited: Duration::ZERO, outcome: None });
        self.due = false;
    }

    /// Waits for the running job, all frames together no longer than `patience`.
    pub fn wait(&mut self, patience: Duration) {
        let Some(running) = self.running.as_mut().filter(|running| running.outcome.is_none()) else { return };
        running.outcome = running.job.ended_within(patience.saturating_sub(running.waited));
        running.waited = running.waited.max(patience);
    }

    /// The result, returned once; `None` while there is no new one.
    pub fn ended(&mut self) -> Option<Result<T, Error>> {
        self.wait(Duration::ZERO);
        let outcome = self.running.as_mut()?.outcome.take()?;
        self.running = None;
        Some(outcome)
    }

    /// How long until the running job is slow, zero where it is already; `None` where none runs.
    pub fn slow_in(&self) -> Option<Duration> {
        Some(LONG.saturating_sub(self.running.as_ref()?.began.elapsed()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::mpsc::channel;

    #[test]
    fn slow_work_leaves_the_caller_free_and_only_the_newest_state_follows_it() {
        let (ctx, mut newest) = (Context::default(), Newest::default());
        let (begun, begins) = channel();
        let (go, gate) = channel::<()>();
        let begin = |newest: &mut Newest<u32>, state: u32, gate: Option<std::sync::mpsc::Receiver<()>>| {
            if !newest.is_due() {
                return;
            }
            let begun = begun.clone();
            newest.begin(&ctx, move || {
                begun.send(state).unwrap();
                gate.into_iter().for_each(|gate| gate.recv().unwrap());
                Ok(state)
            });
        };
        assert!(!newest.is_behind());
        newest.outdate();
        begin(&mut newest, 0, Some(gate));
        // The first is held at its gate: each of these returns all the same.
        for state in 1..=100 {
            newest.outdate();
            begin(&mut newest, state, None);
            newest.wait(Duration::ZERO);
            assert!(newest.ended().is_none() && newest.is_behind());
        }
        go.send(()).unwrap();
        newest.wait(Duration::MAX);
        assert!(matches!(newest.ended(), Some(Ok(0))) && newest.is_behind());
        begin(&mut newest, 100, None);
        newest.wait(Duration::MAX);
        assert!(matches!(newest.ended(), Some(Ok(100))) && !newest.is_behind());
        assert!(newest.ended().is_none() && newest.slow_in().is_none());
        assert_eq!(begins.try_iter().collect::<Vec<_>>(), [0, 100]);
    }

    #[test]
    fn what_was_given_up_is_never_taken_in() {
        let (ctx, mut newest) = (Context::default(), Newest::default());
        newest.begin(&ctx, || Ok("old"));
        newest.wait(Duration::MAX);
        newest.give_up();
        assert!(newest.ended().is_none() && newest.is_due());
        newest.begin(&ctx, || Ok("new"));
        newest.wait(Duration::MAX);
        assert!(matches!(newest.ended(), Some(Ok("new"))));
    }

    #[test]
    fn work_that_breaks_off_is_an_error_and_the_next_one_runs() {
        let (ctx, mut newest) = (Context::default(), Newest::default());
        newest.begin(&ctx, || panic!("a bug, on purpose"));
        newest.wait(Duration::MAX);
        assert!(matches!(newest.ended(), Some(Err(Error::BrokeOff(_)))));
        newest.begin(&ctx, || Ok(1));
        newest.wait(Duration::MAX);
        assert!(matches!(newest.ended(), Some(Ok(1))));
    }
}
