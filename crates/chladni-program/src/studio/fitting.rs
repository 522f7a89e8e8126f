//! The size of letters and controls that a screen has room for.

use egui::{Context, Vec2, ViewportCommand};

/// Points of a screen, without zoom, that the bars of the system and the frame of a window take.
const FRAME: Vec2 = Vec2::new(0.0, 80.0);

/// How large a window is drawn.
#[derive(Debug)]
pub struct Fitting {
    /// The zoom of the last frame.
    last: f32,
    /// The zoom for which the system knows the smallest size of the window.
    smallest_at: f32,
}

impl Default for Fitting {
    /// Of a new window: egui begins without zoom, and the window's builder has set its smallest size.
    fn default() -> Self {
        Self { last: 1.0, smallest_at: 1.0 }
    }
}

impl Fitting {
    /// Draws in the size `zoom` from now on, as far as the screen has room for a window of the `smallest` points.
    pub fn zoom(&mut self, ctx: &Context, zoom: f32, smallest: [f32; 2]) {
        let now = ctx.zoom_factor();
        let differ = |a: f32, b: f32| (a - b).abs() > 1e-3;
        // In the first frame of a zoom the screen is still measured in points of the one before.
        if differ(std::mem::replace(&mut self.last, now), now) {
            ctx.request_repaint();
            return;
        }
        let screen = ctx.input(|input| input.viewport().monitor_size).map(|points| points * now);
        let fitting = fitting(zoom, smallest.into(), screen);
        if differ(now, fitting) {
            ctx.set_zoom_factor(fitting);
        } else if differ(std::mem::replace(&mut self.smallest_at, now), now) {
            ctx.send_viewport_cmd(ViewportCommand::MinInnerSize(smallest.into()));
        }
    }
}

/// `zoom`, or the largest at which a `screen`, in points without zoom, has room for a window of the `smallest` points.
fn fitting(zoom: f32, smallest: Vec2, screen: Option<Vec2>) -> f32 {
    let screen = screen.filter(|size| size.min_elem() > 0.0);
    let room = screen.map_or(zoom, |size| ((size - FRAME) / smallest).min_elem());
    zoom.min(room.max(0.5))
}

#[cfg(test)]
mod tests {
    use egui::vec2;

    use super::*;

    #[test]
    fn letters_are_no_larger_than_the_screen_has_room_for() {
        let fitting = |zoom, screen| fitting(zoom, vec2(900.0, 600.0), screen);
        // The window, its frame and a bar of the system together are as high as the screen.
        assert_eq!(fitting(1.5, Some(vec2(1366.0, 768.0))), 688.0 / 600.0);
        assert_eq!(fitting(1.5, Some(vec2(1920.0, 1080.0))), 1.5);
        assert_eq!(fitting(1.1, Some(vec2(1366.0, 768.0))), 1.1);
        assert_eq!(fitting(1.0, Some(vec2(320.0, 200.0))), 0.5);
        assert_eq!(fitting(1.0, Some(vec2(320.0, 60.0))), 0.5);
        for unknown in [None, Some(vec2(0.0, 0.0))] {
            assert_eq!(fitting(2.0, unknown), 2.0);
        }
    }
}
