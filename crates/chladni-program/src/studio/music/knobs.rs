//! The knobs and switches of the instrument.

use chladni_music::{Action, Instrument, Parameter, Parameters, Switch, Timbre};
use egui::{RichText, Ui};

use super::wish::Wish;
use crate::studio::author_id::AuthorId;
use crate::studio::theme;
use crate::work::knobs::{CHOIRS, FORMS, KNOBS, SWITCHES, Shown, by_factors, idle, shown};

/// Width of the names.
const LABEL: f32 = 98.0;

/// Draws them all and collects the changes. `voices` may listen to the side in any form.
pub fn show(ui: &mut Ui, instrument: &Instrument, voices: bool, wishes: &mut Vec<Wish>) {
    let parameters = instrument.parameters();
    group(ui, "Form", |ui| {
        form(ui, parameters, wishes);
        harmonics(ui, instrument, wishes);
    });
    group(ui, "Timbre", |ui| timbre(ui, parameters, wishes));
    for (name, rows) in KNOBS {
        group(ui, name, |ui| {
            for (parameter, name) in *rows {
                let idle = idle(parameters, *parameter, voices);
                knob(ui, instrument, *parameter, name, idle, wishes);
            }
        });
    }
    for (name, switches) in SWITCHES {
        group(ui, name, |ui| {
            for (switch, name) in *switches {
                let mut on = parameters.is_on(*switch);
                let check = theme::checkbox(ui, &mut on, name).author_id(switch.name());
                if check.on_hover_text(switch.about()).changed() {
                    wishes.push(Wish::Do(Action::Switch { switch: *switch, on }));
                }
                if *switch == Switch::Sand {
                    sand(ui, parameters, wishes);
                }
            }
        });
    }
}

/// Buttons for sand beside its switch.
fn sand(ui: &mut Ui, parameters: &Parameters, wishes: &mut Vec<Wish>) {
    ui.horizontal(|ui| {
        let tip = "Sand on stage on a shape that moves little, and a higher tone draws a finer figure; takes the \
                   place of the first item";
        if ui.button("Chladni's plate").on_hover_text(tip).clicked() {
            wishes.push(Wish::Experiment);
        }
        let sweep = ui.add_enabled(parameters.is_on(Switch::Sand), egui::Button::new("Sweep"));
        if sweep.on_hover_text("Sweeps the sand off and pours it anew").clicked() {
            wishes.push(Wish::Do(Action::Sweep));
        }
    });
}

fn form(ui: &mut Ui, parameters: &Parameters, wishes: &mut Vec<Wish>) {
    ui.horizontal(|ui| {
        for (form, name, tip) in FORMS {
            let button = ui.selectable_label(parameters.form == form, name);
            if button.author_id(format!("form/{}", name.to_lowercase())).on_hover_text(tip).clicked() {
                wishes.push(Wish::Do(Action::SetForm { form }));
            }
        }
    });
    ui.horizontal(|ui| {
        for (choir, name) in CHOIRS {
            let tip = "Which harmonics may sound";
            if ui.selectable_label(parameters.choir == choir, name).on_hover_text(tip).clicked() {
                wishes.push(Wish::Do(Action::SetChoir { choir }));
            }
        }
    });
}

/// Choice of the material that the shape seems to ring like.
fn timbre(ui: &mut Ui, parameters: &Parameters, wishes: &mut Vec<Wish>) {
    let now = parameters.timbre();
    ui.horizontal_wrapped(|ui| {
        let tip = "Follows the level of the sound, as in the paper";
        if ui.selectable_label(now.is_none(), "None").on_hover_text(tip).clicked() {
            wishes.push(Wish::Do(Action::Switch { switch: Switch::Resonate, on: false }));
        }
        for (name, timbre) in Timbre::NAMED {
            let tip = "Rings as a damped oscillator when the sound strikes it";
            if ui.selectable_label(now == Some(timbre), theme::capitalized(name)).on_hover_text(tip).clicked()
            {
                wishes.extend(Action::for_timbre(&timbre).map(Wish::Do));
            }
        }
    });
}

/// How many harmonics are in use.
fn harmonics(ui: &mut Ui, instrument: &Instrument, wishes: &mut Vec<Wish>) {
    let all = u32::try_from(instrument.shape().eigenvalues.len()).unwrap_or(u32::MAX);
    let before = instrument.parameters().harmonics.map_or(all, |harmonics| harmonics.min(all));
    let mut in_use = before;
    let tip = "How many of the shape's harmonics are in use; fewer move it more broadly";
    let slider = theme::slider(&mut in_use, 2.min(all)..=all);
    let changed =
        theme::wide_row(ui, LABEL, "Harmonics", tip, |ui| ui.add(slider)).on_hover_text(tip).changed();
    if changed && in_use != before {
        let harmonics = if in_use == all { 0 } else { in_use };
        wishes.push(Wish::Do(Action::SetHarmonics { harmonics }));
    }
}

fn group(ui: &mut Ui, name: &str, content: impl FnOnce(&mut Ui)) {
    ui.add_space(theme::GAP);
    ui.label(RichText::new(name).strong());
    theme::group(ui, name, content);
}

fn knob(
    ui: &mut Ui,
    instrument: &Instrument,
    parameter: Parameter,
    name: &str,
    idle: Option<&'static str>,
    wishes: &mut Vec<Wish>,
) {
    let tip = parameter.about();
    let mut value = instrument.parameters().get(parameter);
    let (low, high) = parameter.range();
    let slider = theme::slider(&mut value, low..=high).logarithmic(by_factors(parameter));
    let slider = match shown(parameter) {
        Shown { decimals, unit: "", .. } => slider.fixed_decimals(decimals),
        Shown { factor, decimals, unit } => theme::in_units(slider, factor, decimals, unit),
    };
    let slider = theme::wide_row(ui, LABEL, name, tip, |ui| ui.add_enabled(idle.is_none(), slider));
    let slider = slider
        .author_id(parameter.name())
        .on_hover_text(tip)
        .on_disabled_hover_text(idle.unwrap_or_default());
    if slider.changed() {
        wishes.push(Wish::Do(Action::Set { parameter, value }));
    }
    if let Some(why) = idle {
        theme::weak(ui, why);
    }
}
