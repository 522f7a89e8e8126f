//! The stage's curtain: nothing but the dance, on the screen it was given.

use std::time::{Duration, Instant};

use egui::{Align2, Color32, FontId, Ui, ViewportCommand};

use super::concert::Concert;
use super::preferences::Screen;

/// How long pointer and hint stay after the pointer has moved.
const LINGER: Duration = Duration::from_secs(2);

/// What was done to the window for the stage, to be undone afterwards.
#[derive(Debug, Default)]
pub struct Curtain {
    open: bool,
    /// The window was made to fill a screen by the stage, not by the user.
    filled: bool,
    moved: Option<Instant>,
}

impl Curtain {
    /// Fills the screen when the stage opens and gives it back when it closes.
    pub fn follow(&mut self, ctx: &egui::Context, on_stage: bool, screen: Screen) {
        if on_stage == self.open {
            return;
        }
        self.open = on_stage;
        self.moved = None;
        if !on_stage {
            if std::mem::take(&mut self.filled) {
                ctx.send_viewport_cmd(ViewportCommand::Fullscreen(false));
            }
            return;
        }
        let full = ctx.input(|input| input.viewport().fullscreen.unwrap_or(false));
        match screen {
            Screen::Window => return,
            Screen::Full => ctx.send_viewport_cmd(ViewportCommand::Fullscreen(true)),
            Screen::Monitor(index) => ctx.send_viewport_cmd(ViewportCommand::SetMonitor(index)),
        }
        self.filled = !full;
    }

    /// Hides the pointer; where it moves, shows it for a moment with the keys that help.
    pub fn show(&mut self, ui: &mut Ui, concert: &Concert) {
        if ui.input(|input| input.pointer.is_moving()) {
            self.moved = Some(Instant::now());
        }
        if self.moved.is_none_or(|moved| moved.elapsed() > LINGER) {
            ui.ctx().set_cursor_icon(egui::CursorIcon::None);
            return;
        }
        let hint = match concert.instrument().favourites().len() {
            0 | 1 => "Escape leaves the stage · F11 full screen".to_owned(),
            count => format!("Escape leaves the stage · ← → another of {count} favourites · F11 full screen"),
        };
        let at = ui.max_rect().center_bottom() - egui::vec2(0.0, 24.0);
        let color = Color32::from_white_alpha(150);
        ui.painter().text(at, Align2::CENTER_BOTTOM, hint, FontId::proportional(14.0), color);
    }
}
