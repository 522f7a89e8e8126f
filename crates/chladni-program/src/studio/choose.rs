//! Asking the user for files.

mod system;

use std::path::{Path, PathBuf};

use egui::{Event, ViewportId};

use super::file_window::{Purpose, Request};
use crate::work::formats::ends_in;

pub use system::SystemDialogs;

/// Whether an environment variable is set and not empty.
pub fn is_set(variable: &str) -> bool {
    std::env::var_os(variable).is_some_and(|value| !value.is_empty())
}

/// Whether windows open under Wayland, which winit prefers to X11.
pub fn is_wayland() -> bool {
    cfg!(target_os = "linux") && (is_set("WAYLAND_DISPLAY") || is_set("WAYLAND_SOCKET"))
}

/// Whether files can be dropped on the window: winit 0.30 takes none under Wayland.
pub fn takes_drops() -> bool {
    !is_wayland()
}

/// A kind of file: its name in a dialog and its extensions, without dots.
pub type FileKind<'a> = (&'a str, &'a [&'a str]);

/// The source of answers: the system's dialogs, or a test.
pub trait Chooser {
    /// Asks, and waits for the answer: no files if the user cancels. A file to write has the extension of the first kind
    /// if the user gave none.
    fn ask(&mut self, request: Request) -> Vec<PathBuf>;

    /// Begins to ask while the window goes on; false where something is being asked already.
    fn begin(&mut self, request: Request) -> bool;

    /// The answer to the request that was [begun](Self::begin), once: no files if the user cancels.
    fn answer(&mut self) -> Option<Vec<PathBuf>>;

    /// The error since the last call: no dialog may have come up at all.
    fn trouble(&mut self) -> Option<String> {
        None
    }
}

/// The file dialogs of a window. While it waits for one, what is pressed in it counts for nothing.
pub struct Dialogs {
    chooser: Box<dyn Chooser>,
    ctx: egui::Context,
}

impl Dialogs {
    /// Those of `chooser`, for the window of `ctx`.
    pub fn new(chooser: Box<dyn Chooser>, ctx: &egui::Context) -> Self {
        ctx.add_plugin(Meanwhile::default());
        Self { chooser, ctx: ctx.clone() }
    }

    /// A file to read, of any of `kinds`; `None` if the user cancels.
    pub fn open(&mut self, kinds: &[FileKind<'_>]) -> Option<PathBuf> {
        self.wait(Request::open(kinds)).pop()
    }

    /// Several files to read.
    pub fn open_several(&mut self, kinds: &[FileKind<'_>]) -> Vec<PathBuf> {
        self.wait(Request::open_several(kinds))
    }

    /// A file to write, of any of `kinds`; `suggested` is a name, or a path, to start from.
    pub fn save(&mut self, kinds: &[FileKind<'_>], suggested: &Path) -> Option<PathBuf> {
        self.wait(Request::save(kinds, suggested)).pop()
    }

    /// See [`Chooser::begin`].
    pub fn begin(&mut self, request: Request) -> bool {
        self.chooser.begin(request)
    }

    /// See [`Chooser::answer`].
    pub fn answer(&mut self) -> Option<Vec<PathBuf>> {
        self.chooser.answer()
    }

    /// See [`Chooser::trouble`].
    pub fn trouble(&mut self) -> Option<String> {
        self.chooser.trouble()
    }

    fn wait(&mut self, request: Request) -> Vec<PathBuf> {
        let files = self.chooser.ask(request);
        let frame = self.ctx.cumulative_frame_nr_for(ViewportId::ROOT);
        self.ctx.with_plugin(|meanwhile: &mut Meanwhile| meanwhile.waited_in = Some(frame));
        files
    }
}

/// Drops what was pressed while a dialog was waited for: it was meant for the dialog, or for a picture that stood still.
#[derive(Debug, Default)]
struct Meanwhile {
    /// The frame that waited.
    waited_in: Option<u64>,
}

impl egui::Plugin for Meanwhile {
    fn debug_name(&self) -> &'static str {
        "input while a dialog is open"
    }

    fn input_hook(&mut self, ctx: &egui::Context, input: &mut egui::RawInput) {
        let Some(waited_in) = self.waited_in else { return };
        // The system held it back until the next frame.
        if ctx.cumulative_frame_nr_for(ViewportId::ROOT) <= waited_in + 1 {
            input.events.retain(|event| !is_pressed(event));
        } else {
            self.waited_in = None;
        }
    }
}

/// Whether something is pressed, typed or turned. What is let go counts, or it would stay down.
fn is_pressed(event: &Event) -> bool {
    matches!(
        event,
        Event::Key { pressed: true, .. }
            | Event::PointerButton { pressed: true, .. }
            | Event::Text(_)
            | Event::Cut
            | Event::Copy
            | Event::Paste(_)
            | Event::MouseWheel { .. }
            | Event::Zoom(_)
    )
}

/// Asks where to save a file of any of `kinds`. Its name gets the first one's ending unless it has one of `endings`
/// already: `igea 1.2` has an extension, but not ours.
pub fn ask_where_to_save(
    dialogs: &mut Dialogs,
    kinds: &[FileKind<'_>],
    endings: &[&str],
    suggested: &Path,
) -> Option<PathBuf> {
    let ending = kinds.first()?.1.first()?;
    let mut suggested = suggested.to_owned();
    loop {
        match with_ending(dialogs.save(kinds, &suggested)?, endings, ending) {
            // The dialog asks before it replaces a file, but it did not know the name with the ending added.
            (path, true) if path.exists() => suggested = path,
            (path, _) => return Some(path),
        }
    }
}

/// `path`, with `ending` added unless it has one of `endings`; and whether it was added.
pub fn with_ending(path: PathBuf, endings: &[&str], ending: &str) -> (PathBuf, bool) {
    if ends_in(&path, endings) {
        return (path, false);
    }
    let mut name = path.into_os_string();
    name.push(".");
    name.push(ending);
    (PathBuf::from(name), true)
}

impl Request {
    /// A file to read, of any of `kinds`.
    pub fn open(kinds: &[FileKind<'_>]) -> Self {
        Self::new(Purpose::Open, kinds, PathBuf::new())
    }

    /// Several files to read.
    pub fn open_several(kinds: &[FileKind<'_>]) -> Self {
        Self::new(Purpose::OpenSeveral, kinds, PathBuf::new())
    }

    /// A file to write, or a new folder if the kind has no extensions; `suggested` is a name, or a path, to start from.
    pub fn save(kinds: &[FileKind<'_>], suggested: &Path) -> Self {
        Self::new(Purpose::Save, kinds, suggested.to_owned())
    }

    fn new(purpose: Purpose, kinds: &[FileKind<'_>], start: PathBuf) -> Self {
        let kinds = kinds.iter().map(|(name, extensions)| {
            ((*name).to_owned(), extensions.iter().map(|extension| (*extension).to_owned()).collect())
        });
        Self { purpose, kinds: kinds.collect(), start }
    }
}
