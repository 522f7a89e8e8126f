//! A private PulseAudio server with a null sink.

use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use crate::HANGS;

/// A PulseAudio server of a test's own, whose only device is a null sink at 48 kHz; it stops when it is dropped.
pub struct SoundServer {
    folder: tempfile::TempDir,
    process: Option<Child>,
}

impl SoundServer {
    /// Starts a server. `None`, with a printed line, if PulseAudio is not installed.
    #[allow(clippy::print_stderr, reason = "a skipped test must say so")]
    pub fn start() -> Option<Self> {
        let found = |program: &str| Command::new(program).arg("--version").output().is_ok();
        if !cfg!(target_os = "linux") || !["pulseaudio", "parec", "pactl"].iter().all(|p| found(p)) {
            eprintln!("skipped: pulseaudio, parec and pactl are not all here");
            return None;
        }
        let folder = tempfile::tempdir().ok()?;
        // ALSA's default device becomes the PulseAudio plugin.
        let alsa = "</usr/share/alsa/alsa.conf>\npcm.!default { type pulse }\nctl.!default { type pulse }\n";
        std::fs::write(folder.path().join("alsa.conf"), alsa).ok()?;
        let mut server = Self { folder, process: None };
        server.restart();
        if server.process.is_none() {
            eprintln!("skipped: pulseaudio does not start");
            return None;
        }
        Some(server)
    }

    /// A command for a program that plays and records on this server.
    pub fn command(&self, program: impl Into<PathBuf>) -> Command {
        let mut command = Command::new(program.into());
        command
            .env("ALSA_CONFIG_PATH", self.folder.path().join("alsa.conf"))
            .env("PULSE_SERVER", format!("unix:{}", self.folder.path().join("socket").display()))
            .env("PULSE_RUNTIME_PATH", self.folder.path());
        command
    }

    /// Starts the server again after [`stop`](Self::stop).
    pub fn restart(&mut self) {
        self.restart_at(48_000);
    }

    /// The same with a device of another rate.
    pub fn restart_at(&mut self, rate_hz: u32) {
        let socket = self.folder.path().join("socket");
        // A server that was killed leaves its socket behind.
        let _ = std::fs::remove_file(&socket);
        let child = self
            .command("pulseaudio")
            .env_remove("PULSE_SERVER")
            .args(["-n", "--daemonize=no", "--exit-idle-time=-1", "--use-pid-file=no"])
            .args(["-L", &format!("module-null-sink sink_name=null norewinds=1 rate={rate_hz}")])
            .args([
                "-L",
                &format!("module-native-protocol-unix auth-anonymous=1 socket={}", socket.display()),
            ])
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn();
        self.process = child.ok();
        let end = Instant::now() + HANGS;
        while !self.command("pactl").arg("info").output().is_ok_and(|output| output.status.success()) {
            let has_ended =
                self.process.as_mut().is_none_or(|process| !matches!(process.try_wait(), Ok(None)));
            if has_ended || Instant::now() > end {
                self.stop();
                return;
            }
            std::thread::sleep(Duration::from_millis(50));
        }
    }

    /// Stops the server, like a device that is unplugged.
    pub fn stop(&mut self) {
        if let Some(mut process) = self.process.take() {
            let _ = process.kill();
            let _ = process.wait();
        }
    }
}

impl Drop for SoundServer {
    fn drop(&mut self) {
        self.stop();
    }
}
