//! Asking the user for files.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use super::file_window::{self, Purpose, Request};

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

    /// What went wrong since the last call: no dialog may have come up at all.
    fn trouble(&mut self) -> Option<String> {
        None
    }
}

/// A dialog that closes sooner never came up: nobody reads and clicks that fast.
const TOO_FAST: Duration = Duration::from_millis(250);

/// The dialogs of the system and, where none comes up, a file window of our own.
#[derive(Debug, Default)]
pub struct SystemDialogs {
    /// No dialog of the system came up before.
    missing: bool,
    /// The folder of the file that was chosen last.
    folder: PathBuf,
    trouble: Option<String>,
}

impl SystemDialogs {
    fn dialog(kinds: &[FileKind<'_>]) -> rfd::FileDialog {
        kinds
            .iter()
            .fold(rfd::FileDialog::new(), |dialog, (name, extensions)| dialog.add_filter(*name, extensions))
    }

    /// Asks the system, and uses our own window if the system's dialog ended without an answer faster than a
    /// person could give one.
    fn ask(&mut self, request: Request, ask: impl FnOnce() -> Option<Vec<PathBuf>>) -> Option<Vec<PathBuf>> {
        if !self.missing {
            let start = Instant::now();
            let answer = ask();
            self.missing = answer.is_none() && start.elapsed() < TOO_FAST;
            if !self.missing {
                return answer;
            }
        }
        match file_window::ask(&request) {
            Ok(files) => {
                let folder = files.first().and_then(|file| file.parent());
                self.folder = folder.map_or_else(|| std::mem::take(&mut self.folder), Path::to_owned);
                Some(files).filter(|files| !files.is_empty())
            }
            Err(error) => {
                self.trouble = Some(format!(
                    "No file dialog came up, neither the system's (on Linux from xdg-desktop-portal or zenity) \
                     nor our own: {error}. Files can also be dropped on the window, or named on the command \
                     line: chladni open FILE."
                ));
                None
            }
        }
    }

    fn request(&self, purpose: Purpose, kinds: &[FileKind<'_>]) -> Request {
        let kinds = kinds.iter().map(|(name, extensions)| {
            ((*name).to_owned(), extensions.iter().map(|extension| (*extension).to_owned()).collect())
        });
        let start = if self.folder.as_os_str().is_empty() { PathBuf::from(".") } else { self.folder.clone() };
        Request { purpose, kinds: kinds.collect(), start }
    }
}

impl Chooser for SystemDialogs {
    fn open(&mut self, kinds: &[FileKind<'_>]) -> Option<PathBuf> {
        let request = self.request(Purpose::Open, kinds);
        self.ask(request, || Self::dialog(kinds).pick_file().map(|file| vec![file]))?.pop()
    }

    fn open_several(&mut self, kinds: &[FileKind<'_>]) -> Vec<PathBuf> {
        let request = self.request(Purpose::OpenSeveral, kinds);
        self.ask(request, || Self::dialog(kinds).pick_files()).unwrap_or_default()
    }

    fn save(&mut self, kinds: &[FileKind<'_>], suggested: &Path) -> Option<PathBuf> {
        let mut dialog = Self::dialog(kinds);
        let folder = suggested.parent().filter(|folder| !folder.as_os_str().is_empty());
        if let Some(folder) = folder {
            dialog = dialog.set_directory(folder);
        }
        if let Some(name) = suggested.file_name() {
            dialog = dialog.set_file_name(name.to_string_lossy());
        }
        let request = self.request(Purpose::Save, kinds);
        let start = folder.map_or_else(|| request.start.join(suggested), |_| suggested.to_owned());
        let request = Request { start, ..request };
        let path = self.ask(request, || dialog.save_file().map(|file| vec![file]))?.pop()?;
        let first = kinds.first().and_then(|(_, extensions)| extensions.first());
        match first {
            Some(extension) if path.extension().is_none() => {
                let completed = path.with_extension(extension);
                // What is there is asked about by the dialog alone, which did not know this name.
                if completed.exists() { self.save(kinds, &completed) } else { Some(completed) }
            }
            _ => Some(path),
        }
    }

    fn trouble(&mut self) -> Option<String> {
        self.trouble.take()
    }
}
