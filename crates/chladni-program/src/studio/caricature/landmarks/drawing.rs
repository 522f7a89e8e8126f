//! What is drawn over the two shapes.

use chladni_view::{Marker, Rect};
use egui::{Color32, RichText, Ui};

use super::{COLORS, Side, Which};
use crate::studio::theme;

pub(super) fn cell_of(ui: &Ui, area: egui::Rect, whole: egui::Rect) -> Rect {
    let scale = ui.pixels_per_point();
    let offset = (area.min - whole.min) * scale;
    let total = (whole.size() * scale).round();
    let x = (offset.x.round() as u32).min(total.x as u32);
    let width = ((area.width() * scale).round() as u32).min(total.x as u32 - x);
    Rect { x, y: 0, width: width.max(1), height: (total.y as u32).max(1) }
}

pub(super) fn dots(side: &Side, ends: &[(usize, u32)]) -> Vec<Marker> {
    let dot = |(index, vertex): &(usize, u32)| {
        let [r, g, b] = COLORS[index % COLORS.len()];
        Some(Marker { position: side.position(*vertex)?, radius_px: 6.0, color: [r, g, b, 255] })
    };
    ends.iter().filter_map(dot).collect()
}

pub(super) fn numbers(ui: &Ui, side: &Side, ends: &[(usize, u32)], area: egui::Rect, whole: egui::Rect) {
    let cell = cell_of(ui, area, whole);
    let painter = ui.painter_at(area);
    for (index, vertex) in ends {
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

pub(super) fn label(ui: &Ui, area: egui::Rect, name: &str) {
    let font = egui::TextStyle::Body.resolve(ui.style());
    let at = area.left_top() + egui::vec2(12.0, 10.0);
    ui.painter().text(at, egui::Align2::LEFT_TOP, name, font, theme::palette(ui).weak);
}

/// What to do next, at the foot of the view.
pub(super) fn hint(ui: &mut Ui, rect: egui::Rect, pending: Option<Which>, count: usize) {
    let text = match (pending, count) {
        (Some(Which::Shape), _) => "Now click the same place on the template.".to_owned(),
        (Some(Which::Template), _) => "Now click the same place on the shape.".to_owned(),
        (None, 0) => {
            "Click a place on the shape, such as the tip of the nose, then the same place on the template."
                .to_owned()
        }
        (None, 1 | 2) => format!("{} more, and the landmarks lead the alignment.", 3 - count),
        (None, _) => "Drag a landmark to move it, right-click to remove it. The match follows.".to_owned(),
    };
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
