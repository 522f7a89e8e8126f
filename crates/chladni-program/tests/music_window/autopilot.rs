//! The autopilot: when it takes over, and its keys.

use chladni_music::Action;

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

/// Each frame's clock is given, so that no machine is too slow or too fast for it.
#[test]
fn it_takes_over_eight_seconds_after_the_last_touch_and_obeys_its_keys() {
    let folder = tempfile::tempdir().unwrap();
    let files = ball_and_song(folder.path()).to_vec();
    let (trace, answers) = (Trace::default(), Answers::default());
    let opening = Opening {
        folders: folders(folder.path()),
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

    let file = folder.path().join("leant.toml");
    answers.add(file.clone());
    window.key_press_modifiers(Modifiers::COMMAND, Key::S);
    wait(&mut window, "the show", |_| file.exists());
    let actions = Show::load(&file).unwrap().actions;
    let count = |is: fn(&Action) -> bool| actions.iter().filter(|line| is(&line.action)).count();
    assert_eq!(count(|action| matches!(action, Action::LeaveStage)), 2);
    // Twice by itself or A, and once for each arrow.
    assert_eq!(count(|action| matches!(action, Action::Perform { .. })), 4);
}

/// A file as a desktop hands it over.
#[derive(Debug)]
struct Dropped(std::path::PathBuf);

impl egui::DroppedFile for Dropped {
    fn path(&self) -> &Path {
        &self.0
    }

    fn bytes(&self) -> Result<Vec<u8>, String> {
        std::fs::read(&self.0).map_err(|why| why.to_string())
    }
}

fn drop_file(window: &mut Window, path: std::path::PathBuf) {
    window.input_mut().dropped_files.push(std::sync::Arc::new(Dropped(path)));
    window.run_steps(2);
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
    drop_file(&mut window, path("round.obj"));
    wait(&mut window, "the other shape", |w| !shows(w, "Opening"));
    window.run_steps(5);
    assert!(leans(&window), "the autopilot left the stage with the shape");
    // It still obeys: A ends it, and the gallery is there.
    window.key_press(Key::A);
    window.run_steps(3);
    assert!(!leans(&window));
    window.key_press(Key::A);
    window.run_steps(3);
    drop_file(&mut window, path("other.toml"));
    wait(&mut window, "the other show", |w| shows(w, "6 items"));
    window.run_steps(5);
    assert!(shows(&window, "6 items"), "the autopilot went on in another show");
}
