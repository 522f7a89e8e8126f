//! Temporary files of processes that were killed while they saved: gone once something is saved beside them.

use std::collections::BTreeSet;
use std::fs::{DirEntry, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use tempfile::NamedTempFile;

/// How the name of a temporary file begins; random letters and digits follow, and an ending.
pub(super) const PREFIX: &str = ".chladni-draft-";
pub(super) const RANDOM: usize = 12;

/// Files written to within this time stay: a file is created and locked in two steps, and some file systems know only
/// the locks of their own machine.
const AT_WORK: Duration = Duration::from_secs(3600);

/// Marks a temporary file as somebody's, until it is closed or its process ends. Without locks it is never removed as
/// nobody's.
pub(super) fn claim(file: &File) {
    // Elsewhere a locked file could not be written by the programs that are given its name.
    if cfg!(unix) {
        let _ = file.try_lock();
    }
}

/// Gives up the [`claim`] where it would keep others from writing to the file by its name: a lock on a share of SMB
/// holds off every other handle, those of this process, too.
pub(super) fn let_others_write(draft: &NamedTempFile) {
    let written = File::options().write(true).open(draft.path()).and_then(|mut other| {
        other.write_all(b" ")?;
        other.set_len(0)
    });
    if written.is_err() {
        let _ = draft.as_file().unlock();
    }
}

/// Removes what killed processes left in a folder, when this process saves there first: folders may hold very many files.
pub(super) fn sweep_once(folder: &Path) {
    static SWEPT: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());
    if cfg!(unix) && SWEPT.lock().unwrap_or_else(PoisonError::into_inner).insert(folder.to_owned()) {
        sweep(folder);
    }
}

/// Files that cannot be read or removed stay: a failure here must not fail the save.
fn sweep(folder: &Path) {
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        if is_ours(&entry.file_name().to_string_lossy()) {
            let _ = remove_if_left(&entry);
        }
    }
}

fn is_ours(name: &str) -> bool {
    let Some((random, ending)) = name.strip_prefix(PREFIX).and_then(|rest| rest.split_at_checked(RANDOM))
    else {
        return false;
    };
    random.bytes().all(|byte| byte.is_ascii_alphanumeric()) && (ending.is_empty() || ending.starts_with('.'))
}

fn remove_if_left(entry: &DirEntry) -> io::Result<()> {
    let known = entry.metadata()?;
    if !known.is_file() || known.modified()?.elapsed().unwrap_or_default() < AT_WORK {
        return Ok(());
    }
    let file = File::options().write(true).open(entry.path())?;
    file.try_lock()?;
    std::fs::remove_file(entry.path())
}

#[cfg(all(test, unix))]
#[allow(clippy::unwrap_used, reason = "a panic is how a test fails")]
mod tests {
    use super::super::{temporary_beside, write_atomic};
    use super::*;
    use std::time::SystemTime;

    fn age(path: &Path) {
        date(path, SystemTime::now() - 2 * AT_WORK);
    }

    fn date(path: &Path, written: SystemTime) {
        File::options().write(true).open(path).unwrap().set_modified(written).unwrap();
    }

    #[test]
    fn a_draft_of_the_future_stays_and_keeps_nobody_from_saving() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        let (future, past) = (path(".chladni-draft-Ab12Xz34Cd56"), path(".chladni-draft-Ab12Xz34Cd57"));
        let year = Duration::from_secs(365 * 86_400);
        for (draft, written) in [(&future, SystemTime::now() + year), (&past, SystemTime::UNIX_EPOCH)] {
            std::fs::write(draft, "half").unwrap();
            date(draft, written);
        }
        write_atomic(&path("p.chladni"), b"new").unwrap();
        assert_eq!(std::fs::read(path("p.chladni")).unwrap(), b"new");
        assert!(future.exists() && !past.exists());
    }

    #[test]
    fn what_nobody_holds_and_nobody_wrote_to_for_an_hour_goes() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        // A name that a person may give is nobody's draft.
        let kept = [
            ".chladni-draft-Ab12",
            ".chladni-draft-Ab12Xz34Cd56s.txt",
            ".chladni-backup",
            ".chladni-config.toml",
            ".chladni-ranks-7",
            "p.chladni",
        ];
        for name in [".chladni-draft-Ab12Xz34Cd56", ".chladni-draft-000000000000.mp4"].iter().chain(&kept) {
            std::fs::write(path(name), "half").unwrap();
            age(&path(name));
        }
        std::fs::write(path(".chladni-draft-young0000000"), "half").unwrap();
        std::fs::create_dir(path(".chladni-draft-folder000000")).unwrap();
        std::os::unix::fs::symlink("p.chladni", path(".chladni-draft-link00000000")).unwrap();
        let held = temporary_beside(&path("film.mp4"), ".mp4").unwrap();
        assert_eq!(held.path().metadata().unwrap().len(), 0, "trying it leaves nothing in it");
        age(held.path());
        sweep(folder.path());
        assert!(
            !path(".chladni-draft-Ab12Xz34Cd56").exists()
                && !path(".chladni-draft-000000000000.mp4").exists()
        );
        let others =
            [".chladni-draft-young0000000", ".chladni-draft-folder000000", ".chladni-draft-link00000000"];
        assert!(kept.iter().chain(&others).all(|name| path(name).exists()));
        assert!(held.path().exists(), "it is being written");
        let left = held.into_temp_path().keep().unwrap();
        // A program that another test starts just now holds it, too, until it begins to run.
        for _ in 0..600_000 {
            sweep(folder.path());
            if !left.exists() {
                break;
            }
            std::thread::sleep(Duration::from_millis(2));
        }
        assert!(!left.exists(), "nobody holds it any more");
    }

    #[test]
    fn the_first_save_in_a_folder_sweeps_it() {
        let folder = tempfile::tempdir().unwrap();
        let (left, saved) =
            (folder.path().join(".chladni-draft-Ab12Xz34Cd56"), folder.path().join("p.chladni"));
        for sweeps in [true, false] {
            std::fs::write(&left, "half").unwrap();
            age(&left);
            write_atomic(&saved, b"new").unwrap();
            assert_eq!(left.exists(), !sweeps);
        }
    }
}
