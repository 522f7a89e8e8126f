//! The list of landmarks in the match panel, and their text file.

use std::ops::Range;

use chladni_caricature::{LayerId, Property};
use chladni_match::{MatchSettings, load_landmarks, write_landmarks};
use egui::{RichText, Ui};

use super::super::edits::Edits;
use super::super::layers::icon_button;
use super::super::session::Session;
use super::color;
use crate::studio::author_id::AuthorId;
use crate::studio::choose::ask_where_to_save;
use crate::studio::icon::{self, Icon};
use crate::studio::keys::caricature::LANDMARKS;
use crate::studio::room::Shared;
use crate::studio::theme;
use crate::work::Error;
use crate::work::outputs::check_apart;

/// A list of no more landmarks is laid out whole, so that the keyboard reaches all of them.
const SHORT: usize = 200;

/// Draws the landmarks of `layer`; `picking` is toggled by its button.
pub fn show_list(
    ui: &mut Ui,
    session: &Session,
    layer: LayerId,
    settings: &MatchSettings,
    picking: &mut bool,
    edits: &mut Edits,
    shared: &mut Shared<'_>,
) {
    ui.add_space(theme::GAP_SMALL);
    ui.horizontal(|ui| {
        ui.label("Landmarks").on_hover_text("Pairs of places that belong together; 3 or more lead the match");
        ui.label(RichText::new(settings.landmarks.len().to_string()).color(theme::palette(ui).weak));
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            if icon_button(ui, Icon::Save, "Write the landmarks to a text file")
                .author_id("landmarks-save")
                .clicked()
            {
                save(session, settings, shared);
            }
            if icon_button(ui, Icon::FolderOpen, "Read landmarks from a text file")
                .author_id("landmarks-open")
                .clicked()
                && let Some(landmarks) = load(session, shared)
            {
                edits.set(layer, Property::Matching(MatchSettings { landmarks, ..settings.clone() }));
            }
            let label =
                if *picking { icon::label(Icon::Check, "Done") } else { icon::label(Icon::MapPin, "Pick") };
            ui.toggle_value(picking, label).on_hover_text(LANDMARKS.tooltip(ui.ctx()));
        });
    });
    let mut removed = None;
    // As in the text file: not those of a proxy.
    let numbered = session.subject.numbered_in_file(&settings.landmarks);
    let step = ui.spacing().interact_size.y + ui.spacing().item_spacing.y;
    let seen = in_sight(numbered.len(), ui.clip_rect().y_range(), ui.cursor().top(), step);
    ui.add_space(seen.start as f32 * step);
    for (index, landmark) in numbered.iter().enumerate().take(seen.end).skip(seen.start) {
        ui.horizontal(|ui| {
            let (dot, _) = ui.allocate_exact_size(egui::vec2(12.0, 16.0), egui::Sense::hover());
            ui.painter().circle_filled(dot.center(), 5.0, color(index));
            ui.label(format!("{}", index + 1));
            let text = format!("vertex {} on {}", landmark.shape, landmark.template);
            theme::weak(ui, text);
            ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                let name = format!("Remove landmark {}", index + 1);
                if icon_button(ui, Icon::X, &name)
                    .author_id(format!("landmark-remove/{}", index + 1))
                    .clicked()
                {
                    removed = Some(index);
                }
            });
        });
    }
    ui.add_space((numbered.len() - seen.end) as f32 * step);
    if let Some(index) = removed {
        let mut settings = settings.clone();
        settings.landmarks.remove(index);
        edits.set(layer, Property::Matching(settings));
    }
}

/// The rows in sight of a list that begins at `top` and has one every `step` points.
fn in_sight(rows: usize, sight: egui::Rangef, top: f32, step: f32) -> Range<usize> {
    if rows <= SHORT {
        return 0..rows;
    }
    // Above the first row, the casts give 0.
    let first = (((sight.min - top) / step) as usize).min(rows);
    let end = ((sight.max - top) / step).ceil() as usize;
    first..end.clamp(first, rows)
}

fn load(session: &Session, shared: &mut Shared<'_>) -> Option<Vec<chladni_match::Landmark>> {
    let path = shared.chooser.open(&[("Landmarks", &["txt"])])?;
    let read = load_landmarks(&path).map_err(Error::from);
    let landmarks = read.and_then(|landmarks| session.subject.renumbered(landmarks));
    let (landmarks, warning) = landmarks.map_err(|error| shared.notices.failed(error)).ok()?;
    warning.into_iter().for_each(|warning| shared.notices.warn(warning));
    Some(landmarks)
}

fn save(session: &Session, settings: &MatchSettings, shared: &mut Shared<'_>) {
    let suggested = session.beside_named("landmarks", "txt");
    let asked = ask_where_to_save(shared.chooser, &[("Landmarks", &["txt"])], &["txt"], &suggested);
    let Some(path) = asked else { return };
    if let Err(why) = check_apart(&path, &session.project().files()) {
        return shared.notices.failed(why);
    }
    let text = write_landmarks(&session.subject.numbered_in_file(&settings.landmarks));
    match chladni_task::write_atomic(&path, text.as_bytes()) {
        Ok(()) => shared.notices.done(format!("Saved {}", path.display())),
        Err(error) => shared.notices.error(format!("{}: {error}", path.display())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_a_long_list_only_the_rows_in_sight_are_laid_out() {
        let sight = |rows: usize, top: f32| in_sight(rows, egui::Rangef::new(100.0, 200.0), top, 20.0);
        assert_eq!(sight(SHORT, -1e6), 0..SHORT);
        assert_eq!(sight(1_000_000, 100.0), 0..5);
        assert_eq!(sight(1_000_000, 150.0), 0..3);
        assert_eq!(sight(1_000_000, -910.0), 50..56);
        assert_eq!(sight(1_000_000, 300.0), 0..0);
        assert_eq!(sight(300, -1e6), 300..300);
    }
}
