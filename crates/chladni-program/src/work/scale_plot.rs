//! How a scale curve is drawn, in the window and in the page: where wavelengths and gains lie in its plot, how a hand draws
//! it, and the spectrum that the active model exaggerates behind it. Places in the plot go from 0 to 1, to the right and up.

use chladni_caricature::{Difference, Model, ScaleCurve, wavelengths};
use chladni_harmonics::Basis;

/// Gains with a line of their own.
pub const GAINS: [f64; 4] = [0.0, 1.0, 2.0, ScaleCurve::MAX_GAIN];
/// A step of a free hand, as a share of the axis: with fewer points the curve can still be edited by them.
const STEP: f64 = 1.0 / 48.0;

/// The spectrum that the active model exaggerates, before the curve.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Spectrum {
    /// Wavelength, as a share of the size, and amplitude of each harmonic, from broad to fine; empty until
    /// there is a difference.
    pub waves: Vec<[f64; 2]>,
    /// Amplitude of all that is finer.
    pub residual: f64,
}

impl Spectrum {
    /// The spectrum of a difference on a shape with the harmonics of `basis`.
    pub fn of(difference: &Difference, model: Model, basis: &Basis) -> Self {
        let bars = difference.amplitudes(model);
        let waves = wavelengths(basis).into_iter().zip(bars.harmonics);
        Self { waves: waves.map(|(wave, amplitude)| [wave, amplitude]).collect(), residual: bars.residual }
    }

    /// Where the finest harmonic lies.
    pub fn finest(&self) -> f64 {
        self.waves.last().map_or(1.0, |wave| share_of_axis(wave[0]))
    }

    /// The heights of `bands` bars and one for the residual, each before and after the curve: the energy of each band of
    /// wavelengths in decibels, since differences fall off by orders of magnitude.
    pub fn bars(&self, curve: &ScaleCurve, bands: usize) -> Vec<[f64; 2]> {
        let bands = bands.max(1);
        let mut energy = vec![[0.0_f64; 2]; bands];
        for [wavelength, amplitude] in &self.waves {
            let band = ((share_of_axis(*wavelength) * bands as f64) as usize).min(bands - 1);
            energy[band][0] += amplitude.powi(2);
            energy[band][1] += (amplitude * curve.at(*wavelength)).powi(2);
        }
        energy.push([self.residual.powi(2), (self.residual * curve.residual).powi(2)]);
        let peak = energy.iter().map(|e| e[0]).fold(0.0, f64::max);
        energy.into_iter().map(|[raw, curved]| [bar_height(raw / peak), bar_height(curved / peak)]).collect()
    }
}

/// The height of a bar: from 60 dB below the strongest to 12 dB above it, the most that the curve amplifies.
fn bar_height(energy: f64) -> f64 {
    let decibels = 10.0 * energy.log10();
    if decibels.is_finite() { ((decibels + 60.0) / 72.0).clamp(0.0, 1.0) } else { 0.0 }
}

/// The place of a wavelength on the logarithmic axis: 0 is the broadest, 1 the finest.
pub fn share_of_axis(wavelength: f64) -> f64 {
    let octaves = (ScaleCurve::BROADEST / ScaleCurve::FINEST).log2();
    ((ScaleCurve::BROADEST / wavelength).log2() / octaves).clamp(0.0, 1.0)
}

/// The wavelength at a place of the axis.
pub fn wave_at(share: f64) -> f64 {
    let wavelength = ScaleCurve::BROADEST * (ScaleCurve::FINEST / ScaleCurve::BROADEST).powf(share);
    wavelength.clamp(ScaleCurve::FINEST, ScaleCurve::BROADEST)
}

/// Gains are drawn at their square roots: 1 in the middle, 4 at the top.
pub fn height_of(gain: f64) -> f64 {
    (gain / ScaleCurve::MAX_GAIN).clamp(0.0, 1.0).sqrt()
}

/// The gain at a height.
pub fn gain_at(height: f64) -> f64 {
    height.clamp(0.0, 1.0).powi(2) * ScaleCurve::MAX_GAIN
}

/// Draws freely from the last (wavelength, gain) of a stroke, or at its first, to another; false where that is too near
/// to be a step.
pub fn draw_freely(curve: &mut ScaleCurve, last: Option<[f64; 2]>, to: [f64; 2]) -> bool {
    if last.is_some_and(|last| (share_of_axis(last[0]) - share_of_axis(to[0])).abs() < STEP) {
        return false;
    }
    curve.draw(last.unwrap_or(to), to);
    true
}

/// A wavelength as people read it.
pub fn percent(wavelength: f64) -> String {
    let percent = 100.0 * wavelength;
    if percent < 10.0 { format!("{percent:.1} %") } else { format!("{percent:.0} %") }
}

/// The gain of a curve at one wavelength, in words.
pub fn gain_in_words([wavelength, gain]: [f64; 2]) -> String {
    format!("Waves of {} of its size: ×{gain:.2}", percent(wavelength))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bar_that_is_amplified_as_far_as_it_goes_still_fits() {
        let top = ScaleCurve::MAX_GAIN;
        assert!((bar_height(top * top) - 1.0).abs() < 1e-3 && bar_height(1.0) > 0.8);
        assert_eq!((bar_height(1e-7), bar_height(0.0), bar_height(f64::NAN)), (0.0, 0.0, 0.0));
        let spectrum = Spectrum { waves: vec![[1.0, 1.0], [0.1, 0.1]], residual: 0.01 };
        let bars = spectrum.bars(&ScaleCurve::broad(), 40);
        assert_eq!(bars.len(), 41);
        let most = bars.iter().map(|bar| bar[0]).fold(0.0, f64::max);
        assert!((most - 60.0 / 72.0).abs() < 1e-9 && bars[40][1] == 0.0);
    }

    #[test]
    fn places_come_back_and_a_free_hand_takes_steps() {
        for share in [0.0, 0.3, 1.0] {
            assert!((share_of_axis(wave_at(share)) - share).abs() < 1e-12);
            assert!((height_of(gain_at(share)) - share).abs() < 1e-12);
        }
        let mut curve = ScaleCurve::flat(1.0);
        let point = |share: f64, gain: f64| [wave_at(share), gain];
        assert!(draw_freely(&mut curve, None, point(0.5, 2.0)));
        assert!(!draw_freely(&mut curve, Some(point(0.5, 2.0)), point(0.51, 2.0)));
        assert!(draw_freely(&mut curve, Some(point(0.5, 2.0)), point(0.6, 3.0)));
        assert_eq!(curve.points.len(), 4);
        curve.validate().unwrap();
    }
}
