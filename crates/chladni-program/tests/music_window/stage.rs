//! The stage: on a projector, and in a window of its own.

use chladni_music::Action;

use super::*;

fn enter_with(music: &str) -> (Window, tempfile::TempDir) {
    let folder = tempfile::tempdir().unwrap();
    let folders = folders(folder.path());
    let settings = folders.settings.clone().unwrap();
    std::fs::write(settings, format!("harmonics = 24\n[music]\n{music}")).unwrap();
    (enter(Opening { folders, ..Opening::default() }), folder)
}

fn press_on(window: &mut Window, dance: &str, key: Key) {
    point_at(window, dance);
    window.key_press(key);
    window.run_steps(4);
}

#[test]
fn corners_are_pinned_on_stage_and_nowhere_else() {
    let white = "look = \"\"\nbackground = \"white\"\n";
    let corners = "corners = [[0.2, 0.2], [0.8, 0.2], [0.8, 0.8], [0.2, 0.8]]";
    let trim = "trim = [1.0, 0.5, 1.0]";
    let pinned = format!("{white}[music.projection]\n{corners}\n{trim}\n");
    let (mut window, _folder) = enter_with(&pinned);
    press_on(&mut window, "dance/1", Key::S);
    window.run_steps(20);
    let picture = window.render().unwrap();
    let at = |x: f32, y: f32| {
        let (width, height) = (picture.width() as f32, picture.height() as f32);
        let pixel = picture.get_pixel((x * width) as u32, (y * height) as u32);
        [pixel[0], pixel[1], pixel[2]]
    };
    for outside in [[0.1, 0.5], [0.5, 0.1], [0.9, 0.9]] {
        assert_eq!(at(outside[0], outside[1]), [0; 3], "{outside:?}");
    }
    for inside in [[0.22, 0.22], [0.78, 0.22], [0.22, 0.7]] {
        let [r, g, b] = at(inside[0], inside[1]);
        assert!(r > 240 && b > 240 && (120..136).contains(&g), "{inside:?}: {:?}", [r, g, b]);
    }
    window.key_press(Key::Escape);
    window.run_steps(20);
    click(&mut window, "drawer/look");
    assert!(shows(&window, "Move the corners"));
    control(&window, "projection-reset").click_accesskit();
    window.run_steps(2);
    let settings = std::fs::read_to_string(_folder.path().join("settings.toml")).unwrap();
    assert!(!settings.contains("0.2"), "{settings}");
}

#[test]
fn effects_of_a_look_are_left_out_one_by_one() {
    let (mut window, folder) = enter_with("leans_back = false\nlook = \"ember\"\n");
    click(&mut window, "drawer/look");
    assert!(control(&window, "effect/grain").accesskit_node().is_disabled(), "this look has none");
    control(&window, "effect/corners").click_accesskit();
    let settings = folder.path().join("settings.toml");
    let is_kept = |_: &Window| std::fs::read_to_string(&settings).unwrap().contains("\"corners\"");
    wait(&mut window, "that it is kept", is_kept);
}

#[test]
fn a_film_plays_behind_what_dances() {
    let folder = tempfile::tempdir().unwrap();
    // Two seconds, and again.
    let Some(film) = chladni_testdata::brightening_film(folder.path(), [64, 64], 2.0, 4) else { return };
    let (mut window, _folder) = enter_with(&format!("look = \"\"\npicture = {film:?}\n"));
    press_on(&mut window, "dance/1", Key::S);
    let (mut dark, mut bright) = (false, false);
    let began = Instant::now();
    while !(dark && bright) {
        assert!(began.elapsed() < chladni_testdata::HANGS, "dark {dark}, bright {bright}");
        window.run_steps(5);
        let picture = window.render().unwrap();
        let corner = picture.get_pixel(20, picture.height() - 20);
        (dark, bright) = (dark || corner[1] < 70, bright || corner[1] > 130);
    }
    screenshot(&mut window, "window-music-film-behind.png");
}

/// The list lies below what the drawer shows.
#[cfg(target_os = "linux")]
fn choose(window: &mut Window, camera: &str) {
    control(window, "camera").scroll_to_me();
    window.run_steps(20);
    click(window, "camera");
    control(window, &format!("camera/{camera}")).click_accesskit();
    window.run_steps(2);
}

/// Whether it works here depends on the machine; that it says so does not.
#[cfg(target_os = "linux")]
#[test]
fn a_camera_for_other_programs_is_there_or_says_why_not() {
    let (mut window, _folder) = enter_with("[music.camera]\ndevice = \"/nonexistent/video\"\n");
    wait(&mut window, "that it is not there", |w| shows(w, "camera:"));
    click(&mut window, "drawer/look");
    wait(&mut window, "that it is not tried again", |w| !is_there(w, "camera-out"));
    choose(&mut window, "pipewire");
    let is_off = |w: &Window| control(w, "camera").accesskit_node().value().as_deref() == Some("Off");
    wait(&mut window, "the camera, or why not", |w| is_there(w, "camera-out") || is_off(w));
}

/// Tests draw a second window into the first.
#[test]
fn breeding_goes_on_while_the_show_has_a_window_of_its_own() {
    let (mut window, _folder) = enter_with("own_window = true\n");
    assert!(!shows(&window, "On stage"));
    press_on(&mut window, "dance/2", Key::S);
    window.run_steps(10);
    for still_there in ["On stage", "12 items", "Dance 5", "Freeze"] {
        assert!(shows(&window, still_there), "{still_there}");
    }
    assert!(is_there(&window, "preview") && shows(&window, "Dance 2, on stage"));
    screenshot(&mut window, "window-music-two-windows.png");
    for dance in ["dance/3", "dance/4"] {
        control(&window, dance).click_accesskit();
        window.run_steps(2);
    }
    control(&window, "breed").click_accesskit();
    window.run_steps(4);
    assert!(shows(&window, "2 / 2") && shows(&window, "On stage"));
    press_on(&mut window, "dance/5", Key::N);
    assert!(shows(&window, "Dance 5, next"));
    for button in ["go", "blackout", "freeze", "freeze", "leave"] {
        // The second window may lie over it.
        control(&window, button).click_accesskit();
        window.run_steps(2);
        assert_eq!(shows(&window, "On stage"), button != "leave", "{button}");
    }
    assert!(shows(&window, "12 items") && !shows(&window, "On stage"));
}

#[test]
fn a_dance_has_one_name_on_stage_in_the_gallery_and_on_the_shelf() {
    let (mut window, _folder) = enter_with("own_window = true\n");
    for dance in ["dance/3", "dance/4"] {
        click(&mut window, dance);
    }
    control(&window, "breed").click_accesskit();
    window.run_steps(4);
    press_on(&mut window, "dance/3", Key::F);
    press_on(&mut window, "dance/3", Key::S);
    window.run_steps(10);
    assert!(shows(&window, "Dance 3, on stage"));
    assert!(window.query_all_by_label("Dance 3").next().is_some(), "in the bar");
    // The second window may lie over it.
    control(&window, "drawer/shelf").click_accesskit();
    window.run_steps(4);
    assert!(shows(&window, "Keep on the shelf: Dance 3"));
    window.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    window.run_steps(4);
    assert!(shows(&window, "Keep on the shelf: 3 of generation 2"));
}

/// Escape in a text field leaves the field, and then what is closer than the stage.
#[test]
fn escape_ends_the_show_only_where_nothing_is_to_be_left_before() {
    let (mut window, _folder) = enter_with("own_window = true\n");
    press_on(&mut window, "dance/2", Key::S);
    window.run_steps(10);
    control(&window, "drawer/shelf").click_accesskit();
    window.run_steps(4);
    control(&window, "shelf/search").focus();
    window.run_steps(2);
    control(&window, "shelf/search").type_text("sea");
    window.key_press(Key::Escape);
    window.run_steps(4);
    assert!(shows(&window, "On stage"), "the field had the key");

    press_on(&mut window, "dance/5", Key::E);
    assert!(is_there(&window, "back-to-gallery"));
    window.key_press(Key::Escape);
    window.run_steps(4);
    assert!(shows(&window, "On stage") && !is_there(&window, "back-to-gallery"), "the close-up was left");
    window.key_press(Key::Escape);
    window.run_steps(4);
    assert!(!shows(&window, "On stage"));
}

#[test]
fn the_dance_that_was_to_be_next_still_is_once_another_is_on_stage() {
    let (folder, answers) = (tempfile::tempdir().unwrap(), Answers::default());
    let (folders, chooser) = (folders(folder.path()), Box::new(answers.clone()));
    let mut window = enter(Opening { folders, chooser, ..Opening::default() });
    press_on(&mut window, "dance/5", Key::N);
    press_on(&mut window, "dance/2", Key::S);
    for key in [Key::R, Key::Escape] {
        window.key_press(key);
        window.run_steps(4);
    }
    wait(&mut window, "the gallery", |w| shows(w, "12 items"));
    let actions = saved_show(&mut window, &answers, &folder.path().join("next.toml")).actions;
    let actions: Vec<Action> = actions.into_iter().map(|line| line.action).collect();
    let cued = Action::CueUp { item: 4 };
    let expected = [cued.clone(), Action::PerformGallery { first: 1 }, cued, Action::Go, Action::LeaveStage];
    assert!(actions.ends_with(&expected), "{actions:?}");
}

#[test]
fn arrows_go_through_the_gallery_where_the_beat_does() {
    let (folder, answers) = (tempfile::tempdir().unwrap(), Answers::default());
    let (folders, chooser) = (folders(folder.path()), Box::new(answers.clone()));
    let mut window = enter(Opening { folders, chooser, ..Opening::default() });
    // No beat comes between.
    if plays(&window) {
        click(&mut window, "play");
    }
    click(&mut window, "drawer/knobs");
    control(&window, "beat-steps").click_accesskit();
    window.run_steps(2);
    press_on(&mut window, "dance/12", Key::S);
    for key in [Key::ArrowRight, Key::ArrowLeft, Key::ArrowLeft, Key::Escape] {
        window.key_press(key);
        window.run_steps(4);
    }
    wait(&mut window, "the gallery", |w| shows(w, "12 items"));
    let actions = saved_show(&mut window, &answers, &folder.path().join("turns.toml")).actions;
    let put = actions.iter().filter_map(|line| match line.action {
        Action::PerformGallery { first } => Some(first),
        _ => None,
    });
    assert_eq!(put.collect::<Vec<_>>(), [11, 0, 11, 10]);
}

#[test]
fn keys_that_do_nothing_else_on_stage_show_those_that_help() {
    let (mut window, _folder) = enter_with("leans_back = false\n");
    press_on(&mut window, "dance/2", Key::S);
    let hint = "leaves the stage";
    // Tab leads to the picture, which an arrow then turns.
    for (key, helps) in
        [(Key::Q, true), (Key::ControlLeft, false), (Key::B, false), (Key::Tab, true), (Key::ArrowUp, false)]
    {
        wait(&mut window, "the end of the hint", |w| !shows(w, hint));
        window.key_press(key);
        window.run_steps(2);
        assert_eq!(shows(&window, hint), helps, "{key:?}");
    }
}
