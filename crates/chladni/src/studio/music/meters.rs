//! Spectrum and beat, as they are heard.

use egui::{Color32, Rect, RichText, Stroke, Ui, pos2};

use super::curve::TRANSFER;
use super::listening::Listening;
use crate::studio::theme;

/// Draws spectrum and beat below the gallery.
pub fn show(ui: &mut Ui, listening: &mut Listening) {
    let palette = theme::palette(ui);
    ui.add_space(theme::GAP_SMALL);
    let height = ui.available_height() - theme::GAP_SMALL;
    ui.horizontal(|ui| {
        let width = (ui.available_width() - 190.0).max(120.0);
        let (rect, _) = ui.allocate_exact_size(egui::vec2(width, height), egui::Sense::hover());
        ui.painter().rect_filled(rect, 6.0, ui.visuals().extreme_bg_color);
        let spectrum = listening.spectrum();
        // The name stays free of the bars.
        let rect_of_bars = rect.with_min_y(rect.top() + 16.0);
        bars(ui, rect_of_bars, &spectrum.mid, palette.accent.gamma_multiply(0.8));
        bars(ui, rect_of_bars, &spectrum.side, TRANSFER.gamma_multiply(0.6));
        let font = egui::TextStyle::Small.resolve(ui.style());
        ui.painter().text(
            rect.left_top() + egui::vec2(6.0, 4.0),
            egui::Align2::LEFT_TOP,
            "mid · side",
            font,
            palette.weak,
        );
        ui.vertical(|ui| {
            let moment = listening.beat_moment();
            ui.horizontal(|ui| {
                let size = 9.0 * (1.0 - moment.phase as f32).clamp(0.0, 1.0) * moment.confidence as f32 + 2.0;
                let (dot, _) = ui.allocate_exact_size(egui::vec2(24.0, 24.0), egui::Sense::hover());
                ui.painter().circle_filled(dot.center(), size, palette.accent);
                ui.label(format!("{:.0} BPM", moment.tempo_bpm));
            });
            ui.label(
                RichText::new(format!("confidence {:.0} %", moment.confidence * 100.0))
                    .small()
                    .color(palette.weak),
            );
            ui.horizontal(|ui| {
                if ui.small_button("½").on_hover_text("Half as fast").clicked() {
                    listening.follower().halve();
                }
                if ui.small_button("×2").on_hover_text("Twice as fast").clicked() {
                    listening.follower().double();
                }
                if ui.small_button("Tap").on_hover_text(super::TAP.tooltip(ui.ctx())).clicked() {
                    listening.tap();
                }
            });
        });
    });
}

fn bars(ui: &Ui, rect: Rect, values: &[f32], color: Color32) {
    if values.is_empty() {
        return;
    }
    let step = rect.width() / values.len() as f32;
    for (i, value) in values.iter().enumerate() {
        let x = rect.left() + (i as f32 + 0.5) * step;
        let height = rect.height() * value.clamp(0.0, 1.0).sqrt();
        let line = [pos2(x, rect.bottom()), pos2(x, rect.bottom() - height)];
        ui.painter().line_segment(line, Stroke::new((step - 1.0).max(1.0), color));
    }
}
