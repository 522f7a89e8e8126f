//! The requests that controls make: an action of the instrument, or something of the window.

use crate::target::{CHOIRS, FORMS, Kind, MOST_HARMONICS, Target};
use crate::{Action, MAX_GENES, Parameter, Parameters, Switch};

/// Which choice or dance, or which level.
#[derive(Clone, Debug, PartialEq)]
pub enum Which {
    /// A press: the next choice, or the dance that is marked.
    Press,
    /// The choice or dance with this number, from 1.
    Number(u32),
    /// The choice or dance with this name.
    Name(String),
    /// This level, in [0, 1].
    Level(f32),
}

/// A request of a control to the instrument or the window.
#[derive(Clone, Debug, PartialEq)]
pub enum Cue {
    /// An action of the instrument.
    Do(Action),
    /// A request to the window.
    Ask(Target, Which),
}

impl Cue {
    /// The cue for a target. Targets of the instrument give actions, all others give requests.
    pub fn of(target: Target, which: Which, parameters: &Parameters) -> Option<Self> {
        let action = match (target, &which) {
            (Target::Parameter(parameter), Which::Level(share)) => {
                Action::Set { parameter, value: parameter.at_share(*share) }
            }
            (Target::Harmonics, Which::Level(share)) => {
                // At least 2, because 0 would mean all of them.
                Action::SetHarmonics { harmonics: (MOST_HARMONICS * share).round().max(2.0) as u32 }
            }
            (Target::Switch(switch), Which::Press) => {
                Action::Switch { switch, on: !parameters.is_on(switch) }
            }
            (Target::Form, which) => Action::SetForm { form: pick(&FORMS, parameters.form, which)? },
            (Target::Choir, which) => Action::SetChoir { choir: pick(&CHOIRS, parameters.choir, which)? },
            (Target::Breed, Which::Press) => Action::Breed,
            (Target::LeaveStage, Which::Press) => Action::LeaveStage,
            (Target::Sweep, Which::Press) => Action::Sweep,
            _ => return Some(Self::Ask(target, which)),
        };
        Some(Self::Do(action))
    }
}

/// What must be done before `action` so that it is seen at once: the µ of all dances counts while no dance has its own.
pub fn preceding(action: &Action, parameters: &Parameters) -> Option<Action> {
    let is_mu = matches!(action, Action::Set { parameter: Parameter::StereoMu, .. });
    (is_mu && parameters.is_on(Switch::OwnMu)).then_some(Action::Switch { switch: Switch::OwnMu, on: false })
}

/// The action that sets a knob, a switch or a choice by name; the same for OSC, scripts and the command
/// line. Knobs take a value in their own unit; switches `on`, `off` or a number; `form` and `choir` a name
/// or a number from 0; `harmonics` the number in use (0 for all).
pub fn setting(name: &str, value: &str) -> Option<Action> {
    let number = || value.parse::<f32>().ok().filter(|value| value.is_finite());
    if let Some(parameter) = Parameter::ALL.into_iter().find(|p| p.name() == name) {
        let (low, high) = parameter.range();
        let value = number()?.clamp(low, high);
        return Some(Action::Set { parameter, value });
    }
    if let Some(switch) = Switch::ALL.into_iter().find(|s| s.name() == name) {
        let on = match value {
            "on" => true,
            "off" => false,
            _ => number()? >= 0.5,
        };
        return Some(Action::Switch { switch, on });
    }
    match name {
        "form" => Some(Action::SetForm { form: choice(&FORMS, value)? }),
        "choir" => Some(Action::SetChoir { choir: choice(&CHOIRS, value)? }),
        "harmonics" => {
            Some(Action::SetHarmonics { harmonics: number()?.round().clamp(0.0, MAX_GENES as f32) as u32 })
        }
        _ => None,
    }
}

fn choice<T: Copy>(choices: &[(&str, T)], value: &str) -> Option<T> {
    let number =
        || value.parse::<f32>().ok().filter(|value| *value >= 0.0).map(|value| value.round() as usize);
    let named = choices.iter().find(|(name, _)| *name == value);
    named.or_else(|| choices.get(number()?)).map(|(_, choice)| *choice)
}

/// The choice after `now`, or the one that `which` names.
fn pick<T: Copy + PartialEq>(choices: &[(&str, T)], now: T, which: &Which) -> Option<T> {
    let at = match which {
        Which::Press => (choices.iter().position(|(_, choice)| *choice == now)? + 1) % choices.len(),
        Which::Number(number) => (*number as usize).checked_sub(1)?,
        Which::Name(name) => choices.iter().position(|(known, _)| known == name)?,
        Which::Level(share) => ((share * choices.len() as f32) as usize).min(choices.len() - 1),
    };
    choices.get(at).map(|(_, choice)| *choice)
}

/// The cue of an OSC message to one of the instrument's own addresses, which needs no binding.
/// `/chladni/NAME VALUE` is [`setting`] for knobs, switches, form, choir and harmonics. For other targets
/// the value says which one: a level in [0, 1], a number from 1, or a name; `/chladni/NAME/WHICH` means the
/// same; numbers below 1 are none. A number that is sent as text is a name first: songs may be called so. A button
/// is pressed by a message without a value, and a value of 0 releases it.
pub fn osc_cue(
    address: &str,
    value: Option<f32>,
    text: Option<&str>,
    parameters: &Parameters,
) -> Option<Cue> {
    let name = address.strip_prefix("/chladni/")?;
    if value.is_some_and(f32::is_nan) {
        return None;
    }
    let in_address = name.contains('/');
    let (name, text, value) = match name.split_once('/') {
        // Where the address says which one, the value only presses.
        Some((name, which)) if value != Some(0.0) => (name, Some(which), None),
        Some(_) => return None,
        None => (name, text, value),
    };
    let written = text.map(str::to_owned).or_else(|| value.map(|value| value.to_string()));
    if let Some(action) = written.and_then(|written| setting(name, &written)) {
        return Some(Cue::Do(action));
    }
    let target = Target::named(name)?;
    let which = match (target.kind(), text, value) {
        // Knobs, switches, forms and choirs take no other values.
        _ if setting(name, "0").is_some() && (text.is_some() || value.is_some()) => return None,
        (Kind::Level, text, value) => {
            let written = || text?.parse().ok().filter(|level: &f32| level.is_finite());
            Which::Level(value.or_else(written)?.clamp(0.0, 1.0))
        }
        (Kind::Choice | Kind::Dance, Some(text), _) => match text.parse() {
            Ok(number) if in_address => Which::Number(number),
            _ => Which::Name(text.to_owned()),
        },
        (_, _, Some(0.0)) => return None,
        (Kind::Choice | Kind::Dance, None, Some(value)) => match value.round() {
            number if number >= 1.0 => Which::Number(number as u32),
            // Each step of a fader would press.
            _ => return None,
        },
        _ => Which::Press,
    };
    Cue::of(target, which, parameters)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Choir, Form};

    fn cue(address: &str, value: Option<f32>) -> Option<Cue> {
        osc_cue(address, value, None, &Parameters::default())
    }

    #[test]
    fn own_addresses_need_no_learning() {
        let set = |parameter, value| Some(Cue::Do(Action::Set { parameter, value }));
        assert_eq!(cue("/chladni/side-gain", Some(20.0)), set(Parameter::SideGain, 20.0));
        assert_eq!(cue("/chladni/side-gain", Some(1e9)), set(Parameter::SideGain, 100.0));
        assert_eq!(cue("/chladni/side-gain", Some(f32::NAN)), None);
        let off = Action::Switch { switch: Switch::FlashLimit, on: false };
        assert_eq!(cue("/chladni/flash-limit", Some(0.0)), Some(Cue::Do(off)));
        assert_eq!(cue("/chladni/flash-limit", Some(f32::NAN)), None);
        assert_eq!(cue("/chladni/breed", None), Some(Cue::Do(Action::Breed)));
        let modal = Some(Cue::Do(Action::SetForm { form: Form::Modal }));
        assert_eq!(cue("/chladni/form", Some(1.0)), modal);
        assert_eq!(cue("/chladni/form/modal", None), modal);
        assert_eq!(osc_cue("/chladni/form", None, Some("modal"), &Parameters::default()), modal);
        assert_eq!((cue("/chladni/form/loud", None), cue("/chladni/form", Some(9.0))), (None, None));
        let few = Some(Cue::Do(Action::SetHarmonics { harmonics: 128 }));
        assert_eq!(cue("/chladni/harmonics", Some(128.0)), few);
        assert_eq!(cue("/chladni/stereo-mu", Some(0.25)), set(Parameter::StereoMu, 0.25));
        assert_eq!(setting("choir", "symmetric"), Some(Action::SetChoir { choir: Choir::Symmetric }));
        assert_eq!(
            setting("beat-turns", "off"),
            Some(Action::Switch { switch: Switch::BeatTurns, on: false })
        );
        for (name, value) in [("form", "7"), ("form", "-1"), ("gain", "loud"), ("volume", "1")] {
            assert_eq!(setting(name, value), None, "{name} {value}");
        }
        for nothing in ["", "/", "/chladni", "/chladni/", "/other/gain", "chladni/gain"] {
            assert_eq!(cue(nothing, Some(1.0)), None);
        }
    }

    #[test]
    fn the_mu_of_a_knob_takes_the_place_of_those_of_the_dances() {
        let set = |parameter| Action::Set { parameter, value: 0.5 };
        let parameters = Parameters::default();
        assert!(parameters.is_on(Switch::OwnMu), "each dance has its own at first");
        let off = Action::Switch { switch: Switch::OwnMu, on: false };
        assert_eq!(preceding(&set(Parameter::StereoMu), &parameters), Some(off));
        assert_eq!(preceding(&set(Parameter::Gain), &parameters), None);
        let mut of_all = parameters;
        of_all.switch(Switch::OwnMu, false);
        assert_eq!(preceding(&set(Parameter::StereoMu), &of_all), None);
    }

    #[test]
    fn the_room_is_asked_for_the_rest() {
        let ask = |target, which| Some(Cue::Ask(target, which));
        assert_eq!(cue("/chladni/tap", Some(1.0)), ask(Target::Tap, Which::Press));
        assert_eq!(cue("/chladni/tap", Some(0.0)), None);
        assert_eq!(cue("/chladni/preset", Some(12.0)), ask(Target::Preset, Which::Number(12)));
        assert_eq!(cue("/chladni/preset/7", None), ask(Target::Preset, Which::Number(7)));
        let named = osc_cue("/chladni/preset", None, Some("slow tide"), &Parameters::default());
        assert_eq!(named, ask(Target::Preset, Which::Name("slow tide".into())));
        let called = osc_cue("/chladni/song", None, Some("1999"), &Parameters::default());
        assert_eq!(called, ask(Target::Song, Which::Name("1999".into())));
        assert_eq!(cue("/chladni/look", None), ask(Target::Look, Which::Press));
        assert_eq!(cue("/chladni/choose", Some(3.0)), ask(Target::Choose, Which::Number(3)));
        assert_eq!(cue("/chladni/choose", Some(0.0)), None);
        for below in [-1.0, -0.0, 0.31, 0.32, 0.49] {
            assert_eq!(
                (cue("/chladni/song", Some(below)), cue("/chladni/choose", Some(below))),
                (None, None)
            );
        }
        assert_eq!(cue("/chladni/song", Some(0.9)), ask(Target::Song, Which::Number(1)));
        assert_eq!(cue("/chladni/song", None), ask(Target::Song, Which::Press));
        assert_eq!(cue("/chladni/breed", Some(0.31)), Some(Cue::Do(Action::Breed)));
        assert_eq!(cue("/chladni/crossfade", Some(7.0)), ask(Target::Crossfade, Which::Level(1.0)));
        assert_eq!(cue("/chladni/crossfade", None), None);
        for pressed in [None, Some(1.0), Some(0.7)] {
            let level = |level| ask(Target::Volume, Which::Level(level));
            assert_eq!(cue("/chladni/volume/0.3", pressed), level(0.3));
            assert_eq!(cue("/chladni/volume/7", pressed), level(1.0));
            for no_level in ["/chladni/volume/loud", "/chladni/volume/NaN", "/chladni/volume/"] {
                assert_eq!(cue(no_level, pressed), None, "{no_level}");
            }
        }
        assert_eq!(cue("/chladni/volume/0.3", Some(0.0)), None, "the button is released");
        let labeled = osc_cue("/chladni/volume", Some(0.3), Some("loud"), &Parameters::default());
        assert_eq!(labeled, ask(Target::Volume, Which::Level(0.3)));
        assert_eq!(cue("/chladni/blackout/7", Some(0.0)), None);
    }
}
