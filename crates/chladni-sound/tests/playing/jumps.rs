//! What was decoded ahead and dropped by a jump was not heard.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::{Duration, Instant};

use chladni_sound::{Player, PlayerEvent, PlayerState, Song, WavSample, write_wav};
use chladni_testdata::HANGS;

use super::{silent, undisturbed, wait};

const RATE_HZ: u32 = 48_000;
/// Each sample of a ramp says exactly which one it is.
const STEP: f32 = 1.0 / 1_048_576.0;

/// A ramp from sample `first` on.
fn write_ramp(folder: &Path, name: &str, first: u32, secs: f64) -> PathBuf {
    let path = folder.join(name);
    let frames = (secs * f64::from(RATE_HZ)) as u32;
    let left: Vec<f32> = (first..first + frames).map(|n| n as f32 * STEP).collect();
    let song = Song { rate_hz: RATE_HZ, right: left.clone(), left };
    write_wav(&path, &song, WavSample::Float32).unwrap();
    path
}

/// The parts of ramps that were heard one after the other, as their first sample and the one behind their last.
fn parts(left: &[f32]) -> Vec<(i64, i64)> {
    let mut parts: Vec<(i64, i64)> = Vec::new();
    for sample in left.iter().map(|sample| (sample / STEP) as i64) {
        match parts.last_mut() {
            Some((_, end)) if *end == sample => *end += 1,
            _ => parts.push((sample, sample + 1)),
        }
    }
    parts
}

/// What is heard of `player` in so many seconds.
struct Ear {
    from: Option<u64>,
    left: Vec<f32>,
    right: Vec<f32>,
}

impl Ear {
    fn new(player: &Player) -> Self {
        let mut ear = Self { from: None, left: Vec::new(), right: Vec::new() };
        player.take_heard(&mut ear.from, &mut ear.left, &mut ear.right);
        ear
    }

    fn hear(&mut self, player: &Player, secs: f64) {
        let end = Instant::now() + Duration::from_secs_f64(secs);
        while Instant::now() < end {
            std::thread::sleep(Duration::from_millis(10));
            player.take_heard(&mut self.from, &mut self.left, &mut self.right);
        }
    }
}

#[test]
fn what_a_jump_drops_is_not_handed_out_as_heard() {
    let folder = tempfile::tempdir().unwrap();
    let song = write_ramp(folder.path(), "ramp.wav", 0, 10.0);
    undisturbed(|| {
        let player = silent();
        player.play_list(vec![song.clone()]);
        wait("the first sound", || player.status().position_secs > 0.1);
        let (mut ear, began) = (Ear::new(&player), Instant::now());
        ear.hear(&player, 0.3);
        let jumps = [6.0, 2.0, 8.0, 2.5];
        for secs in jumps {
            player.seek(secs);
            ear.hear(&player, 0.3);
        }
        let off_secs = ear.left.len() as f64 / f64::from(RATE_HZ) - began.elapsed().as_secs_f64();
        let parts = parts(&ear.left);
        let begins: Vec<i64> = parts.iter().skip(1).map(|part| part.0).collect();
        let of_jumps = jumps.map(|secs| (secs * f64::from(RATE_HZ)) as i64);
        let longest = parts.iter().map(|(begin, end)| end - begin).max().unwrap_or(0);
        let right = off_secs.abs() < 0.1 && begins == of_jumps && longest < i64::from(RATE_HZ) / 2;
        (right, format!("{off_secs} s too many, {parts:?}"))
    });
}

#[test]
fn removing_the_song_that_is_decoded_ahead_leaves_the_one_that_is_heard() {
    let folder = tempfile::tempdir().unwrap();
    let ramps = [("a.wav", 0, 1.2), ("b.wav", 200_000, 2.0), ("c.wav", 400_000, 2.0)];
    let [a, b, c] = ramps.map(|(name, first, secs)| write_ramp(folder.path(), name, first, secs));
    undisturbed(|| {
        let player = silent();
        player.play_list(vec![a.clone(), b.clone(), c.clone()]);
        let mut ear = Ear::new(&player);
        wait("the song ahead", || {
            ear.hear(&player, 0.0);
            player.events().any(|event| event == PlayerEvent::SongStarted(1))
        });
        player.set_songs(vec![a.clone(), c.clone()]);
        ear.hear(&player, 1.0);
        let parts = parts(&ear.left);
        // The song that is heard goes on to its end, and then comes the one that has taken the place of the other.
        let is_right = matches!(parts[..], [.., (_, end), (400_000, _)] if end == 57_600)
            && parts.iter().all(|(begin, _)| !(200_000..400_000).contains(begin));
        (is_right, format!("{parts:?}"))
    });
}

#[test]
fn a_song_that_is_not_in_the_list_stops_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let ramps = [("a.wav", 0.3), ("b.wav", 0.5), ("c.wav", 60.0)];
    let songs = ramps.map(|(name, secs)| write_ramp(folder.path(), name, 0, secs));
    let player = silent();
    player.play_list(songs.to_vec());
    player.select(99);
    player.select(1);
    // The second song is still heard, or was a moment ago, when only the third is left: its number lies beyond the list.
    wait("the third song", || player.events().any(|event| event == PlayerEvent::SongStarted(2)));
    player.set_songs(songs[2..].to_vec());
    player.seek(20.0);
    player.select(99);
    wait("the seek", || {
        let status = player.status();
        (status.song, status.state) == (0, PlayerState::Playing) && status.position_secs > 20.0
    });
    player.pause();
    player.select(7);
    player.play();
    wait("going on", || {
        player.status().state == PlayerState::Playing && player.status().position_secs > 20.1
    });
}

#[test]
fn a_song_that_is_longer_than_its_header_says_goes_on() {
    let folder = tempfile::tempdir().unwrap();
    // A loud second and quiet ones: without a table of contents, the length is guessed from the first frames.
    let path = folder.path().join("noise.wav");
    let mut noise = 1u32;
    let left: Vec<f32> = (0..8 * RATE_HZ)
        .map(|n| {
            noise = noise.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            if n < RATE_HZ { (noise >> 16) as f32 / 65_536.0 - 0.5 } else { 0.0 }
        })
        .collect();
    write_wav(&path, &Song { rate_hz: RATE_HZ, right: left.clone(), left }, WavSample::Int16).unwrap();
    let mp3 = path.with_extension("mp3");
    let options = ["-c:a", "libmp3lame", "-q:a", "0", "-write_xing", "0", "-id3v2_version", "0"];
    let encoded = Command::new("ffmpeg")
        .args(["-y", "-loglevel", "error", "-i"])
        .arg(&path)
        .args(options)
        .arg(&mp3)
        .status();
    if !encoded.is_ok_and(|status| status.success()) {
        return println!("skipped: no ffmpeg that writes MP3");
    }
    let player = silent();
    player.play_list(vec![mp3]);
    wait("the song", || player.status().duration_secs.is_some());
    let declared_secs = player.status().duration_secs.unwrap();
    assert!(declared_secs < 5.0, "the header says {declared_secs} s of 8");
    let end = Instant::now() + HANGS;
    while player.status().position_secs < declared_secs + 0.5 {
        assert!(Instant::now() < end, "{:?} of {declared_secs} s", player.status());
        std::thread::sleep(Duration::from_millis(5));
    }
    let status = player.status();
    assert!(status.duration_secs >= Some(status.position_secs), "{status:?}");
}
