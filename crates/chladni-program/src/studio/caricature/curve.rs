//! The scale curve Φ over wavelength, with what the active model exaggerates behind it.

use chladni_caricature::ScaleCurve;
use egui::{Color32, Pos2, Rect, Response, Sense, Stroke, Ui, pos2, vec2};

use crate::studio::author_id::AuthorId;
use crate::studio::theme;

/// The gain at the top of the plot.
const TOP: f64 = ScaleCurve::MAX_GAIN;
/// Gains with a line of their own.
const GAINS: [f64; 4] = [0.0, 1.0, 2.0, TOP];
/// Wavelengths that are named below the plot, shares of the size.
const WAVES: [f64; 6] = [2.0, 1.0, 0.5, 0.2, 0.1, 0.05];
/// How near the pointer must be to take hold of a point, in window points.
const GRIP: f32 = 9.0;
/// Width of the column of the residual.
const COLUMN: f32 = 22.0;

/// How the pointer edits the curve.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Pen {
    /// Take hold of points; a click between them adds one.
    #[default]
    Points,
    /// Draw the curve freely.
    Free,
}

/// What the active model exaggerates, before the curve.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Spectrum {
    /// Wavelength, as a share of the size, and amplitude of each harmonic, from broad to fine; empty until
    /// there is a difference.
    pub waves: Vec<[f64; 2]>,
    /// Amplitude of all that is finer.
    pub residual: f64,
}

/// The two parts of the drawing.
#[derive(Clone, Copy)]
struct Plot {
    /// The curve over the wavelengths of harmonics.
    curve: Rect,
    /// Φ_d and its bar.
    residual: Rect,
}

impl Plot {
    fn within(rect: Rect) -> Self {
        let inner = Rect::from_min_max(rect.min + vec2(28.0, 10.0), rect.max - vec2(12.0, 36.0));
        let split = inner.right() - COLUMN;
        Self {
            curve: Rect::from_min_max(inner.min, pos2(split - 10.0, inner.bottom())),
            residual: Rect::from_min_max(pos2(split, inner.top()), inner.max),
        }
    }
}

/// Draws and edits `curve`; `spectrum` is shown behind it. The response is
/// [`changed`](Response::changed) where the curve was edited, and `drag_stopped` ends an edit.
pub fn edit(ui: &mut Ui, curve: &mut ScaleCurve, pen: Pen, spectrum: &Spectrum) -> Response {
    let size = vec2(ui.available_width(), 180.0);
    let (rect, response) = ui.allocate_exact_size(size, Sense::click_and_drag());
    response.widget_info(|| egui::WidgetInfo {
        current_text_value: Some(in_words(curve)),
        ..egui::WidgetInfo::labeled(egui::Role::Canvas, true, "Scale curve")
    });
    let mut response = response.author_id("scale-curve");
    let plot = Plot::within(rect);
    let before = curve.clone();
    let origin = ui.input(|input| input.pointer.press_origin());
    let on_residual = origin.or(response.hover_pos()).is_some_and(|at| at.x > plot.curve.right() + 4.0);
    if on_residual {
        drag_residual(&response, plot.residual, curve);
    } else {
        match pen {
            Pen::Points => drag_points(ui, &response, plot.curve, curve),
            Pen::Free => draw_freely(ui, &response, plot.curve, curve),
        }
    }
    if *curve != before {
        response.mark_changed();
    }
    paint(ui, rect, plot, curve, spectrum, pen);
    let pointed = response.hover_pos().map(|at| {
        if on_residual {
            return format!("Finer than every harmonic: ×{:.2}", curve.residual);
        }
        let [wavelength, gain] = from_screen(plot.curve, at);
        format!("Waves of {} of its size: ×{gain:.2}", percent(wavelength))
    });
    let text = pointed.unwrap_or_else(|| "Wavelength, as a share of its size".into());
    let font = egui::TextStyle::Small.resolve(ui.style());
    let at = pos2(rect.center().x, rect.bottom() - 3.0);
    ui.painter().text(at, egui::Align2::CENTER_BOTTOM, text, font, theme::palette(ui).weak);
    response
}

fn percent(wavelength: f64) -> String {
    let percent = 100.0 * wavelength;
    if percent < 10.0 { format!("{percent:.1} %") } else { format!("{percent:.0} %") }
}

/// Its points in words; only some if it was drawn freely.
fn in_words(curve: &ScaleCurve) -> String {
    let step = curve.points.len().div_ceil(8).max(1);
    let points = curve.points.iter().step_by(step);
    let words = points.map(|[wavelength, gain]| format!("at {} ×{gain:.2}", percent(*wavelength)));
    let words: Vec<_> = words.chain([format!("finer ×{:.2}", curve.residual)]).collect();
    words.join(", ")
}

fn drag_residual(response: &Response, column: Rect, curve: &mut ScaleCurve) {
    let Some(at) = response.interact_pointer_pos() else { return };
    if response.dragged_by(egui::PointerButton::Primary) || response.clicked() {
        curve.residual = gain_at(column, at.y);
    }
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
        let [wavelength, gain] = from_screen(plot, at);
        let held = nearest(curve, at).unwrap_or_else(|| curve.set_point(wavelength, gain));
        ui.data_mut(|data| data.insert_temp(held_id, held));
    }
    if response.dragged_by(egui::PointerButton::Primary)
        && let Some(held) = ui.data(|data| data.get_temp::<usize>(held_id))
        && held < curve.points.len()
    {
        let [wavelength, gain] = from_screen(plot, at);
        curve.points[held] = [between_neighbors(&curve.points, held, wavelength), gain];
    }
}

/// How near two points may come, as a share of the axis.
const GAP: f64 = 1e-3;

/// `wavelength` for point `held`, kept between its neighbors so that the curve remains a function; where
/// they leave no room it stays.
fn between_neighbors(points: &[[f64; 2]], held: usize, wavelength: f64) -> f64 {
    let left = if held > 0 { share_of_axis(points[held - 1][0]) + GAP } else { 0.0 };
    let right = points.get(held + 1).map_or(1.0, |next| share_of_axis(next[0]) - GAP);
    if left > right {
        return points[held][0];
    }
    wave_at(share_of_axis(wavelength).clamp(left, right))
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
        Some(last) if (share_of_axis(last[0]) - share_of_axis(point[0])).abs() < 1.0 / 48.0 => {}
        _ => {
            curve.draw(last.unwrap_or(point), point);
            ui.data_mut(|data| data.insert_temp(last_id, point));
        }
    }
}

fn paint(ui: &Ui, rect: Rect, plot: Plot, curve: &ScaleCurve, spectrum: &Spectrum, pen: Pen) {
    let palette = theme::palette(ui);
    let painter = ui.painter_at(rect);
    painter.rect_filled(rect, 6.0, ui.visuals().extreme_bg_color);
    let faint = Stroke::new(1.0, palette.line.gamma_multiply(0.7));
    let font = egui::FontId::proportional(10.5);
    for gain in GAINS {
        let y = height_of(plot.curve, gain);
        painter.hline(plot.curve.x_range(), y, faint);
        painter.hline(plot.residual.x_range(), y, faint);
        // Gains are written left of the plot, not over lines.
        let at = pos2(rect.left() + 5.0, y);
        painter.text(at, egui::Align2::LEFT_CENTER, format!("×{gain:.0}"), font.clone(), palette.weak);
    }
    let foot = plot.curve.bottom() + 3.0;
    for wavelength in WAVES {
        let x = to_screen(plot.curve, [wavelength, 0.0]).x;
        painter.vline(x, plot.curve.y_range(), faint);
        painter.text(
            pos2(x, foot),
            egui::Align2::CENTER_TOP,
            percent_tick(wavelength),
            font.clone(),
            palette.weak,
        );
    }
    let finer = pos2(plot.residual.center().x, foot);
    painter.text(finer, egui::Align2::CENTER_TOP, "finer", font, palette.weak);
    if spectrum.waves.is_empty() {
        let font = egui::FontId::proportional(11.5);
        let text = "the difference appears here";
        let at = plot.curve.center_top() + vec2(0.0, 10.0);
        painter.text(at, egui::Align2::CENTER_TOP, text, font, palette.weak);
    }
    paint_bars(
        &painter,
        plot,
        curve,
        spectrum,
        palette.weak.gamma_multiply(0.4),
        palette.accent.gamma_multiply(0.5),
    );
    paint_curve(ui, &painter, plot, curve, spectrum, pen);
}

fn percent_tick(wavelength: f64) -> String {
    format!("{:.0}%", 100.0 * wavelength)
}

/// The curve: strong where there are harmonics, faint where there would be only with more of them.
fn paint_curve(
    ui: &Ui,
    painter: &egui::Painter,
    plot: Plot,
    curve: &ScaleCurve,
    spectrum: &Spectrum,
    pen: Pen,
) {
    let palette = theme::palette(ui);
    let steps = (plot.curve.width() / 2.0).ceil().max(2.0) as usize;
    let line: Vec<Pos2> = (0..=steps)
        .map(|i| {
            let wavelength = wave_at(i as f64 / steps as f64);
            to_screen(plot.curve, [wavelength, curve.at(wavelength)])
        })
        .collect();
    let finest = spectrum.waves.last().map_or(1.0, |wave| share_of_axis(wave[0]));
    let reached = ((finest * steps as f64).ceil() as usize).min(steps);
    painter.line(line[reached..].to_vec(), Stroke::new(1.5, palette.weak.gamma_multiply(0.7)));
    painter.line(line[..=reached].to_vec(), Stroke::new(2.0, palette.accent));
    let handle = |at: Pos2| {
        painter.circle(at, 4.0, ui.visuals().panel_fill, Stroke::new(2.0, palette.accent));
    };
    let y = height_of(plot.residual, curve.residual);
    painter.hline(plot.residual.x_range(), y, Stroke::new(2.0, palette.accent));
    handle(pos2(plot.residual.center().x, y));
    if pen == Pen::Points {
        curve.points.iter().for_each(|point| handle(to_screen(plot.curve, *point)));
    }
}

/// The energy of each band of wavelengths in decibels, since differences fall off by orders of magnitude,
/// before and after the curve. The residual is an extra band.
fn paint_bars(
    painter: &egui::Painter,
    plot: Plot,
    curve: &ScaleCurve,
    spectrum: &Spectrum,
    before: Color32,
    after: Color32,
) {
    let bands = (plot.curve.width() / 6.0).max(1.0) as usize;
    let mut energy = vec![[0.0_f64; 2]; bands];
    for [wavelength, amplitude] in &spectrum.waves {
        let band = ((share_of_axis(*wavelength) * bands as f64) as usize).min(bands - 1);
        energy[band][0] += amplitude.powi(2);
        energy[band][1] += (amplitude * curve.at(*wavelength)).powi(2);
    }
    let residual = [spectrum.residual.powi(2), (spectrum.residual * curve.residual).powi(2)];
    let peak = energy.iter().chain([&residual]).map(|e| e[0]).fold(0.0, f64::max);
    let bar = |x: egui::Rangef, [raw, curved]: [f64; 2]| {
        for (energy, color) in [(raw, before), (curved, after)] {
            let height = plot.curve.height() * bar_height(energy / peak) as f32;
            let y = egui::Rangef::new(plot.curve.bottom() - height, plot.curve.bottom());
            if height > 0.0 {
                painter.rect_filled(Rect::from_x_y_ranges(x, y), 1.0, color);
            }
        }
    };
    let width = plot.curve.width() / bands as f32;
    for (band, energy) in energy.into_iter().enumerate() {
        let left = plot.curve.left() + width * band as f32;
        bar(egui::Rangef::new(left + 0.5, left + width - 0.5), energy);
    }
    bar(plot.residual.x_range().shrink(3.0), residual);
}

/// The height of a bar, from 0 to 1: from 60 dB below the strongest to 12 dB above it, the most that the
/// curve amplifies.
fn bar_height(energy: f64) -> f64 {
    let decibels = 10.0 * energy.log10();
    if decibels.is_finite() { ((decibels + 60.0) / 72.0).clamp(0.0, 1.0) } else { 0.0 }
}

/// The position of a wavelength on the logarithmic axis: 0 is the broadest, 1 the finest.
fn share_of_axis(wavelength: f64) -> f64 {
    let octaves = (ScaleCurve::BROADEST / ScaleCurve::FINEST).log2();
    ((ScaleCurve::BROADEST / wavelength).log2() / octaves).clamp(0.0, 1.0)
}

fn wave_at(share: f64) -> f64 {
    let wavelength = ScaleCurve::BROADEST * (ScaleCurve::FINEST / ScaleCurve::BROADEST).powf(share);
    wavelength.clamp(ScaleCurve::FINEST, ScaleCurve::BROADEST)
}

/// Gains are drawn at their square roots: 1 in the middle, 4 at the top.
fn height_of(plot: Rect, gain: f64) -> f32 {
    plot.bottom() - plot.height() * (gain / TOP).clamp(0.0, 1.0).sqrt() as f32
}

fn gain_at(plot: Rect, y: f32) -> f64 {
    f64::from((plot.bottom() - y) / plot.height()).clamp(0.0, 1.0).powi(2) * TOP
}

fn to_screen(plot: Rect, [wavelength, gain]: [f64; 2]) -> Pos2 {
    pos2(plot.left() + plot.width() * share_of_axis(wavelength) as f32, height_of(plot, gain))
}

fn from_screen(plot: Rect, at: Pos2) -> [f64; 2] {
    let share = f64::from((at.x - plot.left()) / plot.width());
    [wave_at(share.clamp(0.0, 1.0)), gain_at(plot, at.y)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use egui_kittest::Harness;
    use egui_kittest::kittest::Queryable;

    #[test]
    fn screen_and_curve_agree() {
        let plot = Rect::from_min_size(pos2(10.0, 20.0), vec2(200.0, 100.0));
        for point in [[ScaleCurve::BROADEST, 0.0], [0.25, 1.0], [ScaleCurve::FINEST, 4.0]] {
            let back = from_screen(plot, to_screen(plot, point));
            assert!((back[0] / point[0] - 1.0).abs() < 1e-5 && (back[1] - point[1]).abs() < 1e-5, "{back:?}");
        }
    }

    fn window() -> Harness<'static, ScaleCurve> {
        let panel = |ui: &mut Ui, curve: &mut ScaleCurve| {
            edit(ui, curve, Pen::Points, &Spectrum::default());
        };
        Harness::builder().with_size(vec2(340.0, 220.0)).build_ui_state(panel, ScaleCurve::mid())
    }

    /// Presses at `from`, moves to `to` within a frame, and lets go.
    fn drag(window: &mut Harness<'static, ScaleCurve>, from: Pos2, to: Pos2) {
        let button = |pos, pressed| egui::Event::PointerButton {
            pos,
            button: egui::PointerButton::Primary,
            pressed,
            modifiers: egui::Modifiers::NONE,
        };
        window.hover_at(from);
        window.run_steps(1);
        window.event(button(from, true));
        window.run_steps(1);
        for at in [to, to] {
            window.hover_at(at);
            window.run_steps(1);
        }
        window.event(button(to, false));
        window.run_steps(1);
    }

    #[test]
    fn a_quick_hand_moves_the_point_it_took_hold_of() {
        let mut window = window();
        let plot = Plot::within(window.get_by_label("Scale curve").rect());
        let grip = to_screen(plot.curve, ScaleCurve::mid().points[2]);
        let there = grip + vec2(15.0, 30.0);
        drag(&mut window, grip, there);
        let (before, after) = (ScaleCurve::mid().points, &window.state().points);
        assert_eq!(after.len(), before.len());
        assert_eq!((&after[..2], &after[3..]), (&before[..2], &before[3..]));
        assert!(to_screen(plot.curve, after[2]).distance(there) < 0.01);
    }

    #[test]
    fn a_point_and_the_residual_reach_the_largest_gain() {
        let mut window = window();
        let plot = Plot::within(window.get_by_label("Scale curve").rect());
        let grip = to_screen(plot.curve, ScaleCurve::mid().points[2]);
        drag(&mut window, grip, pos2(grip.x, plot.curve.top() - 3.0));
        assert_eq!(window.state().points[2][1], ScaleCurve::MAX_GAIN);
        let points = window.state().points.clone();
        drag(&mut window, plot.residual.center_bottom(), plot.residual.center_top());
        assert_eq!((window.state().residual, &window.state().points), (ScaleCurve::MAX_GAIN, &points));
    }

    #[test]
    fn a_point_stays_where_its_neighbors_leave_no_room() {
        let mut curve = ScaleCurve { points: vec![[1.0, 1.0], [0.501, 1.0], [0.5, 1.0]], residual: 1.0 };
        for held in 0..3 {
            for wavelength in [ScaleCurve::BROADEST, 0.6, ScaleCurve::FINEST] {
                curve.points[held][0] = between_neighbors(&curve.points, held, wavelength);
                curve.validate().unwrap();
            }
        }
        let wide = [[1.0, 1.0], [0.5, 1.0], [0.2, 1.0]];
        assert!((between_neighbors(&wide, 1, 0.4) - 0.4).abs() < 1e-12);
        let next = between_neighbors(&wide, 1, 2.0);
        assert!(next < 1.0 && (share_of_axis(next) - share_of_axis(1.0) - GAP).abs() < 1e-12);
        assert_eq!(between_neighbors(&wide, 2, 0.0001), ScaleCurve::FINEST);
    }

    #[test]
    fn a_bar_that_is_amplified_as_far_as_it_goes_still_fits() {
        assert!((bar_height(TOP * TOP) - 1.0).abs() < 1e-3 && bar_height(1.0) > 0.8);
        assert_eq!((bar_height(1e-7), bar_height(0.0), bar_height(f64::NAN)), (0.0, 0.0, 0.0));
    }
}
