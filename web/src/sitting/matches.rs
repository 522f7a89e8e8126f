//! Matches that layers wait for: those with meshes are made in a worker, the others at once.

use std::sync::Arc;

use chladni_caricature::{
    Action, CaricatureError, Layer, LayerId, MatchRequest, Matched, Property, Template,
};
use chladni_match::{MatchReport, MatchSettings, Method, Scaling};
use chladni_mesh::Estimate;
use chladni_mesh::samples::{SLIDERS, portrait_name, portrait_sliders};
use chladni_program::work::{Aside, matched_with};
use chladni_task::Task;
use serde::Serialize;
use wasm_bindgen::prelude::*;

use super::Sitting;

/// A match that the page has to ask for.
#[derive(Serialize)]
struct Wanted {
    /// The request for [`match_template`](crate::solve::match_template): a text, since a page's numbers have too few
    /// digits for seeds.
    request: String,
    /// The template as people read it.
    template: String,
    /// It is in a file, which the page must have.
    file: bool,
}

#[wasm_bindgen]
impl Sitting {
    /// The next match that layers wait for, as JSON; none where there is none. What needs no worker is done.
    ///
    /// # Errors
    /// Bugs only.
    pub fn missing(&mut self) -> Result<Option<String>, JsError> {
        let (mut own, mut wanted) = (false, None);
        for request in self.stack.missing(self.history.project()) {
            if request.template.is_mesh() {
                wanted = wanted.or(Some(request));
                continue;
            }
            let task = Task::new();
            let found = matched_with(&request, &self.mesh, self.stack.body(), None, &Aside::new(&task));
            self.stack.install(request, found);
            own = true;
        }
        if own {
            self.refresh()?;
        }
        let Some(wanted) = wanted else { return Ok(None) };
        let wanted = Wanted {
            template: wanted.template.to_string(),
            file: matches!(wanted.template, Template::File(_)),
            request: serde_json::to_string(&wanted)?,
        };
        Ok(Some(serde_json::to_string(&wanted)?))
    }

    /// Installs the answer of [`match_template`](crate::solve::match_template) to a request.
    ///
    /// # Errors
    /// Text that is not a match.
    pub fn install(&mut self, request: &str, found: &str) -> Result<(), JsError> {
        let found: Matched = serde_json::from_str(found)?;
        if let Some(orientation) = found.stands.filter(|_| self.stands.in_doubt) {
            self.stands = Estimate { orientation, in_doubt: false, ..self.stands };
        }
        self.stack.install(serde_json::from_str(request)?, Ok(found));
        Ok(self.refresh()?)
    }

    /// No match was found for a request: its layers cannot act, and say why.
    ///
    /// # Errors
    /// Bugs only.
    pub fn fail(&mut self, request: &str, why: String) -> Result<(), JsError> {
        self.stack.install(serde_json::from_str(request)?, Err(CaricatureError::Elsewhere(why)));
        Ok(self.refresh()?)
    }

    /// Forgets the answer to a request: its file has another content.
    ///
    /// # Errors
    /// Bugs only.
    pub fn forget(&mut self, request: &str) -> Result<(), JsError> {
        self.stack.forget(&serde_json::from_str(request)?);
        Ok(self.refresh()?)
    }

    /// The matches of all layers, as JSON, for [`Wall`](crate::Wall): each request with its answer.
    ///
    /// # Errors
    /// Bugs only.
    pub fn matches(&self) -> Result<String, JsError> {
        let layers = self.history.project().layers().iter();
        let requests = layers.filter_map(|(_, layer)| MatchRequest::of(layer));
        let known = requests.filter_map(|request| {
            let found = Arc::clone(self.stack.matched(&request)?);
            Some((request, found))
        });
        let known: Vec<(MatchRequest, Arc<Matched>)> = known.collect();
        let known: Vec<(&MatchRequest, &Matched)> = known.iter().map(|(r, found)| (r, &**found)).collect();
        Ok(serde_json::to_string(&known)?)
    }

    /// Matches a layer with its template by another method: `fit`, `icp`, `map` or `same`.
    ///
    /// # Errors
    /// A name of no method, and a layer that is not there.
    pub fn set_method(&mut self, layer: u32, name: &str) -> Result<(), JsError> {
        let method: Method = serde_json::from_value(name.into())?;
        self.set_matching(layer, |matching| matching.method = method)
    }

    /// Fits the size of a layer's template to the shape, or keeps it, in the units of its file.
    ///
    /// # Errors
    /// A layer that is not there.
    pub fn fit_size(&mut self, layer: u32, on: bool) -> Result<(), JsError> {
        self.set_matching(layer, |matching| {
            matching.scaling = if on { Scaling::Free } else { Scaling::Rigid }
        })
    }

    /// Moves a slider of the head that a layer is compared with, by its number among
    /// [`head_sliders`](crate::head_sliders), to a value from -1 to 1.
    ///
    /// # Errors
    /// A layer whose template has no sliders, and a slider that is not there.
    pub fn set_head(&mut self, layer: u32, slider: usize, value: f64) -> Result<(), JsError> {
        let layer = LayerId(layer.into());
        let found = self.history.project().layer(layer);
        let mut values = found
            .and_then(|found| head_sliders_of(&found.template))
            .ok_or_else(|| JsError::new("this template has no sliders"))?;
        *values.get_mut(slider).ok_or_else(|| JsError::new("there is no such slider"))? =
            value.clamp(-1.0, 1.0);
        let to = Property::Template(Template::Sample(portrait_name(&values)));
        Ok(self.act_once(&Action::Set { layer, to })?)
    }

    /// Tries again what failed for the selected layer.
    ///
    /// # Errors
    /// Bugs only.
    pub fn retry(&mut self) -> Result<(), JsError> {
        let layer = self.selected.and_then(|id| self.history.project().layer(id));
        if let Some(request) = layer.and_then(|layer| MatchRequest::of(layer.as_ref())) {
            self.stack.forget(&request);
        }
        Ok(self.refresh()?)
    }
}

/// The sliders of a head of our own, each with what it goes from and to, as JSON: `[["width", "narrow to broad"], …]`.
///
/// # Errors
/// Bugs only.
#[wasm_bindgen]
pub fn head_sliders() -> Result<String, JsError> {
    Ok(serde_json::to_string(&SLIDERS[..])?)
}

/// The values of the sliders of a template that is a head of our own.
pub(super) fn head_sliders_of(template: &Template) -> Option<[f64; SLIDERS.len()]> {
    let Template::Sample(name) = template else { return None };
    portrait_sliders(name)?.ok()
}

impl Sitting {
    fn set_matching(&mut self, layer: u32, change: impl FnOnce(&mut MatchSettings)) -> Result<(), JsError> {
        let layer = LayerId(layer.into());
        let found = self.history.project().layer(layer);
        let mut matching = found.ok_or_else(|| JsError::new("there is no such layer"))?.matching.clone();
        change(&mut matching);
        Ok(self.act_once(&Action::Set { layer, to: Property::Matching(matching) })?)
    }

    /// The share of the shape where the match of a layer is not trusted, and its surroundings can go on instead.
    pub(super) fn untrusted(&self, layer: &Layer) -> Option<f64> {
        let matched = self.stack.matched(&MatchRequest::of(layer)?)?;
        matched.infill.as_ref().map(|(_, share)| *share)
    }

    /// How good the match of a layer is.
    pub(super) fn quality(&self, layer: &Layer) -> Option<&MatchReport> {
        self.stack.matched(&MatchRequest::of(layer)?)?.report.as_ref()
    }
}
