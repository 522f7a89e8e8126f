//! Controllers: what a MIDI or OSC message touches, and which knob, switch or cue that turns.
//!
//! Nothing here opens a device: bytes and addresses come in, [`Cue`]s go out.

use serde::{Deserialize, Serialize};

use crate::{Action, Choir, Form, Parameter, Parameters, Switch};

/// Something on a controller that can be touched.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", tag = "kind", deny_unknown_fields)]
pub enum Control {
    /// A MIDI controller (knob, fader), channel 0 to 15, number 0 to 127.
    Controller {
        /// Channel.
        channel: u8,
        /// Number.
        number: u8,
    },
    /// A MIDI note (pad, key).
    Note {
        /// Channel.
        channel: u8,
        /// Number.
        number: u8,
    },
    /// A MIDI pitch wheel.
    PitchBend {
        /// Channel.
        channel: u8,
    },
    /// An OSC address.
    Osc {
        /// Such as `/1/fader3`.
        address: String,
    },
}

impl std::fmt::Display for Control {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Controller { channel, number } => write!(f, "CC {number} ch {}", channel + 1),
            Self::Note { channel, number } => write!(f, "note {number} ch {}", channel + 1),
            Self::PitchBend { channel } => write!(f, "pitch bend ch {}", channel + 1),
            Self::Osc { address } => f.write_str(address),
        }
    }
}

/// A control was moved to `value` in [0, 1]; pads and buttons give 0 when they are released.
#[derive(Clone, Debug, PartialEq)]
pub struct Touch {
    /// Which.
    pub control: Control,
    /// Where it stands now.
    pub value: f32,
}

impl Touch {
    /// Reads one MIDI message: controllers, notes and pitch bend. Anything else, and what is cut
    /// short or out of range, is `None`.
    pub fn from_midi(bytes: &[u8]) -> Option<Self> {
        let &[status, number, value, ..] = bytes else { return None };
        if number > 127 || value > 127 {
            return None;
        }
        let (channel, share) = (status & 0x0f, f32::from(value) / 127.0);
        Some(match status & 0xf0 {
            0x80 => Self { control: Control::Note { channel, number }, value: 0.0 },
            0x90 => Self { control: Control::Note { channel, number }, value: share },
            0xb0 => Self { control: Control::Controller { channel, number }, value: share },
            0xe0 => {
                let wheel = u16::from(number) | u16::from(value) << 7;
                Self { control: Control::PitchBend { channel }, value: f32::from(wheel) / 16_383.0 }
            }
            _ => return None,
        })
    }
}

/// What a control turns.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Target {
    /// A knob.
    Parameter(Parameter),
    /// A switch: each press turns it over.
    Switch(Switch),
    /// Harmonics in use.
    Harmonics,
    /// The next form.
    Form,
    /// The next choir.
    Choir,
    /// Breeds the chosen items.
    Breed,
    /// Puts the favourites on stage, or steps to the next.
    NextFavourite,
    /// Steps to the favourite before.
    PreviousFavourite,
    /// Back to the gallery.
    LeaveStage,
    /// Sweeps the sand off and pours it anew.
    Sweep,
    /// A beat by hand.
    Tap,
    /// Plays or pauses.
    PlayPause,
}

impl Target {
    /// The targets that are pressed rather than turned, except the switches.
    pub const BUTTONS: [Self; 7] = [
        Self::Breed,
        Self::NextFavourite,
        Self::PreviousFavourite,
        Self::LeaveStage,
        Self::Sweep,
        Self::Tap,
        Self::PlayPause,
    ];

    /// Targets with a few choices, and the number of harmonics in use.
    pub const CHOICES: [Self; 3] = [Self::Form, Self::Choir, Self::Harmonics];
}

/// What a touch asks of the instrument or of the room around it.
#[derive(Clone, Debug, PartialEq)]
pub enum Cue {
    /// An action of the instrument.
    Do(Action),
    /// The favourite after (true) or before the one on stage.
    StepFavourite(bool),
    /// A beat by hand.
    Tap,
    /// Plays or pauses.
    PlayPause,
}

/// One control and what it turns.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Binding {
    /// The control.
    pub control: Control,
    /// What it turns.
    pub target: Target,
}

/// At most this many bindings are kept.
const MOST_BINDINGS: usize = 512;

/// All bindings, and the target that waits for a control.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Bindings {
    list: Vec<Binding>,
    learning: Option<Target>,
    /// Controls that are pressed, so that a pad that repeats its value presses once.
    pressed: Vec<Control>,
}

impl Bindings {
    /// Bindings as read from a file; of a control that is listed twice, the last target counts.
    pub fn new(list: Vec<Binding>) -> Self {
        let mut bindings = Self::default();
        for binding in list {
            bindings.bind(binding);
        }
        bindings
    }

    /// All of them, oldest first.
    pub fn list(&self) -> &[Binding] {
        &self.list
    }

    /// The next control that is touched is bound to `target`; `None` stops waiting.
    pub fn learn(&mut self, target: Option<Target>) {
        self.learning = target;
    }

    /// The target that waits for a control.
    pub fn learning(&self) -> Option<Target> {
        self.learning
    }

    /// Takes a binding out of the list.
    pub fn forget(&mut self, binding: usize) {
        if binding < self.list.len() {
            let forgotten = self.list.remove(binding);
            self.pressed.retain(|held| *held != forgotten.control);
        }
    }

    /// What a touch does: if a target is waiting for a control, the control is bound to it; otherwise it
    /// turns its target.
    pub fn touch(&mut self, touch: &Touch, parameters: &Parameters) -> Option<Cue> {
        let value = if touch.value.is_finite() { touch.value.clamp(0.0, 1.0) } else { return None };
        if value > 0.0
            && let Some(target) = self.learning.take()
        {
            self.bind(Binding { control: touch.control.clone(), target });
        }
        let target = self.list.iter().find(|binding| binding.control == touch.control)?.target;
        // Remembered only for bound controls, so that other messages cannot fill the memory.
        let pressed = self.press(&touch.control, value);
        match target {
            Target::Parameter(parameter) => {
                Some(Cue::Do(Action::Set { parameter, value: parameter.at_share(value) }))
            }
            Target::Harmonics => {
                // At least 2: 0 would mean all of them.
                let harmonics = (MOST_HARMONICS * value).round().max(2.0) as u32;
                Some(Cue::Do(Action::SetHarmonics { harmonics }))
            }
            _ if !pressed => None,
            Target::Form => next(&FORMS, parameters.form).map(|form| Cue::Do(Action::SetForm { form })),
            Target::Choir => next(&CHOIRS, parameters.choir).map(|choir| Cue::Do(Action::SetChoir { choir })),
            Target::Switch(switch) => Some(Cue::Do(Action::Switch { switch, on: !parameters.is_on(switch) })),
            Target::Breed => Some(Cue::Do(Action::Breed)),
            Target::LeaveStage => Some(Cue::Do(Action::LeaveStage)),
            Target::Sweep => Some(Cue::Do(Action::Sweep)),
            Target::NextFavourite => Some(Cue::StepFavourite(true)),
            Target::PreviousFavourite => Some(Cue::StepFavourite(false)),
            Target::Tap => Some(Cue::Tap),
            Target::PlayPause => Some(Cue::PlayPause),
        }
    }

    /// Whether this value presses the control: it passes the threshold from below.
    fn press(&mut self, control: &Control, value: f32) -> bool {
        let held = self.pressed.iter().position(|known| known == control);
        // A soft hit of a pad counts; a fader has to pass its middle.
        let least = if matches!(control, Control::Note { .. }) { f32::MIN_POSITIVE } else { 0.5 };
        match (held, value >= least) {
            (None, true) => {
                self.pressed.push(control.clone());
                true
            }
            (Some(at), false) => {
                self.pressed.swap_remove(at);
                false
            }
            _ => false,
        }
    }

    fn bind(&mut self, binding: Binding) {
        self.list.retain(|known| known.control != binding.control);
        if self.list.len() < MOST_BINDINGS {
            self.list.push(binding);
        }
    }
}

/// The forms and choirs by their names, in the order of their numbers.
const FORMS: [(&str, Form); 3] =
    [("filter", Form::Filter), ("modal", Form::Modal), ("half-mask", Form::HalfMask)];
const CHOIRS: [(&str, Choir); 3] =
    [("all", Choir::All), ("symmetric", Choir::Symmetric), ("antisymmetric", Choir::Antisymmetric)];
/// Harmonics at the top of a fader.
const MOST_HARMONICS: f32 = 512.0;

/// The action that sets a knob, a switch or a choice by name, the same for OSC, scripts and the command line:
/// knobs take their own units, switches `on`, `off` or a number, `form` and `choir` a name or a number from
/// 0, `harmonics` how many are in use (0 is all).
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
            Some(Action::SetHarmonics { harmonics: number()?.round().clamp(0.0, 16_384.0) as u32 })
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

/// The choice after `now`.
fn next<T: Copy + PartialEq>(choices: &[(&str, T)], now: T) -> Option<T> {
    let at = choices.iter().position(|(_, choice)| *choice == now)?;
    choices.get((at + 1) % choices.len()).map(|(_, choice)| *choice)
}

/// What an OSC message to one of this instrument's own addresses asks for, without any binding:
/// `/chladni/NAME VALUE` is [`setting`]; `/chladni/NAME/CHOICE` is the same for a form or a choir;
/// `/chladni/breed`, `/chladni/next`, `/chladni/previous`, `/chladni/leave`, `/chladni/sweep`, `/chladni/tap` and
/// `/chladni/play` press a button (a value of 0 is its release).
pub fn osc_cue(address: &str, value: Option<f32>) -> Option<Cue> {
    let name = address.strip_prefix("/chladni/")?;
    if value.is_some_and(f32::is_nan) {
        return None;
    }
    if let Some(action) = value.and_then(|value| setting(name, &value.to_string())) {
        return Some(Cue::Do(action));
    }
    if value == Some(0.0) {
        return None;
    }
    if let Some((name, choice)) = name.split_once('/') {
        return setting(name, choice).map(Cue::Do);
    }
    match name {
        "breed" => Some(Cue::Do(Action::Breed)),
        "next" => Some(Cue::StepFavourite(true)),
        "previous" => Some(Cue::StepFavourite(false)),
        "leave" => Some(Cue::Do(Action::LeaveStage)),
        "sweep" => Some(Cue::Do(Action::Sweep)),
        "tap" => Some(Cue::Tap),
        "play" => Some(Cue::PlayPause),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn knob(number: u8, value: u8) -> Touch {
        Touch::from_midi(&[0xb2, number, value]).unwrap()
    }

    #[test]
    fn midi_messages_are_read() {
        let touch = |bytes: &[u8]| Touch::from_midi(bytes).map(|t| (t.control, t.value));
        let note = Control::Note { channel: 9, number: 36 };
        assert_eq!(touch(&[0xb2, 7, 127]), Some((Control::Controller { channel: 2, number: 7 }, 1.0)));
        assert_eq!(touch(&[0x99, 36, 0]), Some((note.clone(), 0.0)));
        assert_eq!(touch(&[0x89, 36, 64]), Some((note, 0.0)));
        assert_eq!(touch(&[0xe0, 127, 127]), Some((Control::PitchBend { channel: 0 }, 1.0)));
        for nothing in [&[][..], &[0xb0], &[0xb0, 7], &[0xb0, 200, 3], &[0xf8, 0, 0], &[0xc0, 1, 0]] {
            assert_eq!(touch(nothing), None, "{nothing:?}");
        }
    }

    #[test]
    fn a_knob_is_learned_turned_and_forgotten() {
        let (mut bindings, parameters) = (Bindings::default(), Parameters::default());
        assert_eq!(bindings.touch(&knob(7, 64), &parameters), None);
        bindings.learn(Some(Target::Parameter(Parameter::Limit)));
        let set = |value| Some(Cue::Do(Action::Set { parameter: Parameter::Limit, value }));
        assert_eq!(bindings.touch(&knob(7, 127), &parameters), set(1.0));
        assert_eq!(bindings.learning(), None);
        assert_eq!(bindings.touch(&knob(7, 0), &parameters), set(0.01));
        assert_eq!(bindings.touch(&knob(8, 127), &parameters), None);
        let text = toml::to_string(&std::collections::BTreeMap::from([("list", bindings.list())])).unwrap();
        let mut read: std::collections::BTreeMap<String, Vec<Binding>> = toml::from_str(&text).unwrap();
        assert_eq!(read.remove("list").unwrap(), bindings.list());
        bindings.forget(0);
        bindings.forget(0);
        assert_eq!(bindings.touch(&knob(7, 127), &parameters), None);
    }

    #[test]
    fn pads_press_once_and_switches_turn_over() {
        let pad = |value| Touch { control: Control::Note { channel: 0, number: 1 }, value };
        let mut bindings = Bindings::new(vec![
            Binding { control: pad(0.0).control, target: Target::Tap },
            Binding { control: pad(0.0).control, target: Target::Switch(Switch::BeatTurns) },
        ]);
        let mut parameters = Parameters::default();
        assert_eq!(bindings.list().len(), 1);
        let turn = |on| Some(Cue::Do(Action::Switch { switch: Switch::BeatTurns, on }));
        assert_eq!(bindings.touch(&pad(0.1), &parameters), turn(false));
        parameters.switch(Switch::BeatTurns, false);
        assert_eq!(bindings.touch(&pad(0.9), &parameters), None);
        assert_eq!(bindings.touch(&pad(0.0), &parameters), None);
        assert_eq!(bindings.touch(&pad(0.9), &parameters), turn(true));
        assert_eq!(bindings.touch(&pad(f32::NAN), &parameters), None);
    }

    #[test]
    fn what_turns_nothing_does_not_make_a_held_pad_press_again() {
        let pad = |number| Touch { control: Control::Note { channel: 0, number }, value: 1.0 };
        let target = Target::Switch(Switch::BeatTurns);
        let mut bindings = Bindings::new(vec![Binding { control: pad(7).control, target }]);
        let parameters = Parameters::default();
        for strange in 0..2 * MOST_BINDINGS {
            let control = Control::Osc { address: format!("/{strange}") };
            assert_eq!(bindings.touch(&Touch { control, value: 1.0 }, &parameters), None);
        }
        assert!(bindings.touch(&pad(7), &parameters).is_some());
        assert_eq!(bindings.touch(&pad(7), &parameters), None);
    }

    #[test]
    fn own_addresses_need_no_learning() {
        let set = |parameter, value| Some(Cue::Do(Action::Set { parameter, value }));
        assert_eq!(osc_cue("/chladni/side-gain", Some(20.0)), set(Parameter::SideGain, 20.0));
        assert_eq!(osc_cue("/chladni/side-gain", Some(1e9)), set(Parameter::SideGain, 100.0));
        assert_eq!(osc_cue("/chladni/side-gain", Some(f32::NAN)), None);
        let off = Action::Switch { switch: Switch::FlashLimit, on: false };
        assert_eq!(osc_cue("/chladni/flash-limit", Some(0.0)), Some(Cue::Do(off)));
        assert_eq!(osc_cue("/chladni/flash-limit", Some(f32::NAN)), None);
        assert_eq!(osc_cue("/chladni/breed", None), Some(Cue::Do(Action::Breed)));
        let modal = Some(Cue::Do(Action::SetForm { form: Form::Modal }));
        assert_eq!(osc_cue("/chladni/form", Some(1.0)), modal);
        assert_eq!(osc_cue("/chladni/form/modal", None), modal);
        let few = Some(Cue::Do(Action::SetHarmonics { harmonics: 128 }));
        assert_eq!(osc_cue("/chladni/harmonics", Some(128.0)), few);
        assert_eq!(osc_cue("/chladni/stereo-mu", Some(0.25)), set(Parameter::StereoMu, 0.25));
        assert_eq!(setting("choir", "symmetric"), Some(Action::SetChoir { choir: Choir::Symmetric }));
        assert_eq!(
            setting("beat-turns", "off"),
            Some(Action::Switch { switch: Switch::BeatTurns, on: false })
        );
        for (name, value) in [("form", "7"), ("form", "-1"), ("gain", "loud"), ("volume", "1")] {
            assert_eq!(setting(name, value), None, "{name} {value}");
        }
        assert_eq!(osc_cue("/chladni/tap", Some(0.0)), None);
        for nothing in ["", "/", "/chladni", "/chladni/", "/other/gain", "chladni/gain"] {
            assert_eq!(osc_cue(nothing, Some(1.0)), None);
        }
    }

    proptest! {
        #[test]
        fn any_bytes_turn_only_what_the_instrument_takes(
            messages in prop::collection::vec(prop::collection::vec(any::<u8>(), 0..5), 0..40))
        {
            let mut parameters = Parameters::default();
            let mut bindings = Bindings::default();
            for (i, message) in messages.iter().enumerate() {
                bindings.learn(Some(Target::Parameter(Parameter::ALL[i % Parameter::ALL.len()])));
                let Some(touch) = Touch::from_midi(message) else { continue };
                if let Some(Cue::Do(Action::Set { parameter, value })) = bindings.touch(&touch, &parameters) {
                    prop_assert!(parameters.set(parameter, value).is_ok());
                }
            }
        }
    }
}
