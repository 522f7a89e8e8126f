//! The real window, driven as a person would, drawn without a display. Needs any Vulkan driver;
//! lavapipe will do.

#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

use std::time::{Duration, Instant};

use chladni::studio::{Opening, Studio};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;

fn open(files: Vec<std::path::PathBuf>) -> Harness<'static, Studio> {
    Harness::builder().with_size([1280.0, 800.0]).wgpu().build_eframe(|creation| {
        Studio::new(creation, Opening { files, ..Opening::default() }).expect("a graphics device")
    })
}

/// Steps until `ready`, as a person waits; fails after a minute.
fn wait(
    harness: &mut Harness<'static, Studio>,
    what: &str,
    ready: impl Fn(&Harness<'static, Studio>) -> bool,
) {
    let start = Instant::now();
    while !ready(harness) {
        assert!(start.elapsed() < Duration::from_secs(60), "{what} did not happen within a minute");
        std::thread::sleep(Duration::from_millis(30));
        harness.run_steps(1);
    }
}

/// Writes what the window shows, for a person to look at, where CHLADNI_SCREENSHOTS names a folder.
fn screenshot(harness: &mut Harness<'static, Studio>, name: &str) {
    harness.run_steps(2);
    if let Some(folder) = std::env::var_os("CHLADNI_SCREENSHOTS") {
        let picture = harness.render().expect("the window can be drawn");
        picture.save(std::path::Path::new(&folder).join(name)).expect("the folder is there");
    }
}

#[test]
fn the_start_screen_leads_to_a_caricature_of_the_sample_head() {
    let mut harness = open(Vec::new());
    harness.run_steps(3);
    screenshot(&mut harness, "window-start.png");
    harness.get_by_label("Open Caricature").click();
    wait(&mut harness, "the sample head", |h| h.query_by_label("Layers").is_some());
    wait(&mut harness, "the match", |h| h.query_by_label("Covered").is_some());
    screenshot(&mut harness, "window-caricature.png");
}
