//! Things drawn behind and over the shapes on the stage: the background, names, the legend of a heat map.

use chladni_view::{Background, Rect, Scale};
use egui::{Color32, Stroke, Ui};

use super::look::Show;
use crate::studio::theme;
use crate::studio::viewport;

/// The background of shapes in this window.
pub fn backdrop(ui: &Ui) -> Background {
    if !ui.visuals().dark_mode {
        return Background::PAPER;
    }
    let stage = theme::palette(ui).stage;
    let lift = |c: u8| c.saturating_add(22);
    let [r, g, b, _] = stage.to_array();
    Background::between([r, g, b].map(lift), [r, g, b])
}

/// Marks a place of a shape that is seen in `area`: a disk where it faces the viewer, a ring where it is hidden.
pub fn mark_place(ui: &Ui, area: egui::Rect, at: egui::Pos2, faces: bool) {
    const RADIUS: f32 = 5.0;
    let (accent, edge) = (theme::palette(ui).accent, Color32::from_black_alpha(200));
    let painter = ui.painter_at(area);
    if faces {
        painter.circle(at, RADIUS, accent, Stroke::new(1.5, edge));
    } else {
        painter.circle_stroke(at, RADIUS, Stroke::new(3.5, edge));
        painter.circle_stroke(at, RADIUS, Stroke::new(1.5, accent));
    }
}

/// Names the shapes in their cells, in a color that can be read on what is behind them.
pub fn show_names(ui: &Ui, rect: egui::Rect, show: Show, cells: &[Rect], color: Color32) {
    let names: &[&str] = match show {
        Show::Result => return,
        // They are not there yet.
        Show::Models if cells.len() == 1 => return,
        Show::Models => &["Coordinate", "Normal", "Distance", "Original"],
        Show::BeforeAfter => &["Before", "After"],
        Show::Template if cells.len() == 1 => &["Result (the selected layer has no template to be seen yet)"],
        Show::Template => &["Result", "Template"],
        Show::Original => &["Original"],
    };
    for (cell, name) in cells.iter().zip(names) {
        show_name(ui, viewport::to_points(ui, rect, *cell), name, color);
    }
}

/// Names the shape in a cell.
pub fn show_name(ui: &Ui, cell: egui::Rect, name: &str, color: Color32) {
    let font = egui::TextStyle::Body.resolve(ui.style());
    let at = cell.left_top() + egui::vec2(12.0, 10.0);
    let rect = ui.painter().text(at, egui::Align2::LEFT_TOP, name, font, color);
    let label = ui.interact(rect, ui.scope_id().with(("shape", name)), egui::Sense::hover());
    label.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Label, true, name));
}

/// A bar of the color map with round numbers beside it.
pub fn show_legend(ui: &Ui, rect: egui::Rect, scale: Scale) {
    let bar = egui::Rect::from_min_size(
        egui::pos2(rect.left() + 16.0, rect.bottom() - 176.0),
        egui::vec2(12.0, 160.0),
    );
    let painter = ui.painter_at(rect);
    let mut mesh = egui::Mesh::default();
    const STEPS: u32 = 48;
    for step in 0..=STEPS {
        let t = step as f32 / STEPS as f32;
        let value = scale.low + (scale.high - scale.low) * t;
        let [r, g, b] = scale.color(value);
        let y = bar.bottom() - bar.height() * t;
        for x in [bar.left(), bar.right()] {
            mesh.colored_vertex(egui::pos2(x, y), Color32::from_rgb(r, g, b));
        }
        if step > 0 {
            let base = 2 * (step - 1);
            mesh.add_triangle(base, base + 1, base + 2);
            mesh.add_triangle(base + 1, base + 3, base + 2);
        }
    }
    painter.add(mesh);
    let font = egui::TextStyle::Small.resolve(ui.style());
    let color = ui.visuals().text_color();
    for tick in scale.ticks(5) {
        let t = (tick - scale.low) / (scale.high - scale.low).max(f32::MIN_POSITIVE);
        let y = bar.bottom() - bar.height() * t;
        painter.hline(bar.right()..=bar.right() + 4.0, y, Stroke::new(1.0, color));
        let at = egui::pos2(bar.right() + 8.0, y);
        painter.text(at, egui::Align2::LEFT_CENTER, format!("{tick}"), font.clone(), color);
    }
}
