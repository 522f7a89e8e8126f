//! What the heat map shows, and the spectrum behind the scale curve.

use chladni_caricature::wavelengths;
use chladni_view::{ColorMap, Scale};

use super::curve::Spectrum;
use super::session::Session;
use super::stage::Coating;
use crate::work::{place_colors, with_pointed};

/// A quantity drawn on the surface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Quantity {
    /// The material alone.
    #[default]
    None,
    /// The colors that the shape brought along.
    Own,
    /// How far the result lies from the original.
    Displacement,
    /// How far the selected layer's template lies from the shape.
    Difference,
    /// The region of the selected layer as it was painted.
    Painted,
    /// The region as it acts, smoothed.
    Region,
    /// How far the match is to be trusted.
    Confidence,
    /// Triangles that any layer turned over.
    Folds,
    /// Triangles of the result that pass through others.
    Crossings,
    /// How much of the selected layer's movement is held back.
    HeldBack,
    /// One harmonic.
    Harmonic,
    /// Where each point lies on the original.
    Place,
}

impl Quantity {
    /// All of them, with their names.
    pub const ALL: [(Self, &'static str); 12] = [
        (Self::None, "Material"),
        (Self::Own, "Its own colors"),
        (Self::Displacement, "Displacement"),
        (Self::Difference, "Difference from the template"),
        (Self::Painted, "Region, as painted"),
        (Self::Region, "Region, smoothed"),
        (Self::Confidence, "Confidence of the match"),
        (Self::Folds, "Folded triangles"),
        (Self::Crossings, "Crossing triangles"),
        (Self::HeldBack, "Held back"),
        (Self::Harmonic, "A harmonic"),
        (Self::Place, "Place on the original"),
    ];
}

/// The user's choice, and whether the stage shows it already.
#[derive(Debug)]
pub struct Heat {
    quantity: Quantity,
    harmonic: usize,
    map: ColorMap,
    painting: Option<Painting>,
    /// A part of the shape under the pointer, 1 on it.
    pointed: Option<Vec<f32>>,
    stale: bool,
}

/// Which form of a region is shown while it is painted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Painting {
    /// As it was painted.
    Raw,
    /// As it acts.
    Smoothed,
}

impl Default for Heat {
    fn default() -> Self {
        Self {
            quantity: Quantity::None,
            harmonic: 1,
            map: ColorMap::Viridis,
            painting: None,
            pointed: None,
            stale: false,
        }
    }
}

impl Heat {
    /// What is shown.
    pub fn quantity(&self) -> Quantity {
        self.quantity
    }

    /// A shape was opened, with or without colors of its own.
    pub fn start(&mut self, own_look: bool) {
        self.quantity = if own_look { Quantity::Own } else { Quantity::None };
        self.stale = true;
    }

    /// The harmonic to show.
    pub fn harmonic(&self) -> usize {
        self.harmonic
    }

    /// Shows something else.
    pub fn choose(&mut self, quantity: Quantity, harmonic: usize, map: ColorMap) {
        self.stale |= (quantity, harmonic, map) != (self.quantity, self.harmonic, self.map);
        (self.quantity, self.harmonic, self.map) = (quantity, harmonic, map);
    }

    /// Shows `quantity`, or the material if it is shown already.
    pub fn toggle(&mut self, quantity: Quantity) {
        let next = if self.quantity == quantity { Quantity::None } else { quantity };
        self.choose(next, self.harmonic, self.map);
    }

    /// The color map for magnitudes.
    pub fn map(&self) -> ColorMap {
        self.map
    }

    /// Whether the choice changed since this was last asked.
    pub fn take_stale(&mut self) -> bool {
        std::mem::take(&mut self.stale)
    }

    /// While a region is painted it is shown, as painted or as it acts, unless a map was chosen.
    pub fn paint(&mut self, painting: Option<Painting>) {
        self.stale |= painting != self.painting;
        self.painting = painting;
    }

    /// While parts are pointed at, that under the pointer is shown with the region, unless a map was chosen.
    pub fn point(&mut self, pointed: Option<Vec<f32>>) {
        self.stale |= pointed != self.pointed;
        self.pointed = pointed;
    }

    /// What the stage is to be painted with.
    pub fn coating(&self, session: &Session) -> Coating {
        let shown = match self.painting.filter(|_| matches!(self.quantity, Quantity::None | Quantity::Own)) {
            Some(Painting::Raw) => Quantity::Painted,
            Some(Painting::Smoothed) => Quantity::Region,
            None => self.quantity,
        };
        if shown == Quantity::Place {
            let colors = place_colors(&session.stack.original().positions);
            let bytes = |color: [f32; 4]| color.map(|c| (c * 255.0).round() as u8);
            return Coating::Colors(colors.into_iter().map(bytes).collect());
        }
        match self.values(shown, session) {
            Some((values, _)) if matches!(shown, Quantity::Painted | Quantity::Region) => {
                let pointed = self.pointed.as_deref();
                Coating::Region(match pointed {
                    Some(pointed) => with_pointed(&values, pointed),
                    None => values,
                })
            }
            Some((values, _)) if matches!(shown, Quantity::Folds | Quantity::Crossings) => {
                Coating::Marks(values)
            }
            Some((values, scale)) => Coating::Values(values, scale),
            None if self.quantity == Quantity::Own => Coating::Own,
            None => Coating::Material,
        }
    }

    /// One value per operator vertex and their scale; `None` where the material is shown or the
    /// quantity does not exist yet.
    fn values(&self, quantity: Quantity, session: &Session) -> Option<(Vec<f32>, Scale)> {
        let length = |d: &[f64; 3]| (d[0].hypot(d[1]).hypot(d[2])) as f32;
        let body = session.stack.body();
        let unit = Scale { map: self.map, low: 0.0, high: 1.0 };
        match quantity {
            Quantity::None | Quantity::Own | Quantity::Place => None,
            Quantity::Displacement => {
                let values: Vec<f32> = session.evaluation.displacement().iter().map(length).collect();
                let scale = Scale::of(self.map, &values);
                Some((values, scale))
            }
            Quantity::Difference => {
                let difference = session.selected_layer()?.difference.as_ref()?;
                let values: Vec<f32> = difference
                    .base
                    .positions
                    .iter()
                    .zip(&difference.target.points)
                    .map(|(x, r)| length(&std::array::from_fn(|i| r[i] - x[i])))
                    .collect();
                let scale = Scale::of(self.map, &values);
                Some((values, scale))
            }
            Quantity::Painted => {
                let layer = session.project().layer(session.selected?)?;
                let values = layer.region.painted.values(&session.stack.surface().file_positions());
                Some((values.to_vec(), unit))
            }
            Quantity::Region => {
                let ones = vec![1.0; body.positions.len()];
                let mask = session.selected_layer()?.mask.as_ref().map_or(ones, |mask| mask.to_vec());
                Some((mask, unit))
            }
            Quantity::Confidence => {
                let confidence = &session.selected_match()?.confidence;
                let mut values = vec![0.0; body.positions.len()];
                for (vertex, confidence) in body.operator_vertex.iter().zip(confidence) {
                    if let Some(vertex) = vertex {
                        values[*vertex as usize] = *confidence as f32;
                    }
                }
                Some((values, unit))
            }
            Quantity::Folds => {
                let folded = session.folds.iter().flatten().copied();
                Some((marked(&body.triangles, folded, body.positions.len()), unit))
            }
            Quantity::Crossings => {
                let crossing = session.crossings.triangles().iter().copied();
                Some((marked(&body.triangles, crossing, body.positions.len()), unit))
            }
            Quantity::HeldBack => {
                let layer = session.selected_layer()?;
                let pairs = layer.displacement.as_ref()?.iter().zip(layer.unlimited.as_ref()?.iter());
                let held = pairs.map(|(kept, asked)| match length(asked) {
                    0.0 => 0.0,
                    asked => (1.0 - length(kept) / asked).clamp(0.0, 1.0),
                });
                Some((held.collect(), unit))
            }
            Quantity::Harmonic => {
                let k = self.harmonic.min(body.basis.harmonics().saturating_sub(1));
                let values: Vec<f32> = body.basis.harmonic(k).iter().map(|h| *h as f32).collect();
                let scale = Scale::of(ColorMap::BlueRed, &values);
                Some((values, scale))
            }
        }
    }
}

/// 1 at the corners of `some` of the triangles, less on two rings around them, so that single triangles of a
/// fine mesh are visible, and 0 elsewhere.
fn marked(triangles: &[[u32; 3]], some: impl Iterator<Item = u32>, vertices: usize) -> Vec<f32> {
    let mut values = vec![0.0_f32; vertices];
    for corner in some.filter_map(|triangle| triangles.get(triangle as usize)).flatten() {
        values[*corner as usize] = 1.0;
    }
    for (known, next) in [(1.0, 0.7), (0.7, 0.4)] {
        let around = triangles.iter().filter(|t| t.iter().any(|v| values[*v as usize] >= known));
        let corners: Vec<u32> = around.flatten().copied().collect();
        for corner in corners {
            let value = &mut values[corner as usize];
            *value = value.max(next);
        }
    }
    values
}

/// What the model of the selected layer exaggerates, over wavelength.
pub fn spectrum(session: &Session) -> Spectrum {
    let layer = session.selected.and_then(|id| session.project().layer(id));
    let difference = session.selected_layer().and_then(|layer| layer.difference.as_ref());
    let (Some(layer), Some(difference)) = (layer, difference) else { return Spectrum::default() };
    let bars = difference.amplitudes(layer.model);
    let waves = wavelengths(&session.stack.body().basis).into_iter().zip(bars.harmonics);
    Spectrum { waves: waves.map(|(wave, amplitude)| [wave, amplitude]).collect(), residual: bars.residual }
}
