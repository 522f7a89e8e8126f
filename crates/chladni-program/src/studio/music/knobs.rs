//! The knobs and switches of the instrument.

use chladni_music::{Action, Choir, Form, FormControl, Instrument, Parameter, Parameters, Switch, Timbre};
use egui::{RichText, Slider, Ui};

use super::wish::Wish;
use crate::studio::author_id::AuthorId;
use crate::studio::theme;

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
    for (name, rows) in GROUPS {
        group(ui, name, |ui| {
            for (parameter, name, tip) in *rows {
                let idle = idle(parameters, *parameter, voices);
                knob(ui, instrument, *parameter, (name, tip), idle, wishes);
            }
        });
    }
    for (name, switches) in SWITCHES {
        group(ui, name, |ui| {
            for (switch, name, tip) in *switches {
                let mut on = parameters.is_on(*switch);
                let check = theme::checkbox(ui, &mut on, name).author_id(switch.name());
                if check.on_hover_text(*tip).changed() {
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
        for (form, name, tip) in [
            (Form::HalfMask, "halves", "The left channel moves the left half, the right one the right"),
            (
                Form::Modal,
                "modal",
                "Along the normals, as a sounding plate: the middle moves symmetric harmonics, the side \
                 antisymmetric ones, towards the louder channel",
            ),
            (
                Form::Filter,
                "filter",
                "The paper's: the shape's own harmonics grow and shrink; a symmetric shape stays so, and left \
                 and right look alike",
            ),
        ] {
            let button = ui.selectable_label(parameters.form == form, theme::capitalized(name));
            if button.author_id(format!("form/{name}")).on_hover_text(tip).clicked() {
                wishes.push(Wish::Do(Action::SetForm { form }));
            }
        }
    });
    ui.horizontal(|ui| {
        for (choir, name) in
            [(Choir::All, "All"), (Choir::Symmetric, "Symmetric"), (Choir::Antisymmetric, "Antisymmetric")]
        {
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

type Row = (Parameter, &'static str, &'static str);

const GROUPS: &[(&str, &[Row])] = &[
    (
        "Movement",
        &[
            (Parameter::Gain, "Gain", "How strongly everything moves; 1 is calibrated to the shape"),
            (Parameter::Calibration, "Calibration", "How far a full-scale sound moves the shape at gain 1"),
            (Parameter::Limit, "Limit", "The share of the shape's size that no part is to exceed"),
            (Parameter::Detail, "Fine detail", "Gain of everything finer than the last harmonic"),
            (Parameter::NormalBlending, "Normal blending", "0 is exact light, 1 the paper's softer look"),
            (
                Parameter::StereoMu,
                "µ of all",
                "How much middle and sides mix, while no dance has a µ of its own",
            ),
        ],
    ),
    (
        "Resonators",
        &[
            (Parameter::Damping, "Damping", "How soon they come to rest; from 1 on they swing no more"),
            (Parameter::TuningHz, "Tuning", "How often a second the broadest movement swings"),
            (Parameter::Stretch, "Stretch", "How much faster finer movements are"),
            (Parameter::Strike, "Strike", "How hard a sound that begins strikes"),
            (Parameter::Hold, "Hold", "How far a sound that lasts holds the shape"),
        ],
    ),
    (
        "Sound",
        &[
            (Parameter::Decay, "Decay", "How long a sound lingers in the shape"),
            (Parameter::SideGain, "Side gain", "How much the difference of left and right counts"),
            (Parameter::Bands, "Bands", "Number of sound bands"),
        ],
    ),
    (
        "Sand",
        &[
            (Parameter::Grains, "Grains", "How many grains lie on the shape that is on stage"),
            (Parameter::GrainSize, "Grain size", "Radius of a grain, as a share of the shape's size"),
        ],
    ),
    (
        "Stage",
        &[
            (Parameter::TransitionBeats, "Transition", "Beats that a change on stage takes"),
            (Parameter::BeatsPerStep, "Step", "Beats between two favorites"),
            (Parameter::TurnRad, "Turn", "How far the beat turns the shape"),
            (Parameter::LightSwingRad, "Light swing", "How far the beat moves the lights"),
            (Parameter::LightPulse, "Light pulse", "How much brighter the beat is"),
        ],
    ),
];

type Choice = (Switch, &'static str, &'static str);

const SWITCHES: &[(&str, &[Choice])] = &[
    (
        "On the beat",
        &[
            (Switch::BeatTurns, "Turn the shape", "The beat turns the shape"),
            (Switch::BeatLights, "Move the lights", "The beat moves the lights"),
            (Switch::BeatSteps, "Next favorite", "The beat steps through the favorites on stage"),
            (Switch::Camera, "Choose shots", "On stage the camera chooses its shots, bar by bar"),
        ],
    ),
    (
        "Hearing",
        &[
            (Switch::LogBands, "Bands by pitch", "Equal steps of pitch rather than of frequency"),
            (Switch::FlipSides, "Exchange sides", "Left and right are exchanged"),
            (Switch::Resonate, "Resonate", "Sound strikes the shape; else the shape follows its level"),
            (Switch::OwnMu, "Each its own µ", "Else all dances have the one among the knobs"),
        ],
    ),
    (
        "Breeding",
        &[(
            Switch::Suggest,
            "Suggest",
            "Of two hundred children show those that differ most and are most like what you chose so far; else \
             whatever the paper's breeding gives",
        )],
    ),
    (
        "Experiment",
        &[(
            Switch::Sand,
            "Sand",
            "Sand lies on the shape that is on stage and gathers where it does not move; form Modal and little \
             gain are best",
        )],
    ),
    (
        "Safety",
        &[
            (
                Switch::FlashLimit,
                "Limit flashes",
                "At most three flashes a second, for people with photosensitive epilepsy",
            ),
            (
                Switch::FlashFields,
                "In any field of view",
                "Limit them in a quarter of any third of the picture, too, for people who sit close. Bodies that swing fast \
                 over a dark ground are darkened by it",
            ),
        ],
    ),
];

/// A knob's name on screen.
pub fn name(parameter: Parameter) -> &'static str {
    let mut rows = GROUPS.iter().flat_map(|(_, rows)| rows.iter());
    rows.find(|row| row.0 == parameter).map_or(parameter.name(), |row| row.1)
}

/// A switch's name on screen.
pub fn switch_name(switch: Switch) -> &'static str {
    let mut rows = SWITCHES.iter().flat_map(|(_, rows)| rows.iter());
    rows.find(|row| row.0 == switch).map_or(switch.name(), |row| row.1)
}

fn group(ui: &mut Ui, name: &str, content: impl FnOnce(&mut Ui)) {
    ui.add_space(theme::GAP);
    ui.label(RichText::new(name).strong());
    theme::group(ui, name, content);
}

/// Why a knob has no effect now.
fn idle(parameters: &Parameters, parameter: Parameter, voices: bool) -> Option<&'static str> {
    let form = parameters.form;
    match parameter {
        Parameter::StereoMu => form.ignores(FormControl::StereoMu).or_else(|| {
            parameters.is_on(Switch::OwnMu).then_some("Each dance has its own µ now (see Hearing).")
        }),
        Parameter::SideGain if !voices => form.ignores(FormControl::SideGain),
        Parameter::Damping
        | Parameter::TuningHz
        | Parameter::Stretch
        | Parameter::Strike
        | Parameter::Hold => {
            (!parameters.is_on(Switch::Resonate)).then_some("Nothing resonates now (see Hearing).")
        }
        Parameter::Grains | Parameter::GrainSize => {
            (!parameters.is_on(Switch::Sand)).then_some("There is no sand now (see Experiment).")
        }
        Parameter::Detail => form.ignores(FormControl::Detail),
        _ => None,
    }
}

fn knob(
    ui: &mut Ui,
    instrument: &Instrument,
    parameter: Parameter,
    (name, tip): (&str, &str),
    idle: Option<&'static str>,
    wishes: &mut Vec<Wish>,
) {
    let mut value = instrument.parameters().get(parameter);
    let (low, high) = parameter.range();
    let slider = theme::slider(&mut value, low..=high).logarithmic(high / low.max(1e-3) > 500.0);
    let slider = match parameter {
        Parameter::Bands | Parameter::BeatsPerStep | Parameter::Grains => slider.fixed_decimals(0),
        Parameter::TransitionBeats => slider.fixed_decimals(1),
        Parameter::GrainSize => in_units(slider, 100.0, 2, " %"),
        Parameter::Calibration | Parameter::Limit => in_units(slider, 100.0, 1, " %"),
        Parameter::TurnRad | Parameter::LightSwingRad => {
            in_units(slider, 180.0 / std::f64::consts::PI, 0, "°")
        }
        _ => slider.fixed_decimals(2),
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
        let weak = theme::palette(ui).weak;
        ui.label(RichText::new(why).small().color(weak));
    }
}

/// Shown times `factor`, with a unit; typed numbers are in it, too, whether or not they name it.
fn in_units<'a>(slider: Slider<'a>, factor: f64, decimals: usize, unit: &'static str) -> Slider<'a> {
    slider
        .custom_formatter(move |value, _| format!("{:.decimals$}{unit}", value * factor))
        .custom_parser(move |text| Some(number_before(text, unit)? / factor))
}

/// The number in `text`, which may end in `unit`.
fn number_before(text: &str, unit: &str) -> Option<f64> {
    text.trim().trim_end_matches(unit.trim()).trim_end().parse().ok()
}

#[cfg(test)]
mod tests {
    use super::number_before;

    #[test]
    fn a_number_is_read_with_its_unit_near_or_far_or_without() {
        for text in ["5", " 5 ", "5%", "5 %", "5.0  % "] {
            assert_eq!(number_before(text, " %"), Some(5.0), "{text}");
        }
        assert_eq!(number_before("-90°", "°"), Some(-90.0));
        assert_eq!(number_before("90 °", "°"), Some(90.0));
        assert_eq!((number_before("5°", " %"), number_before("%", " %")), (None, None));
    }
}
