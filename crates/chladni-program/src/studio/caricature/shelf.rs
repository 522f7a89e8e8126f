//! The shelf: templates of our own, to be taken by their pictures.

use chladni_caricature::Template;
use egui::{Ui, Vec2, vec2};

use crate::studio::author_id::AuthorId;
use crate::studio::card::card;
use crate::studio::icon::{self, Icon};
use crate::studio::room::Shared;
use crate::studio::theme;

/// Names of templates and their samples. Heads first: most shapes that are caricatured have one.
const TEMPLATES: [(&str, &str); 15] = [
    ("Plain head", "template"),
    ("Character", "head"),
    ("Adult", "portrait"),
    ("Child", "portrait?age=-1.00"),
    ("Old man", "portrait?age=1.00"),
    ("Broad", "portrait?width=0.90,cheeks=0.50,jaw=0.80,neck=0.80"),
    ("Narrow", "portrait?width=-0.90,length=0.60,jaw=-0.60"),
    ("Fine features", "portrait?brow=-0.60,eyes=0.50,nose=-0.50,lips=0.60,jaw=-0.70,neck=-0.60"),
    ("Rugged", "portrait?brow=0.90,nose=0.60,bridge=0.80,jaw=0.90,chin=0.70"),
    ("Human", "human"),
    ("Cat", "cat"),
    ("Octopus", "octopus"),
    ("Jellyfish", "jellyfish"),
    ("Bell", "bell"),
    ("Ring", "ring"),
];

const CARD: Vec2 = vec2(104.0, 98.0);
const COLUMNS: usize = 5;

/// A button that opens the shelf; returns the template taken from it, with its name. Pictures are drawn when the
/// shelf is first opened.
pub fn show(ui: &mut Ui, shared: &mut Shared<'_>) -> Option<(&'static str, Template)> {
    let mut taken = None;
    let menu = ui.menu_button(icon::label(Icon::Images, "Shelf"), |ui| {
        ui.spacing_mut().item_spacing = Vec2::splat(theme::GAP_SMALL);
        for row in TEMPLATES.chunks(COLUMNS) {
            ui.horizontal(|ui| {
                for &(name, sample) in row {
                    let picture = shared.pictures.of_sample(ui.ctx(), sample);
                    let card = card(ui, CARD, picture.as_ref(), Icon::Box, "Compare with", name);
                    if card.author_id(format!("shelf/{sample}")).clicked() {
                        taken = Some((name, Template::Sample(sample.into())));
                        ui.close();
                    }
                }
            });
        }
    });
    menu.response
        .author_id("shelf")
        .on_hover_text("Templates of our own: heads, animals and more, by their pictures");
    taken
}

#[cfg(test)]
mod tests {
    use super::*;
    use chladni_mesh::samples::{SAMPLES, portrait_name, portrait_sliders};

    #[test]
    fn all_on_the_shelf_is_there_under_names_of_its_own() {
        for (i, (name, sample)) in TEMPLATES.iter().enumerate() {
            let known = match portrait_sliders(sample) {
                // As the sliders write it, so that touching one changes nothing else.
                Some(values) => portrait_name(&values.unwrap()) == *sample,
                None => SAMPLES.contains(sample),
            };
            assert!(known, "{sample}");
            assert!(TEMPLATES[..i].iter().all(|(other, same)| other != name && same != sample), "{name}");
        }
    }
}
