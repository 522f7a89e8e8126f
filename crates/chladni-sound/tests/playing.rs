//! The player in silence and, if PulseAudio is installed, through a real sink.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on must fail")]

use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::time::{Duration, Instant};

use chladni_sound::{
    Player, PlayerEvent, PlayerSettings, PlayerState, Repeat, Song, WavSample, sample_tune, write_wav,
};
use chladni_testdata::SoundServer;

fn silent() -> Player {
    Player::start(PlayerSettings { audible: false, ..PlayerSettings::default() }).unwrap()
}

fn write_tone(folder: &Path, name: &str, rate_hz: u32, secs: f64) -> PathBuf {
    let path = folder.join(name);
    let tone: Vec<f32> = (0..(secs * f64::from(rate_hz)) as usize)
        .map(|n| 0.5 * (std::f32::consts::TAU * 500.0 * n as f32 / rate_hz as f32).sin())
        .collect();
    let song = Song { rate_hz, right: tone.iter().map(|x| -x).collect(), left: tone };
    write_wav(&path, &song, WavSample::Int16).unwrap();
    path
}

/// Waits until `done` or fails after `secs`.
fn wait(secs: f64, what: &str, mut done: impl FnMut() -> bool) {
    let end = Instant::now() + Duration::from_secs_f64(secs);
    while !done() {
        assert!(Instant::now() < end, "waited {secs} s for {what}");
        std::thread::sleep(Duration::from_millis(2));
    }
}

#[test]
fn time_passes_in_silence_and_obeys() {
    let folder = tempfile::tempdir().unwrap();
    let song = write_tone(folder.path(), "tone.wav", 44_100, 30.0);
    let player = silent();
    player.play_list(vec![song]);
    wait(5.0, "the first sample", || player.status().position_secs > 0.0);
    let (start, from) = (Instant::now(), player.status().position_secs);
    std::thread::sleep(Duration::from_millis(700));
    let moved = player.status().position_secs - from;
    assert!((moved - start.elapsed().as_secs_f64()).abs() < 0.15, "{moved}");
    assert_eq!(player.status().state, PlayerState::Playing);
    assert_eq!(player.status().device, None);

    player.pause();
    wait(2.0, "the pause", || player.status().state == PlayerState::Paused);
    std::thread::sleep(Duration::from_millis(60));
    let still = player.status().position_secs;
    std::thread::sleep(Duration::from_millis(150));
    assert!((player.status().position_secs - still).abs() < 1e-3);

    player.seek(20.0);
    wait(2.0, "the seek", || (player.status().position_secs - 20.0).abs() < 0.05);
    player.play();
    wait(3.0, "going on", || player.status().position_secs > 20.1);
    assert_eq!(player.status().duration_secs, Some(30.0));
}

#[test]
fn the_window_shows_the_samples_that_are_heard() {
    let folder = tempfile::tempdir().unwrap();
    let song = write_tone(folder.path(), "tone.wav", 44_100, 10.0);
    let player = silent();
    player.play_list(vec![song]);
    wait(5.0, "half a second", || player.status().position_secs > 0.5);
    let (mut left, mut right) = (vec![0.0; 2048], vec![0.0; 2048]);
    let secs = player.heard_window(1024, &mut left, &mut right);
    let rate_hz = f64::from(player.status().rate_hz);
    // Sample i lies (i − 1024) / rate after the position: the tone's phase tells.
    let worst = left.iter().zip(&right).enumerate().fold(0.0f64, |worst, (i, (l, r))| {
        let t = secs + (i as f64 - 1024.0) / rate_hz;
        let truth = 0.5 * (std::f64::consts::TAU * 500.0 * t).sin();
        worst.max((f64::from(*l) - truth).abs()).max((f64::from(*r) + truth).abs())
    });
    assert!(worst < 0.05, "{worst}");
}

#[test]
fn a_playlist_goes_on_over_a_broken_song_and_ends() {
    let folder = tempfile::tempdir().unwrap();
    let broken = folder.path().join("broken.mp3");
    std::fs::write(&broken, b"no music").unwrap();
    let songs = vec![
        write_tone(folder.path(), "a.wav", 44_100, 0.4),
        broken,
        write_tone(folder.path(), "c.wav", 22_050, 0.4),
    ];
    let player = silent();
    player.play_list(songs);
    let mut events = Vec::new();
    wait(10.0, "the end", || {
        events.extend(player.events());
        events.contains(&PlayerEvent::Finished)
    });
    assert!(
        matches!(
            &events[..],
            [
                PlayerEvent::SongStarted(0),
                PlayerEvent::SongFailed { song: 1, .. },
                PlayerEvent::SongStarted(2),
                PlayerEvent::Finished
            ]
        ),
        "{events:?}"
    );
    assert_eq!(player.status().state, PlayerState::Stopped);
    player.repeat(Repeat::List);
    player.play();
    wait(3.0, "playing again", || player.status().state == PlayerState::Playing);
}

/// Writes a level on one side only, which says at every sample how loud its song is.
fn write_level(folder: &Path, name: &str, is_left: bool, secs: f64) -> PathBuf {
    let path = folder.join(name);
    let (level, silence) = (vec![0.5; (48_000.0 * secs) as usize], vec![0.0; (48_000.0 * secs) as usize]);
    let (left, right) = if is_left { (level, silence) } else { (silence, level) };
    write_wav(&path, &Song { rate_hz: 48_000, left, right }, WavSample::Float32).unwrap();
    path
}

#[test]
fn one_song_fades_into_the_next() {
    let folder = tempfile::tempdir().unwrap();
    let songs = [("a.wav", true, 2.0), ("b.wav", false, 2.5), ("c.wav", true, 0.6), ("d.wav", false, 1.0)];
    let songs = songs.map(|(name, is_left, secs)| write_level(folder.path(), name, is_left, secs));
    let player = silent();
    player.set_crossfade_secs(1.0);
    player.pause();
    player.play_list(songs[..2].to_vec());
    let (mut from, mut left, mut right) = (None, Vec::new(), Vec::new());
    player.take_heard(&mut from, &mut left, &mut right);
    let mut fades = Vec::new();
    wait(20.0, "the end", || {
        player.take_heard(&mut from, &mut left, &mut right);
        let status = player.status();
        fades.push((status.song, status.crossfade_secs));
        player.events().any(|event| event == PlayerEvent::Finished)
    });
    player.take_heard(&mut from, &mut left, &mut right);
    fades.dedup();
    assert!(fades.ends_with(&[(0, 0.0), (1, 1.0)]), "{fades:?}");
    // What was heard before the first look is missing.
    assert!((3.0..=3.5).contains(&(left.len() as f64 / 48_000.0)), "{}", left.len());
    let power = left.iter().zip(&right).map(|(l, r)| l * l + r * r);
    let worst = power.map(|power| (power - 0.25).abs()).fold(0.0, f32::max);
    assert!(worst < 1e-5, "{worst}");
    let middle = left.len() - 2 * 48_000;
    assert!(
        (left[middle] - right[middle]).abs() < 1e-3,
        "they are equally loud where the second one is heard"
    );
    assert!(left[middle - 24_000..middle + 24_000].is_sorted_by(|one, next| one >= next));

    // Songs that are shorter than two crossfades, and one that cannot be played, at the end, too.
    let broken = folder.path().join("broken.mp3");
    std::fs::write(&broken, b"no music").unwrap();
    let [a, _, c, d] = songs;
    player.play_list(vec![a, c, broken.clone(), d, broken]);
    let mut events = Vec::new();
    wait(20.0, "the end", || {
        events.extend(player.events());
        events.contains(&PlayerEvent::Finished)
    });
    let started = |song| events.contains(&PlayerEvent::SongStarted(song));
    assert!([0, 1, 3].into_iter().all(started), "{events:?}");
}

/// The example that cargo has built beside this test.
fn example(name: &str) -> PathBuf {
    let folder = std::env::current_exe().unwrap().parent().unwrap().parent().unwrap().to_owned();
    folder.join("examples").join(name)
}

fn number(json: &str, name: &str) -> f64 {
    let at = json.find(&format!("\"{name}\": ")).unwrap_or_else(|| panic!("{name} is not in {json}"));
    let text = json[at..].split([':', ',', '}']).nth(1).unwrap();
    text.trim().trim_matches(['[', ']']).parse().unwrap()
}

#[test]
fn what_a_real_sink_gets_is_what_was_decoded() {
    let Some(server) = SoundServer::start() else { return };
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("tune.wav");
    write_wav(&path, &sample_tune(), WavSample::Int16).unwrap();
    undisturbed(|| {
        let report = played(&server, &["check", path.to_str().unwrap(), "4"]);
        assert!(number(&report, "compared_secs") > 1.5);
        let right = number(&report, "underruns") == 0.0
            && number(&report, "relative_error") < 0.02
            // The smallest difference to the recorder includes the recorder's own delay of 10 ms.
            && (-0.01..0.04).contains(&number(&report, "position_ahead_secs"));
        (right, report)
    });
}

/// The report of the example when it plays on `server`.
fn played(server: &SoundServer, arguments: &[&str]) -> String {
    let output = server.command(example("playback")).args(arguments).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8_lossy(&output.stdout).into_owned()
}

/// Playback follows the wall clock, and a busy machine can disturb it: one of four attempts must succeed.
fn undisturbed(mut measure: impl FnMut() -> (bool, String)) {
    let mut reports = Vec::new();
    while reports.len() < 4 {
        let (right, report) = measure();
        if right {
            return;
        }
        reports.push(report);
    }
    panic!("never right: {reports:#?}");
}

#[test]
fn a_device_that_goes_away_and_comes_back() {
    let Some(mut server) = SoundServer::start() else { return };
    let folder = tempfile::tempdir().unwrap();
    let song = write_tone(folder.path(), "long.wav", 44_100, 60.0);
    let mut child = server
        .command(example("playback"))
        .args(["watch", song.to_str().unwrap(), "40"])
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let mut lines = BufReader::new(child.stdout.take().unwrap()).lines().map_while(Result::ok);
    let (mut seen, mut stage) = (Vec::new(), 0);
    for line in &mut lines {
        let place: f64 = line.split(' ').nth(1).and_then(|x| x.parse().ok()).unwrap_or(-1.0);
        let silent = line.ends_with("silence");
        seen.push(line);
        match stage {
            // While it plays: disconnect the device.
            0 if place > 0.5 && !silent => server.stop(),
            // In silence the song continues from where it was.
            1 if place > 1.0 && silent => server.restart(),
            2 if place > 1.5 && !silent => {}
            _ => continue,
        }
        stage += 1;
        if stage == 3 {
            break;
        }
    }
    let _ = child.kill();
    let _ = child.wait();
    assert_eq!(stage, 3, "{seen:#?}");
    assert!(seen.iter().any(|line| line.starts_with("lost")), "{seen:#?}");
}

#[test]
fn pauses_and_other_devices_do_not_move_the_position() {
    let Some(server) = SoundServer::start() else { return };
    let folder = tempfile::tempdir().unwrap();
    let song = write_tone(folder.path(), "long.wav", 44_100, 60.0);
    undisturbed(|| {
        let report = played(&server, &["disturb", song.to_str().unwrap(), "6"]);
        // Playback must continue where the pause began, and a change of device must not make it jump.
        (number(&report, "step_back_secs") < 0.05 && number(&report, "ahead_secs") < 0.1, report)
    });
}

#[test]
fn a_song_of_one_sample_that_repeats_leaves_the_player_time_to_obey() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("one.wav");
    let song = Song { rate_hz: 44_100, left: vec![0.5], right: vec![0.5] };
    write_wav(&path, &song, WavSample::Int16).unwrap();
    let player = silent();
    player.repeat(Repeat::List);
    player.play_list(vec![path]);
    std::thread::sleep(Duration::from_millis(300));
    player.pause();
    wait(0.5, "the pause", || player.status().state == PlayerState::Paused);
    let before = player.events().count();
    assert!(before < 2000, "{before} events");
    let start = Instant::now();
    drop(player);
    assert!(start.elapsed() < Duration::from_millis(500));
}

#[test]
fn a_pause_after_the_last_sample_was_decoded_goes_on_where_it_began() {
    let folder = tempfile::tempdir().unwrap();
    // All of the song is decoded ahead of the device at once.
    let song = write_tone(folder.path(), "short.wav", 48_000, 0.35);
    let player = silent();
    player.play_list(vec![song]);
    wait(2.0, "a tenth of a second", || player.status().position_secs > 0.1);
    player.pause();
    wait(1.0, "the pause", || player.status().state == PlayerState::Paused);
    let paused = player.status().position_secs;
    assert!((0.1..0.34).contains(&paused), "{paused}");
    player.play();
    wait(1.0, "going on", || player.status().state == PlayerState::Playing);
    assert!(player.status().position_secs >= paused - 0.001, "{}", player.status().position_secs);
    let mut events = Vec::new();
    wait(1.0, "the end", || {
        events.extend(player.events());
        events.contains(&PlayerEvent::Finished)
    });
    assert_eq!(events, [PlayerEvent::SongStarted(0), PlayerEvent::Finished]);
}

#[test]
fn what_the_machine_plays_can_be_captured() {
    let Some(server) = SoundServer::start() else { return };
    let folder = tempfile::tempdir().unwrap();
    // Half amplitude on the left, silence on the right.
    let path = folder.path().join("left.wav");
    let left: Vec<f32> = (0..480_000).map(|n| 0.5 * (n as f32 * 0.06).sin()).collect();
    let song = Song { rate_hz: 48_000, right: vec![0.0; left.len()], left };
    write_wav(&path, &song, WavSample::Int16).unwrap();
    let mut player = server
        .command(example("playback"))
        .args(["watch", path.to_str().unwrap(), "8"])
        .stdout(Stdio::null())
        .spawn()
        .unwrap();
    std::thread::sleep(Duration::from_millis(800));
    let heard = server.command(example("capture")).args(["null.monitor", "1.5"]).output().unwrap();
    let _ = player.kill();
    let _ = player.wait();
    let text = String::from_utf8_lossy(&heard.stdout).into_owned();
    let numbers: Vec<f32> = text.split_whitespace().filter_map(|word| word.parse().ok()).collect();
    let [frames, rate_hz, left, right] = numbers[..] else { panic!("{text} {heard:?}") };
    assert_eq!(rate_hz, 48_000.0);
    assert!(frames > 30_000.0, "{text}");
    assert!((left - 0.5).abs() < 0.02 && right < 0.01, "{text}");
}

#[test]
fn one_program_is_captured_and_others_are_not() {
    let Some(server) = SoundServer::start() else { return };
    let folder = tempfile::tempdir().unwrap();
    // Two programs: one plays on the left at half amplitude, the other on the right, a little softer.
    let tone =
        |amplitude: f32| (0..960_000).map(|n| amplitude * (n as f32 * 0.06).sin()).collect::<Vec<f32>>();
    let (left, right, still) = (tone(0.5), tone(0.3), vec![0.0; 960_000]);
    let songs = [("piper", left, still.clone()), ("drummer", still, right)];
    let mut players = songs.map(|(name, left, right)| {
        let path = folder.path().join(format!("{name}.wav"));
        write_wav(&path, &Song { rate_hz: 48_000, left, right }, WavSample::Int16).unwrap();
        let arguments = [format!("--client-name={name}"), path.display().to_string()];
        server.command("paplay").args(arguments).spawn().unwrap()
    });
    let mut listed = String::new();
    wait(10.0, "both programs", || {
        let found = server.command(example("capture")).output().unwrap();
        listed = String::from_utf8_lossy(&found.stdout).into_owned();
        ["Program\tpiper", "Program\tdrummer"].iter().all(|program| listed.contains(program))
    });
    let capture = |name: &str| {
        let heard = server.command(example("capture")).args([name, "1.5"]).output().unwrap();
        let text = String::from_utf8_lossy(&heard.stdout).into_owned();
        let numbers: Vec<f32> = text.split_whitespace().filter_map(|word| word.parse().ok()).collect();
        let [frames, _, left, right] = numbers[..] else { panic!("{text} {heard:?}") };
        (frames, left, right)
    };
    let (frames, left, right) = capture("piper");
    assert!(frames > 30_000.0 && (left - 0.5).abs() < 0.02 && right < 0.01, "{frames} {left} {right}");
    let (frames, left, right) = capture("drummer");
    assert!(frames > 30_000.0 && left < 0.01 && (right - 0.3).abs() < 0.02, "{frames} {left} {right}");
    for player in &mut players {
        let _ = player.kill();
        let _ = player.wait();
    }
    let gone = server.command(example("capture")).args(["piper", "1"]).output().unwrap();
    assert!(!gone.status.success() && String::from_utf8_lossy(&gone.stderr).contains("no such source"));
}

#[test]
fn the_list_changes_around_the_song_that_plays() {
    let folder = tempfile::tempdir().unwrap();
    let [a, b, c] = ["a.wav", "b.wav", "c.wav"].map(|name| write_tone(folder.path(), name, 44_100, 20.0));
    let player = silent();
    player.play_list(vec![a.clone(), b.clone()]);
    player.select(1);
    wait(5.0, "the second song", || player.status().song == 1 && player.status().position_secs > 0.3);
    player.set_songs(vec![b.clone(), c.clone(), a]);
    wait(2.0, "its new number", || player.status().song == 0);
    assert!(player.status().position_secs > 0.3, "the song went on");
    player.set_songs(vec![c]);
    wait(2.0, "the song in its place", || player.status().position_secs < 0.3);
    wait(2.0, "that it plays", || player.status().state == PlayerState::Playing);
    player.set_songs(Vec::new());
    wait(2.0, "silence", || player.status().state == PlayerState::Stopped);
    player.set_songs(vec![b]);
    player.play();
    wait(2.0, "a song again", || player.status().state == PlayerState::Playing);
}
