//! The real window, driven as a person would, drawn and painted by the processor without a display. Only tests of lost
//! devices, and those that compare both painters, need a Vulkan driver; lavapipe will do.

mod names;
#[allow(dead_code, reason = "each test program uses a part")]
pub mod painted;
#[allow(dead_code, reason = "each test program uses a part")]
pub mod person;

use std::cell::{Cell, RefCell};
use std::collections::VecDeque;
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use chladni_program::studio::{Chooser, Opening, Purpose, Request, Studio};
use chladni_view::{Draw, Gpu};
use eframe::wgpu;
use egui_kittest::kittest::{NodeT, Queryable};
use egui_kittest::{Harness, HarnessBuilder, Node};
use painted::Painted;

/// The window and what is on it.
pub type Window = Harness<'static, Studio>;

/// The person's answers to file dialogs, in turn, and the last name that was offered.
#[derive(Clone, Default)]
pub struct Answers(
    Rc<RefCell<VecDeque<PathBuf>>>,
    Rc<RefCell<Vec<String>>>,
    Rc<RefCell<Option<Vec<PathBuf>>>>,
    Rc<Cell<bool>>,
);

impl Answers {
    /// One more answer.
    pub fn add(&self, path: impl Into<PathBuf>) {
        self.0.borrow_mut().push_back(path.into());
    }

    /// The person looks at a dialog and says nothing, or goes on.
    #[allow(dead_code, reason = "each test program uses a part")]
    pub fn hesitate(&self, still: bool) {
        self.3.set(still);
    }

    /// Extensions that the person could choose from when last asked.
    #[allow(dead_code, reason = "each test program uses a part")]
    pub fn offered(&self) -> Vec<String> {
        self.1.borrow().clone()
    }

    /// The next answer, or all of them where several files are asked for.
    fn give(&self, request: &Request) -> Vec<PathBuf> {
        let extensions = request.kinds.iter().flat_map(|(_, extensions)| extensions);
        *self.1.borrow_mut() = extensions.cloned().collect();
        let most = if request.purpose == Purpose::OpenSeveral { usize::MAX } else { 1 };
        let mut answers = self.0.borrow_mut();
        let count = answers.len().min(most);
        answers.drain(..count).collect()
    }
}

impl Chooser for Answers {
    fn ask(&mut self, request: Request) -> Vec<PathBuf> {
        self.give(&request)
    }

    fn begin(&mut self, request: Request) -> bool {
        if self.2.borrow().is_some() {
            return false;
        }
        let files = self.give(&request);
        *self.2.borrow_mut() = Some(files);
        true
    }

    fn answer(&mut self) -> Option<Vec<PathBuf>> {
        if self.3.get() { None } else { self.2.borrow_mut().take() }
    }
}

/// Whether somebody wants to see what the window shows.
pub fn takes_pictures() -> bool {
    std::env::var_os("CHLADNI_SCREENSHOTS").is_some()
}

/// A file as a desktop hands it over.
#[derive(Debug)]
struct Dropped(PathBuf);

impl egui::DroppedFile for Dropped {
    fn path(&self) -> &Path {
        &self.0
    }

    fn bytes(&self) -> Result<Vec<u8>, String> {
        std::fs::read(&self.0).map_err(|why| why.to_string())
    }
}

/// Drops files on the window, all at once.
#[allow(dead_code, reason = "each test program uses a part")]
pub fn drop_files(window: &mut Window, paths: &[PathBuf]) {
    for path in paths {
        window.input_mut().dropped_files.push(std::sync::Arc::new(Dropped(path.clone())));
    }
    window.run_steps(2);
}

/// The names of the numbers that Tab leads into.
#[allow(dead_code, reason = "each test program uses a part")]
pub fn numbers_by_tab(window: &mut Window) -> std::collections::BTreeSet<String> {
    let mut numbers = std::collections::BTreeSet::new();
    for _ in 0..120 {
        window.key_press(egui::Key::Tab);
        window.run_steps(2);
        let fields = window.get_all_by_role(egui::accesskit::Role::SpinButton);
        let focused = fields.map(|field| field.accesskit_node()).filter(|field| field.is_focused());
        numbers.extend(focused.filter_map(|field| field.label()));
    }
    numbers
}

/// A clock that stands still: no work takes any time, and a slow machine does not do less.
#[allow(dead_code, reason = "each test program uses a part")]
pub fn no_time() -> Instant {
    static START: std::sync::OnceLock<Instant> = std::sync::OnceLock::new();
    *START.get_or_init(Instant::now)
}

/// Opens the window in a size in points.
pub fn open(opening: Opening, size: [f32; 2]) -> Window {
    open_with(opening, Harness::builder().with_size(size))
}

/// Opens the window on a screen of one's own, or with steps of another length.
pub fn open_with(opening: Opening, builder: HarnessBuilder<Studio>) -> Window {
    builder
        .renderer(Painted::default())
        .build_eframe(|creation| Studio::new(creation, opening).expect("a graphics device"))
}

/// Opens the window on a graphics device, if only a software one, and tells which; `None` where there is none.
#[allow(dead_code, clippy::print_stdout, reason = "each test program uses a part; what is skipped is said")]
pub fn open_with_device(opening: Opening, size: [f32; 2]) -> Option<(Window, wgpu::Device)> {
    if Gpu::headless().is_err() {
        println!("skipped: no graphics device");
        return None;
    }
    let device = Rc::new(RefCell::new(None));
    let seen = Rc::clone(&device);
    let builder = Harness::builder().with_size(size).wgpu();
    let window = builder.build_eframe(move |creation| {
        *seen.borrow_mut() = creation.wgpu_render_state.as_ref().map(|state| state.device.clone());
        Studio::new(creation, Opening { draw: Draw::Gpu, ..opening }).expect("a graphics device")
    });
    let device = device.borrow_mut().take().expect("a graphics device");
    Some((window, device))
}

/// Does to `device` what a driver does that restarts.
#[allow(dead_code, reason = "each test program uses a part")]
pub fn lose(device: &wgpu::Device) {
    device.destroy();
    device.poll(wgpu::PollType::wait_indefinitely()).expect("the device");
}

/// Has something happen on another thread at a random time within the next 0.3 s.
#[allow(dead_code, reason = "each test program uses a part")]
pub fn meanwhile(
    chance: &mut impl FnMut() -> u64,
    happens: impl FnOnce() + Send + 'static,
) -> JoinHandle<()> {
    let after = Duration::from_micros((chance() >> 33) % 300_000);
    std::thread::spawn(move || {
        std::thread::sleep(after);
        happens();
    })
}

/// Has the memory of `device` be too small, on any driver: it is asked for a picture of hundreds of gigabytes.
#[allow(dead_code, reason = "each test program uses a part")]
pub fn exhaust(device: &wgpu::Device) {
    let limits = device.limits();
    let (side, layers) = (limits.max_texture_dimension_2d, limits.max_texture_array_layers);
    let _ = device.create_texture(&wgpu::TextureDescriptor {
        label: Some("one that no device has room for"),
        size: wgpu::Extent3d { width: side, height: side, depth_or_array_layers: layers },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba32Float,
        usage: wgpu::TextureUsages::TEXTURE_BINDING,
        view_formats: &[],
    });
}

/// The control that is known as `id`, whatever it is called.
pub fn control<'a, State>(window: &'a Harness<'_, State>, id: &'a str) -> Node<'a> {
    window.get_by(move |node| node.author_id() == Some(id))
}

/// Whether each of these controls is hit without its neighbors: it is 24 points wide and high, or a circle of that width
/// around its middle meets none of them, nor such a circle of another small one (WCAG 2.2, criterion 2.5.8).
#[allow(dead_code, reason = "each test program uses a part")]
pub fn are_hit_apart(controls: &[egui::Rect]) -> bool {
    // Less by what places on whole pixels may lose.
    const LEAST: f32 = 23.9;
    let is_small = |control: &egui::Rect| control.size().min_elem() < LEAST;
    let is_far = |small: &egui::Rect, other: &egui::Rect| {
        let between = (small.center() - other.center()).length();
        other.distance_to_pos(small.center()) >= 0.5 * LEAST && (between >= LEAST || !is_small(other))
    };
    let is_apart =
        |small: &egui::Rect| controls.iter().all(|other| std::ptr::eq(small, other) || is_far(small, other));
    controls.iter().all(|control| !is_small(control) || is_apart(control))
}

/// Whether there is a control that is known as `id`.
#[allow(dead_code, reason = "each test program uses a part")]
pub fn is_there(window: &Window, id: &str) -> bool {
    window.query_by(|node| node.author_id() == Some(id)).is_some()
}

/// Whether something says that it is still at work.
#[allow(dead_code, reason = "each test program uses a part")]
pub fn is_busy(window: &Window) -> bool {
    window.query_all_by(|node| node.is_busy()).next().is_some()
}

/// Whether something whose name contains `text` is there.
pub fn shows(window: &Window, text: &str) -> bool {
    window.query_all_by_label_contains(text).next().is_some()
}

/// A wait fails only after this many frames and after [`HANGS`](chladni_testdata::HANGS): on a busy machine frames slow down,
/// but less than the work that is waited for.
const MOST_FRAMES: usize = 15_000;

/// Steps until `ready`, as a person waits.
pub fn wait(window: &mut Window, what: &str, ready: impl Fn(&Window) -> bool) {
    let start = Instant::now();
    for frame in 0.. {
        if ready(window) {
            return;
        }
        if frame > MOST_FRAMES && start.elapsed() > chladni_testdata::HANGS {
            break;
        }
        std::thread::sleep(Duration::from_millis(15));
        window.run_steps(1);
    }
    picture(window, "failed.png");
    panic!("{what} did not happen: {window:?}");
}

/// Waits until nobody holds the lock of what a dropped window left: neither its thread nor a program that another test starts
/// just now.
#[allow(dead_code, reason = "each test program uses a part")]
pub fn wait_until_left(folder: &Path, kind: &str, extension: &str) {
    let start = Instant::now();
    while chladni_task::RecoveryCopy::left_behind(folder, kind, extension).is_empty() {
        assert!(start.elapsed() < chladni_testdata::HANGS, "nothing was left");
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// Shows the window to a person: as a picture where CHLADNI_SCREENSHOTS names a folder for them, and, to
/// one who does not see, by names. Fails where a control has none of its own.
pub fn screenshot<State>(window: &mut Harness<'_, State>, name: &str) {
    window.run_steps(2);
    names::check(window, name);
    picture(window, name);
}

fn picture<State>(window: &mut Harness<'_, State>, name: &str) {
    if let Some(folder) = std::env::var_os("CHLADNI_SCREENSHOTS") {
        let picture = window.render().expect("the window can be drawn");
        picture.save(Path::new(&folder).join(name)).expect("the folder is there");
    }
}
