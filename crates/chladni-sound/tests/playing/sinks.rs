//! Through a real sink of PulseAudio, where that is installed: playing and capturing.

use std::io::{BufRead, BufReader};
use std::path::PathBuf;
use std::process::Stdio;

use chladni_sound::{SEAM_SECS, Song, WavSample, sample_tune, write_wav};
use chladni_testdata::SoundServer;

use super::{undisturbed, wait, write_tone};

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

/// The report of the example when it plays on `server`; its error where it found nothing to report.
fn played(server: &SoundServer, arguments: &[&str]) -> Result<String, String> {
    let output = server.command(example("playback")).args(arguments).output().unwrap();
    let words = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    if output.status.success() { Ok(words(&output.stdout)) } else { Err(words(&output.stderr)) }
}

/// The time in the song, of a line of the example's watch.
fn place(line: &str) -> f64 {
    line.split(' ').nth(1).and_then(|x| x.parse().ok()).unwrap_or(-1.0)
}

#[test]
fn what_a_real_sink_gets_is_what_was_decoded() {
    let Some(server) = SoundServer::start() else { return };
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("tune.wav");
    write_wav(&path, &sample_tune(), WavSample::Int16).unwrap();
    undisturbed(|| {
        let report = played(&server, &["check", path.to_str().unwrap(), "4"])?;
        let right = number(&report, "compared_secs") > 1.5
            && number(&report, "underruns") == 0.0
            && number(&report, "relative_error") < 0.02
            // The smallest difference to the recorder includes the recorder's own delay of 10 ms.
            && (-0.01..0.04).contains(&number(&report, "position_ahead_secs"));
        if right { Ok(()) } else { Err(report) }
    });
}

#[test]
fn a_device_that_goes_away_and_comes_back_at_another_rate() {
    let Some(mut server) = SoundServer::start() else { return };
    let folder = tempfile::tempdir().unwrap();
    let song = write_tone(folder.path(), "long.wav", 44_100, 60.0);
    let mut child = server
        .command(example("playback"))
        .args(["watch", song.to_str().unwrap(), "1200"])
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let mut lines = BufReader::new(child.stdout.take().unwrap()).lines().map_while(Result::ok);
    let (mut seen, mut stage) = (Vec::new(), 0);
    for line in &mut lines {
        let place = place(&line);
        let silent = line.ends_with("silence");
        seen.push(line);
        match stage {
            // While it plays: disconnect the device.
            0 if place > 0.5 && !silent => server.stop(),
            // In silence the song continues from where it was.
            1 if place > 1.0 && silent => server.restart_at(44_100),
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
fn pauses_and_other_devices_do_not_move_the_position_and_make_no_step() {
    let Some(server) = SoundServer::start() else { return };
    let folder = tempfile::tempdir().unwrap();
    let song = write_tone(folder.path(), "long.wav", 44_100, 60.0);
    undisturbed(|| {
        let report = played(&server, &["disturb", song.to_str().unwrap(), "6"])?;
        // Playback must continue where the pause began, and a change of device must not make it jump.
        let stays = number(&report, "step_back_secs") < 0.05 && number(&report, "ahead_secs") < 0.1;
        // The slope of the tone at the device's 48 kHz, and the fades of a jump and of the gain.
        let slope = 0.5 * std::f64::consts::TAU * 500.0 / 48_000.0;
        let most = slope + 3.1 * 0.5 / (f64::from(SEAM_SECS) * 48_000.0);
        let right = stays && number(&report, "loudest") > 0.45 && number(&report, "largest_step") < most;
        if right { Ok(()) } else { Err(report) }
    });
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
        .args(["watch", path.to_str().unwrap(), "1200"])
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut lines = BufReader::new(player.stdout.take().unwrap()).lines().map_while(Result::ok);
    assert!(lines.any(|line| place(&line) > 0.5 && !line.ends_with("silence")));
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
    // They play for twenty minutes.
    const FRAMES: usize = 1200 * 8000;
    let tone = |amplitude: f32| {
        (0..FRAMES).map(|n| amplitude * (n as f64 * 0.06).sin() as f32).collect::<Vec<f32>>()
    };
    let (left, right, still) = (tone(0.5), tone(0.3), vec![0.0; FRAMES]);
    let songs = [("piper", left, still.clone()), ("drummer", still, right)];
    let mut players = songs.map(|(name, left, right)| {
        let path = folder.path().join(format!("{name}.wav"));
        write_wav(&path, &Song { rate_hz: 8000, left, right }, WavSample::Int16).unwrap();
        let arguments = [format!("--client-name={name}"), path.display().to_string()];
        server.command("paplay").args(arguments).spawn().unwrap()
    });
    let mut listed = String::new();
    wait("both programs", || {
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
    wait("the end of the piper", || {
        let gone = server.command(example("capture")).args(["piper", "0"]).output().unwrap();
        !gone.status.success() && String::from_utf8_lossy(&gone.stderr).contains("no such source")
    });
}
