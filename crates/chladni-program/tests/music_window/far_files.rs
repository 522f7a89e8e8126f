//! Shows that name files which are not there, or which lie on another machine.

use chladni_music::{FileRef, GalleryShape, Instrument, Looks, SongRef};

use super::files::shows_in;
use super::*;

/// Writes a show of the ball in `folder` which names files that are not there, some of them on another machine.
fn show_of_far_files(folder: &Path) -> Show {
    let shape = GalleryShape { eigenvalues: (0..96).map(f64::from).collect(), bands: 32 };
    let file = |name: &str| FileRef { path: name.into(), blake3: None };
    let show = Show {
        body: Some(file("ball.obj")),
        songs: ["songs/gone.wav", r"\\server\share\b.wav"].map(|song| SongRef::of(file(song))).into(),
        looks: Some(Looks {
            picture: "gone.png".into(),
            panorama: r"\\server\share\sky.hdr".into(),
            ..Looks::default()
        }),
        ..Show::of(&Instrument::new(3, 6, shape).unwrap())
    };
    show.save(&folder.join("evening.toml")).unwrap();
    show
}

/// Saves the show that is open under another name: it names all as `show` does, and the window warns.
fn keeps_names(window: &mut Window, answers: &Answers, folder: &Path, show: &Show) {
    let again = saved_show(window, answers, &folder.join("later.toml"));
    assert_eq!(again.songs.get(..2), Some(&show.songs[..]));
    let looks = again.looks.unwrap();
    assert!(looks.picture == "gone.png" && looks.panorama == r"\\server\share\sky.hdr", "{looks:?}");
    assert!(again.far.is_empty(), "only a copy says so twice");
    wait(window, "the warning", |w| shows(w, r"which will not find \\server\share\sky.hdr"));
}

#[test]
fn files_of_a_show_that_are_not_there_now_keep_their_names() {
    let (folder, answers) = (tempfile::tempdir().unwrap(), Answers::default());
    let [ball, _] = ball_and_song(folder.path());
    let show = show_of_far_files(folder.path());
    let (folders, chooser) = (folders(folder.path()), Box::new(answers.clone()));
    let files = vec![ball, folder.path().join("evening.toml")];
    let mut window = open(Opening { folders, chooser, files, ..Opening::default() }, [1000.0, 640.0]);
    wait(&mut window, "the show", |w| shows(w, "6 items"));
    keeps_names(&mut window, &answers, folder.path(), &show);
}

#[test]
fn they_keep_them_after_a_crash_too() {
    let (folder, answers) = (tempfile::tempdir().unwrap(), Answers::default());
    let home = folder.path();
    let opening = |files: Vec<std::path::PathBuf>| Opening {
        folders: Folders { recovery: Some(home.join("recovery")), ..folders(home) },
        chooser: Box::new(answers.clone()),
        files,
        now: no_time,
        ..Opening::default()
    };
    let [ball, _] = ball_and_song(home);
    let show = show_of_far_files(home);
    let mut window = open(opening(vec![ball, home.join("evening.toml")]), [1000.0, 640.0]);
    wait(&mut window, "the show", |w| shows(w, "6 items"));
    window.run_steps(3);
    point_at(&mut window, "dance/3");
    window.key_press(Key::F);
    wait(&mut window, "a copy", |_| shows_in(home).len() == 1);
    // Nobody tells the window that it ends: a crash.
    drop(window);
    wait_until_left(&home.join("recovery"), "show", "toml");

    let mut window = open(opening(Vec::new()), [1000.0, 640.0]);
    window.run_steps(3);
    click(&mut window, "recover-show");
    wait(&mut window, "the show", |w| shows(w, "6 items") && !shows(w, "Opening"));
    keeps_names(&mut window, &answers, home, &show);
}

#[test]
fn only_a_copy_of_our_own_may_say_how_else_files_are_named() {
    let (folder, answers) = (tempfile::tempdir().unwrap(), Answers::default());
    let [ball, _] = ball_and_song(folder.path());
    let mut show = show_of_far_files(folder.path());
    let place = folder.path().join("songs/gone.wav").to_str().unwrap().to_owned();
    show.far = [(place, FileRef { path: r"\\server\share\other.wav".into(), blake3: None })].into();
    let path = folder.path().join("evening.toml");
    show.save(&path).unwrap();
    let (folders, chooser) = (folders(folder.path()), Box::new(answers.clone()));
    let opening = Opening { folders, chooser, files: vec![ball, path], ..Opening::default() };
    let mut window = open(opening, [1000.0, 640.0]);
    wait(&mut window, "the show", |w| shows(w, "6 items"));
    keeps_names(&mut window, &answers, folder.path(), &show);
}

/// A song with such a name can lie beside a show where that is no path.
#[cfg(unix)]
#[test]
fn a_song_that_another_system_would_look_for_on_another_machine_is_saved_with_a_warning() {
    let (folder, answers) = (tempfile::tempdir().unwrap(), Answers::default());
    let [ball, song] = ball_and_song(folder.path());
    // A name, not a path: only Windows looks for it elsewhere.
    let name = r"\\server\share\a.wav".to_owned();
    let far = folder.path().join(name);
    std::fs::rename(song, &far).unwrap();
    let (folders, chooser) = (folders(folder.path()), Box::new(answers.clone()));
    let (trace, files) = (Trace::default(), vec![ball, far]);
    let opening = Opening { folders, chooser, files, trace: Some(trace.clone()), ..Opening::default() };
    let mut window = enter(opening);
    wait(&mut window, "the song", |_| trace.borrow().last().is_some_and(|frame| frame.is_known));
    run_for(&mut window, 0.3);
    let show = saved_show(&mut window, &answers, &folder.path().join("set.toml"));
    assert!(show.songs.iter().any(|song| song.path == r"\\server\share\a.wav"), "{:?}", show.songs);
    wait(&mut window, "the warning", |w| shows(w, r"which will not find \\server\share\a.wav"));
}
