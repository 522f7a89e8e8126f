//! Files that several programs read, change and write: one of them at a time.

use std::fs::{File, TryLockError};
use std::path::Path;
use std::thread::sleep;
use std::time::Duration;

use crate::{folder_of, where_it_leads};

/// Waiting ends after this many pauses, two seconds in all: a program that was stopped may hold the lock for ever.
const PAUSES: u32 = 200;
const PAUSE: Duration = Duration::from_millis(10);

/// Does `work`, which reads, changes and writes the file at `path`, while no other program does the same by this function
/// to a file in that folder. Within `work`, it may not be called again for the folder.
///
/// The lock, on the folder, is advisory. It is waited for two seconds at most; after that, and where a folder cannot be
/// locked, as on Windows and on some network drives, `work` is done without it.
pub fn alone<T>(path: &Path, work: impl FnOnce() -> T) -> T {
    let _held = locked(folder_of(&where_it_leads(path)));
    work()
}

/// The folder, locked until it is dropped.
fn locked(folder: &Path) -> Option<File> {
    let folder = File::open(folder).ok()?;
    for _ in 0..PAUSES {
        match folder.try_lock() {
            Ok(()) => return Some(folder),
            Err(TryLockError::WouldBlock) => sleep(PAUSE),
            Err(TryLockError::Error(_)) => return None,
        }
    }
    None
}

#[cfg(all(test, unix))]
#[allow(clippy::unwrap_used, reason = "a panic is how a test fails")]
mod tests {
    use super::*;

    #[test]
    fn of_those_that_count_in_a_file_at_once_each_is_counted() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("count");
        std::fs::write(&path, "0").unwrap();
        let start = std::sync::Barrier::new(8);
        let count = || {
            start.wait();
            alone(&path, || {
                let counted: u32 = std::fs::read_to_string(&path).unwrap().parse().unwrap();
                std::fs::write(&path, (counted + 1).to_string()).unwrap();
            });
        };
        std::thread::scope(|scope| {
            for _ in 0..8 {
                scope.spawn(count);
            }
        });
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "8");
    }

    #[test]
    fn where_no_folder_is_the_work_is_done() {
        assert_eq!(alone(Path::new("/no/such/folder/file"), || 7), 7);
    }
}
