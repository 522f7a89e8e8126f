//! A curve of many values that is drawn by hand.

use egui::{Align2, Color32, FontId, Pos2, Rect, Response, Sense, Stroke, TextStyle, Ui, pos2, vec2};

use crate::studio::author_id::AuthorId;
use crate::studio::curve_keys::{CurveKeys, STEP};
use crate::studio::theme;
use crate::work::drawn_curve::{draw, draw_step};

/// Color of transfers on the dark of a cell.
pub const TRANSFER: Color32 = Color32::from_rgb(120, 190, 220);

/// The same on a panel, where the light theme needs it darker.
pub fn transfer_color(ui: &Ui) -> Color32 {
    if ui.visuals().dark_mode { TRANSFER } else { Color32::from_rgb(28, 112, 150) }
}

/// How a curve looks and what its values may be.
pub struct Plot<'a> {
    /// Its author id, which tests find it by.
    pub id: &'static str,
    /// Its name, on screen and for screen readers.
    pub name: &'a str,
    /// Lowest and highest value.
    pub range: (f32, f32),
    /// Its line.
    pub color: Color32,
    /// Bars behind it, each in [0, 1], spread over the width.
    pub behind: &'a [f32],
}

/// Draws `values` and lets the pointer draw over them, and arrow keys change them. The response is
/// [`changed`](Response::changed) where values were drawn, and `drag_stopped` or `clicked` ends
/// a stroke. With Shift a stroke keeps the height at which it began.
pub fn edit(ui: &mut Ui, rect: Rect, plot: &Plot<'_>, values: &mut [f32]) -> Response {
    let id = ui.scope_id().with(plot.name);
    let response = ui.interact(rect, id, Sense::click_and_drag());
    let keys = CurveKeys::of(ui, &response, STEP);
    response.widget_info(|| egui::WidgetInfo {
        current_text_value: keys.map(|keys| in_words(values, keys.middle())),
        ..egui::WidgetInfo::labeled(egui::Role::Canvas, true, plot.name)
    });
    let mut response = response.author_id(plot.id);
    let inside = inside(rect);
    let held = response.is_pointer_button_down_on()
        && ui.input(|input| input.pointer.button_down(egui::PointerButton::Primary));
    if let Some(at) = response.interact_pointer_pos().filter(|_| held || response.clicked()) {
        let mut point = from_screen(inside, plot.range, at);
        let last = ui.data(|data| data.get_temp::<[f32; 2]>(id)).unwrap_or(point);
        if ui.input(|input| input.modifiers.shift) {
            point[1] = last[1];
        }
        if draw(values, plot.range, last, point) {
            response.mark_changed();
        }
        ui.data_mut(|data| data.insert_temp(id, point));
        CurveKeys::follow(ui, &response, STEP, point[0]);
    } else {
        ui.data_mut(|data| data.remove_temp::<[f32; 2]>(id));
    }
    if let Some(keys) = keys.filter(|keys| keys.rise != 0.0) {
        let (low, high) = plot.range;
        let value = value_at(values, keys.middle()) + keys.rise * (high - low);
        if draw_step(values, plot.range, keys.middle(), STEP, value) {
            response.mark_changed();
        }
    }
    paint(ui, rect, inside, plot, values, response.hovered());
    if let Some(keys) = keys {
        keys.paint(ui, inside);
    }
    response.on_hover_cursor(egui::CursorIcon::Crosshair)
}

/// The value at a share of the width.
fn value_at(values: &[f32], at: f32) -> f32 {
    let index = (at * values.len() as f32) as usize;
    values.get(index).or(values.last()).copied().unwrap_or_default()
}

fn in_words(values: &[f32], at: f32) -> String {
    format!("{:.2} at {:.0} %", value_at(values, at), 100.0 * at)
}

/// Where the curve lies within its frame: below the name.
fn inside(rect: Rect) -> Rect {
    let mut inside = rect.shrink2(vec2(10.0, 10.0));
    inside.min.y += 16.0;
    inside
}

fn from_screen(inside: Rect, (low, high): (f32, f32), at: Pos2) -> [f32; 2] {
    let u = (at.x - inside.left()) / inside.width().max(1.0);
    let share = (inside.bottom() - at.y) / inside.height().max(1.0);
    [u.clamp(0.0, 1.0), (low + share * (high - low)).clamp(low, high)]
}

fn paint(ui: &Ui, rect: Rect, inside: Rect, plot: &Plot<'_>, values: &[f32], hovered: bool) {
    let palette = theme::palette(ui);
    let painter = ui.painter_at(rect);
    let edge = if hovered { plot.color.gamma_multiply(0.6) } else { palette.line };
    painter.rect(rect, 8.0, ui.visuals().extreme_bg_color, Stroke::new(1.0, edge), egui::StrokeKind::Inside);
    let step = inside.width() / plot.behind.len().max(1) as f32;
    for (i, value) in plot.behind.iter().enumerate() {
        let x = inside.left() + (i as f32 + 0.5) * step;
        let height = inside.height() * value.clamp(0.0, 1.0).sqrt();
        let bar = Stroke::new((step - 1.0).max(1.0), palette.weak.gamma_multiply(0.3));
        painter.vline(x, inside.bottom() - height..=inside.bottom(), bar);
    }
    let (low, high) = plot.range;
    let y = |value: f32| inside.bottom() - inside.height() * ((value - low) / (high - low)).clamp(0.0, 1.0);
    if low < 0.0 {
        painter.hline(inside.x_range(), y(0.0), Stroke::new(1.0, palette.line));
    }
    line(&painter, inside, values, plot.range, Stroke::new(2.0, plot.color));
    let font = TextStyle::Small.resolve(ui.style());
    painter.text(rect.left_top() + vec2(10.0, 6.0), Align2::LEFT_TOP, plot.name, font, palette.weak);
    let small = FontId::proportional(10.0);
    for (value, anchor) in [(high, Align2::RIGHT_TOP), (low, Align2::RIGHT_BOTTOM)] {
        let at = pos2(rect.right() - 8.0, y(value) + if value == high { -4.0 } else { 4.0 });
        painter.text(at, anchor, format!("{value:.0}"), small.clone(), palette.weak);
    }
}

/// `values` as one line across `rect`.
pub fn line(painter: &egui::Painter, rect: Rect, values: &[f32], (low, high): (f32, f32), stroke: Stroke) {
    let last = values.len().saturating_sub(1).max(1) as f32;
    let span = if high > low { high - low } else { 1.0 };
    let points: Vec<Pos2> = values
        .iter()
        .enumerate()
        .map(|(i, value)| {
            let share = ((value - low) / span).clamp(0.0, 1.0);
            pos2(rect.left() + rect.width() * i as f32 / last, rect.bottom() - rect.height() * share)
        })
        .collect();
    painter.line(points, stroke);
}

#[cfg(test)]
mod tests {
    use egui::Key;
    use egui_kittest::Harness;
    use egui_kittest::kittest::Queryable;

    use super::*;

    /// A window with a curve of `count` values in the middle of its range.
    fn window(count: usize) -> Harness<'static, Vec<f32>> {
        let panel = |ui: &mut Ui, values: &mut Vec<f32>| {
            let plot = Plot { id: "curve/t", name: "t", range: (0.0, 1.0), color: TRANSFER, behind: &[] };
            let rect = Rect::from_min_size(Pos2::ZERO, vec2(300.0, 100.0));
            edit(ui, rect, &plot, values);
            let _ = ui.button("Another");
        };
        Harness::builder().with_size(vec2(320.0, 200.0)).build_ui_state(panel, vec![0.5; count])
    }

    /// Gives the curve the focus and presses `keys`.
    fn press(window: &mut Harness<'static, Vec<f32>>, keys: &[Key]) {
        window.get_by_label("t").focus();
        window.run_steps(3);
        for key in keys {
            window.key_press(*key);
            window.run_steps(2);
        }
    }

    #[test]
    fn arrow_keys_choose_a_place_of_the_curve_and_change_it_there() {
        let mut window = window(64);
        press(&mut window, &[Key::ArrowRight, Key::ArrowRight, Key::ArrowUp, Key::ArrowDown, Key::ArrowDown]);
        let values = window.state();
        assert!((values[4] - 0.45).abs() < 1e-5 && values[4] == values[5], "{values:?}");
        assert!(values[..4].iter().chain(&values[6..]).all(|value| *value == 0.5), "{values:?}");
    }

    #[test]
    fn steps_side_by_side_are_raised_alike() {
        let mut window = window(50);
        press(&mut window, &[Key::ArrowUp, Key::ArrowRight, Key::ArrowUp, Key::ArrowRight, Key::ArrowUp]);
        let values = window.state();
        assert!(values[..5].iter().all(|value| (value - 0.55).abs() < 1e-5), "{values:?}");
        assert!(values[5..].iter().all(|value| *value == 0.5), "{values:?}");
    }

    #[test]
    fn keys_go_on_where_the_pointer_has_drawn() {
        let mut window = window(64);
        let at = inside(Rect::from_min_size(Pos2::ZERO, vec2(300.0, 100.0))).center();
        window.hover_at(at);
        for pressed in [true, false] {
            let button = egui::PointerButton::Primary;
            window.event(egui::Event::PointerButton {
                pos: at,
                button,
                pressed,
                modifiers: egui::Modifiers::NONE,
            });
            window.run_steps(2);
        }
        press(&mut window, &[Key::ArrowUp]);
        let values = window.state();
        assert!(values[31] == values[32] && (values[31] - 0.55).abs() < 1e-5, "{values:?}");
        let mut others = values[..31].iter().chain(&values[33..]);
        assert!(others.all(|value| (value - 0.5).abs() < 1e-5), "{values:?}");
    }
}
