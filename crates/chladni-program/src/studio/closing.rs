//! Leaving the window: unsaved work is asked about first.

use super::author_id::AuthorId;
use super::{Studio, theme};

/// The state of closing the window.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Closing {
    /// Staying.
    #[default]
    No,
    /// Asked about unsaved work.
    Asked,
    /// Decided; the window is about to go.
    Yes,
}

/// The user's answer.
enum Answer {
    Stay,
    Save,
    Discard,
}

impl Studio {
    /// Asks before unsaved work is lost.
    pub(super) fn handle_close(&mut self, ctx: &egui::Context) {
        let unsaved: Vec<String> = self.rooms.iter().filter_map(|room| room.unsaved()).collect();
        if ctx.input(|input| input.viewport().close_requested())
            && !unsaved.is_empty()
            && self.closing != Closing::Yes
        {
            ctx.send_viewport_cmd(egui::ViewportCommand::CancelClose);
            self.closing = Closing::Asked;
        }
        if self.closing != Closing::Asked {
            return;
        }
        match ask(ctx, &unsaved) {
            None => {}
            Some(Answer::Stay) => self.closing = Closing::No,
            Some(Answer::Discard) => self.leave(ctx),
            Some(Answer::Save) => {
                let saved = (0..self.rooms.len()).all(|index| {
                    self.with_room(ctx, index, |room, shared| room.save_all(shared)).unwrap_or(true)
                });
                // Anything that could not be saved has shown an error; nothing is lost.
                if saved { self.leave(ctx) } else { self.closing = Closing::No }
            }
        }
    }

    fn leave(&mut self, ctx: &egui::Context) {
        self.closing = Closing::Yes;
        ctx.send_viewport_cmd(egui::ViewportCommand::Close);
    }
}

fn ask(ctx: &egui::Context, unsaved: &[String]) -> Option<Answer> {
    let mut answer = None;
    let ((), dismissed) = theme::modal(ctx, "Save before closing?", 420.0, |ui| {
        for line in unsaved {
            ui.label(line);
        }
        ui.add_space(theme::GAP_LARGE);
        ui.horizontal(|ui| {
            if theme::primary_button(ui, "Save and close").author_id("save-and-close").clicked() {
                answer = Some(Answer::Save);
            }
            if ui.button("Keep working").author_id("keep-working").clicked() {
                answer = Some(Answer::Stay);
            }
            ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                if ui.button("Close and lose changes").author_id("lose-changes").clicked() {
                    answer = Some(Answer::Discard);
                }
            });
        });
    });
    if dismissed {
        answer.get_or_insert(Answer::Stay);
    }
    answer
}
