//! Matches that layers wait for: those with meshes are made in a worker, the others at once.

use std::sync::Arc;

use chladni_caricature::{CaricatureError, Layer, MatchRequest, Matched, Template};
use chladni_mesh::Estimate;
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

impl Sitting {
    /// How good the match of a layer is: the share of the shape that is covered, and warnings.
    pub(super) fn quality(&self, layer: &Layer) -> Option<(f64, Vec<String>)> {
        let matched = self.stack.matched(&MatchRequest::of(layer)?)?;
        let report = matched.report.as_ref()?;
        Some((report.coverage, report.warnings.clone()))
    }
}
