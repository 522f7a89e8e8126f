//! Asking the person for files.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// A kind of file: its name in a dialog and its extensions, without dots.
pub type Kind<'a> = (&'a str, &'a [&'a str]);

/// Who is asked for files: the system's dialogs, or a test.
pub trait Chooser {
    /// A file to read, of any of `kinds`; `None` where the person thinks better of it.
    fn open(&mut self, kinds: &[Kind<'_>]) -> Option<PathBuf>;

    /// Several files to read.
    fn open_several(&mut self, kinds: &[Kind<'_>]) -> Vec<PathBuf>;

    /// A file to write, of any of `kinds`; `suggested` is a name, or a path, to start from. Has
    /// the extension of the first kind where the person gave none.
    fn save(&mut self, kinds: &[Kind<'_>], suggested: &Path) -> Option<PathBuf>;

    /// What went wrong since the last call: no dialog may have come up at all.
    fn trouble(&mut self) -> Option<&'static str> {
        None
    }
}

/// A dialog that is gone sooner was never there: nobody reads and clicks as fast.
const TOO_FAST: Duration = Duration::from_millis(250);

/// The dialogs of the system.
#[derive(Debug, Default)]
pub struct SystemDialogs {
    failed: bool,
}

impl SystemDialogs {
    fn dialog(kinds: &[Kind<'_>]) -> rfd::FileDialog {
        kinds
            .iter()
            .fold(rfd::FileDialog::new(), |dialog, (name, extensions)| dialog.add_filter(*name, extensions))
    }

    /// Asks, and notes where no answer came faster than a person can give one.
    fn ask<T>(&mut self, ask: impl FnOnce() -> Option<T>) -> Option<T> {
        let start = Instant::now();
        let answer = ask();
        self.failed |= answer.is_none() && start.elapsed() < TOO_FAST;
        answer
    }
}

impl Chooser for SystemDialogs {
    fn open(&mut self, kinds: &[Kind<'_>]) -> Option<PathBuf> {
        self.ask(|| Self::dialog(kinds).pick_file())
    }

    fn open_several(&mut self, kinds: &[Kind<'_>]) -> Vec<PathBuf> {
        self.ask(|| Self::dialog(kinds).pick_files()).unwrap_or_default()
    }

    fn save(&mut self, kinds: &[Kind<'_>], suggested: &Path) -> Option<PathBuf> {
        let mut dialog = Self::dialog(kinds);
        if let Some(folder) = suggested.parent().filter(|folder| !folder.as_os_str().is_empty()) {
            dialog = dialog.set_directory(folder);
        }
        if let Some(name) = suggested.file_name() {
            dialog = dialog.set_file_name(name.to_string_lossy());
        }
        let path = self.ask(|| dialog.save_file())?;
        let first = kinds.first().and_then(|(_, extensions)| extensions.first());
        Some(match first {
            Some(extension) if path.extension().is_none() => path.with_extension(extension),
            _ => path,
        })
    }

    fn trouble(&mut self) -> Option<&'static str> {
        std::mem::take(&mut self.failed).then_some(
            "No file dialog came up. On Linux it needs xdg-desktop-portal or zenity; files can also be dropped \
             on the window, or named on the command line: chladni open FILE.",
        )
    }
}
