//! The dialogs of the system, and our own window where there are none.

use std::ffi::OsString;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::time::{Duration, Instant};

use chladni_view::Draw;

use super::Chooser;
use crate::studio::file_window::{self, Purpose, Request};

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

/// Asks the system, or in our own window, which is drawn as `draw` says.
fn ask(request: &Request, folder: &Path, missing: bool, draw: Draw) -> Asked {
    let environment = |name: &str| std::env::var_os(name).filter(|value| !value.is_empty());
    let own = |request: &Request| file_window::ask(request, draw);
    ask_by(request, folder, missing, environment, ask_the_system, own)
}

/// Asks the system, and uses our `own` window if that is `missing`, cannot come up in this `environment`, or ends without an
/// answer faster than a person could give one. `folder` is where our own begins if the request does not say.
fn ask_by(
    request: &Request,
    folder: &Path,
    missing: bool,
    environment: impl Fn(&str) -> Option<OsString>,
    system: impl FnOnce(&Request) -> Vec<PathBuf>,
    own: impl FnOnce(&Request) -> io::Result<Vec<PathBuf>>,
) -> Asked {
    let mut missing = missing || !can_come_up(environment);
    if !missing {
        let start = Instant::now();
        let files = system(request);
        missing = files.is_empty() && start.elapsed() < TOO_FAST;
        if !missing {
            return Asked { files, missing, trouble: None };
        }
    }
    let here = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let start =
        if is_with_folder(&request.start) { request.start.clone() } else { here.join(&request.start) };
    match own(&Request { start, ..request.clone() }) {
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

/// Whether the system's dialog can come up: on Linux it comes over the bus of the desktop, or from zenity. A busy machine
/// without either fails too slowly to be known by the time that it takes. A bus that only X11 knows of (autolaunch) is given
/// up: a desktop sets the address.
fn can_come_up(environment: impl Fn(&str) -> Option<OsString>) -> bool {
    if !cfg!(target_os = "linux") {
        return true;
    }
    let bus = |folder: OsString| Path::new(&folder).join("bus").exists();
    let zenity = |folders: OsString| std::env::split_paths(&folders).any(|f| f.join("zenity").is_file());
    environment("DBUS_SESSION_BUS_ADDRESS").is_some()
        || environment("XDG_RUNTIME_DIR").is_some_and(bus)
        || environment("PATH").is_some_and(zenity)
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
    fn ask(&mut self, mut request: Request) -> Vec<PathBuf> {
        loop {
            let asked = ask(&request, &self.folder, self.missing, self.draw);
            let mut files = self.take(asked);
            match completed(&request, &mut files) {
                Some(again) => request = again,
                None => return files,
            }
        }
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

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::*;

    /// Whether our own window is asked where the system's dialog ends without an answer, too late to be known by the time.
    fn own_is_asked(environment: impl Fn(&str) -> Option<OsString>) -> bool {
        let slow = |_: &Request| {
            std::thread::sleep(TOO_FAST);
            Vec::new()
        };
        let own = |_: &Request| Ok(vec![PathBuf::from("chosen")]);
        let asked = ask_by(&Request::open(&[]), Path::new(""), false, environment, slow, own);
        !asked.files.is_empty()
    }

    #[test]
    fn where_the_system_has_no_dialog_our_own_window_is_asked_however_slow_the_machine_is() {
        let folder = tempfile::tempdir().unwrap();
        let only = |name: &'static str, value: &Path| {
            let value = value.as_os_str().to_owned();
            move |asked: &str| (asked == name).then(|| value.clone())
        };
        assert!(own_is_asked(|_| None));
        assert!(own_is_asked(only("XDG_RUNTIME_DIR", folder.path())));
        assert!(own_is_asked(only("PATH", folder.path())));
        // A person has cancelled these.
        assert!(!own_is_asked(only("DBUS_SESSION_BUS_ADDRESS", Path::new("unix:path=/run/bus"))));
        for name in ["bus", "zenity"] {
            std::fs::write(folder.path().join(name), "").unwrap();
        }
        assert!(!own_is_asked(only("XDG_RUNTIME_DIR", folder.path())));
        assert!(!own_is_asked(only("PATH", folder.path())));
    }
}
