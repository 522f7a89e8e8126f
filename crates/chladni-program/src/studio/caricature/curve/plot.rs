//! Where wavelengths and gains lie on the screen.

use egui::{Pos2, Rect, pos2, vec2};

use crate::work::scale_plot::{self, share_of_axis, wave_at};

/// Width of the column of the residual.
const COLUMN: f32 = 22.0;

/// The two parts of the drawing.
#[derive(Clone, Copy)]
pub(super) struct Plot {
    /// The curve over the wavelengths of harmonics.
    pub(super) curve: Rect,
    /// Φ_d and its bar.
    pub(super) residual: Rect,
}

impl Plot {
    pub(super) fn within(rect: Rect) -> Self {
        let inner = Rect::from_min_max(rect.min + vec2(28.0, 10.0), rect.max - vec2(12.0, 36.0));
        let split = inner.right() - COLUMN;
        Self {
            curve: Rect::from_min_max(inner.min, pos2(split - 10.0, inner.bottom())),
            residual: Rect::from_min_max(pos2(split, inner.top()), inner.max),
        }
    }
}

pub(super) fn height_of(plot: Rect, gain: f64) -> f32 {
    plot.bottom() - plot.height() * scale_plot::height_of(gain) as f32
}

pub(super) fn gain_at(plot: Rect, y: f32) -> f64 {
    scale_plot::gain_at(f64::from((plot.bottom() - y) / plot.height()))
}

pub(super) fn to_screen(plot: Rect, [wavelength, gain]: [f64; 2]) -> Pos2 {
    pos2(plot.left() + plot.width() * share_of_axis(wavelength) as f32, height_of(plot, gain))
}

pub(super) fn from_screen(plot: Rect, at: Pos2) -> [f64; 2] {
    let share = f64::from((at.x - plot.left()) / plot.width());
    [wave_at(share.clamp(0.0, 1.0)), gain_at(plot, at.y)]
}
