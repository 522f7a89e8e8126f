//! Heat maps of numbers on the figure, and the viewpoint of a drawing in ink.

use std::sync::Arc;

use chladni_caricature::{Base, Crossings};
use chladni_program::work::{Coating, Error, Quantity, Seen, coating};
use chladni_task::Task;
use chladni_view::ColorMap;
use serde::Serialize;
use wasm_bindgen::prelude::*;

use super::Sitting;
use crate::ink::Viewer;

/// Colors of a legend.
const LEGEND: usize = 16;

/// The user's choice of a heat map.
pub struct Heat {
    quantity: Quantity,
    harmonic: usize,
    map: ColorMap,
    /// Triangles that cross, and the shape in which they were looked for.
    crossings: Option<(Arc<Base>, Vec<u32>)>,
}

impl Heat {
    /// The first heat map of a shape with or without colors of its own.
    pub fn of(own_look: bool) -> Self {
        let quantity = if own_look { Quantity::Own } else { Quantity::None };
        Self { quantity, harmonic: 1, map: ColorMap::Viridis, crossings: None }
    }

    /// The shape is shown as it looks.
    pub fn is_off(&self) -> bool {
        matches!(self.quantity, Quantity::None | Quantity::Own)
    }
}

/// The state of a heat map that the page shows beside the picture.
#[derive(Serialize)]
pub struct ShownHeat {
    /// By its number among [`quantities`].
    quantity: Option<usize>,
    harmonic: usize,
    map: &'static str,
    legend: Option<Legend>,
}

#[derive(Serialize)]
struct Legend {
    low: f32,
    high: f32,
    /// From `low` to `high`.
    colors: Vec<[u8; 3]>,
    ticks: Vec<f32>,
}

/// The names of all quantities that a heat map can show, as JSON.
///
/// # Errors
/// Bugs only.
#[wasm_bindgen]
pub fn quantities() -> Result<String, JsError> {
    Ok(serde_json::to_string(&Quantity::ALL.map(|(_, name)| name))?)
}

/// The names of the color maps for magnitudes, as JSON.
///
/// # Errors
/// Bugs only.
#[wasm_bindgen]
pub fn color_maps() -> Result<String, JsError> {
    let maps = ColorMap::ALL.into_iter().filter(|map| *map != ColorMap::BlueRed);
    Ok(serde_json::to_string(&maps.map(ColorMap::name).collect::<Vec<_>>())?)
}

#[wasm_bindgen]
impl Sitting {
    /// Shows a quantity by its number among [`quantities`]: that `harmonic`, where it is one; magnitudes by the color map
    /// of this name.
    ///
    /// # Errors
    /// A number or a name that none has.
    pub fn show_heat(&mut self, quantity: usize, harmonic: usize, map: &str) -> Result<(), JsError> {
        let (quantity, _) =
            Quantity::ALL.get(quantity).ok_or_else(|| JsError::new("there is no such quantity"))?;
        let map = ColorMap::ALL.into_iter().find(|known| known.name() == map);
        self.heat.quantity = *quantity;
        self.heat.map = map.ok_or_else(|| JsError::new("there is no such color map"))?;
        self.heat.harmonic = harmonic.min(self.stack.body().basis.harmonics().saturating_sub(1));
        Ok(self.recoat()?)
    }

    /// From where the picture of this size is seen, as JSON, for [`Inker`](crate::Inker).
    ///
    /// # Errors
    /// A picture without pixels or too large.
    pub fn viewer(&mut self, width: u32, height: u32) -> Result<String, JsError> {
        self.stage.frame(width, height)?;
        Ok(serde_json::to_string(&Viewer::from(self.stage.camera))?)
    }

    /// The same for a picture that is saved.
    ///
    /// # Errors
    /// Bugs only.
    pub fn viewer_of_export(&mut self, width: u32, height: u32) -> Result<String, JsError> {
        self.settle()?;
        Ok(serde_json::to_string(&Viewer::from(self.stage.held(width, height)))?)
    }

    /// The next picture is drawn, even if nothing changes.
    pub fn redraw(&mut self) {
        self.stage.stir();
    }

    /// How often the figure has changed.
    pub fn pose(&self) -> f64 {
        self.stage.changes() as f64
    }

    /// The coordinates of the figure's vertices.
    pub fn positions(&self) -> Vec<f32> {
        self.stage.positions().as_flattened().to_vec()
    }

    /// The corners of its triangles.
    pub fn corners(&self) -> Vec<u32> {
        self.stage.triangles().as_flattened().to_vec()
    }
}

impl Sitting {
    /// The figure's color by the chosen heat map.
    pub(super) fn heated(&mut self) -> Result<Coating, Error> {
        let quantity = self.heat.quantity;
        let folds: Vec<u32> = match quantity {
            Quantity::Folds => {
                let surface = self.stack.surface();
                self.evaluation.layers.iter().flat_map(|layer| layer.folded_triangles(surface)).collect()
            }
            _ => Vec::new(),
        };
        if quantity == Quantity::Crossings {
            self.find_crossings()?;
        }
        let seen = Seen {
            project: self.history.project(),
            stack: &self.stack,
            evaluation: &self.evaluation,
            selected: self.selected,
            folds: &folds,
            crossings: self.heat.crossings.as_ref().map_or(&[], |(_, found)| found),
        };
        let own = if quantity == Quantity::Own { Coating::Own } else { Coating::Material };
        Ok(coating(quantity, self.heat.harmonic, self.heat.map, &seen).unwrap_or(own))
    }

    pub(super) fn shown_heat(&self) -> ShownHeat {
        let Heat { quantity, harmonic, map, .. } = &self.heat;
        let legend = self.stage.scale().map(|scale| {
            let at = |i: usize| scale.low + (scale.high - scale.low) * i as f32 / (LEGEND - 1) as f32;
            let colors = (0..LEGEND).map(|i| scale.color(at(i))).collect();
            Legend { low: scale.low, high: scale.high, colors, ticks: scale.ticks(4) }
        });
        let quantity = Quantity::ALL.iter().position(|(known, _)| known == quantity);
        ShownHeat { quantity, harmonic: *harmonic, map: map.name(), legend }
    }

    fn find_crossings(&mut self) -> Result<(), Error> {
        let result = &self.evaluation.result;
        if self.heat.crossings.as_ref().is_none_or(|(searched, _)| !Arc::ptr_eq(searched, result)) {
            let tree = Crossings::of(self.stack.surface().clone());
            let found = tree.triangles(&result.positions, &Task::new())?;
            self.heat.crossings = Some((Arc::clone(result), found));
        }
        Ok(())
    }
}
