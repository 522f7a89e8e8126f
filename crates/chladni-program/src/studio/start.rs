//! The start screen: the rooms, the samples, the recent files, and what to do next.

use std::path::PathBuf;

use chladni_mesh::samples::SAMPLES;
use egui::{Align, Layout, RichText, Sense, Stroke, StrokeKind, Ui, UiBuilder, Vec2, vec2};

use super::author_id::AuthorId;
use super::card::card;
use super::choose::takes_drops;
use super::icon::{self, Icon};
use super::keys::start::OPEN;
use super::{Studio, theme};
use crate::work::shown_name;
use crate::work::source::sample_path;

/// Width of the column that everything stands in.
const COLUMN: f32 = 704.0;
/// The card of a file: a picture over a name.
const CARD: Vec2 = vec2(164.0, 138.0);
/// The card of a sample: six stand in a row.
const SAMPLE_CARD: Vec2 = vec2(104.0, 98.0);

/// The choice by a click: a room, and the files to open in it.
type Choice = (usize, Vec<PathBuf>);

impl Studio {
    /// Draws the start screen below the top bar.
    pub(super) fn start_screen(&mut self, ui: &mut Ui) {
        let ctx = ui.ctx().clone();
        let mut chosen: Option<Choice> = None;
        egui::CentralPanel::default().show(ui, |ui| {
            egui::ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
                let space = (ui.available_height() * 0.07).max(20.0);
                let column = COLUMN.min(ui.available_width());
                let left = (ui.available_width() - column) / 2.0;
                ui.add_space(space);
                ui.horizontal_top(|ui| {
                    ui.add_space(left);
                    ui.allocate_ui_with_layout(vec2(column, 0.0), Layout::top_down(Align::LEFT), |ui| {
                        ui.set_width(column);
                        chosen = self.start_column(ui);
                    });
                });
                ui.add_space(space);
            });
        });
        if let Some((index, files)) = chosen {
            self.current = Some(index);
            if !files.is_empty() {
                self.with_room(&ctx, index, |room, shared| room.open_anew(&files, shared));
            }
        }
    }

    fn start_column(&mut self, ui: &mut Ui) -> Option<Choice> {
        let weak = theme::palette(ui).weak;
        let mut chosen = None;
        ui.label(RichText::new("What would you like to play?").text_style(theme::title()));
        let invitation = if takes_drops() {
            "Drop meshes, a song or a project anywhere on this window, or begin with one of these."
        } else {
            "Open meshes, a song or a project, or begin with one of these. (Under Wayland, nothing can be dropped here.)"
        };
        ui.horizontal(|ui| {
            ui.label(RichText::new(invitation).color(weak));
            ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                let button = ui.button(icon::label(Icon::FolderOpen, "Open…"));
                if button.on_hover_text(OPEN.tooltip(ui.ctx())).clicked() || OPEN.pressed(ui.ctx()) {
                    chosen = self.ask_for_files();
                }
            });
        });
        ui.add_space(theme::GAP_LARGE);
        ui.horizontal(|ui| {
            ui.spacing_mut().item_spacing.x = theme::GAP_LARGE;
            let width = (COLUMN - theme::GAP_LARGE) / 2.0;
            for (index, room) in self.rooms.iter().enumerate() {
                let card = room_card(ui, width, room.icon(), room.name(), room.invitation());
                if card.author_id(format!("room/{index}")).clicked() {
                    chosen = Some((index, Vec::new()));
                }
            }
        });
        heading(ui, "Samples");
        ui.horizontal_wrapped(|ui| {
            ui.spacing_mut().item_spacing = Vec2::splat(theme::GAP_LARGE);
            for name in SAMPLES {
                let picture = self.pictures.of_sample(ui.ctx(), name);
                let card =
                    card(ui, SAMPLE_CARD, picture.as_ref(), Icon::Box, "Open", &theme::capitalized(name));
                if self.pictures.awaits_sample(name) {
                    ui.ctx().accesskit_node_builder(card.id, egui::accesskit::Node::set_busy);
                }
                if card.clicked() {
                    chosen = Some((0, vec![sample_path(name)]));
                }
            }
        });
        if !self.settings.recent.is_empty() {
            heading(ui, "Recent");
            ui.horizontal_wrapped(|ui| {
                ui.spacing_mut().item_spacing = Vec2::splat(theme::GAP_LARGE);
                chosen = self.recent_cards(ui).or(chosen.take());
            });
        }
        chosen
    }

    /// Asks for files, and which room they are meant for.
    fn ask_for_files(&mut self) -> Option<Choice> {
        let extensions: Vec<&str> = self.rooms.iter().flat_map(|room| room.extensions()).collect();
        let files = self.chooser.open_several(&[("Meshes, songs and projects", &extensions)]);
        let meant = self.rooms.iter().position(|room| files.iter().any(|path| room.claims(path)));
        (!files.is_empty()).then_some((meant.unwrap_or(0), files))
    }

    fn recent_cards(&mut self, ui: &mut Ui) -> Option<Choice> {
        let mut chosen = None;
        for path in self.settings.recent.clone() {
            let name = shown_name(&path).into_owned();
            let picture = self.pictures.of_file(ui.ctx(), &path);
            let room = self.rooms.iter().position(|room| room.claims(&path)).unwrap_or(0);
            let mark = self.rooms.get(room).map_or(Icon::File, |room| room.icon());
            let clicked = card(ui, CARD, picture.as_ref(), mark, "Open", &name)
                .on_hover_text(path.display().to_string());
            if clicked.clicked() {
                if path.exists() {
                    chosen = Some((room, vec![path]));
                } else {
                    self.notices.error(format!("{} is not there any more.", path.display()));
                    self.settings.recent.retain(|known| *known != path);
                }
            }
        }
        chosen
    }
}

fn heading(ui: &mut Ui, name: &str) {
    ui.add_space(theme::GAP_LARGE);
    ui.label(RichText::new(name).text_style(egui::TextStyle::Heading));
    ui.add_space(theme::GAP_SMALL);
}

/// A large card that opens a room.
fn room_card(ui: &mut Ui, width: f32, mark: Icon, name: &str, invitation: &str) -> egui::Response {
    let palette = theme::palette(ui);
    let (rect, response) = ui.allocate_exact_size(vec2(width, 108.0), Sense::click());
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, format!("Open {name}")));
    let line = if response.hovered() { palette.accent } else { palette.line };
    ui.painter().rect(rect, 10.0, palette.card, Stroke::new(1.0, line), StrokeKind::Inside);
    let mut inside =
        ui.new_child(UiBuilder::new().max_rect(rect.shrink(16.0)).layout(Layout::top_down(Align::LEFT)));
    inside.horizontal(|ui| {
        ui.label(RichText::new(icon::text(mark)).size(28.0).color(palette.accent));
        ui.label(RichText::new(name).size(19.0).strong());
    });
    inside.add(egui::Label::new(RichText::new(invitation).color(palette.weak)).wrap().selectable(false));
    response
}
