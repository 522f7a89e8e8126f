//! The look of the dance, and the screen that the stage appears on.

use chladni_music::{Instrument, Looks};
use chladni_view::film::{HAS_SYPHON, video_devices};
use chladni_view::{Background, Effect, Finish, Lights, Look, Material, Palette};
use egui::{RichText, Ui};

use std::path::Path;

use super::preferences::{Camera, CameraSize, Screen, with_lasting};
use super::wish::{Then, Wish};
use crate::studio::author_id::AuthorId;
use crate::studio::icon::{self, Icon};
use crate::studio::room::Shared;
use crate::studio::standing::Standing;
use crate::studio::theme;
use crate::work::OWN_COLORS;

/// The names of the look that is seen: that of the dance on stage in place of the show's, as
/// [`look_on_stage`](crate::work::look_on_stage) puts it there. Pictures around the stage, a shape's own colors and what is
/// left out stay.
pub fn seen(instrument: &Instrument, of_show: Looks) -> Looks {
    let Some(look) = instrument.look().filter(|look| Look::named(look).is_some()) else { return of_show };
    let palette = if of_show.palette == OWN_COLORS { OWN_COLORS.to_owned() } else { String::new() };
    with_lasting(Looks { look: look.to_owned(), palette, ..Looks::default() }, &of_show)
}

/// Draws the drawer.
pub fn show(
    ui: &mut Ui,
    shared: &mut Shared<'_>,
    (mut standing, has_own_colors): (Standing, bool),
    adjusts: &mut bool,
    wishes: &mut Vec<Wish>,
) {
    let preferences = &mut shared.settings.music;
    let mut look = preferences.look.clone();
    ui.horizontal(|ui| {
        scene(ui, &mut look);
        let up = if standing.is_in_doubt() { "Up?" } else { "Up" };
        if standing.menu(ui, icon::label(Icon::ArrowUp, up)) {
            wishes.push(Wish::Stand(standing.given));
        }
    });
    ui.add_space(theme::GAP);
    if look != preferences.look {
        preferences.put_on(look);
    }
    part(ui, "material", &mut preferences.material, Material::PRESETS.map(|preset| preset.0));
    part(ui, "light", &mut preferences.lights, Lights::PRESETS.map(|preset| preset.0));
    part(ui, "background", &mut preferences.background, Background::PRESETS.map(|preset| preset.0));
    palette(ui, &mut preferences.palette, has_own_colors);
    let own = Look::named(&preferences.look).unwrap_or(Look::PLAIN).finish;
    blur(ui, &mut preferences.blur_percent, own.blur);
    effects(ui, &mut preferences.without, own);
    let tip = "A picture of your own (PNG or JPEG) behind all, in the place of the background, or a film (through ffmpeg)";
    if file(ui, ("Picture", tip), &mut preferences.picture) {
        wishes.push(Wish::Choose(Then::Picture));
    }
    let tip = "A panorama of your own (HDR, PNG or JPEG, twice as wide as high): shapes mirror it, and its light is theirs";
    if file(ui, ("Panorama", tip), &mut preferences.panorama) {
        wishes.push(Wish::Choose(Then::Panorama));
    }
    ui.label(RichText::new("Stage").strong());
    screens(ui, &mut preferences.screen, shared.screen.monitors());
    let tip = "The picture goes into a second window, on that screen; controls and gallery stay here";
    theme::checkbox(ui, &mut preferences.own_window, "In a window of its own").on_hover_text(tip);
    let tip = "Nothing but the dance is shown on stage. Escape comes back. While a screen is not \
               connected the stage stays in its window.";
    theme::weak(ui, tip);
    ui.add_space(theme::GAP);
    camera(ui, &mut preferences.camera, &mut preferences.camera_size);
    preferences.projection.show(ui, adjusts);
}

/// The screens that there are by their names, and the chosen one even where it is not there.
fn screens(ui: &mut Ui, chosen: &mut Screen, names: Vec<String>) {
    let missing = chosen.name().filter(|_| chosen.index(&names).is_none());
    ui.horizontal_wrapped(|ui| {
        for (screen, label) in [(Screen::Window, "In the window"), (Screen::Full, "This screen")] {
            ui.selectable_value(chosen, screen, label);
        }
        for name in names {
            ui.selectable_value(chosen, Screen::Named(name.clone()), name);
        }
        if let Some(name) = missing {
            let _ = ui.selectable_label(true, format!("{name} (not connected)"));
        }
    });
}

/// Which programs see the stage, by the means that this system has.
fn camera(ui: &mut Ui, chosen: &mut Camera, size: &mut CameraSize) {
    let (ways, tip): (&[Camera], _) = if cfg!(target_os = "linux") {
        (
            &[Camera::PipeWire],
            "OBS, browsers and other programs see the stage as a camera named Chladni: through PipeWire, or \
             through a device of v4l2loopback",
        )
    } else if HAS_SYPHON {
        (&[Camera::Syphon], "Programs that know Syphon see the stage as a server named Chladni")
    } else {
        return;
    };
    ui.label(RichText::new("Camera for other programs").strong());
    let name = |camera: &Camera| match camera {
        Camera::Off => "Off".to_owned(),
        Camera::PipeWire => "PipeWire".to_owned(),
        Camera::Syphon => "Syphon".to_owned(),
        Camera::Device(path) => path.display().to_string(),
    };
    let list = egui::ComboBox::from_id_salt("camera").width(160.0).selected_text(name(chosen));
    let response = list.show_ui(ui, |ui| {
        for camera in [&[Camera::Off], ways].concat() {
            let (label, id) = (name(&camera), format!("camera/{}", name(&camera).to_lowercase()));
            ui.selectable_value(chosen, camera, label).author_id(id);
        }
        for (path, device) in video_devices() {
            let camera = Camera::Device(path);
            let label = format!("{} ({device})", name(&camera));
            ui.selectable_value(chosen, camera, label);
        }
    });
    response.response.author_id("camera").on_hover_text(tip);
    let tip = "The size of its pictures: a fixed one, or that which the stage, or the window where nothing is on stage, has \
               when the camera begins";
    theme::group(ui, "Size of the camera's pictures", |ui| {
        ui.horizontal_wrapped(|ui| {
            for (way, label) in CameraSize::ALL {
                ui.selectable_value(size, way, label).on_hover_text(tip);
            }
        });
    });
    ui.add_space(theme::GAP);
}

/// A file of one's own, or none; true where another is to be chosen.
fn file(ui: &mut Ui, (heading, tip): (&str, &str), chosen: &mut String) -> bool {
    let mut asks = false;
    ui.label(RichText::new(heading).strong());
    ui.horizontal(|ui| {
        let name = Path::new(chosen.as_str()).file_name().map(|name| name.to_string_lossy().into_owned());
        let label = name.unwrap_or_else(|| format!("{heading} …"));
        asks = ui.button(label).on_hover_text(tip).clicked();
        if !chosen.is_empty() && ui.button(format!("No {}", heading.to_lowercase())).clicked() {
            chosen.clear();
        }
    });
    ui.add_space(theme::GAP);
    asks
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
}

/// Menu of the palettes that color the movement: too many for a row of buttons.
fn palette(ui: &mut Ui, chosen: &mut String, has_own_colors: bool) {
    let (as_look, own) = ("As the look", "Own colors");
    let is_own = chosen == OWN_COLORS;
    let unnamed = || if is_own { own } else { as_look }.to_owned();
    let known = Palette::named(chosen).map_or_else(unnamed, |palette| theme::capitalized(palette.name()));
    ui.label(RichText::new("Palette").strong());
    let list = egui::ComboBox::from_id_salt("palette").width(160.0).height(480.0).selected_text(known);
    let response = list.show_ui(ui, |ui| {
        ui.selectable_value(chosen, String::new(), as_look);
        ui.selectable_value(chosen, OWN_COLORS.to_owned(), own);
        for palette in Palette::ALL {
            ui.selectable_value(chosen, palette.name().to_owned(), theme::capitalized(palette.name()));
        }
    });
    response
        .response
        .on_hover_text("The colors of what moves, or those that the shape brings: its texture or colors");
    if is_own && !has_own_colors {
        let text = "This shape has no colors of its own: those of the look are shown.";
        theme::weak(ui, text);
    }
    ui.add_space(theme::GAP);
}

/// Depth of field: the look's own until the slider is moved.
fn blur(ui: &mut Ui, chosen: &mut Option<u8>, own: f32) {
    ui.label(RichText::new("Depth of field").strong());
    let tip = "As through a lens that is wide open: what lies before or behind the front of the shape is soft. 0 is sharp \
               everywhere. It goes first where pictures are late.";
    let mut percent = chosen.unwrap_or((100.0 * own).round() as u8);
    let slider = theme::in_units(theme::slider(&mut percent, 0..=100), 1.0, 0, " %");
    if theme::row(ui, "Blur", tip, |ui| ui.add(slider)).on_hover_text(tip).changed() {
        *chosen = Some(percent);
    }
    if chosen.is_some() && ui.button("As the look").author_id("blur/own").clicked() {
        *chosen = None;
    }
    ui.add_space(theme::GAP);
}

/// The effects of the look's finish, each of which can be left out of all looks.
fn effects(ui: &mut Ui, left_out: &mut Vec<String>, own: Finish) {
    ui.label(RichText::new("Effects").strong());
    theme::group(ui, "Effects", |ui| {
        for (name, effect) in Effect::NAMED {
            let (label, tip) = match effect {
                Effect::Trails => ("Trails", "Light stays visible for a while"),
                Effect::Glow => ("Glow", "Light spreads from bright places"),
                Effect::Corners => ("Dark corners", "The picture is darker towards its corners"),
                Effect::Grain => ("Grain", "Each pixel differs by chance, as on film"),
            };
            let mut shown = own.has(effect) && !left_out.iter().any(|known| known == name);
            let check = ui.add_enabled_ui(own.has(effect), |ui| theme::checkbox(ui, &mut shown, label)).inner;
            let check = check.on_hover_text(format!("{tip}. What is off is left out of all looks."));
            let check = check.on_disabled_hover_text("This look has none");
            if check.author_id(format!("effect/{name}")).changed() {
                left_out.retain(|known| known != name);
                if !shown {
                    left_out.push(name.to_owned());
                }
            }
        }
    });
    ui.add_space(theme::GAP);
}

/// A part of the look: no name is the look's own.
fn part<const N: usize>(ui: &mut Ui, id: &str, chosen: &mut String, names: [&str; N]) {
    let all: Vec<&str> = [""].into_iter().chain(names).collect();
    choose(ui, id, chosen, &all);
}

fn choose(ui: &mut Ui, id: &str, chosen: &mut String, names: &[&str]) {
    let heading = theme::capitalized(id);
    ui.label(RichText::new(&heading).strong());
    let choices = |ui: &mut Ui| {
        for name in names {
            let label = if name.is_empty() { "As the look".to_owned() } else { theme::capitalized(name) };
            let button = ui.selectable_label(chosen == name, label);
            if button.author_id(format!("{id}/{name}")).clicked() {
                *chosen = (*name).to_owned();
            }
        }
    };
    theme::group(ui, &heading, |ui| ui.horizontal_wrapped(choices));
    ui.add_space(theme::GAP);
}

#[cfg(test)]
mod tests {
    use super::*;
    use chladni_music::{Action, GalleryShape, Moment};

    #[test]
    fn the_look_of_the_dance_on_stage_is_the_one_that_is_seen() {
        let shape = GalleryShape { eigenvalues: (0..32).map(f64::from).collect(), bands: 16 };
        let mut instrument = Instrument::new(1, 6, shape).unwrap();
        let of_show = Looks {
            look: "aurora".into(),
            material: "clay".into(),
            picture: "wall.png".into(),
            without: vec!["grain".into()],
            ..Looks::default()
        };
        assert_eq!(seen(&instrument, of_show.clone()), of_show);
        let put_on = |instrument: &mut Instrument, look: &str| {
            instrument.apply(Moment::default(), Action::SetLook { look: look.into() }).unwrap();
        };
        put_on(&mut instrument, "ember");
        let ember = Looks { look: "ember".into(), material: String::new(), ..of_show.clone() };
        assert_eq!(seen(&instrument, of_show.clone()), ember);
        // One of a later version is not seen.
        put_on(&mut instrument, "no such look");
        assert_eq!(seen(&instrument, of_show.clone()), of_show);
    }
}
