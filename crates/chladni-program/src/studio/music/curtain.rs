//! The stage in the window: nothing but the dance, on the chosen screen.

use egui::{Color32, Event, Key, Ui, ViewportCommand};

use super::concert::Concert;
use super::legible::{self, Anchored};
use super::place::{Change, Place};
use super::preferences::Screen;
use super::projection::Projection;

/// How long pointer and hint stay after the pointer has moved, or a key was pressed that does nothing else.
const LINGER_SECS: f64 = 2.0;
/// The size of the hint's letters, in points.
const HINT: f32 = 14.0;

/// Changes made to the window for the stage, to be undone afterwards.
#[derive(Debug, Default)]
pub struct Curtain {
    open: bool,
    /// The window was made to fill a screen by the stage, not by the user.
    filled: bool,
    /// When the pointer last moved, or help was sought with a key, by the window's clock.
    sought_secs: Option<f64>,
    place: Place,
}

impl Curtain {
    /// Fills the screen when the stage opens and gives it back when it closes. Returns a message for the user.
    pub fn follow(
        &mut self,
        ctx: &egui::Context,
        on_stage: bool,
        screen: &Screen,
        names: impl FnOnce() -> Vec<String>,
    ) -> Option<String> {
        let opens = on_stage && !self.open;
        if on_stage != self.open {
            (self.open, self.sought_secs, self.place) = (on_stage, None, Place::default());
            if !on_stage && std::mem::take(&mut self.filled) {
                ctx.send_viewport_cmd(ViewportCommand::Fullscreen(false));
            }
        }
        if !on_stage {
            return None;
        }
        let full = ctx.input(|input| input.viewport().fullscreen.unwrap_or(false));
        match screen {
            Screen::Window => {}
            Screen::Full if opens => {
                ctx.send_viewport_cmd(ViewportCommand::Fullscreen(true));
                self.filled = !full;
            }
            Screen::Full => {}
            Screen::Monitor(_) | Screen::Named(_) => {
                let change = self.place.follow(screen, &names())?;
                match &change {
                    Change::Fill(index) => {
                        ctx.send_viewport_cmd(ViewportCommand::SetMonitor(*index));
                        self.filled |= !full;
                    }
                    // Left only where the stage has a window of its own, which is asked for every screen.
                    Change::Leave | Change::Missing { filled: true, .. } => {
                        if std::mem::take(&mut self.filled) {
                            ctx.send_viewport_cmd(ViewportCommand::Fullscreen(false));
                        }
                    }
                    Change::Missing { .. } => {}
                }
                return change.warning();
            }
        }
        None
    }

    /// Hides the pointer. Where it moves, or a key is pressed that nothing else has taken, shows it for a moment with the keys
    /// that help.
    pub fn show(&mut self, ui: &mut Ui, concert: &Concert, projection: Projection) {
        let now_secs = ui.input(|input| input.time);
        let opacity = concert.title_opacity(now_secs);
        concert.song_title.show(ui, ui.max_rect(), projection, opacity);
        let is_press =
            |event: &Event| matches!(event, Event::Key { key, pressed: true, .. } if !goes_with_others(*key));
        if ui.input(|input| input.pointer.is_moving() || input.events.iter().any(is_press)) {
            self.sought_secs = Some(now_secs);
        }
        if self.sought_secs.is_none_or(|sought_secs| now_secs - sought_secs > LINGER_SECS) {
            ui.ctx().set_cursor_icon(egui::CursorIcon::None);
            return;
        }
        let hint = if concert.is_held() {
            "H goes on · arrow keys show another dance · Escape leaves the stage".to_owned()
        } else if concert.is_piloted() {
            "H holds this dance · arrow keys show another · Escape leaves the stage".to_owned()
        } else if concert.instrument().steps_through_gallery() {
            "Escape leaves the stage · arrow keys show another dance · F11 full screen".to_owned()
        } else {
            match concert.instrument().favorites().len() {
                0 | 1 => "Escape leaves the stage · F11 full screen".to_owned(),
                count => format!(
                    "Escape leaves the stage · arrow keys show another of {count} favorites · F11 full screen"
                ),
            }
        };
        let at = ui.max_rect().center_bottom() - egui::vec2(0.0, 24.0);
        let width = ui.max_rect().width();
        let line = Anchored { at, anchor: egui::Align2::CENTER_CENTER, width };
        legible::show_halo(ui, line, &hint, HINT, 1.0);
        let text = egui::RichText::new(hint).size(HINT).color(Color32::from_white_alpha(200));
        let place = egui::Rect::from_center_size(at, egui::vec2(width, 20.0));
        // A label is read aloud, too.
        ui.put(place, egui::Label::new(text).selectable(false));
    }
}

/// Whether a key seeks nothing by itself: those that modify others, and locks.
fn goes_with_others(key: Key) -> bool {
    matches!(
        key,
        Key::ShiftLeft
            | Key::ShiftRight
            | Key::ControlLeft
            | Key::ControlRight
            | Key::AltLeft
            | Key::AltRight
            | Key::SuperLeft
            | Key::SuperRight
            | Key::Fn
            | Key::CapsLock
            | Key::NumLock
            | Key::ScrollLock
    )
}
