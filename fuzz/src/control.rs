//! What controllers and clocks send while the music plays.

use chladni_music::{
    Action, Bindings, ClockMessage, Cue, OscMessage, Parameters, Target, Tempo, Touch, Which, osc_cue,
};

use crate::{MIB, within};

/// The most memory that each byte of a packet takes: an argument of OSC is a byte there.
const EACH: usize = 256;

/// MIDI messages and OSC packets, as they turn knobs and set the clock; each begins with its length.
pub fn messages(bytes: &[u8]) {
    within(bytes.len(), EACH, MIB, || Desk::new().hear(bytes));
}

/// All that listens.
struct Desk {
    bindings: Bindings,
    parameters: Parameters,
    tempo: Tempo,
    /// What is learned next, over and over.
    targets: std::iter::Cycle<std::vec::IntoIter<Target>>,
}

impl Desk {
    fn new() -> Self {
        let targets = Target::all().collect::<Vec<_>>().into_iter().cycle();
        Self {
            bindings: Bindings::default(),
            parameters: Parameters::default(),
            tempo: Tempo::default(),
            targets,
        }
    }

    fn hear(&mut self, mut bytes: &[u8]) {
        let mut secs = 0.0;
        while let Some((&length, rest)) = bytes.split_first() {
            let (message, rest) = rest.split_at(usize::from(length).min(rest.len()));
            bytes = rest;
            secs += f64::from(length) / 100.0;
            for message in OscMessage::in_packet(message).unwrap_or_default() {
                match ClockMessage::from_osc(&message.address, message.value) {
                    Some(clock) => self.tempo.hear(clock, secs),
                    None => self.osc(&message),
                }
            }
            ClockMessage::from_midi(message).into_iter().for_each(|clock| self.tempo.hear(clock, secs));
            let beat = self.tempo.at(secs);
            assert!(self.tempo.bpm().is_none_or(|bpm| bpm.is_finite() && bpm > 0.0), "{beat:?}");
            self.midi(message);
        }
        self.feedback();
    }

    /// An address of our own is a cue; any other is bound as a knob is.
    fn osc(&mut self, OscMessage { address, value, text }: &OscMessage) {
        let cue = osc_cue(address, *value, text.as_deref(), &self.parameters).or_else(|| {
            let now = self.parameters.clone();
            self.bindings.learn(self.targets.next().map(|target| (target, None)));
            self.bindings.touch_osc(address, *value, &now, &|target, number| target.standing(number, &now))
        });
        self.obey(cue);
    }

    fn midi(&mut self, message: &[u8]) {
        let Some(touch) = Touch::from_midi("desk", message) else { return };
        self.bindings.learn(self.targets.next().map(|target| (target, None)));
        let now = self.parameters.clone();
        let cue = self.bindings.touch(&touch, &now, &|target, number| target.standing(number, &now));
        self.obey(cue);
    }

    fn obey(&mut self, cue: Option<Cue>) {
        match cue {
            Some(Cue::Do(Action::Set { parameter, value })) => {
                self.parameters.set(parameter, value).expect("a knob gives what its parameter takes");
            }
            Some(Cue::Do(Action::Switch { switch, on })) => self.parameters.switch(switch, on),
            Some(Cue::Ask(_, Which::Level(level))) => assert!((0.0..=1.0).contains(&level)),
            _ => {}
        }
    }

    /// The device is shown where all stands, once.
    fn feedback(&mut self) {
        let now = self.parameters.clone();
        let mut sent = || {
            let standing = |target: Target, number| target.standing(number, &now);
            self.bindings.feedback(&standing, &|device| device == "desk")
        };
        // A control that a hand has just moved is shown the next time.
        let messages = [sent(), sent()].concat();
        assert!(
            messages.iter().all(|(_, [status, rest @ ..])| *status >= 0x80 && rest.iter().all(|x| *x < 0x80))
        );
        assert!(sent().is_empty());
    }
}
