//! MIDI controllers, whenever they are plugged in.

use std::collections::HashMap;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use chladni_music::Touch;
use midir::{Ignore, MidiInput, MidiInputConnection};

/// Touches that may wait for the next frame.
const MOST_TOUCHES: usize = 1024;
/// How often devices are looked for.
const LOOK: Duration = Duration::from_secs(1);
const CLIENT: &str = "chladni";

/// What is known of the devices.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Devices {
    /// Those that are listened to, by name.
    pub names: Vec<String>,
    /// Why there are none, where the system has no MIDI.
    pub failure: Option<String>,
}

/// Listens to every MIDI input that is there or comes later.
pub struct Midi {
    touches: Receiver<Touch>,
    devices: Arc<Mutex<Devices>>,
    closed: Arc<AtomicBool>,
}

impl Midi {
    /// Starts to look for devices. Finding none is not an error.
    pub fn start() -> std::io::Result<Self> {
        let (sender, touches) = sync_channel(MOST_TOUCHES);
        let devices = Arc::new(Mutex::new(Devices::default()));
        let closed = Arc::new(AtomicBool::new(false));
        let (told, ended) = (Arc::clone(&devices), Arc::clone(&closed));
        std::thread::Builder::new().name("midi".into()).spawn(move || {
            let mut open = HashMap::new();
            while !ended.load(Ordering::Relaxed) {
                let failure = look(&mut open, &sender).err();
                let mut names: Vec<String> = open.values().map(|(name, _)| String::clone(name)).collect();
                names.sort();
                *lock(&told) = Devices { names, failure };
                std::thread::sleep(LOOK);
            }
        })?;
        Ok(Self { touches, devices, closed })
    }

    /// What was touched since the last call.
    pub fn touches(&self) -> impl Iterator<Item = Touch> {
        self.touches.try_iter().take(MOST_TOUCHES)
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

/// A list of names is never half written.
fn lock(devices: &Mutex<Devices>) -> MutexGuard<'_, Devices> {
    devices.lock().unwrap_or_else(PoisonError::into_inner)
}

type Open = HashMap<String, (String, MidiInputConnection<()>)>;

/// Connects what is new and lets go of what is gone.
fn look(open: &mut Open, sender: &SyncSender<Touch>) -> Result<(), String> {
    // Where the kernel has no sequencer, ALSA would print a complaint at every look.
    if cfg!(target_os = "linux") && !std::path::Path::new("/dev/snd/seq").exists() {
        open.clear();
        return Err("this system has no MIDI".into());
    }
    let input = || {
        let mut input = MidiInput::new(CLIENT).map_err(|why| why.to_string())?;
        input.ignore(Ignore::All);
        Ok::<_, String>(input)
    };
    let looking = input()?;
    let ports = looking.ports();
    open.retain(|id, _| ports.iter().any(|port| port.id() == *id));
    for port in ports {
        let id = port.id();
        // A device that disappears meanwhile is handled the next time.
        let Ok(name) = looking.port_name(&port) else { continue };
        if open.contains_key(&id) {
            continue;
        }
        let sender = sender.clone();
        let listen = move |_: u64, bytes: &[u8], (): &mut ()| {
            if let Some(touch) = Touch::from_midi(bytes) {
                // A full queue drops the touch: the next one of the same knob will do.
                let _ = sender.try_send(touch);
            }
        };
        if let Ok(connection) = input()?.connect(&port, CLIENT, listen, ()) {
            open.insert(id, (name, connection));
        }
    }
    Ok(())
}
