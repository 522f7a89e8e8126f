//! Recovery of unsaved work after a crash.

use std::path::{Path, PathBuf};
use std::time::SystemTime;

use chladni_task::{RecoveryCopy, read_text_file};

use crate::project_file::MOST_BYTES;
use crate::{CaricatureError, Project};

/// Beginning and ending of a copy's name.
const NAMES: (&str, &str) = ("session", "chladni");

/// The recovery copy of a running program; [`finish`](Self::finish) removes it.
#[derive(Debug)]
pub struct Recovery(RecoveryCopy);

/// A project that a program left behind when it crashed.
#[derive(Clone, Debug)]
pub struct Recovered {
    /// The recovery file.
    pub copy: PathBuf,
    /// Where the project was saved, if it was.
    pub original: Option<PathBuf>,
    /// When the copy was last written, where the system knows.
    pub modified: Option<SystemTime>,
    /// The project as it was.
    pub project: Project,
}

impl Recovery {
    /// Starts a copy in `folder`, which is created if missing. `id` must differ between programs that run at once,
    /// such as the process id.
    ///
    /// # Errors
    /// A folder that cannot be made or written.
    pub fn start(folder: &Path, id: u32) -> Result<Self, CaricatureError> {
        let copy = RecoveryCopy::start(folder, NAMES.0, NAMES.1, id);
        copy.map(Self).map_err(|source| CaricatureError::Io { path: folder.into(), source })
    }

    /// Keeps `project` as it is now. `original` is where the user saved it, if anywhere.
    ///
    /// # Errors
    /// As [`Project::save`].
    pub fn keep(&self, project: &Project, original: Option<&Path>) -> Result<(), CaricatureError> {
        let (copy, original) =
            (self.0.path(), original.map(|p| std::path::absolute(p).unwrap_or_else(|_| p.into())));
        let text = project.to_text(copy, original)?;
        self.0.keep(text.as_bytes()).map_err(|source| CaricatureError::Io { path: copy.into(), source })
    }

    /// Drops the copy: everything is saved.
    pub fn clear(&self) {
        self.0.clear();
    }

    /// Ends well and removes the copy. A value that is merely dropped, as by a panic, leaves its copy.
    pub fn finish(self) {
        self.0.finish();
    }

    /// The projects in `folder` whose programs crashed, newest first, and the copies that cannot be read, each with
    /// the reason. An absent folder holds none.
    pub fn find(folder: &Path) -> (Vec<Recovered>, Vec<CaricatureError>) {
        let (mut found, mut unreadable) = (Vec::new(), Vec::new());
        for copy in RecoveryCopy::left_behind(folder, NAMES.0, NAMES.1) {
            match Recovered::read(&copy) {
                Ok(recovered) => found.push(recovered),
                Err(why) => unreadable.push(why),
            }
        }
        found.sort_by_key(|r| std::cmp::Reverse(r.modified));
        (found, unreadable)
    }
}

impl Recovered {
    fn read(copy: &Path) -> Result<Self, CaricatureError> {
        let text = read_text_file(copy, MOST_BYTES)
            .map_err(|source| CaricatureError::Io { path: copy.into(), source })?;
        let (project, original) = Project::from_text(&text, copy)?;
        let modified = std::fs::metadata(copy).and_then(|m| m.modified()).ok();
        Ok(Self { copy: copy.into(), original, modified, project })
    }

    /// Removes the copy: it was recovered, or it is not wanted.
    pub fn discard(&self) {
        RecoveryCopy::discard(&self.copy);
    }
}
