//! Captures the output of a PulseAudio or PipeWire server, all of it or one program's, with its own recorder.

use std::ffi::OsString;
use std::io::Read;
use std::process::{Child, Command, Stdio};
use std::sync::atomic::Ordering;

use chladni_task::{Needs, other_program};
use serde::Deserialize;

use super::Inlet;
use crate::SoundError;

/// The rate to which the server converts.
pub(super) const RATE_HZ: u32 = 48_000;
const BYTES_PER_FRAME: usize = 8;

/// Names of the monitors that the sound server offers; empty without a server.
pub(super) fn monitors() -> Vec<String> {
    let listed = other_program("pactl", Needs::Desktop)
        .args(["list", "short", "sources"])
        .stderr(Stdio::null())
        .output();
    let Ok(listed) = listed else { return Vec::new() };
    String::from_utf8_lossy(&listed.stdout)
        .lines()
        .filter_map(|line| line.split('\t').nth(1))
        .filter(|name| name.ends_with(".monitor"))
        .map(str::to_owned)
        .collect()
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
        let Some(sound) = child.stdout.take() else { return Err(failed("parec has no output".into())) };
        let reading = std::thread::Builder::new().name("capture".into()).spawn(move || read(sound, inlet));
        match reading {
            Ok(_) => Ok(Self { child }),
            Err(error) => {
                let _ = child.kill();
                let _ = child.wait();
                Err(failed(format!("no thread for it: {error}")))
            }
        }
    }
}

impl Drop for Recorder {
    fn drop(&mut self) {
        // The reading thread ends when the pipe does.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn read(mut sound: impl Read, mut inlet: Inlet) {
    let mut buffer = [0u8; 512 * BYTES_PER_FRAME];
    let mut held = 0;
    loop {
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
