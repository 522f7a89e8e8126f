//! MIDI controllers and clocks, whenever they are plugged in, and the feedback to them.

use std::collections::{HashMap, HashSet, VecDeque};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, TrySendError, sync_channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use chladni_music::{ClockMessage, Touch};
use midir::{Ignore, MidiInput, MidiInputConnection, MidiOutput, MidiOutputConnection};

use crate::work::Error;

/// Touches, and messages of clocks, that may wait for the next frame.
const MOST_TOUCHES: usize = 1024;
/// Messages of a clock's port, ticks counted together, that wait for room there.
const MOST_LATE: usize = 64;
/// How often devices are looked for.
const LOOK: Duration = Duration::from_secs(1);
const CLIENT: &str = "chladni";

/// The MIDI devices.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Devices {
    /// Those that are listened to, by name.
    pub names: Vec<String>,
    /// Those that are there but cannot be listened to, or sent to, and why: another program may have them.
    pub refused: Vec<String>,
    /// Those that can be sent to.
    pub outputs: Vec<String>,
    /// Why there are none, where the system has no MIDI.
    pub failure: Option<String>,
}

/// A message from a clock.
#[derive(Clone, Debug)]
pub struct Said {
    /// The port that it came from. Two devices of one kind have ports of their own.
    pub port: Arc<str>,
    /// The name of the device.
    pub device: Arc<str>,
    pub message: ClockMessage,
    pub came: Instant,
}

/// Listens to every MIDI input that is there or comes later.
pub struct Midi {
    touches: Receiver<Touch>,
    clock: Receiver<Said>,
    devices: Arc<Mutex<Devices>>,
    outputs: Outputs,
    closed: Arc<AtomicBool>,
}

/// The ports to send to, by name. Clones share them.
#[derive(Clone, Default)]
pub struct Outputs(Arc<Mutex<Ports>>);

#[derive(Default)]
struct Ports {
    /// They are opened when they are there.
    wanted: HashSet<String>,
    /// By name, each with the node of its card.
    open: HashMap<String, (Option<u64>, MidiOutputConnection)>,
}

impl Outputs {
    /// Whether a device is open; one that is not is opened for the next time.
    pub fn opens(&self, device: &str) -> bool {
        let mut ports = lock(&self.0);
        let open = ports.open.contains_key(device);
        if !open {
            ports.wanted.insert(device.to_owned());
        }
        open
    }

    /// Sends a message to a device that is open.
    pub fn send(&self, device: &str, message: &[u8]) {
        if !self.opens(device) {
            return;
        }
        let mut ports = lock(&self.0);
        let Some((_, connection)) = ports.open.get_mut(device) else { return };
        if connection.send(message).is_err() {
            // It is gone, or is opened anew at the next look.
            let gone = ports.open.remove(device);
            drop(ports);
            // Only now, since closing may take long.
            drop(gone);
        }
    }

    /// Opens the wanted ports that exist; returns all that exist, and those that refuse, and why. Opening and closing may
    /// take long, and those who send do not wait for it.
    fn look(&self) -> Result<(Vec<String>, Vec<String>), Error> {
        let output = || MidiOutput::new(CLIENT).map_err(Error::other);
        let looking = output()?;
        let ports: Vec<_> = looking
            .ports()
            .into_iter()
            .filter_map(|port| Some((lasting(&looking.port_name(&port).ok()?), node_of(&port.id()), port)))
            .filter(|(name, ..)| !is_own(name))
            .collect();
        let mut known = lock(&self.0);
        let is_gone = |name: &String, node: Option<u64>| {
            !ports.iter().any(|(there, now, _)| there == name && *now == node)
        };
        let gone: Vec<_> = known.open.extract_if(|name, (node, _)| is_gone(name, *node)).collect();
        let mut missing = known.wanted.clone();
        missing.retain(|name| !known.open.contains_key(name));
        drop(known);
        drop(gone);
        let mut refused = Vec::new();
        for (name, node, port) in &ports {
            if !missing.contains(name) {
                continue;
            }
            match output()?.connect(port, CLIENT) {
                Ok(connection) => {
                    missing.remove(name);
                    lock(&self.0).open.insert(name.clone(), (*node, connection));
                }
                Err(why) => refused.push(format!("{name} cannot be sent to: {why}")),
            }
        }
        Ok((ports.into_iter().map(|(name, ..)| name).collect(), refused))
    }
}

/// Whether a port is one of ours, as ALSA calls them: listening to them, we would hear our own messages.
fn is_own(name: &str) -> bool {
    cfg!(target_os = "linux") && name.split_once(':').is_some_and(|(client, _)| client == CLIENT)
}

/// The name of a port without the numbers that ALSA gives anew each time.
fn lasting(name: &str) -> String {
    let is_number = |word: &str| word.chars().all(|c| c.is_ascii_digit() || c == ':') && word.contains(':');
    match name.rsplit_once(' ') {
        Some((lasting, last)) if is_number(last) => lasting.to_owned(),
        _ => name.to_owned(),
    }
}

/// The card that ALSA gives a port's client: the kernel numbers them from 16 on, four for each card.
#[cfg(any(test, target_os = "linux"))]
fn card_of(id: &str) -> Option<u32> {
    let client: u32 = id.split_once(':')?.0.parse().ok()?;
    (16..128).contains(&client).then(|| (client - 16) / 4)
}

/// The number of the card's node in the file system; none where there are no such nodes, or for programs. A device that was
/// unplugged and is back between two looks has the name and the number it had, but another node, and hears nothing of an
/// old connection.
#[cfg(target_os = "linux")]
fn node_of(id: &str) -> Option<u64> {
    use std::os::unix::fs::MetadataExt;
    let card = card_of(id)?;
    Some(std::fs::metadata(format!("/dev/snd/controlC{card}")).ok()?.ino())
}

/// Other systems give a device another number each time.
#[cfg(not(target_os = "linux"))]
fn node_of(_: &str) -> Option<u64> {
    None
}

impl Midi {
    /// Starts to look for devices. Finding none is not an error.
    pub fn start() -> std::io::Result<Self> {
        let (touch, touches) = sync_channel(MOST_TOUCHES);
        let (tick, clock) = sync_channel(MOST_TOUCHES);
        let sender = Sender { touch, tick, late: VecDeque::new() };
        let outputs = Outputs::default();
        let sent_to = outputs.clone();
        let devices = Arc::new(Mutex::new(Devices::default()));
        let closed = Arc::new(AtomicBool::new(false));
        let (seen, ended) = (Arc::clone(&devices), Arc::clone(&closed));
        std::thread::Builder::new().name("midi".into()).spawn(move || {
            let mut open = HashMap::new();
            while !ended.load(Ordering::Relaxed) {
                let there = look(&mut open, &sender).and_then(|refused| Ok((refused, sent_to.look()?)));
                let mut names: Vec<String> = open.values().map(|input| input.name.clone()).collect();
                names.sort();
                let failure = there.as_ref().err().map(ToString::to_string);
                let (mut refused, (outputs, unsent)) = there.unwrap_or_default();
                refused.extend(unsent);
                *lock(&seen) = Devices { names, refused, outputs, failure };
                std::thread::sleep(LOOK);
            }
        })?;
        Ok(Self { touches, clock, devices, outputs, closed })
    }

    /// Touches since the last call.
    pub fn touches(&self) -> impl Iterator<Item = Touch> {
        self.touches.try_iter().take(MOST_TOUCHES)
    }

    /// Messages of clocks since the last call.
    pub fn clock(&self) -> impl Iterator<Item = Said> {
        self.clock.try_iter().take(MOST_TOUCHES)
    }

    /// The ports to send to.
    pub fn outputs(&self) -> &Outputs {
        &self.outputs
    }

    /// The devices now.
    pub fn devices(&self) -> Devices {
        lock(&self.devices).clone()
    }
}

impl Drop for Midi {
    fn drop(&mut self) {
        self.closed.store(true, Ordering::Relaxed);
    }
}

/// Names and ports are never half written.
fn lock<T>(shared: &Mutex<T>) -> MutexGuard<'_, T> {
    shared.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Where the messages of a port go.
#[derive(Clone)]
struct Sender {
    touch: SyncSender<Touch>,
    tick: SyncSender<Said>,
    /// Messages of the clock that found the queue full: nothing empties it while another room is open.
    late: VecDeque<Said>,
}

impl Sender {
    fn hear(&mut self, port: &Arc<str>, device: &Arc<str>, bytes: &[u8]) {
        // A full queue drops the touch: the next one of the same knob will do.
        if let Some(message) = ClockMessage::from_midi(bytes) {
            let (port, device, came) = (Arc::clone(port), Arc::clone(device), Instant::now());
            self.say(Said { port, device, message, came });
        } else if let Some(touch) = Touch::from_midi(device, bytes) {
            let _ = self.touch.try_send(touch);
        }
    }

    /// Sends a message of the clock after those that wait, or lets it wait: without its ticks the clock would be out of
    /// phase.
    fn say(&mut self, said: Said) {
        while let Some(first) = self.late.front() {
            if self.tick.try_send(first.clone()).is_err() {
                return self.wait(said);
            }
            self.late.pop_front();
        }
        if let Err(TrySendError::Full(said)) = self.tick.try_send(said) {
            self.wait(said);
        }
    }

    fn wait(&mut self, said: Said) {
        match (said.message, self.late.back_mut()) {
            (ClockMessage::Tick, Some(Said { message: ClockMessage::Lost { ticks }, came, .. })) => {
                (*ticks, *came) = (ticks.saturating_add(1), said.came);
            }
            (ClockMessage::Tick, _) => {
                self.late.push_back(Said { message: ClockMessage::Lost { ticks: 1 }, ..said });
            }
            (message, _) => {
                // A start makes all before it meaningless.
                if message == ClockMessage::Start {
                    self.late.clear();
                }
                if self.late.len() < MOST_LATE {
                    self.late.push_back(said);
                }
            }
        }
    }
}

/// By the port's number.
type Open = HashMap<String, Input>;

struct Input {
    name: String,
    /// That of its card.
    node: Option<u64>,
    /// Listens until it is dropped.
    _connection: MidiInputConnection<()>,
}

/// Connects new ports and drops missing ones; returns those that refuse, and why.
fn look(open: &mut Open, sender: &Sender) -> Result<Vec<String>, Error> {
    // Where the kernel has no sequencer, ALSA would print a complaint at every look.
    if cfg!(target_os = "linux") && !std::path::Path::new("/dev/snd/seq").exists() {
        open.clear();
        return Err(Error::other("this system has no MIDI"));
    }
    let input = || {
        let mut input = MidiInput::new(CLIENT).map_err(Error::other)?;
        input.ignore(Ignore::SysexAndActiveSense);
        Ok::<_, Error>(input)
    };
    let looking = input()?;
    let ports = looking.ports();
    open.retain(|id, input| ports.iter().any(|port| port.id() == *id) && node_of(id) == input.node);
    let mut refused = Vec::new();
    for port in ports {
        let id = port.id();
        // A device that disappears meanwhile is handled the next time.
        let Ok(name) = looking.port_name(&port) else { continue };
        if open.contains_key(&id) || is_own(&name) {
            continue;
        }
        let mut sender = sender.clone();
        let (from, device) = (Arc::from(id.as_str()), Arc::from(lasting(&name)));
        let listen = move |_: u64, bytes: &[u8], (): &mut ()| sender.hear(&from, &device, bytes);
        let node = node_of(&id);
        match input()?.connect(&port, CLIENT, listen, ()) {
            Ok(connection) => {
                open.insert(id, Input { name, node, _connection: connection });
            }
            Err(why) => refused.push(format!("{name} cannot be opened: {why}")),
        }
    }
    Ok(refused)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_device_keeps_its_name() {
        let names = ["nanoKONTROL2:nanoKONTROL2 MIDI 1 24:0", "Launchpad Mini 3", "Port 1:2 A"].map(lasting);
        assert_eq!(names, ["nanoKONTROL2:nanoKONTROL2 MIDI 1", "Launchpad Mini 3", "Port 1:2 A"]);
    }

    #[test]
    fn ports_of_cards_are_known() {
        assert_eq!(
            ["16:0", "24:0", "27:1", "128:0", "14:0", "a"].map(card_of),
            [Some(0), Some(2), Some(2), None, None, None]
        );
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn own_ports_are_known() {
        assert!(is_own("chladni:chladni 130:0") && is_own("chladni:chladni"));
        assert!(!is_own("chladni desk:out 24:0") && !is_own("Launchpad Mini 3"));
    }

    #[test]
    fn clock_and_touches_have_queues_of_their_own_that_never_block() {
        let ((touch, touches), (tick, clock)) = (sync_channel(4), sync_channel(4));
        let mut sender = Sender { touch, tick, late: VecDeque::new() };
        let (port, device) = (Arc::from("24:0"), Arc::from("a"));
        for _ in 0..100 {
            for bytes in [&[0xf8][..], &[0xb0, 7, 9], &[0xf0, 1, 2]] {
                sender.hear(&port, &device, bytes);
            }
        }
        assert_eq!((touches.try_iter().count(), clock.try_iter().count()), (4, 4));
    }

    #[test]
    fn ticks_that_find_the_queue_full_are_counted() {
        use ClockMessage::{Continue, Lost, Start, Stop, Tick};
        let ((touch, _touches), (tick, clock)) = (sync_channel(1), sync_channel(4));
        let mut sender = Sender { touch, tick, late: VecDeque::new() };
        let (port, device) = (Arc::from("24:0"), Arc::from("a"));
        let mut hear = |byte: u8| sender.hear(&port, &device, &[byte]);
        let heard = || clock.try_iter().map(|said| said.message).collect::<Vec<_>>();
        (0..10).for_each(|_| hear(0xf8));
        assert_eq!(heard(), [Tick; 4]);
        hear(0xf8);
        assert_eq!(heard(), [Lost { ticks: 6 }, Tick]);
        // What was lost before a start does not matter; what comes after keeps its order.
        (0..7).for_each(|_| hear(0xf8));
        [0xfa, 0xf8, 0xf8, 0xfc, 0xf8, 0xfb].into_iter().for_each(&mut hear);
        assert_eq!(heard(), [Tick; 4]);
        hear(0xf8);
        assert_eq!(heard(), [Start, Lost { ticks: 2 }, Stop, Lost { ticks: 1 }]);
        hear(0xf8);
        assert_eq!(heard(), [Continue, Lost { ticks: 1 }, Tick]);
    }
}
