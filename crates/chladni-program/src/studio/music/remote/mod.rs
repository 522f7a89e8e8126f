//! Control from outside: MIDI controllers and OSC, and what they turn.

mod midi;
mod osc;
mod panel;

use chladni_music::{Action, Bindings, Control, Cue, Parameters, Touch, osc_cue};

use self::midi::Midi;
use self::osc::Osc;
use super::preferences::Preferences;

/// Devices, port and bindings.
#[derive(Default)]
pub struct Remote {
    started: bool,
    midi: Option<Midi>,
    osc: Option<Result<Osc, String>>,
    /// The port that `osc` was opened for.
    port: Option<u16>,
    bindings: Bindings,
    /// What was touched last.
    last: Option<Control>,
}

impl Remote {
    /// Opens what the preferences ask for and collects what was touched since the last frame.
    pub fn cues(&mut self, preferences: &mut Preferences, parameters: &Parameters) -> Vec<Cue> {
        if !self.started {
            self.started = true;
            self.bindings = Bindings::new(preferences.bindings.clone());
            self.midi = Midi::start().ok();
        }
        if self.port != preferences.osc_port {
            self.port = preferences.osc_port;
            // The old port is closed first: it may be the same one.
            self.osc = None;
            self.osc = self.port.map(|port| Osc::listen(port).map_err(|why| format!("port {port}: {why}")));
        }
        let mut cues = Vec::new();
        let touched: Vec<Touch> = self.midi.iter().flat_map(Midi::touches).collect();
        for touch in touched {
            self.touch(&touch, parameters, &mut cues);
        }
        if let Some(Ok(osc)) = &self.osc {
            for message in osc.messages().collect::<Vec<_>>() {
                match osc_cue(&message.address, message.value) {
                    Some(cue) => push(&mut cues, cue),
                    None => {
                        let control = Control::Osc { address: message.address };
                        self.touch(
                            &Touch { control, value: message.value.unwrap_or(1.0) },
                            parameters,
                            &mut cues,
                        );
                    }
                }
            }
        }
        if preferences.bindings != self.bindings.list() {
            preferences.bindings = self.bindings.list().to_vec();
        }
        cues
    }

    fn touch(&mut self, touch: &Touch, parameters: &Parameters, cues: &mut Vec<Cue>) {
        self.last = Some(touch.control.clone());
        if let Some(cue) = self.bindings.touch(touch, parameters) {
            push(cues, cue);
        }
    }
}

/// Of several turns of one knob within a frame only the last counts.
fn push(cues: &mut Vec<Cue>, cue: Cue) {
    if let Cue::Do(Action::Set { parameter: turned, .. }) = cue {
        cues.retain(|known| !matches!(known, Cue::Do(Action::Set { parameter, .. }) if *parameter == turned));
    }
    cues.push(cue);
}
