//! Files whose names look like options, addresses, commands or lines of output.

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

#[test]
fn names_make_no_lines_and_move_no_cursor() {
    let home = tempfile::tempdir().unwrap();
    let folder = home.path();
    let [mesh, song, project, arrays, missing] =
        ["obj", "wav", "chladni", "npz", "ply"].map(|kind| format!("a\n#\u{1b}[2J\u{202e}.{kind}"));
    ball(&folder.join(&mesh));
    hum(&folder.join(&song));
    let commands: [(&[&str], bool); 6] = [
        (&["project", "new", &mesh, "-k", "8", "-o", &project], true),
        (&["project", "add-layer", &project, "--template", "self:scale=0.5", "--mu", "-2"], true),
        (&["project", "show", &project], true),
        (&["project", "show", &project, "--json"], true),
        (&["dance", "--duration", "0.1", "-k", "4", "--coefficients", &arrays, "--", &mesh, &song], true),
        (&["info", &missing], false),
    ];
    for (arguments, succeeds) in commands {
        let mut command = Command::new(env!("CARGO_BIN_EXE_chladni"));
        let output = command.arg("--quiet").args(arguments).current_dir(folder).output().unwrap();
        let printed = [output.stdout, output.stderr].map(|bytes| String::from_utf8(bytes).unwrap()).concat();
        assert_eq!(output.status.success(), succeeds, "{arguments:?}: {printed}");
        assert!(printed.contains("#\\u001b[2J\\u202e."), "{arguments:?}: {printed:?}");
        assert!(
            printed.chars().all(|c| c == '\n' || !(c.is_control() || c == '\u{202e}')),
            "{arguments:?}: {printed:?}"
        );
        assert!(printed.lines().all(|line| !line.starts_with('#')), "{arguments:?}: {printed:?}");
    }
}
