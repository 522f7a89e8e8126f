//! The camera as another program sees it, through a PipeWire of the test's own.

use std::io::Read;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

use chladni_testdata::HANGS;
use chladni_view::film::{CameraTarget, LiveCamera};
use chladni_view::{FrameRate, Picture};

const WIDTH: u32 = 320;
const HEIGHT: u32 = 180;
const LEFT: [u8; 4] = [220, 40, 30, 255];
const RIGHT: [u8; 4] = [20, 60, 200, 255];
const FRAMES: usize = 60;

struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

fn is_there(program: &str) -> bool {
    let mut command = Command::new(program);
    command.arg("--version").stdout(Stdio::null()).stderr(Stdio::null());
    command.status().is_ok_and(|status| status.success())
}

fn start(mut command: Command, runtime: &Path) -> Running {
    command.env("XDG_RUNTIME_DIR", runtime).env("HOME", runtime);
    command.stdout(Stdio::null()).stderr(Stdio::null());
    Running(command.spawn().expect("it was there"))
}

fn halves(left: [u8; 4], right: [u8; 4]) -> Picture {
    let row = [left, right].map(|color| color.repeat(WIDTH as usize / 2)).concat();
    Picture { width: WIDTH, height: HEIGHT, rgba: row.repeat(HEIGHT as usize) }
}

#[test]
fn another_program_sees_it() {
    let needed = ["pipewire", "wireplumber", "dbus-run-session", "gst-launch-1.0", "gst-inspect-1.0"];
    if let Some(program) = needed.into_iter().find(|program| !is_there(program)) {
        return println!("skipped: no {program}");
    }
    let plugin = Command::new("gst-inspect-1.0").arg("pipewiresink").stdout(Stdio::null()).status().unwrap();
    if !plugin.success() {
        return println!("skipped: no pipewiresink");
    }
    let runtime = tempfile::tempdir().unwrap();
    let daemon = start(Command::new("pipewire"), runtime.path());
    let socket = runtime.path().join("pipewire-0");
    let began = Instant::now();
    while !socket.exists() {
        assert!(began.elapsed() < HANGS, "pipewire does not come up");
        std::thread::sleep(Duration::from_millis(20));
    }
    // It connects readers with cameras, and wants a bus.
    let mut manager = Command::new("dbus-run-session");
    manager.args(["--", "wireplumber"]);
    let mut manager = start(manager, runtime.path());
    // The camera takes the daemon from its environment: it runs in a process that has another one.
    let program = std::env::current_exe().unwrap();
    let mut command = Command::new(program);
    command.args(["--exact", "within_the_daemon", "--ignored", "--nocapture"]);
    command.env("XDG_RUNTIME_DIR", runtime.path()).env("CHLADNI_CAMERA_TEST", runtime.path());
    let output = command.output().unwrap();
    // Without the daemon its manager ends, and so does the bus.
    drop(daemon);
    let ending = Instant::now();
    while matches!(manager.0.try_wait(), Ok(None)) && ending.elapsed() < Duration::from_secs(10) {
        std::thread::sleep(Duration::from_millis(20));
    }
    let said =
        String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{said}");
    println!("{said}");
}

#[test]
#[ignore = "run by another_program_sees_it"]
fn within_the_daemon() {
    if std::env::var_os("CHLADNI_CAMERA_TEST").is_none() {
        return;
    }
    let mut camera =
        LiveCamera::open(&CameraTarget::PipeWire, (WIDTH, HEIGHT), FrameRate::per_second(30)).unwrap();
    let (_reader, frames) = first_frames(&mut camera);
    let mut count = 1;
    let check = |frame: &[u8], [left, right]: [[u8; 4]; 2]| {
        let pixel = |x: u32, y: u32| &frame[4 * (y * WIDTH + x) as usize..][..4];
        for (x, y, color) in [(10, 10, left), (100, 170, left), (250, 10, right), (310, 170, right)] {
            let off = pixel(x, y).iter().zip(color).map(|(a, b)| a.abs_diff(b)).max();
            assert!(off <= Some(1), "({x}, {y}): {:?} is not {color:?}", pixel(x, y));
        }
    };
    for _ in 0..FRAMES {
        let frame = frames.recv_timeout(HANGS).expect("another frame");
        check(&frame, [LEFT, RIGHT]);
        count += 1;
    }
    // Another picture, and how long it takes to the other program.
    camera.picture(&mut halves(RIGHT, LEFT));
    let handed_over = Instant::now();
    let changed = loop {
        let frame = frames.recv_timeout(HANGS).expect("another frame");
        if frame[0].abs_diff(RIGHT[0]) <= 1 {
            break frame;
        }
        count += 1;
    };
    println!(
        "{count} frames seen, then another picture after {:.0} ms",
        1e3 * handed_over.elapsed().as_secs_f64()
    );
    check(&changed, [RIGHT, LEFT]);
    assert!(camera.sent() >= count);
}

/// Another program that reads the camera, and its first frame.
fn first_frames(camera: &mut LiveCamera) -> (Running, Receiver<Vec<u8>>) {
    let mut command = Command::new("gst-launch-1.0");
    command.args(["-q", "pipewiresrc", "target-object=chladni", "!", "videoconvert", "!"]);
    command.args(["video/x-raw,format=RGBA", "!", "fdsink", "fd=1", "sync=false"]);
    let began = Instant::now();
    camera.picture(&mut halves(LEFT, RIGHT));
    let mut wait = Duration::from_secs(5);
    while began.elapsed() < HANGS {
        if let Some(why) = camera.trouble() {
            panic!("{why}");
        }
        let mut reader =
            Running(command.stdout(Stdio::piped()).stderr(Stdio::null()).spawn().expect("it was there"));
        let mut pipe = reader.0.stdout.take().expect("its output");
        let (sender, frames) = channel();
        std::thread::spawn(move || {
            let mut frame = vec![0; (4 * WIDTH * HEIGHT) as usize];
            while pipe.read_exact(&mut frame).is_ok() && sender.send(frame.clone()).is_ok() {}
        });
        // One that comes before the camera is announced gives up or waits in vain, and another one comes.
        if frames.recv_timeout(wait).is_ok() {
            return (reader, frames);
        }
        // On a busy machine it may only have been slow.
        wait *= 2;
    }
    panic!("nothing was seen; sent {}", camera.sent());
}

#[test]
fn a_device_is_no_option_of_ffmpeg() {
    for name in ["-y", "video2", "file:video2", ""] {
        let target = CameraTarget::Device(name.into());
        let Err(why) = LiveCamera::open(&target, (WIDTH, HEIGHT), FrameRate::per_second(30)) else {
            panic!("{name} is taken");
        };
        assert!(why.to_string().contains("whole path"), "{why}");
    }
}

#[test]
fn what_ends_says_why() {
    if !is_there("gst-launch-1.0") && !is_there("ffmpeg") {
        return println!("skipped: neither gst-launch-1.0 nor ffmpeg");
    }
    let nowhere = CameraTarget::Device("/nonexistent/video".into());
    let size = (WIDTH, HEIGHT);
    let mut camera = match LiveCamera::open(&nowhere, size, FrameRate::per_second(30)) {
        Ok(camera) => camera,
        Err(why) => return assert!(why.to_string().contains("ffmpeg"), "{why}"),
    };
    let began = Instant::now();
    let why = loop {
        if let Some(why) = camera.trouble() {
            break why;
        }
        assert!(began.elapsed() < HANGS, "it does not end");
        std::thread::sleep(Duration::from_millis(10));
    };
    assert!(why.to_string().starts_with("camera: "), "{why}");
    // Not every ffmpeg knows of such devices.
    assert!(["nonexistent", "v4l2"].iter().any(|word| why.to_string().contains(word)), "{why}");
    assert!(camera.trouble().is_none(), "it says so once");
    assert!(LiveCamera::open(&nowhere, (WIDTH, 181), FrameRate::per_second(30)).is_err());
}
