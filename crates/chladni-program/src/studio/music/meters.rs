//! Spectrum, level and beat, as they are heard.

use egui::{Align2, Color32, FontId, Pos2, Rect, RichText, Sense, Stroke, Ui, pos2, vec2};
use epaint::PathShape;

use super::curve;
use super::listening::{Listening, Loudness};
use crate::studio::author_id::AuthorId;
use crate::studio::icon::{self, Icon};
use crate::studio::keys::music::{DOUBLE, HALVE, TAP};
use crate::studio::theme;

/// Height of the bar with all meters.
pub const HEIGHT: f32 = 92.0;
/// Widths of the two meters beside the spectrum.
const LEVELS: f32 = 132.0;
const BEAT: f32 = 176.0;

/// Draws spectrum, levels and beat below the gallery.
pub fn show(ui: &mut Ui, listening: &mut Listening) {
    ui.add_space(theme::GAP_SMALL);
    let height = ui.available_height() - theme::GAP_SMALL;
    ui.horizontal(|ui| {
        let width = (ui.available_width() - LEVELS - BEAT - 3.0 * theme::GAP).max(120.0);
        let (rect, response) = ui.allocate_exact_size(vec2(width, height), Sense::hover());
        response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, "Spectrum"));
        spectrum(ui, rect, listening);
        response.on_hover_text("What the middle of the sound holds (above), and its sides (below)");
        ui.add_space(theme::GAP_SMALL);
        ui.allocate_ui(vec2(LEVELS, height), |ui| levels(ui, listening));
        ui.add_space(theme::GAP_SMALL);
        ui.allocate_ui(vec2(BEAT, height), |ui| beat(ui, listening));
    });
}

/// Mid grows upward and side downward from one line.
fn spectrum(ui: &Ui, rect: Rect, listening: &Listening) {
    let palette = theme::palette(ui);
    let painter = ui.painter_at(rect);
    painter.rect_filled(rect, 6.0, ui.visuals().extreme_bg_color);
    let inside = rect.shrink2(vec2(8.0, 4.0));
    // Names above the bars.
    let (names, inside) = inside.split_top_bottom_at_y(inside.top() + 13.0);
    let (above, below) = inside.split_top_bottom_at_fraction(0.64);
    let (heard, bands_hz) = listening.spectrum();
    bars(&painter, above, &heard.mid, palette.accent.gamma_multiply(0.85), false);
    bars(&painter, below, &heard.side, curve::transfer_color(ui).gamma_multiply(0.85), true);
    painter.hline(inside.x_range(), above.bottom(), Stroke::new(1.0, palette.line));
    let font = FontId::proportional(10.5);
    painter.text(names.left_top(), Align2::LEFT_TOP, "mid", font.clone(), palette.weak);
    painter.text(below.left_bottom(), Align2::LEFT_BOTTOM, "side", font.clone(), palette.weak);
    for (hz, name) in [(100.0, "100 Hz"), (1000.0, "1 kHz"), (10_000.0, "10 kHz")] {
        let band = bands_hz.partition_point(|&band| band < hz);
        if band > 0 && band < bands_hz.len() {
            let x = inside.left() + inside.width() * band as f32 / bands_hz.len() as f32;
            if x + 40.0 > inside.right() || x < inside.left() + 26.0 {
                continue;
            }
            painter.vline(
                x,
                inside.top()..=inside.bottom(),
                Stroke::new(1.0, palette.line.gamma_multiply(0.6)),
            );
            painter.text(pos2(x + 3.0, names.top()), Align2::LEFT_TOP, name, font.clone(), palette.weak);
        }
    }
}

fn bars(painter: &egui::Painter, rect: Rect, values: &[f32], color: Color32, down: bool) {
    let step = rect.width() / values.len().max(1) as f32;
    let base = if down { rect.top() + 1.0 } else { rect.bottom() };
    for (i, value) in values.iter().enumerate() {
        let x = rect.left() + (i as f32 + 0.5) * step;
        let height = (rect.height() - 1.0) * value.clamp(0.0, 1.0).sqrt();
        let end = if down { base + height } else { base - height };
        painter.line_segment([pos2(x, base), pos2(x, end)], Stroke::new((step - 1.0).max(1.0), color));
    }
}

fn levels(ui: &mut Ui, listening: &Listening) {
    ui.vertical(|ui| {
        theme::weak(ui, "Level");
        for (channel, of) in CHANNELS.into_iter().zip(listening.levels()) {
            ui.horizontal(|ui| {
                let letter = RichText::new(&channel[..1]).small();
                ui.add_sized([10.0, 14.0], egui::Label::new(letter).selectable(false));
                level(ui, channel, of);
            });
        }
    });
}

/// The channels of [`Listening::levels`].
pub const CHANNELS: [&str; 2] = ["Left", "Right"];

/// A peak from which on the sound may have been cut off.
const CLIPS: f32 = 0.999;

/// A bar of the root mean square with a line at the peak, from −60 dB to full scale, and a mark where it clips.
pub fn level(ui: &mut Ui, channel: &str, level: Loudness) {
    let palette = theme::palette(ui);
    let share = |amplitude: f32| (1.0 + 20.0 * amplitude.max(1e-6).log10() / 60.0).clamp(0.0, 1.0);
    let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), 12.0), Sense::hover());
    let clips = level.peak >= CLIPS;
    let color = if clips { palette.error } else { palette.good };
    ui.painter().rect_filled(rect, 4.0, ui.visuals().extreme_bg_color);
    let mut bar = rect.shrink(2.0);
    let whole = bar.width();
    bar.set_width(whole * share(level.rms));
    ui.painter().rect_filled(bar, 3.0, color.gamma_multiply(0.8));
    if share(level.peak) > 0.0 {
        let x = rect.left() + 2.0 + whole * share(level.peak);
        ui.painter().vline(x, rect.shrink(2.0).y_range(), Stroke::new(2.0, color));
    }
    if clips {
        let mark = rect.with_min_x(rect.right() - rect.height());
        ui.painter().rect_filled(mark, 4.0, color);
        let (text, font) = (icon::text(Icon::TriangleAlert), FontId::proportional(10.0));
        ui.painter().text(mark.center(), Align2::CENTER_CENTER, text, font, ui.visuals().extreme_bg_color);
    }
    let decibels = |amplitude: f32| 20.0 * amplitude.max(1e-6).log10();
    let text = format!("Mean {:.0} dB, peak {:.0} dB", decibels(level.rms), decibels(level.peak));
    let clipped = if clips { ", clips" } else { "" };
    response.widget_info(|| egui::WidgetInfo {
        current_text_value: Some(text.clone()),
        ..egui::WidgetInfo::labeled(egui::Role::Meter, true, format!("{channel} level{clipped}"))
    });
    response.on_hover_text(text);
}

fn beat(ui: &mut Ui, listening: &mut Listening) {
    let palette = theme::palette(ui);
    let moment = listening.beat_moment();
    let (phase, sure) = (moment.phase.clamp(0.0, 1.0) as f32, moment.confidence.clamp(0.0, 1.0) as f32);
    let (rect, response) = ui.allocate_exact_size(vec2(48.0, 48.0), Sense::hover());
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, "Beat dial"));
    dial(ui, rect, phase, sure);
    response.on_hover_text("The beat: the ring goes round once a beat, and is as bright as it is sure");
    ui.vertical(|ui| {
        ui.spacing_mut().item_spacing.y = 3.0;
        if moment.tempo_bpm > 0.0 {
            ui.label(RichText::new(format!("{:.0} BPM", moment.tempo_bpm)).size(15.0).strong());
            let text = format!("{:.0} % sure", 100.0 * sure);
            ui.label(RichText::new(text).small().color(palette.weak)).on_hover_text("Confidence of the beat");
        } else {
            ui.label(RichText::new("– BPM").size(15.0).strong());
            theme::weak(ui, "waiting for a beat");
        }
        ui.horizontal(|ui| {
            ui.spacing_mut().item_spacing.x = 4.0;
            if ui.small_button("½").on_hover_text(HALVE.tooltip(ui.ctx())).clicked() {
                listening.halve();
            }
            if ui.small_button("×2").on_hover_text(DOUBLE.tooltip(ui.ctx())).clicked() {
                listening.double();
            }
            if ui.small_button("Tap").author_id("tap").on_hover_text(TAP.tooltip(ui.ctx())).clicked() {
                listening.tap();
            }
        });
    });
}

/// A ring that goes round once a beat, and a disc that swells on it.
fn dial(ui: &Ui, rect: Rect, phase: f32, sure: f32) {
    let palette = theme::palette(ui);
    let (center, radius) = (rect.center(), 0.5 * rect.width() - 4.0);
    ui.painter().circle_stroke(center, radius, Stroke::new(3.0, palette.line));
    let at = |turn: f32| -> Pos2 {
        let (sin, cos) = (turn * std::f32::consts::TAU).sin_cos();
        center + radius * vec2(sin, -cos)
    };
    let arc: Vec<Pos2> = (0..=40u8).map(|i| at(phase * f32::from(i) / 40.0)).collect();
    let color = palette.accent.gamma_multiply(0.25 + 0.75 * sure);
    ui.painter().add(PathShape::line(arc, Stroke::new(3.0, color)));
    let swell = (1.0 - phase).powi(2) * sure;
    ui.painter().circle_filled(center, 3.0 + (radius - 8.0) * swell, color);
}

#[cfg(test)]
mod tests {
    use egui_kittest::Harness;
    use egui_kittest::kittest::Queryable;

    use super::*;

    #[test]
    fn sound_that_clips_has_a_mark_and_says_so() {
        for (peak, name) in [(0.5, "Left level"), (1.0, "Left level, clips")] {
            let heard = Loudness { peak, rms: 0.1 };
            // Nothing is drawn before the font of the icons is there.
            let is_ready = std::rc::Rc::new(std::cell::Cell::new(false));
            let ready = is_ready.clone();
            let meter = move |ui: &mut Ui| {
                if ready.get() {
                    level(ui, CHANNELS[0], heard);
                }
            };
            let mut window = Harness::builder().with_size(vec2(200.0, 40.0)).build_ui(meter);
            theme::install(&window.ctx);
            window.run_steps(1);
            is_ready.set(true);
            window.run_steps(3);
            assert!(window.query_by_label(name).is_some(), "{name}");
            let shapes = &window.output().shapes;
            let is_marked = shapes.iter().any(|clipped| matches!(clipped.shape, egui::Shape::Text(_)));
            assert_eq!(is_marked, peak > CLIPS);
        }
    }
}
