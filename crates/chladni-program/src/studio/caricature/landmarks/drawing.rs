//! The overlay of the two shapes.

use chladni_view::Rect;
use egui::{Color32, RichText, Ui};

use crate::work::landmarks::Side;

/// No more landmarks than this are numbered: a ray is cast for each in every frame, and they would cover each other.
const MOST_NUMBERS: usize = 300;

pub(super) fn cell_of(ui: &Ui, area: egui::Rect, whole: egui::Rect) -> Rect {
    let scale = ui.pixels_per_point();
    let offset = (area.min - whole.min) * scale;
    let total = (whole.size() * scale).round();
    let x = (offset.x.round() as u32).min(total.x as u32);
    let width = ((area.width() * scale).round() as u32).min(total.x as u32 - x);
    Rect { x, y: 0, width: width.max(1), height: (total.y as u32).max(1) }
}

pub(super) fn numbers(ui: &Ui, side: &Side, ends: &[(usize, u32)], area: egui::Rect, whole: egui::Rect) {
    let cell = cell_of(ui, area, whole);
    let painter = ui.painter_at(area);
    for (index, vertex) in ends.iter().take(MOST_NUMBERS) {
        let Some(([x, y], true)) = side.pixel(*vertex, cell) else { continue };
        let at = whole.min + egui::vec2(x, y) / ui.pixels_per_point() + egui::vec2(9.0, -9.0);
        let font = egui::TextStyle::Button.resolve(ui.style());
        let text = painter.layout_no_wrap((index + 1).to_string(), font, Color32::WHITE);
        let box_ = egui::Rect::from_min_size(at, text.size())
            .expand2(egui::vec2(4.0, 0.0))
            .translate(egui::vec2(0.0, -text.size().y / 2.0));
        painter.rect_filled(box_, 4.0, Color32::from_black_alpha(170));
        painter.galley(at - egui::vec2(0.0, text.size().y / 2.0), text, Color32::WHITE);
    }
}

/// The hint at the next step, at the foot of the view.
pub(super) fn hint(ui: &mut Ui, rect: egui::Rect, text: &str) {
    let area = egui::Rect::from_center_size(
        egui::pos2(rect.center().x, rect.bottom() - 30.0),
        egui::vec2(rect.width() - 40.0, 28.0),
    );
    ui.scope_builder(egui::UiBuilder::new().max_rect(area), |ui| {
        ui.vertical_centered(|ui| {
            egui::Frame::popup(ui.style()).inner_margin(6.0).show(ui, |ui| ui.label(RichText::new(text)));
        });
    });
}
