//! The scale curve of the chosen layer, drawn by hand. Places in its plot go from 0 to 1, to the right and up.

use chladni_caricature::{Action, Layer, LayerId, Property, ScaleCurve};
use chladni_program::work::Error;
use chladni_program::work::scale_plot::{
    GAINS, Spectrum, draw_freely, gain_at, gain_in_words, height_of, share_of_axis, wave_at,
};
use serde::Serialize;
use wasm_bindgen::prelude::*;

use super::Sitting;

/// Pieces of the line.
const PIECES: u32 = 96;
/// Bars of the spectrum behind it.
const BANDS: usize = 40;
/// Wavelengths that are named below the plot, shares of the size.
const WAVES: [f64; 4] = [2.0, 0.5, 0.2, 0.05];

/// All that the page draws of it.
#[derive(Serialize)]
struct Plot {
    /// Heights of the curve from left to right.
    line: Vec<f64>,
    /// Where the finest harmonic lies: beyond, there would be some only with more of them.
    reached: f64,
    /// The energy of each band of wavelengths before and after the curve, then of all that is finer than the harmonics.
    bars: Vec<[f64; 2]>,
    /// The gain of the curve on that residual.
    residual: f64,
    /// Heights and names of gains; places and names of wavelengths.
    gains: [(f64, String); 4],
    waves: [(f64, String); 4],
}

#[wasm_bindgen]
impl Sitting {
    /// The plot, as JSON; `null` where no layer is chosen.
    ///
    /// # Errors
    /// Bugs only.
    pub fn scale_plot(&self) -> Result<String, JsError> {
        let plot = self.chosen().map(|(id, layer)| {
            let evaluated = self.evaluation.layers.iter().find(|evaluated| evaluated.id == id);
            let difference = evaluated.and_then(|evaluated| evaluated.difference.as_ref());
            let basis = &self.stack.body().basis;
            let spectrum = difference.map(|difference| Spectrum::of(difference, layer.model, basis));
            let spectrum = spectrum.unwrap_or_default();
            let at = |i: u32| height_of(layer.curve.at(wave_at(f64::from(i) / f64::from(PIECES))));
            Plot {
                line: (0..=PIECES).map(at).collect(),
                reached: spectrum.finest(),
                bars: spectrum.bars(&layer.curve, BANDS),
                residual: layer.curve.residual,
                gains: GAINS.map(|gain| (height_of(gain), format!("×{gain:.0}"))),
                waves: WAVES.map(|wave| (share_of_axis(wave), format!("{:.0} %", 100.0 * wave))),
            }
        });
        Ok(serde_json::to_string(&plot)?)
    }

    /// The height of the curve at a place.
    pub fn scale_height(&self, x: f64) -> f64 {
        self.chosen().map_or(0.0, |(_, layer)| height_of(layer.curve.at(wave_at(x))))
    }

    /// The gain there, in words.
    pub fn scale_words(&self, x: f64) -> String {
        let words = |(_, layer): (LayerId, &Layer)| gain_in_words([wave_at(x), layer.curve.at(wave_at(x))]);
        self.chosen().map(words).unwrap_or_default()
    }

    /// Draws from one place to another, as part of a drag, or begins at one; false where they are too near to each other,
    /// and the stroke goes on from the first.
    ///
    /// # Errors
    /// Bugs only.
    pub fn draw_scale(&mut self, from: Option<Vec<f64>>, x: f64, y: f64) -> Result<bool, JsError> {
        let last = match from.as_deref() {
            Some(&[x, y]) => Some([wave_at(x), gain_at(y)]),
            _ => None,
        };
        let mut drawn = false;
        self.change_curve(|curve| drawn = draw_freely(curve, last, [wave_at(x), gain_at(y)]))?;
        Ok(drawn)
    }

    /// Puts a point of the curve at a place, as part of a drag.
    ///
    /// # Errors
    /// Bugs only.
    pub fn put_scale_point(&mut self, x: f64, y: f64) -> Result<(), JsError> {
        Ok(self.change_curve(|curve| {
            curve.set_point(wave_at(x), gain_at(y));
        })?)
    }

    /// The gain of all that is finer than the harmonics, as part of a drag.
    ///
    /// # Errors
    /// A gain that is too large.
    pub fn set_residual(&mut self, gain: f64) -> Result<(), JsError> {
        Ok(self.change_curve(|curve| curve.residual = gain)?)
    }
}

impl Sitting {
    fn chosen(&self) -> Option<(LayerId, &Layer)> {
        let id = self.selected?;
        Some((id, self.history.project().layer(id)?))
    }

    fn change_curve(&mut self, change: impl FnOnce(&mut ScaleCurve)) -> Result<(), Error> {
        let Some((layer, mut curve)) = self.chosen().map(|(id, layer)| (id, layer.curve.clone())) else {
            return Ok(());
        };
        let before = curve.clone();
        change(&mut curve);
        if curve == before {
            return Ok(());
        }
        let surface = self.stack.surface().clone();
        self.history.apply_live(&Action::Set { layer, to: Property::Curve(curve) }, Some(&surface))?;
        self.refresh()
    }
}
