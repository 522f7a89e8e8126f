//! A small copy of the second window's picture, for those who look at the first.

use egui::{Color32, Rect, Sense, Ui, vec2};

use super::Concert;
use super::pane::Pane;
use crate::studio::author_id::AuthorId;
use crate::studio::theme;

/// Points that it is high in the bar, and under the pointer.
const HEIGHT: f32 = 30.0;
const LARGE: f32 = 270.0;

impl Concert {
    /// Draws the picture of the stage, as dark as it is there; nothing before the stage has one of its own.
    pub fn preview(&self, ui: &mut Ui) {
        let Some(pane) = self.apart.as_ref().map(|apart| &apart.pane) else { return };
        let Some([width, height]) = pane.shown.as_ref().map(|shown| shown.staged.size()) else { return };
        let aspect = width as f32 / height.max(1) as f32;
        let (rect, response) = ui.allocate_exact_size(vec2(HEIGHT * aspect, HEIGHT), Sense::hover());
        response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, "The stage"));
        paint_stage(ui, pane, rect);
        response.author_id("preview").on_hover_ui(|ui| {
            let (rect, _) = ui.allocate_exact_size(vec2(LARGE * aspect, LARGE), Sense::hover());
            paint_stage(ui, pane, rect);
        });
    }
}

fn paint_stage(ui: &Ui, pane: &Pane, rect: Rect) {
    let Some(texture) = pane.texture() else { return };
    ui.painter().image(texture, rect, theme::WHOLE_IMAGE, Color32::WHITE);
    pane.lay_veil(ui, rect);
}
