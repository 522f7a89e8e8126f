//! The sliders of a template that is a head of our own.

use chladni_caricature::{Layer, LayerId, Property, Template};
use chladni_mesh::samples::{SLIDERS, portrait_name, portrait_sliders};
use egui::Ui;

use super::edits::Edits;
use super::landmarks;
use crate::studio::room::Shared;
use crate::studio::theme;

/// Draws the sliders of a layer's template, where it has any; the match follows them, and landmarks go.
pub fn show(ui: &mut Ui, id: LayerId, layer: &Layer, edits: &mut Edits, shared: &mut Shared<'_>) {
    let Template::Sample(name) = &layer.template else { return };
    let Some(Ok(mut values)) = portrait_sliders(name) else { return };
    theme::group(ui, "The head", |ui| {
        for place in 0..SLIDERS.len() {
            let (name, about) = SLIDERS[place];
            theme::row(ui, &theme::capitalized(&name.replace('-', " ")), about, |ui| {
                let slider = ui.add(theme::slider(&mut values[place], -1.0..=1.0).fixed_decimals(2));
                if slider.changed() && !layer.matching.landmarks.is_empty() {
                    shared.notices.warn(landmarks::GONE);
                }
                let head = || Property::Template(Template::Sample(portrait_name(&values)));
                edits.drag(id, &slider, head);
            });
        }
    });
}
