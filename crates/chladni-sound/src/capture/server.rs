//! Captures the output of a PulseAudio or PipeWire server, all of it or one program's, with its own recorder.

use std::ffi::OsString;
use std::io::Read;
use std::process::{Child, Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::time::Duration;

use chladni_task::{Needs, other_program};
use serde::Deserialize;

use super::Inlet;
use crate::SoundError;

/// The rate to which the server converts.
pub(super) const RATE_HZ: u32 = 48_000;
const BYTES_PER_FRAME: usize = 8;
/// The pause between two looks for a monitor that is recorded.
const LOOK: Duration = Duration::from_secs(1);

/// The sources that the sound server offers, as `pactl` lists them; `None` where no server answers.
fn sources() -> Option<String> {
    let mut pactl = other_program("pactl", Needs::Desktop);
    let listed = pactl.args(["list", "short", "sources"]).stderr(Stdio::null()).output().ok()?;
    listed.status.success().then(|| String::from_utf8_lossy(&listed.stdout).into_owned())
}

/// Number and name of each listed source.
fn numbered(listed: &str) -> impl Iterator<Item = (&str, &str)> {
    listed.lines().filter_map(|line| {
        let mut columns = line.split('\t');
        Some((columns.next()?, columns.next()?))
    })
}

/// Names of the monitors that the sound server offers; empty without a server.
pub(super) fn monitors() -> Vec<String> {
    let listed = sources().unwrap_or_default();
    let names = numbered(&listed).map(|(_, name)| name).filter(|name| name.ends_with(".monitor"));
    names.map(str::to_owned).collect()
}

/// An output of a sound server that can be recorded.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Played {
    /// A sink's monitor, by name.
    Monitor(String),
    /// The output of the program of this name.
    Program(String),
}

impl Played {
    /// The argument that makes `parec` record it.
    fn argument(&self) -> Option<String> {
        match self {
            Self::Monitor(name) => Some(format!("--device={name}")),
            Self::Program(name) => {
                let found = inputs().into_iter().find(|input| input.program() == Some(name));
                found.map(|input| format!("--monitor-stream={}", input.index))
            }
        }
    }
}

/// One stream of sound that a program plays, as `pactl` lists it.
#[derive(Deserialize)]
struct SinkInput {
    index: u32,
    /// Whether it is paused.
    #[serde(default)]
    corked: bool,
    properties: Properties,
}

#[derive(Deserialize)]
struct Properties {
    #[serde(rename = "application.name")]
    name: Option<String>,
    #[serde(rename = "application.process.id")]
    process: Option<String>,
}

impl SinkInput {
    /// The program's name, unless it is this program itself.
    fn program(&self) -> Option<&str> {
        let own = std::process::id().to_string();
        self.properties.name.as_deref().filter(|_| self.properties.process.as_deref() != Some(&own))
    }
}

/// Streams that sound first; empty without a server, or with one that is older than its list in JSON.
fn inputs() -> Vec<SinkInput> {
    let mut pactl = other_program("pactl", Needs::Desktop);
    write_points(&mut pactl, std::env::var_os("LC_ALL"));
    let listed = pactl.args(["-f", "json", "list", "sink-inputs"]).stderr(Stdio::null()).output();
    let mut inputs: Vec<SinkInput> =
        listed.ok().and_then(|listed| serde_json::from_slice(&listed.stdout).ok()).unwrap_or_default();
    inputs.sort_by_key(|input| input.corked);
    inputs
}

/// Lets a program write numbers with a decimal point, as `pactl` needs for its JSON to be valid, whatever language `LC_ALL`,
/// here `all`, asks for. Its letters stay those of that language.
fn write_points(program: &mut Command, all: Option<OsString>) {
    if let Some(all) = all.filter(|all| !all.is_empty()) {
        program.env_remove("LC_ALL").env("LC_CTYPE", all);
    }
    program.env("LC_NUMERIC", "C");
}

/// Names of the programs that play something, each once.
pub(super) fn programs() -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for input in inputs() {
        if let Some(name) = input.program().filter(|name| names.iter().all(|known| known != name)) {
            names.push(name.to_owned());
        }
    }
    names
}

/// A running `parec` process and the thread that reads its output.
pub(super) struct Recorder {
    child: Child,
    /// Dropped, it ends the watch over a monitor.
    _watch: Sender<()>,
}

impl Recorder {
    pub fn start(name: &str, played: &Played, inlet: Inlet) -> Result<Self, SoundError> {
        let failed = |what: String| SoundError::Device { what: format!("{name}: {what}") };
        let argument = played.argument().ok_or_else(|| failed("plays nothing now".into()))?;
        let mut child = other_program("parec", Needs::Desktop)
            .arg(argument)
            .args(["--raw", "--format=float32le", "--rate=48000", "--channels=2", "--latency-msec=15"])
            .arg("--client-name=chladni")
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .map_err(|error| failed(format!("parec does not start: {error}")))?;
        let (sound, (watch, ended)) = (child.stdout.take(), channel());
        // Dropped on an error, it ends the process.
        let recorder = Self { child, _watch: watch };
        let Some(sound) = sound else { return Err(failed("parec has no output".into())) };
        let lost = Arc::clone(&inlet.lost);
        let thread = || std::thread::Builder::new().name("capture".into());
        let no_thread = |error: std::io::Error| failed(format!("no thread for it: {error}"));
        thread().spawn(move || read(sound, inlet)).map_err(no_thread)?;
        if let Played::Monitor(monitor) = played.clone() {
            thread().spawn(move || watch_over(&monitor, &lost, &ended)).map_err(no_thread)?;
        }
        Ok(recorder)
    }
}

impl Drop for Recorder {
    fn drop(&mut self) {
        // The reading thread ends when the pipe does.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Takes a monitor for lost as soon as its sink is gone: the server would let `parec` go on with another source, which may
/// be a microphone.
fn watch_over(monitor: &str, lost: &AtomicBool, ended: &Receiver<()>) {
    let mut number = None;
    loop {
        // Without a server `parec` ends by itself.
        if sources().is_some_and(|listed| !is_still_there(&listed, monitor, &mut number)) {
            return lost.store(true, Ordering::Release);
        }
        if ended.recv_timeout(LOOK) != Err(RecvTimeoutError::Timeout) || lost.load(Ordering::Acquire) {
            return;
        }
    }
}

/// Whether a source is among those that are listed, by the number that it had at first: one that comes back under its name
/// has another.
fn is_still_there(listed: &str, source: &str, first: &mut Option<String>) -> bool {
    let found = numbered(listed).find(|(_, name)| *name == source);
    found.is_some_and(|(number, _)| *first.get_or_insert_with(|| number.to_owned()) == *number)
}

fn read(mut sound: impl Read, mut inlet: Inlet) {
    let mut buffer = [0u8; 512 * BYTES_PER_FRAME];
    let mut held = 0;
    // The sound that follows where the source was lost is another one's.
    while !inlet.lost.load(Ordering::Acquire) {
        match sound.read(&mut buffer[held..]) {
            Ok(0) | Err(_) => break,
            Ok(got) => held += got,
        }
        let whole = held - held % BYTES_PER_FRAME;
        for frame in buffer[..whole].chunks_exact(BYTES_PER_FRAME) {
            let at = |i: usize| f32::from_le_bytes([frame[i], frame[i + 1], frame[i + 2], frame[i + 3]]);
            inlet.push([at(0), at(4)]);
        }
        buffer.copy_within(whole..held, 0);
        held -= whole;
    }
    inlet.lost.store(true, Ordering::Release);
}

#[cfg(test)]
mod tests {
    use std::ffi::OsStr;

    use super::*;

    #[test]
    fn a_source_that_is_gone_is_missed_also_where_another_has_its_name() {
        let listed = |number: u32| format!("0\tnull.monitor\tmodule\n{number}\tother.monitor\tmodule\n");
        let mut first = None;
        let mut is_there = |listed: &str| is_still_there(listed, "other.monitor", &mut first);
        assert!(is_there(&listed(1)) && is_there(&listed(1)));
        assert!(!is_there("0\tnull.monitor\tmodule\n") && !is_there(&listed(2)));
    }

    #[test]
    fn a_source_that_was_lost_is_read_no_further() {
        let (inlet, consumer) = crate::capture::inlet();
        inlet.lost.store(true, Ordering::Release);
        read([0u8; 16 * BYTES_PER_FRAME].as_slice(), inlet);
        assert_eq!(consumer.slots(), 0);
    }

    #[test]
    fn a_list_has_decimal_points_in_every_language() {
        let given = |all: &str| {
            let mut program = other_program("pactl", Needs::Desktop);
            program.env("LC_ALL", all).env("LC_CTYPE", "before");
            write_points(&mut program, Some(all.into()));
            let value = |name: &str| {
                let found = program.get_envs().find(|(known, _)| *known == OsStr::new(name));
                found.and_then(|(_, value)| value).map(|value| value.to_string_lossy().into_owned())
            };
            ["LC_ALL", "LC_CTYPE", "LC_NUMERIC"].map(|name| value(name).unwrap_or_default())
        };
        assert_eq!(given("de_DE.UTF-8"), ["", "de_DE.UTF-8", "C"]);
        assert_eq!(given(""), ["", "before", "C"]);
    }
}
