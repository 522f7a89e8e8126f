//! Which figures stand on the stage, and where.

use chladni_view::{Rect, layout};
use egui::Ui;

use super::super::look::Show;
use super::super::shot::Pose;
use super::Stage;
use crate::studio::viewport;
use crate::work::{Inked, Pen};

/// Figures that the stage holds room for: the result, the three models, the original, and the template.
pub const FIGURES: usize = 6;
/// The result of the whole stack.
pub const RESULT: usize = 0;
/// The first of the three models of the selected layer.
pub const MODELS: usize = 1;
/// The shape as it was loaded.
pub const ORIGINAL: usize = 4;
/// The template of the selected layer as it was matched, drawn over the others as a ghost or beside the result.
pub const TEMPLATE: usize = 5;

impl Stage {
    /// The figures that are shown and their cells on the canvas that fills `rect`.
    pub(super) fn arranged(&self, ui: &Ui, rect: egui::Rect, show: Show) -> (&'static [usize], Vec<Rect>) {
        let (figures, canvas) = (self.figures(show), viewport::area(ui, rect));
        (figures, layout::arranged(canvas, figures.len(), 0.8, 2))
    }

    /// The figures that are shown, from left to right.
    pub(super) fn figures(&self, show: Show) -> &'static [usize] {
        match show {
            Show::Models if self.shows_models => &[MODELS, MODELS + 1, MODELS + 2, ORIGINAL],
            Show::BeforeAfter => &[ORIGINAL, RESULT],
            Show::Template if self.has_template => &[RESULT, TEMPLATE],
            Show::Result | Show::Models | Show::Template => &[RESULT],
            Show::Original => &[ORIGINAL],
        }
    }
}

/// How far each vertex of a figure is exaggerated, for a pen that shows it; empty where none is.
pub(super) fn moved(poses: &[Pose], figure: usize, pen: Pen) -> Vec<f64> {
    let exaggerated = figure == RESULT || (MODELS..ORIGINAL).contains(&figure);
    match (poses.get(figure), poses.get(ORIGINAL)) {
        (Some((positions, _)), Some((rest, _))) if pen.exaggeration && exaggerated => {
            Inked::moved(positions, rest.iter().map(|p| p.map(f64::from))).moved
        }
        _ => Vec::new(),
    }
}
