//! The bar above the stage: file, history, view and look.

use chladni_caricature::Action;
use chladni_view::{ColorMap, Lights, Material};
use egui::Ui;

use super::CaricatureRoom;
use super::edits::Edit;
use super::landmarks::Picking;
use super::look::Show;
use super::stage::Stage;
use crate::studio::author_id::AuthorId;
use crate::studio::icon::{self, Icon};
use crate::studio::keys::caricature::{EXPORT, FIT, GALLERY, INK, NEXT_SHOW, OPEN, REDO, SAVE, UNDO, WIRE};
use crate::studio::room::Shared;
use crate::studio::theme;
use crate::work::landmarks::HALF_A_LANDMARK;
use crate::work::{Quantity, USUAL_TONES};

impl CaricatureRoom {
    /// Draws the bar.
    pub(super) fn toolbar(&mut self, ui: &mut Ui, shared: &mut Shared<'_>) {
        egui::Panel::top("caricature toolbar").resizable(false).show(ui, |ui| {
            ui.add_space(2.0);
            // In a narrow window a second row is better than buttons out of reach.
            ui.horizontal_wrapped(|ui| {
                ui.spacing_mut().item_spacing.x = 5.0;
                self.file_buttons(ui, shared);
                ui.separator();
                self.show_buttons(ui);
                ui.separator();
                self.look_menus(ui);
            });
            ui.add_space(2.0);
        });
    }

    fn file_buttons(&mut self, ui: &mut Ui, shared: &mut Shared<'_>) {
        let ctx = ui.ctx().clone();
        if ui.button(icon::text(Icon::FolderOpen)).on_hover_text(OPEN.tooltip(&ctx)).clicked() {
            self.choose_file(shared);
        }
        let change = ui.add_enabled(self.session.is_some(), egui::Button::new(icon::text(Icon::Replace)));
        let tip =
            "The same layers on another shape, as a new project: regions and landmarks are carried over";
        if change.accessible_name("Another shape").author_id("another-shape").on_hover_text(tip).clicked() {
            self.change_shape(shared);
        }
        let modified = self.session.as_ref().is_some_and(|session| session.history.is_modified());
        let save = egui::Button::new(icon::text(Icon::Save));
        let save = ui.add_enabled(modified, save).author_id("save");
        if save.on_hover_text(SAVE.tooltip(&ctx)).clicked() {
            self.save(false, shared);
        }
        let export = egui::Button::new(icon::label(Icon::Share, "Export"));
        if ui.add_enabled(self.session.is_some(), export).on_hover_text(EXPORT.tooltip(&ctx)).clicked() {
            self.export();
        }
        // The project being loaded will replace the open one.
        let loading = self.loading.is_some();
        let Some(session) = &self.session else { return };
        let is_half = self.picking.as_ref().is_some_and(Picking::has_pending);
        let undo = if is_half { Some(HALF_A_LANDMARK) } else { session.history.undo_label() };
        let mut travels = None;
        for (back, mark, shortcut, label) in
            [(true, Icon::Undo2, UNDO, undo), (false, Icon::Redo2, REDO, session.history.redo_label())]
        {
            let button = ui.add_enabled(label.is_some() && !loading, egui::Button::new(icon::text(mark)));
            let button = button.author_id(if back { "undo" } else { "redo" });
            let tip = format!("{}: {}", shortcut.tooltip(&ctx), label.unwrap_or("nothing"));
            if button.on_hover_text(tip).clicked() {
                travels = Some(back);
            }
        }
        if let Some(back) = travels {
            self.travel(back);
        }
    }

    /// Undoes or redoes a step.
    pub(super) fn travel(&mut self, back: bool) {
        // Half a landmark is not in the history yet: it is taken back first.
        if back && self.picking.as_mut().is_some_and(Picking::drop_pending) {
            return;
        }
        self.stale |= self.session.as_mut().is_some_and(|session| session.travel(back).is_some());
    }

    fn show_buttons(&mut self, ui: &mut Ui) {
        let before = self.look.show;
        for (show, mark, tip) in [
            (Show::Result, Icon::User, "The result"),
            (Show::Models, Icon::Users, "The selected layer in all three models; click one to choose it"),
            (Show::BeforeAfter, Icon::Columns2, "Before and after"),
            (Show::Template, Icon::GitCompareArrows, "The result beside the template of the selected layer"),
        ] {
            let tip = format!("{tip} ({})", ui.ctx().format_shortcut(&NEXT_SHOW.keys));
            ui.selectable_value(&mut self.look.show, show, icon::text(mark)).on_hover_text(tip);
        }
        self.stale |= self.look.show != before;
        if self.session.is_none() || self.loading.is_some() {
            return;
        }
        let button = ui.selectable_label(self.gallery.is_open(), icon::text(Icon::LayoutGrid));
        if button.on_hover_text(GALLERY.tooltip(ui.ctx())).clicked() {
            if self.gallery.is_open() { self.gallery.close() } else { self.gallery.open() }
        }
    }

    fn look_menus(&mut self, ui: &mut Ui) {
        ui.toggle_value(&mut self.look.wire, icon::text(Icon::Grid3x3)).on_hover_text(WIRE.tooltip(ui.ctx()));
        let ghost = ui.toggle_value(&mut self.look.ghost, icon::text(Icon::Ghost));
        let tip = "The template of the selected layer over the shape, as a ghost; ink does not draw it";
        self.stale |=
            ghost.accessible_name("Ghost of the template").author_id("ghost").on_hover_text(tip).changed();
        let (mut quantity, mut harmonic, mut map) =
            (self.heat.quantity(), self.heat.harmonic(), self.heat.map());
        let name = Quantity::ALL.iter().find(|(q, _)| *q == quantity).map_or("", |(_, name)| name);
        let choice =
            // High enough for all choices, because no scroll bar would show that there are more.
            egui::ComboBox::from_id_salt("heat").width(136.0).height(520.0).selected_text(name).show_ui(ui, |ui| {
                let has_own = self.stage.as_ref().is_some_and(Stage::has_own_look);
                for (choice, name) in Quantity::ALL.into_iter().filter(|q| q.0 != Quantity::Own || has_own) {
                    let button = ui.selectable_value(&mut quantity, choice, name);
                    button.author_id(format!("colors/{choice:?}").to_lowercase());
                }
                ui.separator();
                for choice in [ColorMap::Viridis, ColorMap::Cividis, ColorMap::Magma] {
                    ui.selectable_value(&mut map, choice, choice.name());
                }
            });
        choice.response.accessible_name("What colors show").author_id("colors");
        if quantity == Quantity::Harmonic {
            let top = self.session.as_ref().map_or(1, |session| session.stack.body().basis.harmonics()) - 1;
            let number = theme::number(&mut harmonic).range(0..=top).prefix("H ");
            ui.add(number).accessible_name("Harmonic");
        }
        self.heat.choose(quantity, harmonic, map);
        let material = self.look.material;
        let look = ui.menu_button(icon::label(Icon::Lightbulb, "Look"), |ui| {
            ui.toggle_value(&mut self.look.ink, "Ink on paper").on_hover_text(INK.tooltip(ui.ctx()));
            let mut tones = self.look.pen.ink.tones > 0;
            let flat = ui.toggle_value(&mut tones, "Flat tones").author_id("flat-tones");
            if flat.on_hover_text("In ink: light as three flat tones instead of hatching").changed() {
                self.look.pen = self.look.pen.toned(if tones { USUAL_TONES } else { 0 });
            }
            ui.separator();
            ui.label(egui::RichText::new("Material").color(theme::palette(ui).weak));
            for (index, (name, _)) in Material::PRESETS.iter().enumerate() {
                ui.selectable_value(&mut self.look.material, index, theme::capitalized(name))
                    .author_id(format!("material/{name}"));
            }
            ui.separator();
            ui.label(egui::RichText::new("Light").color(theme::palette(ui).weak));
            for (index, (name, _)) in Lights::PRESETS.iter().enumerate() {
                ui.selectable_value(&mut self.look.lights, index, theme::capitalized(name));
            }
        });
        look.response.author_id("look");
        // The bare places of a region have the material's color.
        self.stale |= self.look.material != material;
        if ui.button(icon::text(Icon::Maximize)).on_hover_text(FIT.tooltip(ui.ctx())).clicked()
            && let Some(stage) = &mut self.stage
        {
            stage.fit();
        }
        self.stance_menu(ui);
    }

    /// Sets which way is up, in case the estimate is wrong.
    fn stance_menu(&mut self, ui: &mut Ui) {
        let Some(session) = self.session.as_mut().filter(|_| self.loading.is_none()) else { return };
        let mut standing = session.standing();
        let doubt = if standing.is_in_doubt() { " Up?" } else { "" };
        if standing.menu(ui, format!("{}{doubt}", icon::text(Icon::ArrowUp)))
            && session.apply(vec![Edit::Once(Action::Stand(standing.given))]).is_ok()
        {
            self.stale = true;
        }
    }
}
