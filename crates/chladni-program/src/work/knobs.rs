//! The knobs and switches of the music instrument as people see them, in the window and on the page: their groups, names
//! and units, and why one has no effect.

use chladni_music::{Choir, Form, FormControl, Parameter, Parameters, Switch};

/// The forms, their names and what they do.
pub const FORMS: [(Form, &str, &str); 3] = [
    (Form::HalfMask, "Halves", "The left channel moves the left half, the right one the right"),
    (
        Form::Modal,
        "Modal",
        "Along the normals, as a sounding plate: the middle moves symmetric harmonics, the side antisymmetric ones, \
         towards the louder channel",
    ),
    (
        Form::Filter,
        "Filter",
        "The paper's: the shape's own harmonics grow and shrink; a symmetric shape stays so, and left and right look \
         alike",
    ),
];

/// Which harmonics may sound, by names.
pub const CHOIRS: [(Choir, &str); 3] =
    [(Choir::All, "All"), (Choir::Symmetric, "Symmetric"), (Choir::Antisymmetric, "Antisymmetric")];

/// A knob and its name; [`Parameter::about`] says what it does.
pub type Knob = (Parameter, &'static str);

/// All knobs, in groups that have names.
pub const KNOBS: &[(&str, &[Knob])] = &[
    (
        "Movement",
        &[
            (Parameter::Gain, "Gain"),
            (Parameter::Calibration, "Calibration"),
            (Parameter::Limit, "Limit"),
            (Parameter::Detail, "Fine detail"),
            (Parameter::NormalBlending, "Normal blending"),
            (Parameter::StereoMu, "µ of all"),
        ],
    ),
    (
        "Resonators",
        &[
            (Parameter::Damping, "Damping"),
            (Parameter::TuningHz, "Tuning"),
            (Parameter::Stretch, "Stretch"),
            (Parameter::Strike, "Strike"),
            (Parameter::Hold, "Hold"),
        ],
    ),
    (
        "Sound",
        &[(Parameter::Decay, "Decay"), (Parameter::SideGain, "Side gain"), (Parameter::Bands, "Bands")],
    ),
    ("Sand", &[(Parameter::Grains, "Grains"), (Parameter::GrainSize, "Grain size")]),
    (
        "Stage",
        &[
            (Parameter::TransitionBeats, "Transition"),
            (Parameter::BeatsPerStep, "Step"),
            (Parameter::TurnRad, "Turn"),
            (Parameter::LightSwingRad, "Light swing"),
            (Parameter::LightPulse, "Light pulse"),
        ],
    ),
];

/// A switch and its name; [`Switch::about`] says what it does.
pub type Choice = (Switch, &'static str);

/// All switches, in groups that have names.
pub const SWITCHES: &[(&str, &[Choice])] = &[
    (
        "On the beat",
        &[
            (Switch::BeatTurns, "Turn the shape"),
            (Switch::BeatLights, "Move the lights"),
            (Switch::BeatSteps, "Next dance"),
            (Switch::Camera, "Choose shots"),
        ],
    ),
    (
        "Hearing",
        &[
            (Switch::LogBands, "Bands by pitch"),
            (Switch::FlipSides, "Exchange sides"),
            (Switch::Resonate, "Resonate"),
            (Switch::OwnMu, "Each its own µ"),
        ],
    ),
    ("Breeding", &[(Switch::Suggest, "Suggest")]),
    ("Experiment", &[(Switch::Sand, "Sand")]),
    ("Safety", &[(Switch::FlashLimit, "Limit flashes"), (Switch::FlashFields, "In any field of view")]),
];

/// How the value of a knob is shown: times `factor`, with `decimals` and a unit, which may be empty.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shown {
    /// A value is multiplied by it.
    pub factor: f64,
    /// Digits behind the point.
    pub decimals: usize,
    /// With the space before it.
    pub unit: &'static str,
}

/// How the value of a knob is shown.
pub fn shown(parameter: Parameter) -> Shown {
    let plain = |decimals| Shown { factor: 1.0, decimals, unit: "" };
    match parameter {
        Parameter::Bands | Parameter::BeatsPerStep | Parameter::Grains => plain(0),
        Parameter::TransitionBeats => plain(1),
        Parameter::GrainSize => Shown { factor: 100.0, decimals: 2, unit: " %" },
        Parameter::Calibration | Parameter::Limit => Shown { factor: 100.0, decimals: 1, unit: " %" },
        Parameter::TurnRad | Parameter::LightSwingRad => {
            Shown { factor: 180.0 / std::f64::consts::PI, decimals: 0, unit: "°" }
        }
        _ => plain(2),
    }
}

/// Whether a knob's slider goes by even factors rather than by even steps.
pub fn by_factors(parameter: Parameter) -> bool {
    let (low, high) = parameter.range();
    high / low.max(1e-3) > 500.0
}

/// A knob's name on screen.
pub fn knob_name(parameter: Parameter) -> &'static str {
    let mut rows = KNOBS.iter().flat_map(|(_, rows)| rows.iter());
    rows.find(|row| row.0 == parameter).map_or(parameter.name(), |row| row.1)
}

/// A switch's name on screen.
pub fn switch_name(switch: Switch) -> &'static str {
    let mut rows = SWITCHES.iter().flat_map(|(_, rows)| rows.iter());
    rows.find(|row| row.0 == switch).map_or(switch.name(), |row| row.1)
}

/// Why a form ignores a knob. `voices` may listen to the side in any form.
pub fn ignored_by(form: Form, parameter: Parameter, voices: bool) -> Option<&'static str> {
    match parameter {
        Parameter::StereoMu => form.ignores(FormControl::StereoMu),
        Parameter::SideGain if !voices => form.ignores(FormControl::SideGain),
        Parameter::Detail => form.ignores(FormControl::Detail),
        _ => None,
    }
}

/// The switch that a knob depends on, and how it has to stand.
pub fn needed_by(parameter: Parameter) -> Option<(Switch, bool)> {
    match parameter {
        Parameter::StereoMu => Some((Switch::OwnMu, false)),
        Parameter::Damping
        | Parameter::TuningHz
        | Parameter::Stretch
        | Parameter::Strike
        | Parameter::Hold => Some((Switch::Resonate, true)),
        Parameter::Grains | Parameter::GrainSize => Some((Switch::Sand, true)),
        Parameter::TurnRad => Some((Switch::BeatTurns, true)),
        Parameter::LightSwingRad | Parameter::LightPulse => Some((Switch::BeatLights, true)),
        _ => None,
    }
}

/// Why a knob has no effect now. `voices` may listen to the side in any form.
pub fn idle(parameters: &Parameters, parameter: Parameter, voices: bool) -> Option<&'static str> {
    let of_switch = || {
        let (switch, _) = needed_by(parameter).filter(|(switch, on)| parameters.is_on(*switch) != *on)?;
        match switch {
            Switch::OwnMu => Some("Each dance has its own µ now (see Hearing)."),
            Switch::Resonate => Some("Nothing resonates now (see Hearing)."),
            Switch::Sand => Some("There is no sand now (see Experiment)."),
            Switch::BeatTurns => Some("The shape does not turn now (see On the beat)."),
            Switch::BeatLights => Some("The lights do not move now (see On the beat)."),
            _ => None,
        }
    };
    ignored_by(parameters.form, parameter, voices).or_else(of_switch)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_knob_and_every_switch_is_there_once() {
        let mut knobs: Vec<Parameter> =
            KNOBS.iter().flat_map(|(_, rows)| rows.iter().map(|row| row.0)).collect();
        knobs.sort();
        assert_eq!(knobs, Parameter::ALL);
        let mut switches: Vec<Switch> =
            SWITCHES.iter().flat_map(|(_, rows)| rows.iter().map(|row| row.0)).collect();
        switches.sort();
        assert_eq!(switches, Switch::ALL);
    }

    #[test]
    fn knobs_of_turns_and_lights_rest_while_nothing_follows_the_beat() {
        for (switch, knobs) in [
            (Switch::BeatTurns, &[Parameter::TurnRad][..]),
            (Switch::BeatLights, &[Parameter::LightSwingRad, Parameter::LightPulse][..]),
        ] {
            let mut parameters = Parameters::default();
            assert!(knobs.iter().all(|knob| idle(&parameters, *knob, false).is_none()));
            parameters.switch(switch, false);
            assert!(knobs.iter().all(|knob| idle(&parameters, *knob, false).is_some()));
        }
    }

    #[test]
    fn knobs_of_resonators_and_sand_rest_without_them() {
        let mut parameters = Parameters::default();
        assert!(idle(&parameters, Parameter::Damping, false).is_none());
        parameters.switch(Switch::Resonate, false);
        assert!(idle(&parameters, Parameter::Damping, false).is_some());
        assert!(idle(&parameters, Parameter::Grains, false).is_some());
        parameters.switch(Switch::Sand, true);
        assert!(idle(&parameters, Parameter::Grains, false).is_none());
        assert!(idle(&parameters, Parameter::SideGain, false).is_some());
        assert!(idle(&parameters, Parameter::SideGain, true).is_none());
    }
}
