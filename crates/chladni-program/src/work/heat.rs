//! Heat maps: a quantity of the caricature for each vertex.

use chladni_caricature::{EvaluatedLayer, Evaluation, LayerId, MatchRequest, Matched, Project, Stack};
use chladni_view::{ColorMap, Scale, srgb_bytes};

use super::place_colors;

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
    /// The region as it acts, smoothed; as it was painted where its layer does not act.
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

/// The source of a shape's color.
#[derive(Clone, Debug)]
pub enum Coating {
    /// The material alone.
    Material,
    /// The colors that the shape brought along.
    Own,
    /// A heat map.
    Values(Vec<f32>, Scale),
    /// A region on the material: 0 is bare, 1 is painted.
    Region(Vec<f32>),
    /// Places on the material to look at: 0 is bare, 1 is marked.
    Marks(Vec<f32>),
    /// A color for each vertex, sRGB.
    Colors(Vec<[u8; 4]>),
}

/// The data from which quantities are computed.
#[derive(Clone, Copy)]
pub struct Seen<'a> {
    /// The document.
    pub project: &'a Project,
    /// The stack that evaluates it.
    pub stack: &'a Stack,
    /// Its result.
    pub evaluation: &'a Evaluation,
    /// The layer that quantities of one layer belong to.
    pub selected: Option<LayerId>,
    /// Triangles that any layer turned over.
    pub folds: &'a [u32],
    /// Triangles that pass through others.
    pub crossings: &'a [u32],
}

impl Seen<'_> {
    fn layer(&self) -> Option<&EvaluatedLayer> {
        self.evaluation.layers.iter().find(|layer| Some(layer.id) == self.selected)
    }

    fn matched(&self) -> Option<&Matched> {
        let layer = self.project.layer(self.selected?)?;
        self.stack.matched(&MatchRequest::of(layer)?).map(|matched| &**matched)
    }
}

/// A quantity as a shape shows it, magnitudes by `map`; `None` where the shape is shown as it looks, or there is no such
/// quantity yet.
pub fn coating(quantity: Quantity, harmonic: usize, map: ColorMap, seen: &Seen<'_>) -> Option<Coating> {
    let length = |d: &[f64; 3]| (d[0].hypot(d[1]).hypot(d[2])) as f32;
    let body = seen.stack.body();
    // A region that was painted on another mesh lies nowhere on this one.
    let region = |values: &[f32]| (values.len() == body.positions.len()).then(|| values.to_vec());
    let unit = Scale { map, low: 0.0, high: 1.0 };
    let scaled = |map: ColorMap, values: Vec<f32>| {
        let scale = Scale::of(map, &values);
        Coating::Values(values, scale)
    };
    Some(match quantity {
        Quantity::None | Quantity::Own => return None,
        Quantity::Displacement => scaled(map, seen.evaluation.displacement().iter().map(length).collect()),
        Quantity::Difference => {
            let difference = seen.layer()?.difference.as_ref()?;
            let pairs = difference.base.positions.iter().zip(&difference.target.points);
            let apart = pairs.map(|(x, r)| length(&std::array::from_fn(|i| r[i] - x[i])));
            scaled(map, apart.collect())
        }
        Quantity::Painted => {
            let layer = seen.project.layer(seen.selected?)?;
            let values = layer.region.painted.values(&seen.stack.surface().file_positions());
            Coating::Region(region(&values)?)
        }
        Quantity::Region => {
            let painted = &seen.project.layer(seen.selected?)?.region.painted;
            // A layer that does not act has none: as it was painted.
            let mask = seen.layer()?.mask.clone();
            let mask = mask.unwrap_or_else(|| painted.values(&seen.stack.surface().file_positions()));
            Coating::Region(region(&mask)?)
        }
        Quantity::Confidence => {
            let confidence = seen.matched()?.confidence.iter().map(|confidence| *confidence as f32);
            Coating::Values(body.on_operator_vertices(confidence, 0.0), unit)
        }
        Quantity::Folds => Coating::Marks(marked(&body.triangles, seen.folds, body.positions.len())),
        Quantity::Crossings => Coating::Marks(marked(&body.triangles, seen.crossings, body.positions.len())),
        Quantity::HeldBack => {
            let layer = seen.layer()?;
            let pairs = layer.displacement.as_ref()?.iter().zip(layer.unlimited.as_ref()?.iter());
            let held = pairs.map(|(kept, asked)| match length(asked) {
                0.0 => 0.0,
                asked => (1.0 - length(kept) / asked).clamp(0.0, 1.0),
            });
            Coating::Values(held.collect(), unit)
        }
        Quantity::Harmonic => {
            let last = body.basis.harmonics().checked_sub(1)?;
            let harmonic = body.basis.harmonic(harmonic.min(last));
            scaled(ColorMap::BlueRed, harmonic.iter().map(|h| *h as f32).collect())
        }
        Quantity::Place => {
            let colors = place_colors(&seen.stack.original().positions);
            Coating::Colors(colors.into_iter().map(srgb_bytes).collect())
        }
    })
}

/// 1 at the corners of `some` of the triangles, less on two rings around them, so that single triangles of a
/// fine mesh are visible, and 0 elsewhere.
fn marked(triangles: &[[u32; 3]], some: &[u32], vertices: usize) -> Vec<f32> {
    let mut values = vec![0.0_f32; vertices];
    for corner in some.iter().filter_map(|triangle| triangles.get(*triangle as usize)).flatten() {
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

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;

    use chladni_caricature::{Layer, Painted, ShapeSource, Template};
    use chladni_harmonics::{BasisSettings, Body};
    use chladni_task::Task;

    #[test]
    fn the_region_of_a_layer_that_is_off_is_as_it_was_painted() {
        let mesh = chladni_mesh::samples::icosphere(2);
        let body = Arc::new(Body::build(&mesh, &BasisSettings::new(16), &Task::new()).unwrap());
        let half: Arc<[f32]> = (0..body.positions.len()).map(|v| (v % 2) as f32).collect();
        let mut stack = Stack::new(body).unwrap();
        let mut layer = Layer { enabled: false, ..Layer::new("off", Template::Sphere) };
        layer.region.painted = Painted::Vertices(half.clone());
        let mut project = Project::new(ShapeSource::Sample("ball".into()), 16);
        let id = project.push(layer).unwrap();
        let evaluation = stack.evaluate(&project);
        let seen = Seen {
            project: &project,
            stack: &stack,
            evaluation: &evaluation,
            selected: Some(id),
            folds: &[],
            crossings: &[],
        };
        let region = coating(Quantity::Region, 0, ColorMap::Viridis, &seen);
        assert!(matches!(region, Some(Coating::Region(values)) if values == half.to_vec()));
    }

    #[test]
    fn a_region_of_another_mesh_is_not_shown() {
        let mesh = chladni_mesh::samples::icosphere(2);
        let body = Arc::new(Body::build(&mesh, &BasisSettings::new(16), &Task::new()).unwrap());
        let mut layer = Layer::new("of another", Template::Sphere);
        layer.region.painted = Painted::Vertices(vec![0.5; body.positions.len() + 1].into());
        let mut stack = Stack::new(body).unwrap();
        let mut project = Project::new(ShapeSource::Sample("ball".into()), 16);
        let selected = Some(project.push(layer).unwrap());
        let evaluation = &stack.evaluate(&project);
        let (project, stack) = (&project, &stack);
        let seen = Seen { project, stack, evaluation, selected, folds: &[], crossings: &[] };
        for quantity in [Quantity::Painted, Quantity::Region] {
            assert!(coating(quantity, 0, ColorMap::Viridis, &seen).is_none(), "{quantity:?}");
        }
    }
}
