//! Control from outside: MIDI controllers, clocks and OSC, their bindings, and the beat for others.

mod beat_out;
mod clock_out;
mod clock_panel;
mod leader;
mod midi;
mod osc;
mod panel;

use std::time::Instant;

use chladni_music::{Action, Bindings, ClockMessage, Control, Cue, Parameters, Standing, Touch, osc_cue};

use self::beat_out::BeatOut;
pub use self::beat_out::Now;
use self::clock_out::ClockSender;
pub use self::clock_panel::NUDGE_SECS;
use self::leader::Leader;
use self::midi::{Devices, Midi};
use self::osc::{Osc, Senders};
use super::preferences::Preferences;
use crate::work::Error;

/// Devices, port and bindings.
#[derive(Default)]
pub struct Remote {
    /// Looks for MIDI devices, once it was started; or why nothing does.
    midi: Option<std::io::Result<Midi>>,
    /// Whose MIDI clock is followed.
    leader: Leader,
    osc: Option<Result<Osc, Error>>,
    /// The port that `osc` was opened for.
    port: Option<(u16, Senders)>,
    bindings: Bindings,
    /// The number of the choice or dance that is being learned; 0 is none.
    number: u32,
    /// The machines that are heard, as they are being typed.
    allowed: String,
    /// What was touched until now is forgotten, since nobody saw what it would have done.
    forgets: bool,
    /// The last control that was touched.
    last: Option<Control>,
    beat_out: Option<Result<BeatOut, Error>>,
    /// The address that it was opened for.
    beats_to: Option<String>,
    /// That address as it is being typed.
    beats_typed: Option<String>,
    /// Sends MIDI clock, once it was started; or the device that was chosen when that failed, and why.
    clock_out: Option<Result<ClockSender, (String, Error)>>,
}

/// Input since the last frame.
#[derive(Default)]
pub struct Asked {
    /// The cues of controls.
    pub cues: Vec<Cue>,
    /// The messages of clocks, and when they came.
    pub clock: Vec<(ClockMessage, Instant)>,
}

impl Remote {
    /// Forgets what was touched since the last frame: the room was not shown. Clocks are still heard.
    pub fn forget_touches(&mut self) {
        self.forgets = true;
    }

    /// No target waits for a control any more: its row is out of sight.
    pub fn stop_learning(&mut self) {
        self.bindings.learn(None);
    }

    /// Opens the devices that the preferences ask for and collects all touches since the last frame.
    /// `standing` says where things are, for knobs that take over softly and for feedback to devices.
    pub fn asked(
        &mut self,
        preferences: &mut Preferences,
        parameters: &Parameters,
        standing: Standing<'_>,
    ) -> Asked {
        if self.midi.is_none() {
            self.bindings = Bindings::new(preferences.bindings.clone());
            self.midi = Some(Midi::start());
        }
        let from = if preferences.osc_network {
            Senders::Network(preferences.osc_allowed.clone())
        } else {
            Senders::Here
        };
        let port = preferences.osc_port.map(|port| (port, from));
        if self.port != port {
            self.port = port;
            // The old port is closed first: it may be the same one.
            self.osc = None;
            let listen = |(port, from)| {
                Osc::listen(port, from).map_err(|why| Error::other(why).of(format_args!("port {port}")))
            };
            self.osc = self.port.clone().map(listen);
        }
        let mut cues = Vec::new();
        let said = self.midi.iter().flatten().flat_map(Midi::clock);
        let own = preferences.clock_out.as_deref();
        let said = said.filter(|said| self.leader.follows(said, own));
        let mut clock: Vec<_> = said.map(|said| (said.message, said.came)).collect();
        let forgets = std::mem::take(&mut self.forgets);
        if forgets {
            self.bindings.forget_hands();
        }
        let touched: Vec<Touch> = self.midi.iter().flatten().flat_map(Midi::touches).collect();
        for touch in touched.into_iter().filter(|_| !forgets) {
            self.touch(&touch, parameters, standing, &mut cues);
        }
        if let Some(Ok(osc)) = &self.osc {
            for (message, came) in osc.messages().collect::<Vec<_>>() {
                let said = ClockMessage::from_osc(&message.address, message.value);
                let own = osc_cue(&message.address, message.value, message.text.as_deref(), parameters);
                match (own, said) {
                    (Some(_), _) | (None, None) if forgets => {}
                    (Some(cue), _) => push(&mut cues, cue),
                    (None, Some(said)) => clock.push((said, came)),
                    (None, None) => {
                        let (address, value) = (message.address, message.value);
                        let cue = self.bindings.touch_osc(&address, value, parameters, standing);
                        self.last = Some(Control::Osc { address });
                        cue.into_iter().for_each(|cue| push(&mut cues, cue));
                    }
                }
            }
        }
        if preferences.bindings != self.bindings.list() {
            preferences.bindings = self.bindings.list().to_vec();
        }
        if let Some(Ok(midi)) = &self.midi {
            let outputs = midi.outputs();
            for (device, message) in self.bindings.feedback(standing, &|device| outputs.opens(device)) {
                outputs.send(&device, &message);
            }
        }
        Asked { cues, clock }
    }

    /// Tells others of the beat, where the preferences ask for it.
    pub fn tell(&mut self, preferences: &Preferences, now: &Now<'_>, ctx: &egui::Context) {
        if self.beats_to != preferences.beat_out {
            self.beats_to.clone_from(&preferences.beat_out);
            let open = |to: &String| BeatOut::to(to, ctx).map_err(|why| Error::other(why).of(to));
            self.beat_out = self.beats_to.as_ref().map(open);
        }
        if let Some(Ok(out)) = &mut self.beat_out {
            out.tell(now, ctx);
        }
        let chosen = preferences.clock_out.as_ref();
        if let Some(Err((device, _))) = &self.clock_out
            && chosen != Some(device)
        {
            // It is tried again for the next device that is chosen.
            self.clock_out = None;
        }
        if self.clock_out.is_none()
            && let Some(device) = chosen
            && let Some(Ok(midi)) = &self.midi
        {
            let sender = ClockSender::start(midi.outputs().clone());
            let failed = |why| (device.clone(), Error::other(why).of("MIDI clock"));
            self.clock_out = Some(sender.map_err(failed));
        }
        if let Some(Ok(out)) = &self.clock_out {
            out.tell(preferences.clock_out.as_deref(), now);
        }
    }

    /// The MIDI devices, or why there are none.
    fn midi_devices(&self) -> Devices {
        match &self.midi {
            Some(Ok(midi)) => midi.devices(),
            Some(Err(why)) => Devices { failure: Some(why.to_string()), ..Devices::default() },
            None => Devices::default(),
        }
    }

    fn touch(&mut self, touch: &Touch, parameters: &Parameters, standing: Standing<'_>, cues: &mut Vec<Cue>) {
        self.last = Some(touch.control.clone());
        if let Some(cue) = self.bindings.touch(touch, parameters, standing) {
            push(cues, cue);
        }
    }
}

/// If a knob turns several times within a frame, only the last turn counts.
fn push(cues: &mut Vec<Cue>, cue: Cue) {
    if let Cue::Do(Action::Set { parameter: turned, .. }) = cue {
        cues.retain(|known| !matches!(known, Cue::Do(Action::Set { parameter, .. }) if *parameter == turned));
    }
    cues.push(cue);
}

#[cfg(test)]
mod tests {
    use chladni_music::Beat;

    use super::*;
    use crate::studio::music::listening::Progress;

    #[test]
    fn a_clock_that_could_not_be_sent_is_tried_again_for_another_device() {
        let failed = Err(("drums".to_owned(), Error::other("no more threads")));
        let mut remote = Remote { clock_out: Some(failed), ..Remote::default() };
        let now = Now {
            at_secs: 1.0,
            beat: Beat { count: 8.0, confidence: 1.0 },
            beat_at: Instant::now(),
            tempo_bpm: 120.0,
            progress: Progress::default(),
            bands: &[],
            ahead_secs: 0.0,
        };
        let mut tell = |device: &str| {
            let preferences = Preferences { clock_out: Some(device.to_owned()), ..Preferences::default() };
            remote.tell(&preferences, &now, &egui::Context::default());
            remote.clock_out.is_some()
        };
        assert_eq!([tell("drums"), tell("synth")], [true, false]);
    }
}
