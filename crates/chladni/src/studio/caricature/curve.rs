//! The scale curve Φ over frequency, with the spectrum of the difference behind it.

use chladni_caricature::ScaleCurve;
use egui::{Color32, Pos2, Rect, Response, Sense, Stroke, Ui, pos2, vec2};

use crate::studio::theme;

/// The gain at the top of the plot.
const TOP: f64 = 2.0;
/// How near the pointer must be to take hold of a point, in window points.
const GRIP: f32 = 9.0;

/// How the pointer edits the curve.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Pen {
    /// Take hold of points; a click between them adds one.
    #[default]
    Points,
    /// Draw the curve freely.
    Free,
}

/// One bar of the spectrum: normalised frequency and amplitude.
pub type Bar = [f64; 2];

/// Draws and edits `curve`; `spectrum` is shown behind it. The response is
/// [`changed`](Response::changed) where the curve was edited, and `drag_stopped` ends an edit.
pub fn edit(ui: &mut Ui, curve: &mut ScaleCurve, pen: Pen, spectrum: &[Bar]) -> Response {
    let size = vec2(ui.available_width(), 150.0);
    let (rect, mut response) = ui.allocate_exact_size(size, Sense::click_and_drag());
    response.widget_info(|| egui::WidgetInfo {
        current_text_value: Some(told(curve)),
        ..egui::WidgetInfo::labeled(egui::Role::Canvas, true, "Scale curve")
    });
    let plot = plot_in(rect);
    let before = curve.clone();
    match pen {
        Pen::Points => drag_points(ui, &response, plot, curve),
        Pen::Free => draw_freely(ui, &response, plot, curve),
    }
    if *curve != before {
        response.mark_changed();
    }
    paint(ui, rect, plot, curve, spectrum, pen);
    if let Some(at) = response.hover_pos() {
        let [u, gain] = from_screen(plot, at);
        let font = egui::TextStyle::Small.resolve(ui.style());
        let text = format!("{:.0} % of the highest frequency: ×{gain:.2}", u * 100.0);
        let middle = plot.center_bottom() + vec2(0.0, 4.0);
        let color = theme::palette(ui).weak;
        ui.painter().text(middle, egui::Align2::CENTER_TOP, text, font, color);
    }
    response
}

/// The curve's own place, without its scales.
fn plot_in(rect: Rect) -> Rect {
    Rect::from_min_max(rect.min + vec2(26.0, 10.0), rect.max - vec2(10.0, 20.0))
}

/// Its points in words; of one that was drawn freely only some.
fn told(curve: &ScaleCurve) -> String {
    let step = curve.points.len().div_ceil(8).max(1);
    let points = curve.points.iter().step_by(step);
    let words: Vec<_> = points.map(|[u, gain]| format!("at {:.0} % ×{gain:.2}", 100.0 * u)).collect();
    words.join(", ")
}

fn drag_points(ui: &Ui, response: &Response, plot: Rect, curve: &mut ScaleCurve) {
    let held_id = response.id.with("held");
    let nearest = |curve: &ScaleCurve, at: Pos2| {
        let distance = |p: &[f64; 2]| to_screen(plot, *p).distance(at);
        (0..curve.points.len())
            .min_by(|&a, &b| distance(&curve.points[a]).total_cmp(&distance(&curve.points[b])))
            .filter(|&i| distance(&curve.points[i]) <= GRIP)
    };
    let Some(at) = response.interact_pointer_pos() else { return };
    if response.secondary_clicked() {
        if let Some(index) = nearest(curve, at).filter(|_| curve.points.len() > 2) {
            curve.points.remove(index);
        }
        return;
    }
    if response.drag_started_by(egui::PointerButton::Primary) || response.clicked() {
        // A drag is noticed some way from where it began.
        let at = ui.input(|input| input.pointer.press_origin()).unwrap_or(at);
        let [u, gain] = from_screen(plot, at);
        let held = nearest(curve, at).unwrap_or_else(|| curve.set_point(u, gain, 0.0));
        ui.data_mut(|data| data.insert_temp(held_id, held));
    }
    if response.dragged_by(egui::PointerButton::Primary)
        && let Some(held) = ui.data(|data| data.get_temp::<usize>(held_id))
        && held < curve.points.len()
    {
        let [u, gain] = from_screen(plot, at);
        curve.points[held] = [between_neighbours(&curve.points, held, u), gain];
    }
}

/// How near two points may come.
const GAP: f64 = 1e-3;

/// `u` for point `held`, kept between its neighbours so that the curve remains a function; where
/// they leave no room it stays.
fn between_neighbours(points: &[[f64; 2]], held: usize, u: f64) -> f64 {
    let low = if held > 0 { points[held - 1][0] + GAP } else { 0.0 };
    let high = points.get(held + 1).map_or(1.0, |next| next[0] - GAP);
    if low <= high { u.clamp(low, high) } else { points[held][0] }
}

fn draw_freely(ui: &Ui, response: &Response, plot: Rect, curve: &mut ScaleCurve) {
    let last_id = response.id.with("last");
    let Some(at) = response.interact_pointer_pos() else { return };
    if !response.dragged_by(egui::PointerButton::Primary) {
        return;
    }
    let point = from_screen(plot, at);
    let last =
        if response.drag_started() { None } else { ui.data(|data| data.get_temp::<[f64; 2]>(last_id)) };
    // A step of 1/48 keeps the curve editable by its points afterwards.
    match last {
        Some(last) if (last[0] - point[0]).abs() < 1.0 / 48.0 => {}
        _ => {
            curve.draw(last.unwrap_or(point), point);
            ui.data_mut(|data| data.insert_temp(last_id, point));
        }
    }
}

fn paint(ui: &Ui, rect: Rect, plot: Rect, curve: &ScaleCurve, spectrum: &[Bar], pen: Pen) {
    let palette = theme::palette(ui);
    let painter = ui.painter_at(rect);
    painter.rect_filled(rect, 6.0, ui.visuals().extreme_bg_color);
    for gain in [0.0, 1.0, TOP] {
        let y = to_screen(plot, [0.0, gain]).y;
        painter.hline(plot.x_range(), y, Stroke::new(1.0, palette.line.gamma_multiply(0.7)));
    }
    if spectrum.is_empty() {
        let font = egui::FontId::proportional(11.5);
        let text = "the difference appears here";
        painter.text(plot.center_top() + vec2(0.0, 10.0), egui::Align2::CENTER_TOP, text, font, palette.weak);
    }
    paint_spectrum(&painter, plot, spectrum, palette.weak.gamma_multiply(0.45));
    let steps = (plot.width() / 2.0).ceil().max(2.0) as usize;
    let line: Vec<Pos2> = (0..=steps)
        .map(|i| {
            let u = i as f64 / steps as f64;
            to_screen(plot, [u, curve.at(u)])
        })
        .collect();
    painter.line(line, Stroke::new(2.0, palette.accent));
    // Gains stand left of the plot, under no line.
    for gain in [0.0, 1.0, TOP] {
        let at = pos2(rect.left() + 4.0, to_screen(plot, [0.0, gain]).y);
        let font = egui::FontId::proportional(10.5);
        painter.text(at, egui::Align2::LEFT_CENTER, format!("×{gain:.0}"), font, palette.weak);
    }
    let feet = [(0.0, egui::Align2::LEFT_BOTTOM, "broad"), (1.0, egui::Align2::RIGHT_BOTTOM, "fine")];
    for (u, align, text) in feet {
        let at = pos2(to_screen(plot, [u, 0.0]).x, rect.bottom() - 2.0);
        painter.text(at, align, text, egui::FontId::proportional(10.5), palette.weak);
    }
    if pen == Pen::Points {
        for point in &curve.points {
            painter.circle(
                to_screen(plot, *point),
                4.0,
                ui.visuals().panel_fill,
                Stroke::new(2.0, palette.accent),
            );
        }
    }
}

/// The spectrum on a scale of decibels: differences fall off by orders of magnitude.
fn paint_spectrum(painter: &egui::Painter, plot: Rect, spectrum: &[Bar], color: Color32) {
    let peak = spectrum.iter().map(|bar| bar[1]).fold(0.0, f64::max);
    if peak <= 0.0 {
        return;
    }
    let columns = plot.width().max(1.0) as usize;
    let mut highest = vec![0.0_f64; columns];
    for [u, amplitude] in spectrum {
        let column = ((u * columns as f64) as usize).min(columns - 1);
        highest[column] = highest[column].max(*amplitude);
    }
    const FLOOR_DB: f64 = -60.0;
    for (column, amplitude) in highest.iter().enumerate().filter(|(_, a)| **a > 0.0) {
        let share = 1.0 - 20.0 * (amplitude / peak).log10() / FLOOR_DB;
        let x = plot.left() + column as f32 + 0.5;
        let y = plot.bottom() - plot.height() * share.clamp(0.0, 1.0) as f32;
        painter.vline(x, y..=plot.bottom(), Stroke::new(1.0, color));
    }
}

fn to_screen(plot: Rect, [u, gain]: [f64; 2]) -> Pos2 {
    pos2(
        plot.left() + plot.width() * u as f32,
        plot.bottom() - plot.height() * (gain / TOP).clamp(0.0, 1.0) as f32,
    )
}

fn from_screen(plot: Rect, at: Pos2) -> [f64; 2] {
    let u = f64::from((at.x - plot.left()) / plot.width());
    let gain = f64::from((plot.bottom() - at.y) / plot.height()) * TOP;
    [u.clamp(0.0, 1.0), gain.clamp(0.0, TOP)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use egui_kittest::Harness;
    use egui_kittest::kittest::Queryable;

    #[test]
    fn screen_and_curve_agree() {
        let plot = Rect::from_min_size(pos2(10.0, 20.0), vec2(200.0, 100.0));
        for point in [[0.0, 0.0], [0.25, 1.0], [1.0, 2.0]] {
            let back = from_screen(plot, to_screen(plot, point));
            assert!((back[0] - point[0]).abs() < 1e-6 && (back[1] - point[1]).abs() < 1e-6);
        }
    }

    #[test]
    fn a_quick_hand_moves_the_point_it_took_hold_of() {
        let panel = |ui: &mut Ui, curve: &mut ScaleCurve| drop(edit(ui, curve, Pen::Points, &[]));
        let mut window =
            Harness::builder().with_size(vec2(340.0, 190.0)).build_ui_state(panel, ScaleCurve::mid());
        let plot = plot_in(window.get_by_label("Scale curve").rect());
        let button = |pos, pressed| egui::Event::PointerButton {
            pos,
            button: egui::PointerButton::Primary,
            pressed,
            modifiers: egui::Modifiers::NONE,
        };
        let grip = to_screen(plot, ScaleCurve::mid().points[2]);
        let there = grip + vec2(20.0, 30.0);
        window.hover_at(grip);
        window.run_steps(1);
        window.event(button(grip, true));
        window.run_steps(1);
        for at in [there, there] {
            window.hover_at(at);
            window.run_steps(1);
        }
        window.event(button(there, false));
        window.run_steps(1);
        let (before, after) = (ScaleCurve::mid().points, &window.state().points);
        assert_eq!(after.len(), before.len());
        assert_eq!((&after[..2], &after[3..]), (&before[..2], &before[3..]));
        assert!(to_screen(plot, after[2]).distance(there) < 0.01);
    }

    #[test]
    fn a_point_stays_where_its_neighbours_leave_no_room() {
        let mut curve = ScaleCurve { points: vec![[0.0, 1.0], [0.9995, 1.0], [1.0, 1.0]], residual: 1.0 };
        for held in 0..3 {
            for u in [0.0, 0.5, 1.0] {
                curve.points[held][0] = between_neighbours(&curve.points, held, u);
                curve.validate().unwrap();
            }
        }
        let wide = [[0.2, 1.0], [0.5, 1.0], [0.8, 1.0]];
        assert_eq!(between_neighbours(&wide, 1, 0.6), 0.6);
        assert_eq!(between_neighbours(&wide, 1, 0.1), 0.2 + GAP);
        assert_eq!(between_neighbours(&wide, 2, 2.0), 1.0);
    }
}
