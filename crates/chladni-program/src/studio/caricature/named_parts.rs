//! The parts of a head by their names, found beside the window: a click takes one as the region.

use std::sync::Arc;

use chladni_caricature::{Action, HeadParts, Layer, LayerId, PaintEdit};
use egui::{RichText, Ui};

use super::edits::Edits;
use super::session::Session;
use crate::studio::author_id::AuthorId;
use crate::studio::job::{self, Job};
use crate::studio::theme;
use crate::work::{Aside, Error, Parts, head_parts};

/// A part that is less sure than this on average is marked.
const UNSURE: f64 = 0.5;

/// The list, and what is known of the shape's parts.
#[derive(Default)]
pub struct NamedParts {
    open: bool,
    known: Known,
}

/// What is known of the parts of the open shape.
#[derive(Default)]
enum Known {
    #[default]
    Nothing,
    Searching(Job<Option<Named>>),
    NoHead,
    Failed(String),
    Found(Named),
}

/// Parts with names.
struct Named {
    parts: Parts,
    /// How sure each part is, by its number; `None` of one that the shape lacks, empty where all are known.
    confidence: Vec<Option<f64>>,
    warnings: Vec<String>,
}

impl NamedParts {
    /// Another shape is open.
    pub fn forget(&mut self) {
        self.known = Known::Nothing;
    }

    /// Draws what opens the list.
    pub fn show_switch(&mut self, ui: &mut Ui) {
        let tip = "Nose, brow, eyes and the other parts of a head, by their names";
        ui.toggle_value(&mut self.open, "Parts of a head").author_id("head-parts").on_hover_text(tip);
    }

    /// Whether the parts are to be looked for.
    pub fn wants_search(&self) -> bool {
        self.open && matches!(self.known, Known::Nothing)
    }

    /// Looks for the parts of the open shape; a sample's are known.
    pub fn search(&mut self, session: &Session, ctx: &egui::Context) {
        let (mesh, body) = (Arc::clone(&session.subject.mesh), Arc::clone(session.stack.body()));
        let parts = Parts::known(&session.project().shape.to_string(), &mesh, &body);
        if !parts.names.is_empty() {
            self.known = Known::Found(Named { parts, confidence: Vec::new(), warnings: Vec::new() });
            return;
        }
        self.known = Known::Searching(Job::start("Looking for a head", ctx, move |task| {
            let found = head_parts(&mesh, HeadParts::MOST_MISFIT, &Aside::new(task))?;
            Ok(found.map(|(found, ..)| {
                let parts = Parts::of_head(&found.part, &body);
                let confidence = (0..parts.names.len()).map(|part| found.extent(part).1).collect();
                Named { parts, confidence, warnings: found.report.warnings }
            }))
        }));
    }

    /// Draws the list where it is open. `erase` takes parts away in place of taking them.
    pub fn show(&mut self, ui: &mut Ui, id: LayerId, layer: &Layer, erase: bool, edits: &mut Edits) {
        if let Known::Searching(job) = &self.known
            && let Some(ended) = job.ended()
        {
            self.known = match ended {
                Ok(Some(named)) => Known::Found(named),
                Ok(None) => Known::NoHead,
                Err(Error::Cancelled) => {
                    self.open = false;
                    Known::Nothing
                }
                Err(why) => Known::Failed(why.to_string()),
            };
        }
        if !self.open {
            return;
        }
        let palette = theme::palette(ui);
        let say = |ui: &mut Ui, text: &str, color| {
            ui.add(egui::Label::new(RichText::new(text).color(color).small()).wrap());
        };
        match &self.known {
            Known::Nothing => {}
            Known::Searching(job) => job::show_progress(ui, job),
            Known::NoHead => say(ui, NO_HEAD, palette.weak),
            Known::Failed(why) => say(ui, why, palette.error),
            Known::Found(named) => {
                named.show(ui, id, layer, erase, edits);
                named.warnings.iter().for_each(|warning| say(ui, warning, palette.warning));
            }
        }
    }
}

/// What is said where there are no names.
const NO_HEAD: &str = "The shape does not look like a head, so its parts have no names. Paint with Parts takes what \
                       stands out of any shape.";

impl Named {
    fn show(&self, ui: &mut Ui, id: LayerId, layer: &Layer, erase: bool, edits: &mut Edits) {
        let within = self.parts.in_region(&layer.region.painted);
        let modifiers = ui.input(|input| input.modifiers);
        ui.horizontal_wrapped(|ui| {
            ui.spacing_mut().item_spacing.x = 3.0;
            ui.spacing_mut().button_padding.x = 6.0;
            for (part, name) in self.parts.names.iter().enumerate() {
                let Some((text, tip, unsure)) = self.described(part, name) else { continue };
                let color = unsure.then(|| theme::palette(ui).warning);
                let text = color.into_iter().fold(RichText::new(text), RichText::color);
                let button = ui.selectable_label(within.contains(&part), text);
                let button = button.author_id(format!("part/{name}"));
                if button.on_hover_text(tip).clicked() {
                    let erase = erase ^ modifiers.ctrl;
                    let edit = PaintEdit::taking(&[part], &self.parts.part, modifiers.shift, erase);
                    edits.once(Action::Paint { layer: id, edit });
                }
            }
        });
    }

    /// A part's label, its tip, and whether it is unsure; `None` of one that the shape lacks.
    fn described(&self, part: usize, name: &str) -> Option<(String, String, bool)> {
        const HOW: &str = "A click takes it as the region; Shift adds it, Erase or Ctrl takes it away";
        let name = theme::capitalized(name);
        let Some(confidence) = self.confidence.get(part) else {
            return Some((name, format!("{HOW}. Known, since the sample was modeled of its parts"), false));
        };
        let sure = (*confidence)?;
        let percent = 100.0 * sure;
        let doubt = if sure < UNSURE { ": look whether it is where it should be" } else { "" };
        let tip = format!("{HOW}. Found by a match with a head, {percent:.0} % sure{doubt}");
        Some((format!("{name} {percent:.0} %"), tip, sure < UNSURE))
    }
}
