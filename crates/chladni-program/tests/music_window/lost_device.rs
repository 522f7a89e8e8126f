//! A driver that restarts takes the window's device with it.

use eframe::wgpu;

use super::*;

#[test]
fn the_dance_goes_on_in_another_window_when_the_device_is_lost() {
    goes_on_without(lose, "The graphics device was lost");
}

#[test]
fn the_dance_goes_on_in_another_window_when_the_memory_of_the_device_is_full() {
    goes_on_without(exhaust, "The graphics device was lost (its memory is full)");
}

/// Breeds a dance, does `harm` to the device, and finds all again in another window, which says why.
fn goes_on_without(harm: fn(&wgpu::Device), why: &str) {
    let folder = tempfile::tempdir().unwrap();
    let folders = folders(folder.path());
    let handover = Handover::default();
    // A busy machine may take longer for a few frames than a note lasts.
    let now = no_time;
    let opening =
        || Opening { folders: folders.clone(), handover: handover.clone(), now, ..Opening::default() };
    let size = [1000.0, 640.0];
    let Some((mut window, device)) = open_with_device(opening(), size) else { return };
    window.run_steps(3);
    control(&window, "room/1").click();
    wait(&mut window, "the gallery", |w| w.query_by_label_contains("12 items").is_some());
    window.run_steps(3);
    click(&mut window, "dance/2");
    click(&mut window, "dance/5");
    click(&mut window, "breed");
    click(&mut window, "dance/5");
    assert!(shows(&window, "2 / 2"));

    harm(&device);
    window.run_steps(2);
    assert!(handover.reason().is_some());
    drop(window);
    let (mut window, _) = open_with_device(opening(), size).expect("a device");
    wait(&mut window, "the note", |w| shows(w, why));
    wait(&mut window, "the gallery as it was", |w| shows(w, "2 / 2"));
    assert!(is_chosen(&window, "dance/5"));
    window.run_steps(10);
    screenshot(&mut window, "lost-device-music.png");
    wait(&mut window, "the dance", |w| pause(w).is_zero());
}

/// A person's work: how many generations there are, the last on screen, and who is chosen of it.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Done {
    generation: u64,
    chosen: [bool; 12],
}

impl Done {
    fn seen(window: &Window) -> Self {
        let generation = (1..=MOST).find(|g| shows(window, &format!("{g} / {g}"))).unwrap_or(0);
        Self { generation, chosen: std::array::from_fn(|i| is_chosen(window, &format!("dance/{}", i + 1))) }
    }
}

/// The most generations that are bred.
const MOST: u64 = 4;

/// A campaign: `CHLADNI_CASES=1000 cargo test --release -p chladni-program --test music_window any_moment` (docs/trust.md).
#[test]
fn the_dance_goes_on_with_a_device_lost_at_any_moment() {
    let cases = chladni_testdata::setting("CHLADNI_CASES", 6);
    let folder = tempfile::tempdir().unwrap();
    let folders = folders(folder.path());
    let files = ball_and_song(folder.path()).to_vec();
    let handover = Handover::default();
    let opening =
        |files| Opening { folders: folders.clone(), handover: handover.clone(), files, ..Opening::default() };
    let size = [1000.0, 640.0];
    let Some((mut window, mut device)) = open_with_device(opening(files), size) else { return };
    wait(&mut window, "the gallery", |w| w.query_by_label_contains("12 items").is_some());
    window.run_steps(3);
    let mut done = Done::seen(&window);
    assert_eq!(done, Done { generation: 1, chosen: [false; 12] });
    let mut chance = chladni_testdata::chance(1787);
    for case in 0..cases {
        let lost = device.clone();
        let driver = meanwhile(&mut chance, move || lost.destroy());
        let before = loop {
            let before = done;
            let parents = done.chosen.iter().filter(|is_chosen| **is_chosen).count();
            if parents > 2 && done.generation < MOST {
                // By name: several notices may lie over the place.
                control(&window, "breed").click_accesskit();
                window.run_steps(2);
                done = Done { generation: done.generation + 1, chosen: [false; 12] };
            } else {
                let dance = ((chance() >> 33) % 12) as usize;
                control(&window, &format!("dance/{}", dance + 1)).click_accesskit();
                window.run_steps(2);
                done.chosen[dance] = !done.chosen[dance];
            }
            // In the frame in which it is lost nothing may be drawn, and the next one hands over.
            wait(&mut window, "the gallery", |w| handover.reason().is_some() || is_there(w, "dance/12"));
            if handover.reason().is_some() {
                break before;
            }
            assert_eq!(Done::seen(&window), done, "case {case}");
        };
        driver.join().unwrap();
        drop(window);
        (window, device) = open_with_device(opening(Vec::new()), size).expect("a device");
        wait(&mut window, "the gallery", |w| is_there(w, "dance/12"));
        let kept = Done::seen(&window);
        assert!(kept == done || kept == before, "case {case}: {kept:?} of {done:?} after {before:?}");
        done = kept;
    }
}
