//! Control from outside: MIDI controllers, clocks and OSC, their bindings, and the beat for others.

mod beat_out;
mod clock_out;
mod clock_panel;
mod leader;
mod midi;
mod osc;
mod panel;

use std::time::{Duration, Instant};

use chladni_music::{
    Action, Bindings, ClockMessage, Control, Cue, OscMessage, Parameters, Standing, Touch, osc_cue, preceding,
};

use self::beat_out::BeatOut;
pub use self::beat_out::Now;
use self::clock_out::ClockSender;
pub use self::clock_panel::NUDGE_SECS;
use self::leader::Leader;
use self::midi::{Devices, Midi};
use self::osc::{Osc, Senders};
use super::preferences::Preferences;
use crate::studio::notices::Notices;
use crate::work::Error;

/// The matter of notices about the port of OSC.
const OSC: &str = "OSC";
/// A port that another program has is tried again after this time.
const LISTEN_AGAIN: Duration = Duration::from_secs(5);

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
    /// When that was tried last.
    tried: Option<Instant>,
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
        notices: &mut Notices,
    ) -> Asked {
        if self.midi.is_none() {
            self.bindings = Bindings::new(preferences.bindings.clone());
            self.midi = Some(Midi::start());
        }
        self.listen(preferences, notices);
        // As they will be once the cues so far are done.
        let mut parameters = parameters.clone();
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
            self.touch(&touch, &mut parameters, standing, &mut cues);
        }
        clock.extend(self.osc.iter().flatten().flat_map(Osc::clock));
        let touched: Vec<OscMessage> = self.osc.iter().flatten().flat_map(Osc::touches).collect();
        for message in touched.into_iter().filter(|_| !forgets) {
            self.touch_osc(message, &mut parameters, standing, &mut cues);
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

    /// Listens on the port that the preferences ask for.
    fn listen(&mut self, preferences: &Preferences, notices: &mut Notices) {
        let from = if preferences.osc_network {
            Senders::Network(preferences.osc_allowed.clone())
        } else {
            Senders::Here
        };
        let port = preferences.osc_port.map(|port| (port, from));
        let is_new = self.port != port;
        let has_failed = matches!(self.osc, Some(Err(_)));
        let is_due = self.tried.is_none_or(|tried| tried.elapsed() > LISTEN_AGAIN);
        if !(is_new || (has_failed && is_due)) {
            return;
        }
        (self.port, self.tried) = (port, Some(Instant::now()));
        // The old port is closed first: it may be the same one.
        self.osc = None;
        let listen = |(port, from)| {
            Osc::listen(port, from).map_err(|why| Error::other(why).of(format_args!("port {port}")))
        };
        self.osc = self.port.clone().map(listen);
        match &self.osc {
            Some(Err(why)) if is_new => notices.update(OSC, format!("No OSC is heard: {why}")),
            Some(Err(_)) => {}
            Some(Ok(_)) | None => notices.withdraw(OSC),
        }
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

    fn touch(
        &mut self,
        touch: &Touch,
        parameters: &mut Parameters,
        standing: Standing<'_>,
        cues: &mut Vec<Cue>,
    ) {
        self.last = Some(touch.control.clone());
        if let Some(cue) = self.bindings.touch(touch, parameters, standing) {
            push(cues, parameters, cue);
        }
    }

    fn touch_osc(
        &mut self,
        message: OscMessage,
        parameters: &mut Parameters,
        standing: Standing<'_>,
        cues: &mut Vec<Cue>,
    ) {
        let OscMessage { address, value, text } = message;
        let cue = match osc_cue(&address, value, text.as_deref(), parameters) {
            Some(cue) => Some(cue),
            // A button of a clock is let go.
            None if ClockMessage::from_osc(&address, Some(1.0)).is_some() => None,
            None => {
                let cue = self.bindings.touch_osc(&address, value, parameters, standing);
                self.last = Some(Control::Osc { address });
                cue
            }
        };
        cue.into_iter().for_each(|cue| push(cues, parameters, cue));
    }
}

/// If a knob turns several times within a frame, only the last turn counts. In `parameters`, switches and choices are left
/// as they will be once the cue is done: the next press goes on from there.
fn push(cues: &mut Vec<Cue>, parameters: &mut Parameters, cue: Cue) {
    if let Cue::Do(action) = &cue
        && let Some(Action::Switch { switch, on }) = preceding(action, parameters)
    {
        parameters.switch(switch, on);
    }
    match cue {
        Cue::Do(Action::Set { parameter: turned, .. }) => cues
            .retain(|known| !matches!(known, Cue::Do(Action::Set { parameter, .. }) if *parameter == turned)),
        Cue::Do(Action::Switch { switch, on }) => parameters.switch(switch, on),
        Cue::Do(Action::SetForm { form }) => parameters.form = form,
        Cue::Do(Action::SetChoir { choir }) => parameters.choir = choir,
        _ => {}
    }
    cues.push(cue);
}

#[cfg(test)]
mod tests {
    use std::net::{Ipv4Addr, UdpSocket};

    use chladni_music::{Beat, Form, Switch};

    use super::*;
    use crate::studio::music::listening::Progress;

    #[test]
    fn a_port_that_another_program_has_is_tried_again() {
        let other = UdpSocket::bind((Ipv4Addr::LOCALHOST, 0)).unwrap();
        let osc_port = Some(other.local_addr().unwrap().port());
        let preferences = Preferences { osc_port, ..Preferences::default() };
        let (mut remote, mut notices) = (Remote::default(), Notices::default());
        remote.listen(&preferences, &mut notices);
        assert!(matches!(remote.osc, Some(Err(_))));
        drop(other);
        // However long a busy machine takes from here on.
        remote.tried = Some(Instant::now() + Duration::from_secs(3600));
        remote.listen(&preferences, &mut notices);
        assert!(matches!(remote.osc, Some(Err(_))));
        remote.tried = None;
        remote.listen(&preferences, &mut notices);
        assert!(matches!(remote.osc, Some(Ok(_))));
    }

    #[test]
    fn nothing_is_heard_until_the_user_wants_it() {
        let (mut remote, mut notices) = (Remote::default(), Notices::default());
        remote.listen(&Preferences::default(), &mut notices);
        assert!(remote.osc.is_none());
        // Then it is heard from this machine alone.
        let preferences = Preferences { osc_port: Some(0), ..Preferences::default() };
        remote.listen(&preferences, &mut notices);
        assert!(remote.osc.is_some() && remote.port == Some((0, Senders::Here)));
    }

    #[test]
    fn presses_of_one_frame_count_one_after_the_other() {
        let (mut cues, mut parameters) = (Vec::new(), Parameters::default());
        for address in ["/chladni/form", "/chladni/own-mu"].repeat(2) {
            let cue = osc_cue(address, None, None, &parameters).unwrap();
            push(&mut cues, &mut parameters, cue);
        }
        // From the half-mask form and a µ of each dance.
        let own_mu = |on| Cue::Do(Action::Switch { switch: Switch::OwnMu, on });
        let form = |form| Cue::Do(Action::SetForm { form });
        assert_eq!(cues, [form(Form::Filter), own_mu(false), form(Form::Modal), own_mu(true)]);
    }

    #[test]
    fn a_press_goes_on_from_a_switch_that_a_knob_turned() {
        let (mut cues, mut parameters) = (Vec::new(), Parameters::default());
        // At first each dance has a µ of its own, until the common one is turned.
        for (address, value) in [("/chladni/stereo-mu", Some(0.5)), ("/chladni/own-mu", None)] {
            let cue = osc_cue(address, value, None, &parameters).unwrap();
            push(&mut cues, &mut parameters, cue);
        }
        assert_eq!(cues.last(), Some(&Cue::Do(Action::Switch { switch: Switch::OwnMu, on: true })));
    }

    #[test]
    fn a_button_of_a_clock_that_is_let_go_is_no_control() {
        let (mut remote, mut parameters, mut cues) = (Remote::default(), Parameters::default(), Vec::new());
        for (address, value) in [("/1/fader1", 0.5), ("/stop", 0.0), ("/chladni/beat", 0.0)] {
            let message = OscMessage { address: address.into(), value: Some(value), text: None };
            remote.touch_osc(message, &mut parameters, &|_, _| None, &mut cues);
        }
        assert_eq!(remote.last, Some(Control::Osc { address: "/1/fader1".into() }));
        assert!(cues.is_empty());
    }

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
