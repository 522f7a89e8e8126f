//! The autopilot: when it takes over, and its keys.

use chladni_music::{Action, Form, GalleryShape, Instrument, Moment, Parameter};
use chladni_program::studio::SetPlan;
use chladni_sound::Capture;

use super::clocks::packet;
use super::*;

/// Goes to a time of the window's clock, which stands still otherwise.
fn go_to(window: &mut Window, secs: f64) {
    window.input_mut().time = Some(secs);
    window.run_steps(1);
}

fn press(window: &mut Window, key: Key) {
    window.key_press(key);
    window.run_steps(3);
}

/// A room on a ball and a song, which is known, at 1 s of a clock that stands still.
fn with_a_song(folder: &Path) -> (Window, Answers) {
    let files = ball_and_song(folder).to_vec();
    let (trace, answers) = (Trace::default(), Answers::default());
    let folders = folders(folder);
    std::fs::write(folders.settings.as_ref().unwrap(), "harmonics = 96\n").unwrap();
    let opening = Opening {
        folders,
        files,
        chooser: Box::new(answers.clone()),
        trace: Some(trace.clone()),
        now: no_time,
        ..Opening::default()
    };
    let mut window = open_with(opening, Harness::builder().with_size([1000.0, 640.0]));
    window.input_mut().time = Some(1.0);
    wait(&mut window, "the gallery", |w| w.query_by_label_contains("12 items").is_some());
    wait(&mut window, "the song", |_| trace.borrow().last().is_some_and(|frame| frame.is_known));
    (window, answers)
}

#[test]
fn a_key_that_acts_keeps_it_from_taking_over() {
    let folder = tempfile::tempdir().unwrap();
    let (mut window, _) = with_a_song(folder.path());
    press(&mut window, Key::ArrowRight);
    go_to(&mut window, 20.0);
    window.run_steps(2);
    assert!(shows(&window, "12 items"), "it took over");
}

/// Each frame's clock is given, so that no machine is too slow or too fast for it.
#[test]
fn it_takes_over_eight_seconds_after_the_last_touch_and_obeys_its_keys() {
    let folder = tempfile::tempdir().unwrap();
    let (mut window, answers) = with_a_song(folder.path());
    let leans = |window: &Window| !shows(window, "12 items");

    // A pointer that moves puts it off.
    go_to(&mut window, 8.0);
    window.event(Event::PointerMoved(Pos2::new(500.0, 300.0)));
    go_to(&mut window, 8.5);
    go_to(&mut window, 16.4);
    go_to(&mut window, 16.45);
    assert!(!leans(&window), "it did not wait");
    go_to(&mut window, 16.6);
    window.run_steps(2);
    assert!(leans(&window), "it did not take over");

    // A ends it, and does not let it begin again by itself.
    press(&mut window, Key::A);
    assert!(!leans(&window));
    go_to(&mut window, 60.0);
    window.run_steps(2);
    assert!(!leans(&window));
    press(&mut window, Key::A);
    assert!(leans(&window));

    // H holds the dance, as the keys that are named where the pointer moves say; an arrow goes to another one all the same.
    let hint = |window: &mut Window, secs: f64| {
        for (i, x) in [400.0, 500.0].into_iter().enumerate() {
            window.event(Event::PointerMoved(Pos2::new(x, 300.0)));
            go_to(window, secs + 0.05 * i as f64);
        }
        ["H holds", "H goes on"].map(|text| shows(window, text))
    };
    assert_eq!(hint(&mut window, 60.1), [true, false]);
    press(&mut window, Key::H);
    assert_eq!(hint(&mut window, 60.2), [false, true]);
    press(&mut window, Key::ArrowRight);
    press(&mut window, Key::H);
    assert_eq!(hint(&mut window, 60.3), [true, false]);
    press(&mut window, Key::ArrowLeft);
    press(&mut window, Key::Escape);
    assert!(!leans(&window));

    let actions = saved_show(&mut window, &answers, &folder.path().join("leant.toml")).actions;
    let count = |is: fn(&Action) -> bool| actions.iter().filter(|line| is(&line.action)).count();
    assert_eq!(count(|action| matches!(action, Action::LeaveStage)), 2);
    // Twice by itself or A, and once for each arrow.
    assert_eq!(count(|action| matches!(action, Action::Perform { .. })), 4);
}

#[test]
fn it_goes_on_with_another_shape_and_ends_with_another_show() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let files = ball_and_song(folder.path()).to_vec();
    chladni_mesh::save_mesh(&chladni_mesh::samples::icosphere(2), &path("round.obj")).unwrap();
    std::fs::write(path("other.toml"), "format_version = 1\nseed = 5\nsize = 6\n").unwrap();
    let answers = Answers::default();
    let chooser = Box::new(answers.clone());
    let folders = folders(folder.path());
    let mut window = enter(Opening { folders, files, chooser, now: no_time, ..Opening::default() });
    window.key_press(Key::A);
    window.run_steps(3);
    let leans = |window: &Window| !shows(window, "12 items");
    assert!(leans(&window));
    drop_files(&mut window, &[path("round.obj")]);
    wait(&mut window, "the other shape", |w| !shows(w, "Opening"));
    window.run_steps(5);
    assert!(leans(&window), "the autopilot left the stage with the shape");
    // It still obeys: A ends it, and the gallery is there.
    window.key_press(Key::A);
    window.run_steps(3);
    assert!(!leans(&window));
    window.key_press(Key::A);
    window.run_steps(3);
    drop_files(&mut window, &[path("other.toml")]);
    wait(&mut window, "the other show", |w| shows(w, "6 items"));
    window.run_steps(5);
    assert!(shows(&window, "6 items"), "the autopilot went on in another show");
}

/// A room on a ball and a song in which the autopilot does not begin by itself.
fn with_its_key(folder: &Path) -> (Window, Answers) {
    let (folders, answers) = (folders(folder), Answers::default());
    let settings = folders.settings.clone().unwrap();
    std::fs::write(settings, "harmonics = 24\n[music]\nleans_back = false\n").unwrap();
    let (files, chooser) = (ball_and_song(folder).to_vec(), Box::new(answers.clone()));
    (enter(Opening { folders, files, chooser, now: no_time, ..Opening::default() }), answers)
}

#[test]
fn a_preset_that_is_taken_meanwhile_keeps_its_form_and_knobs() {
    let folder = tempfile::tempdir().unwrap();
    let shape = GalleryShape { eigenvalues: (0..24).map(f64::from).collect(), bands: 128 };
    let mut instrument = Instrument::new(1, 6, shape.clone()).unwrap();
    let damping = Action::Set { parameter: Parameter::Damping, value: 1.5 };
    for action in [Action::SetForm { form: Form::Modal }, damping] {
        instrument.apply(Moment::default(), action).unwrap();
    }
    let preset = instrument.preset(&instrument.gallery().items()[0], Vec::new());
    let path = folder.path().join("calm.toml");
    preset.save(&path).unwrap();
    let (mut window, answers) = with_its_key(folder.path());
    press(&mut window, Key::A);
    assert!(!shows(&window, "12 items"));
    drop_files(&mut window, &[path]);
    window.run_steps(3);
    assert!(!shows(&window, "12 items"), "the stage was left");
    press(&mut window, Key::Escape);
    wait(&mut window, "the gallery", |w| shows(w, "12 items"));
    let show = saved_show(&mut window, &answers, &folder.path().join("taken.toml"));
    let played = show.replay(shape).unwrap();
    assert_eq!(played.parameters().of_a_dance(), preset.settings);
    assert!(played.gallery().items().iter().any(|item| item.name == preset.name));
}

/// Five changes of the picture fit into a second: after four, the stage is opened by the fifth.
#[test]
fn it_does_all_its_actions_or_none_where_the_flash_guard_holds_the_stage_back() {
    let folder = tempfile::tempdir().unwrap();
    let (mut window, answers) = with_its_key(folder.path());
    point_at(&mut window, "dance/2");
    let mut now_secs = window.ctx.input(|input| input.time);
    // Each round in a moment of its own.
    for before in 0..3 {
        now_secs += 2.0;
        go_to(&mut window, now_secs);
        for _ in 0..before {
            press(&mut window, Key::S);
            press(&mut window, Key::Escape);
        }
        press(&mut window, Key::A);
        now_secs += 2.0;
        go_to(&mut window, now_secs);
        press(&mut window, Key::Escape);
        wait(&mut window, "the gallery", |w| shows(w, "12 items"));
    }
    let actions = saved_show(&mut window, &answers, &folder.path().join("held.toml")).actions;
    let actions = actions.into_iter().map(|line| line.action);
    // A gain that stays as it is is none.
    let actions: Vec<Action> = actions.filter(|action| !matches!(action, Action::Set { .. })).collect();
    let begun = actions.iter().filter(|action| matches!(action, Action::Take { .. })).count();
    let whole =
        actions.windows(2).filter(|pair| matches!(pair, [Action::Take { .. }, Action::Perform { .. }]));
    assert!(begun > 0 && whole.count() == begun, "{actions:?}");
}

/// A window that opens for the autopilot, on a ball and live input.
fn piloted(folder: &Path, folders: Folders, input: Capture, trace: &Trace) -> Window {
    let [ball, _] = ball_and_song(folder);
    let opening = Opening {
        folders,
        files: vec![ball],
        set: SetPlan { autopilot: true, ..SetPlan::default() },
        input: Some(input),
        trace: Some(trace.clone()),
        now: no_time,
        ..Opening::default()
    };
    open_with(opening, Harness::builder().with_size([1000.0, 640.0]))
}

#[test]
fn it_begins_at_once_on_live_input_where_the_window_opens_for_it() {
    let folder = tempfile::tempdir().unwrap();
    let (input, _feed) = Capture::fed(44_100).unwrap();
    let trace = Trace::default();
    let mut window = piloted(folder.path(), folders(folder.path()), input, &trace);
    wait(&mut window, "the stage", |_| trace.borrow().last().is_some_and(|frame| frame.on_stage));
    window.run_steps(3);
    // The key ends it, and it does not begin again.
    press(&mut window, Key::A);
    wait(&mut window, "the gallery", |w| shows(w, "12 items"));
    window.run_steps(5);
    assert!(shows(&window, "12 items"));
}

#[test]
fn what_a_crash_left_is_asked_about_once_the_stage_is_left() {
    let folder = tempfile::tempdir().unwrap();
    let recovery = folder.path().join("recovery");
    std::fs::create_dir(&recovery).unwrap();
    std::fs::write(recovery.join("show-1-0.toml"), "format_version = 1\nseed = 3\nsize = 6\n").unwrap();
    let (input, _feed) = Capture::fed(44_100).unwrap();
    let trace = Trace::default();
    let folders = Folders { recovery: Some(recovery), ..folders(folder.path()) };
    let asks = |window: &Window| shows(window, "The last show did not end well");
    let mut window = piloted(folder.path(), folders, input, &trace);
    wait(&mut window, "the stage", |window| {
        assert!(!asks(window), "it would vanish with the stage");
        trace.borrow().last().is_some_and(|frame| frame.on_stage)
    });
    window.run_steps(3);
    assert!(!asks(&window), "it lies on the stage");
    press(&mut window, Key::A);
    wait(&mut window, "the question", asks);
}

/// Each frame's clock is given, so that no machine is too slow or too fast for it.
#[test]
fn hands_on_a_controller_keep_it_away() {
    let folder = tempfile::tempdir().unwrap();
    let (folders, trace) = (folders(folder.path()), Trace::default());
    let port = free_port();
    let settings = folders.settings.clone().unwrap();
    std::fs::write(&settings, format!("harmonics = 24\n[music]\nosc_port = {port}\n")).unwrap();
    let files = ball_and_song(folder.path()).to_vec();
    let opening = Opening { folders, files, trace: Some(trace.clone()), now: no_time, ..Opening::default() };
    let mut window = open_with(opening, Harness::builder().with_size([1000.0, 640.0]));
    window.input_mut().time = Some(1.0);
    wait(&mut window, "the gallery", |w| w.query_by_label_contains("12 items").is_some());
    wait(&mut window, "the song", |_| trace.borrow().last().is_some_and(|frame| frame.is_known));
    go_to(&mut window, 4.0);
    let socket = UdpSocket::bind((Ipv4Addr::LOCALHOST, 0)).unwrap();
    wait(&mut window, "the controller's volume", |_| {
        socket.send_to(&packet("/chladni/volume", 0.25), (Ipv4Addr::LOCALHOST, port)).unwrap();
        std::fs::read_to_string(&settings).unwrap().contains("volume = 0.25")
    });
    for at_secs in [12.5, 12.6, 30.0] {
        go_to(&mut window, at_secs);
    }
    window.run_steps(2);
    assert!(shows(&window, "12 items"), "it took over");
}
