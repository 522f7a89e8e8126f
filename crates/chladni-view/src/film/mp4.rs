//! MP4 through an ffmpeg child process.

use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::thread::JoinHandle;

use super::{Encode, FilmSettings, beside, persist};
use crate::cpu::halved_chroma;
use crate::{Picture, ViewError};

/// Whether ffmpeg is on the PATH.
pub fn ffmpeg_is_there() -> bool {
    Command::new("ffmpeg")
        .arg("-version")
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .status()
        .is_ok_and(|status| status.success())
}

/// Frames go into ffmpeg's standard input; it writes to a temporary file.
pub(super) struct Mp4 {
    path: PathBuf,
    file: Option<tempfile::NamedTempFile>,
    child: Child,
    input: Option<ChildStdin>,
    complaints: Option<JoinHandle<String>>,
    opaque: Vec<u8>,
    planes: Vec<u8>,
}

impl Mp4 {
    pub(super) fn create(path: &Path, settings: &FilmSettings) -> Result<Self, ViewError> {
        if settings.width < 2 || settings.height < 2 {
            return Err(ViewError::Film("an MP4 needs at least 2×2 pixels".into()));
        }
        let file = beside(path)?;
        let mut command = Command::new("ffmpeg");
        // H.264 with halved chroma needs even sides; BT.709 is what players take it for.
        let bt709 = [
            "-colorspace",
            "bt709",
            "-color_primaries",
            "bt709",
            "-color_trc",
            "bt709",
            "-color_range",
            "tv",
        ];
        command.args(["-y", "-nostdin", "-loglevel", "error", "-f", "rawvideo", "-pixel_format", "yuv420p"]);
        command.args(["-video_size", &format!("{}x{}", settings.width & !1, settings.height & !1)]);
        command.args(bt709);
        command.args(["-framerate", &format!("{}/{}", settings.rate.numerator, settings.rate.denominator)]);
        command.args(["-i", "pipe:0"]);
        if let Some(audio) = &settings.audio {
            command.arg("-i").arg(audio);
            // Endless silence after the sound, and the video as the shortest: exactly its length.
            command.args(["-map", "0:v", "-map", "1:a", "-af", "apad", "-shortest"]);
            command.args(["-c:a", "aac", "-b:a", "192k"]);
        }
        // The best H.264 encoder it has. The settings are those of libx264; others leave them aside. Encoding shares the
        // processor with drawing: these look like `fast` at 18 in a quarter of its time, a third larger.
        command.args(["-c:v", "h264", "-preset", "superfast", "-crf", "21"]);
        command.args(bt709);
        command.args(["-movflags", "+faststart", "-f", "mp4"]).arg(file.path());
        let spawned = command.stdin(Stdio::piped()).stdout(Stdio::null()).stderr(Stdio::piped()).spawn();
        let mut child = spawned.map_err(|error| match error.kind() {
            std::io::ErrorKind::NotFound => ViewError::NoFfmpeg,
            _ => ViewError::Ffmpeg(error.to_string()),
        })?;
        let input = child.stdin.take();
        let complaints = child.stderr.take().map(|mut stderr| {
            std::thread::spawn(move || {
                let mut text = String::new();
                // What cannot be read cannot be reported; the exit status still is.
                let _ = stderr.by_ref().take(64 << 10).read_to_string(&mut text);
                let _ = std::io::copy(&mut stderr, &mut std::io::sink());
                text
            })
        });
        Ok(Self {
            path: path.to_owned(),
            file: Some(file),
            child,
            input,
            complaints,
            opaque: Vec::new(),
            planes: Vec::new(),
        })
    }

    /// What ffmpeg said, once it has ended.
    fn complaint(&mut self, otherwise: &str) -> ViewError {
        let text = self.complaints.take().and_then(|thread| thread.join().ok()).unwrap_or_default();
        let line = text.lines().map(str::trim).filter(|line| !line.is_empty()).collect::<Vec<_>>().join("; ");
        ViewError::Ffmpeg(if line.is_empty() { otherwise.to_owned() } else { line })
    }
}

impl Encode for Mp4 {
    fn frame(&mut self, picture: &Picture) -> Result<(), ViewError> {
        // MP4 has no alpha: what is transparent becomes black.
        let mut rgba = &picture.rgba;
        if rgba.as_chunks::<4>().0.iter().any(|pixel| pixel[3] != 255) {
            self.opaque.clear();
            self.opaque.extend(rgba.as_chunks::<4>().0.iter().flat_map(|&[r, g, b, a]| {
                let dim = |c: u8| ((u16::from(c) * u16::from(a) + 127) / 255) as u8;
                [dim(r), dim(g), dim(b), 255]
            }));
            rgba = &self.opaque;
        }
        halved_chroma(rgba, [picture.width as usize, picture.height as usize], &mut self.planes);
        let written = match &mut self.input {
            Some(input) => input.write_all(&self.planes),
            None => return Err(self.complaint("it takes no more frames")),
        };
        written.map_err(|error| {
            // A broken pipe means that ffmpeg has ended; it says why.
            self.input = None;
            let _ = self.child.kill();
            let _ = self.child.wait();
            self.complaint(&error.to_string())
        })
    }

    fn finish(mut self: Box<Self>) -> Result<(), ViewError> {
        self.input = None;
        let status = self.child.wait().map_err(|error| ViewError::Ffmpeg(error.to_string()))?;
        if !status.success() {
            return Err(self.complaint(&status.to_string()));
        }
        match self.file.take() {
            Some(file) => persist(file, &self.path),
            None => Err(ViewError::Film("finished twice".into())),
        }
    }
}

impl Drop for Mp4 {
    fn drop(&mut self) {
        // Nothing to do for a child that has ended; the temporary file removes itself.
        self.input = None;
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
