//! Dances: bred, named, drawn, kept and put on stage.

use super::*;

#[test]
fn a_paused_song_lets_the_gallery_rest() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = enter(Opening { folders: folders(folder.path()), ..Opening::default() });
    wait(&mut window, "the song", plays);
    window.key_press(Key::Space);
    // Work that was under way when it was paused, such as measuring a picture's brightness, may still arrive.
    let resting = std::cell::Cell::new(0);
    wait(&mut window, "rest", |w| {
        resting.set(if pause(w) >= std::time::Duration::from_millis(20) { resting.get() + 1 } else { 0 });
        resting.get() == 5
    });
    window.key_press(Key::Space);
    wait(&mut window, "the dance", |w| pause(w).is_zero());
}

#[test]
fn gallery_breed_twice_name_draw_stage_keep_and_reopen() {
    let folder = tempfile::tempdir().unwrap();
    let folders = folders(folder.path());
    let answers = Answers::default();
    let chooser = Box::new(answers.clone());
    let mut window = enter(Opening { folders: folders.clone(), chooser, ..Opening::default() });
    window.run_steps(10);
    screenshot(&mut window, "window-music.png");

    breed_twice_and_travel(&mut window);
    breed_by_keys(&mut window);
    name_and_draw(&mut window);
    keep_on_the_shelf(&mut window, folder.path());
    go_on_stage_and_back(&mut window);
    let session = folder.path().join("evening.toml");
    answers.add(session.clone());
    click(&mut window, "file");
    click(&mut window, "file/save-show");
    drop(window);

    // A film repeats the actions in the window, the same way each time.
    let film = |name: &str| {
        let coefficients = folder.path().join(name);
        let [session, out] = [&session, &coefficients].map(|path| path.to_str().unwrap());
        let dance =
            ["chladni", "--quiet", "dance", "sample:octopus", "sample:tune", "-k", "96", "--duration", "1"];
        let code =
            chladni_program::cli::run(dance.iter().chain(&["--session", session, "--coefficients", out]));
        assert_eq!(code, 0);
        archive::array(&coefficients, "coefficients").unwrap().values
    };
    let first = film("first.npz");
    assert!(first.iter().any(|c| *c != 0.0) && first == film("second.npz"));

    // The next evening: the shelf is as it was, and the session goes on.
    let mut window = enter(Opening { folders, files: vec![session.clone()], ..Opening::default() });
    wait(&mut window, "the show", |w| shows(w, "4 / 4"));
    resize_and_take_from_the_shelf(&mut window);
}

fn breed_twice_and_travel(window: &mut Window) {
    click(window, "dance/2");
    click(window, "dance/5");
    assert!(is_chosen(window, "dance/5") && !is_chosen(window, "dance/1"));
    click(window, "breed");
    assert!(shows(window, "2 / 2"));
    for dance in ["dance/1", "dance/3", "dance/8"] {
        click(window, dance);
    }
    window.key_press(Key::Enter);
    window.run_steps(2);
    assert!(shows(window, "3 / 3"));

    // Back to any generation, and forth again.
    click(window, "generations");
    click(window, "generation/1");
    assert!(shows(window, "1 / 3") && is_chosen(window, "dance/5"));
    click(window, "generations");
    click(window, "generation/3");
    assert!(shows(window, "3 / 3") && !is_chosen(window, "dance/5"));
}

/// By keys alone: the mark goes right and down, what is marked is chosen, locked and changed.
fn breed_by_keys(window: &mut Window) {
    window.hover_at(Pos2::new(500.0, 60.0));
    window.run_steps(2);
    for key in [Key::ArrowRight, Key::ArrowRight, Key::ArrowDown, Key::C, Key::L] {
        window.key_press(key);
        window.run_steps(1);
    }
    assert!(is_chosen(window, "dance/6") && !is_chosen(window, "dance/5"));
    for key in [Key::C, Key::M] {
        window.key_press(key);
        window.run_steps(1);
    }
    assert!(shows(window, "4 / 4") && !is_chosen(window, "dance/6"));
    for (on, key) in [(Modifiers::SHIFT, Key::Z), (Modifiers::NONE, Key::Y)] {
        window.key_press_modifiers(Modifiers::COMMAND, Key::Z);
        window.run_steps(2);
        assert!(shows(window, "3 / 4"));
        window.key_press_modifiers(Modifiers::COMMAND | on, key);
        window.run_steps(2);
        assert!(shows(window, "4 / 4"), "{key:?}");
    }
}

/// Names a dance and draws its a by hand: full to the left of the middle, still to the right.
fn name_and_draw(window: &mut Window) {
    point_at(window, "dance/4");
    window.key_press(Key::E);
    window.run_steps(3);
    assert!(!shows(window, "Dance 5"));
    write(window, "name", "Squid");
    let plot = control(window, "curve/a").rect();
    let at = |x: f32, y: f32| plot.lerp_inside([x, y]);
    drag(window, &[at(0.01, 0.05), at(0.3, 0.05), at(0.5, 0.05), at(0.5, 0.547), at(0.99, 0.547)]);
    screenshot(window, "window-music-curves.png");
    click(window, "favorite");
    click(window, "lineage");
    assert!(shows(window, "Squid: bred from") && shows(window, "of generation 2: bred from"));
    assert!(shows(window, "of generation 1: from seed 2012"));
    screenshot(window, "window-music-lineage.png");
    window.key_press(Key::Escape);
    window.run_steps(2);
}

fn keep_on_the_shelf(window: &mut Window, folder: &Path) {
    click(window, "keep");
    write(window, "shelf/tags", "slow, sea");
    screenshot(window, "window-music-shelf.png");
    click(window, "shelf/keep");
    let kept: Vec<_> = std::fs::read_dir(folder.join("dances")).unwrap().collect();
    let preset = Preset::load(&kept[0].as_ref().unwrap().path()).unwrap();
    assert_eq!((kept.len(), preset.name.as_str()), (1, "Squid"));
    assert_eq!(preset.tags, ["slow", "sea"]);
    assert!(preset.lineage.len() > 3 && preset.lineage[0].edited);
    let a = &preset.mapping.amplification;
    let (low, high) = a.split_at(a.len() / 2);
    assert!(low[3..low.len() - 3].iter().all(|a| *a > 0.95), "{low:?}");
    assert!(high[3..].iter().all(|a| a.abs() < 0.1), "{high:?}");
}

#[test]
fn the_form_of_a_dance_that_cannot_be_kept_stays_open() {
    let folder = tempfile::tempdir().unwrap();
    let dances = folder.path().join("dances");
    std::fs::write(&dances, "no folder").unwrap();
    let files = ball_and_song(folder.path()).to_vec();
    let mut window = enter(Opening { folders: folders(folder.path()), files, ..Opening::default() });
    point_at(&mut window, "dance/4");
    window.key_press(Key::E);
    window.run_steps(3);
    click(&mut window, "keep");
    write(&mut window, "shelf/name", "Squid");
    click(&mut window, "shelf/keep");
    assert!(is_there(&window, "shelf/keep"), "the name is gone");
    std::fs::remove_file(&dances).unwrap();
    click(&mut window, "shelf/keep");
    assert!(!is_there(&window, "shelf/keep") && dances.read_dir().unwrap().count() == 1);
}

/// The stage hides everything; Escape comes back.
fn go_on_stage_and_back(window: &mut Window) {
    control(window, "back-to-gallery").click();
    window.run_steps(2);
    control(window, "perform-favorites").click();
    window.run_steps(4);
    assert!(!shows(window, "12 items") && !shows(window, "Chladni"));
    screenshot(window, "window-music-stage.png");
    window.key_press(Key::Escape);
    window.run_steps(3);
    assert!(shows(window, "12 items"));
}

/// A dance from the shelf is tried out where the gallery was.
fn resize_and_take_from_the_shelf(window: &mut Window) {
    window.get_by_role_and_label(Role::CheckBox, "Squid");
    for (size, next) in [(12, 16), (16, 9), (9, 6)] {
        assert!(shows(window, &format!("{size} items")));
        click(window, "gallery");
        click(window, &format!("gallery/{next}"));
        assert!(shows(window, &format!("{next} items")) && shows(window, "1 / 1"));
        assert!(is_there(window, &format!("dance/{next}")));
        assert!(!is_there(window, &format!("dance/{}", next + 1)));
    }
    click(window, "drawer/shelf");
    let kept = |window: &Window| control(window, "preset/Squid").rect().center();
    window.hover_at(kept(window));
    window.run_steps(2);
    // It is tried out where the gallery was.
    assert!(!is_there(window, "dance/5"));
    click(window, "preset/Squid");
    window.hover_at(Pos2::new(300.0, 300.0));
    window.run_steps(2);
    assert!(shows(window, "2 / 2"));
    window.get_by_role_and_label(Role::CheckBox, "Squid");
    screenshot(window, "window-music-reopened.png");
}

#[test]
fn what_was_bred_goes_on_on_another_shape_and_favorites_are_asked_about_on_closing() {
    let folder = tempfile::tempdir().unwrap();
    let ball = folder.path().join("ball.obj");
    chladni_mesh::save_mesh(&chladni_mesh::samples::icosphere(2), &ball).unwrap();
    let answers = Answers::default();
    let chooser = Box::new(answers.clone());
    let mut window = enter(Opening { folders: folders(folder.path()), chooser, ..Opening::default() });
    let close = |window: &mut Window| {
        ask_to_close(window);
        shows(window, "Save before closing?")
    };
    click(&mut window, "dance/2");
    click(&mut window, "dance/5");
    click(&mut window, "breed");
    assert!(!close(&mut window), "nothing was marked");
    point_at(&mut window, "dance/3");
    window.key_press(Key::F);
    window.run_steps(2);
    // A place that the next gallery does not have.
    point_at(&mut window, "dance/12");
    window.key_press(Key::E);
    window.run_steps(2);
    assert!(!is_there(&window, "dance/6"));
    click(&mut window, "gallery");
    click(&mut window, "gallery/12");
    assert!(shows(&window, "12 items") && shows(&window, "2 / 2"), "it has this size already");
    click(&mut window, "gallery");
    click(&mut window, "gallery/6");
    wait(&mut window, "the question", |w| shows(w, "Save before another gallery?"));
    click(&mut window, "keep-working");
    assert!(shows(&window, "12 items") && shows(&window, "2 / 2"));
    click(&mut window, "gallery");
    click(&mut window, "gallery/6");
    wait(&mut window, "the question", |w| shows(w, "Save before another gallery?"));
    click(&mut window, "lose-changes");
    wait(&mut window, "the other gallery", |w| shows(w, "6 items"));
    assert!(is_there(&window, "dance/6"), "an empty bench");
    point_at(&mut window, "dance/1");
    window.key_press(Key::M);
    window.run_steps(2);

    answers.add(ball);
    window.key_press_modifiers(Modifiers::COMMAND, Key::O);
    window.run_steps(2);
    wait(&mut window, "the ball", |w| !shows(w, "Opening"));
    window.run_steps(2);
    assert!(shows(&window, "2 / 2"));

    assert!(close(&mut window) && shows(&window, "with one favorite"));
    let session = folder.path().join("evening.toml");
    click(&mut window, "keep-working");
    answers.add(session.clone());
    window.key_press_modifiers(Modifiers::COMMAND, Key::S);
    window.run_steps(3);
    assert!(!close(&mut window));
    // Now that the show has a file, it lacks what is bred.
    point_at(&mut window, "dance/1");
    window.key_press(Key::M);
    window.run_steps(2);
    assert!(close(&mut window));
    answers.add(session.clone());
    click(&mut window, "save-and-close");
    assert!(Show::load(&session).unwrap().actions.len() == 7);
}

#[test]
fn a_close_up_stays_with_its_dance_and_ends_with_it() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = enter(Opening { folders: folders(folder.path()), ..Opening::default() });
    let choose_and_draw = |window: &mut Window, drawn: &str, keys: &[Key]| {
        click(window, "dance/2");
        click(window, "dance/5");
        point_at(window, drawn);
        for key in keys {
            window.key_press(*key);
            window.run_steps(3);
        }
    };
    let is_close = |window: &Window| is_there(window, "back-to-gallery");
    choose_and_draw(&mut window, "dance/3", &[Key::L, Key::E, Key::Enter]);
    assert!(shows(&window, "2 / 2") && is_close(&window), "it stays in its place");
    window.key_press(Key::M);
    window.run_steps(3);
    assert!(shows(&window, "3 / 3") && is_close(&window), "it is changed a little");
    window.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    window.run_steps(3);
    assert!(shows(&window, "2 / 3") && is_close(&window));
    window.key_press(Key::Escape);
    window.run_steps(3);
    choose_and_draw(&mut window, "dance/4", &[Key::E, Key::Enter]);
    assert!(shows(&window, "4 / 4") && !is_close(&window) && is_there(&window, "dance/4"), "it has gone");
}

#[test]
fn children_are_suggested_beside_the_frames_and_what_is_chosen_meanwhile_counts() {
    let folder = tempfile::tempdir().unwrap();
    let recovery = Some(folder.path().join("recovery"));
    let folders = Folders { recovery, ..folders(folder.path()) };
    let mut window = enter(Opening { folders, ..Opening::default() });
    click(&mut window, "suggest-children");
    click(&mut window, "dance/2");
    click(&mut window, "breed");
    wait(&mut window, "children", |w| shows(w, "2 / 2"));
    assert!((1..=12).all(|n| !is_chosen(&window, &format!("dance/{n}"))), "a new generation");
    // A choice made right after the request counts, too: judging begins again, and ends.
    click(&mut window, "dance/3");
    control(&window, "breed").click();
    window.run_steps(1);
    control(&window, "dance/4").click();
    wait(&mut window, "more children", |w| shows(w, "3 / 3"));
    // They would be missed.
    wait(&mut window, "a copy", |_| files::shows_in(folder.path()).len() == 1);
}

#[test]
fn a_double_click_puts_a_dance_on_stage_and_makes_it_no_parent() {
    let folder = tempfile::tempdir().unwrap();
    let files = ball_and_song(folder.path()).to_vec();
    let mut window = enter(Opening { folders: folders(folder.path()), files, ..Opening::default() });
    // Both clicks come in one moment.
    let now_secs = window.ctx.input(|input| input.time);
    window.input_mut().time = Some(now_secs);
    for _ in 0..2 {
        control(&window, "dance/2").click();
    }
    window.run_steps(3);
    window.input_mut().time = None;
    assert!(!shows(&window, "12 items"), "it is not on stage");
    window.key_press(Key::Escape);
    window.run_steps(3);
    assert!(shows(&window, "12 items") && !is_chosen(&window, "dance/2"));
}

#[test]
fn a_sheet_begins_with_sand_that_goes_with_it() {
    let folder = tempfile::tempdir().unwrap();
    let (sheet, ball) = (folder.path().join("sheet.obj"), folder.path().join("ball.obj"));
    let strip = |i: u32| [f64::from(i % 12) / 11.0, f64::from(i / 12) / 11.0, 0.0];
    let squares = (0..121).map(|i| i + i / 11);
    let mesh = chladni_mesh::TriMesh {
        positions: (0..144).map(strip).collect(),
        triangles: squares.flat_map(|v| [[v, v + 1, v + 13], [v, v + 13, v + 12]]).collect(),
        ..chladni_mesh::TriMesh::default()
    };
    chladni_mesh::save_mesh(&mesh, &sheet).unwrap();
    chladni_mesh::save_mesh(&chladni_mesh::samples::icosphere(2), &ball).unwrap();
    let answers = Answers::default();
    let chooser = Box::new(answers.clone());
    let mut window = enter(Opening { folders: folders(folder.path()), chooser, ..Opening::default() });
    click(&mut window, "drawer/knobs");
    let is_on = |window: &Window| control(window, "sand").accesskit_node().toggled() == Some(Toggled::True);
    assert!(!is_on(&window));
    for (file, sandy) in [(&sheet, true), (&ball, false), (&sheet, true)] {
        answers.add(file.clone());
        window.key_press_modifiers(Modifiers::COMMAND, Key::O);
        window.run_steps(2);
        wait(&mut window, "the other shape", |w| !shows(w, "Opening"));
        window.run_steps(20);
        assert_eq!(is_on(&window), sandy);
    }
    screenshot(&mut window, "window-music-sheet.png");
}

#[test]
fn the_buttons_of_a_dance_are_hit_apart() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = enter(Opening { folders: folders(folder.path()), ..Opening::default() });
    point_at(&mut window, "dance/1");
    let cell = control(&window, "dance/1").rect().shrink(1.0);
    let inside = |role: Role| {
        let controls = window.query_all_by_role(role).map(|control| control.rect());
        controls.filter(|rect| cell.contains_rect(*rect)).collect::<Vec<_>>()
    };
    let buttons = [inside(Role::CheckBox), inside(Role::Button)].concat();
    assert!(buttons.len() >= 4 && are_hit_apart(&buttons), "{buttons:?}");
    // A small one is measured from the edge of a wide one, not from its middle.
    let wide = egui::Rect::from_min_size(Pos2::ZERO, egui::vec2(100.0, 24.0));
    let small = |y| egui::Rect::from_center_size(egui::pos2(90.0, y), egui::Vec2::splat(10.0));
    assert_eq!([30.0, 37.0].map(|y| are_hit_apart(&[wide, small(y)])), [false, true]);
    assert_eq!([50.0, 62.0].map(|y| are_hit_apart(&[small(37.0), small(y)])), [false, true]);
}

/// Contrast of two colors (WCAG 2.2).
fn contrast(a: [u8; 4], b: [u8; 4]) -> f32 {
    let luminance = |[r, g, b, _]: [u8; 4]| {
        let [r, g, b] = [r, g, b].map(|level| (f32::from(level) / 255.0).powf(2.2));
        0.2126 * r + 0.7152 * g + 0.0722 * b
    };
    let (a, b) = (luminance(a), luminance(b));
    (a.max(b) + 0.05) / (a.min(b) + 0.05)
}

#[test]
fn borders_and_marks_are_seen_on_a_white_background() {
    let folder = tempfile::tempdir().unwrap();
    let folders = folders(folder.path());
    let white = "harmonics = 24\n[music]\nleans_back = false\nlook = \"\"\nbackground = \"white\"\n";
    std::fs::write(folders.settings.as_ref().unwrap(), white).unwrap();
    let mut window = enter(Opening { folders, ..Opening::default() });
    click(&mut window, "dance/2");
    window.run_steps(4);
    let cell = control(&window, "dance/2").rect();
    let picture = window.render().unwrap();
    let edge = (0..8).map(|x| picture.get_pixel(cell.left() as u32 + x, cell.center().y as u32).0);
    let edge: Vec<[u8; 4]> = edge.collect();
    let line = edge.iter().find(|[r, _, b, _]| i32::from(*r) - i32::from(*b) > 100);
    let is_seen =
        |line: &[u8; 4]| edge.iter().any(|beside| beside[0] < line[0] && contrast(*beside, *line) >= 3.0);
    assert!(line.is_some_and(is_seen), "{edge:?}");

    // Which marks are set is seen without their colors.
    let mut plates = || {
        let favorite = window.get_by_role_and_label(Role::CheckBox, "Favorite").rect();
        let picture = window.render().unwrap();
        let plate = picture.get_pixel(favorite.left() as u32 + 3, favorite.center().y as u32).0;
        window.key_press(Key::F);
        window.run_steps(3);
        plate
    };
    let (off, on) = (plates(), plates());
    assert!(contrast(off, on) >= 3.0, "{off:?}, {on:?}");
}
