//! Films on a disk that becomes full: an error that says what to do, and all that was there before stays.

#![cfg(target_os = "linux")]
#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "a panic is how a test fails, and a skipped one says so"
)]

use std::fs::File;
use std::io::Write;
use std::path::Path;

use chladni_testdata::{childs_folder, ignored_test, in_shell, on_a_small_disk};
use chladni_view::film::{CutOff, ffmpeg_is_there};
use chladni_view::{Film, FilmSettings, FrameRate, Picture, ViewError};

const FRAMES: u64 = 20;
const BLOCK: u64 = 4096;

/// Runs an ignored test of this file with a disk of 2 MB.
fn on_a_disk(test: &str) {
    on_a_small_disk(2048, &in_shell(&ignored_test(test)));
}

/// Leaves `room` bytes, a whole number of blocks, on the disk.
fn fill(disk: &Path, room: u64) {
    let mut filler = File::create(disk.join("filler")).unwrap();
    while filler.write_all(&[0; BLOCK as usize]).is_ok() {}
    let length = filler.metadata().unwrap().len();
    filler.set_len(length / BLOCK * BLOCK - room).unwrap();
}

/// Amounts of room in which a file of `length` bytes does not fit: none, half of it, and all but its last block.
fn too_little(length: u64) -> [u64; 3] {
    let all_but_one = (length.div_ceil(BLOCK) - 1) * BLOCK;
    [0, length / 2 / BLOCK * BLOCK, all_but_one]
}

fn film(path: &Path) -> Result<(), ViewError> {
    let (width, height, rate) = (96, 64, FrameRate::per_second(20));
    let settings = FilmSettings { width, height, rate, frames: FRAMES, first: 0, audio: None };
    let mut film = Film::create(path, settings)?;
    // Noise, which no format makes small.
    let mut state = chladni_testdata::chance(7);
    let mut chance = || (state() >> 56) as u8;
    for _ in 0..FRAMES {
        let rgba = (0..width * height).flat_map(|_| [chance(), chance(), chance(), 255]).collect();
        film.push(&Picture { width, height, rgba })?;
    }
    film.finish()
}

fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

#[test]
fn a_film_that_does_not_fit_leaves_the_old_one() {
    on_a_disk("films_do_not_fit");
}

#[test]
#[ignore = "run by a_film_that_does_not_fit_leaves_the_old_one"]
fn films_do_not_fit() {
    let Some(disk) = childs_folder() else { return };
    let roomy = tempfile::tempdir().unwrap();
    for name in ["d.mp4", "d.gif", "d.png"] {
        if name == "d.mp4" && !ffmpeg_is_there() {
            println!("skipped: no ffmpeg");
            continue;
        }
        let (path, whole) = (disk.join(name), roomy.path().join(name));
        film(&whole).unwrap();
        std::fs::write(&path, "old").unwrap();
        for room in too_little(whole.metadata().unwrap().len()) {
            fill(&disk, room);
            let said = film(&path).unwrap_err().to_string();
            let all = said.contains(path.to_str().unwrap()) && said.contains("the disk is full: make room");
            assert!(all, "{room} bytes: {said}");
            assert_eq!(std::fs::read(&path).unwrap(), b"old");
            assert_eq!(names(&disk), [name, "filler"]);
        }
        std::fs::remove_file(disk.join("filler")).unwrap();
        film(&path).unwrap();
        assert_eq!(path.metadata().unwrap().len(), whole.metadata().unwrap().len(), "{name}");
        std::fs::remove_file(path).unwrap();
    }
}

#[test]
fn frames_that_do_not_fit_are_named_and_those_before_them_are_whole() {
    on_a_disk("frames_do_not_fit");
}

#[test]
#[ignore = "run by frames_that_do_not_fit_are_named_and_those_before_them_are_whole"]
fn frames_do_not_fit() {
    let Some(disk) = childs_folder() else { return };
    let frames = disk.join("frames");
    std::fs::create_dir(&frames).unwrap();
    std::fs::write(frames.join("frame-00000.png"), "old").unwrap();
    for (room, replaces) in [(0, false), (30 * BLOCK, true)] {
        fill(&disk, room);
        let said = film(&frames).unwrap_err().to_string();
        assert!(said.contains(".png: the disk is full: make room"), "{said}");
        let first = std::fs::read(frames.join("frame-00000.png")).unwrap();
        assert_eq!(first != b"old", replaces);
        for name in names(&frames) {
            let bytes = std::fs::read(frames.join(&name)).unwrap();
            assert!(bytes == b"old" || Picture::decode(&bytes).is_ok(), "{name}");
        }
    }
}

#[test]
fn a_recording_that_does_not_fit_is_kept_until_there_is_room() {
    if !ffmpeg_is_there() {
        return println!("skipped: no ffmpeg");
    }
    on_a_disk("a_recording_does_not_fit");
}

#[test]
#[ignore = "run by a_recording_that_does_not_fit_is_kept_until_there_is_room"]
fn a_recording_does_not_fit() {
    let Some(disk) = childs_folder() else { return };
    let roomy = tempfile::tempdir().unwrap();
    let record = |home: &Path| {
        let folder = home.join(".chladni-recorded");
        std::fs::create_dir(&folder).unwrap();
        film(&folder.join("picture.mp4")).unwrap();
        std::fs::write(folder.join("sound.raw"), [0; 8 * 8000]).unwrap();
        std::fs::write(folder.join("recording.txt"), "8000\nset.mp4\n").unwrap();
        folder
    };
    let length = CutOff::find(&record(roomy.path())).unwrap().save().unwrap().metadata().unwrap().len();
    let folder = record(&disk);
    let before = names(&folder);
    for room in too_little(length) {
        fill(&disk, room);
        let said = CutOff::find(&folder).unwrap().save().unwrap_err().to_string();
        assert!(said.contains("the disk is full: make room"), "{room} bytes: {said}");
        assert_eq!(
            (names(&folder), names(&disk)),
            (before.clone(), vec![".chladni-recorded".to_owned(), "filler".to_owned()])
        );
    }
    std::fs::remove_file(disk.join("filler")).unwrap();
    let film = CutOff::find(&folder).unwrap().save().unwrap();
    assert_eq!(film, disk.join("set (cut off).mp4"));
    assert!(!folder.exists());
}
