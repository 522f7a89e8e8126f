//! The offer to recover unsaved work after a crash.

use chladni_caricature::{Recovered, Recovery, ShapeSource};
use egui::RichText;

use crate::studio::age::changed_ago;
use crate::studio::author_id::AuthorId;
use crate::studio::room::Shared;
use crate::studio::theme;
use crate::work::shown_name;

/// Recovery copies found when the window opened.
#[derive(Default)]
pub struct Offer {
    found: Option<Vec<Recovered>>,
}

/// The user's answer about the copies, each named by its index.
enum Choice {
    Recover(usize),
    ThrowAway(usize),
    Later,
}

impl Offer {
    /// Looks once, and asks as long as there is something; returns the project that the user wants to recover.
    pub fn show(&mut self, shared: &mut Shared<'_>) -> Option<Recovered> {
        let found = self.found.get_or_insert_with(|| find(shared));
        if found.is_empty() {
            return None;
        }
        let mut answer = None;
        let ((), dismissed) = theme::modal(&shared.ctx, "The last session did not end well", 460.0, |ui| {
            ui.label(
                RichText::new("Your work is still there. Recover it, or throw it away.")
                    .color(theme::palette(ui).weak),
            );
            ui.add_space(theme::GAP);
            egui::ScrollArea::vertical().max_height(280.0).show(ui, |ui| {
                for (index, recovered) in found.iter().enumerate() {
                    ui.separator();
                    let name = name(recovered);
                    ui.label(RichText::new(&name).strong());
                    ui.label(RichText::new(describe(recovered)).color(theme::palette(ui).weak));
                    theme::group(ui, &name, |ui| {
                        ui.horizontal(|ui| {
                            if theme::primary_button(ui, "Recover").author_id("recover").clicked() {
                                answer = Some(Choice::Recover(index));
                            }
                            if ui.button("Throw away").clicked() {
                                answer = Some(Choice::ThrowAway(index));
                            }
                        });
                    });
                }
            });
            ui.separator();
            if ui.button("Ask again next time").clicked() {
                answer = Some(Choice::Later);
            }
        });
        if dismissed {
            answer.get_or_insert(Choice::Later);
        }
        match answer? {
            Choice::Recover(index) => {
                let recovered = found.remove(index);
                // The others are asked about the next time: one project is open at a time.
                found.clear();
                Some(recovered)
            }
            Choice::ThrowAway(index) => {
                found.remove(index).discard();
                None
            }
            Choice::Later => {
                found.clear();
                None
            }
        }
    }
}

fn find(shared: &mut Shared<'_>) -> Vec<Recovered> {
    let Some(folder) = &shared.folders.recovery else { return Vec::new() };
    let (found, unreadable) = Recovery::find(folder);
    for why in unreadable {
        shared.notices.warn(format!("A recovery copy cannot be read: {why}"));
    }
    found
}

fn name(recovered: &Recovered) -> String {
    let file = match (&recovered.original, &recovered.project.shape) {
        (Some(path), _) | (None, ShapeSource::File(path)) => path,
        (None, ShapeSource::Sample(name)) => return format!("Sample {name}, never saved"),
    };
    let file_name = shown_name(file).into_owned();
    match recovered.original {
        Some(_) => file_name,
        None => format!("{file_name}, never saved"),
    }
}

fn describe(recovered: &Recovered) -> String {
    let layers = match recovered.project.layers().len() {
        1 => "1 layer".to_owned(),
        count => format!("{count} layers"),
    };
    match changed_ago(recovered.modified) {
        Some(age) => format!("{layers}, {age}"),
        None => layers,
    }
}
