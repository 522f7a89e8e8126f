//! A program that records is killed: its film is there nevertheless.

#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use chladni_view::film::{CutOff, LiveFilm, ffmpeg_is_there};
use chladni_view::{FrameRate, Picture};

/// The film that the child records.
const FILM: &str = "CHLADNI_TEST_RECORD_FOREVER";
/// Printed by the child before the folder of its recording, and once it has recorded for long enough.
const FOLDER: &str = "folder ";
const ENOUGH: &str = "enough";
const SOUND_HZ: u32 = 8000;

fn picture(shade: u8) -> Picture {
    Picture { width: 64, height: 48, rgba: [shade, shade, shade, 255].repeat(64 * 48) }
}

/// The child of the test below.
#[test]
fn records_until_killed() {
    let Some(path) = std::env::var_os(FILM) else { return };
    let mut film = LiveFilm::begin(Path::new(&path), (64, 48), FrameRate::per_second(30), SOUND_HZ).unwrap();
    writeln!(std::io::stdout(), "\n{FOLDER}{}", film.folder().display()).unwrap();
    for i in 0.. {
        let at_secs = (f64::from(i) + 0.5) / 30.0;
        film.picture(at_secs, picture((i % 200) as u8));
        let tone: Vec<f32> = (0..267).map(|n| (0.4 * f64::from(n)).sin() as f32).collect();
        film.sound(at_secs, &tone, &tone);
        if i == 30 * 60 {
            writeln!(std::io::stdout(), "\n{ENOUGH}").unwrap();
        }
        std::thread::sleep(Duration::from_millis(1));
    }
}

/// A condition becomes true, however long a busy machine takes.
fn wait(what: &str, mut done: impl FnMut() -> bool) {
    let began = Instant::now();
    while !done() {
        assert!(began.elapsed() < chladni_testdata::HANGS, "waited for {what}");
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// How many pieces the encoder has begun to write.
fn pieces(folder: &Path) -> usize {
    let film = std::fs::read(folder.join("picture.mp4")).unwrap_or_default();
    film.windows(4).filter(|name| name == b"moof").count()
}

fn probed(film: &Path) -> String {
    let mut command = Command::new("ffprobe");
    command.args(["-v", "error", "-show_entries", "stream=codec_type,duration", "-of", "csv=p=0"]);
    String::from_utf8(command.arg(film).output().unwrap().stdout).unwrap()
}

#[test]
fn what_was_recorded_before_a_kill_becomes_a_film() {
    if !ffmpeg_is_there() {
        return println!("skipped: no ffmpeg");
    }
    let home = tempfile::tempdir().unwrap();
    let mut child = Command::new(std::env::current_exe().unwrap())
        .args(["--exact", "records_until_killed", "--test-threads=1"])
        .env(FILM, home.path().join("set.mp4"))
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut said = BufReader::new(child.stdout.take().unwrap()).lines().map_while(Result::ok);
    let folder = said.find_map(|line| line.strip_prefix(FOLDER).map(PathBuf::from)).unwrap();
    said.find(|line| line == ENOUGH).unwrap();
    // The encoder may be behind.
    wait("eight pieces of a second", || pieces(&folder) >= 8);
    // Somebody records there.
    assert!(CutOff::find(&folder).is_none());
    child.kill().unwrap();
    child.wait().unwrap();
    std::fs::write(home.path().join("set (cut off).mp4"), "of another evening").unwrap();
    let found = CutOff::find(&folder).unwrap();
    assert_eq!(found.film(), home.path().join("set.mp4"));
    // Nor does anybody else take it.
    assert!(CutOff::find(&folder).is_none());
    let film = found.save().unwrap();
    assert_eq!(film, home.path().join("set (cut off 2).mp4"));
    assert!(!folder.exists());
    let streams = probed(&film);
    for kind in ["video,", "audio,"] {
        let secs = streams.lines().find_map(|line| line.strip_prefix(kind)).unwrap();
        assert!(secs.parse::<f64>().unwrap() > 5.0, "{streams}");
    }
}

/// Its encoder is killed, as by a full disk: the recording fails, and what there is of it is kept.
#[cfg(target_os = "linux")]
#[test]
fn what_was_recorded_before_the_encoder_died_is_kept() {
    if !ffmpeg_is_there() {
        return println!("skipped: no ffmpeg");
    }
    let home = tempfile::tempdir().unwrap();
    let path = home.path().join("set.mp4");
    let mut film = LiveFilm::begin(&path, (64, 48), FrameRate::per_second(30), SOUND_HZ).unwrap();
    let folder = film.folder().to_owned();
    let mut i = 0;
    wait("two pieces of a second", || {
        film.picture((f64::from(i) + 0.5) / 30.0, picture((i % 200) as u8));
        i += 1;
        pieces(&folder) >= 2
    });
    let ours = format!("{}/", folder.display());
    let processes = std::fs::read_dir("/proc").unwrap().filter_map(Result::ok);
    let encoder = processes.map(|entry| entry.path()).find(|process| {
        std::fs::read(process.join("cmdline"))
            .is_ok_and(|line| String::from_utf8_lossy(&line).contains(&ours))
    });
    let number = encoder.unwrap().file_name().unwrap().to_owned();
    Command::new("kill").arg("-9").arg(number).status().unwrap();
    let refused = loop {
        film.picture((f64::from(i) + 0.5) / 30.0, picture(100));
        i += 1;
        if let Some(ended) = film.ended() {
            break ended;
        }
        film.finish((f64::from(i) + 0.5) / 30.0);
        std::thread::sleep(Duration::from_millis(5));
    };
    assert!(refused.is_err());
    // A program that another test starts just now has the lock, too, until it begins to run.
    let mut found = None;
    wait("the lock", || {
        found = CutOff::find(&folder);
        found.is_some()
    });
    let found = found.unwrap();
    let film = found.save().unwrap();
    assert!(probed(&film).contains("video,"));
    assert!(!folder.exists());
}

#[test]
fn a_folder_that_is_none_is_left_alone() {
    let home = tempfile::tempdir().unwrap();
    assert!(CutOff::find(&home.path().join(".chladni-gone")).is_none());
    let other = home.path().join(".chladni-other");
    std::fs::create_dir(&other).unwrap();
    assert!(CutOff::find(&other).is_none());
    std::fs::write(other.join("recording.txt"), "48000\n../../elsewhere/set.mp4\n").unwrap();
    let found = CutOff::find(&other).unwrap();
    assert_eq!(found.film(), home.path().join("set.mp4"));
    // There is nothing to make a film of: where to look for the sound is said.
    assert!(found.is_empty());
    let said = found.save().unwrap_err().to_string();
    assert!(said.contains(&other.display().to_string()), "{said}");
    assert!(other.exists());
}
