//! The gallery of a shape, which outlives that it is closed.

use std::sync::Arc;

use chladni_caricature::{Layer, LayerId, MatchRequest};
use egui::Ui;

use super::super::edits::Edits;
use super::super::look::Portrayal;
use super::super::session::Session;
use super::{GalleryView, Given};
use crate::studio::room::Shared;
use crate::work::{Error, Exhibition};

/// The gallery of the open shape. It stays as it was while it is closed.
#[derive(Default)]
pub struct ShapesGallery {
    view: Option<GalleryView>,
    open: bool,
}

impl ShapesGallery {
    /// Whether it stands in the place of the shape.
    pub fn is_open(&self) -> bool {
        self.open
    }

    /// Shows it as it was left.
    pub fn open(&mut self) {
        self.open = true;
    }

    /// Leaves it as it is; one that is still being prepared is given up.
    pub fn close(&mut self) {
        self.open = false;
        self.view.take_if(|view| view.shown.is_none() && view.before.is_none());
        if let Some(view) = &mut self.view {
            (view.taking, view.wall) = (None, None);
            view.work.take_if(|_| view.shown.is_none());
        }
    }

    /// The device was lost.
    pub fn change_device(&mut self) {
        if let Some(view) = &mut self.view {
            view.wall = None;
        }
    }

    /// Draws it where it is open; false where it is closed. What is taken becomes layers.
    pub fn show(
        &mut self,
        ui: &mut Ui,
        session: &mut Session,
        look: Portrayal,
        shared: &mut Shared<'_>,
        edits: &mut Edits,
    ) -> Result<bool, Error> {
        if !self.open {
            return Ok(false);
        }
        let view = match self.view.take() {
            Some(view) if view.belongs_to(session) => view,
            Some(view) => GalleryView {
                surprises: view.surprises,
                seed: view.seed,
                ..GalleryView::begin(session, view.given, view.shown.or(view.before), ui.ctx())
            },
            None => GalleryView::begin(session, matched_template(session), None, ui.ctx()),
        };
        match self.view.insert(view).show(ui, session, look, shared, edits) {
            Ok(true) => {}
            Ok(false) => self.close(),
            Err(why) => {
                self.close();
                return Err(why);
            }
        }
        Ok(true)
    }
}

/// The template of the topmost layer with a mesh, where it is matched or about to be: the mesh of a layer that is hidden
/// may be gone.
pub(super) fn matched_template(session: &Session) -> Option<Given> {
    let project = session.project();
    let (template, matching) = Exhibition::template_of(project)?;
    let wanted = MatchRequest { template: template.clone(), matching: matching.clone() };
    let failed = session.failed_layers();
    let waits_for_it = |(id, layer): &(LayerId, Arc<Layer>)| {
        project.acts(layer) && !failed.contains(id) && MatchRequest::of(layer).as_ref() == Some(&wanted)
    };
    let matches = session.stack.matched(&wanted).is_some() || project.layers().iter().any(waits_for_it);
    matches.then_some((template, matching))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::studio::caricature::loading::{Candidate, load};
    use chladni_caricature::{Project, ShapeSource, Template};
    use chladni_task::Task;
    use std::sync::mpsc::channel;

    #[test]
    fn a_hidden_layer_that_was_never_matched_gives_no_template() {
        for enabled in [false, true] {
            let mut project = Project::new(ShapeSource::Sample("head".into()), 16);
            let layer = Layer { enabled, ..Layer::new("mesh", Template::Sample("template".into())) };
            project.push(layer).unwrap();
            let session = Session::new(load(Candidate::new(project), &channel().0, &Task::new()).unwrap());
            assert_eq!(matched_template(&session).is_some(), enabled);
        }
    }
}
