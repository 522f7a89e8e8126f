//! The size of letters and controls.

use egui::Key;

use super::Studio;
use super::keys::window::{ZOOM_IN, ZOOM_OUT, ZOOM_RESET};
use super::opening::{SMALLEST, WINDOW};
use super::shortcut::Shortcut;

/// Points across a screen on which those of usual size are too small to read.
const MANY_POINTS: f32 = 3000.0;
/// Plus on keyboards that have it above the equals sign.
const ZOOM_IN_UNSHIFTED: Shortcut = Shortcut::command(Key::Equals, ZOOM_IN.action);
/// One press of a key.
const STEP: f32 = 1.1;

impl Studio {
    pub(super) fn zoom_by_keys(&mut self, ctx: &egui::Context) {
        if ZOOM_IN.pressed_anywhere(ctx) || ZOOM_IN_UNSHIFTED.pressed_anywhere(ctx) {
            self.enlarge(ctx);
        }
        if ZOOM_RESET.pressed_anywhere(ctx) {
            self.settings.zoom = 1.0;
        }
        if ZOOM_OUT.pressed_anywhere(ctx) {
            // From the size that is seen, which may be all that the screen has room for.
            self.settings.zoom = (self.settings.zoom.min(ctx.zoom_factor()) / STEP).max(0.5);
        }
    }

    /// Draws in the size of the preferences from now on, as far as the screen has room for it.
    pub(super) fn zoom(&mut self, ctx: &egui::Context) {
        self.fitting.zoom(ctx, self.settings.zoom, SMALLEST);
    }

    /// Larger controls, as far as the window has room for them.
    fn enlarge(&mut self, ctx: &egui::Context) {
        let room = (ctx.content_rect().size() / egui::Vec2::from(SMALLEST)).min_elem();
        if room < STEP {
            self.notices
                .update("size of letters", "There is no room for larger letters: enlarge the window first.");
        } else {
            self.settings.zoom = (self.settings.zoom * STEP).min(3.0);
        }
    }

    /// On the first run, larger controls on a screen of many small points, which the system has not
    /// enlarged itself.
    pub(super) fn suit_the_screen(&mut self, ctx: &egui::Context) {
        let screen = ctx.input(|input| input.viewport().monitor_size).filter(|size| size.x > 0.0);
        if let Some(size) = screen.filter(|_| self.first_run) {
            self.first_run = false;
            if size.x >= MANY_POINTS {
                self.settings.zoom = 1.5;
                // As many points as before, of more pixels.
                let pixels = egui::Vec2::from(WINDOW) * 1.5;
                ctx.send_viewport_cmd(egui::ViewportCommand::InnerSize(pixels));
            }
        }
    }
}
