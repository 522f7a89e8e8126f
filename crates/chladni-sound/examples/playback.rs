//! Plays a song on the default device and reports how it went, as JSON lines.
//!
//! `playback check SONG SECS` records the PulseAudio monitor `null.monitor` meanwhile and compares the
//! recording with the decoded song. `playback watch SONG SECS` prints device and position. `playback
//! disturb SONG SECS` repeatedly pauses, continues and changes the device, and reports the effect on the
//! position and, of a recording of the same monitor, the largest difference of neighboring samples.

use std::error::Error;
use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdout, Command, Stdio};
use std::time::{Duration, Instant};

use chladni_sound::{Player, PlayerEvent, PlayerSettings, Repeat, Song, SongOptions, SongReader};
use chladni_task::Task;

const RATE_HZ: u32 = 48_000;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [mode, song, secs] = arguments.as_slice() else {
        return Err("check|watch|disturb SONG SECS".into());
    };
    let (song, secs) = (PathBuf::from(song), secs.parse()?);
    match mode.as_str() {
        "watch" => watch(song, secs),
        "disturb" => disturb(song, secs),
        _ => check(&song, secs),
    }
}

fn watch(song: PathBuf, secs: f64) -> Result<(), Box<dyn Error>> {
    let player = Player::start(PlayerSettings::default())?;
    player.repeat(Repeat::Song);
    player.play_list(vec![song]);
    let start = Instant::now();
    let mut out = std::io::stdout().lock();
    while start.elapsed().as_secs_f64() < secs {
        let status = player.status();
        let device = status.device.unwrap_or_else(|| "silence".into());
        writeln!(out, "{:.2} {:.3} {device}", start.elapsed().as_secs_f64(), status.position_secs)?;
        for event in player.events() {
            let lost = matches!(event, PlayerEvent::DeviceLost(_));
            writeln!(out, "{} {event:?}", if lost { "lost" } else { "event" })?;
        }
        out.flush()?;
        std::thread::sleep(Duration::from_millis(50));
    }
    Ok(())
}

/// Pauses every half second, then selects a missing device and the usual one again, repeatedly.
fn disturb(song: PathBuf, secs: f64) -> Result<(), Box<dyn Error>> {
    let (mut recorder, mut recorded, mut bytes) = record()?;
    let recording = std::thread::spawn(move || recorded.read_to_end(&mut bytes).map(|_| bytes));
    let player = Player::start(PlayerSettings::default())?;
    player.play_list(vec![song]);
    let position = || player.status().position_secs;
    let wait = |secs: f64, note: &mut dyn FnMut(f64)| {
        let start = Instant::now();
        while start.elapsed().as_secs_f64() < secs {
            std::thread::sleep(Duration::from_millis(2));
            note(position());
        }
    };
    wait(1.0, &mut |_| {});
    let (start, mut last, mut back) = (Instant::now(), position(), 0.0f64);
    while start.elapsed().as_secs_f64() < 0.5 * secs {
        player.pause();
        wait(0.25, &mut |_| {});
        last = position().max(last);
        player.play();
        wait(0.25, &mut |now| {
            back = back.max(last - now);
            last = now;
        });
    }
    let (start, from, mut ahead) = (Instant::now(), position(), 0.0f64);
    last = from;
    while start.elapsed().as_secs_f64() < 0.5 * secs {
        for device in [Some("alsa:nowhere".to_owned()), None] {
            player.set_device(device);
            wait(0.1, &mut |now| {
                back = back.max(last - now);
                last = now;
                ahead = ahead.max(now - from - start.elapsed().as_secs_f64());
            });
        }
    }
    drop(player);
    recorder.kill()?;
    recorder.wait()?;
    let heard = left_samples(&recording.join().map_err(|_| "the recording broke off")??);
    let steps = heard.windows(2).map(|pair| (pair[1] - pair[0]).abs());
    let loudest = heard.iter().fold(0.0f32, |most, sample| most.max(sample.abs()));
    writeln!(
        std::io::stdout(),
        "{{\"step_back_secs\": {back:.4}, \"ahead_secs\": {ahead:.3}, \"loudest\": {loudest:.4}, \"largest_step\": {:.4}}}",
        steps.fold(0.0, f32::max),
    )?;
    Ok(())
}

/// Begins to record the monitor; the recorder, what it writes, and the first of that.
fn record() -> Result<(Child, ChildStdout, Vec<u8>), Box<dyn Error>> {
    let mut recorder = Command::new("parec")
        .args(["-d", "null.monitor", "--format=float32le", "--rate=48000", "--channels=2"])
        .args(["--latency-msec=10", "--raw"])
        .stdout(Stdio::piped())
        .spawn()?;
    let mut recorded = recorder.stdout.take().ok_or("parec has no output")?;
    let mut first = vec![0u8; 16_384];
    // The recorder starts before the player does.
    let got = recorded.read(&mut first)?;
    first.truncate(got);
    Ok((recorder, recorded, first))
}

/// The left channel of what the recorder wrote.
fn left_samples(bytes: &[u8]) -> Vec<f32> {
    bytes.chunks_exact(8).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect()
}

fn check(path: &Path, secs: f64) -> Result<(), Box<dyn Error>> {
    let options = SongOptions { rate_hz: Some(RATE_HZ), ..SongOptions::default() };
    let truth = Song::read(&mut SongReader::open(path)?, &options, &Task::new())?;
    let (mut recorder, mut recorded, mut bytes) = record()?;
    let mut block = vec![0u8; 16_384];
    let start = Instant::now();
    let player = Player::start(PlayerSettings::default())?;
    player.play_list(vec![path.to_owned(); 64]);
    let mut first_sound_secs = None;
    let mut places = Vec::new();
    while start.elapsed().as_secs_f64() < secs {
        let got = recorded.read(&mut block)?;
        if got == 0 {
            return Err("the recording has ended".into());
        }
        bytes.extend_from_slice(&block[..got]);
        let status = player.status();
        if status.position_secs > 0.0 && first_sound_secs.is_none() {
            first_sound_secs = Some(start.elapsed().as_secs_f64());
        }
        let song_secs = status.position_secs + status.song as f64 * truth.duration_secs();
        places.push((bytes.len() / 8, song_secs));
    }
    let status = player.status();
    let events: Vec<PlayerEvent> = player.events().collect();
    drop(player);
    recorder.kill()?;
    recorder.wait()?;
    let Some(report) = compare(&left_samples(&bytes), &truth, &places) else {
        return Err(format!("nothing was recorded that is in the song; {status:?} {events:?}").into());
    };
    writeln!(
        std::io::stdout(),
        "{{\"first_sound_secs\": {:.3}, \"underruns\": {}, \"compared_secs\": {:.2}, \"relative_error\": {:.6}, \
         \"position_ahead_secs\": [{:.4}, {:.4}], \"device\": {:?}}}",
        first_sound_secs.unwrap_or(f64::INFINITY),
        status.underruns,
        report.compared_secs,
        report.relative_error,
        report.ahead_secs.0,
        report.ahead_secs.1,
        status.device,
    )?;
    Ok(())
}

struct Report {
    compared_secs: f64,
    relative_error: f64,
    /// Smallest value and median of the player's position minus the recorder's; the recorder's own delay
    /// (10 ms requested) is included.
    ahead_secs: (f64, f64),
}

/// Compares the left channels. The song repeats.
fn compare(recorded: &[f32], truth: &Song, places: &[(usize, f64)]) -> Option<Report> {
    let song = &truth.left;
    // A piece of the song that is not silent is searched for in the recording.
    let (from, len) = (RATE_HZ as usize, 4000);
    let piece = song.get(from..from + len)?;
    let error_at =
        |at: usize| -> f32 { recorded[at..at + len].iter().zip(piece).map(|(a, b)| (a - b) * (a - b)).sum() };
    let places_to_look = 0..recorded.len().min(12 * RATE_HZ as usize).checked_sub(len)?;
    let found = places_to_look.min_by(|&a, &b| error_at(a).total_cmp(&error_at(b)))?;
    let begin = found.checked_sub(from)?;
    let (mut error, mut power) = (0.0f64, 0.0f64);
    for (n, &heard) in recorded[begin..].iter().enumerate() {
        let true_sample = song[n % song.len()];
        error += f64::from(heard - true_sample).powi(2);
        power += f64::from(true_sample).powi(2);
    }
    let mut ahead: Vec<f64> = places
        .iter()
        .filter(|(_, song_secs)| *song_secs > 0.5)
        .map(|(frames, song_secs)| song_secs - (*frames as f64 - begin as f64) / f64::from(RATE_HZ))
        .collect();
    ahead.sort_by(f64::total_cmp);
    Some(Report {
        compared_secs: (recorded.len() - begin) as f64 / f64::from(RATE_HZ),
        relative_error: (error / power).sqrt(),
        ahead_secs: (*ahead.first()?, ahead[ahead.len() / 2]),
    })
}
