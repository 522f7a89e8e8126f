//! Asking the user for files.

use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::time::{Duration, Instant};

use chladni_view::Draw;

use super::file_window::{self, Purpose, Request};
use crate::work::formats::ends_in;

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
    /// A file to read, of any of `kinds`; `None` if the user cancels.
    fn open(&mut self, kinds: &[FileKind<'_>]) -> Option<PathBuf>;

    /// Several files to read.
    fn open_several(&mut self, kinds: &[FileKind<'_>]) -> Vec<PathBuf>;

    /// A file to write, of any of `kinds`; `suggested` is a name, or a path, to start from. Has the extension
    /// of the first kind if the user gave none.
    fn save(&mut self, kinds: &[FileKind<'_>], suggested: &Path) -> Option<PathBuf>;

    /// Begins to ask while the window goes on; false where something is being asked already.
    fn begin(&mut self, request: Request) -> bool;

    /// The answer to the request that was [begun](Self::begin), once: no files if the user cancels.
    fn answer(&mut self) -> Option<Vec<PathBuf>>;

    /// The error since the last call: no dialog may have come up at all.
    fn trouble(&mut self) -> Option<String> {
        None
    }
}

/// Asks where to save a file of any of `kinds`. Its name gets the first one's ending unless it has one of `endings`
/// already: `igea 1.2` has an extension, but not ours.
pub fn ask_where_to_save(
    chooser: &mut dyn Chooser,
    kinds: &[FileKind<'_>],
    endings: &[&str],
    suggested: &Path,
) -> Option<PathBuf> {
    let ending = kinds.first()?.1.first()?;
    let mut suggested = suggested.to_owned();
    loop {
        match with_ending(chooser.save(kinds, &suggested)?, endings, ending) {
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

/// A dialog that closes sooner never came up: nobody reads and clicks that fast.
const TOO_FAST: Duration = Duration::from_millis(250);

/// The dialogs of the system and, where none comes up, a file window of our own.
#[derive(Debug, Default)]
pub struct SystemDialogs {
    /// The choice of the device that draws our own window.
    draw: Draw,
    /// No dialog of the system came up before.
    missing: bool,
    /// The folder of the file that was chosen last.
    folder: PathBuf,
    trouble: Option<String>,
    /// The request that waits in the background, and the channel of its answer.
    asking: Option<(Request, Receiver<Asked>)>,
}

/// The outcome of a dialog.
#[derive(Debug)]
struct Asked {
    files: Vec<PathBuf>,
    /// The system's dialog did not come up.
    missing: bool,
    trouble: Option<String>,
}

/// Asks the system, and uses our own window if that is `missing` or ends without an answer faster than a person could
/// give one. `folder` is where our own begins if the request does not say, and it is drawn as `draw` says.
fn ask(request: &Request, folder: &Path, mut missing: bool, draw: Draw) -> Asked {
    if !missing {
        let start = Instant::now();
        let files = ask_the_system(request);
        missing = files.is_empty() && start.elapsed() < TOO_FAST;
        if !missing {
            return Asked { files, missing, trouble: None };
        }
    }
    let here = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let start =
        if is_with_folder(&request.start) { request.start.clone() } else { here.join(&request.start) };
    match file_window::ask(&Request { start, ..request.clone() }, draw) {
        Ok(files) => Asked { files, missing, trouble: None },
        Err(error) => {
            let trouble = format!(
                "No file dialog came up, neither the system's (on Linux from xdg-desktop-portal or zenity) \
                 nor our own: {error}. Files can also be named on the command line: chladni open FILE."
            );
            Asked { files: Vec::new(), missing, trouble: Some(trouble) }
        }
    }
}

fn is_with_folder(path: &Path) -> bool {
    path.parent().is_some_and(|folder| !folder.as_os_str().is_empty())
}

fn ask_the_system(request: &Request) -> Vec<PathBuf> {
    let mut dialog = rfd::FileDialog::new();
    let is_read = request.purpose != Purpose::Save;
    for (name, extensions) in request.kinds.iter().filter(|(_, extensions)| !extensions.is_empty()) {
        // Dialogs of Linux tell `a.OBJ` from `a.obj`.
        let capitals = extensions.iter().filter(|_| is_read).map(|extension| extension.to_uppercase());
        let shown: Vec<String> = extensions.iter().cloned().chain(capitals).collect();
        dialog = dialog.add_filter(name, &shown);
    }
    if is_read {
        // Under zenity those whose name has a dot: rfd gives it `*.*`.
        dialog = dialog.add_filter("All files", &["*"]);
    }
    if let Some(folder) = request.start.parent().filter(|_| is_with_folder(&request.start)) {
        dialog = dialog.set_directory(folder);
    }
    if let Some(name) = request.start.file_name() {
        dialog = dialog.set_file_name(name.to_string_lossy());
    }
    match request.purpose {
        Purpose::Open => dialog.pick_file().into_iter().collect(),
        Purpose::OpenSeveral => dialog.pick_files().unwrap_or_default(),
        Purpose::Save => dialog.save_file().into_iter().collect(),
    }
}

/// The request to make again where a file to be saved was named without an extension, and is there with it: the dialog,
/// which alone asks before it replaces a file, did not know that name. Else the extension is added.
fn completed(request: &Request, files: &mut [PathBuf]) -> Option<Request> {
    let extension = request.kinds.first().and_then(|(_, extensions)| extensions.first());
    let (Purpose::Save, Some(file), Some(extension)) = (request.purpose, files.first_mut(), extension) else {
        return None;
    };
    if file.extension().is_some() {
        return None;
    }
    file.set_extension(extension);
    file.exists().then(|| Request { start: file.clone(), ..request.clone() })
}

impl SystemDialogs {
    /// Our own window, where it is needed, is drawn as `draw` says.
    pub fn drawn(draw: Draw) -> Self {
        Self { draw, ..Self::default() }
    }

    /// Waits for the answer.
    fn wait(&mut self, mut request: Request) -> Vec<PathBuf> {
        loop {
            let asked = ask(&request, &self.folder, self.missing, self.draw);
            let mut files = self.take(asked);
            match completed(&request, &mut files) {
                Some(again) => request = again,
                None => return files,
            }
        }
    }

    fn take(&mut self, asked: Asked) -> Vec<PathBuf> {
        let Asked { files, missing, trouble } = asked;
        self.missing = missing;
        self.trouble = trouble.or(self.trouble.take());
        if let Some(folder) = files.first().and_then(|file| file.parent()) {
            self.folder = folder.to_owned();
        }
        files
    }
}

impl Chooser for SystemDialogs {
    fn open(&mut self, kinds: &[FileKind<'_>]) -> Option<PathBuf> {
        self.wait(Request::open(kinds)).pop()
    }

    fn open_several(&mut self, kinds: &[FileKind<'_>]) -> Vec<PathBuf> {
        self.wait(Request::open_several(kinds))
    }

    fn save(&mut self, kinds: &[FileKind<'_>], suggested: &Path) -> Option<PathBuf> {
        self.wait(Request::save(kinds, suggested)).pop()
    }

    fn begin(&mut self, request: Request) -> bool {
        if self.asking.is_some() {
            return false;
        }
        let (answer, answers) = channel();
        let (asks, folder, missing, draw) = (request.clone(), self.folder.clone(), self.missing, self.draw);
        let asking = move || {
            // If nobody waits any longer, the window is closed.
            let _ = answer.send(ask(&asks, &folder, missing, draw));
        };
        match std::thread::Builder::new().name("file dialog".into()).spawn(asking) {
            Ok(_) => self.asking = Some((request, answers)),
            Err(error) => self.trouble = Some(format!("No file dialog can be opened: {error}")),
        }
        true
    }

    fn answer(&mut self) -> Option<Vec<PathBuf>> {
        let asked = match self.asking.as_ref()?.1.try_recv() {
            Ok(asked) => asked,
            Err(TryRecvError::Empty) => return None,
            Err(TryRecvError::Disconnected) => {
                Asked { files: Vec::new(), missing: self.missing, trouble: None }
            }
        };
        let (request, _) = self.asking.take()?;
        let mut files = self.take(asked);
        match completed(&request, &mut files) {
            Some(again) => {
                self.begin(again);
                None
            }
            None => Some(files),
        }
    }

    fn trouble(&mut self) -> Option<String> {
        self.trouble.take()
    }
}
