//! One song follows the other without a gap: a sound that was cut in two comes out whole.

use std::path::{Path, PathBuf};
use std::process::Command;

use chladni_sound::{Song, WavSample, write_wav};

use super::{heard, silent};

/// Writes `sound`, cut at a frame, as two songs.
fn cut_in_two(folder: &Path, sound: &[f32], rate_hz: u32, at: usize) -> Vec<PathBuf> {
    let halves = [&sound[..at], &sound[at..]];
    let write = |(half, name): (&[f32], &str)| {
        let path = folder.join(name);
        let song = Song { rate_hz, left: half.to_vec(), right: half.iter().map(|x| -x).collect() };
        write_wav(&path, &song, WavSample::Float32).unwrap();
        path
    };
    halves.into_iter().zip(["one.wav", "two.wav"]).map(write).collect()
}

#[test]
fn a_ramp_that_was_cut_in_two_comes_out_whole_to_the_sample() {
    let folder = tempfile::tempdir().unwrap();
    // Each sample says exactly which one it is.
    const STEP: f32 = 1.0 / 131_072.0;
    let ramp: Vec<f32> = (1..=60_000u16).map(|n| f32::from(n) * STEP).collect();
    for at in [30_000, 30_001, 41_007] {
        let [left, right] = heard(&silent(), cut_in_two(folder.path(), &ramp, 48_000, at), |_| ());
        assert!(left.len() > ramp.len() - at + 4_800, "the cut was heard: {} frames", left.len());
        let first = left.iter().position(|x| *x > 0.0).unwrap();
        let sound = &left[first..];
        let whole = sound.windows(2).position(|pair| pair[1] - pair[0] != STEP);
        assert_eq!(whole.map(|n| (n, &sound[n..n + 3])), None, "cut at {at}");
        assert_eq!(sound.last(), ramp.last());
        assert!(left.iter().zip(&right).all(|(l, r)| *l == -r));
    }
}

const TONE_HZ: f64 = 441.7;

/// A tone that a cut at any place leaves at some other height.
fn tone(rate_hz: u32, secs: f64) -> Vec<f32> {
    let turn = std::f64::consts::TAU * TONE_HZ / f64::from(rate_hz);
    (0..(secs * f64::from(rate_hz)) as u32).map(|n| (0.5 * (turn * f64::from(n)).sin()) as f32).collect()
}

/// How far what is heard strays from a tone, at most.
fn strays(heard: &[f32]) -> f64 {
    // Any sine obeys x[n + 1] + x[n − 1] = 2 cos(turn) x[n], whatever its phase and height.
    let turn = std::f64::consts::TAU * TONE_HZ / 48_000.0;
    let stray = |x: &[f32]| (f64::from(x[2]) + f64::from(x[0]) - 2.0 * turn.cos() * f64::from(x[1])).abs();
    heard.windows(3).map(stray).fold(0.0, f64::max)
}

#[test]
fn a_tone_of_another_rate_that_was_cut_in_two_comes_out_whole() {
    let folder = tempfile::tempdir().unwrap();
    let sound = tone(44_100, 1.4);
    for at in [30_000, 30_031] {
        let [left, _] = heard(&silent(), cut_in_two(folder.path(), &sound, 44_100, at), |_| ());
        // The last frames are the end of the tone itself.
        let whole = &left[..left.len() - 1_000];
        let first = whole.iter().position(|x| *x != 0.0).unwrap();
        assert!(whole.len() - first > 40_000, "the cut was heard");
        let stray = strays(&whole[first + 1_000..]);
        assert!(stray < 1e-5, "cut at {at}: strays by {stray}");
    }
}

/// Encodes a song by ffmpeg; `None` where that cannot.
fn encoded(wav: &Path, ending: &str, options: &[&str]) -> Option<PathBuf> {
    let path = wav.with_extension(ending);
    let quiet = ["-y", "-loglevel", "error", "-i"];
    let done = Command::new("ffmpeg").args(quiet).arg(wav).args(options).arg(&path).status();
    done.is_ok_and(|status| status.success()).then_some(path)
}

#[test]
fn an_encoded_tone_that_was_cut_in_two_comes_out_whole() {
    let folder = tempfile::tempdir().unwrap();
    const AT: usize = 30_007;
    let sound = tone(48_000, 1.4);
    // The last number: frames that ffmpeg's encoder of AAC spoils at each beginning; its own decoder gives the same.
    let formats: [(&str, &[&str], f32, usize); 5] = [
        ("flac", &[], 1e-4, 0),
        ("mp3", &["-c:a", "libmp3lame", "-b:a", "256k"], 0.1, 0),
        ("ogg", &["-c:a", "libvorbis", "-q:a", "8"], 0.1, 0),
        ("opus", &["-c:a", "libopus", "-b:a", "256k"], 0.1, 0),
        ("m4a", &["-c:a", "aac", "-b:a", "256k"], 0.1, 1024),
    ];
    let halves = cut_in_two(folder.path(), &sound, 48_000, AT);
    let check = |(ending, options, most, spoiled): (&str, &[&str], f32, usize)| {
        let songs: Option<Vec<_>> = halves.iter().map(|wav| encoded(wav, ending, options)).collect();
        let Some(songs) = songs else {
            println!("skipped: no ffmpeg that writes {ending}");
            return;
        };
        let [left, _] = heard(&silent(), songs, |_| ());
        // Frames that are lost or added anywhere put all before them out of step.
        let shift = sound.len() as isize - left.len() as isize;
        let pairs = left.iter().enumerate().filter_map(|(n, heard)| {
            let at = usize::try_from(n as isize + shift).ok()?;
            let since_begin = if at < AT { at } else { at - AT };
            (since_begin >= spoiled).then(|| (heard - sound[at]).abs())
        });
        let worst = pairs.fold(0.0, f32::max);
        assert!(shift >= 0 && left.len() > sound.len() / 2, "{ending}: {} frames", left.len());
        assert!(worst < most, "{ending}: {worst}");
    };
    // At the same time, as each plays for as long as it is.
    let check = &check;
    std::thread::scope(|scope| {
        for format in formats {
            scope.spawn(move || check(format));
        }
    });
}
