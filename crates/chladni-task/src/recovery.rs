//! A copy of unsaved work that outlives a crash.
//!
//! A running program keeps the copy in a folder of its own, and holds a lock beside it. The system releases the
//! lock when the process dies, for whatever reason; a copy whose lock is free was left by a crash. Some file systems
//! have no locks. There, a copy counts as left by a crash once nobody has written to it for a minute: a running program that
//! is idle for longer is taken for a crashed one, and a younger copy is offered only at a later start.

use std::fs::{File, TryLockError};
use std::io;
use std::path::{Path, PathBuf};
use std::time::Duration;

use crate::{advised, create_private_folder, write_atomic_private};

/// A copy that was written to within this time is a running program's where there are no locks.
const AT_WORK: Duration = Duration::from_secs(60);

/// The copy of a running program; [`finish`](Self::finish) removes it. One that is merely dropped, as by a
/// panic, stays.
#[derive(Debug)]
pub struct RecoveryCopy {
    copy: PathBuf,
    lock: PathBuf,
    /// Held for as long as the program runs.
    _held: File,
}

impl RecoveryCopy {
    /// Begins to keep copies in `folder`, which is created if missing, under names that begin with `kind` and end with
    /// `extension`. Programs that run at once need another `id` each, such as that of the process. On Unix, only its owner
    /// can enter the folder from then on: others could hold the locks.
    ///
    /// # Errors
    /// A folder that cannot be made or written.
    pub fn start(folder: &Path, kind: &str, extension: &str, id: u32) -> io::Result<Self> {
        create_private_folder(folder)?;
        for attempt in 0..1000 {
            let copy = folder.join(format!("{kind}-{id}-{attempt}.{extension}"));
            // An old copy waits to be recovered.
            if copy.exists() {
                continue;
            }
            let lock = copy.with_extension("lock");
            let mut options = File::options();
            options.create(true).truncate(false).write(true);
            #[cfg(unix)]
            std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
            let held = options.open(&lock).map_err(advised)?;
            if is_free(&held.try_lock()) {
                return Ok(Self { copy, lock, _held: held });
            }
        }
        Err(io::Error::other("too many copies were left behind"))
    }

    /// Where the copy is, once it was written.
    pub fn path(&self) -> &Path {
        &self.copy
    }

    /// Keeps `bytes` in place of the last copy. Only the owner can read them (on Unix), as the file that they belong to may be
    /// private.
    ///
    /// # Errors
    /// As [`write_atomic`](crate::write_atomic).
    pub fn keep(&self, bytes: &[u8]) -> io::Result<()> {
        write_atomic_private(&self.copy, bytes)
    }

    /// Drops the copy: everything is saved.
    pub fn clear(&self) {
        // If it cannot be removed, it is offered for recovery again, which does no harm.
        let _ = std::fs::remove_file(&self.copy);
    }

    /// The program ends well: nothing stays.
    pub fn finish(self) {
        self.clear();
        let _ = std::fs::remove_file(&self.lock);
    }

    /// The copies in `folder`, of this kind and extension, whose programs died. An absent folder holds none.
    pub fn left_behind(folder: &Path, kind: &str, extension: &str) -> Vec<PathBuf> {
        let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
        let begins = |path: &Path| {
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            name.strip_prefix(kind).is_some_and(|rest| rest.starts_with('-'))
        };
        let ours = |path: &PathBuf| path.extension().is_some_and(|end| end == extension) && begins(path);
        entries.map(|e| e.path()).filter(ours).filter(|copy| !is_running(copy)).collect()
    }

    /// Removes a copy that was [left behind](Self::left_behind): it was recovered, or it is not wanted.
    pub fn discard(copy: &Path) {
        let _ = std::fs::remove_file(copy);
        let _ = std::fs::remove_file(copy.with_extension("lock"));
    }
}

/// Whether a lock that answers so can be taken: no other program holds it. One on a file system that has no locks is
/// nobody's.
fn is_free(answer: &Result<(), TryLockError>) -> bool {
    !matches!(answer, Err(TryLockError::WouldBlock))
}

/// Whether the program of `copy` still runs.
fn is_running(copy: &Path) -> bool {
    let Ok(lock) = File::options().write(true).open(copy.with_extension("lock")) else { return false };
    let written = copy.metadata().and_then(|copy| copy.modified());
    // A copy of the future was written just now by a clock that is ahead.
    let age = written.map_or(Duration::MAX, |written| written.elapsed().unwrap_or_default());
    is_held(&lock.try_lock(), age)
}

/// Whether a program keeps the copy of this age whose lock answers so.
fn is_held(answer: &Result<(), TryLockError>, age: Duration) -> bool {
    match answer {
        Ok(()) => false,
        Err(TryLockError::WouldBlock) => true,
        Err(TryLockError::Error(_)) => age < AT_WORK,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(unix)]
    #[test]
    fn a_copy_can_be_read_by_its_owner_alone() {
        use std::os::unix::fs::PermissionsExt;
        let mode = |path: &Path| path.metadata().unwrap().permissions().mode() & 0o777;
        let home = tempfile::tempdir().unwrap();
        let [new, old] = ["new", "old"].map(|name| home.path().join(name));
        std::fs::create_dir(&old).unwrap();
        std::fs::set_permissions(&old, std::fs::Permissions::from_mode(0o755)).unwrap();
        for folder in [new, old] {
            let copy = RecoveryCopy::start(&folder, "show", "toml", 7).unwrap();
            assert_eq!((mode(&folder), mode(&copy.lock)), (0o700, 0o600));
            for _ in 0..2 {
                copy.keep(b"unsaved").unwrap();
                assert_eq!(mode(copy.path()), 0o600);
            }
        }
    }

    #[test]
    fn a_folder_without_locks_keeps_copies_too() {
        let without = || Err(TryLockError::Error(io::ErrorKind::Unsupported.into()));
        assert!(is_free(&Ok(())) && is_free(&without()) && !is_free(&Err(TryLockError::WouldBlock)));
        let (young, old) = (AT_WORK / 2, 2 * AT_WORK);
        assert!(is_held(&without(), young) && !is_held(&without(), old));
        assert!(is_held(&Err(TryLockError::WouldBlock), old) && !is_held(&Ok(()), young));
    }

    #[test]
    fn a_copy_that_is_passed_over_gets_no_lock() {
        let home = tempfile::tempdir().unwrap();
        let old = home.path().join("show-7-0.toml");
        std::fs::write(&old, "old").unwrap();
        let copy = RecoveryCopy::start(home.path(), "show", "toml", 7).unwrap();
        assert_eq!(copy.path(), home.path().join("show-7-1.toml"));
        assert!(!old.with_extension("lock").exists());
    }

    #[test]
    fn what_a_crash_leaves_is_found_by_its_kind_and_what_runs_is_not() {
        let home = tempfile::tempdir().unwrap();
        let folder = home.path().join("recovery");
        let left = |kind: &str| RecoveryCopy::left_behind(&folder, kind, "toml");
        assert!(left("show").is_empty());
        let copy = RecoveryCopy::start(&folder, "show", "toml", 7).unwrap();
        copy.keep(b"first").unwrap();
        copy.keep(b"second").unwrap();
        let other = RecoveryCopy::start(&folder, "show", "toml", 7).unwrap();
        assert!(left("show").is_empty() && copy.path() != other.path(), "they run");
        drop(copy);
        // A program that another test starts just now has the lock, too, until it begins to run.
        let found = (0..600_000).find_map(|_| {
            let found = Some(left("show")).filter(|found| !found.is_empty());
            found.or_else(|| {
                std::thread::sleep(Duration::from_millis(2));
                None
            })
        });
        let found = found.unwrap();
        assert_eq!(found.iter().map(|path| std::fs::read(path).unwrap()).collect::<Vec<_>>(), [b"second"]);
        assert!(left("sho").is_empty() && left("session").is_empty());
        RecoveryCopy::discard(&found[0]);
        other.keep(b"third").unwrap();
        other.finish();
        assert!(left("show").is_empty() && std::fs::read_dir(&folder).unwrap().count() == 0);
    }
}
