//! Where wavelengths and gains lie on the screen.

use chladni_caricature::ScaleCurve;
use egui::{Pos2, Rect, pos2, vec2};

/// The gain at the top of the plot.
pub(super) const TOP: f64 = ScaleCurve::MAX_GAIN;
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

/// The position of a wavelength on the logarithmic axis: 0 is the broadest, 1 the finest.
pub(super) fn share_of_axis(wavelength: f64) -> f64 {
    let octaves = (ScaleCurve::BROADEST / ScaleCurve::FINEST).log2();
    ((ScaleCurve::BROADEST / wavelength).log2() / octaves).clamp(0.0, 1.0)
}

pub(super) fn wave_at(share: f64) -> f64 {
    let wavelength = ScaleCurve::BROADEST * (ScaleCurve::FINEST / ScaleCurve::BROADEST).powf(share);
    wavelength.clamp(ScaleCurve::FINEST, ScaleCurve::BROADEST)
}

/// Gains are drawn at their square roots: 1 in the middle, 4 at the top.
pub(super) fn height_of(plot: Rect, gain: f64) -> f32 {
    plot.bottom() - plot.height() * (gain / TOP).clamp(0.0, 1.0).sqrt() as f32
}

pub(super) fn gain_at(plot: Rect, y: f32) -> f64 {
    f64::from((plot.bottom() - y) / plot.height()).clamp(0.0, 1.0).powi(2) * TOP
}

pub(super) fn to_screen(plot: Rect, [wavelength, gain]: [f64; 2]) -> Pos2 {
    pos2(plot.left() + plot.width() * share_of_axis(wavelength) as f32, height_of(plot, gain))
}

pub(super) fn from_screen(plot: Rect, at: Pos2) -> [f64; 2] {
    let share = f64::from((at.x - plot.left()) / plot.width());
    [wave_at(share.clamp(0.0, 1.0)), gain_at(plot, at.y)]
}
