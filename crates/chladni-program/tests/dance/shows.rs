//! Films of shows: the options that hold throughout, and the show's own file.

use std::path::Path;

use chladni_music::{
    Action, FileRef, Form, GalleryShape, Instrument, LoggedAction, Moment, Parameter, Settings, SongRef,
    Stretch, Switch,
};
use chladni_program::work::film;
use chladni_sound::{Song, WavSample, write_wav};

use crate::looks::{frame, show};
use crate::{array, ball, run, warnings_of};

/// Shape and values of the coefficients of a show in which `changes` are made after 0.2 s.
fn danced(folder: &Path, changes: &[Action], start: &str, more: &[&str]) -> (Vec<u64>, Vec<f64>) {
    ball(&folder.join("ball.obj"));
    let mut show = show("ember", None);
    let moment = Moment { at_secs: 0.2, at_beat: 0.0 };
    show.actions.extend(changes.iter().map(|action| LoggedAction { moment, action: action.clone() }));
    let [file, npz] = ["a.show.toml", "a.npz"].map(|name| folder.join(name));
    show.save(&file).unwrap();
    let [file_name, npz_name] = [&file, &npz].map(|path| path.to_str().unwrap());
    let dance = ["dance", "--show", file_name, "--coefficients", npz_name, "-k", "16"];
    let part = ["--start", start, "--duration", "0.4", "--fps", "10"];
    assert_eq!(run(&[&dance[..], &part, more].concat()), 0, "{more:?}");
    array(&npz, "coefficients")
}

#[test]
fn options_hold_throughout_a_show() {
    let folder = tempfile::tempdir().unwrap();
    let danced = |changes: &[Action], more: &[&str]| danced(folder.path(), changes, "6", more);
    // A preset that is taken sets knobs, too.
    let shape = GalleryShape { eigenvalues: (0..16).map(f64::from).collect(), bands: 32 };
    let instrument = Instrument::new(1, 6, shape).unwrap();
    let mut preset = instrument.preset(&instrument.gallery().items()[0], Vec::new());
    preset.settings = Settings { knobs: [(Parameter::Gain, 0.1)].into(), ..Settings::default() };
    let take = Action::Take { item: 5, preset: Box::new(preset) };
    let plain = danced(&[], &[]);
    for (change, option) in [
        (Action::Set { parameter: Parameter::Gain, value: 0.1 }, ["--gain", "2"]),
        (take, ["--gain", "2"]),
        (Action::Set { parameter: Parameter::Decay, value: 0.9 }, ["--set", "decay=0.1"]),
        (Action::Switch { switch: Switch::Resonate, on: false }, ["--timbre", "rubber"]),
    ] {
        let change = [change];
        assert_ne!(danced(&change, &[]), plain, "{change:?} changes nothing");
        assert_eq!(danced(&change, &option), danced(&[], &option), "{option:?}");
    }
}

#[test]
fn sand_holds_throughout_a_show() {
    let folder = tempfile::tempdir().unwrap();
    let danced = |changes: &[Action], more: &[&str]| danced(folder.path(), changes, "6", more);
    let modal = Action::SetForm { form: Form::Modal };
    let plain = danced(&[], &["--sand"]);
    for change in
        [Action::SetForm { form: Form::HalfMask }, Action::Set { parameter: Parameter::Gain, value: 2.0 }]
    {
        let [one, both] = [vec![modal.clone()], vec![modal.clone(), change.clone()]];
        assert_ne!(danced(&both, &[]), danced(&one, &[]), "{change:?} changes nothing");
        assert_eq!(danced(&[change], &["--sand"]), plain);
    }
}

#[test]
fn a_knob_that_the_form_ignores_is_warned_of() {
    let folder = tempfile::tempdir().unwrap();
    let mesh = folder.path().join("ball.obj");
    ball(&mesh);
    let output = film::Output { coefficients: Some(folder.path().join("c.npz")), ..film::Output::nowhere() };
    let changes = vec![Action::Set { parameter: Parameter::StereoMu, value: 1.0 }];
    let beginning = film::Beginning { changes, ..film::Beginning::default() };
    let mut film = film::Film::new(mesh.display().to_string(), "sample:tune".into(), beginning, output);
    (film.harmonics, film.duration_secs) = (Some(24), Some(0.1));
    let said = warnings_of(film);
    assert!(said.iter().any(|warning| warning.contains("Without effect in halves")), "{said:?}");
}

#[test]
fn a_shape_stands_as_its_show_says_unless_the_command_or_another_shape_does() {
    let folder = tempfile::tempdir().unwrap();
    let bell = Some(FileRef { path: "sample:bell".into(), blake3: None });
    let upright = chladni_music::Show { body: bell, ..show("ember", None) };
    let upside_down = chladni_mesh::Orientation::new([0.0, -1.0, 0.0], [0.0, 0.0, 1.0]);
    let turned = chladni_music::Show { stands: upside_down, ..upright.clone() };
    let of = |show: &chladni_music::Show, more: &[&str]| frame(folder.path(), show, "0", more);
    let seen = of(&upright, &[]);
    assert!(of(&turned, &[]) != seen);
    assert!(of(&turned, &["--up", "y", "--front", "z"]) == seen);
    assert!(of(&turned, &["sample:bell"]) == seen);
}

/// A song of `secs` that clicks every `gap_secs`.
fn clicks(path: &Path, secs: usize, gap_secs: f64) {
    let rate_hz = 22_050;
    let mut left = vec![0.0f32; secs * rate_hz as usize];
    let step = (gap_secs * f64::from(rate_hz)) as usize;
    left.iter_mut().step_by(step).for_each(|sample| *sample = 0.9);
    write_wav(path, &Song { rate_hz, right: left.clone(), left }, WavSample::Int16).unwrap();
}

#[test]
fn a_film_that_begins_in_a_later_song_has_the_beats_of_the_whole_one() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    ball(Path::new(&path("ball.obj")));
    clicks(Path::new(&path("first.wav")), 6, 0.5);
    clicks(Path::new(&path("second.wav")), 9, 0.6);
    let song = |name: &str| SongRef::of(FileRef { path: name.to_owned(), blake3: None });
    let first = Stretch { at_secs: 0.0, song: Some(0), song_secs: 0.0, playing: true, crossfade_secs: 0.0 };
    let at = |at_secs, action| LoggedAction { moment: Moment { at_secs, at_beat: 0.0 }, action };
    let show = chladni_music::Show {
        songs: ["first.wav", "second.wav"].map(song).to_vec(),
        heard: vec![first, Stretch { at_secs: 5.0, song: Some(1), ..first }],
        duration_secs: Some(13.0),
        actions: vec![
            at(0.0, Action::Favorite { item: 0, on: true }),
            at(0.0, Action::Favorite { item: 3, on: true }),
            at(0.0, Action::Switch { switch: Switch::BeatSteps, on: true }),
            at(0.0, Action::Set { parameter: Parameter::BeatsPerStep, value: 4.0 }),
            at(3.0, Action::PerformFavorites { first: 0 }),
        ],
        ..show("ember", None)
    };
    let (file, npz) = (path("a.show.toml"), path("a.npz"));
    show.save(Path::new(&file)).unwrap();
    // A power of two, at which the times of both films are the same to the last bit.
    let dance = ["dance", "--show", &file, "--coefficients", &npz, "-k", "16", "--fps", "8"];
    let danced = |more: &[&str]| {
        assert_eq!(run(&[&dance[..], more].concat()), 0, "{more:?}");
        array(Path::new(&npz), "coefficients").1
    };
    let (whole, part) = (danced(&[]), danced(&["--start", "11"]));
    assert_eq!(whole.len() / 13, part.len() / 2);
    assert!(part.iter().any(|c| *c != 0.0));
    assert!(part == whole[whole.len() - part.len()..], "other dances than those of the whole film");
}

#[test]
fn a_song_that_is_not_heard_in_a_film_may_be_missing() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    ball(Path::new(&path("ball.obj")));
    let mut show = show("ember", None);
    show.songs.push(SongRef::of(FileRef { path: "gone.wav".to_owned(), blake3: None }));
    let (file, npz) = (path("a.show.toml"), path("a.npz"));
    let dance = ["dance", "--show", &file, "--coefficients", &npz, "-k", "16", "--duration", "0.2"];
    show.save(Path::new(&file)).unwrap();
    assert_eq!(run(&dance), 0);
    show.heard =
        vec![Stretch { at_secs: 0.0, song: Some(1), song_secs: 0.0, playing: true, crossfade_secs: 0.0 }];
    show.save(Path::new(&file)).unwrap();
    assert_ne!(run(&dance), 0);
}

#[test]
fn the_form_that_is_asked_for_is_that_of_all_frames() {
    let folder = tempfile::tempdir().unwrap();
    let change = [Action::SetForm { form: Form::Filter }];
    assert_eq!(danced(folder.path(), &change, "0", &["--form", "modal"]).0, [4, 16]);
}

#[test]
fn presets_do_not_replace_the_show() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    ball(Path::new(&path("ball.obj")));
    let file = path("item-03.toml");
    show("ember", None).save(Path::new(&file)).unwrap();
    let before = std::fs::read(&file).unwrap();
    let dance = ["dance", "--show", &file, "--presets", &path(""), "--coefficients", &path("a.npz")];
    assert_eq!(run(&[&dance[..], &["-k", "16", "--duration", "0.2"]].concat()), 2);
    assert!(std::fs::read(&file).unwrap() == before && !Path::new(&path("a.npz")).exists());
}
