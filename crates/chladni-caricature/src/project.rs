//! The document: a shape and its stack of layers, and the actions that change it.

use std::path::Path;
use std::sync::Arc;

use chladni_harmonics::Laplacian;
use chladni_match::{MatchSettings, Method};
use chladni_mesh::Orientation;
use serde::{Deserialize, Serialize};

use crate::runs::MOST_VALUES;
use crate::{
    CaricatureError, Layer, LayerId, Model, PaintEdit, Resolution, ScaleCurve, ShapeSource, Smoothing,
    Surface, Template,
};

/// K of a project that names none.
pub const DEFAULT_HARMONICS: usize = 512;

/// The content of a project file: which shape, how many harmonics of which Laplacian, which layers. Cloning shares
/// the layers.
#[derive(Clone, Debug, PartialEq)]
pub struct Project {
    /// Where the shape comes from.
    pub shape: ShapeSource,
    /// K, the number of harmonics to solve for.
    pub harmonics: usize,
    /// The format of the file that it was read from, if an older one.
    pub(crate) older_format: Option<i64>,
    /// How finely the shape is worked on.
    pub resolution: Resolution,
    /// How the shape stands in pictures; `None` is estimated.
    pub stands: Option<Orientation>,
    /// The operator whose harmonics they are. New layers of a project with the papers' own have the
    /// papers' settings.
    pub laplacian: Laplacian,
    /// Whether layers are limited where they would fold the surface or pass it through itself.
    pub keep_triangles: bool,
    layers: Vec<(LayerId, Arc<Layer>)>,
    next_id: u64,
}

/// Everything a user can do to a project. Ids of layers are given out in order, so that a
/// recorded list of actions replays to the same project.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Action {
    /// Puts a layer at `index` of the stack (0 is the lowest).
    Add {
        /// Where, at most the number of layers.
        index: usize,
        /// The new layer.
        layer: Box<Layer>,
    },
    /// Takes a layer away.
    Remove(LayerId),
    /// Puts a copy directly above a layer.
    Duplicate(LayerId),
    /// Moves a layer to `index` of the stack.
    Move {
        /// The layer.
        layer: LayerId,
        /// Its new place; beyond the top is the top.
        index: usize,
    },
    /// Changes one property of a layer.
    Set {
        /// The layer.
        layer: LayerId,
        /// The property and its new value.
        to: Property,
    },
    /// Paints the region of a layer.
    Paint {
        /// The layer.
        layer: LayerId,
        /// The change that the brush made.
        edit: PaintEdit,
    },
    /// Changes the number of harmonics; the basis has to be solved again.
    SetHarmonics(usize),
    /// Says how the shape stands in pictures; `None` leaves it to the estimate.
    Stand(Option<Orientation>),
    /// Changes the operator; the basis has to be solved again.
    SetLaplacian(Laplacian),
    /// Says whether layers are limited where they would fold the surface.
    KeepTriangles(bool),
}

/// A property of a layer with its new value.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Property {
    /// Its name.
    Name(String),
    /// Its template.
    Template(Template),
    /// How the template is matched, landmarks included.
    Matching(MatchSettings),
    /// How far doubtful places are filled in.
    Infill(f64),
    /// Its model; μ is reduced to the new model's usual range.
    Model(Model),
    /// μ.
    Mu(f64),
    /// The factor on μ.
    Strength(f64),
    /// How the region is smoothed.
    Smoothing(Smoothing),
    /// Φ.
    Curve(ScaleCurve),
    /// Whether it acts.
    Enabled(bool),
    /// Whether only it and other soloed layers act.
    Solo(bool),
}

impl Project {
    /// A project without layers.
    pub fn new(shape: ShapeSource, harmonics: usize) -> Self {
        Self {
            shape,
            harmonics,
            laplacian: Laplacian::default(),
            keep_triangles: false,
            older_format: None,
            resolution: Resolution::Usual,
            stands: None,
            layers: Vec::new(),
            next_id: 1,
        }
    }

    /// A message to the user about a project that was read from an older format.
    pub fn taken_over(&self) -> Option<String> {
        let format = self.older_format?;
        Some(format!(
            "a project of format {format}: its curves and soft edges are wavelengths now, and heat softens what a \
             Gaussian did, so that the shape may differ a little"
        ))
    }

    /// The layers with their ids, lowest first.
    pub fn layers(&self) -> &[(LayerId, Arc<Layer>)] {
        &self.layers
    }

    /// The files that it is made of: of its shape and of its layers' templates.
    pub fn files(&self) -> Vec<&Path> {
        let templates = self.layers.iter().filter_map(|(_, layer)| layer.template.file());
        self.shape.file().into_iter().chain(templates).collect()
    }

    /// The layer called `id`.
    pub fn layer(&self, id: LayerId) -> Option<&Arc<Layer>> {
        self.layers.iter().find(|(i, _)| *i == id).map(|(_, l)| l)
    }

    /// The number of a layer, counted from the lowest, 1: its name where ids mean nothing, as in files.
    pub fn number(&self, id: LayerId) -> Option<usize> {
        self.layers.iter().position(|(i, _)| *i == id).map(|place| place + 1)
    }

    /// Whether a layer acts: it is enabled, and soloed where any layer is.
    pub fn acts(&self, layer: &Layer) -> bool {
        layer.enabled && (layer.solo || !self.layers.iter().any(|(_, l)| l.solo))
    }

    /// The layers that [act](Self::acts).
    pub fn acting(&self) -> impl Iterator<Item = &Layer> {
        self.layers.iter().map(|(_, layer)| &**layer).filter(|layer| self.acts(layer))
    }

    /// Whether any layer names vertices of the shape by number: in a painted region or by landmarks.
    pub fn names_vertices(&self) -> bool {
        self.layers.iter().any(|(_, layer)| layer.names_vertices())
    }

    /// Whether any layer names vertices or places of the shape. Without one, nothing has to be
    /// [`carried`](Self::carried) to another shape.
    pub fn names_places(&self) -> bool {
        self.layers.iter().any(|(_, layer)| layer.names_places())
    }

    /// The id that the next new layer gets.
    pub fn next_id(&self) -> LayerId {
        LayerId(self.next_id)
    }

    /// A layer with this project's default settings: the paper's in a project with the paper's Laplacian, and
    /// the [`usual_curve`](Self::usual_curve).
    pub fn new_layer(&self, name: impl Into<String>, template: Template) -> Layer {
        let layer = match self.laplacian {
            Laplacian::Cotangent => Layer::paper(name, template),
            Laplacian::Delaunay => Layer::new(name, template),
        };
        let curve = self.usual_curve(&layer.template, layer.matching.method, layer.mu);
        Layer { curve, ..layer }
    }

    /// The default scale curve: all scales alike, but without the finest where a matched template mesh is
    /// exaggerated (μ < 0), because the match is rough there. In a project with the paper's Laplacian, all
    /// scales alike.
    pub fn usual_curve(&self, template: &Template, method: Method, mu: f64) -> ScaleCurve {
        let rough = template.is_mesh() && method != Method::Same && mu < 0.0;
        match self.laplacian {
            Laplacian::Delaunay if rough => ScaleCurve::smooth(),
            Laplacian::Delaunay | Laplacian::Cotangent => ScaleCurve::flat(1.0),
        }
    }

    /// Adds a layer on top and returns its id.
    ///
    /// # Errors
    /// As [`Layer::validate`], and a template that is the result of a layer which is not there.
    pub fn push(&mut self, layer: Layer) -> Result<LayerId, CaricatureError> {
        let id = self.next_id();
        self.apply(&Action::Add { index: self.layers.len(), layer: Box::new(layer) }, None)?;
        Ok(id)
    }

    fn insert(&mut self, index: usize, layer: Arc<Layer>) -> LayerId {
        let id = LayerId(self.next_id);
        self.next_id += 1;
        self.layers.insert(index.min(self.layers.len()), (id, layer));
        id
    }

    fn index(&self, id: LayerId) -> Result<usize, CaricatureError> {
        self.layers.iter().position(|(i, _)| *i == id).ok_or(CaricatureError::NoLayer(id.0))
    }

    /// Applies `action`. Painting needs the `surface` of the shape. On an error nothing has changed.
    ///
    /// # Errors
    /// A missing layer, a number out of range, painting without a `surface` or on another one, a template that is
    /// the result of a layer not below the one that uses it, or more painted values than a file may hold.
    pub fn apply(&mut self, action: &Action, surface: Option<&Surface>) -> Result<(), CaricatureError> {
        let mut changed = self.clone();
        changed.act(action, surface)?;
        if let Some((layer, of)) = changed.not_below() {
            let of = self.layer(of).map_or_else(|| of.0.to_string(), |below| below.name.clone());
            return Err(CaricatureError::NotBelow { layer: layer.name.clone(), of });
        }
        // Work that could not be saved is not begun.
        let stored = changed.stored_values();
        if stored > MOST_VALUES && stored > self.stored_values() {
            return Err(CaricatureError::Range {
                what: "the number of painted values of all layers",
                value: stored as f64,
                range: "2²⁶ (67,108,864) or less to be saved: set a region to Everywhere, or delete a layer",
            });
        }
        *self = changed;
        Ok(())
    }

    /// How many painted values its file holds.
    pub(crate) fn stored_values(&self) -> usize {
        self.layers.iter().map(|(_, layer)| layer.region.painted.stored_values()).sum()
    }

    /// The first layer whose template is the result of one that is not below it, and that one.
    fn not_below(&self) -> Option<(&Layer, LayerId)> {
        self.layers.iter().enumerate().find_map(|(place, (_, layer))| match layer.template {
            Template::Layer(of) if self.layers[..place].iter().all(|(below, _)| *below != of) => {
                Some((&**layer, of))
            }
            _ => None,
        })
    }

    fn act(&mut self, action: &Action, surface: Option<&Surface>) -> Result<(), CaricatureError> {
        match action {
            Action::Add { index, layer } => {
                layer.validate()?;
                self.insert(*index, Arc::new(Layer::clone(layer)));
            }
            Action::Remove(id) => {
                let index = self.index(*id)?;
                self.layers.remove(index);
            }
            Action::Duplicate(id) => {
                let index = self.index(*id)?;
                let mut copy = Layer::clone(&self.layers[index].1);
                copy.name.push_str(" copy");
                self.insert(index + 1, Arc::new(copy));
            }
            Action::Move { layer, index } => {
                let from = self.index(*layer)?;
                let entry = self.layers.remove(from);
                self.layers.insert((*index).min(self.layers.len()), entry);
            }
            Action::Set { layer, to } => self.change(*layer, |l| to.put(l))?,
            Action::Paint { layer, edit } => {
                let surface = surface.ok_or(CaricatureError::NoSurface)?;
                self.change(*layer, |l| {
                    l.region.painted = edit.apply(&l.region.painted, surface)?;
                    Ok(())
                })?;
            }
            Action::SetHarmonics(0) => {
                return Err(CaricatureError::Range {
                    what: "the number of harmonics",
                    value: 0.0,
                    range: "1 or more",
                });
            }
            Action::SetHarmonics(harmonics) => self.harmonics = *harmonics,
            Action::Stand(stands) => self.stands = *stands,
            Action::SetLaplacian(laplacian) => self.laplacian = *laplacian,
            Action::KeepTriangles(keep) => self.keep_triangles = *keep,
        }
        Ok(())
    }

    fn change(
        &mut self,
        id: LayerId,
        put: impl FnOnce(&mut Layer) -> Result<(), CaricatureError>,
    ) -> Result<(), CaricatureError> {
        let index = self.index(id)?;
        let mut layer = Layer::clone(&self.layers[index].1);
        put(&mut layer)?;
        layer.validate()?;
        self.layers[index].1 = Arc::new(layer);
        Ok(())
    }

    /// This project with every layer replaced by what `change` makes of it, ids kept.
    pub(crate) fn map_layers(
        &self,
        change: impl Fn(&Layer) -> Result<Layer, CaricatureError>,
    ) -> Result<Self, CaricatureError> {
        let mut changed = self.clone();
        for (_, layer) in &mut changed.layers {
            *layer = Arc::new(change(layer)?);
        }
        Ok(changed)
    }
}

impl Property {
    fn put(&self, layer: &mut Layer) -> Result<(), CaricatureError> {
        match self.clone() {
            Self::Name(name) => layer.name = name,
            Self::Template(template) => {
                // Landmarks name vertices of the mesh that they were set on.
                if layer.template.loses_landmarks_to(&template) {
                    layer.matching.landmarks.clear();
                }
                layer.template = template;
            }
            Self::Matching(matching) => layer.matching = matching,
            Self::Infill(infill) => layer.infill = infill,
            Self::Model(model) if model != layer.model => {
                layer.model = model;
                layer.mu = layer.mu.max(model.strongest_usual_mu());
            }
            Self::Model(_) => {}
            Self::Mu(mu) => layer.mu = mu,
            Self::Strength(strength) => layer.strength = strength,
            Self::Smoothing(smoothing) => layer.region.smoothing = smoothing,
            Self::Curve(curve) => layer.curve = curve,
            Self::Enabled(enabled) => layer.enabled = enabled,
            Self::Solo(solo) => layer.solo = solo,
        }
        Ok(())
    }
}

impl Action {
    /// The action's name for undo and redo.
    pub fn label(&self) -> &'static str {
        match self {
            Self::Add { .. } => "add layer",
            Self::Remove(_) => "delete layer",
            Self::Duplicate(_) => "duplicate layer",
            Self::Move { .. } => "reorder layers",
            Self::Paint { edit, .. } => match edit {
                PaintEdit::Dab(dab) if dab.erase => "erase",
                PaintEdit::Dab(_) => "paint",
                PaintEdit::FillComponent { .. } => "fill component",
                PaintEdit::Smooth => "smooth region",
                PaintEdit::Grow => "grow region",
                PaintEdit::Shrink => "shrink region",
                PaintEdit::Invert => "invert region",
                PaintEdit::Clear => "clear region",
                PaintEdit::Set(_) => "set region",
            },
            Self::SetHarmonics(_) => "number of harmonics",
            Self::Stand(_) => "which way is up",
            Self::SetLaplacian(_) => "Laplacian",
            Self::KeepTriangles(_) => "keep triangles",
            Self::Set { to, .. } => match to {
                Property::Name(_) => "rename layer",
                Property::Template(_) => "template",
                Property::Matching(_) => "match",
                Property::Infill(_) => "filling in",
                Property::Model(_) => "model",
                Property::Mu(_) => "μ",
                Property::Strength(_) => "strength",
                Property::Smoothing(_) => "region smoothing",
                Property::Curve(_) => "scale curve",
                Property::Enabled(_) => "show layer",
                Property::Solo(_) => "solo layer",
            },
        }
    }

    /// The layer it changes, where it changes one.
    pub fn layer(&self) -> Option<LayerId> {
        match self {
            Self::Set { layer, .. } | Self::Paint { layer, .. } | Self::Move { layer, .. } => Some(*layer),
            Self::Remove(layer) | Self::Duplicate(layer) => Some(*layer),
            Self::Add { .. } | Self::SetHarmonics(_) | Self::SetLaplacian(_) => None,
            Self::Stand(_) | Self::KeepTriangles(_) => None,
        }
    }
}
