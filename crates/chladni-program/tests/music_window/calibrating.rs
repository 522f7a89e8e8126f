//! A person taps to clicks and flashes.

use super::*;

/// Taps at whole seconds of the window's clock and `after_secs`, until the words change.
fn tap_to_flashes(window: &mut Window, after_secs: f64) {
    let begun = window.ctx.input(|input| input.time).ceil() + 2.0;
    for tap in 0..40 {
        if !shows(window, "Now tap with each flash") {
            break;
        }
        window.key_press(Key::Space);
        window.input_mut().time = Some(begun + f64::from(tap) + after_secs);
        window.run_steps(1);
    }
    window.input_mut().time = None;
    window.run_steps(2);
}

#[test]
fn taps_to_clicks_and_flashes_become_the_lateness_of_the_picture() {
    let folder = tempfile::tempdir().unwrap();
    let folders = folders(folder.path());
    let settings = folders.settings.clone().unwrap();
    let mut window = enter(Opening { folders, ..Opening::default() });
    click(&mut window, "drawer/songs");
    wait(&mut window, "the song before", plays);
    control(&window, "calibrate").click_accesskit();
    wait(&mut window, "the clicks", |w| shows(w, "with each click"));
    wait(&mut window, "the song's pause", |w| !plays(w));
    // All of them fall on almost the same place of one click.
    for _ in 0..200 {
        if shows(&window, "Now tap with each flash") {
            break;
        }
        window.key_press(Key::Space);
        window.run_steps(1);
    }
    tap_to_flashes(&mut window, 0.0);
    screenshot(&mut window, "calibrated.png");
    if shows(&window, "These taps cannot be used") {
        click(&mut window, "calibrate/cancel");
    } else {
        assert!(shows(&window, "than the sound is heard"));
        click(&mut window, "calibrate/use");
        let kept =
            || std::fs::read_to_string(&settings).is_ok_and(|text| text.contains("[music.picture_late_ms]"));
        wait(&mut window, "that it is kept", |_| kept());
    }
    assert!(!is_there(&window, "calibrate/tap"));
    wait(&mut window, "the song", plays);
    control(&window, "calibrate").click_accesskit();
    wait(&mut window, "the clicks again", |w| shows(w, "with each click"));
    wait(&mut window, "the pause", |w| !plays(w));
    window.key_press(Key::F1);
    wait(&mut window, "the keys that tap", |w| shows(w, "Tap with each click, then with each flash"));
    window.key_press(Key::F1);
    window.key_press(Key::Escape);
    wait(&mut window, "the window as it was", |w| !is_there(w, "calibrate/tap"));
    wait(&mut window, "the song as before", plays);
    // A question in front of the clicks has the keys.
    point_at(&mut window, "dance/3");
    window.key_press(Key::F);
    window.run_steps(2);
    control(&window, "calibrate").click_accesskit();
    wait(&mut window, "the clicks before the question", |w| shows(w, "with each click"));
    ask_to_close(&mut window);
    assert!(shows(&window, "Save before closing?"));
    window.key_press(Key::Space);
    window.key_press(Key::Escape);
    window.run_steps(3);
    assert!(!shows(&window, "Save before closing?") && shows(&window, "0 of "), "they went to the clicks");
    window.key_press(Key::Escape);
    wait(&mut window, "the window as before", |w| !is_there(w, "calibrate/tap"));
    wait(&mut window, "the song after the question", plays);
    // Elsewhere nobody taps: the clicks end, and the song goes on.
    control(&window, "calibrate").click_accesskit();
    wait(&mut window, "the clicks once more", |w| shows(w, "with each click"));
    wait(&mut window, "the second pause", |w| !plays(w));
    window.get_by_role_and_label(Role::Button, "Chladni").click_accesskit();
    wait(&mut window, "the start screen", |w| is_there(w, "room/1"));
    click(&mut window, "room/1");
    wait(&mut window, "the room", |w| is_there(w, "play"));
    assert!(!is_there(&window, "calibrate/tap"));
    wait(&mut window, "the song again", plays);
}
