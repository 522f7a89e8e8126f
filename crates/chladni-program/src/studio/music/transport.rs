//! Files, song and gallery: the bar above the dancing shapes.

use chladni_mesh::samples::SAMPLES;
use chladni_music::{Action, Switch};
use chladni_task::counted;
use egui::{RichText, ScrollArea, Ui};

use super::concert::Concert;
use super::film;
use super::listening::Listening;
use super::view::View;
use super::wish::{Then, Wish};
use crate::studio::author_id::AuthorId;
use crate::studio::context_menu;
use crate::studio::icon::{self, Icon};
use crate::studio::keys::music::{
    BACK, BREED, FILM, FORTH, NEXT_SONG, OPEN, PLAY, PREVIOUS_SONG, SAVE, SHOW,
};
use crate::studio::shortcut::Shortcut;
use crate::studio::theme;
use crate::work::source::sample_path;

/// The width of the slider through a song, where there is room and where there is not.
const SEEK_WIDTH: [f32; 2] = [110.0, 40.0];
/// A song's name with less room than this is left out.
const SHORTEST_NAME: f32 = 20.0;

/// Draws the bar.
pub fn show(ui: &mut Ui, listening: &mut Listening, concert: &Concert, wishes: &mut Vec<Wish>) {
    let kept = egui::Id::unique("transport-right");
    ui.horizontal_centered(|ui| {
        files(ui, concert, wishes);
        recording(ui, concert, wishes);
        camera(ui, concert);
        ui.separator();
        // The buttons on the right are laid out later: they take as much room as in the frame before.
        let right = ui.data(|data| data.get_temp::<f32>(kept)).unwrap_or(0.0);
        song(ui, listening, right);
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            stage(ui, concert, wishes);
            breeding(ui, concert, wishes);
            ui.separator();
            let right = ui.min_rect().width();
            ui.data_mut(|data| data.insert_temp(kept, right));
            if ui.available_width() < SHORTEST_NAME {
                return;
            }
            ui.with_layout(egui::Layout::left_to_right(egui::Align::Center), |ui| {
                let name = RichText::new(listening.source_name()).color(theme::palette(ui).weak);
                ui.add(egui::Label::new(name).truncate());
            });
        });
    });
}

/// Says that it is recorded and for how long, and ends the recording on a click.
fn recording(ui: &mut Ui, concert: &Concert, wishes: &mut Vec<Wish>) {
    let Some(recorder) = &concert.outgoing.recorder else { return };
    let (secs, left_out) = recorder.progress(ui.input(|input| input.time));
    if recorder.ends() {
        let saving = egui::Button::new(icon::label(Icon::Circle, "Saving …"));
        let saving = ui.add_enabled(false, saving).author_id("recording-saving");
        saving.on_disabled_hover_text(format!("The recording of {} is being written", clock(secs)));
        return;
    }
    let text = RichText::new(icon::label(Icon::Circle, &clock(secs))).color(theme::palette(ui).error);
    let tip = match left_out {
        0 => "Recording: end it".to_owned(),
        _ => format!("Recording, {} left out so far: end it", counted(left_out, "picture", "pictures")),
    };
    let end = ui.button(text).accessible_name("End the recording").author_id("recording-end");
    if end.on_hover_text(tip).clicked() {
        wishes.push(Wish::Record);
    }
}

/// Says that other programs see the stage.
fn camera(ui: &mut Ui, concert: &Concert) {
    let Some(camera) = concert.outgoing.camera() else { return };
    let sent = counted(camera.sent(), "picture", "pictures");
    let left_out = counted(camera.left_out(), "was", "were");
    let tip = format!(
        "Other programs see the stage as the camera Chladni: {sent} went out, {left_out} followed by another \
         one too soon. Drawer Look ends it."
    );
    ui.label(icon::text(Icon::Camera)).author_id("camera-out").on_hover_text(tip);
}

fn files(ui: &mut Ui, concert: &Concert, wishes: &mut Vec<Wish>) {
    let menu = ui.menu_button(icon::label(Icon::FolderOpen, "File"), |ui| {
        for (id, mark, name, tip, wish) in [
            ("open", Icon::FolderOpen, "Open …", OPEN.tooltip(ui.ctx()), Wish::Choose(Then::Open)),
            (
                "add-songs",
                Icon::Music,
                "Add songs …",
                "To the end of the list".into(),
                Wish::Choose(Then::AddSongs),
            ),
            (
                "save-show",
                Icon::Save,
                "Save show …",
                format!("{}: all that was done, to go on with or to film later", SAVE.tooltip(ui.ctx())),
                Wish::Choose(Then::SaveShow),
            ),
            (
                "record",
                Icon::Circle,
                if concert.outgoing.is_recording() { "End the recording" } else { "Record the set …" },
                "Picture and sound as they are played now, to an MP4".into(),
                Wish::Record,
            ),
            (
                "film",
                Icon::Clapperboard,
                "Film …",
                format!("{} ({})", film::TIP, FILM.text(ui.ctx())),
                Wish::Film,
            ),
        ] {
            let button = ui.button(icon::label(mark, name)).author_id(format!("file/{id}"));
            if button.on_hover_text(tip).clicked() {
                wishes.push(wish);
                ui.close();
            }
        }
        ui.separator();
        let samples = ui.menu_button("Samples", |ui| {
            for name in SAMPLES {
                let button = ui.button(theme::capitalized(name)).author_id(format!("sample/{name}"));
                if button.clicked() {
                    wishes.push(Wish::Open(sample_path(name)));
                    ui.close();
                }
            }
        });
        samples.response.author_id("samples");
    });
    menu.response.author_id("file");
}

/// The song that plays; `right` is the width that is needed on the right of it.
fn song(ui: &mut Ui, listening: &mut Listening, right: f32) {
    let back =
        ui.button(icon::text(Icon::SkipBack)).accessible_name("Previous song").author_id("previous-song");
    if back.on_hover_text(PREVIOUS_SONG.tooltip(ui.ctx())).clicked() {
        listening.previous_song(true);
    }
    let status = listening.status();
    let playing = listening.plays_songs();
    let mark = if playing { Icon::Pause } else { Icon::Play };
    let button = ui.button(icon::text(mark)).accessible_name(if playing { "Pause" } else { "Play" });
    let button = button.author_id("play");
    if button.on_hover_text(PLAY.tooltip(ui.ctx())).clicked() {
        listening.toggle();
    }
    let next = ui.button(icon::text(Icon::SkipForward)).accessible_name("Next song").author_id("next-song");
    if next.on_hover_text(NEXT_SONG.tooltip(ui.ctx())).clicked() {
        listening.next_song(true);
    }
    if listening.live().is_some() {
        ui.label(icon::label(Icon::Mic, "Live"));
        return;
    }
    let length = status.duration_secs.unwrap_or(0.0);
    let mut at = status.position_secs;
    let time = format!("{} / {}", clock(status.position_secs), clock(length));
    let font = egui::TextStyle::Monospace.resolve(ui.style());
    let time_width = ui.painter().layout_no_wrap(time.clone(), font, egui::Color32::WHITE).size().x;
    let gaps = 2.0 * ui.spacing().item_spacing.x;
    let [most, least] = SEEK_WIDTH;
    ui.spacing_mut().slider_width = (ui.available_width() - time_width - gaps - right).clamp(least, most);
    let slider = theme::slider(&mut at, 0.0..=length.max(0.1)).show_value(false);
    let slider = ui.add_enabled(length > 0.0, slider).author_id("seek").on_hover_text("Where in the song");
    if length > 0.0 && slider.changed() {
        listening.player().seek(at);
    }
    ui.monospace(time).author_id("time");
}

/// From right to left.
fn stage(ui: &mut Ui, concert: &Concert, wishes: &mut Vec<Wish>) {
    let favorites = concert.instrument().favorites().len();
    let button = egui::Button::new(icon::label(Icon::Presentation, "Stage"));
    let button = ui
        .add_enabled(favorites > 0, button)
        .author_id("perform-favorites")
        .on_hover_text(SHOW.tooltip(ui.ctx()))
        .on_disabled_hover_text("Favorite a dance first: mark it and press F");
    if button.clicked() {
        wishes.push(Wish::Do(Action::PerformFavorites { first: 0 }));
    }
}

/// From right to left.
fn breeding(ui: &mut Ui, concert: &Concert, wishes: &mut Vec<Wish>) {
    let gallery = concert.instrument().gallery();
    sizes(ui, concert, wishes);
    step(ui, Icon::ChevronRight, FORTH, gallery.forth(), wishes);
    generations(ui, concert, wishes);
    step(ui, Icon::ChevronLeft, BACK, gallery.back(), wishes);
    let chosen = gallery.items().iter().filter(|item| item.chosen).count();
    let name = if chosen == 0 { "Breed".into() } else { format!("Breed {chosen}") };
    let button = egui::Button::new(icon::label(Icon::Heart, &name));
    let suggests = concert.instrument().parameters().is_on(Switch::Suggest);
    let (least, least_words) = if suggests { (1, "one") } else { (2, "two") };
    let tip = format!("{}: click at least {least_words} that you like", BREED.tooltip(ui.ctx()));
    suggesting(ui, suggests, wishes);
    if concert.is_judging() {
        ui.spinner();
    }
    if ui
        .add_enabled(chosen >= least && !concert.is_judging(), button)
        .author_id("breed")
        .on_hover_text(tip.clone())
        .on_disabled_hover_text(tip)
        .clicked()
    {
        wishes.push(Wish::Do(Action::Breed));
    }
}

/// The button to a neighboring generation, where there is one.
fn step(ui: &mut Ui, mark: Icon, key: Shortcut, to: Option<usize>, wishes: &mut Vec<Wish>) {
    let button = ui.add_enabled(to.is_some(), egui::Button::new(icon::text(mark)));
    if button.on_hover_text(key.tooltip(ui.ctx())).clicked() {
        wishes.extend(to.map(|generation| Wish::Do(Action::GoTo { generation })));
    }
}

/// Whether children are suggested, and the way to forget past choices.
fn suggesting(ui: &mut Ui, on: bool, wishes: &mut Vec<Wish>) {
    let tip = "Suggest children that differ most and are most like what you chose so far. Right click: forget \
               what was chosen.";
    let button = egui::Button::selectable(on, icon::text(Icon::Sparkles));
    let response = ui.add(button).on_hover_text(tip);
    response.widget_info(|| egui::WidgetInfo::selected(egui::Role::CheckBox, true, on, "Suggest children"));
    let response = response.author_id("suggest-children");
    if response.clicked() {
        wishes.push(Wish::Do(Action::Switch { switch: Switch::Suggest, on: !on }));
    }
    context_menu::show(&response, |ui| {
        if context_menu::entry(ui, true, "Forget what was chosen").clicked() {
            wishes.push(Wish::Do(Action::ForgetPreference));
        }
    });
}

/// The way back to any generation.
fn generations(ui: &mut Ui, concert: &Concert, wishes: &mut Vec<Wish>) {
    let gallery = concert.instrument().gallery();
    let (current, count) = (gallery.current(), gallery.generations().len());
    ui.menu_button(format!("{} / {count}", current + 1), |ui| {
        ScrollArea::vertical().max_height(400.0).show(ui, |ui| {
            for (index, generation) in gallery.generations().iter().enumerate().rev() {
                let from = match generation.from {
                    Some(from) => format!("{}, from {}", index + 1, from + 1),
                    None => "1, the beginning".into(),
                };
                let button = ui.selectable_label(index == current, format!("Generation {from}"));
                if button.author_id(format!("generation/{}", index + 1)).clicked() {
                    wishes.push(Wish::Do(Action::GoTo { generation: index }));
                    ui.close();
                }
            }
        });
    })
    .response
    .author_id("generations")
    .on_hover_text("All generations: go back to any");
}

fn sizes(ui: &mut Ui, concert: &Concert, wishes: &mut Vec<Wish>) {
    let gallery = concert.instrument().gallery();
    let (seed, size) = (gallery.seed(), gallery.items().len());
    ui.menu_button(format!("{size} items"), |ui| {
        let mut entry = |ui: &mut Ui, id: &str, name: String, wish: Option<Wish>| {
            if ui.button(name).author_id(format!("gallery/{id}")).clicked() {
                wishes.extend(wish);
                ui.close();
            }
        };
        for choice in chladni_music::GALLERY_SIZES {
            // The size it has would bring the first generation again, and take the others away.
            let wish = (choice != size).then_some(Wish::Do(Action::NewGallery { seed, size: choice }));
            entry(ui, &choice.to_string(), format!("{choice} items"), wish);
        }
        let another = Action::NewGallery { seed: gallery.next_seed(), size };
        entry(ui, "seed", icon::label(Icon::Dices, "Another seed"), Some(Wish::Do(another)));
        let first = concert.harmonics().first_waving();
        ui.separator();
        entry(
            ui,
            "harmonics",
            icon::label(Icon::FlipHorizontal2, "Harmonics and symmetry"),
            Some(Wish::Show(View::Harmonics(first))),
        );
    })
    .response
    .author_id("gallery")
    .on_hover_text(format!("How many dances there are; the seed of all that is random is {seed}"));
}

fn clock(secs: f64) -> String {
    let whole = secs.max(0.0) as u64;
    format!("{}:{:02}", whole / 60, whole % 60)
}
