//! The bar at the top: the way to the start screen and to the rooms, and controls for the whole window.

use super::icon::{self, Icon};
use super::keys::window::HELP;
use super::{Studio, theme};

impl Studio {
    pub(super) fn top_bar(&mut self, ui: &mut egui::Ui) {
        egui::Panel::top("top bar").resizable(false).exact_size(42.0).show(ui, |ui| {
            ui.horizontal_centered(|ui| {
                let palette = theme::palette(ui);
                let home = ui
                    .add(
                        egui::Button::new(
                            egui::RichText::new("Chladni").size(16.0).strong().color(palette.accent),
                        )
                        .frame(false),
                    )
                    .on_hover_text("Start screen");
                if home.clicked() {
                    self.current = None;
                }
                ui.add_space(theme::GAP_LARGE);
                for (index, room) in self.rooms.iter().enumerate() {
                    let label = icon::label(room.icon(), room.name());
                    if ui.selectable_label(self.current == Some(index), label).clicked() {
                        self.current = Some(index);
                    }
                }
                ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                    self.window_buttons(ui)
                });
            });
        });
    }

    fn window_buttons(&mut self, ui: &mut egui::Ui) {
        if ui.button(icon::text(Icon::Keyboard)).on_hover_text(HELP.tooltip(ui.ctx())).clicked() {
            self.key_sheet.open = !self.key_sheet.open;
        }
        let (mark, tip) =
            if self.settings.light { (Icon::Moon, "Dark theme") } else { (Icon::Sun, "Light theme") };
        if ui.button(icon::text(mark)).on_hover_text(tip).clicked() {
            self.settings.light = !self.settings.light;
        }
    }
}
