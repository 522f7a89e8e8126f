//! The music room as a person plays it.

#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

mod archive;
mod driving;

use std::net::{Ipv4Addr, UdpSocket};
use std::path::Path;

use chladni_music::{Preset, Show};
use chladni_program::studio::{Folders, Handover, Opening, Trace};
use chladni_sound::{Song, WavSample, write_wav};
use driving::{
    Answers, Window, lose, no_time, open, open_with, open_with_device, screenshot, shows, takes_pictures,
    wait,
};
use egui::accesskit::{Role, Toggled};
use egui::{Event, Key, Modifiers, PointerButton, Pos2};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};

/// Few harmonics are solved quickly.
fn folders(folder: &Path) -> Folders {
    let settings = folder.join("settings.toml");
    std::fs::write(&settings, "harmonics = 96\n").unwrap();
    Folders { settings: Some(settings), dances: Some(folder.join("dances")), ..Folders::default() }
}

fn enter(opening: Opening) -> Window {
    let opening = Opening { now: no_time, ..opening };
    let named = !opening.files.is_empty();
    // Pictures are for people: frames that come late would be drawn smaller. Without them fewer pixels are quicker.
    let builder = Harness::builder();
    let builder = if takes_pictures() {
        builder.with_size([1280.0, 800.0]).with_step_dt(1.0 / 60.0)
    } else {
        builder.with_size([1000.0, 640.0])
    };
    let mut window = open_with(opening, builder);
    window.run_steps(3);
    if !named {
        window.get_by_label("Open Music").click();
    }
    wait(&mut window, "the gallery", |w| w.query_by_label_contains("12 items").is_some());
    window.run_steps(3);
    window
}

fn click(window: &mut Window, label: &str) {
    window.get_by_label(label).click();
    window.run_steps(2);
}

fn click_containing(window: &mut Window, label: &str) {
    window.get_by_label_contains(label).click();
    window.run_steps(2);
}

fn write(window: &mut Window, field: &str, text: &str) {
    window.get_by_role_and_label(Role::TextInput, field).click();
    window.run_steps(2);
    window.get_by_role_and_label(Role::TextInput, field).type_text(text);
    window.run_steps(2);
}

fn is_chosen(window: &Window, dance: &str) -> bool {
    window.get_by_label(dance).accesskit_node().toggled() == Some(Toggled::True)
}

fn drag(window: &mut Window, points: &[Pos2]) {
    let button = |pos, pressed| Event::PointerButton {
        pos,
        button: PointerButton::Primary,
        pressed,
        modifiers: Modifiers::NONE,
    };
    window.event(Event::PointerMoved(points[0]));
    window.run_steps(1);
    window.event(button(points[0], true));
    for &point in points {
        window.event(Event::PointerMoved(point));
        window.run_steps(1);
    }
    window.event(button(points[points.len() - 1], false));
    window.run_steps(2);
}

/// How long the window may wait for its next frame.
fn pause(window: &Window) -> std::time::Duration {
    window.output().viewport_output[&egui::ViewportId::ROOT].repaint_delay
}

#[test]
fn a_paused_song_lets_the_gallery_rest() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = enter(Opening { folders: folders(folder.path()), ..Opening::default() });
    wait(&mut window, "the dance", |w| pause(w).is_zero());
    window.key_press(Key::Space);
    wait(&mut window, "rest", |w| pause(w) >= std::time::Duration::from_millis(20));
    window.run_steps(5);
    assert!(!pause(&window).is_zero());
    window.key_press(Key::Space);
    wait(&mut window, "the dance", |w| pause(w).is_zero());
}

#[test]
fn the_dance_goes_on_in_another_window_when_the_device_is_lost() {
    let folder = tempfile::tempdir().unwrap();
    let folders = folders(folder.path());
    let handover = Handover::default();
    let opening = || Opening { folders: folders.clone(), handover: handover.clone(), ..Opening::default() };
    let size = [1000.0, 640.0];
    let (mut window, device) = open_with_device(opening(), size);
    window.run_steps(3);
    window.get_by_label("Open Music").click();
    wait(&mut window, "the gallery", |w| w.query_by_label_contains("12 items").is_some());
    window.run_steps(3);
    click(&mut window, "Dance 2");
    click(&mut window, "Dance 5");
    click_containing(&mut window, "Breed 2");
    click(&mut window, "Dance 5");
    assert!(shows(&window, "2 / 2"));

    lose(&device);
    window.run_steps(2);
    assert!(handover.reason().is_some());
    drop(window);
    let (mut window, _) = open_with_device(opening(), size);
    window.run_steps(2);
    assert!(shows(&window, "The graphics device was lost") && shows(&window, "2 / 2"));
    assert!(is_chosen(&window, "Dance 5"));
    window.run_steps(10);
    screenshot(&mut window, "lost-device-music.png");
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

    click(&mut window, "Dance 2");
    click(&mut window, "Dance 5");
    assert!(is_chosen(&window, "Dance 5") && !is_chosen(&window, "Dance 1"));
    click_containing(&mut window, "Breed 2");
    assert!(shows(&window, "2 / 2"));
    for dance in ["Dance 1", "Dance 3", "Dance 8"] {
        click(&mut window, dance);
    }
    window.key_press(Key::Enter);
    window.run_steps(2);
    assert!(shows(&window, "3 / 3"));

    // Back to any generation, and forth again.
    click(&mut window, "3 / 3");
    click(&mut window, "Generation 1, the beginning");
    assert!(shows(&window, "1 / 3") && is_chosen(&window, "Dance 5"));
    click(&mut window, "1 / 3");
    click(&mut window, "Generation 3, from 2");
    assert!(shows(&window, "3 / 3") && !is_chosen(&window, "Dance 5"));

    // By keys alone: the mark goes right and down, what is marked is chosen, locked and changed.
    window.hover_at(Pos2::new(500.0, 60.0));
    window.run_steps(2);
    for key in [Key::ArrowRight, Key::ArrowRight, Key::ArrowDown, Key::C, Key::L] {
        window.key_press(key);
        window.run_steps(1);
    }
    assert!(is_chosen(&window, "Dance 6") && !is_chosen(&window, "Dance 5"));
    for key in [Key::C, Key::M] {
        window.key_press(key);
        window.run_steps(1);
    }
    assert!(shows(&window, "4 / 4") && !is_chosen(&window, "Dance 6"));
    window.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    window.run_steps(2);
    assert!(shows(&window, "3 / 4"));
    window.key_press_modifiers(Modifiers::COMMAND | Modifiers::SHIFT, Key::Z);
    window.run_steps(2);
    assert!(shows(&window, "4 / 4"));

    // Name one and draw its a by hand: full to the left of the middle, still to the right.
    window.get_by_label("Dance 4").hover();
    window.run_steps(2);
    window.key_press(Key::E);
    window.run_steps(3);
    assert!(!shows(&window, "Dance 5"));
    write(&mut window, "Name", "Squid");
    let plot = window.get_by_label("a: how strongly each harmonic answers").rect();
    let at = |x: f32, y: f32| plot.lerp_inside([x, y]);
    drag(&mut window, &[at(0.01, 0.05), at(0.3, 0.05), at(0.5, 0.05), at(0.5, 0.547), at(0.99, 0.547)]);
    screenshot(&mut window, "window-music-curves.png");
    click_containing(&mut window, "Favourite");
    click_containing(&mut window, "Lineage");
    assert!(shows(&window, "Squid: bred from") && shows(&window, "of generation 2: bred from"));
    assert!(shows(&window, "of generation 1: from seed 2012"));
    screenshot(&mut window, "window-music-lineage.png");
    window.key_press(Key::Escape);
    window.run_steps(2);

    click_containing(&mut window, "Keep …");
    write(&mut window, "Tags", "slow, sea");
    screenshot(&mut window, "window-music-shelf.png");
    click(&mut window, "Keep");
    let kept: Vec<_> = std::fs::read_dir(folder.path().join("dances")).unwrap().collect();
    let preset = Preset::load(&kept[0].as_ref().unwrap().path()).unwrap();
    assert_eq!((kept.len(), preset.name.as_str()), (1, "Squid"));
    assert_eq!(preset.tags, ["slow", "sea"]);
    assert!(preset.lineage.len() > 3 && preset.lineage[0].edited);
    let a = &preset.mapping.amplification;
    let (low, high) = a.split_at(a.len() / 2);
    assert!(low[3..low.len() - 3].iter().all(|a| *a > 0.95), "{low:?}");
    assert!(high[3..].iter().all(|a| a.abs() < 0.1), "{high:?}");

    // The stage hides everything; Escape comes back.
    window.get_by_label_contains("Gallery").click();
    window.run_steps(2);
    window.get_all_by_label_contains("Stage").last().unwrap().click();
    window.run_steps(4);
    assert!(!shows(&window, "12 items") && !shows(&window, "Chladni"));
    screenshot(&mut window, "window-music-stage.png");
    window.key_press(Key::Escape);
    window.run_steps(3);
    assert!(shows(&window, "12 items"));
    let session = folder.path().join("evening.toml");
    answers.add(session.clone());
    click_containing(&mut window, "File");
    click_containing(&mut window, "Save show");
    drop(window);

    // What was done in the window is a film, the same one each time.
    let film = |name: &str| {
        let coefficients = folder.path().join(name);
        let [session, out] = [&session, &coefficients].map(|path| path.to_str().unwrap());
        let dance =
            ["chladni", "--quiet", "dance", "sample:octopus", "sample:tune", "-k", "96", "--duration", "1"];
        let told =
            chladni_program::cli::run(dance.iter().chain(&["--session", session, "--coefficients", out]));
        assert_eq!(told, 0);
        archive::array(&coefficients, "coefficients").unwrap().values
    };
    let first = film("first.npz");
    assert!(first.iter().any(|c| *c != 0.0) && first == film("second.npz"));

    // The next evening: the shelf is as it was, and the session goes on.
    let mut window = enter(Opening { folders, files: vec![session.clone()], ..Opening::default() });
    wait(&mut window, "the show", |w| shows(w, "4 / 4"));
    window.get_by_role_and_label(Role::CheckBox, "Squid");
    for (size, next) in [(12, 16), (16, 9), (9, 6)] {
        click_containing(&mut window, &format!("{size} items, seed 2012"));
        click(&mut window, &format!("{next} items"));
        assert!(shows(&window, &format!("{next} items, seed 2012")) && shows(&window, "1 / 1"));
        assert!(window.query_by_label(&format!("Dance {next}")).is_some());
        assert!(window.query_by_label(&format!("Dance {}", next + 1)).is_none());
    }
    click(&mut window, "Shelf");
    let kept = |window: &Window| window.get_by_role_and_label(Role::Button, "Squid").rect().center();
    window.hover_at(kept(&window));
    window.run_steps(2);
    // It is tried out where the gallery was.
    assert!(window.query_by_label("Dance 5").is_none());
    window.get_by_role_and_label(Role::Button, "Squid").click();
    window.run_steps(2);
    window.hover_at(Pos2::new(300.0, 300.0));
    window.run_steps(2);
    assert!(shows(&window, "2 / 2"));
    window.get_by_role_and_label(Role::CheckBox, "Squid");
    screenshot(&mut window, "window-music-reopened.png");
}

#[test]
fn what_was_bred_goes_on_on_another_shape_and_favourites_are_asked_about_on_closing() {
    let folder = tempfile::tempdir().unwrap();
    let ball = folder.path().join("ball.obj");
    chladni_mesh::save_mesh(&chladni_mesh::samples::icosphere(2), &ball).unwrap();
    let answers = Answers::default();
    let chooser = Box::new(answers.clone());
    let mut window = enter(Opening { folders: folders(folder.path()), chooser, ..Opening::default() });
    let close = |window: &mut Window| {
        for close in [true, false] {
            let viewport = window.input_mut().viewports.entry(egui::ViewportId::ROOT).or_default();
            viewport.events.clear();
            viewport.events.extend(close.then_some(egui::ViewportEvent::Close));
            window.run_steps(2);
        }
        shows(window, "Save before closing?")
    };
    click(&mut window, "Dance 2");
    click(&mut window, "Dance 5");
    click_containing(&mut window, "Breed 2");
    assert!(!close(&mut window), "nothing was marked");
    window.get_by_label("Dance 3").hover();
    window.run_steps(2);
    window.key_press(Key::F);
    window.run_steps(2);
    // A place that the next gallery does not have.
    window.get_by_label("Dance 12").hover();
    window.run_steps(2);
    window.key_press(Key::E);
    window.run_steps(2);
    assert!(window.query_by_label("Dance 6").is_none());
    click_containing(&mut window, "12 items, seed 2012");
    click(&mut window, "6 items");
    assert!(window.query_by_label("Dance 6").is_some(), "an empty bench");
    window.get_by_label("Dance 1").hover();
    window.run_steps(2);
    window.key_press(Key::M);
    window.run_steps(2);

    answers.add(ball);
    window.key_press_modifiers(Modifiers::COMMAND, Key::O);
    window.run_steps(2);
    wait(&mut window, "the ball", |w| !shows(w, "Opening"));
    window.run_steps(2);
    assert!(shows(&window, "2 / 2"));

    assert!(close(&mut window) && shows(&window, "with one favourite"));
    let session = folder.path().join("evening.toml");
    answers.add(session.clone());
    click(&mut window, "Save and close");
    assert!(Show::load(&session).unwrap().actions.len() == 6);
}

/// Pictures of the room on usual screens, and that nothing on them hangs over their edge.
#[test]
fn the_room_fits_every_screen() {
    let folder = tempfile::tempdir().unwrap();
    let screens: &[(&str, [f32; 2], f32, bool)] = &[
        ("least", [900.0, 600.0], 1.0, false),
        ("laptop", [1366.0, 768.0], 1.0, true),
        ("desk", [1920.0, 1080.0], 1.0, false),
        ("desk-light", [1920.0, 1080.0], 1.0, true),
        ("4k", [1920.0, 1080.0], 2.0, false),
        ("4k-light", [1920.0, 1080.0], 2.0, true),
    ];
    let shown = if takes_pictures() { screens } else { &screens[..1] };
    for (name, size, pixels_per_point, light) in shown {
        let folders = folders(folder.path());
        let settings = folders.settings.clone().unwrap();
        std::fs::write(settings, format!("harmonics = 96\nlight = {light}\n")).unwrap();
        let builder = Harness::builder().with_size(*size).with_pixels_per_point(*pixels_per_point);
        let mut window = open_with(Opening { folders, now: no_time, ..Opening::default() }, builder);
        window.run_steps(3);
        window.get_by_label("Open Music").click();
        wait(&mut window, "the gallery", |w| w.query_by_label_contains("12 items").is_some());
        if takes_pictures() {
            // Until there is something to hear.
            std::thread::sleep(std::time::Duration::from_millis(1500));
        }
        for dance in ["Dance 2", "Dance 7"] {
            click(&mut window, dance);
        }
        for key in [Key::F, Key::L] {
            window.key_press(key);
            window.run_steps(1);
        }
        window.run_steps(8);
        let screen = egui::Rect::from_min_size(Pos2::ZERO, egui::Vec2::from(*size)).expand(0.5);
        for label in ["Dance 4", "Dance 12", "Play", "Knobs", "Remote", "Tap", "Gain"] {
            // Where a song plays, the button is for a pause.
            let label = if label == "Play" && shows(&window, "Pause") { "Pause" } else { label };
            let found = window.query_all_by_label(label).last();
            let rect = found.unwrap_or_else(|| panic!("{name}: there is no {label}")).rect();
            assert!(screen.contains_rect(rect), "{name}: {label} lies at {rect}");
        }
        let overlap = |a: &str, b: &str| {
            let rect = |label: &str| window.query_all_by_label_contains(label).next().unwrap().rect();
            rect(a).intersects(rect(b))
        };
        assert!(!overlap("Breed 2", "Next song"), "{name}: the bar is too full");
        screenshot(&mut window, &format!("music-{name}.png"));
    }
}

#[test]
fn a_fader_is_learned_over_osc_and_remembered() {
    let folder = tempfile::tempdir().unwrap();
    let folders = folders(folder.path());
    // Any port that is free now.
    let port = UdpSocket::bind((Ipv4Addr::LOCALHOST, 0)).unwrap().local_addr().unwrap().port();
    let settings = folders.settings.clone().unwrap();
    std::fs::write(&settings, format!("harmonics = 24\n[music]\nosc_port = {port}\n")).unwrap();
    let mut window = enter(Opening { folders: folders.clone(), ..Opening::default() });
    click(&mut window, "Remote");
    assert!(shows(&window, &format!("Port {port}")));
    click(&mut window, "Learn Gain");
    let socket = UdpSocket::bind((Ipv4Addr::LOCALHOST, 0)).unwrap();
    // "/1/f" with one float, by the book: address, type tags, big-endian number.
    let packet = [&b"/1/f\0\0\0\0,f\0\0"[..], &0.25f32.to_be_bytes()].concat();
    for tries in 0.. {
        assert!(tries < 50, "the fader is not learned");
        socket.send_to(&packet, (Ipv4Addr::LOCALHOST, port)).unwrap();
        std::thread::sleep(std::time::Duration::from_millis(20));
        window.run_steps(1);
        if shows(&window, "/1/f") {
            break;
        }
    }
    window.run_steps(1);
    screenshot(&mut window, "window-music-remote.png");
    click(&mut window, "Knobs");
    // A quarter of the way from 0 to 20.
    assert!(window.query_all_by_value("5.00").next().is_some());
    let kept = std::fs::read_to_string(settings).unwrap();
    assert!(kept.contains("/1/f") && kept.contains("gain"), "{kept}");
}

/// Taking a picture fails where something on it has no name of its own.
#[test]
fn everything_in_a_menu_has_a_name_and_keys_act_on_the_dance_that_has_the_focus() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = enter(Opening { folders: folders(folder.path()), ..Opening::default() });
    for menu in ["File", "12 items, seed 2012", "1 / 1"] {
        click(&mut window, menu);
        screenshot(&mut window, &format!("menu-{}.png", menu.replace([' ', '/', ','], "")));
        window.key_press(Key::Escape);
        window.run_steps(3);
    }
    window.get_by_label("Dance 3").click_secondary();
    window.run_steps(3);
    screenshot(&mut window, "menu-dance.png");
    window.key_press(Key::Escape);
    window.run_steps(3);

    window.get_by_label("Dance 5").focus();
    window.run_steps(3);
    window.key_press(Key::Space);
    window.run_steps(3);
    assert!(is_chosen(&window, "Dance 5"));
    window.key_press(Key::F);
    window.run_steps(3);
    screenshot(&mut window, "music-focus.png");
    click(&mut window, "Shelf");
    assert!(shows(&window, "Keep on the shelf: Dance 5"));
}

#[test]
fn looking_at_knobs_dances_and_voices_changes_none_of_them() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let project = path("wild.chladni");
    let run = |arguments: &[&str]| chladni_program::cli::run(["chladni", "--quiet"].iter().chain(arguments));
    let name = project.to_str().unwrap();
    assert_eq!(run(&["project", "new", "sample:head", "-o", name, "--harmonics", "24"]), 0);
    assert_eq!(run(&["project", "add-layer", name, "--template", "ellipsoid", "--mu", "-2"]), 0);
    // Values that no slider of two decimals, or from -4 to 4, would have given.
    let actions = [
        "do = \"set\"\nparameter = \"gain\"\nvalue = 1.2345",
        "do = \"set-item-gain\"\nitem = 0\ngain = 6.54321",
        "do = \"set-voice\"\nvoice = 0\nsettings = { driver = \"side\", gain = 7.777 }",
    ]
    .map(|text| format!("[[actions]]\nat_secs = 0.0\nat_beat = 0.0\n{text}\n"))
    .concat();
    std::fs::write(path("before.toml"), format!("format_version = 1\nseed = 5\nsize = 6\n{actions}"))
        .unwrap();
    let answers = Answers::default();
    let chooser = Box::new(answers.clone());
    let mut window = enter(Opening { folders: folders(folder.path()), chooser, ..Opening::default() });
    answers.add(project);
    window.key_press_modifiers(Modifiers::COMMAND, Key::O);
    wait(&mut window, "the voice", |w| w.query_all_by_label("Beat").count() == 1);
    answers.add(path("before.toml"));
    window.key_press_modifiers(Modifiers::COMMAND, Key::O);
    wait(&mut window, "the session", |w| shows(w, "6 items"));
    click(&mut window, "Knobs");
    for dance in ["Dance 1", "Dance 2"] {
        window.get_by_label(dance).hover();
        window.run_steps(2);
        window.key_press(Key::E);
        window.run_steps(3);
        assert!(!shows(&window, "Dance 3"));
        window.key_press(Key::Escape);
        window.run_steps(2);
    }
    answers.add(path("after.toml"));
    window.key_press_modifiers(Modifiers::COMMAND, Key::S);
    window.run_steps(3);
    let [before, after] = ["before.toml", "after.toml"].map(|name| Show::load(&path(name)).unwrap());
    assert_eq!(before.actions, after.actions);
}

#[test]
fn a_control_without_effect_in_a_form_says_so_and_is_inactive() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = enter(Opening { folders: folders(folder.path()), ..Opening::default() });
    click(&mut window, "Knobs");
    let idle = |window: &Window, name: &str| {
        window.get_by_role_and_label(Role::Slider, name).accesskit_node().is_disabled()
    };
    for (form, side_gain, detail) in
        [("Halves", true, false), ("Filter", false, false), ("Modal", false, true)]
    {
        click(&mut window, form);
        assert_eq!((idle(&window, "Side gain"), idle(&window, "Fine detail")), (side_gain, detail), "{form}");
        assert_eq!(shows(&window, "Without effect in halves"), side_gain, "{form}");
        assert_eq!(shows(&window, "Without effect in modal"), detail, "{form}");
        if form == "Halves" {
            screenshot(&mut window, "window-music-halves.png");
        }
        window.get_by_label("Dance 1").hover();
        window.run_steps(2);
        window.key_press(Key::E);
        window.run_steps(3);
        assert_eq!(shows(&window, "not in halves"), side_gain, "{form}");
        assert_eq!(window.query_by_role_and_label(Role::Slider, "μ").is_none(), side_gain, "{form}");
        window.key_press(Key::Escape);
        window.run_steps(2);
    }
}

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
    for (name, told) in [
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
        wait(&mut window, &format!("word of {name}"), |w| shows(w, told));
        assert!(window.query_by_label("Dance 6").is_some(), "{name} took the gallery away");
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
    click(&mut window, "Songs");
    assert!(shows(&window, "sample tune"));
    let songs = ["first.wav", "second.wav"].map(|name| folder.path().join(name));
    for song in &songs {
        let second = vec![0.0; 44_100];
        let silence = Song { rate_hz: 44_100, left: second.clone(), right: second };
        write_wav(song, &silence, WavSample::Int16).unwrap();
        answers.add(song.clone());
    }
    click_containing(&mut window, "Add songs …");
    assert!(shows(&window, "first") && shows(&window, "second") && !shows(&window, "Remove sample tune"));
    screenshot(&mut window, "window-music-songs.png");
    click(&mut window, "Remove first");
    assert!(!shows(&window, "Remove first") && shows(&window, "Remove second"));

    click(&mut window, "Look");
    click(&mut window, "Bronze");
    click(&mut window, "Slate");
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
    click_containing(&mut window, "File");
    click_containing(&mut window, "Open …");
    click(&mut window, "Body");
    wait(&mut window, "the voices", |w| w.query_all_by_label("Beat").count() == 2);
    screenshot(&mut window, "window-music-voices.png");
    click_containing(&mut window, "Show harmonics");
    window.run_steps(2);
    assert!(shows(&window, "Extrema and their") && shows(&window, "antisymmetric"));
    screenshot(&mut window, "window-music-harmonics.png");
    wait(&mut window, "rest", |w| !pause(w).is_zero());
    window.key_press(Key::Escape);
    window.run_steps(2);
    assert!(window.query_by_label("Dance 1").is_some());
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
    click(&mut window, "Small");
    click(&mut window, "12");
    screenshot(&mut window, "window-music-film.png");
    click(&mut window, "Film to …");
    wait(&mut window, "progress", |w| shows(w, "Filming film.gif"));
    screenshot(&mut window, "window-music-filming.png");
    wait(&mut window, "the film", |w| shows(w, "Filmed"));
    let film = std::fs::read(path("film.gif")).unwrap();
    assert_eq!(&film[..6], b"GIF89a");
    assert_eq!([film[6], film[7], film[8], film[9]], [128, 2, 104, 1], "640 × 360");
}

/// A ball that is quickly solved and drawn, and four seconds of a song with a beat, of which the channels differ.
fn ball_and_song(folder: &Path) -> [std::path::PathBuf; 2] {
    let [ball, wav] = ["ball.obj", "song.wav"].map(|name| folder.join(name));
    let mut mesh = chladni_mesh::samples::icosphere(2);
    for p in &mut mesh.positions {
        p[1] *= 1.3 + 0.2 * p[0];
        p[2] *= 0.9 + 0.1 * p[1];
    }
    chladni_mesh::save_mesh(&mesh, &ball).unwrap();
    let mut song = chladni_sound::sample_tune();
    let from = 6 * song.rate_hz as usize;
    song.left = song.left[from..from + 4 * song.rate_hz as usize].to_vec();
    song.right = song.right[from..from + 4 * song.rate_hz as usize].to_vec();
    write_wav(&wav, &song, WavSample::Int16).unwrap();
    [ball, wav]
}

/// A window on a ball and a song, which has been read, and where its shows go.
fn recorded(folder: &Path, trace: &Trace) -> (Window, Answers) {
    let answers = Answers::default();
    let chooser = Box::new(answers.clone());
    let files = ball_and_song(folder).to_vec();
    let opening = Opening {
        folders: folders(folder),
        chooser,
        files,
        trace: Some(trace.clone()),
        // A slow machine would leave harmonics out that films have.
        now: no_time,
        ..Opening::default()
    };
    // Frames that come late would be drawn smaller than a film's.
    let builder = Harness::builder().with_size([1000.0, 640.0]).with_step_dt(1.0 / 60.0);
    let mut window = open_with(opening, builder);
    wait(&mut window, "the gallery", |w| w.query_by_label_contains("12 items").is_some());
    wait(&mut window, "the song", |_| trace.borrow().last().is_some_and(|frame| frame.is_known));
    window.run_steps(5);
    (window, answers)
}

/// Steps for a while, as time goes by.
fn run_for(window: &mut Window, secs: f64) {
    let start = std::time::Instant::now();
    while start.elapsed().as_secs_f64() < secs {
        std::thread::sleep(std::time::Duration::from_millis(20));
        window.run_steps(1);
    }
}

#[test]
fn a_run_of_the_window_filmed_by_the_command_has_the_same_coefficients_bit_for_bit() {
    let folder = tempfile::tempdir().unwrap();
    let trace = Trace::default();
    let (mut window, answers) = recorded(folder.path(), &trace);
    // It plays, breeds, turns knobs, pauses, leaps, and puts a dance on stage.
    click(&mut window, "Dance 2");
    click(&mut window, "Dance 5");
    click_containing(&mut window, "Breed 2");
    run_for(&mut window, 0.4);
    click(&mut window, "Halves");
    run_for(&mut window, 0.3);
    window.key_press(Key::Space);
    run_for(&mut window, 1.0);
    window.key_press(Key::Space);
    run_for(&mut window, 0.3);
    let slider = window.get_by_label("Where in the song").rect();
    drag(&mut window, &[slider.lerp_inside([0.12, 0.5])]);
    run_for(&mut window, 0.5);
    window.get_by_label("Dance 3").hover();
    window.run_steps(2);
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
    // From when the song was known, but not while what was heard before it faded.
    let known = frames.iter().find(|frame| frame.is_known).unwrap().at_secs + 0.4;
    let acts: Vec<f64> = show.actions.iter().map(|line| line.moment.at_secs).collect();
    // In a frame in which something is done it is not seen yet.
    let end = show.duration_secs.unwrap() - 0.1;
    let steady = |at_secs: f64| at_secs > known && at_secs < end && !acts.contains(&at_secs);
    let steady: Vec<_> = frames.iter().filter(|frame| steady(frame.at_secs)).collect();
    let mut compared = 0;
    for frame in steady.iter().step_by((steady.len() / 12).max(1)) {
        let out = folder.path().join("frame.npz");
        let start = frame.at_secs.to_string();
        let [show, npz] = [&show_file, &out].map(|path| path.to_str().unwrap());
        let dance = ["chladni", "--quiet", "dance", "--show", show, "--start", &start, "--duration", "0.03"];
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
            show_file
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
    click(&mut window, "Look");
    click(&mut window, "Bronze");
    // Turned, shifted and nearer.
    let middle = window.get_by_label("Dance 6").rect().center();
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
    window.event(Event::MouseWheel {
        unit: egui::MouseWheelUnit::Point,
        delta: egui::vec2(0.0, 50.0),
        phase: egui::TouchPhase::Move,
        modifiers: Modifiers::NONE,
        source: egui::MouseWheelSource::Wheel,
    });
    run_for(&mut window, 0.5);
    window.event(Event::PointerMoved(window.get_by_label("Dance 3").rect().center()));
    window.run_steps(2);
    window.key_press(Key::S);
    run_for(&mut window, 1.2);
    window.key_press(Key::Space);
    // Until it rests, and is drawn as finely as a film.
    run_for(&mut window, 1.5);
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
fn a_show_opens_with_its_shape_its_songs_its_look_and_its_view() {
    let folder = tempfile::tempdir().unwrap();
    let trace = Trace::default();
    let (mut window, answers) = recorded(folder.path(), &trace);
    click(&mut window, "Look");
    click(&mut window, "Clay");
    window.get_by_label("Dance 3").hover();
    window.run_steps(2);
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
    click(&mut window, "Shelf");
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
    click(&mut window, "Songs");
    window.get_by_role_and_label(Role::SpinButton, "Volume").focus();
    window.run_steps(2);
    window.get_by_role_and_label(Role::SpinButton, "Volume").type_text("0.25");
    window.key_press(Key::Enter);
    window.run_steps(3);
    assert!(shows(&window, "The system's own"));
    screenshot(&mut window, "window-music-sound.png");
    drop(window);
    let kept = std::fs::read_to_string(settings).unwrap();
    assert!(kept.contains("volume = 0.25"), "{kept}");
}

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
    click_containing(&mut window, "Open …");
    wait(&mut window, "the gallery", |w| w.query_by_label_contains("12 items").is_some());
}
