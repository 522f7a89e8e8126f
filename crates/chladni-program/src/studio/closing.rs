//! Leaving the window: unsaved work is asked about first.

use std::time::Duration;

use chladni_task::Task;

use super::Studio;
use super::unsaved::{Answer, Question, ask_to_wait};

/// Time between two looks whether the program is asked to end.
const LOOK: Duration = Duration::from_millis(100);

/// The state of closing the window.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Closing {
    /// Staying.
    #[default]
    No,
    /// Asked about unsaved work.
    Asked {
        /// How many errors there were before.
        errors: usize,
    },
    /// All is saved; it closes once the work in the background is done.
    Waiting {
        /// How many errors there were before it was asked to close.
        errors: usize,
    },
    /// Decided; the window is about to go.
    Yes,
}

/// A window that nobody touches draws nothing: wakes it once `ends` is cancelled.
pub fn wake_to_end(ctx: &egui::Context, ends: Task) {
    let ctx = ctx.clone();
    let watch = move || {
        while !ends.is_cancelled() {
            std::thread::sleep(LOOK);
        }
        ctx.request_repaint();
    };
    // Without it, the window ends with the next thing that happens in it.
    let _ = std::thread::Builder::new().name("end".into()).spawn(watch);
}

impl Studio {
    /// Asks before unsaved work is lost.
    pub(super) fn handle_close(&mut self, ctx: &egui::Context) {
        let asked = ctx.input(|input| input.viewport().close_requested());
        if !asked && matches!(self.closing, Closing::No | Closing::Yes) {
            return;
        }
        let being_made: Vec<String> =
            self.rooms.iter().filter_map(|room| room.being_made().map(str::to_owned)).collect();
        let mut unsaved: Vec<String> = self.rooms.iter().filter_map(|room| room.unsaved()).collect();
        let is_saved = unsaved.is_empty();
        unsaved.extend(being_made.iter().map(|label| format!("{label} is not finished.")));
        if asked && !unsaved.is_empty() && self.closing != Closing::Yes {
            ctx.send_viewport_cmd(egui::ViewportCommand::CancelClose);
            if self.closing == Closing::No {
                let errors = self.notices.errors();
                // There is nothing to be saved where only a film is still being made.
                self.closing = if is_saved { Closing::Waiting { errors } } else { Closing::Asked { errors } };
            }
        }
        match self.closing {
            Closing::No | Closing::Yes => {}
            // The work in the background ended meanwhile.
            Closing::Asked { errors } if unsaved.is_empty() => self.leave_unless_failed(ctx, errors),
            Closing::Asked { errors } => self.ask_to_save(ctx, &unsaved, errors),
            Closing::Waiting { errors } if unsaved.is_empty() => self.leave_unless_failed(ctx, errors),
            Closing::Waiting { errors } if being_made.is_empty() => {
                // A controller has changed something meanwhile.
                self.closing = Closing::Asked { errors };
                ctx.request_repaint();
            }
            Closing::Waiting { .. } => match ask_to_wait(ctx, &being_made) {
                None | Some(Answer::Save) => {}
                Some(Answer::Stay) => self.closing = Closing::No,
                Some(Answer::Discard) => self.leave(ctx),
            },
        }
    }

    /// Whether the window is being closed, or that is asked about.
    pub(super) fn is_closing(&self) -> bool {
        self.closing != Closing::No
    }

    fn ask_to_save(&mut self, ctx: &egui::Context, unsaved: &[String], errors: usize) {
        match Question::CLOSING.ask(ctx, unsaved) {
            None => {}
            Some(Answer::Stay) => self.closing = Closing::No,
            Some(Answer::Discard) => self.leave(ctx),
            Some(Answer::Save) => {
                let saved = (0..self.rooms.len()).all(|index| {
                    self.with_room(ctx, index, |room, shared| room.save_all(shared)).unwrap_or(true)
                });
                // Anything that could not be saved has shown an error; nothing is lost.
                self.closing = if saved { Closing::Waiting { errors } } else { Closing::No };
                ctx.request_repaint();
            }
        }
    }

    /// Closes without a question where the system asks the program to end: unsaved work is kept as after a crash, to be
    /// offered next time.
    pub(super) fn end_if_asked(&mut self, ctx: &egui::Context) {
        let asked = self.ends.as_ref().is_some_and(Task::is_cancelled);
        if asked && self.closing != Closing::Yes {
            for index in 0..self.rooms.len() {
                self.with_room(ctx, index, |room, shared| room.interrupt(shared));
            }
            self.leave(ctx);
        }
    }

    /// Leaves where there were no more `errors` since: those of the work that it waited for are to be read.
    fn leave_unless_failed(&mut self, ctx: &egui::Context, errors: usize) {
        if self.notices.errors() > errors {
            self.closing = Closing::No;
        } else {
            self.leave(ctx);
        }
    }

    fn leave(&mut self, ctx: &egui::Context) {
        self.closing = Closing::Yes;
        ctx.send_viewport_cmd(egui::ViewportCommand::Close);
    }
}
