//! The look of the dance, and the screen that the stage appears on.

use chladni_view::{Background, Lights, Look, Material, Palette};
use egui::{RichText, Ui};

use super::preferences::{Preferences, Screen};
use crate::studio::theme;

/// Screens that are offered; the system does not tell how many there are.
const SCREENS: usize = 4;

/// Draws the drawer.
pub fn show(ui: &mut Ui, preferences: &mut Preferences, adjusts: &mut bool) {
    let before = preferences.look.clone();
    scene(ui, &mut preferences.look);
    if preferences.look != before {
        // A look is a whole: parts that were chosen for another one go.
        let parts = [
            &mut preferences.palette,
            &mut preferences.material,
            &mut preferences.lights,
            &mut preferences.background,
        ];
        parts.into_iter().for_each(String::clear);
    }
    part(ui, "Material", &mut preferences.material, Material::PRESETS.map(|preset| preset.0));
    part(ui, "Light", &mut preferences.lights, Lights::PRESETS.map(|preset| preset.0));
    part(ui, "Background", &mut preferences.background, Background::PRESETS.map(|preset| preset.0));
    palette(ui, &mut preferences.palette);
    ui.label(RichText::new("Stage").strong());
    let screens = [(Screen::Window, "In the window".to_owned()), (Screen::Full, "This screen".to_owned())];
    let more = (0..SCREENS).map(|i| (Screen::Monitor(i), format!("Screen {}", i + 1)));
    ui.horizontal_wrapped(|ui| {
        for (screen, name) in screens.into_iter().chain(more) {
            ui.selectable_value(&mut preferences.screen, screen, name);
        }
    });
    let tip = "The picture goes into a second window, on that screen; controls and gallery stay here";
    theme::checkbox(ui, &mut preferences.own_window, "In a window of its own").on_hover_text(tip);
    let tip = "Nothing but the dance is shown on stage. Escape comes back. A screen that is not there is \
               left out: the stage then stays where it is.";
    ui.label(RichText::new(tip).small().color(theme::palette(ui).weak));
    ui.add_space(theme::GAP);
    preferences.projection.show(ui, adjusts);
}

/// The whole scene: too many for a row of buttons.
fn scene(ui: &mut Ui, chosen: &mut String) {
    let known = Look::PRESETS.iter().any(|(name, _)| name == chosen);
    let shown = theme::capitalized(if known { chosen } else { "plain" });
    let list = egui::ComboBox::from_id_salt("look").width(160.0).height(480.0).selected_text(shown);
    let response = list.show_ui(ui, |ui| {
        for (name, _) in Look::PRESETS {
            ui.selectable_value(chosen, name.to_owned(), theme::capitalized(name));
        }
    });
    response.response.on_hover_text(
        "The whole scene: what shapes are made of, how movement and music color them, and light",
    );
    ui.add_space(theme::GAP);
}

/// What colors the movement: too many for a row of buttons, too.
fn palette(ui: &mut Ui, chosen: &mut String) {
    let own = "As the look";
    let known =
        Palette::named(chosen).map_or_else(|| own.to_owned(), |palette| theme::capitalized(palette.name()));
    ui.label(RichText::new("Palette").strong());
    let list = egui::ComboBox::from_id_salt("palette").width(160.0).height(480.0).selected_text(known);
    let response = list.show_ui(ui, |ui| {
        ui.selectable_value(chosen, String::new(), own);
        for palette in Palette::ALL {
            ui.selectable_value(chosen, palette.name().to_owned(), theme::capitalized(palette.name()));
        }
    });
    response.response.on_hover_text("The colors of what moves");
    ui.add_space(theme::GAP);
}

/// A part of the look: no name is the look's own.
fn part<const N: usize>(ui: &mut Ui, heading: &str, chosen: &mut String, names: [&str; N]) {
    let all: Vec<&str> = [""].into_iter().chain(names).collect();
    choose(ui, heading, chosen, &all);
}

fn choose(ui: &mut Ui, heading: &str, chosen: &mut String, names: &[&str]) {
    ui.label(RichText::new(heading).strong());
    let choices = |ui: &mut Ui| {
        for name in names {
            let label = if name.is_empty() { "As the look".to_owned() } else { theme::capitalized(name) };
            if ui.selectable_label(chosen == name, label).clicked() {
                *chosen = (*name).to_owned();
            }
        }
    };
    theme::group(ui, heading, |ui| ui.horizontal_wrapped(choices));
    ui.add_space(theme::GAP);
}
