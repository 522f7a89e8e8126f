//! Keys of a curve that has the focus, as on the web page: left and right go along it, up and down change its height there.

use egui::{EventFilter, Key, Rect, Response, Ui, pos2};

use super::theme;

/// Arrow keys go so many steps across a curve.
const ACROSS: f32 = 32.0;
/// And so many up.
const UP: f32 = 20.0;
/// The width of a step, as a share of the curve's.
pub const STEP: f32 = 1.0 / ACROSS;

/// The state of the keys, in shares of the curve's width and height.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CurveKeys {
    /// The left end of the step that is to change.
    pub at: f32,
    /// By how much it is raised now.
    pub rise: f32,
}

impl CurveKeys {
    /// Those of a curve, if it has the focus.
    pub fn of(ui: &Ui, response: &Response) -> Option<Self> {
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
            *at = (*at + side * STEP).clamp(0.0, 1.0 - STEP);
            *at
        });
        Some(Self { at, rise: rise / UP })
    }

    /// Shows where they are on a curve that fills `plot`.
    pub fn paint(self, ui: &Ui, plot: Rect) {
        let x = |share: f32| plot.left() + share * plot.width();
        let step = Rect::from_min_max(pos2(x(self.at), plot.top()), pos2(x(self.at + STEP), plot.bottom()));
        ui.painter().rect_filled(step, 0.0, theme::palette(ui).weak.gamma_multiply(0.3));
    }
}
