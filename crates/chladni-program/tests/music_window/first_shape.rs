//! A room whose first shape cannot be opened.

use super::*;

#[test]
fn a_room_whose_first_shape_cannot_be_opened_asks_for_another() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    chladni_mesh::save_mesh(&chladni_mesh::samples::icosphere(2), &path("ball.obj")).unwrap();
    let second = vec![0.25; 44_100];
    let song = Song { rate_hz: 44_100, left: second.clone(), right: second };
    write_wav(&path("song.wav"), &song, WavSample::Int16).unwrap();
    let answers = Answers::default();
    let (chooser, files) = (Box::new(answers.clone()), vec!["sample:nobody".into(), path("song.wav")]);
    let opening = Opening { folders: folders(folder.path()), chooser, files, ..Opening::default() };
    let mut window = open(opening, [1000.0, 640.0]);
    wait(&mut window, "word of it", |w| shows(w, "there is no such sample"));
    wait(&mut window, "the way out", |w| shows(w, "Nothing dances yet"));
    screenshot(&mut window, "window-music-nothing.png");
    answers.add(path("ball.obj"));
    click(&mut window, "open");
    wait(&mut window, "the gallery", |w| w.query_by_label_contains("12 items").is_some());
}

#[test]
fn a_show_that_is_opened_where_nothing_dances_brings_a_shape() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    std::fs::write(path("six.toml"), "format_version = 1\nseed = 3\nsize = 6\n").unwrap();
    let [_, song] = ball_and_song(folder.path());
    let answers = Answers::default();
    let (chooser, files) = (Box::new(answers.clone()), vec!["sample:nobody".into(), song]);
    let opening = Opening { folders: folders(folder.path()), chooser, files, ..Opening::default() };
    let mut window = open(opening, [1000.0, 640.0]);
    wait(&mut window, "the way out", |w| shows(w, "Nothing dances yet"));
    answers.add(path("six.toml"));
    click(&mut window, "open");
    wait(&mut window, "the show", |w| shows(w, "6 items"));
}
