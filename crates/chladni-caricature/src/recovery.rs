//! Recovery of a session that crashed.
//!
//! A running session keeps a copy of its project in a state folder, and holds a lock beside it. The system
//! releases the lock when the process dies, for whatever reason; a copy whose lock is free was left by a
//! crash.

use std::fs::{File, TryLockError};
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use chladni_task::read_text_file;

use crate::project_file::MOST_BYTES;
use crate::{CaricatureError, Project};

/// The recovery copy of a running session; [`finish`](Self::finish) removes it.
#[derive(Debug)]
pub struct Recovery {
    copy: PathBuf,
    lock: PathBuf,
    /// Held for as long as the session lives.
    _held: File,
}

/// A project that a session left behind when it died.
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
    /// Starts a session that keeps its copies in `folder`, which is created if missing. `id` must differ
    /// between sessions that run at once, such as the process id.
    ///
    /// # Errors
    /// A folder that cannot be made or written.
    pub fn start(folder: &Path, id: u32) -> Result<Self, CaricatureError> {
        std::fs::create_dir_all(folder)
            .map_err(|source| CaricatureError::Io { path: folder.into(), source })?;
        for attempt in 0..1000 {
            let name = format!("session-{id}-{attempt}");
            let lock = folder.join(format!("{name}.lock"));
            let copy = folder.join(format!("{name}.chladni"));
            let held = File::options().create(true).truncate(false).write(true).open(&lock);
            let held = held.map_err(|source| CaricatureError::Io { path: lock.clone(), source })?;
            // An old copy waits to be recovered; another session may hold the lock.
            if !copy.exists() && held.try_lock().is_ok() {
                return Ok(Self { copy, lock, _held: held });
            }
        }
        let source = std::io::Error::other("too many sessions were left behind");
        Err(CaricatureError::Io { path: folder.into(), source })
    }

    /// Keeps `project` as it is now. `original` is where the user saved it, if anywhere.
    ///
    /// # Errors
    /// As [`Project::save`].
    pub fn keep(&self, project: &Project, original: Option<&Path>) -> Result<(), CaricatureError> {
        let original = original.map(|p| std::path::absolute(p).unwrap_or_else(|_| p.into()));
        let text = project.to_text(&self.copy, original)?;
        chladni_task::write_atomic(&self.copy, text.as_bytes())
            .map_err(|source| CaricatureError::Io { path: self.copy.clone(), source })
    }

    /// Drops the copy: everything is saved.
    pub fn clear(&self) {
        // If it cannot be removed, it is offered for recovery again, which does no harm.
        let _ = std::fs::remove_file(&self.copy);
    }

    /// Ends the session well. A session that is merely dropped, as by a panic, leaves its copy.
    pub fn finish(self) {
        self.clear();
        let _ = std::fs::remove_file(&self.lock);
    }

    /// The projects in `folder` whose sessions died, newest first, and the copies that cannot be
    /// read, each with the reason. An absent folder holds none.
    pub fn find(folder: &Path) -> (Vec<Recovered>, Vec<CaricatureError>) {
        let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
        let copies = entries.map(|e| e.path()).filter(|p| p.extension().is_some_and(|e| e == "chladni"));
        let (mut found, mut unreadable) = (Vec::new(), Vec::new());
        for copy in copies.filter(|copy| !is_running(&copy.with_extension("lock"))) {
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
        let _ = std::fs::remove_file(&self.copy);
        let _ = std::fs::remove_file(self.copy.with_extension("lock"));
    }
}

/// Whether somebody holds the lock at `path`.
fn is_running(path: &Path) -> bool {
    let lock = File::options().write(true).open(path);
    lock.is_ok_and(|file| matches!(file.try_lock(), Err(TryLockError::WouldBlock)))
}
