//! The layers of a caricature as voices: what each listens to.

use chladni_music::{Action, Driver, Instrument, VoiceSettings};
use egui::{RichText, Slider, Ui};

use super::wish::Wish;
use crate::studio::theme;

/// Draws the voices, one group a layer.
pub fn show(ui: &mut Ui, instrument: &Instrument, names: &[String], wishes: &mut Vec<Wish>) {
    ui.label(RichText::new("Layers as voices").strong());
    if names.is_empty() {
        let text = "Open a caricature (a .chladni project): each of its layers becomes a voice that the \
                    music drives.";
        theme::weak(ui, text);
    }
    for (voice, name) in names.iter().enumerate() {
        let before = instrument.voice(voice);
        let mut settings = before;
        ui.add_space(theme::GAP_SMALL);
        let said = format!("Voice {}, {name}", voice + 1);
        egui::Frame::group(ui.style())
            .show(ui, |ui| theme::group(ui, &said, |ui| settings_of(ui, name, &mut settings)));
        if settings != before {
            wishes.push(Wish::Do(Action::SetVoice { voice, settings }));
        }
    }
}

fn settings_of(ui: &mut Ui, name: &str, settings: &mut VoiceSettings) {
    ui.set_width(ui.available_width());
    ui.label(name);
    ui.horizontal_wrapped(|ui| driver(ui, &mut settings.driver));
    if let Driver::Band { from, to } = &mut settings.driver {
        band(ui, from, to);
    }
    let tip = "1 is the layer as it was made; below 0 is its opposite";
    let gain = theme::slider(&mut settings.gain, -4.0..=4.0).fixed_decimals(2);
    ui.add(gain.text("gain")).on_hover_text(tip);
}

fn driver(ui: &mut Ui, driver: &mut Driver) {
    let band = match *driver {
        Driver::Band { .. } => *driver,
        _ => VoiceSettings::initial(0).driver,
    };
    for (choice, name, tip) in [
        (band, "Band", "The loudest tone within a range"),
        (Driver::Beat, "Beat", "Full on the beat, fading until the next"),
        (Driver::Mid, "Mid", "The loudest tone of the middle"),
        (Driver::Side, "Side", "The loudest tone of the sides"),
    ] {
        let on = std::mem::discriminant(driver) == std::mem::discriminant(&choice);
        if ui.selectable_label(on, name).on_hover_text(tip).clicked() {
            *driver = choice;
        }
    }
}

fn band(ui: &mut Ui, from: &mut f32, to: &mut f32) {
    ui.horizontal(|ui| {
        ui.spacing_mut().slider_width = 60.0;
        let tip = "0 is the lowest band, 1 the highest";
        for (bound, name) in [(&mut *from, "Lowest band"), (&mut *to, "Highest band")] {
            let slider = Slider::new(bound, 0.0..=1.0).show_value(false);
            ui.add(slider).accessible_name(name).on_hover_text(tip);
        }
        ui.label(RichText::new(format!("{:.0}–{:.0} %", *from * 100.0, *to * 100.0)).small());
    });
}
