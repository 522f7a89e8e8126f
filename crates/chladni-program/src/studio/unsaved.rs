//! The question what to do with work that no file has, before it would be lost.

use super::author_id::AuthorId;
use super::theme;

/// The user's answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Answer {
    /// Nothing is to happen.
    Stay,
    /// It is saved first.
    Save,
    /// It may be lost.
    Discard,
}

/// How the question is put: its title, and the words on the buttons that save and that do not.
#[derive(Clone, Copy, Debug)]
pub struct Question {
    title: &'static str,
    save: (&'static str, &'static str),
    discard: &'static str,
}

impl Question {
    /// Before the window closes.
    pub const CLOSING: Self = Self {
        title: "Save before closing?",
        save: ("Save and close", "save-and-close"),
        discard: "Close and lose changes",
    };
    /// Before something else is opened.
    pub const OPENING: Self =
        Self { title: "Save before opening another?", save: ("Save", "save-first"), discard: "Lose changes" };

    /// Before another gallery of dances begins.
    pub const BREEDING_ANEW: Self = Self {
        title: "Save before another gallery?",
        save: ("Save", "save-first"),
        discard: "Lose these dances",
    };

    /// Asks, in each frame until there is an answer; `lines` list the unsaved work.
    pub fn ask(self, ctx: &egui::Context, lines: &[String]) -> Option<Answer> {
        let mut answer = None;
        let ((), dismissed) = theme::modal(ctx, self.title, 420.0, |ui| {
            for line in lines {
                ui.label(line);
            }
            ui.add_space(theme::GAP_LARGE);
            ui.horizontal(|ui| {
                let (save, id) = self.save;
                if theme::primary_button(ui, save).author_id(id).clicked() {
                    answer = Some(Answer::Save);
                }
                if ui.button("Keep working").author_id("keep-working").clicked() {
                    answer = Some(Answer::Stay);
                }
                ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                    if ui.button(self.discard).author_id("lose-changes").clicked() {
                        answer = Some(Answer::Discard);
                    }
                });
            });
        });
        answer.or(dismissed.then_some(Answer::Stay))
    }
}

/// Asks, while a closing window waits for work that is `being_made`, whether to stay or to close at once.
pub fn ask_to_wait(ctx: &egui::Context, being_made: &[String]) -> Option<Answer> {
    let mut answer = None;
    let ((), dismissed) = theme::modal(ctx, "Closing when this is done", 420.0, |ui| {
        for label in being_made {
            ui.horizontal(|ui| {
                ui.spinner();
                ui.label(format!("{label} …"));
            });
        }
        ui.add_space(theme::GAP_LARGE);
        ui.horizontal(|ui| {
            if ui.button("Keep working").author_id("keep-working").clicked() {
                answer = Some(Answer::Stay);
            }
            ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                if ui.button("Stop it and close").author_id("stop-and-close").clicked() {
                    answer = Some(Answer::Discard);
                }
            });
        });
    });
    answer.or(dismissed.then_some(Answer::Stay))
}
