//! What was decoded ahead and dropped by a jump was not heard.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::{Duration, Instant};

use chladni_sound::{Player, PlayerEvent, PlayerState, Repeat, Song, WavSample, write_wav};
use chladni_testdata::HANGS;

use super::{Ear, paused_at, silent, wait};

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

/// Plays to the end of the list, and says what was heard.
fn heard_to_the_end(ear: &mut Ear, player: &Player) -> Vec<(i64, i64)> {
    player.play();
    ear.hear_to_the_end(player, |_| ());
    parts(&ear.left)
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

#[test]
fn what_a_jump_drops_is_not_handed_out_as_heard() {
    let folder = tempfile::tempdir().unwrap();
    let song = write_ramp(folder.path(), "ramp.wav", 0, 20.0);
    let player = silent();
    let mut ear = Ear::new(&player);
    player.play_list(vec![song]);
    let (mut begin, mut heard) = (0.0, Vec::new());
    for jump in [6.0, 2.0, 8.0, 2.5, 0.0] {
        wait("some sound", || {
            ear.hear(&player);
            player.status().position_secs > begin + 0.2
        });
        let end = paused_at(&player);
        ear.hear(&player);
        let frame = |secs: f64| (secs * f64::from(RATE_HZ)).round() as i64;
        heard.push((frame(begin), frame(end)));
        player.seek(jump);
        wait("the jump", || player.status().position_secs == jump);
        player.play();
        begin = jump;
    }
    assert_eq!(parts(&ear.left), heard);
}

#[test]
fn removing_the_song_that_is_decoded_ahead_leaves_the_one_that_is_heard() {
    let folder = tempfile::tempdir().unwrap();
    let ramps = [("a.wav", 0, 10.0), ("b.wav", 500_000, 2.0), ("c.wav", 700_000, 2.0)];
    let [a, b, c] = ramps.map(|(name, first, secs)| write_ramp(folder.path(), name, first, secs));
    let player = silent();
    let mut ear = Ear::new(&player);
    player.play_list(vec![a.clone(), b, c.clone()]);
    paused_at(&player);
    // Near its end the next song is decoded, too. Time stands still meanwhile.
    player.seek(9.9);
    wait("the song ahead", || player.events().any(|event| event == PlayerEvent::SongStarted(1)));
    player.set_songs(vec![a, c]);
    let parts = heard_to_the_end(&mut ear, &player);
    // The song that is heard goes on to its end, and then comes the one that has taken the place of the other.
    assert!(parts.ends_with(&[(475_200, 480_000), (700_000, 796_000)]), "{parts:?}");
    assert!(parts.iter().all(|(begin, _)| !(500_000..700_000).contains(begin)), "{parts:?}");
}

#[test]
fn all_songs_of_a_list_in_another_order_follow_the_one_that_is_heard() {
    let folder = tempfile::tempdir().unwrap();
    let ramps = [("a.wav", 0, 10.0), ("b.wav", 500_000, 0.5), ("c.wav", 700_000, 0.5)];
    let [a, b, c] = ramps.map(|(name, first, secs)| write_ramp(folder.path(), name, first, secs));
    let player = silent();
    let mut ear = Ear::new(&player);
    player.play_list(vec![b.clone(), a.clone(), c.clone()]);
    player.select(1);
    paused_at(&player);
    player.seek(9.9);
    wait("the song ahead", || player.events().any(|event| event == PlayerEvent::SongStarted(2)));
    player.set_songs(vec![a, b, c]);
    let parts = heard_to_the_end(&mut ear, &player);
    assert!(parts.ends_with(&[(475_200, 480_000), (500_000, 524_000), (700_000, 724_000)]), "{parts:?}");
}

#[test]
fn behind_the_last_song_of_a_list_that_repeats_comes_what_follows_in_a_changed_one() {
    let folder = tempfile::tempdir().unwrap();
    let ramps = [("a.wav", 2.0), ("b.wav", 0.5), ("c.wav", 0.5), ("d.wav", 10.0)];
    let [a, b, c, d] = ramps.map(|(name, secs)| write_ramp(folder.path(), name, 0, secs));
    for (before, after, starts) in [
        // The first song still follows: the second one is the next to start.
        (vec![&a, &b, &c, &d], vec![&a, &c, &d], 1),
        // Another song does: the one that is heard starts again, where it is.
        (vec![&a, &b, &d], vec![&a, &b, &d, &c], 2),
    ] {
        let [before, after] = [before, after].map(|songs| songs.into_iter().cloned().collect::<Vec<_>>());
        let player = silent();
        player.repeat(Repeat::List);
        let last = before.len() - 1;
        player.play_list(before);
        player.select(last);
        paused_at(&player);
        player.events().for_each(drop);
        player.seek(9.9);
        wait("the song ahead", || player.events().any(|event| event == PlayerEvent::SongStarted(0)));
        player.set_songs(after);
        player.play();
        let mut next = None;
        wait("the next start", || {
            next = player.events().next();
            next.is_some()
        });
        assert_eq!(next, Some(PlayerEvent::SongStarted(starts)));
    }
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
