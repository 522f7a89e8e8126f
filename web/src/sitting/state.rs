//! The state of a sitting that the page shows beside its picture.

use chladni_caricature::{Layer, LayerId, LayerState, Model, Painted, ScaleCurve, Smoothing};
use chladni_match::{Landmark, Method, Scaling};
use chladni_mesh::Axis;
use chladni_program::work::landmarks::HALF_A_LANDMARK;
use chladni_program::work::{STARTING_POINTS, results, template_name, template_text};
use serde::Serialize;
use wasm_bindgen::prelude::*;

use super::Sitting;
use super::landmarks::Landmarks;
use super::matches::head_sliders_of;
use super::seeing::ShownHeat;

/// The scale curves that have names.
const CURVES: [&str; 5] = ["flat", "smooth", "broad", "mid", "fine"];

#[derive(Serialize)]
struct ShownLayer<'a> {
    id: LayerId,
    name: &'a str,
    template: String,
    /// The text in which its numbers are edited, where it needs neither a mesh nor another layer.
    template_text: Option<String>,
    model: Model,
    mu: f64,
    /// The strongest exaggeration that its slider offers.
    least_mu: f64,
    strength: f64,
    enabled: bool,
    solo: bool,
    /// A named curve, or `""`.
    curve: &'static str,
    everywhere: bool,
    /// Names of the parts that its region holds.
    parts: Vec<&'a str>,
    smoothing: Smoothing,
    /// `acts`, `off`, `waiting` or `failed`.
    state: &'static str,
    why: Option<&'a str>,
    /// Triangles that it turns over.
    folds: usize,
    /// The share of the shape that its match covers.
    coverage: Option<f64>,
    /// The median distance to its template that its match leaves, a share of the shape's diagonal.
    residual: Option<f64>,
    /// Triangles that its match turns over, and those that it stretches strongly.
    flipped: usize,
    stretched: usize,
    warnings: Vec<String>,
    /// It is compared with a mesh, on which landmarks can be picked.
    has_mesh: bool,
    /// How it is matched with that, whether its size is fitted, and how far places without trust are filled in.
    method: Method,
    fits_size: bool,
    infill: f64,
    /// The share of the shape where the match is not trusted; none where there is nothing to fill in.
    untrusted: Option<f64>,
    /// The sliders of its template, where that is a head of our own.
    head: Option<Vec<f64>>,
    landmarks: Vec<Landmark>,
}

#[derive(Serialize)]
struct State<'a> {
    shape: String,
    /// The file's vertices.
    vertices: usize,
    harmonics: usize,
    /// As many as the project asks for.
    wanted_harmonics: usize,
    solved: bool,
    layers: Vec<ShownLayer<'a>>,
    /// Layers whose results a new one can be compared with, by their names.
    results: Vec<(LayerId, &'a str)>,
    selected: Option<LayerId>,
    undo: Option<&'static str>,
    redo: Option<&'static str>,
    modified: bool,
    keep_triangles: bool,
    /// The axis that is said to point up, or `""`.
    up: String,
    /// Nobody has said which way is up, and the surface does not tell.
    up_in_doubt: bool,
    bare: bool,
    /// The three models of the chosen layer and the original are shown.
    in_models: bool,
    parts: &'a [String],
    /// The level at which parts were looked for; none of those of a head.
    level: Option<f64>,
    /// Names of the parts under the pointer.
    pointed: Vec<&'a str>,
    yaw_rad: f32,
    distance: f32,
    heat: ShownHeat,
    /// The shape has colors of its own.
    own_look: bool,
    /// The hint at the next step, while landmarks are picked.
    hint: Option<String>,
}

#[wasm_bindgen]
impl Sitting {
    /// All that controls show, as JSON.
    ///
    /// # Errors
    /// Bugs only.
    pub fn state(&self) -> Result<String, JsError> {
        let project = self.history.project();
        let up = project.stands.and_then(|stands| Axis::of(stands.up()));
        let is_half = self.landmarks.as_ref().is_some_and(Landmarks::has_pending);
        let state = State {
            shape: project.shape.to_string(),
            vertices: self.mesh.positions.len(),
            harmonics: self.stack.body().basis.harmonics(),
            wanted_harmonics: project.harmonics,
            solved: self.solved,
            layers: project.layers().iter().map(|(id, layer)| self.shown(*id, layer)).collect(),
            results: results(project).iter().map(|(id, layer)| (*id, layer.name.as_str())).collect(),
            selected: self.selected,
            undo: if is_half { Some(HALF_A_LANDMARK) } else { self.history.undo_label() },
            redo: self.history.redo_label(),
            modified: self.history.is_modified(),
            keep_triangles: project.keep_triangles,
            up: up.map_or_else(String::new, |axis| axis.to_string()),
            up_in_doubt: project.stands.is_none() && self.stands.in_doubt,
            bare: self.bare,
            in_models: self.in_models,
            parts: &self.parts.names,
            level: self.parts.level,
            pointed: self.names(&self.tool.pointed),
            yaw_rad: self.stage.camera.yaw_rad,
            distance: self.stage.camera.distance,
            heat: self.shown_heat(),
            own_look: self.stage.has_own_look(),
            hint: self.landmark_hint(),
        };
        Ok(serde_json::to_string(&state)?)
    }

    /// The messages since the last call, one per line.
    pub fn take_notes(&mut self) -> String {
        std::mem::take(&mut self.notes).join("\n")
    }
}

impl Sitting {
    fn names(&self, parts: &[usize]) -> Vec<&str> {
        parts.iter().filter_map(|part| self.parts.names.get(*part)).map(String::as_str).collect()
    }

    fn shown<'a>(&'a self, id: LayerId, layer: &'a Layer) -> ShownLayer<'a> {
        let evaluated = self.evaluation.layers.iter().find(|evaluated| evaluated.id == id);
        let (state, why) = match evaluated.map(|evaluated| &evaluated.state) {
            None | Some(LayerState::Waiting) => ("waiting", None),
            Some(LayerState::Acts | LayerState::Outdated) => ("acts", None),
            Some(LayerState::Off) => ("off", None),
            Some(LayerState::Failed(why)) => ("failed", Some(why.as_str())),
        };
        let curve =
            CURVES.into_iter().find(|name| name.parse::<ScaleCurve>().ok().as_ref() == Some(&layer.curve));
        let quality = self.quality(layer);
        ShownLayer {
            id,
            name: &layer.name,
            template: template_name(&layer.template, self.history.project()),
            template_text: template_text(&layer.template),
            model: layer.model,
            mu: layer.mu,
            least_mu: if layer.model == Model::Distance { -8.0 } else { -3.0 },
            strength: layer.strength,
            enabled: layer.enabled,
            solo: layer.solo,
            curve: curve.unwrap_or_default(),
            everywhere: layer.region.painted == Painted::Everywhere,
            parts: self.names(&self.parts.in_region(&layer.region.painted)),
            smoothing: layer.region.smoothing,
            state,
            why,
            folds: evaluated.map_or(0, |evaluated| evaluated.folds(self.stack.surface())),
            coverage: quality.map(|report| report.coverage),
            residual: quality.and_then(|report| report.residual_median),
            flipped: quality.map_or(0, |report| report.flipped_triangles),
            stretched: quality.map_or(0, |report| report.strongly_stretched),
            warnings: quality.map(|report| report.warnings.clone()).unwrap_or_default(),
            has_mesh: layer.template.is_mesh(),
            method: layer.matching.method,
            fits_size: layer.matching.scaling == Scaling::Free,
            infill: layer.infill,
            untrusted: self.untrusted(layer),
            head: head_sliders_of(&layer.template).map(Vec::from),
            landmarks: layer.matching.landmarks.clone(),
        }
    }
}

/// The templates that need no file, each with its comparison in words, as JSON: `[["Ellipsoid", "Against …"], …]`.
///
/// # Errors
/// Bugs only.
#[wasm_bindgen]
pub fn starting_points() -> Result<String, JsError> {
    let all: Vec<[&str; 2]> = STARTING_POINTS.iter().map(|point| [point.name, point.tip]).collect();
    Ok(serde_json::to_string(&all)?)
}
