//! Files that are opened, refused and remembered.

use chladni_music::{Action, FileRef, GalleryShape, Instrument, LoggedAction, SongRef, Switch};

use super::*;

#[test]
fn what_cannot_be_opened_is_told_and_the_dance_goes_on() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    chladni_mesh::save_mesh(&chladni_mesh::samples::icosphere(2), &path("ball.obj")).unwrap();
    std::fs::write(path("six.toml"), "format_version = 1\nseed = 3\nsize = 6\n").unwrap();
    std::fs::write(path("broken.mp3"), b"no music at all").unwrap();
    std::fs::write(path("broken.toml"), "format_version = 1\nname = 3\n").unwrap();
    std::fs::write(path("newer.toml"), "format_version = 99\n").unwrap();
    let strange = "[[actions]]\nat_secs = 0.0\nat_beat = 0.0\ndo = \"dive\"\n";
    std::fs::write(path("strange.toml"), format!("format_version = 1\nseed = 3\nsize = 6\n{strange}"))
        .unwrap();
    std::fs::write(path("broken.obj"), "v 0 0 nan\nf 1 2 3\n").unwrap();
    let answers = Answers::default();
    let chooser = Box::new(answers.clone());
    let files = vec![path("ball.obj"), path("six.toml")];
    let mut window = open(
        Opening { folders: folders(folder.path()), chooser, files, ..Opening::default() },
        [1000.0, 640.0],
    );
    wait(&mut window, "the ball", |w| shows(w, "6 items"));
    for (name, message) in [
        ("missing.wav", "missing.wav"),
        ("broken.mp3", "broken.mp3"),
        ("broken.toml", "broken.toml"),
        ("newer.toml", "99"),
        ("strange.toml", "dive"),
        ("broken.obj", "broken.obj"),
        ("missing.obj", "missing.obj"),
    ] {
        answers.add(path(name));
        window.key_press_modifiers(Modifiers::COMMAND, Key::O);
        wait(&mut window, &format!("word of {name}"), |w| shows(w, message));
        assert!(is_there(&window, "dance/6"), "{name} took the gallery away");
    }
    screenshot(&mut window, "window-music-trouble.png");
    // A good song after bad ones plays.
    let second = vec![0.25; 44_100];
    let song = Song { rate_hz: 44_100, left: second.clone(), right: second };
    write_wav(&path("good.wav"), &song, WavSample::Int16).unwrap();
    answers.add(path("good.wav"));
    window.key_press_modifiers(Modifiers::COMMAND, Key::O);
    wait(&mut window, "the good song", |w| w.query_by_label("good").is_some());
}

#[test]
fn songs_looks_harmonics_and_a_caricature_whose_layers_are_voices() {
    let folder = tempfile::tempdir().unwrap();
    let answers = Answers::default();
    let chooser = Box::new(answers.clone());
    let mut window = enter(Opening { folders: folders(folder.path()), chooser, ..Opening::default() });
    click(&mut window, "drawer/songs");
    assert!(shows(&window, "sample tune"));
    let songs = ["first.wav", "second.wav"].map(|name| folder.path().join(name));
    for song in &songs {
        let second = vec![0.0; 44_100];
        let silence = Song { rate_hz: 44_100, left: second.clone(), right: second };
        write_wav(song, &silence, WavSample::Int16).unwrap();
        answers.add(song.clone());
    }
    click(&mut window, "songs-add");
    assert!(shows(&window, "first") && shows(&window, "second") && !shows(&window, "Remove sample tune"));
    screenshot(&mut window, "window-music-songs.png");
    click(&mut window, "song-remove/1");
    assert!(!shows(&window, "Remove first") && shows(&window, "Remove second"));

    click(&mut window, "drawer/look");
    click(&mut window, "material/bronze");
    click(&mut window, "background/slate");
    window.run_steps(2);
    screenshot(&mut window, "window-music-look.png");

    let project = folder.path().join("wild.chladni");
    let run = |arguments: &[&str]| chladni_program::cli::run(["chladni", "--quiet"].iter().chain(arguments));
    let path = project.to_str().unwrap();
    assert_eq!(run(&["project", "new", "sample:head", "-o", path, "--harmonics", "48"]), 0);
    for mu in ["-2", "1.5"] {
        assert_eq!(run(&["project", "add-layer", path, "--template", "ellipsoid", "--mu", mu]), 0);
    }
    answers.add(project);
    click(&mut window, "file");
    click(&mut window, "file/open");
    click(&mut window, "drawer/body");
    wait(&mut window, "the voices", |w| w.query_all_by_label("Beat").count() == 2);
    screenshot(&mut window, "window-music-voices.png");
    click(&mut window, "show-harmonics");
    window.run_steps(2);
    assert!(shows(&window, "Extrema and their") && shows(&window, "antisymmetric"));
    screenshot(&mut window, "window-music-harmonics.png");
    wait(&mut window, "rest", |w| !pause(w).is_zero());
    window.key_press(Key::Escape);
    window.run_steps(2);
    assert!(is_there(&window, "dance/1"));
}

#[test]
fn a_show_opens_with_its_shape_its_songs_its_look_and_its_view() {
    let folder = tempfile::tempdir().unwrap();
    let trace = Trace::default();
    let (mut window, answers) = recorded(folder.path(), &trace);
    click(&mut window, "drawer/look");
    click(&mut window, "material/clay");
    point_at(&mut window, "dance/3");
    window.key_press(Key::F);
    run_for(&mut window, 0.3);
    let show_file = folder.path().join("evening.toml");
    answers.add(show_file.clone());
    window.key_press_modifiers(Modifiers::COMMAND, Key::S);
    window.run_steps(3);
    drop(window);
    // In another window, with other preferences and on another shape.
    let elsewhere = tempfile::tempdir().unwrap();
    let chooser = Box::new(answers.clone());
    let folders = folders(elsewhere.path());
    let again = Trace::default();
    let opening = Opening { folders, chooser, trace: Some(again.clone()), ..Opening::default() };
    let mut window = enter(opening);
    answers.add(show_file.clone());
    window.key_press_modifiers(Modifiers::COMMAND, Key::O);
    wait(&mut window, "the song of the show", |w| w.query_by_label("song").is_some());
    wait(&mut window, "what it sounds like", |_| again.borrow().last().is_some_and(|frame| frame.is_known));
    click(&mut window, "drawer/shelf");
    assert!(shows(&window, "Keep on the shelf: Dance 3"));
    answers.add(folder.path().join("later.toml"));
    window.key_press_modifiers(Modifiers::COMMAND, Key::S);
    window.run_steps(3);
    let [before, after] =
        [show_file, folder.path().join("later.toml")].map(|path| Show::load(&path).unwrap());
    assert_eq!(before.body, after.body);
    assert_eq!((before.harmonics, before.looks, before.songs), (after.harmonics, after.looks, after.songs));
    assert_eq!((before.actions, before.viewpoint), (after.actions, after.viewpoint));
    assert_eq!(before.heard[..], after.heard[..before.heard.len()]);
    assert!(after.duration_secs > before.duration_secs);
}

#[test]
fn every_format_that_is_decoded_is_offered_and_volume_and_device_are_chosen_and_remembered() {
    let folder = tempfile::tempdir().unwrap();
    let answers = Answers::default();
    let chooser = Box::new(answers.clone());
    let folders = folders(folder.path());
    let settings = folders.settings.clone().unwrap();
    let mut window = enter(Opening { folders, chooser, ..Opening::default() });
    window.key_press_modifiers(Modifiers::COMMAND, Key::O);
    window.run_steps(2);
    let offered = answers.offered();
    for format in
        ["wav", "aiff", "flac", "mp3", "ogg", "opus", "m4a", "mka", "webm", "obj", "toml", "chladni"]
    {
        assert!(offered.iter().any(|known| known == format), "{format} is not offered");
    }
    click(&mut window, "drawer/songs");
    for (slider, typed) in [("Volume", "0,25"), ("Crossfade", "3")] {
        window.get_by_role_and_label(Role::SpinButton, slider).focus();
        window.run_steps(2);
        window.get_by_role_and_label(Role::SpinButton, slider).type_text(typed);
        window.key_press(Key::Enter);
        window.run_steps(3);
    }
    assert!(shows(&window, "The system's own"));
    screenshot(&mut window, "window-music-sound.png");
    wait(&mut window, "the preferences", |_| {
        let kept = std::fs::read_to_string(&settings).unwrap();
        kept.contains("volume = 0.25") && kept.contains("song_fade_secs = 3.0")
    });
}

#[test]
fn a_show_is_opened_once_it_is_known_what_becomes_of_unsaved_favorites() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    std::fs::write(path("six.toml"), "format_version = 1\nseed = 3\nsize = 6\n").unwrap();
    let answers = Answers::default();
    let chooser = Box::new(answers.clone());
    let mut window = enter(Opening { folders: folders(folder.path()), chooser, ..Opening::default() });
    let ask = |window: &mut Window| {
        answers.add(path("six.toml"));
        window.key_press_modifiers(Modifiers::COMMAND, Key::O);
        window.run_steps(3);
        shows(window, "Save before opening another?")
    };
    point_at(&mut window, "dance/3");
    window.key_press(Key::F);
    window.run_steps(2);
    assert!(ask(&mut window) && shows(&window, "with one favorite") && is_there(&window, "dance/12"));
    click(&mut window, "keep-working");
    assert!(is_there(&window, "dance/12"));
    assert!(ask(&mut window));
    answers.add(path("evening.toml"));
    click(&mut window, "save-first");
    wait(&mut window, "the show", |w| shows(w, "6 items"));
    assert!(Show::load(&path("evening.toml")).unwrap().actions.len() == 1);
    assert!(!ask(&mut window), "nothing is unsaved");
}

#[test]
fn the_dance_goes_on_while_the_place_of_a_show_is_chosen() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let trace = Trace::default();
    let (mut window, answers) = recorded(folder.path(), &trace);
    std::fs::write(path("six.toml"), "format_version = 1\nseed = 3\nsize = 6\n").unwrap();
    point_at(&mut window, "dance/3");
    window.key_press(Key::F);
    window.run_steps(2);
    answers.add(path("six.toml"));
    window.key_press_modifiers(Modifiers::COMMAND, Key::O);
    wait(&mut window, "the question", |w| shows(w, "Save before opening another?"));
    answers.add(path("evening.toml"));
    answers.hesitate(true);
    click(&mut window, "save-first");
    let before = trace.borrow().len();
    window.run_steps(10);
    assert!(trace.borrow().len() >= before + 10, "the window waits");
    assert!(is_there(&window, "dance/12") && !shows(&window, "Save before opening another?"));
    answers.hesitate(false);
    wait(&mut window, "the show", |w| shows(w, "6 items"));
    assert!(path("evening.toml").exists());
}

#[test]
fn songs_of_a_long_list_that_are_out_of_sight_are_not_drawn() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let [ball, _] = ball_and_song(folder.path());
    let second = vec![0.0; 44_100];
    let silence = Song { rate_hz: 44_100, left: second.clone(), right: second };
    let mut files = vec![ball];
    for song in 1..=40 {
        files.push(path(&format!("{song:02}.wav")));
        write_wav(&files[song], &silence, WavSample::Int16).unwrap();
    }
    let mut window = enter(Opening { folders: folders(folder.path()), files, ..Opening::default() });
    click(&mut window, "drawer/songs");
    assert!(is_there(&window, "song-remove/1") && !is_there(&window, "song-remove/40"));
    control(&window, "song/40").scroll_to_me();
    wait(&mut window, "the last song", |w| is_there(w, "song-remove/40"));
    assert!(!is_there(&window, "song-remove/1"));
}

#[test]
fn songs_that_are_added_come_at_the_end_of_what_plays() {
    let folder = tempfile::tempdir().unwrap();
    let [ball, song] = ball_and_song(folder.path());
    let second = folder.path().join("second.wav");
    std::fs::copy(&song, &second).unwrap();
    let answers = Answers::default();
    let chooser = Box::new(answers.clone());
    let files = vec![ball, song];
    let mut window = enter(Opening { folders: folders(folder.path()), files, chooser, ..Opening::default() });
    click(&mut window, "drawer/songs");
    wait(&mut window, "its song", |w| is_there(w, "song/1") && is_chosen(w, "song/1"));
    // However long this takes, no song ends.
    click(&mut window, "repeat/song");
    answers.add(second);
    click(&mut window, "songs-add");
    wait(&mut window, "the second song", |w| is_there(w, "song/2"));
    window.run_steps(20);
    assert!(is_chosen(&window, "song/1") && !is_chosen(&window, "song/2"));
}

#[test]
fn songs_that_are_opened_with_a_show_come_behind_its_own() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let [ball, song] = ball_and_song(folder.path());
    let side = vec![0.0; 120 * 22_050];
    let silence = Song { rate_hz: 22_050, left: side.clone(), right: side };
    for wav in [song, path("other.wav")] {
        write_wav(&wav, &silence, WavSample::Int16).unwrap();
    }
    // Its shape is another one, which has to be loaded first.
    chladni_mesh::save_mesh(&chladni_mesh::samples::icosphere(2), &path("round.obj")).unwrap();
    let shape = GalleryShape { eigenvalues: (0..96).map(f64::from).collect(), bands: 32 };
    let file = |name: &str| FileRef { path: name.into(), blake3: None };
    let show = Show {
        body: Some(file("round.obj")),
        songs: vec![SongRef::of(file("song.wav"))],
        ..Show::of(&Instrument::new(3, 6, shape).unwrap())
    };
    show.save(&path("evening.toml")).unwrap();
    let files = vec![ball, path("evening.toml"), path("other.wav")];
    let opening = Opening { folders: folders(folder.path()), files, ..Opening::default() };
    let mut window = open(opening, [1000.0, 640.0]);
    wait(&mut window, "the show", |w| shows(w, "6 items"));
    click(&mut window, "drawer/songs");
    // However long the rest takes, no song ends.
    click(&mut window, "repeat/song");
    assert!(shows(&window, "Remove song") && shows(&window, "Remove other"));
    // The show's own is the one that plays.
    wait(&mut window, "its song", |w| is_chosen(w, "song/1"));
    window.run_steps(20);
    assert!(is_chosen(&window, "song/1") && !is_chosen(&window, "song/2"));
}

#[test]
fn a_show_is_saved_under_a_name_that_opens_again() {
    let (folder, answers) = (tempfile::tempdir().unwrap(), Answers::default());
    let (folders, chooser) = (folders(folder.path()), Box::new(answers.clone()));
    let mut window = enter(Opening { folders, chooser, ..Opening::default() });
    answers.add(folder.path().join("gig 3.5"));
    window.key_press_modifiers(Modifiers::COMMAND, Key::S);
    wait(&mut window, "the show", |_| folder.path().join("gig 3.5.toml").exists());
    assert!(!folder.path().join("gig 3.5").exists());
}

#[test]
fn what_was_begun_with_a_dance_ends_where_another_show_comes() {
    let (folder, answers) = (tempfile::tempdir().unwrap(), Answers::default());
    let (folders, chooser) = (folders(folder.path()), Box::new(answers.clone()));
    let mut window = enter(Opening { folders, chooser, ..Opening::default() });
    let show = folder.path().join("empty.toml");
    saved_show(&mut window, &answers, &show);
    point_at(&mut window, "dance/4");
    window.key_press(Key::E);
    window.run_steps(3);
    click(&mut window, "keep");
    assert!(is_there(&window, "shelf/keep"));
    answers.add(show);
    window.key_press_modifiers(Modifiers::COMMAND, Key::O);
    wait(&mut window, "the other show", |w| !is_there(w, "shelf/keep"));
}

#[test]
fn a_sheet_in_place_of_a_body_is_strewn_at_that_moment() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let trace = Trace::default();
    let (mut window, answers) = recorded(folder.path(), &trace);
    wait(&mut window, "some of the song", |_| trace.borrow().last().is_some_and(|frame| frame.at_secs > 0.2));
    point_at(&mut window, "dance/3");
    window.key_press(Key::F);
    window.run_steps(2);
    click(&mut window, "drawer/knobs");
    assert!(!is_chosen(&window, "form/modal"));
    chladni_mesh::save_mesh(&chladni_mesh::samples::grid_square(12), &path("sheet.obj")).unwrap();
    answers.add(path("sheet.obj"));
    window.key_press_modifiers(Modifiers::COMMAND, Key::O);
    wait(&mut window, "the sheet", |w| is_there(w, "form/modal") && is_chosen(w, "form/modal"));
    let actions = saved_show(&mut window, &answers, &path("sheet.toml")).actions;
    let strewn = |action: &Action| *action == Action::Switch { switch: Switch::Sand, on: true };
    assert!(actions.iter().any(|line| strewn(&line.action)));
    let times: Vec<f64> = actions.iter().map(|line| line.moment.at_secs).collect();
    assert!(times[0] > 0.2 && times.is_sorted(), "{times:?}");
}

#[test]
fn a_project_with_a_song_dances_to_it() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let [_, song] = ball_and_song(folder.path());
    let project = chladni_caricature::Project::new(chladni_mesh::ShapeSource::File(path("ball.obj")), 64);
    project.save(&path("ball.chladni")).unwrap();
    let files = vec![path("ball.chladni"), song];
    let mut window = enter(Opening { folders: folders(folder.path()), files, ..Opening::default() });
    wait(&mut window, "the song", |w| w.query_by_label("song").is_some());
    assert!(is_there(&window, "dance/12"));
}

#[test]
fn the_dance_goes_on_while_files_are_chosen() {
    let folder = tempfile::tempdir().unwrap();
    let trace = Trace::default();
    let (mut window, answers) = recorded(folder.path(), &trace);
    answers.add("sample:cat");
    answers.hesitate(true);
    window.key_press_modifiers(Modifiers::COMMAND, Key::O);
    window.run_steps(2);
    let before = trace.borrow().len();
    window.run_steps(10);
    assert!(trace.borrow().len() >= before + 10, "the window waits");
    window.key_press_modifiers(Modifiers::COMMAND, Key::O);
    window.run_steps(2);
    assert!(shows(&window, "open already"));
    answers.hesitate(false);
    wait(&mut window, "the cat", |w| shows(w, "Opening"));
}

#[test]
fn a_program_that_is_asked_to_end_closes_its_window() {
    let folder = tempfile::tempdir().unwrap();
    let (files, ends) = (ball_and_song(folder.path()).to_vec(), chladni_task::Task::new());
    let opening =
        Opening { folders: folders(folder.path()), files, ends: Some(ends.clone()), ..Opening::default() };
    let mut window = enter(opening);
    window.run_steps(3);
    assert!(!closes(&window));
    ends.cancel();
    window.run_steps(1);
    assert!(closes(&window));
}

/// Shows that were left in the folder of recovery copies.
pub fn shows_in(folder: &Path) -> Vec<std::path::PathBuf> {
    let entries = std::fs::read_dir(folder.join("recovery")).into_iter().flatten().flatten();
    entries
        .map(|entry| entry.path())
        .filter(|path| path.extension().is_some_and(|end| end == "toml"))
        .collect()
}

#[test]
fn a_show_survives_a_crash_and_a_request_to_end() {
    let folder = tempfile::tempdir().unwrap();
    let home = folder.path();
    let ends = chladni_task::Task::new();
    let opening = |files: Vec<std::path::PathBuf>| Opening {
        folders: Folders { recovery: Some(home.join("recovery")), ..folders(home) },
        files,
        ends: Some(ends.clone()),
        now: no_time,
        ..Opening::default()
    };
    let mut window = enter(opening(ball_and_song(home).to_vec()));
    point_at(&mut window, "dance/3");
    window.key_press(Key::F);
    wait(&mut window, "a copy", |_| shows_in(home).len() == 1);
    // Nobody tells the window that it ends: a crash.
    drop(window);
    wait_until_left(&home.join("recovery"), "show", "toml");

    let mut window = open(opening(Vec::new()), [1000.0, 640.0]);
    window.run_steps(3);
    assert!(shows(&window, "The last show did not end well"));
    screenshot(&mut window, "window-music-recover.png");
    click(&mut window, "recover-show");
    wait(&mut window, "the gallery", |w| shows(w, "12 items") && !shows(w, "Opening"));
    let old = shows_in(home);
    wait(&mut window, "a copy of its own", |_| shows_in(home).len() == 1 && shows_in(home) != old);
    ask_to_close(&mut window);
    assert!(shows(&window, "with one favorite"));
    click(&mut window, "keep-working");
    point_at(&mut window, "dance/5");
    window.key_press(Key::F);
    window.run_steps(2);
    // Actions since the last copy are kept, too.
    ends.cancel();
    window.run_steps(1);
    assert!(closes(&window));
    drop(window);
    let kept = Show::load(&shows_in(home)[0]).unwrap();
    let favorites = kept.actions.iter().filter(|line| matches!(line.action, Action::Favorite { .. }));
    assert_eq!(favorites.count(), 2);
}

#[test]
fn the_copy_of_a_show_follows_the_shape_that_dances() {
    let folder = tempfile::tempdir().unwrap();
    let home = folder.path();
    let round = home.join("round.obj");
    chladni_mesh::save_mesh(&chladni_mesh::samples::icosphere(2), &round).unwrap();
    let opening = Opening {
        folders: Folders { recovery: Some(home.join("recovery")), ..folders(home) },
        files: ball_and_song(home).to_vec(),
        now: no_time,
        ..Opening::default()
    };
    let mut window = enter(opening);
    point_at(&mut window, "dance/3");
    window.key_press(Key::F);
    let copy_has = |body: &str| {
        let copy = shows_in(home).pop().and_then(|path| Show::load(&path).ok());
        copy.and_then(|show| show.body).is_some_and(|file| file.path.ends_with(body))
    };
    wait(&mut window, "a copy", |_| copy_has("ball.obj"));
    drop_files(&mut window, &[round]);
    wait(&mut window, "a copy with the other shape", |_| copy_has("round.obj"));
}

#[test]
fn the_last_action_before_the_room_is_left_is_in_the_copy() {
    let folder = tempfile::tempdir().unwrap();
    let home = folder.path();
    let opening = Opening {
        folders: Folders { recovery: Some(home.join("recovery")), ..folders(home) },
        files: ball_and_song(home).to_vec(),
        now: no_time,
        ..Opening::default()
    };
    // In short frames, so that the room is left before the next copy is due.
    let builder = Harness::builder().with_size([1000.0, 640.0]).with_step_dt(1.0 / 60.0);
    let mut window = open_with(opening, builder);
    wait(&mut window, "the gallery", |w| shows(w, "12 items"));
    window.run_steps(3);
    let is_kept = |favorites: usize| {
        let copy = shows_in(home).pop().and_then(|path| Show::load(&path).ok());
        let is_favorite = |line: &&LoggedAction| matches!(line.action, Action::Favorite { .. });
        copy.is_some_and(|show| show.actions.iter().filter(is_favorite).count() == favorites)
    };
    point_at(&mut window, "dance/3");
    window.key_press(Key::F);
    window.run_steps(130);
    wait(&mut window, "a copy", |_| is_kept(1));
    point_at(&mut window, "dance/5");
    window.key_press(Key::F);
    window.get_by_role_and_label(Role::Button, "Chladni").click();
    window.run_steps(130);
    wait(&mut window, "a copy of all", |_| is_kept(2));
    assert!(shows(&window, "What would you like to play?"));
}

#[test]
fn a_recovered_show_whose_shape_does_not_open_is_not_thrown_away() {
    stays_where_its_shape(|ball| std::fs::write(ball, "v 0 0 0\nf 1 2 3\n").unwrap());
}

#[test]
fn a_recovered_show_whose_shape_is_missing_is_not_thrown_away() {
    stays_where_its_shape(|ball| std::fs::remove_file(ball).unwrap());
}

/// Recovers a show whose shape was made unreadable by `spoil`.
fn stays_where_its_shape(spoil: impl Fn(&Path)) {
    let folder = tempfile::tempdir().unwrap();
    let home = folder.path();
    let opening = |files: Vec<std::path::PathBuf>| Opening {
        folders: Folders { recovery: Some(home.join("recovery")), ..folders(home) },
        files,
        now: no_time,
        ..Opening::default()
    };
    let [ball, song] = ball_and_song(home);
    let mut window = enter(opening(vec![ball.clone(), song]));
    point_at(&mut window, "dance/3");
    window.key_press(Key::F);
    wait(&mut window, "a copy", |_| shows_in(home).len() == 1);
    drop(window);
    wait_until_left(&home.join("recovery"), "show", "toml");
    let left = shows_in(home);

    spoil(&ball);
    let mut window = open(opening(Vec::new()), [1000.0, 640.0]);
    window.run_steps(3);
    click(&mut window, "recover-show");
    wait(&mut window, "why it does not open", |w| shows(w, "ball.obj") && is_there(w, "dance/3"));
    point_at(&mut window, "dance/3");
    window.key_press(Key::F);
    wait(&mut window, "a copy of the other show", |_| shows_in(home).iter().any(|path| !left.contains(path)));
    window.run_steps(3);
    assert!(left[0].exists(), "what was not opened is gone");
}
