//! Films of what dances are what the window showed.

use super::*;

/// A window whose ball dances for four seconds, with the form of a film that is to be `to` in the folder; and the answers to
/// later questions.
fn asked_for_a_film(folder: &Path, to: &str) -> (Window, Answers) {
    let (answers, files) = (Answers::default(), ball_and_song(folder).to_vec());
    answers.add(folder.join(to));
    let chooser = Box::new(answers.clone());
    let mut window = enter(Opening { folders: folders(folder), chooser, files, ..Opening::default() });
    window.key_press_modifiers(Modifiers::COMMAND, Key::E);
    window.run_steps(3);
    (window, answers)
}

#[test]
fn what_dances_is_filmed_beside_the_window() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    chladni_mesh::save_mesh(&chladni_mesh::samples::icosphere(2), &path("ball.obj")).unwrap();
    let tone: Vec<f32> = (0..11_025).map(|i| (i as f32 * 0.06).sin() * 0.5).collect();
    let song = Song { rate_hz: 22_050, left: tone.clone(), right: tone };
    write_wav(&path("short.wav"), &song, WavSample::Int16).unwrap();
    let (answers, files) = (Answers::default(), vec![path("ball.obj"), path("short.wav")]);
    let chooser = Box::new(answers.clone());
    let mut window = enter(Opening { folders: folders(folder.path()), chooser, files, ..Opening::default() });
    answers.add(path("film.gif"));
    window.key_press_modifiers(Modifiers::COMMAND, Key::E);
    window.run_steps(3);
    click(&mut window, "size/640x360");
    click(&mut window, "fps/12");
    screenshot(&mut window, "window-music-film.png");
    click(&mut window, "film-begin");
    // A short film may be done before the window is seen again.
    wait(&mut window, "progress", |w| shows(w, "Filming film.gif") || shows(w, "Filmed"));
    screenshot(&mut window, "window-music-filming.png");
    wait(&mut window, "the film", |w| shows(w, "Filmed"));
    let film = std::fs::read(path("film.gif")).unwrap();
    assert_eq!(&film[..6], b"GIF89a");
    assert_eq!([film[6], film[7], film[8], film[9]], [128, 2, 104, 1], "640 × 360");
}

#[test]
fn frames_and_their_sound_go_into_a_new_folder_at_any_rate() {
    let folder = tempfile::tempdir().unwrap();
    let frames = folder.path().join("take.1");
    let (mut window, answers) = asked_for_a_film(folder.path(), "take.1");
    click(&mut window, "size/640x360");
    control(&window, "fps").set_value_accesskit(1.25);
    window.run_steps(2);
    click(&mut window, "film-frames");
    assert!(answers.offered().is_empty(), "a folder has no extension");
    wait(&mut window, "the film", |w| shows(w, "Filmed"));
    let entries = frames.read_dir().unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
    let mut names: Vec<String> = entries.collect();
    names.sort();
    let mut expected: Vec<String> = (0..5).map(|frame| format!("frame-{frame:05}.png")).collect();
    expected.push("sound.wav".to_owned());
    assert_eq!(names, expected, "1.25 frames in each of four seconds");
    let png = std::fs::read(frames.join("frame-00004.png")).unwrap();
    let picture = chladni_view::Picture::decode(&png).unwrap();
    assert_eq!((picture.width, picture.height), (640, 360));
    let wav = std::fs::read(frames.join("sound.wav")).unwrap();
    let song = std::fs::read(folder.path().join("song.wav")).unwrap();
    assert_eq!((&wav[..4], wav.len()), (&b"RIFF"[..], song.len()), "all of the song");
    assert!(wav[44..].iter().any(|byte| *byte != 0), "silent");
    // Nothing that is there is replaced.
    answers.add(frames.clone());
    window.key_press_modifiers(Modifiers::COMMAND, Key::E);
    window.run_steps(3);
    click(&mut window, "film-frames");
    wait(&mut window, "the reason", |w| shows(w, "holds files already"));
    assert!(is_there(&window, "film-begin"));
    assert_eq!(std::fs::read(frames.join("frame-00004.png")).unwrap(), png);
}

#[test]
fn a_run_of_the_window_filmed_by_the_command_has_the_same_coefficients_bit_for_bit() {
    let folder = tempfile::tempdir().unwrap();
    let trace = Trace::default();
    let (mut window, answers) = recorded(folder.path(), &trace);
    // It plays, breeds, turns knobs, pauses, leaps, and puts a dance on stage.
    click(&mut window, "dance/2");
    click(&mut window, "dance/5");
    click(&mut window, "breed");
    run_for(&mut window, 0.4);
    click(&mut window, "form/halves");
    run_for(&mut window, 0.3);
    window.key_press(Key::Space);
    run_for(&mut window, 1.0);
    window.key_press(Key::Space);
    run_for(&mut window, 0.3);
    let slider = control(&window, "seek").rect();
    drag(&mut window, &[slider.lerp_inside([0.12, 0.5])]);
    run_for(&mut window, 0.5);
    point_at(&mut window, "dance/3");
    window.key_press(Key::S);
    run_for(&mut window, 0.6);
    window.key_press(Key::Escape);
    run_for(&mut window, 0.4);
    let show_file = folder.path().join("run.toml");
    answers.add(show_file.clone());
    window.key_press_modifiers(Modifiers::COMMAND, Key::S);
    window.run_steps(3);
    drop(window);

    let show = Show::load(&show_file).unwrap();
    assert!(show.heard.iter().any(|stretch| !stretch.playing), "no pause in {:?}", show.heard);
    assert!(show.heard.len() >= 4, "no leap in {:?}", show.heard);
    let frames = trace.borrow();
    // From when the song was known, but not while what was heard before it faded: a busy machine may leap meanwhile, and then
    // fades from what is fading.
    let known = frames.iter().find(|frame| frame.is_known).unwrap().at_secs + 0.4;
    let known = show
        .heard
        .iter()
        .fold(known, |known, leap| if leap.at_secs < known { known.max(leap.at_secs + 0.4) } else { known });
    let acts: Vec<f64> = show.actions.iter().map(|line| line.moment.at_secs).collect();
    // In a frame in which something is done it is not seen yet.
    let end = show.duration_secs.unwrap() - 0.1;
    let steady = |at_secs: f64| at_secs > known && at_secs < end && !acts.contains(&at_secs);
    let steady: Vec<_> = frames.iter().filter(|frame| steady(frame.at_secs)).collect();
    let mut compared = 0;
    for frame in steady.iter().step_by((steady.len() / 12).max(1)) {
        let out = folder.path().join("frame.npz");
        let start = frame.at_secs.to_string();
        let [file, npz] = [&show_file, &out].map(|path| path.to_str().unwrap());
        let dance = ["chladni", "--quiet", "dance", "--show", file, "--start", &start, "--duration", "0.03"];
        assert_eq!(chladni_program::cli::run(dance.iter().chain(&["--coefficients", npz])), 0);
        let filmed = archive::array(&out, "coefficients").unwrap().values;
        let seen: Vec<u32> = frame.coefficients.iter().map(|c| c.to_bits()).collect();
        let filmed: Vec<u32> = filmed.iter().map(|c| (*c as f32).to_bits()).collect();
        assert_eq!(seen.len(), filmed.len(), "at {start} s");
        let other = seen.iter().zip(&filmed).filter(|(a, b)| a != b).count();
        assert_eq!(
            other,
            0,
            "of {} coefficients at {start} s, known from {known} s: {:?}",
            seen.len(),
            show.heard
        );
        compared += usize::from(filmed.iter().any(|bits| *bits != 0));
    }
    assert!(compared >= 6, "{compared} frames moved");
}

#[test]
fn a_frame_of_a_film_is_the_picture_in_the_window_at_that_moment() {
    let folder = tempfile::tempdir().unwrap();
    let trace = Trace::default();
    let (mut window, answers) = recorded(folder.path(), &trace);
    click(&mut window, "drawer/look");
    click(&mut window, "material/bronze");
    // Turned, shifted and nearer.
    let middle = control(&window, "dance/6").rect().center();
    for (modifiers, by) in [(Modifiers::NONE, [60.0, 25.0]), (Modifiers::SHIFT, [18.0, -9.0])] {
        let button =
            |pos, pressed| Event::PointerButton { pos, button: PointerButton::Middle, pressed, modifiers };
        let end = middle + egui::Vec2::from(by);
        for event in
            [Event::PointerMoved(middle), button(middle, true), Event::PointerMoved(end), button(end, false)]
        {
            window.event_modifiers(event, modifiers);
            window.run_steps(1);
        }
    }
    window.event(Event::PointerMoved(middle));
    // In steps as small as those of a touchpad, which take effect at once.
    for _ in 0..10 {
        window.event(Event::MouseWheel {
            unit: egui::MouseWheelUnit::Point,
            delta: egui::vec2(0.0, 5.0),
            phase: egui::TouchPhase::Move,
            modifiers: Modifiers::NONE,
            source: egui::MouseWheelSource::Wheel,
        });
    }
    run_for(&mut window, 0.5);
    window.event(Event::PointerMoved(control(&window, "dance/3").rect().center()));
    window.run_steps(2);
    window.key_press(Key::S);
    // Before the song is studied the camera follows what is heard; a film knows the song.
    wait(&mut window, "the beats of the song", |_| trace.borrow().last().is_some_and(|frame| frame.is_known));
    run_for(&mut window, 1.2);
    window.key_press(Key::Space);
    // Until the wheel has run out, and the picture is drawn as finely as a film: on a busy machine there are few
    // frames in a while.
    run_for(&mut window, 3.0);
    window.run_steps(20);
    let picture = window.render().unwrap();
    let (width, height) = (picture.width(), picture.height());
    let at_secs = trace.borrow().last().unwrap().at_secs;
    assert!(trace.borrow().last().unwrap().on_stage);
    run_for(&mut window, 0.3);
    window.key_press(Key::Escape);
    window.run_steps(3);
    let show_file = folder.path().join("stage.toml");
    answers.add(show_file.clone());
    window.key_press_modifiers(Modifiers::COMMAND, Key::S);
    window.run_steps(3);
    drop(window);
    let viewpoint = Show::load(&show_file).unwrap().viewpoint;
    assert!(
        viewpoint.yaw_rad.abs() > 0.1 && viewpoint.distance < 0.97 && viewpoint.shift[0] > 0.01,
        "{viewpoint:?}"
    );

    let frames = folder.path().join("frames");
    let (size, start) = (format!("{width}x{height}"), at_secs.to_string());
    let [show, out] = [&show_file, &frames].map(|path| path.to_str().unwrap());
    let dance =
        ["chladni", "--quiet", "dance", "--show", show, "--frames", out, "--size", &size, "--samples", "4"];
    assert_eq!(chladni_program::cli::run(dance.iter().chain(&["--start", &start, "--duration", "0.03"])), 0);
    let png = std::fs::read(frames.join("frame-00000.png")).unwrap();
    let film = chladni_view::Picture::decode(&png).unwrap();
    if let Some(folder) = std::env::var_os("CHLADNI_SCREENSHOTS") {
        picture.save(Path::new(&folder).join("stage-window.png")).unwrap();
        std::fs::write(Path::new(&folder).join("stage-film.png"), png).unwrap();
    }
    assert_eq!((film.width, film.height), (width, height));
    let seen = picture.into_raw();
    // Windows are drawn with eight bits twice; edges may round otherwise.
    let differ = seen.iter().zip(&film.rgba).filter(|(a, b)| a.abs_diff(**b) > 12).count();
    assert!(differ < seen.len() / 200, "{differ} of {} channels differ", seen.len());
    let ground = &film.rgba[..3];
    let shape =
        film.rgba.chunks(4).filter(|p| p.iter().zip(ground).any(|(a, b)| a.abs_diff(*b) > 40)).count();
    assert!(shape > film.rgba.len() / 400, "nothing is seen");
}

#[test]
fn a_window_that_is_closed_while_it_films_waits_for_the_film() {
    let folder = tempfile::tempdir().unwrap();
    let film = folder.path().join("film.gif");
    let (mut window, _) = asked_for_a_film(folder.path(), "film.gif");
    click(&mut window, "size/1280x720");
    click(&mut window, "fps/50");
    click(&mut window, "film-begin");
    wait(&mut window, "progress", |w| shows(w, "Filming film.gif"));
    ask_to_close(&mut window);
    assert!(shows(&window, "Closing when this is done"));
    assert!(!shows(&window, "Save before closing?"), "nothing is unsaved");
    screenshot(&mut window, "window-music-closing.png");
    click(&mut window, "keep-working");
    assert!(!shows(&window, "Closing when this is done") && !film.exists());
    ask_to_close(&mut window);
    wait(&mut window, "the end", closes);
    assert!(film.exists());
}

#[test]
fn a_film_that_ends_while_the_start_screen_is_there_is_announced() {
    let folder = tempfile::tempdir().unwrap();
    let (mut window, _) = asked_for_a_film(folder.path(), "film.gif");
    click(&mut window, "size/640x360");
    click(&mut window, "fps/12");
    click(&mut window, "film-begin");
    window.get_by_role_and_label(Role::Button, "Chladni").click();
    window.run_steps(3);
    wait(&mut window, "the film", |w| shows(w, "Filmed"));
    assert!(shows(&window, "What would you like to play?"));
    ask_to_close(&mut window);
    assert!(!shows(&window, "Closing when this is done"));
}

#[test]
fn the_form_of_a_film_that_cannot_be_stays_open() {
    let folder = tempfile::tempdir().unwrap();
    let (mut window, _) = asked_for_a_film(folder.path(), "film.gif");
    click(&mut window, "fps/60");
    click(&mut window, "film-begin");
    wait(&mut window, "the reason", |w| shows(w, "at most 50 frames"));
    assert!(is_there(&window, "film-begin"));
}

#[test]
fn escape_leaves_a_number_or_a_question_before_the_form() {
    let folder = tempfile::tempdir().unwrap();
    let files = ball_and_song(folder.path()).to_vec();
    let mut window = enter(Opening { folders: folders(folder.path()), files, ..Opening::default() });
    point_at(&mut window, "dance/3");
    window.key_press(Key::F);
    window.key_press_modifiers(Modifiers::COMMAND, Key::E);
    window.run_steps(3);
    window.get_by_role_and_label(Role::SpinButton, "Width").focus();
    window.run_steps(2);
    window.get_by_role_and_label(Role::SpinButton, "Width").type_text("700");
    window.run_steps(2);
    let escape = |window: &mut Window| {
        window.key_press(Key::Escape);
        window.run_steps(3);
        is_there(window, "film-begin")
    };
    assert!(escape(&mut window), "the number had the key");
    ask_to_close(&mut window);
    assert!(shows(&window, "Save before closing?"));
    assert!(escape(&mut window) && !shows(&window, "Save before closing?"), "the question had the key");
    assert!(!escape(&mut window));
}

#[test]
fn what_is_on_stage_is_filmed_by_its_key() {
    let folder = tempfile::tempdir().unwrap();
    let files = ball_and_song(folder.path()).to_vec();
    let mut window = enter(Opening { folders: folders(folder.path()), files, ..Opening::default() });
    point_at(&mut window, "dance/3");
    window.key_press(Key::S);
    window.run_steps(3);
    assert!(!is_there(&window, "dance/3"));
    window.key_press_modifiers(Modifiers::COMMAND, Key::E);
    window.run_steps(3);
    assert!(is_there(&window, "film-begin"));
    // Escape closes an open list, then the form.
    window.get_by_role(Role::ComboBox).click();
    window.run_steps(3);
    for is_open in [true, false] {
        window.key_press(Key::Escape);
        window.run_steps(3);
        assert_eq!(is_there(&window, "film-begin"), is_open);
    }
}
