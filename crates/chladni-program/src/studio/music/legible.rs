//! Lines of text over a picture, with a dark halo, which can be read on any ground.

use std::sync::Arc;

use egui::text::{LayoutJob, TextWrapping};
use egui::{Align2, Color32, FontId, Galley, Pos2, Ui, vec2};

use crate::work::{halo_offsets, halo_opacity};

/// Where a line of text stands.
#[derive(Clone, Copy, Debug)]
pub struct Anchored {
    /// The point at which its anchor is.
    pub at: Pos2,
    pub anchor: Align2,
    /// What is wider ends in an ellipsis.
    pub width: f32,
}

/// Draws a text in letters of this size, in points.
pub fn show(ui: &Ui, place: Anchored, text: &str, size: f32, color: Color32) {
    let (corner, galley) = show_halo(ui, place, text, size, f32::from(color.a()) / 255.0);
    ui.painter().galley(corner, galley, color);
}

/// Draws the halo alone, as opaque as the text will be; returns the text and its corner.
pub fn show_halo(ui: &Ui, place: Anchored, text: &str, size: f32, opacity: f32) -> (Pos2, Arc<Galley>) {
    let (corner, galley) = laid_out(ui, place, text, size);
    halo(ui, corner, &galley, size, opacity);
    (corner, galley)
}

/// A text and its corner.
pub fn laid_out(ui: &Ui, place: Anchored, text: &str, size: f32) -> (Pos2, Arc<Galley>) {
    let text = text.replace(char::is_control, " ");
    let mut job = LayoutJob::simple_singleline(text, FontId::proportional(size), Color32::PLACEHOLDER);
    job.wrap = TextWrapping::truncate_at_width(place.width.max(0.0));
    let galley = ui.painter().layout_job(job);
    (place.anchor.anchor_size(place.at, galley.size()).min, galley)
}

/// Draws the halo of a text.
pub fn halo(ui: &Ui, corner: Pos2, text: &Arc<Galley>, size: f32, opacity: f32) {
    let color = Color32::from_black_alpha((255.0 * halo_opacity(opacity)) as u8);
    for [x, y] in halo_offsets(size) {
        ui.painter().galley(corner + vec2(x, y), Arc::clone(text), color);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_line_ends_where_its_room_does() {
        let ctx = egui::Context::default();
        let widest = |width: f32| {
            let output = ctx.run_ui(egui::RawInput::default(), |ui| {
                let place = Anchored { at: ui.max_rect().min, anchor: Align2::LEFT_TOP, width };
                show(ui, place, "The long name of a dance\nthat nobody cut", 20.0, Color32::WHITE);
            });
            let width = |shape: &epaint::ClippedShape| shape.shape.visual_bounding_rect().width();
            output.shapes.iter().map(width).fold(0.0, f32::max)
        };
        assert!(widest(100.0) <= 103.0 && widest(100.0) > 60.0 && widest(2000.0) > 250.0);
    }
}
