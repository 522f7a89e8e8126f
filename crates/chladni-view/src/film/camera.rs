//! Live pictures as a camera for other programs. We never wait for them, and they always get the newest
//! picture.

#[cfg_attr(not(all(target_os = "macos", feature = "syphon")), path = "camera/no_syphon.rs")]
mod syphon;

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{ChildStdin, Command};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use chladni_task::{Needs, apart, other_program};

use super::feed::Feed;
use super::ffmpeg::ffmpeg;
use super::live::fit;
use super::raw::{Raw, RawFormat};
use super::{Encode, FilmSettings, FrameRate, on_black};
use crate::{Picture, ViewError};

pub use syphon::HAS_SYPHON;

/// Where Linux lists video devices without hardware.
const VIRTUAL_DEVICES: &str = "/sys/devices/virtual/video4linux";
/// Packages to install for a PipeWire camera if it is missing.
const INSTALL: &str = "install gstreamer1.0-tools, gstreamer1.0-plugins-base, gstreamer1.0-plugins-good and gstreamer1.0-pipewire";

/// Which kind of camera other programs see.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum CameraTarget {
    /// A node of PipeWire, named Chladni. Needs `gst-launch-1.0` with PipeWire's plugin.
    PipeWire,
    /// A video device of v4l2loopback, such as `/dev/video2`: its path begins at the root, so that it is no option of
    /// ffmpeg, which it needs.
    Device(PathBuf),
    /// A server of Syphon, named Chladni. Only where [`HAS_SYPHON`]; needs Syphon.framework.
    Syphon,
    /// Raw frames on standard output, for a program that reads them as they come. Where it is late, frames are left out.
    StandardOutput(RawFormat),
}

/// Video devices that can be given pictures (those of v4l2loopback), each with its name; none but on Linux.
pub fn video_devices() -> Vec<(PathBuf, String)> {
    let entries = std::fs::read_dir(VIRTUAL_DEVICES).into_iter().flatten().flatten();
    let mut devices: Vec<(PathBuf, String)> = entries
        .map(|entry| {
            let name = std::fs::read_to_string(entry.path().join("name")).unwrap_or_default();
            (Path::new("/dev").join(entry.file_name()), name.trim().to_owned())
        })
        .collect();
    devices.sort();
    devices
}

/// A camera that shows the newest picture it was given, again and again. Dropped, it is gone.
///
/// Pictures are not queued: one that comes before the last one was shown replaces it.
#[derive(Debug)]
pub struct LiveCamera {
    /// The program that shows the pictures, where one does.
    feed: Option<Feed>,
    common: Arc<Common>,
    /// Ends with what went wrong, unless only the program knows that.
    thread: Option<JoinHandle<Option<String>>>,
    writes_out: bool,
}

/// State that both threads share.
#[derive(Debug, Default)]
struct Common {
    newest: Mutex<Newest>,
    sent: AtomicU64,
    left_out: AtomicU64,
    ends: AtomicBool,
}

#[derive(Debug, Default)]
struct Newest {
    picture: Picture,
    is_fresh: bool,
}

impl LiveCamera {
    /// Opens a camera of `width`×`height` pixels, both even because some programs need that. It is black until a
    /// picture comes.
    ///
    /// # Errors
    /// [`ViewError::Camera`] where a program is missing that it needs or refuses to start; [`ViewError::Size`] and
    /// [`ViewError::Film`] for sizes and rates that no film has. What goes wrong later is found by
    /// [`trouble`](Self::trouble).
    pub fn open(
        target: &CameraTarget,
        (width, height): (u32, u32),
        rate: FrameRate,
    ) -> Result<Self, ViewError> {
        let settings = FilmSettings { width, height, rate, frames: u64::MAX, first: 0, audio: None };
        settings.check()?;
        if width % 2 == 1 || height % 2 == 1 {
            return Err(ViewError::Camera(format!("its sides are even, unlike {width}×{height}")));
        }
        if let CameraTarget::Device(path) = target
            && !path.has_root()
        {
            let why = format!("{} is no device: give its whole path, such as /dev/video2", path.display());
            return Err(ViewError::Camera(why));
        }
        let (feed, way) = match (target, target.command(width, height, rate)) {
            (CameraTarget::StandardOutput(format), _) => {
                (None, Way::Pipe(Raw::begin(std::io::stdout(), *format, &settings)?))
            }
            (_, None) => (None, Way::Syphon),
            (_, Some(mut command)) => {
                let mut feed = start(&mut command, target)?;
                let input =
                    feed.take_input().ok_or_else(|| ViewError::Camera("no pipe to its program".into()))?;
                (Some(feed), Way::Program(input))
            }
        };
        let common = Arc::new(Common::default());
        let sender = Sender { common: Arc::clone(&common), width, height, rate };
        let thread = std::thread::Builder::new()
            .name("camera".into())
            .spawn(move || sender.run(way))
            .map_err(|why| ViewError::Camera(format!("no thread to send from: {why}")))?;
        let writes_out = matches!(target, CameraTarget::StandardOutput(_));
        Ok(Self { feed, common, thread: Some(thread), writes_out })
    }

    /// Shows `picture`, of any size, from now on; leaves an old picture in it, whose memory can hold the next
    /// one.
    pub fn picture(&mut self, picture: &mut Picture) {
        // The other thread swaps pictures under this lock and does nothing else.
        let mut newest = self.common.newest.lock().unwrap_or_else(PoisonError::into_inner);
        std::mem::swap(&mut newest.picture, picture);
        if std::mem::replace(&mut newest.is_fresh, true) {
            self.common.left_out.fetch_add(1, Ordering::Relaxed);
        }
    }

    /// How many pictures went out; none do while nobody watches.
    pub fn sent(&self) -> u64 {
        self.common.sent.load(Ordering::Relaxed)
    }

    /// How many were replaced by a newer one before they went out.
    pub fn left_out(&self) -> u64 {
        self.common.left_out.load(Ordering::Relaxed)
    }

    /// Why it ended, once it has.
    pub fn trouble(&mut self) -> Option<ViewError> {
        if !self.thread.as_ref()?.is_finished() {
            return None;
        }
        let said = self.thread.take()?.join().ok().flatten();
        let Some(feed) = &mut self.feed else {
            return Some(ViewError::Camera(said.unwrap_or_else(|| "its thread has ended".into())));
        };
        // Later complaints only follow from the first one.
        let said = feed.complaint("its program has ended");
        let said = said.split("; ").next().unwrap_or_default();
        Some(ViewError::Camera(if said.contains("no element") {
            format!("{said}: {INSTALL}")
        } else if said.contains("pipewiresink") && said.contains("Failed to connect") {
            "no PipeWire runs that it could be a camera of".into()
        } else {
            said.to_owned()
        }))
    }
}

impl Drop for LiveCamera {
    fn drop(&mut self) {
        self.common.ends.store(true, Ordering::Relaxed);
        // The thread may wait for its reader, which ends first.
        if let Some(feed) = &mut self.feed {
            feed.end();
        }
        // Standard output belongs to a reader that may never take another picture: that thread ends with the program.
        let waits = self.feed.is_some() || !self.writes_out;
        if let Some(thread) = self.thread.take().filter(|_| waits) {
            thread.join().ok();
        }
    }
}

/// Starts the program of `target`.
fn start(command: &mut Command, target: &CameraTarget) -> Result<Feed, ViewError> {
    Feed::start(command).map_err(|why| {
        ViewError::Camera(match (why.kind(), target) {
            (std::io::ErrorKind::NotFound, CameraTarget::PipeWire) => {
                format!("gst-launch-1.0 is not on the PATH: {INSTALL}")
            }
            (std::io::ErrorKind::NotFound, _) => "ffmpeg is not on the PATH: install it".into(),
            _ => why.to_string(),
        })
    })
}

impl CameraTarget {
    /// The program that shows the pictures, where one does.
    fn command(&self, width: u32, height: u32, rate: FrameRate) -> Option<Command> {
        let fps = format!("{}/{}", rate.numerator, rate.denominator);
        match self {
            Self::PipeWire => {
                let mut command = other_program("gst-launch-1.0", Needs::Desktop);
                apart(&mut command);
                command.args(["-q", "fdsrc", "fd=0"]).arg(format!("blocksize={}", 4 * width * height));
                command.args(["!", "rawvideoparse", "format=rgbx"]);
                command.args([
                    format!("width={width}"),
                    format!("height={height}"),
                    format!("framerate={fps}"),
                ]);
                // The pictures come in time; readers may want another kind of pixels.
                command.args(["!", "videoconvert", "!", "pipewiresink", "mode=provide", "sync=false"]);
                command.arg(
                    "stream-properties=props,media.class=Video/Source,media.role=Camera,node.name=chladni,\
                     node.description=Chladni",
                );
                Some(command)
            }
            Self::Device(path) => {
                let mut command = ffmpeg();
                command.args(["-nostdin", "-loglevel", "error", "-f", "rawvideo", "-pixel_format", "rgb0"]);
                command.args([
                    "-video_size",
                    &format!("{width}x{height}"),
                    "-framerate",
                    &fps,
                    "-i",
                    "pipe:0",
                ]);
                command.args(["-f", "v4l2", "-pix_fmt", "yuv420p"]).arg(path);
                Some(command)
            }
            Self::Syphon | Self::StandardOutput(_) => None,
        }
    }
}

/// How pictures leave.
enum Way {
    /// Into the standard input of a program.
    Program(ChildStdin),
    /// Through a server that the sending thread opens.
    Syphon,
    /// As frames of a raw format.
    Pipe(Raw<std::io::Stdout>),
}

/// On a thread of its own.
struct Sender {
    common: Arc<Common>,
    width: u32,
    height: u32,
    rate: FrameRate,
}

impl Sender {
    /// Until it is dropped or nobody takes its pictures; then why, unless only a program knows that.
    fn run(self, way: Way) -> Option<String> {
        match way {
            Way::Program(mut input) => {
                self.send(|_, rgba| input.write_all(rgba).is_ok());
                None
            }
            Way::Syphon => {
                let mut trouble = None;
                match syphon::Server::open(self.width, self.height) {
                    Ok(mut server) => self.send(|_, rgba| {
                        trouble = server.send(rgba).err();
                        trouble.is_none()
                    }),
                    Err(why) => trouble = Some(why),
                }
                trouble
            }
            Way::Pipe(mut raw) => {
                let mut trouble = None;
                self.send(|picture, _| {
                    trouble = raw.frame(picture).err().map(|why| why.to_string());
                    trouble.is_none()
                });
                trouble
            }
        }
    }

    /// Sends the newest picture at each time of the rate, until it is dropped or `send` fails.
    fn send(&self, mut send: impl FnMut(&Picture, &[u8]) -> bool) {
        let black = [0, 0, 0, 255].repeat(self.width as usize * self.height as usize);
        let mut shown = Picture { width: self.width, height: self.height, rgba: black };
        let mut opaque = Vec::new();
        let began = Instant::now();
        let mut slot = 0;
        while !self.common.ends.load(Ordering::Relaxed) {
            if self.take(&mut shown) && (shown.width, shown.height) != (self.width, self.height) {
                shown = fit(shown, self.width, self.height);
            }
            if !send(&shown, on_black(&shown.rgba, &mut opaque)) {
                return;
            }
            self.common.sent.fetch_add(1, Ordering::Relaxed);
            // If the reader was late, the slots in between are left out.
            slot = (slot + 1).max(self.rate.slot(began.elapsed().as_secs_f64()));
            let next = Duration::from_secs_f64(self.rate.start_secs(slot));
            std::thread::sleep(next.saturating_sub(began.elapsed()));
        }
    }

    /// Takes the newest picture; whether there is one that was not taken before.
    fn take(&self, shown: &mut Picture) -> bool {
        let mut newest = self.common.newest.lock().unwrap_or_else(PoisonError::into_inner);
        let is_fresh = std::mem::replace(&mut newest.is_fresh, false);
        if is_fresh {
            std::mem::swap(&mut newest.picture, shown);
        }
        is_fresh
    }
}
