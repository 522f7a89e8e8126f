//! Knobs, keys, menus, controllers, and windows of every size.

use super::clocks::{packet, send_until};
use super::*;

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
        control(&window, "room/1").click();
        wait(&mut window, "the gallery", |w| w.query_by_label_contains("12 items").is_some());
        if takes_pictures() {
            // Until there is something to hear.
            std::thread::sleep(std::time::Duration::from_millis(1500));
        }
        for dance in ["dance/2", "dance/7"] {
            click(&mut window, dance);
        }
        for key in [Key::F, Key::L] {
            window.key_press(key);
            window.run_steps(1);
        }
        window.run_steps(8);
        let screen = egui::Rect::from_min_size(Pos2::ZERO, egui::Vec2::from(*size)).expand(0.5);
        for id in ["dance/4", "dance/12", "play", "drawer/knobs", "drawer/remote", "tap", "gain"] {
            let rect = control(&window, id).rect();
            assert!(screen.contains_rect(rect), "{name}: {id} lies at {rect}");
        }
        let [breed, next] = ["breed", "next-song"].map(|id| control(&window, id).rect());
        assert!(!breed.intersects(next), "{name}: the bar is too full");
        // With room for the clock of a recording between them, which a shorter slider makes.
        let [time, seek] = ["time", "seek"].map(|id| control(&window, id).rect());
        let spare = breed.left() - time.right() + seek.width() - 40.0;
        assert!(spare > 90.0, "{name}: {spare} points are left");
        screenshot(&mut window, &format!("music-{name}.png"));
    }
}

#[test]
fn a_fader_is_learned_over_osc_and_remembered() {
    let folder = tempfile::tempdir().unwrap();
    let folders = folders(folder.path());
    let port = free_port();
    let settings = folders.settings.clone().unwrap();
    std::fs::write(&settings, format!("harmonics = 24\n[music]\nosc_port = {port}\n")).unwrap();
    let mut window = enter(Opening { folders: folders.clone(), ..Opening::default() });
    click(&mut window, "drawer/remote");
    assert!(shows(&window, &format!("Port {port}")));
    // It may have to be scrolled to.
    let learn = |window: &mut Window| {
        control(window, "learn/gain").click_accesskit();
        window.run_steps(2);
    };
    let waits = |window: &Window| {
        let learn = control(window, "learn/gain");
        learn.accesskit_node().toggled() == Some(Toggled::True)
    };
    learn(&mut window);
    assert!(waits(&window));
    // Out of sight, nothing waits for a control.
    for drawer in ["drawer/knobs", "drawer/remote"] {
        click(&mut window, drawer);
    }
    assert!(!waits(&window));
    learn(&mut window);
    send_until(&mut window, port, &packet("/1/f", 0.25), "/1/f");
    window.run_steps(1);
    screenshot(&mut window, "window-music-remote.png");
    click(&mut window, "drawer/knobs");
    // A quarter of the way from 0 to 20.
    assert!(window.query_all_by_value("5.00").next().is_some());
    let kept = std::fs::read_to_string(settings).unwrap();
    assert!(kept.contains("/1/f") && kept.contains("gain"), "{kept}");
}

#[test]
fn a_sample_is_opened_from_the_menu() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = enter(Opening { folders: folders(folder.path()), ..Opening::default() });
    for control in ["file", "samples", "sample/disc"] {
        click(&mut window, control);
    }
    wait(&mut window, "the disc", |w| shows(w, "Opening"));
}

/// Taking a picture fails where something on it has no name of its own.
#[test]
fn everything_in_a_menu_has_a_name_and_keys_act_on_the_dance_that_has_the_focus() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = enter(Opening { folders: folders(folder.path()), ..Opening::default() });
    for menu in ["file", "gallery", "generations"] {
        click(&mut window, menu);
        screenshot(&mut window, &format!("menu-{}.png", menu));
        window.key_press(Key::Escape);
        window.run_steps(3);
    }
    control(&window, "dance/3").click_secondary();
    window.run_steps(3);
    screenshot(&mut window, "menu-dance.png");
    window.key_press(Key::Escape);
    window.run_steps(3);

    control(&window, "dance/5").focus();
    window.run_steps(3);
    window.key_press(Key::Space);
    window.run_steps(3);
    assert!(is_chosen(&window, "dance/5"));
    window.key_press(Key::F);
    window.run_steps(3);
    screenshot(&mut window, "music-focus.png");
    click(&mut window, "drawer/shelf");
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
    click(&mut window, "drawer/knobs");
    for dance in ["dance/1", "dance/2"] {
        point_at(&mut window, dance);
        window.key_press(Key::E);
        window.run_steps(3);
        assert!(!shows(&window, "Dance 3"));
        window.key_press(Key::Escape);
        window.run_steps(2);
    }
    // Through all controls: into each number, and on without a change.
    let numbers = numbers_by_tab(&mut window);
    assert!(["Gain", "Side gain"].iter().all(|name| numbers.contains(*name)), "{numbers:?}");
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
    window.key_press(Key::Enter);
    window.run_steps(3);
    assert!(shows(&window, "Breeding needs at least 2 chosen items"));
    click(&mut window, "drawer/knobs");
    let idle = |window: &Window, id: &str| control(window, id).accesskit_node().is_disabled();
    for (form, side_gain, detail) in
        [("halves", true, false), ("filter", false, false), ("modal", false, true)]
    {
        click(&mut window, &format!("form/{form}"));
        assert_eq!((idle(&window, "side-gain"), idle(&window, "detail")), (side_gain, detail), "{form}");
        assert_eq!(shows(&window, "Without effect in halves"), side_gain, "{form}");
        assert_eq!(shows(&window, "Without effect in modal"), detail, "{form}");
        if form == "halves" {
            screenshot(&mut window, "window-music-halves.png");
        }
        point_at(&mut window, "dance/1");
        window.key_press(Key::E);
        window.run_steps(3);
        assert_eq!(shows(&window, "not in halves"), side_gain, "{form}");
        assert_eq!(window.query_by_role_and_label(Role::Slider, "μ").is_none(), side_gain, "{form}");
        window.key_press(Key::Escape);
        window.run_steps(2);
    }
}
