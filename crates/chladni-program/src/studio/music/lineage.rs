//! The family tree of dances, and the way back to where an ancestor was.

use chladni_music::{Action, Gallery, GalleryItem, Instrument, ItemId, Origin};
use egui::{RichText, ScrollArea, Ui};

use super::wish::Wish;
use crate::studio::author_id::AuthorId;
use crate::studio::theme;

/// "Squid", "Dance 3" where it is in the generation that is shown, or else "3 of generation 2".
pub fn called(instrument: &Instrument, item: &GalleryItem) -> String {
    let gallery = instrument.gallery();
    match gallery.items().iter().position(|shown| shown.id == item.id) {
        Some(place) if item.name.is_empty() => format!("Dance {}", place + 1),
        None if item.name.is_empty() && gallery.born(item.id).is_none() => "Dance of another gallery".into(),
        _ => name(gallery, item.id, &item.name),
    }
}

/// A menu called `label` of an item and its ancestors, newest first; a click goes to the generation of one.
pub fn menu(ui: &mut Ui, label: &str, instrument: &Instrument, item: &GalleryItem, wishes: &mut Vec<Wish>) {
    let button = ui.menu_button(label, |ui| {
        ScrollArea::vertical().max_height(360.0).show(ui, |ui| {
            let gallery = instrument.gallery();
            for ancestor in instrument.lineage(item) {
                let mut text = format!(
                    "{}: {}",
                    name(gallery, ancestor.id, &ancestor.name),
                    how(gallery, &ancestor.origin)
                );
                if ancestor.edited {
                    text += ", changed by hand";
                }
                let Some((generation, _)) = gallery.born(ancestor.id) else {
                    ui.label(RichText::new(text).color(theme::palette(ui).weak));
                    continue;
                };
                let shown = generation == gallery.current();
                if ui.selectable_label(shown, text).on_hover_text("Go to its generation").clicked() {
                    wishes.push(Wish::Do(Action::GoTo { generation }));
                    ui.close();
                }
            }
        });
    });
    button.response.accessible_name("Lineage").author_id("lineage").on_hover_text("Where it comes from");
}

/// "Squid", or "3 of generation 2".
fn name(gallery: &Gallery, id: ItemId, own: &str) -> String {
    match gallery.born(id) {
        _ if !own.is_empty() => own.to_owned(),
        Some((generation, place)) => format!("{} of generation {}", place + 1, generation + 1),
        None => "of another gallery".into(),
    }
}

fn how(gallery: &Gallery, origin: &Origin) -> String {
    let parent = |id: ItemId| {
        let own = gallery.find(id).map_or("", |item| item.name.as_str());
        match gallery.born(id) {
            Some((_, place)) if own.is_empty() => (place + 1).to_string(),
            _ => name(gallery, id, own),
        }
    };
    match origin {
        Origin::Initial { seed, .. } => format!("from seed {seed}"),
        Origin::Bred { parents: [a, b] } => format!("bred from {} and {}", parent(*a), parent(*b)),
        Origin::Mutated { parent: of } => format!("{}, changed a little", parent(*of)),
        Origin::Loaded { name } => format!("the preset {name}"),
    }
}
