//! Where the beat comes from, and where it goes.

use egui::{RichText, TextEdit, Ui};

use super::Remote;
use crate::studio::author_id::AuthorId;
use crate::studio::keys::music::{LOCK_BEAT, NUDGE_BACK, NUDGE_ON};
use crate::studio::music::listening::Listening;
use crate::studio::music::preferences::Preferences;
use crate::studio::theme;

/// How far one nudge moves the beat.
pub const NUDGE_SECS: f64 = 0.01;

impl Remote {
    /// Draws the part of the drawer that is about clocks.
    pub(super) fn clock(&mut self, ui: &mut Ui, preferences: &mut Preferences, listening: &mut Listening) {
        ui.label(RichText::new("Clock").strong());
        let tip =
            "MIDI clock of any device, and /tempo and /beat over OSC, in place of the beat that is heard";
        theme::checkbox(ui, &mut preferences.follows_clock, "Follow MIDI clock and OSC")
            .author_id("follow-clock")
            .on_hover_text(tip);
        let message = match (listening.is_locked(), listening.follows_clock()) {
            (true, _) => "The tempo is held.",
            (false, true) => "The beat is that of the clock.",
            (false, false) if preferences.follows_clock => {
                "No clock is heard yet: the beat is that of the music."
            }
            (false, false) => "The beat is that of the music.",
        };
        theme::weak(ui, message);
        ui.horizontal(|ui| {
            let mut locked = listening.is_locked();
            let lock = theme::checkbox(ui, &mut locked, "Hold the tempo");
            if lock.on_hover_text(LOCK_BEAT.tooltip(ui.ctx())).changed() {
                listening.lock(locked);
            }
            for (sign, key, secs) in [("–", NUDGE_BACK, -NUDGE_SECS), ("+", NUDGE_ON, NUDGE_SECS)] {
                let button = ui.small_button(sign).on_hover_text(key.tooltip(ui.ctx()));
                if button.clicked() {
                    listening.nudge(secs);
                }
            }
        });
        ui.add_space(theme::GAP);
        self.beat_out(ui, preferences);
    }

    fn beat_out(&mut self, ui: &mut Ui, preferences: &mut Preferences) {
        ui.label(RichText::new("Beat out").strong());
        let tip = "/beat, /bar, /tempo, /energy, /section, and /bands 30 times a second";
        let label = ui.label("By OSC to").on_hover_text(tip).id;
        let mut address =
            self.beats_typed.take().or_else(|| preferences.beat_out.clone()).unwrap_or_default();
        let field =
            TextEdit::singleline(&mut address).hint_text("127.0.0.1:9000").desired_width(f32::INFINITY);
        let field = ui.add(field).labelled_by(label).on_hover_text(tip);
        // Half an address would be looked up at each key.
        if field.lost_focus() {
            preferences.beat_out = Some(address.trim().to_owned()).filter(|address| !address.is_empty());
        } else if field.has_focus() {
            self.beats_typed = Some(address);
        }
        let failure = match &self.beat_out {
            Some(Ok(out)) => out.failure.as_ref(),
            Some(Err(why)) => Some(why),
            None => None,
        };
        if let Some(why) = failure {
            theme::warning(ui, why.to_string());
        }
        let outputs = self.midi_devices().outputs;
        let choices = choices(outputs, preferences.clock_out.clone());
        if choices.is_empty() {
            return;
        }
        ui.label("MIDI clock to");
        theme::group(ui, "MIDI clock to", |ui| {
            ui.selectable_value(&mut preferences.clock_out, None, "Nobody");
            for (device, label) in choices {
                ui.selectable_value(&mut preferences.clock_out, Some(device), label);
            }
        });
        if let Some(Err((_, why))) = &self.clock_out {
            theme::warning(ui, why.to_string());
        }
    }
}

/// The devices that a clock can be sent to, each with its label. The one that is `chosen` is listed even where it is missing
/// now, so that it can be changed.
fn choices(outputs: Vec<String>, chosen: Option<String>) -> Vec<(String, String)> {
    let gone = chosen.filter(|device| !outputs.contains(device));
    let gone = gone.map(|device| (device.clone(), format!("{device} (not connected)")));
    outputs.into_iter().map(|device| (device.clone(), device)).chain(gone).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_device_that_was_unplugged_is_listed_as_not_connected() {
        let pair = |device: &str, label: &str| (device.to_owned(), label.to_owned());
        let drums = || vec!["drums".to_owned()];
        assert_eq!(choices(drums(), Some("drums".to_owned())), [pair("drums", "drums")]);
        let listed = choices(drums(), Some("synth".to_owned()));
        assert_eq!(listed, [pair("drums", "drums"), pair("synth", "synth (not connected)")]);
        assert!(choices(Vec::new(), None).is_empty());
    }
}
