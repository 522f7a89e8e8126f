//! How a shape stands in a room, and the menu that corrects it.

use chladni_mesh::{Axis, Orientation};
use egui::{Button, RichText, Ui};

use super::author_id::AuthorId;
use super::theme;

/// How a shape stands.
#[derive(Clone, Copy, Debug)]
pub struct Standing {
    /// As the shape's own file or an estimate says.
    pub found: Orientation,
    /// Whether that is in doubt.
    pub in_doubt: bool,
    /// What was set in its place.
    pub given: Option<Orientation>,
}

impl Standing {
    /// How it stands now.
    pub fn now(&self) -> Orientation {
        self.given.unwrap_or(self.found)
    }

    /// Whether the user should look at how it stands.
    pub fn is_in_doubt(&self) -> bool {
        self.given.is_none() && self.in_doubt
    }

    /// Draws a button with the menu that sets how the shape stands, in case the estimate is wrong; true where that was
    /// changed.
    pub fn menu(&mut self, ui: &mut Ui, label: String) -> bool {
        let (before, now) = (self.given, self.now());
        let menu = ui.menu_button(label, |ui| {
            ui.label(RichText::new("Up is").color(theme::palette(ui).weak));
            for axis in Axis::ALL {
                let button = ui.selectable_label(Axis::of(now.up()) == Some(axis), axis.to_string());
                if button.author_id(format!("stance/{axis}")).clicked() {
                    self.given = Some(now.with_up(axis));
                }
            }
            ui.separator();
            if ui.button("Turn the front by a quarter").author_id("stance/quarter").clicked() {
                self.given = Some(now.quarters(1));
            }
            let estimated = ui.add_enabled(before.is_some(), Button::new("As estimated"));
            if estimated.author_id("stance/estimated").clicked() {
                self.given = None;
            }
        });
        let tip =
            format!("Which way is up: {now}. Exports keep the file's axes; viewers take y for up in a GLB.");
        let button = menu.response.accessible_name(format!("Which way is up: {now}"));
        button.author_id("stance").on_hover_text(tip);
        self.given != before
    }
}
