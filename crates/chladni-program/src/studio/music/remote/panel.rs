//! The panel for devices, for the bindings of controls, and for learning them.

use std::net::{IpAddr, Ipv4Addr};
use std::path::Path;

use chladni_music::{Bindings, Kind, Target};
use egui::{RichText, Ui};

use super::super::listening::Listening;
use super::super::preferences::Preferences;
use super::super::wish::{Then, Wish};
use super::Remote;
use super::osc::Packets;
use crate::studio::author_id::AuthorId;
use crate::studio::icon::{self, Icon};
use crate::studio::room::Shared;
use crate::studio::theme;
use crate::work::{Error, knobs, write_file};

/// The port that is offered first: TouchOSC's.
const USUAL_PORT: u16 = 8000;
/// How large a file of bindings may be.
const MOST_BYTES: u64 = 1 << 20;

impl Remote {
    /// Draws the drawer.
    pub fn show(
        &mut self,
        ui: &mut Ui,
        shared: &mut Shared<'_>,
        listening: &mut Listening,
        wishes: &mut Vec<Wish>,
    ) {
        let preferences = &mut shared.settings.music;
        self.devices(ui);
        ui.add_space(theme::GAP);
        self.osc(ui, preferences);
        ui.add_space(theme::GAP);
        self.clock(ui, preferences, listening);
        ui.add_space(theme::GAP);
        ui.label(RichText::new("What turns what").strong());
        theme::weak(
            ui,
            "Click Learn, then move a knob, a fader or a pad. A number takes one dance, preset or song.",
        );
        files(ui, wishes);
        for (kind, heading) in [
            (Kind::Level, "Levels"),
            (Kind::Switch, "Switches"),
            (Kind::Choice, "Choices"),
            (Kind::Dance, "Dances"),
            (Kind::Button, "Buttons"),
        ] {
            ui.label(RichText::new(heading).strong());
            for target in Target::all().filter(|target| target.kind() == kind) {
                row(ui, &mut self.bindings, &mut self.number, target);
                endless(ui, &mut self.bindings, target);
            }
        }
    }

    /// Writes all bindings into a file.
    pub fn export(&self, path: &Path) -> Result<(), Error> {
        let text = self.bindings.to_text()?;
        write_file(path, text.as_bytes())
    }

    /// Adds the bindings of a file; returns how many it has.
    pub fn import(&mut self, path: &Path) -> Result<usize, Error> {
        let text = chladni_task::read_text_file(path, MOST_BYTES)
            .map_err(|why| Error::Input(format!("{}: {why}", path.display())))?;
        self.bindings.import(&text).map_err(|why| Error::from(why).of(path.display()))
    }

    fn devices(&self, ui: &mut Ui) {
        ui.label(RichText::new("MIDI").strong());
        let devices = self.midi_devices();
        match &devices.failure {
            Some(why) => theme::weak(ui, format!("No controllers: {why}.")),
            None if devices.names.is_empty() && devices.refused.is_empty() => {
                theme::weak(ui, "No controller is plugged in. One that comes later is found by itself.");
            }
            None => {}
        }
        for name in &devices.names {
            ui.label(icon::label(Icon::Cable, name));
        }
        for why in &devices.refused {
            theme::warning(ui, why);
        }
        if let Some(control) = &self.last {
            theme::weak(ui, format!("Touched last: {control}"));
        }
    }

    fn osc(&mut self, ui: &mut Ui, preferences: &mut Preferences) {
        ui.label(RichText::new("OSC").strong());
        ui.horizontal(|ui| {
            let mut on = preferences.osc_port.is_some();
            let mut port = preferences.osc_port.unwrap_or(USUAL_PORT);
            let tip = "Messages such as /chladni/gain 1.5 and /chladni/breed need no learning.";
            let listen = theme::checkbox(ui, &mut on, "Listen on UDP port").on_hover_text(tip);
            let number = ui.add_enabled(on, theme::number(&mut port).range(1024..=65_535));
            let number = number.labelled_by(listen.id);
            if listen.changed() || number.changed() {
                preferences.osc_port = on.then_some(port);
            }
        });
        if preferences.osc_port.is_some() {
            self.network(ui, preferences);
        }
        match &self.osc {
            Some(Ok(osc)) => theme::weak(ui, heard(osc.port(), osc.packets())),
            Some(Err(why)) => theme::warning(ui, why.to_string()),
            None => {}
        }
    }

    /// Choice of the other machines that are heard.
    fn network(&mut self, ui: &mut Ui, preferences: &mut Preferences) {
        let tip = "Otherwise only programs on this machine are heard";
        theme::checkbox(ui, &mut preferences.osc_network, "Other machines, too").on_hover_text(tip);
        if !preferences.osc_network {
            return;
        }
        let field = egui::TextEdit::singleline(&mut self.allowed).hint_text("192.168.1.20, 192.168.1.21");
        let label = ui.label("Only these").id;
        let tip =
            "IPv4 addresses of machines that are heard; none: anyone on this network can turn the knobs";
        let field = ui.add(field.desired_width(f32::INFINITY)).labelled_by(label).on_hover_text(tip);
        let field = field.author_id("osc-allowed");
        match addresses(&self.allowed) {
            // A list that is being typed would let in other machines, an empty one any.
            Some(allowed) if field.lost_focus() => preferences.osc_allowed = allowed,
            Some(_) if !field.has_focus() => {
                let allowed: Vec<String> = preferences.osc_allowed.iter().map(ToString::to_string).collect();
                self.allowed = allowed.join(", ");
            }
            Some(_) => {}
            None => theme::warning(ui, "These are no IPv4 addresses: those before are still heard."),
        }
    }
}

/// How many packets came at a port, and how many were left out, and why.
fn heard(port: u16, packets: Packets) -> String {
    let Packets { taken, crowded_out, bad } = packets;
    format!("Port {port}: {taken} packets; left out: {crowded_out} too many, {bad} bad ones")
}

/// The addresses in a list; `None` where others are in it than those of IPv4, which alone are listened to.
fn addresses(typed: &str) -> Option<Vec<IpAddr>> {
    let words = typed.split([',', ' ']).filter(|word| !word.is_empty());
    words.map(|word| word.parse::<Ipv4Addr>().ok().map(IpAddr::V4)).collect()
}

/// Bindings as a file, for another machine.
fn files(ui: &mut Ui, wishes: &mut Vec<Wish>) {
    ui.horizontal(|ui| {
        for (name, id, tip, then) in [
            ("Export …", "bindings-export", "All bindings as a file", Then::ExportBindings),
            ("Import …", "bindings-import", "Those of a file, beside what there is", Then::ImportBindings),
        ] {
            if ui.button(name).author_id(id).on_hover_text(tip).clicked() {
                wishes.push(Wish::Choose(then));
            }
        }
    });
}

fn row(ui: &mut Ui, bindings: &mut Bindings, number: &mut u32, target: Target) {
    ui.horizontal(|ui| {
        let name = name(target);
        // The buttons first, so that a long name cannot push them away.
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            let numbered = matches!(target.kind(), Kind::Choice | Kind::Dance);
            let waits = bindings.learning().is_some_and(|(waits, _)| waits == target);
            let learn = match waits {
                true if bindings.is_full() => {
                    let tip = "No more controls are kept: forget one, or move one that is bound already";
                    ui.selectable_label(true, "No room …").on_hover_text(tip)
                }
                true => ui.selectable_label(true, "Move it …"),
                false => ui.selectable_label(false, "Learn"),
            };
            learn.widget_info(|| {
                egui::WidgetInfo::selected(egui::Role::Button, true, waits, format!("Learn {name}"))
            });
            let learn = learn.author_id(format!("learn/{}", target.name()));
            if learn.clicked() {
                *number = 0;
                bindings.learn((!waits).then_some((target, None)));
            }
            let mut number_field = None;
            if waits && numbered {
                // Without a number, a press takes this one.
                let unnumbered = if target.kind() == Kind::Dance { "marked" } else { "next" };
                let which = theme::number(number).range(0..=999).custom_formatter(|number, _| {
                    if number < 1.0 { unnumbered.into() } else { format!("{number:.0}") }
                });
                let field = ui.add(which);
                if field.changed() {
                    bindings.learn(Some((target, Some(*number).filter(|number| *number > 0))));
                }
                number_field = Some(field);
            }
            let mut forgotten = None;
            for (index, binding) in bindings.list().iter().enumerate() {
                if binding.target != target {
                    continue;
                }
                let which = binding.number.map_or_else(String::new, |number| format!("{number}: "));
                let text = icon::label(Icon::X, &format!("{which}{}", binding.control));
                let forget = ui.small_button(RichText::new(text).small());
                let forget = forget.accessible_name(format!("Forget {which}{}", binding.control));
                let tip = match binding.device.as_str() {
                    "" => "Forget this".to_owned(),
                    device => format!("Forget this of {device}"),
                };
                if forget.on_hover_text(tip).clicked() {
                    forgotten = Some(index);
                }
            }
            if let Some(index) = forgotten {
                bindings.forget(index);
            }
            ui.with_layout(egui::Layout::left_to_right(egui::Align::Center), |ui| {
                let label = ui.add(egui::Label::new(name).truncate());
                if let Some(field) = number_field {
                    field.labelled_by(label.id);
                }
            });
        });
    });
}

/// Whether the knobs that are bound to a level turn endlessly.
fn endless(ui: &mut Ui, bindings: &mut Bindings, target: Target) {
    let mut turned = None;
    for (index, binding) in bindings.list().iter().enumerate() {
        if binding.target != target || !binding.can_be_relative() {
            continue;
        }
        let mut relative = binding.relative;
        let tip = "It sends steps, not positions: 1 for one to the right, 127 for one to the left";
        let label = format!("{} turns endlessly", binding.control);
        if theme::checkbox(ui, &mut relative, &label).on_hover_text(tip).changed() {
            turned = Some((index, relative));
        }
    }
    if let Some((index, relative)) = turned {
        bindings.set_relative(index, relative);
    }
}

fn name(target: Target) -> &'static str {
    match target {
        Target::Parameter(parameter) => knobs::knob_name(parameter),
        Target::Switch(switch) => knobs::switch_name(switch),
        _ => target.about(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn well_formed_packets_that_are_too_many_are_not_called_bad() {
        let said = heard(8000, Packets { taken: 9621, crowded_out: 46_558, bad: 3 });
        assert_eq!(said, "Port 8000: 9621 packets; left out: 46558 too many, 3 bad ones");
    }

    #[test]
    fn only_addresses_that_can_be_heard_are_taken() {
        let desk = IpAddr::from([192, 168, 1, 20]);
        assert_eq!(addresses("192.168.1.20, 127.0.0.1"), Some(vec![desk, Ipv4Addr::LOCALHOST.into()]));
        assert_eq!(addresses(" "), Some(Vec::new()));
        assert_eq!((addresses("fe80::1"), addresses("192.168.1.20, desk")), (None, None));
    }
}
