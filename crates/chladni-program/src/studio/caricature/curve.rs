//! The scale curve Φ over wavelength, with the spectrum that the active model exaggerates behind it.

mod painting;
mod plot;

use chladni_caricature::ScaleCurve;
use egui::{Pos2, Rect, Response, Sense, Ui, pos2, vec2};

use self::painting::paint;
use self::plot::{Plot, from_screen, gain_at, to_screen};
use crate::studio::author_id::AuthorId;
use crate::studio::curve_keys::CurveKeys;
use crate::studio::theme;
use crate::work::scale_plot::{self, Spectrum, gain_in_words, percent, share_of_axis, wave_at};

/// How near the pointer must be to take hold of a point, in window points.
const GRIP: f32 = 9.0;

/// The width of what a key changes: one point.
const POINT: f32 = 0.0;

/// How the pointer edits the curve.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Pen {
    /// Take hold of points; a click between them adds one.
    #[default]
    Points,
    /// Draw the curve freely.
    Free,
}

/// Draws and edits `curve`, by the pointer or by arrow keys; `spectrum` is shown behind it. The response is
/// [`changed`](Response::changed) where the curve was edited, and `drag_stopped` ends an edit.
pub fn edit(ui: &mut Ui, curve: &mut ScaleCurve, pen: Pen, spectrum: &Spectrum) -> Response {
    let size = vec2(ui.available_width(), 180.0);
    let (rect, response) = ui.allocate_exact_size(size, Sense::click_and_drag());
    let keys = CurveKeys::of(ui, &response, POINT);
    let there = keys.map(|keys| wave_at(f64::from(keys.middle())));
    response.widget_info(|| egui::WidgetInfo {
        current_text_value: Some(there.map_or_else(|| in_words(curve), |wave| there_in_words(curve, wave))),
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
        let pointed = match pen {
            Pen::Points => drag_points(ui, &response, plot.curve, curve),
            Pen::Free => {
                draw_freely(ui, &response, plot.curve, curve);
                response.interact_pointer_pos().map(|at| from_screen(plot.curve, at)[0])
            }
        };
        if let Some(wavelength) = pointed.filter(|_| *curve != before) {
            CurveKeys::follow(ui, &response, POINT, share_of_axis(wavelength) as f32);
        }
    }
    if let (Some(keys), Some(wave)) = (keys.filter(|keys| keys.rise != 0.0), there) {
        let away = |other: &f64| (share_of_axis(*other) - share_of_axis(wave)).abs();
        // A point that is there already is moved.
        let points = curve.points.iter().map(|point| point[0]).filter(|other| away(other) < GAP);
        let wave = points.min_by(|a, b| away(a).total_cmp(&away(b))).unwrap_or(wave);
        let height = scale_plot::height_of(curve.at(wave)) + f64::from(keys.rise);
        curve.set_point(wave, scale_plot::gain_at(height));
    }
    if *curve != before {
        response.mark_changed();
    }
    paint(ui, rect, plot, curve, spectrum, pen);
    if let Some(keys) = keys {
        keys.paint(ui, plot.curve);
    }
    let pointed = response.hover_pos().map(|at| {
        if on_residual {
            return format!("Finer than every harmonic: ×{:.2}", curve.residual);
        }
        gain_in_words(from_screen(plot.curve, at))
    });
    let text = pointed.or_else(|| there.map(|wave| there_in_words(curve, wave)));
    let text = text.unwrap_or_else(|| "Wavelength, as a share of its size".into());
    let font = egui::TextStyle::Small.resolve(ui.style());
    let at = pos2(rect.center().x, rect.bottom() - 3.0);
    ui.painter().text(at, egui::Align2::CENTER_BOTTOM, text, font, theme::palette(ui).weak);
    response
}

/// Its points in words; only some if it was drawn freely.
fn in_words(curve: &ScaleCurve) -> String {
    let step = curve.points.len().div_ceil(8).max(1);
    let points = curve.points.iter().step_by(step);
    let words = points.map(|[wavelength, gain]| format!("at {} ×{gain:.2}", percent(*wavelength)));
    let words: Vec<_> = words.chain([format!("finer ×{:.2}", curve.residual)]).collect();
    words.join(", ")
}

fn there_in_words(curve: &ScaleCurve, wavelength: f64) -> String {
    gain_in_words([wavelength, curve.at(wavelength)])
}

fn drag_residual(response: &Response, column: Rect, curve: &mut ScaleCurve) {
    let Some(at) = response.interact_pointer_pos() else { return };
    if response.dragged_by(egui::PointerButton::Primary) || response.clicked() {
        curve.residual = gain_at(column, at.y);
    }
}

/// Returns the wavelength of the point that was moved or set.
fn drag_points(ui: &Ui, response: &Response, plot: Rect, curve: &mut ScaleCurve) -> Option<f64> {
    let held_id = response.id.with("held");
    let nearest = |curve: &ScaleCurve, at: Pos2| {
        let distance = |p: &[f64; 2]| to_screen(plot, *p).distance(at);
        (0..curve.points.len())
            .min_by(|&a, &b| distance(&curve.points[a]).total_cmp(&distance(&curve.points[b])))
            .filter(|&i| distance(&curve.points[i]) <= GRIP)
    };
    let at = response.interact_pointer_pos()?;
    if response.secondary_clicked() {
        if let Some(index) = nearest(curve, at).filter(|_| curve.points.len() > 2) {
            curve.points.remove(index);
        }
        return None;
    }
    let mut moved = None;
    if response.drag_started_by(egui::PointerButton::Primary) || response.clicked() {
        // A drag is noticed some way from where it began.
        let at = ui.input(|input| input.pointer.press_origin()).unwrap_or(at);
        let [wavelength, gain] = from_screen(plot, at);
        let held = nearest(curve, at).unwrap_or_else(|| curve.set_point(wavelength, gain));
        ui.data_mut(|data| data.insert_temp(held_id, held));
        moved = curve.points.get(held).map(|point| point[0]);
    }
    if response.dragged_by(egui::PointerButton::Primary)
        && let Some(held) = ui.data(|data| data.get_temp::<usize>(held_id))
        && held < curve.points.len()
    {
        let [wavelength, gain] = from_screen(plot, at);
        let wavelength = between_neighbors(&curve.points, held, wavelength);
        curve.points[held] = [wavelength, gain];
        moved = Some(wavelength);
    }
    moved
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
    if scale_plot::draw_freely(curve, last, point) {
        ui.data_mut(|data| data.insert_temp(last_id, point));
    }
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
    fn arrow_keys_put_points() {
        let mut window = window();
        window.get_by_label("Scale curve").focus();
        window.run_steps(3);
        let height = |window: &Harness<'static, ScaleCurve>, place: f64| {
            scale_plot::height_of(window.state().at(wave_at(place)))
        };
        let (place, count) = (3.0 / 32.0, window.state().points.len());
        let before = height(&window, place);
        let step = if before < 0.5 { egui::Key::ArrowUp } else { egui::Key::ArrowDown };
        for key in [egui::Key::ArrowRight; 3].into_iter().chain([step; 2]) {
            window.key_press(key);
            window.run_steps(2);
        }
        let moved = (height(&window, place) - before).abs();
        assert!((moved - 0.1).abs() < 1e-6, "{moved}");
        assert_eq!(window.state().points.len(), count + 1);
        window.state().validate().unwrap();
    }

    #[test]
    fn arrow_keys_reach_the_finest_waves() {
        let mut window = window();
        window.get_by_label("Scale curve").focus();
        window.run_steps(3);
        for key in [egui::Key::ArrowRight; 40].into_iter().chain([egui::Key::ArrowUp]) {
            window.key_press(key);
            window.run_steps(1);
        }
        let [wavelength, gain] = window.state().points.last().copied().unwrap();
        assert!(share_of_axis(wavelength) > 0.999 && gain > 0.0, "×{gain} at {wavelength}");
        window.state().validate().unwrap();
    }

    #[test]
    fn arrow_keys_go_on_from_the_point_that_the_pointer_moved() {
        let mut window = window();
        let plot = Plot::within(window.get_by_label("Scale curve").rect());
        let grip = to_screen(plot.curve, ScaleCurve::mid().points[2]);
        drag(&mut window, grip, grip + vec2(15.0, 30.0));
        let [wavelength, gain] = window.state().points[2];
        window.get_by_label("Scale curve").focus();
        window.run_steps(3);
        window.key_press(egui::Key::ArrowUp);
        window.run_steps(2);
        let raised = scale_plot::height_of(window.state().at(wavelength)) - scale_plot::height_of(gain);
        assert!((raised - 0.05).abs() < 1e-3, "{raised}");
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
}
