//! Captures a PulseAudio or PipeWire monitor with the server's own recorder.

use std::io::Read;
use std::process::{Child, Command, Stdio};
use std::sync::atomic::Ordering;

use super::Inlet;
use crate::SoundError;

/// The rate to which the server converts.
pub(super) const RATE_HZ: u32 = 48_000;
const BYTES_PER_FRAME: usize = 8;

/// Names of the monitors that the sound server offers; empty without a server.
pub(super) fn names() -> Vec<String> {
    let listed = Command::new("pactl").args(["list", "short", "sources"]).stderr(Stdio::null()).output();
    let Ok(listed) = listed else { return Vec::new() };
    String::from_utf8_lossy(&listed.stdout)
        .lines()
        .filter_map(|line| line.split('\t').nth(1))
        .filter(|name| name.ends_with(".monitor"))
        .map(str::to_owned)
        .collect()
}

/// A running `parec` process and the thread that reads its output.
pub(super) struct Recorder {
    child: Child,
}

impl Recorder {
    pub fn start(name: &str, inlet: Inlet) -> Result<Self, SoundError> {
        let failed = |what: String| SoundError::Device { what: format!("{name}: {what}") };
        let mut child = Command::new("parec")
            .arg(format!("--device={name}"))
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
