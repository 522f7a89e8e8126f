//! Leaving the window: unsaved work is asked about first.

use super::Studio;
use super::unsaved::{Answer, Question};

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
        match Question::CLOSING.ask(ctx, &unsaved) {
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
