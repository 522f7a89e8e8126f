//! The two curves of a dance; those of the one on stage are drawn by hand.

use chladni_music::{Action, Mapping, direct_transfer};
use chladni_program::work::drawn_curve;
use wasm_bindgen::prelude::*;

use super::Concert;

#[wasm_bindgen]
impl Concert {
    /// The place in the gallery of the dance on stage, which beats may change; none where none of the gallery is there.
    pub fn staged(&self) -> Option<usize> {
        let scene = self.instrument.scene(self.beat_at(self.clock.at_secs()))?;
        self.instrument.gallery().items().iter().position(|item| item.id == scene.to)
    }

    /// t of a dance of the gallery: from the lowest band of the sound to the highest, which harmonic each drives, from 0
    /// for the first to 1 for the last.
    ///
    /// # Errors
    /// A dance that is not there.
    pub fn transfer(&self, item: usize) -> Result<Vec<f32>, JsError> {
        Ok(self.mapping(item)?.transfer.clone())
    }

    /// a of a dance of the gallery: how strongly each harmonic answers, in [−1, 1].
    ///
    /// # Errors
    /// A dance that is not there.
    pub fn amplification(&self, item: usize) -> Result<Vec<f32>, JsError> {
        Ok(self.mapping(item)?.amplification.clone())
    }

    /// Gives a dance a ready-made curve, to begin from: `direct` (low sounds to low harmonics), `reversed`, `rest` (no
    /// harmonic answers), or `opposite` (what shrinks grows).
    ///
    /// # Errors
    /// A name that none has, and a dance that is not there.
    pub fn begin_curve(&mut self, item: usize, name: &str) -> Result<(), JsError> {
        let mapping = self.mapping(item)?;
        let transfer = |transfer| Action::SetTransfer { item, transfer };
        let amplification = |amplification| Action::SetAmplification { item, amplification };
        let action = match name {
            "direct" => {
                let eigenvalues = &self.instrument.shape().eigenvalues;
                transfer(direct_transfer(eigenvalues, mapping.transfer.len(), 1.0, false))
            }
            "reversed" => transfer(mapping.transfer.iter().map(|t| 1.0 - t).collect()),
            "rest" => amplification(vec![0.0; mapping.amplification.len()]),
            "opposite" => amplification(mapping.amplification.iter().map(|a| -a).collect()),
            _ => return Err(JsError::new("there is no such curve")),
        };
        Ok(self.act(action)?)
    }
}

impl Concert {
    fn mapping(&self, item: usize) -> Result<&Mapping, JsError> {
        let found = self.instrument.gallery().items().get(item);
        Ok(&found.ok_or_else(|| JsError::new("there is no such dance"))?.genome)
    }
}

/// The values of a curve between `low` and `high` after a stroke from one point to another: x in [0, 1], y a value.
#[wasm_bindgen]
pub fn draw_curve(
    mut values: Vec<f32>,
    low: f32,
    high: f32,
    from_x: f32,
    from_y: f32,
    to_x: f32,
    to_y: f32,
) -> Vec<f32> {
    drawn_curve::draw(&mut values, (low, high), [from_x, from_y], [to_x, to_y]);
    values
}

/// The values of a curve between `low` and `high` whose part of this `width` around `middle` gets a height; the two in
/// [0, 1], the height a value.
#[wasm_bindgen]
pub fn draw_step(
    mut values: Vec<f32>,
    low: f32,
    high: f32,
    middle: f32,
    width: f32,
    height: f32,
) -> Vec<f32> {
    drawn_curve::draw_step(&mut values, (low, high), middle, width, height);
    values
}

/// The same curve, smoother.
#[wasm_bindgen]
pub fn smooth_curve(mut values: Vec<f32>) -> Vec<f32> {
    drawn_curve::smooth(&mut values);
    values
}
