//! Cards: a picture over a name, to be clicked.

use egui::{Align, Align2, Layout, Sense, Stroke, StrokeKind, Ui, UiBuilder, Vec2, vec2};

use super::icon::{self, Icon};
use super::theme;

/// Height of the name below a picture.
const NAME: f32 = 30.0;

/// Draws a card of `size`, with `mark` where there is no picture. Screen readers say the effect of a click (`does`),
/// then `name`.
pub fn card(
    ui: &mut Ui,
    size: Vec2,
    picture: Option<&egui::TextureHandle>,
    mark: Icon,
    does: &str,
    name: &str,
) -> egui::Response {
    let palette = theme::palette(ui);
    let (rect, response) = ui.allocate_exact_size(size, Sense::click());
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, format!("{does} {name}")));
    let line = if response.hovered() { palette.accent } else { palette.line };
    let painter = ui.painter();
    painter.rect(rect, 8.0, palette.card, Stroke::new(1.0, line), StrokeKind::Inside);
    let frame = egui::Rect::from_min_size(rect.min, vec2(rect.width(), size.y - NAME)).shrink(1.0);
    painter.rect_filled(frame, egui::CornerRadius { nw: 7, ne: 7, sw: 0, se: 0 }, palette.stage);
    match picture {
        Some(picture) => {
            painter.image(picture.id(), frame, theme::WHOLE_IMAGE, egui::Color32::WHITE);
        }
        None => {
            let font = egui::FontId::proportional(30.0);
            painter.text(frame.center(), Align2::CENTER_CENTER, icon::text(mark), font, palette.line);
        }
    }
    let below = egui::Rect::from_min_max(frame.left_bottom(), rect.max).shrink2(vec2(10.0, 3.0));
    let mut line =
        ui.new_child(UiBuilder::new().max_rect(below).layout(Layout::left_to_right(Align::Center)));
    line.add(egui::Label::new(name).truncate().selectable(false));
    response
}
