//! The layer that the panels edit: its effect, and how far it may go.

use std::sync::Arc;

use chladni_caricature::{EvaluatedLayer, Layer, LayerId, LayerState, MatchRequest, Matched};

use super::Session;
use crate::work::furthest_mu;

/// How far a layer is held back where it would fold the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Held {
    /// Not found yet: shown as far as it went before.
    Unknown,
    /// This share of its movement is kept.
    Back {
        /// Mean length of the displacement, as a share of the unlimited one's.
        kept: f64,
    },
}

impl Session {
    /// The layer that the panels edit, as the document has it.
    pub fn chosen(&self) -> Option<(LayerId, Arc<Layer>)> {
        let id = self.selected?;
        Some((id, Arc::clone(self.project().layer(id)?)))
    }

    /// The evaluation of the selected layer.
    pub fn selected_evaluation(&self) -> Option<&EvaluatedLayer> {
        let selected = self.selected?;
        self.shown.evaluation.layers.iter().find(|layer| layer.id == selected)
    }

    /// The μ with the strongest exaggeration before the selected layer folds more than this share of the
    /// triangles. What is shown must have [caught up](Self::catch_up).
    pub fn furthest_mu(&self, may_fold: f64) -> Option<f64> {
        let (_, layer) = self.chosen()?;
        furthest_mu(self.selected_evaluation()?, &layer, self.stack.surface(), may_fold)
    }

    /// How far the selected layer is held back; `None` where its project does not keep triangles.
    pub fn kept(&self) -> Option<Held> {
        if !self.project().keep_triangles {
            return None;
        }
        let kept = self.selected_evaluation().and_then(|layer| layer.kept.as_ref());
        Some(kept.map_or(Held::Unknown, |kept| Held::Back { kept: kept.share }))
    }

    pub(super) fn selected_request(&self) -> Option<MatchRequest> {
        MatchRequest::of(&self.chosen()?.1)
    }

    /// The match of the selected layer.
    pub fn selected_match(&self) -> Option<&Arc<Matched>> {
        self.stack.matched(&self.selected_request()?)
    }

    /// Why the selected layer cannot act.
    pub fn selected_failure(&self) -> Option<&str> {
        match &self.selected_evaluation()?.state {
            LayerState::Failed(why) => Some(why),
            _ => None,
        }
    }
}
