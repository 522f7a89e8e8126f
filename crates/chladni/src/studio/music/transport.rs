//! Song, gallery and meters: the bars around the dancing shapes.

use chladni_music::Action;
use chladni_sound::PlayerState;
use egui::{Color32, Rect, RichText, Slider, Stroke, Ui, pos2};

use super::concert::Concert;
use super::listening::Listening;
use super::{BREED, PLAY};
use crate::studio::icon::{self, Icon};
use crate::studio::theme;

/// What the bar asks of the room.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wish {
    /// Choose songs.
    OpenSong,
    /// Choose another shape.
    OpenShape,
    /// Save the session.
    SaveSession,
}

/// Draws the bar above the gallery.
pub fn show(
    ui: &mut Ui,
    listening: &mut Listening,
    concert: &Concert,
    actions: &mut Vec<Action>,
) -> Option<Wish> {
    let mut wish = None;
    ui.horizontal_centered(|ui| {
        if ui.button(icon::text(Icon::Music)).on_hover_text("Choose songs").clicked() {
            wish = Some(Wish::OpenSong);
        }
        if ui.button(icon::text(Icon::FolderOpen)).on_hover_text("Choose another shape").clicked() {
            wish = Some(Wish::OpenShape);
        }
        if ui.button(icon::text(Icon::Save)).on_hover_text("Save the session, to film it later").clicked() {
            wish = Some(Wish::SaveSession);
        }
        ui.separator();
        song(ui, listening);
        ui.separator();
        breeding(ui, concert, actions);
    });
    wish
}

fn song(ui: &mut Ui, listening: &mut Listening) {
    let status = listening.player().status();
    let mark = if status.state == PlayerState::Playing { Icon::Pause } else { Icon::Play };
    if ui.button(icon::text(mark)).on_hover_text(PLAY.tooltip(ui.ctx())).clicked() {
        listening.toggle();
    }
    if ui.button(icon::text(Icon::SkipForward)).on_hover_text("Next song").clicked() {
        listening.player().next();
    }
    let length = status.duration_secs.unwrap_or(0.0);
    let mut at = status.position_secs;
    ui.spacing_mut().slider_width = 130.0;
    let slider = ui.add_enabled(length > 0.0, Slider::new(&mut at, 0.0..=length.max(0.1)).show_value(false));
    if slider.changed() {
        listening.player().seek(at);
    }
    ui.monospace(format!("{} / {}", clock(status.position_secs), clock(length)));
    ui.add(egui::Label::new(RichText::new(listening.song_name()).color(theme::palette(ui).weak)).truncate());
}

fn breeding(ui: &mut Ui, concert: &Concert, actions: &mut Vec<Action>) {
    let gallery = concert.instrument().gallery();
    let chosen = gallery.items().iter().filter(|item| item.chosen).count();
    let button = egui::Button::new(icon::label(Icon::Heart, "Breed"));
    let tip = format!("{}: choose at least two that you like", BREED.tooltip(ui.ctx()));
    if ui.add_enabled(chosen >= 2, button).on_hover_text(tip.clone()).on_disabled_hover_text(tip).clicked() {
        actions.push(Action::Breed);
    }
    let (current, count) = (gallery.current(), gallery.generations().len());
    let back = egui::Button::new(icon::text(Icon::ChevronLeft));
    if ui.add_enabled(current > 0, back).on_hover_text("The generation before").clicked() {
        actions.push(Action::GoTo { generation: current - 1 });
    }
    ui.label(format!("{} / {count}", current + 1)).on_hover_text("Generation");
    let forth = egui::Button::new(icon::text(Icon::ChevronRight));
    if ui.add_enabled(current + 1 < count, forth).on_hover_text("The generation after").clicked() {
        actions.push(Action::GoTo { generation: current + 1 });
    }
    ui.menu_button(format!("{} items, seed {}", gallery.items().len(), gallery.seed()), |ui| {
        for size in chladni_music::GALLERY_SIZES {
            if ui.button(format!("{size} items")).clicked() {
                actions.push(Action::NewGallery { seed: gallery.seed(), size });
                ui.close();
            }
        }
        if ui.button(icon::label(Icon::Dices, "Another seed")).clicked() {
            actions.push(Action::NewGallery {
                seed: gallery.seed().wrapping_add(1),
                size: gallery.items().len(),
            });
            ui.close();
        }
    });
    let favourites = concert.instrument().favourites().len();
    let button = egui::Button::new(icon::label(Icon::Presentation, "Stage"));
    let tip = "Put the favourites on stage; Escape comes back";
    if ui
        .add_enabled(favourites > 0, button)
        .on_hover_text(tip)
        .on_disabled_hover_text("Favourite a dance first (F)")
        .clicked()
    {
        actions.push(Action::PerformFavourites { first: 0 });
    }
}

/// Draws spectrum and beat below the gallery.
pub fn meters(ui: &mut Ui, listening: &mut Listening) {
    let palette = theme::palette(ui);
    ui.add_space(theme::GAP_SMALL);
    let height = ui.available_height() - theme::GAP_SMALL;
    ui.horizontal(|ui| {
        let width = (ui.available_width() - 190.0).max(120.0);
        let (rect, _) = ui.allocate_exact_size(egui::vec2(width, height), egui::Sense::hover());
        ui.painter().rect_filled(rect, 6.0, ui.visuals().extreme_bg_color);
        let spectrum = listening.spectrum();
        bars(ui, rect, &spectrum.mid, palette.accent.gamma_multiply(0.8));
        bars(ui, rect, &spectrum.side, Color32::from_rgb(120, 190, 220).gamma_multiply(0.6));
        let font = egui::TextStyle::Small.resolve(ui.style());
        ui.painter().text(
            rect.left_top() + egui::vec2(6.0, 4.0),
            egui::Align2::LEFT_TOP,
            "mid · side",
            font,
            palette.weak,
        );
        ui.vertical(|ui| {
            let moment = listening.beat_moment();
            ui.horizontal(|ui| {
                let size = 9.0 * (1.0 - moment.phase as f32).clamp(0.0, 1.0) * moment.confidence as f32 + 2.0;
                let (dot, _) = ui.allocate_exact_size(egui::vec2(24.0, 24.0), egui::Sense::hover());
                ui.painter().circle_filled(dot.center(), size, palette.accent);
                ui.label(format!("{:.0} BPM", moment.tempo_bpm));
            });
            ui.label(
                RichText::new(format!("confidence {:.0} %", moment.confidence * 100.0))
                    .small()
                    .color(palette.weak),
            );
            ui.horizontal(|ui| {
                if ui.small_button("½").on_hover_text("Half as fast").clicked() {
                    listening.follower().halve();
                }
                if ui.small_button("×2").on_hover_text("Twice as fast").clicked() {
                    listening.follower().double();
                }
                if ui.small_button("Tap").on_hover_text(super::TAP.tooltip(ui.ctx())).clicked() {
                    listening.tap();
                }
            });
        });
    });
}

fn bars(ui: &Ui, rect: Rect, values: &[f32], color: Color32) {
    if values.is_empty() {
        return;
    }
    let step = rect.width() / values.len() as f32;
    for (i, value) in values.iter().enumerate() {
        let x = rect.left() + (i as f32 + 0.5) * step;
        let height = rect.height() * value.clamp(0.0, 1.0).sqrt();
        let line = [pos2(x, rect.bottom()), pos2(x, rect.bottom() - height)];
        ui.painter().line_segment(line, Stroke::new((step - 1.0).max(1.0), color));
    }
}

fn clock(secs: f64) -> String {
    let whole = secs.max(0.0) as u64;
    format!("{}:{:02}", whole / 60, whole % 60)
}
