//! The start screen: the samples, the recent files, and what to do next.

use std::path::PathBuf;

use super::icon::{self, Icon};
use super::{Studio, theme};

impl Studio {
    /// Draws the start screen below the top bar.
    pub(super) fn start_screen(&mut self, ui: &mut egui::Ui) {
        let ctx = ui.ctx().clone();
        let mut chosen: Option<(usize, Vec<PathBuf>)> = None;
        egui::CentralPanel::default().show(ui, |ui| {
            ui.vertical_centered(|ui| {
                ui.add_space((ui.available_height() * 0.16).max(24.0));
                ui.label(egui::RichText::new("What would you like to play?").text_style(theme::title()));
                ui.label(
                    egui::RichText::new("Drop meshes, a song or a project anywhere on this window.")
                        .color(theme::palette(ui).weak),
                );
                ui.add_space(theme::GAP_LARGE * 2.0);
                let width = 300.0 * self.rooms.len() as f32 + theme::GAP_LARGE;
                ui.allocate_ui(egui::vec2(width, 150.0), |ui| {
                    ui.horizontal(|ui| {
                        for (index, room) in self.rooms.iter().enumerate() {
                            if room_card(ui, room.icon(), room.name(), room.invitation()) {
                                chosen = Some((index, Vec::new()));
                            }
                        }
                    });
                });
                ui.add_space(theme::GAP_LARGE * 2.0);
                if let Some(path) = recent_files(ui, &self.settings.recent) {
                    let room = self.rooms.iter().position(|room| room.claims(&path)).unwrap_or(0);
                    chosen = Some((room, vec![path]));
                }
            });
        });
        if let Some((index, files)) = chosen {
            self.current = Some(index);
            if !files.is_empty() {
                self.with_room(&ctx, index, |room, shared| room.open(&files, shared));
            }
        }
    }
}

/// A large card that opens a room; true when clicked.
fn room_card(ui: &mut egui::Ui, mark: Icon, name: &str, invitation: &str) -> bool {
    let palette = theme::palette(ui);
    let (rect, response) = ui.allocate_exact_size(egui::vec2(300.0, 150.0), egui::Sense::click());
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, format!("Open {name}")));
    let line = if response.hovered() { palette.accent } else { palette.line };
    ui.painter().rect(rect, 10.0, palette.card, egui::Stroke::new(1.0, line), egui::StrokeKind::Inside);
    let mut inside = ui.new_child(
        egui::UiBuilder::new().max_rect(rect.shrink(18.0)).layout(egui::Layout::top_down(egui::Align::LEFT)),
    );
    inside.label(egui::RichText::new(icon::text(mark)).size(34.0).color(palette.accent));
    inside.label(egui::RichText::new(name).text_style(egui::TextStyle::Heading).strong());
    inside
        .add(egui::Label::new(egui::RichText::new(invitation).color(palette.weak)).wrap().selectable(false));
    response.clicked()
}

fn recent_files(ui: &mut egui::Ui, recent: &[PathBuf]) -> Option<PathBuf> {
    if recent.is_empty() {
        return None;
    }
    let mut chosen = None;
    ui.label(egui::RichText::new("Recent").strong());
    for path in recent {
        let name = path
            .file_name()
            .map_or_else(|| path.display().to_string(), |name| name.to_string_lossy().into_owned());
        let row = ui.add(egui::Button::new(icon::label(Icon::History, &name)).frame(false));
        if row.on_hover_text(path.display().to_string()).clicked() {
            chosen = Some(path.clone());
        }
    }
    chosen
}
