//! Bindings of MIDI and OSC controls to targets.
//!
//! Nothing here opens a device: bytes and addresses come in, [`Cue`]s and messages for the devices go out.

use serde::{Deserialize, Serialize};

use crate::cue::{Cue, Which};
use crate::target::{Kind, Target};
use crate::text_file::{self, FORMAT_VERSION};
use crate::{Control, MusicError, Parameters, Touch};

/// A control and the target it is bound to.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Binding {
    /// The name of the device; empty for any device.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub device: String,
    /// The control.
    pub control: Control,
    /// The target that it controls.
    pub target: Target,
    /// Which choice or dance it takes, from 1; `None` for the next choice, or the dance that is marked.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub number: Option<u32>,
    /// A MIDI controller that sends by how many steps a level goes up or, as 128 less the steps, down: a knob that turns
    /// endlessly.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub relative: bool,
}

impl Binding {
    fn is_of(&self, device: &str, control: &Control) -> bool {
        self.control == *control && (self.device.is_empty() || self.device == device)
    }

    /// Whether it can be [`relative`](Self::relative).
    pub fn can_be_relative(&self) -> bool {
        self.target.kind() == Kind::Level && matches!(self.control, Control::Controller { .. })
    }

    /// Whether it is of a knob that turns endlessly.
    fn is_endless(&self) -> bool {
        self.relative && self.can_be_relative()
    }
}

/// The largest number of bindings.
const MOST_BINDINGS: usize = 512;
/// A knob within this distance of its target's position takes over: two steps of a MIDI controller.
const NEAR: f32 = 2.1 / 127.0;

/// Returns the position of a target, in [0, 1]. For choices and dances: 1 if the one with that number is
/// current, otherwise 0. `None` if the position is unknown or meaningless.
pub type Standing<'a> = &'a dyn Fn(Target, Option<u32>) -> Option<f32>;

/// The state of a binding's control while the program runs.
#[derive(Clone, Debug, Default, PartialEq)]
struct Hand {
    /// Whether it is pressed: a pad that repeats its value counts as one press.
    pressed: bool,
    /// Its last position.
    at: Option<f32>,
    /// The last position to which it moved its target. While the target stays there, the control owns it.
    put: Option<f32>,
    /// Since then the device was sent another position.
    was_sent: bool,
    /// Where its target stood when it was turned last, since the last feedback: movements of a control within one frame
    /// have not reached the target yet.
    seen: Option<f32>,
    /// The message that the device shows now.
    shown: Option<[u8; 3]>,
}

/// All bindings, and the target that is waiting for a control.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Bindings {
    list: Vec<Binding>,
    /// The states, one per binding.
    hands: Vec<Hand>,
    learning: Option<(Target, Option<u32>)>,
    /// A note that was learned for a level and is still held: it may be the touch sensor of a fader that moves next.
    felt: Option<Binding>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct BindingFile {
    format_version: u32,
    #[serde(default)]
    binding: Vec<Binding>,
}

impl Bindings {
    /// Bindings as [`list`](Self::list) had them. If a control is listed twice, the last target counts; beyond 512 they are
    /// left out.
    pub fn new(list: Vec<Binding>) -> Self {
        let mut bindings = Self::default();
        for binding in list {
            bindings.bind(binding);
        }
        bindings
    }

    /// All bindings, oldest first.
    pub fn list(&self) -> &[Binding] {
        &self.list
    }

    /// The bindings as a text file.
    ///
    /// # Errors
    /// None in practice: all bindings can be written.
    pub fn to_text(&self) -> Result<String, MusicError> {
        text_file::print(
            "bindings",
            &BindingFile { format_version: FORMAT_VERSION, binding: self.list.clone() },
        )
    }

    /// Adds the bindings of a text file to those of other devices and controls. Returns how many were read.
    ///
    /// # Errors
    /// Text that does not list bindings (the error states the line), a newer format version, or more bindings than there
    /// is room for. Then nothing changes.
    pub fn import(&mut self, text: &str) -> Result<usize, MusicError> {
        text_file::version("bindings", text)?;
        let file: BindingFile = text_file::parse("bindings", text)?;
        let count = file.binding.len();
        let mut all = self.clone();
        if !file.binding.into_iter().all(|binding| all.bind(binding)) {
            let why = format!("no more than {MOST_BINDINGS} are kept: forget some first");
            return Err(MusicError::Parse { kind: "bindings", why });
        }
        *self = all;
        Ok(count)
    }

    /// Binds the next control that is touched to a target and a number. `None` stops waiting.
    pub fn learn(&mut self, target: Option<(Target, Option<u32>)>) {
        (self.learning, self.felt) = (target, None);
    }

    /// The target that waits for a control, and its number.
    pub fn learning(&self) -> Option<(Target, Option<u32>)> {
        self.learning
    }

    /// Whether there is no room for another control; one that is bound already can still be bound to another target.
    pub fn is_full(&self) -> bool {
        self.list.len() >= MOST_BINDINGS
    }

    /// Removes a binding.
    pub fn forget(&mut self, binding: usize) {
        if binding < self.list.len() {
            self.list.remove(binding);
            self.hands.remove(binding);
        }
    }

    /// Whether the binding at `at` is of a knob that turns endlessly. Nothing changes where it
    /// [cannot be](Binding::can_be_relative).
    pub fn set_relative(&mut self, at: usize, on: bool) {
        if let Some(binding) = self.list.get_mut(at).filter(|binding| binding.can_be_relative()) {
            binding.relative = on;
        }
    }

    /// Handles a touch. If a target is waiting for a control and there is room, binds this control to it; otherwise the
    /// control turns its target. A knob or fader whose position differs from its target's takes over when
    /// it passes that position. A note that is learned for a level does nothing until it is released: if a knob or fader of
    /// its device that is bound to nothing else moves before that, the note was its touch sensor, and the level is bound to
    /// what moves.
    pub fn touch(&mut self, touch: &Touch, parameters: &Parameters, standing: Standing<'_>) -> Option<Cue> {
        let value = if touch.value.is_finite() { touch.value.clamp(0.0, 1.0) } else { return None };
        let learned = self.learning.or_else(|| self.felt_for(touch)).filter(|_| value > 0.0);
        if let Some((target, number)) = learned {
            if let Some(sensor) = self.felt.take()
                && let Some(at) = self.list.iter().position(|binding| *binding == sensor)
            {
                self.forget(at);
            }
            let (device, control) = (touch.device.clone(), touch.control.clone());
            // A knob that turns endlessly does so whatever it is bound to.
            let relative = target.kind() == Kind::Level
                && self.list.iter().any(|known| known.is_endless() && known.is_of(&device, &control));
            let binding = Binding { device, control, target, number, relative };
            let may_be_sensor =
                target.kind() == Kind::Level && matches!(binding.control, Control::Note { .. });
            // Where there is no room, it goes on waiting.
            if self.bind(binding.clone()) {
                self.learning = None;
                self.felt = Some(binding).filter(|_| may_be_sensor);
            }
        }
        if self.felt.as_ref().is_some_and(|felt| felt.is_of(&touch.device, &touch.control)) {
            if value <= 0.0 {
                self.felt = None;
            }
            return None;
        }
        let at = self.list.iter().position(|binding| binding.is_of(&touch.device, &touch.control))?;
        let (binding, hand) = (self.list.get(at)?, self.hands.get_mut(at)?);
        let pressed = hand.press(&binding.control, value);
        let which = match (binding.target.kind(), binding.number) {
            (Kind::Level, _) if binding.is_endless() => {
                Which::Level(hand.step(value, standing(binding.target, None)?))
            }
            (Kind::Level, _) => {
                let now = standing(binding.target, None).filter(|_| learned.is_none());
                if !hand.turn(value, now.filter(|_| moves(&binding.control))) {
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

    /// Handles an OSC message. One without a value presses each time: it is never said to be released.
    pub fn touch_osc(
        &mut self,
        address: &str,
        value: Option<f32>,
        parameters: &Parameters,
        standing: Standing<'_>,
    ) -> Option<Cue> {
        let control = Control::Osc { address: address.to_owned() };
        let touch = Touch { device: String::new(), control, value: value.unwrap_or(1.0) };
        let cue = self.touch(&touch, parameters, standing);
        let bound = self.list.iter().position(|binding| binding.is_of(&touch.device, &touch.control));
        if let Some(hand) = bound.filter(|_| value.is_none()).and_then(|at| self.hands.get_mut(at)) {
            hand.pressed = false;
        }
        cue
    }

    /// The messages with which the devices that `listens` accepts show the positions of targets, each with
    /// the name of its device. Only changes are sent, and only for bindings to a certain device. To be called
    /// once a frame, after all touches.
    pub fn feedback(
        &mut self,
        standing: Standing<'_>,
        listens: &dyn Fn(&str) -> bool,
    ) -> Vec<(String, [u8; 3])> {
        let mut messages = Vec::new();
        for (binding, hand) in self.list.iter().zip(&mut self.hands) {
            // Its target follows after this.
            let moves = hand.seen.take().is_some();
            if binding.device.is_empty() || !listens(&binding.device) {
                // After the device is connected again, everything is sent.
                hand.shown = None;
                continue;
            }
            if moves {
                continue;
            }
            let shows =
                standing(binding.target, binding.number).and_then(|share| binding.control.message(share));
            // A fader that is being moved shows the position already; a message would fight the hand. An endless knob does
            // not know its position.
            let put = hand.put.filter(|_| !hand.was_sent && !binding.is_endless());
            let is_there = put.is_some() && put.and_then(|at| binding.control.message(at)) == shows;
            if let Some(message) = shows.filter(|message| hand.shown != Some(*message)) {
                hand.shown = Some(message);
                if !is_there {
                    hand.was_sent = true;
                    messages.push((binding.device.clone(), message));
                }
            }
        }
        messages
    }

    /// Controls were moved unseen: nothing is known of where they stand.
    pub fn forget_hands(&mut self) {
        // It may have been released.
        self.felt = None;
        self.hands.iter_mut().for_each(|hand| *hand = Hand::default());
    }

    /// The target of the note that is felt, and its number, where `touch` moves a control of the same device.
    fn felt_for(&self, touch: &Touch) -> Option<(Target, Option<u32>)> {
        let felt = self.felt.as_ref().filter(|felt| felt.device == touch.device && moves(&touch.control))?;
        // A pad may stay on, and then what moves is not its fader: it keeps what it is bound to. Only faders bend a pitch.
        let is_free = |known: &Binding| {
            known.target == felt.target
                || matches!(touch.control, Control::PitchBend { .. })
                || !known.is_of(&touch.device, &touch.control)
        };
        let may_be_its_fader = self.list.contains(felt) && self.list.iter().all(is_free);
        may_be_its_fader.then_some((felt.target, felt.number))
    }

    /// Returns whether there was room for it.
    fn bind(&mut self, binding: Binding) -> bool {
        while let Some(known) = self.list.iter().position(|known| {
            known.control == binding.control && (known.device.is_empty() || known.device == binding.device)
        }) {
            self.forget(known);
        }
        let has_room = !self.is_full();
        if has_room {
            self.list.push(binding);
            self.hands.push(Hand::default());
        }
        has_room
    }
}

impl Hand {
    /// Whether this value presses the control, that is, exceeds the threshold after being below it.
    fn press(&mut self, control: &Control, value: f32) -> bool {
        // A soft hit of a pad counts as a press; a fader must pass its middle.
        let least = if matches!(control, Control::Note { .. }) { f32::MIN_POSITIVE } else { 0.5 };
        let before = std::mem::replace(&mut self.pressed, value >= least);
        self.pressed && !before
    }

    /// Whether a knob at `value` turns its target, whose position is `now`; with `None` it takes over at
    /// once.
    fn turn(&mut self, value: f32, now: Option<f32>) -> bool {
        let before = self.at.replace(value);
        let has = now.is_none_or(|now| {
            let stays = self.put.is_some_and(|put| (put - now).abs() < NEAR || self.seen == Some(now));
            let passes = before.is_some_and(|before| (before - now) * (value - now) <= 0.0);
            stays || passes || (value - now).abs() < NEAR
        });
        self.put = has.then_some(value);
        self.was_sent &= !has;
        self.seen = now.filter(|_| has);
        has
    }

    /// Where the target of an endless knob goes that sends `value` while its target is at `now`.
    fn step(&mut self, value: f32, now: f32) -> f32 {
        let sent = (127.0 * value).round();
        let steps = if sent < 64.0 { sent } else { sent - 128.0 };
        // Steps within one frame add up.
        let from = self.put.filter(|_| self.seen == Some(now)).unwrap_or(now);
        let to = (from + steps / 127.0).clamp(0.0, 1.0);
        (self.put, self.seen, self.was_sent) = (Some(to), Some(now), false);
        to
    }
}

/// Whether a control has positions that a hand moves, unlike a pad.
fn moves(control: &Control) -> bool {
    matches!(control, Control::Controller { .. } | Control::PitchBend { .. })
}

#[cfg(test)]
mod tests;
