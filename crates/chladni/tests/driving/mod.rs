//! The real window, driven as a person would, drawn without a display. Needs any Vulkan driver;
//! lavapipe will do.

use std::cell::RefCell;
use std::collections::VecDeque;
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::time::{Duration, Instant};

use chladni::studio::{Chooser, Kind, Opening, Studio};
use egui_kittest::Harness;

/// The window and what is on it.
pub type Window = Harness<'static, Studio>;

/// What the person will answer when asked for files, in turn.
#[derive(Clone, Default)]
pub struct Answers(Rc<RefCell<VecDeque<PathBuf>>>);

impl Answers {
    /// One more answer.
    pub fn add(&self, path: PathBuf) {
        self.0.borrow_mut().push_back(path);
    }
}

impl Chooser for Answers {
    fn open(&mut self, _: &[Kind<'_>]) -> Option<PathBuf> {
        self.0.borrow_mut().pop_front()
    }

    fn open_several(&mut self, _: &[Kind<'_>]) -> Vec<PathBuf> {
        self.0.borrow_mut().drain(..).collect()
    }

    fn save(&mut self, _: &[Kind<'_>], _: &Path) -> Option<PathBuf> {
        self.0.borrow_mut().pop_front()
    }
}

/// Opens the window.
pub fn open(opening: Opening) -> Window {
    // Pictures are for people; without them fewer pixels are quicker.
    let size =
        if std::env::var_os("CHLADNI_SCREENSHOTS").is_some() { [1280.0, 800.0] } else { [1000.0, 640.0] };
    Harness::builder()
        .with_size(size)
        .wgpu()
        .build_eframe(|creation| Studio::new(creation, opening).expect("a graphics device"))
}

/// Steps until `ready`, as a person waits; fails after a minute.
pub fn wait(window: &mut Window, what: &str, ready: impl Fn(&Window) -> bool) {
    let start = Instant::now();
    while !ready(window) {
        assert!(start.elapsed() < Duration::from_secs(60), "{what} did not happen within a minute");
        std::thread::sleep(Duration::from_millis(30));
        window.run_steps(1);
    }
}

/// Writes what the window shows, for a person to look at, where CHLADNI_SCREENSHOTS names a folder.
pub fn screenshot(window: &mut Window, name: &str) {
    window.run_steps(2);
    if let Some(folder) = std::env::var_os("CHLADNI_SCREENSHOTS") {
        let picture = window.render().expect("the window can be drawn");
        picture.save(Path::new(&folder).join(name)).expect("the folder is there");
    }
}
