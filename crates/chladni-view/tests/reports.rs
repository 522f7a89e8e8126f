//! What the environment asks of ffmpeg stays outside.
#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

use std::path::{Path, PathBuf};
use std::process::Command;

use chladni_view::film::ffmpeg_is_there;
use chladni_view::{Film, FilmSettings, FrameRate, Picture};

const FILM: &str = "CHLADNI_REPORTED_FILM";

fn asked_to_report(mut command: Command, report: &Path) {
    // It wants `:` escaped, which is in no path of a test.
    command.env("FFREPORT", format!("file={}", report.display()));
    assert!(command.output().unwrap().status.success());
}

#[test]
fn ffmpeg_writes_no_report_of_our_films() {
    if !ffmpeg_is_there() {
        return println!("skipped: no ffmpeg");
    }
    let folder = tempfile::tempdir().unwrap();
    let (film, report) = (folder.path().join("film.mp4"), folder.path().join("report"));
    let mut ours = Command::new(std::env::current_exe().unwrap());
    ours.args(["--exact", "a_film_is_made", "--ignored"]).env(FILM, &film);
    asked_to_report(ours, &report);
    assert!(film.is_file() && !report.exists());
    // By itself it writes one.
    let mut alone = Command::new("ffmpeg");
    alone.args(["-v", "quiet", "-f", "lavfi", "-i", "color=s=16x16:d=0.1", "-f", "null", "-"]);
    asked_to_report(alone, &report);
    assert!(report.is_file());
}

#[test]
#[ignore = "run by ffmpeg_writes_no_report_of_our_films"]
fn a_film_is_made() {
    let Some(path) = std::env::var_os(FILM).map(PathBuf::from) else { return };
    let (width, height, rate) = (16, 16, FrameRate::per_second(25));
    let settings = FilmSettings { width, height, rate, frames: 2, first: 0, audio: None };
    let mut film = Film::create(&path, settings).unwrap();
    for _ in 0..2 {
        film.push(&Picture::filled(width, height, [200, 100, 50, 255])).unwrap();
    }
    film.finish().unwrap();
}
