//! Controllers: what a MIDI or OSC message touches, and what that turns.
//!
//! Nothing here opens a device: bytes and addresses come in, [`Cue`]s and messages for the device go out.

use serde::{Deserialize, Serialize};

use crate::target::{Cue, Kind, Target, Which};
use crate::text_file::{self, FORMAT_VERSION};
use crate::{Control, MusicError, Parameters, Touch};

/// One control and what it turns.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Binding {
    /// The device, by its name; empty is any.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub device: String,
    /// The control.
    pub control: Control,
    /// What it turns.
    pub target: Target,
    /// Which choice or dance it takes, from 1; `None` is the next choice, or the dance that is marked.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub number: Option<u32>,
}

impl Binding {
    fn is_of(&self, device: &str, control: &Control) -> bool {
        self.control == *control && (self.device.is_empty() || self.device == device)
    }
}

/// At most this many bindings are kept.
const MOST_BINDINGS: usize = 512;
/// A knob this near takes over: two steps of a MIDI controller.
const NEAR: f32 = 2.1 / 127.0;

/// Where a target stands, in [0, 1]: of choices and dances, whether the one of that number is the one. `None` where that
/// is not known or means nothing.
pub type Standing<'a> = &'a dyn Fn(Target, Option<u32>) -> Option<f32>;

/// What is remembered of a binding's control while the program runs.
#[derive(Clone, Debug, Default, PartialEq)]
struct Hand {
    /// It is pressed, so that a pad that repeats its value presses once.
    pressed: bool,
    /// Where it was last.
    at: Option<f32>,
    /// Where it has last put its target: while that stays there, the hand has it.
    put: Option<f32>,
    /// The message that the device shows.
    shown: Option<[u8; 3]>,
}

/// All bindings, and the target that waits for a control.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Bindings {
    list: Vec<Binding>,
    /// One for each binding.
    hands: Vec<Hand>,
    learning: Option<(Target, Option<u32>)>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct BindingFile {
    format_version: u32,
    #[serde(default)]
    binding: Vec<Binding>,
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

    /// As a text file.
    ///
    /// # Errors
    /// Bugs only: all bindings can be written.
    pub fn to_text(&self) -> Result<String, MusicError> {
        text_file::print(
            "bindings",
            &BindingFile { format_version: FORMAT_VERSION, binding: self.list.clone() },
        )
    }

    /// Takes the bindings of a text file; those of other devices and controls stay. Returns how many there were.
    ///
    /// # Errors
    /// Text that does not list bindings, with its line, or a newer format version. Nothing changes then.
    pub fn import(&mut self, text: &str) -> Result<usize, MusicError> {
        text_file::version("bindings", text)?;
        let file: BindingFile = text_file::parse("bindings", text)?;
        let count = file.binding.len();
        file.binding.into_iter().for_each(|binding| self.bind(binding));
        Ok(count)
    }

    /// The next control that is touched is bound to a target and a number; `None` stops waiting.
    pub fn learn(&mut self, target: Option<(Target, Option<u32>)>) {
        self.learning = target;
    }

    /// The target that waits for a control, and its number.
    pub fn learning(&self) -> Option<(Target, Option<u32>)> {
        self.learning
    }

    /// Takes a binding out of the list.
    pub fn forget(&mut self, binding: usize) {
        if binding < self.list.len() {
            self.list.remove(binding);
            self.hands.remove(binding);
        }
    }

    /// What a touch does: if a target is waiting for a control, the control is bound to it; otherwise it
    /// turns its target. A knob or fader that stands elsewhere than its target takes over where it passes it.
    pub fn touch(&mut self, touch: &Touch, parameters: &Parameters, standing: Standing<'_>) -> Option<Cue> {
        let value = if touch.value.is_finite() { touch.value.clamp(0.0, 1.0) } else { return None };
        let learned = self.learning.filter(|_| value > 0.0);
        if let Some((target, number)) = learned {
            self.learning = None;
            let (device, control) = (touch.device.clone(), touch.control.clone());
            self.bind(Binding { device, control, target, number });
        }
        let at = self.list.iter().position(|binding| binding.is_of(&touch.device, &touch.control))?;
        let (binding, hand) = (self.list.get(at)?, self.hands.get_mut(at)?);
        let pressed = hand.press(&binding.control, value);
        let which = match (binding.target.kind(), binding.number) {
            (Kind::Level, _) => {
                let now = standing(binding.target, None).filter(|_| learned.is_none());
                let soft = matches!(binding.control, Control::Controller { .. } | Control::PitchBend { .. });
                if !hand.turn(value, now.filter(|_| soft)) {
                    return None;
                }
                Which::Level(value)
            }
            _ if !pressed => return None,
            (Kind::Choice | Kind::Dance, Some(number)) => Which::Number(number),
            _ => Which::Press,
        };
        Cue::of(binding.target, which, parameters)
    }

    /// The messages that let devices which `listens` show where things stand: each with its device. Only what is new is
    /// sent; bindings that are not of one device tell none.
    pub fn feedback(
        &mut self,
        standing: Standing<'_>,
        listens: &dyn Fn(&str) -> bool,
    ) -> Vec<(String, [u8; 3])> {
        let mut messages = Vec::new();
        for (binding, hand) in self.list.iter().zip(&mut self.hands) {
            if binding.device.is_empty() || !listens(&binding.device) {
                // Plugged in again, all is sent anew.
                hand.shown = None;
                continue;
            }
            let shows =
                standing(binding.target, binding.number).and_then(|share| binding.control.message(share));
            // A fader that is being moved shows the same already, or fights the hand.
            let is_there = hand.put.is_some() && hand.put.and_then(|at| binding.control.message(at)) == shows;
            if let Some(message) = shows.filter(|message| hand.shown != Some(*message)) {
                hand.shown = Some(message);
                if !is_there {
                    messages.push((binding.device.clone(), message));
                }
            }
        }
        messages
    }

    fn bind(&mut self, binding: Binding) {
        while let Some(known) = self.list.iter().position(|known| {
            known.control == binding.control && (known.device.is_empty() || known.device == binding.device)
        }) {
            self.forget(known);
        }
        if self.list.len() < MOST_BINDINGS {
            self.list.push(binding);
            self.hands.push(Hand::default());
        }
    }
}

impl Hand {
    /// Whether this value presses the control: it passes the threshold from below.
    fn press(&mut self, control: &Control, value: f32) -> bool {
        // A soft hit of a pad counts; a fader has to pass its middle.
        let least = if matches!(control, Control::Note { .. }) { f32::MIN_POSITIVE } else { 0.5 };
        let before = std::mem::replace(&mut self.pressed, value >= least);
        self.pressed && !before
    }

    /// Whether a knob at `value` turns its target, which stands at `now`; `None` takes over at once.
    fn turn(&mut self, value: f32, now: Option<f32>) -> bool {
        let before = self.at.replace(value);
        let has = now.is_none_or(|now| {
            let stays = self.put.is_some_and(|put| (put - now).abs() < NEAR);
            let passes = before.is_some_and(|before| (before - now) * (value - now) <= 0.0);
            stays || passes || (value - now).abs() < NEAR
        });
        self.put = has.then_some(value);
        has
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Action, Parameter, Switch};
    use proptest::prelude::*;

    fn knob(number: u8, value: u8) -> Touch {
        Touch::from_midi("desk", &[0xb2, number, value]).unwrap()
    }

    fn binding(control: Control, target: Target) -> Binding {
        Binding { device: String::new(), control, target, number: None }
    }

    /// What a touch does where the room knows of nothing but the knobs.
    fn touch(bindings: &mut Bindings, touch: &Touch, parameters: &Parameters) -> Option<Cue> {
        bindings.touch(touch, parameters, &|target, number| target.standing(number, parameters))
    }

    #[test]
    fn midi_messages_are_read() {
        let touch = |bytes: &[u8]| Touch::from_midi("", bytes).map(|t| (t.control, t.value));
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
        let (mut bindings, mut parameters) = (Bindings::default(), Parameters::default());
        assert_eq!(touch(&mut bindings, &knob(7, 64), &parameters), None);
        bindings.learn(Some((Target::Parameter(Parameter::Limit), None)));
        let set = |value| Some(Cue::Do(Action::Set { parameter: Parameter::Limit, value }));
        assert_eq!(touch(&mut bindings, &knob(7, 127), &parameters), set(1.0));
        parameters.set(Parameter::Limit, 1.0).unwrap();
        assert_eq!(bindings.learning(), None);
        assert_eq!(touch(&mut bindings, &knob(7, 0), &parameters), set(0.01));
        assert_eq!(touch(&mut bindings, &knob(8, 127), &parameters), None);
        let text = bindings.to_text().unwrap();
        let mut read = Bindings::default();
        assert_eq!(read.import(&text).unwrap(), 1);
        assert_eq!(read.list(), bindings.list());
        assert_eq!(read.list()[0].device, "desk");
        assert!(read.import("format_version = 3\nbinding = 7").is_err());
        bindings.forget(0);
        bindings.forget(0);
        assert_eq!(touch(&mut bindings, &knob(7, 127), &parameters), None);
    }

    #[test]
    fn a_knob_takes_over_where_it_passes_its_target() {
        let target = Target::Parameter(Parameter::StereoMu);
        let mut bindings = Bindings::new(vec![binding(knob(1, 0).control, target)]);
        let mut parameters = Parameters::default();
        parameters.set(Parameter::StereoMu, 0.5).unwrap();
        let turn = |bindings: &mut Bindings, parameters: &mut Parameters, value: u8| {
            let cue = touch(bindings, &knob(1, value), parameters);
            if let Some(Cue::Do(Action::Set { parameter, value })) = cue {
                parameters.set(parameter, value).unwrap();
                return true;
            }
            false
        };
        let turned = [10, 30, 50, 70, 90, 20].map(|value| turn(&mut bindings, &mut parameters, value));
        assert_eq!(turned, [false, false, false, true, true, true]);
        // Somebody else turns it: the knob has to come and take it again.
        parameters.set(Parameter::StereoMu, 0.9).unwrap();
        let turned = [25, 60, 113, 100].map(|value| turn(&mut bindings, &mut parameters, value));
        assert_eq!(turned, [false, false, true, true]);
    }

    #[test]
    fn devices_show_where_things_stand_and_are_told_once() {
        let note = Control::Note { channel: 0, number: 40 };
        let fader = Control::PitchBend { channel: 3 };
        let of = |device: &str, control: &Control, target, number| Binding {
            device: device.into(),
            control: control.clone(),
            target,
            number,
        };
        let mut bindings = Bindings::new(vec![
            of("pads", &note, Target::Switch(Switch::Sand), None),
            of("pads", &Control::Note { channel: 0, number: 41 }, Target::Form, Some(2)),
            of("desk", &fader, Target::Parameter(Parameter::StereoMu), None),
            of("", &Control::Controller { channel: 0, number: 1 }, Target::Harmonics, None),
            of("pads", &Control::Note { channel: 0, number: 42 }, Target::Blackout, None),
        ]);
        let mut parameters = Parameters::default();
        parameters.form = crate::Form::Modal;
        let sent = |bindings: &mut Bindings, parameters: &Parameters| {
            bindings.feedback(&|target, number| target.standing(number, parameters), &|_| true)
        };
        let first = sent(&mut bindings, &parameters);
        let pads = "pads".to_owned();
        let expected =
            [(pads.clone(), [0x90, 40, 0]), (pads.clone(), [0x90, 41, 127]), ("desk".into(), [0xe3, 0, 0])];
        assert_eq!(first, expected);
        assert!(sent(&mut bindings, &parameters).is_empty());
        parameters.switch(Switch::Sand, true);
        parameters.set(Parameter::StereoMu, 1.0).unwrap();
        let again = sent(&mut bindings, &parameters);
        assert_eq!(again, [(pads, [0x90, 40, 127]), ("desk".into(), [0xe3, 127, 127])]);
        // What a hand does, the fader shows already.
        let moved = Touch::from_midi("desk", &[0xe3, 127, 127]).unwrap();
        assert!(touch(&mut bindings, &moved, &parameters).is_some());
        let moved = Touch::from_midi("desk", &[0xe3, 0, 64]).unwrap();
        let Some(Cue::Do(Action::Set { parameter, value })) = touch(&mut bindings, &moved, &parameters)
        else {
            panic!("it does not turn");
        };
        parameters.set(parameter, value).unwrap();
        assert!(sent(&mut bindings, &parameters).is_empty());
        assert!(bindings.feedback(&|_, _| Some(0.0), &|_| false).is_empty());
        assert_eq!(sent(&mut bindings, &parameters).len(), 2);
    }

    #[test]
    fn the_same_control_of_two_devices_is_two() {
        let mut bindings = Bindings::default();
        let pad = |device: &str| Touch::from_midi(device, &[0x90, 1, 100]).unwrap();
        let release = |device: &str| Touch::from_midi(device, &[0x80, 1, 0]).unwrap();
        let parameters = Parameters::default();
        for (device, number) in [("left", 1), ("right", 2)] {
            bindings.learn(Some((Target::Choose, Some(number))));
            let cue = touch(&mut bindings, &pad(device), &parameters);
            assert_eq!(cue, Some(Cue::Ask(Target::Choose, Which::Number(number))));
            touch(&mut bindings, &release(device), &parameters);
        }
        assert_eq!(bindings.list().len(), 2);
        let cue = touch(&mut bindings, &pad("left"), &parameters);
        assert_eq!(cue, Some(Cue::Ask(Target::Choose, Which::Number(1))));
        assert_eq!(touch(&mut bindings, &pad("middle"), &parameters), None);
    }

    #[test]
    fn pads_press_once_and_switches_turn_over() {
        let control = Control::Note { channel: 0, number: 1 };
        let pad = |value| Touch { device: "any".into(), control: control.clone(), value };
        let mut bindings = Bindings::new(vec![
            binding(control.clone(), Target::Tap),
            binding(control.clone(), Target::Switch(Switch::BeatTurns)),
        ]);
        let mut parameters = Parameters::default();
        assert_eq!(bindings.list().len(), 1);
        let turn = |on| Some(Cue::Do(Action::Switch { switch: Switch::BeatTurns, on }));
        assert_eq!(touch(&mut bindings, &pad(0.1), &parameters), turn(false));
        parameters.switch(Switch::BeatTurns, false);
        assert_eq!(touch(&mut bindings, &pad(0.9), &parameters), None);
        assert_eq!(touch(&mut bindings, &pad(0.0), &parameters), None);
        assert_eq!(touch(&mut bindings, &pad(0.9), &parameters), turn(true));
        assert_eq!(touch(&mut bindings, &pad(f32::NAN), &parameters), None);
    }

    #[test]
    fn what_turns_nothing_does_not_make_a_held_pad_press_again() {
        let pad = Touch { device: "a".into(), control: Control::Note { channel: 0, number: 7 }, value: 1.0 };
        let target = Target::Switch(Switch::BeatTurns);
        let mut bindings = Bindings::new(vec![binding(pad.control.clone(), target)]);
        let parameters = Parameters::default();
        for strange in 0..2 * MOST_BINDINGS {
            let control = Control::Osc { address: format!("/{strange}") };
            let strange = Touch { device: String::new(), control, value: 1.0 };
            assert_eq!(touch(&mut bindings, &strange, &parameters), None);
        }
        assert!(touch(&mut bindings, &pad, &parameters).is_some());
        assert_eq!(touch(&mut bindings, &pad, &parameters), None);
    }

    proptest! {
        #[test]
        fn any_bytes_turn_only_what_the_instrument_takes(
            messages in prop::collection::vec(prop::collection::vec(any::<u8>(), 0..5), 0..40))
        {
            let mut parameters = Parameters::default();
            let mut bindings = Bindings::default();
            for (i, message) in messages.iter().enumerate() {
                let parameter = Parameter::ALL[i % Parameter::ALL.len()];
                bindings.learn(Some((Target::Parameter(parameter), None)));
                let Some(moved) = Touch::from_midi("", message) else { continue };
                if let Some(Cue::Do(Action::Set { parameter, value })) = touch(&mut bindings, &moved, &parameters) {
                    prop_assert!(parameters.set(parameter, value).is_ok());
                }
            }
        }
    }
}
