//! Asking the person for files.

use std::path::{Path, PathBuf};

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
}

/// The dialogs of the system.
#[derive(Debug, Default)]
pub struct SystemDialogs;

impl SystemDialogs {
    fn dialog(kinds: &[Kind<'_>]) -> rfd::FileDialog {
        kinds
            .iter()
            .fold(rfd::FileDialog::new(), |dialog, (name, extensions)| dialog.add_filter(*name, extensions))
    }
}

impl Chooser for SystemDialogs {
    fn open(&mut self, kinds: &[Kind<'_>]) -> Option<PathBuf> {
        Self::dialog(kinds).pick_file()
    }

    fn open_several(&mut self, kinds: &[Kind<'_>]) -> Vec<PathBuf> {
        Self::dialog(kinds).pick_files().unwrap_or_default()
    }

    fn save(&mut self, kinds: &[Kind<'_>], suggested: &Path) -> Option<PathBuf> {
        let mut dialog = Self::dialog(kinds);
        if let Some(folder) = suggested.parent().filter(|folder| !folder.as_os_str().is_empty()) {
            dialog = dialog.set_directory(folder);
        }
        if let Some(name) = suggested.file_name() {
            dialog = dialog.set_file_name(name.to_string_lossy());
        }
        let path = dialog.save_file()?;
        let first = kinds.first().and_then(|(_, extensions)| extensions.first());
        Some(match first {
            Some(extension) if path.extension().is_none() => path.with_extension(extension),
            _ => path,
        })
    }
}
