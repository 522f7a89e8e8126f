//! When the graphics device is lost, the window closes and its contents are kept.
//!
//! A driver that restarts takes all that was on the card with it, and egui's painter cannot change devices. So
//! the window closes, and another opens with the same rooms, which move to its device.

use std::cell::RefCell;
use std::rc::Rc;

use super::Studio;
use super::room::Room;

/// The state that a window hands over to the next one.
pub struct Left {
    /// The rooms, with all that is open in them.
    pub rooms: Vec<Box<dyn Room>>,
    /// The room that was on screen.
    pub current: Option<usize>,
    /// Why the device was lost.
    pub why: String,
    /// The clock of the window; the next one's continues from here.
    pub at_secs: f64,
    /// From the next window on the processor draws, whatever was chosen.
    pub falls_to_processor: bool,
}

/// Holds the contents of a window that has lost its device, for the next one.
#[derive(Clone, Default)]
pub struct Handover(Rc<RefCell<Option<Left>>>);

impl Handover {
    /// Why the last window had to close; `None` where it did not have to.
    pub fn reason(&self) -> Option<String> {
        self.0.borrow().as_ref().map(|left| left.why.clone())
    }

    pub(super) fn leave(&self, left: Left) {
        *self.0.borrow_mut() = Some(left);
    }

    pub(super) fn fall_to_processor(&self) {
        if let Some(left) = self.0.borrow_mut().as_mut() {
            left.falls_to_processor = true;
        }
    }

    pub(super) fn take(&self) -> Option<Left> {
        self.0.borrow_mut().take()
    }
}

impl Studio {
    /// Once the device is lost: leaves the rooms to the next window, and closes. True from then on.
    pub(super) fn hand_over(&mut self, ctx: &egui::Context) -> bool {
        let Some(why) = self.loss.reason().map(str::to_owned) else { return false };
        // The next window reads them.
        self.write_settings();
        if !self.rooms.is_empty() {
            let (rooms, current) = (std::mem::take(&mut self.rooms), self.current.take());
            let at_secs = ctx.input(|input| input.time);
            self.handover.leave(Left { rooms, current, why, at_secs, falls_to_processor: false });
        }
        // egui's painter panics where it has something to paint and no device.
        ctx.graphics_mut(|graphics| *graphics = egui::layers::GraphicLayers::default());
        ctx.send_viewport_cmd(egui::ViewportCommand::Close);
        true
    }
}
