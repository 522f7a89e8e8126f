//! What is plugged in, what turns what, and learning.

use chladni_music::{Bindings, Parameter, Switch, Target};
use egui::{RichText, Ui};

use super::super::knobs;
use super::super::listening::Listening;
use super::super::preferences::Preferences;
use super::{Midi, Remote};
use crate::studio::icon::{self, Icon};
use crate::studio::theme;

/// The port that is offered first: TouchOSC's.
const USUAL_PORT: u16 = 8000;

impl Remote {
    /// Draws the drawer.
    pub fn show(&mut self, ui: &mut Ui, preferences: &mut Preferences, listening: &mut Listening) {
        self.devices(ui);
        ui.add_space(theme::GAP);
        self.osc(ui, preferences);
        ui.add_space(theme::GAP);
        self.clock(ui, preferences, listening);
        ui.add_space(theme::GAP);
        ui.label(RichText::new("What turns what").strong());
        weak(ui, "Click Learn, then move a knob, a fader or a pad.");
        let parameters = Parameter::ALL.into_iter().map(Target::Parameter);
        let switches = Switch::ALL.into_iter().map(Target::Switch);
        let first = Target::BUTTONS.into_iter().chain(parameters);
        for target in first.chain(switches).chain(Target::CHOICES) {
            row(ui, &mut self.bindings, target);
        }
    }

    fn devices(&self, ui: &mut Ui) {
        ui.label(RichText::new("MIDI").strong());
        let devices = self.midi.as_ref().map(Midi::devices).unwrap_or_default();
        match devices.failure {
            Some(why) => weak(ui, &format!("No controllers: {why}.")),
            None if devices.names.is_empty() => {
                weak(ui, "No controller is plugged in. One that comes later is found by itself.");
            }
            None => {}
        }
        for name in &devices.names {
            ui.label(icon::label(Icon::Cable, name));
        }
        if let Some(control) = &self.last {
            weak(ui, &format!("Touched last: {control}"));
        }
    }

    fn osc(&self, ui: &mut Ui, preferences: &mut Preferences) {
        ui.label(RichText::new("OSC").strong());
        ui.horizontal(|ui| {
            let mut on = preferences.osc_port.is_some();
            let mut port = preferences.osc_port.unwrap_or(USUAL_PORT);
            let tip = "Anyone on this network can then turn the knobs. Messages such as /chladni/gain 1.5 \
                       and /chladni/breed need no learning.";
            let listen = theme::checkbox(ui, &mut on, "Listen on UDP port").on_hover_text(tip);
            let number = ui.add_enabled(on, egui::DragValue::new(&mut port).range(1024..=65_535));
            let number = number.labelled_by(listen.id);
            if listen.changed() || number.changed() {
                preferences.osc_port = on.then_some(port);
            }
        });
        match &self.osc {
            Some(Ok(osc)) => {
                let (good, bad) = osc.counts();
                weak(ui, &format!("Port {}: {good} packets, {bad} bad ones left out", osc.port()));
            }
            Some(Err(why)) => {
                ui.label(RichText::new(why).small().color(theme::palette(ui).warning));
            }
            None => {}
        }
    }
}

fn row(ui: &mut Ui, bindings: &mut Bindings, target: Target) {
    ui.horizontal(|ui| {
        let name = name(target);
        ui.label(name);
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            let waits = bindings.learning() == Some(target);
            let learn = ui.selectable_label(waits, if waits { "Move it …" } else { "Learn" });
            learn.widget_info(|| {
                egui::WidgetInfo::selected(egui::Role::Button, true, waits, format!("Learn {name}"))
            });
            if learn.clicked() {
                bindings.learn((!waits).then_some(target));
            }
            let mut forgotten = None;
            for (index, binding) in bindings.list().iter().enumerate() {
                if binding.target != target {
                    continue;
                }
                let text = RichText::new(icon::label(Icon::X, &binding.control.to_string())).small();
                let forget = ui.small_button(text).accessible_name(format!("Forget {}", binding.control));
                if forget.on_hover_text("Forget this").clicked() {
                    forgotten = Some(index);
                }
            }
            if let Some(index) = forgotten {
                bindings.forget(index);
            }
        });
    });
}

fn name(target: Target) -> &'static str {
    match target {
        Target::Parameter(parameter) => knobs::name(parameter),
        Target::Switch(switch) => knobs::switch_name(switch),
        Target::Harmonics => "Harmonics",
        Target::Form => "The next form",
        Target::Choir => "The next choice of harmonics",
        Target::Breed => "Breed",
        Target::NextFavourite => "Next favourite on stage",
        Target::PreviousFavourite => "The favourite before",
        Target::LeaveStage => "Leave the stage",
        Target::Sweep => "Sweep the sand",
        Target::Tap => "Tap the beat",
        Target::PlayPause => "Play or pause",
    }
}

pub(super) fn weak(ui: &mut Ui, text: &str) {
    ui.label(RichText::new(text).small().color(theme::palette(ui).weak));
}
