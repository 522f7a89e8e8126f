//! Long work in the background: it reports progress, can be cancelled, and never blocks a frame.

use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::thread::Builder;
use std::time::Duration;

use chladni_task::{Progress, Task};

use crate::work::Error;

/// How long a closing window waits for work that it cancels.
const PATIENCE: Duration = Duration::from_secs(5);

/// One piece of work on its own thread.
#[derive(Debug)]
pub struct Job<T> {
    label: String,
    task: Task,
    result: Receiver<Result<T, Error>>,
}

impl<T: Send + 'static> Job<T> {
    /// Starts `work` and repaints `ctx` when it is done. Where no thread can begin, that is its result.
    pub fn start(
        label: impl Into<String>,
        ctx: &egui::Context,
        work: impl FnOnce(&Task) -> Result<T, Error> + Send + 'static,
    ) -> Self {
        Self::on(Builder::new().name("job".into()), label, ctx, work)
    }

    fn on(
        thread: Builder,
        label: impl Into<String>,
        ctx: &egui::Context,
        work: impl FnOnce(&Task) -> Result<T, Error> + Send + 'static,
    ) -> Self {
        let (task, (sender, result)) = (Task::new(), channel());
        let (worker, refused, repaint) = (task.clone(), sender.clone(), ctx.clone());
        let begun = thread.spawn(move || {
            // Dropped from right to left, also where the work breaks off: a frame that is woken finds it ended.
            let (_repaint, sender) = (Repaint(repaint), sender);
            // If the window has dropped the job, nobody receives the result.
            let _ = sender.send(work(&worker));
        });
        if let Err(why) = begun {
            let _ = refused.send(Err(Error::other(format!("no thread can begin: {why}"))));
            ctx.request_repaint();
        }
        Self { label: label.into(), task, result }
    }

    /// Its result, returned once; `None` while it is running. [`Error::BrokeOff`] where the thread ended
    /// without a result.
    pub fn ended(&self) -> Option<Result<T, Error>> {
        self.ended_within(Duration::ZERO)
    }

    /// The same, waiting no longer than `patience` for it.
    pub fn ended_within(&self, patience: Duration) -> Option<Result<T, Error>> {
        match self.result.recv_timeout(patience) {
            Ok(result) => Some(result),
            Err(RecvTimeoutError::Timeout) => None,
            Err(RecvTimeoutError::Disconnected) => Some(Err(Error::BrokeOff(self.label.clone()))),
        }
    }
}

impl<T> Job<T> {
    /// The work's name in the window.
    pub fn label(&self) -> &str {
        &self.label
    }

    /// How far it is.
    pub fn progress(&self) -> Progress {
        self.task.progress()
    }

    /// Cancels it, and waits a moment until it has ended.
    pub fn stop(self) {
        self.cancel();
        // A result is of no use any more; who has ended without one has ended, too.
        let _ = self.result.recv_timeout(PATIENCE);
    }

    /// Asks it to stop; its result then says that it was cancelled.
    pub fn cancel(&self) {
        self.task.cancel();
    }
}

impl<T> Drop for Job<T> {
    fn drop(&mut self) {
        self.task.cancel();
    }
}

/// Repaints when it is dropped.
struct Repaint(egui::Context);

impl Drop for Repaint {
    fn drop(&mut self) {
        self.0.request_repaint();
    }
}

/// Draws progress and a cancel button. Repaints by itself while shown.
pub fn show_progress<T>(ui: &mut egui::Ui, job: &Job<T>) {
    let progress = job.progress();
    // The button first, so that a long label cannot push it away.
    let row = egui::vec2(ui.available_width(), ui.spacing().interact_size.y);
    ui.allocate_ui_with_layout(row, egui::Layout::right_to_left(egui::Align::Center), |ui| {
        if ui.button("Cancel").clicked() {
            job.cancel();
        }
        ui.with_layout(egui::Layout::left_to_right(egui::Align::Center), |ui| {
            ui.spinner();
            ui.add(egui::Label::new(job.label()).truncate());
        });
    });
    let share = progress.fraction().unwrap_or(0.0) as f32;
    let stage = egui::RichText::new(progress.stage).small();
    ui.add(egui::ProgressBar::new(share).text(stage).desired_height(18.0));
    ui.ctx().request_repaint_after(Duration::from_millis(100));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn work_for_which_no_thread_can_begin_ends_with_the_reason() {
        // No machine has this much memory for a stack.
        let thread = Builder::new().stack_size(1 << 62);
        let job = Job::<()>::on(thread, "Counting", &egui::Context::default(), |_| Ok(()));
        assert!(matches!(job.ended(), Some(Err(Error::Other(_)))));
    }

    #[test]
    fn the_window_is_repainted_for_work_that_breaks_off() {
        let ctx = egui::Context::default();
        let (repaint, repaints) = channel();
        ctx.set_request_repaint_callback(move |_| {
            let _ = repaint.send(());
        });
        let job = Job::<()>::start("Counting", &ctx, |_| panic!("a bug, on purpose"));
        repaints.recv_timeout(chladni_testdata::HANGS).unwrap();
        assert!(matches!(job.ended(), Some(Err(Error::BrokeOff(_)))));
    }
}
