//! Files whose names look like options, addresses or commands.

use std::collections::BTreeSet;
use std::path::Path;
use std::process::Command;

use chladni_sound::{Song, WavSample, write_wav};
use chladni_view::Picture;

use crate::strobing::ball;

/// Runs the program in `folder` and checks that it succeeds.
fn ok(folder: &Path, arguments: &[String]) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_chladni"));
    command.args(["--quiet", "dance", "--size", "32x32", "--duration", "0.1", "-k", "4", "--draw", "cpu"]);
    let output = command.args(arguments).current_dir(folder).output().unwrap();
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
}

/// A fifth of a second of sound.
fn hum(path: &Path) {
    let song = Song { rate_hz: 8_000, left: vec![0.5; 1_600], right: vec![0.5; 1_600] };
    write_wav(path, &song, WavSample::Int16).unwrap();
}

#[test]
fn files_are_read_and_made_by_whatever_name() {
    if !chladni_view::ffmpeg_is_there() {
        return println!("skipped: no ffmpeg");
    }
    let png = Picture::filled(16, 16, [128, 128, 128, 255]).to_png().unwrap();
    for name in ["-y", "$(touch x)", "|x", "concat:a|b", "pipe:1", "a\nb"] {
        let home = tempfile::tempdir().unwrap();
        let folder = home.path();
        let [mesh, song, picture, film] = ["obj", "wav", "png", "mp4"].map(|kind| format!("{name}.{kind}"));
        ball(&folder.join(&mesh));
        hum(&folder.join(&song));
        std::fs::write(folder.join(&picture), &png).unwrap();
        let names = ["--".to_owned(), mesh.clone(), song.clone()];
        ok(folder, &[&[format!("--picture={picture}"), format!("--output={film}")][..], &names].concat());
        // The film stands behind the next one.
        ok(folder, &[&[format!("--picture={film}"), "--output=next.mp4".to_owned()][..], &names].concat());
        let there = std::fs::read_dir(folder).unwrap();
        let there: BTreeSet<String> =
            there.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        assert_eq!(there, BTreeSet::from([mesh, song, picture, film, "next.mp4".to_owned()]));
    }
}
