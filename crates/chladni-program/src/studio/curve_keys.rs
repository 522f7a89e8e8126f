//! Keys of a curve that has the focus, as on the web page: left and right go along it, up and down change its height there.

use egui::{EventFilter, Key, Rect, Response, Ui, pos2};

use super::theme;

/// Arrow keys go so many steps across a curve.
const ACROSS: f32 = 32.0;
/// And so many up.
const UP: f32 = 20.0;
/// The width of a step, as a share of the curve's.
pub const STEP: f32 = 1.0 / ACROSS;
/// The least width of the mark, in points.
const MARK: f32 = 2.0;

/// The state of the keys, in shares of the curve's width and height.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CurveKeys {
    /// The left end of the part that is to change.
    at: f32,
    /// The width of that part.
    width: f32,
    /// By how much it is raised now.
    pub rise: f32,
}

impl CurveKeys {
    /// Those of a curve, if it has the focus. They change a part of this `width`: a [`STEP`], or 0 for one point.
    pub fn of(ui: &Ui, response: &Response, width: f32) -> Option<Self> {
        if !response.has_focus() {
            return None;
        }
        let arrows = EventFilter { horizontal_arrows: true, vertical_arrows: true, ..EventFilter::default() };
        ui.memory_mut(|memory| memory.set_focus_lock_filter(response.id, arrows));
        let [side, rise] =
            [(Key::ArrowRight, Key::ArrowLeft), (Key::ArrowUp, Key::ArrowDown)].map(|(more, less)| {
                ui.input(|input| {
                    let presses = input.num_presses(more) as f32 - input.num_presses(less) as f32;
                    if input.modifiers.is_none() { presses } else { 0.0 }
                })
            });
        let at = ui.data_mut(|data| {
            let at = data.get_temp_mut_or(response.id.with("keys"), 0.0_f32);
            *at = (*at + side * STEP).clamp(0.0, 1.0 - width);
            *at
        });
        Some(Self { at, width, rise: rise / UP })
    }

    /// The keys go on from where the pointer has changed the curve.
    pub fn follow(ui: &Ui, response: &Response, width: f32, pointer: f32) {
        let at = (pointer - 0.5 * width).clamp(0.0, 1.0 - width);
        ui.data_mut(|data| data.insert_temp(response.id.with("keys"), at));
    }

    /// The middle of the part that is to change.
    pub fn middle(self) -> f32 {
        self.at + 0.5 * self.width
    }

    /// Shows where they are on a curve that fills `plot`.
    pub fn paint(self, ui: &Ui, plot: Rect) {
        let middle = plot.left() + self.middle() * plot.width();
        let half = 0.5 * (self.width * plot.width()).max(MARK);
        let part = Rect::from_min_max(pos2(middle - half, plot.top()), pos2(middle + half, plot.bottom()));
        ui.painter().rect_filled(part, 0.0, theme::palette(ui).weak.gamma_multiply(0.3));
    }
}
