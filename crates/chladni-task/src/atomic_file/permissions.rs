//! Permissions of written files: only the owner can read one while it is written; then the old file's permissions return.

use std::fs::{Metadata, Permissions};
use std::io;
use std::path::Path;

use tempfile::{NamedTempFile, TempDir};

use super::system::System;
use super::{draft_in, folder_of};

/// Who can read a file that was not there before.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Readers {
    /// Those whom the system lets read any new file.
    Usual,
    Owner,
}

/// The mode of a file that only its owner can read.
pub(super) const PRIVATE: u32 = 0o600;

/// Gives a complete temporary file the permissions of the file that it replaces, or those of a new one in its folder.
pub(super) fn give(
    system: &dyn System,
    draft: &NamedTempFile,
    replaced: Option<&Metadata>,
    readers: Readers,
) -> io::Result<()> {
    if !cfg!(unix) {
        return Ok(());
    }
    let wanted = match (replaced, readers) {
        (Some(known), _) => known.permissions(),
        (None, Readers::Owner) => return Ok(()),
        (None, Readers::Usual) => of_a_new_file(system, folder_of(draft.path()))?,
    };
    let file = draft.as_file();
    // Some file systems have a single set of permissions and refuse to hear of others.
    if file.metadata()?.permissions() == wanted { Ok(()) } else { system.set_permissions(file, wanted) }
}

/// The permissions that the system gives new files in a folder, as those of an empty one that is removed at once: a process can
/// read its mask only by changing it, and the folder may have rules of its own.
fn of_a_new_file(system: &dyn System, folder: &Path) -> io::Result<Permissions> {
    Ok(draft_in(system, folder, "", 0o666)?.as_file().metadata()?.permissions())
}

/// A new folder in `parent`, with a name that begins with `prefix`. On Unix, only its owner can enter it. It is removed when it is
/// dropped.
///
/// # Errors
/// The folder cannot be made.
pub fn private_folder(prefix: &str, parent: &Path) -> io::Result<TempDir> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(prefix);
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(Permissions::from_mode(0o700));
    }
    builder.tempdir_in(parent)
}

/// Lets only its owner enter a folder, if the file system can.
#[cfg(unix)]
pub(super) fn shut_others_out(folder: &Path) {
    use std::os::unix::fs::PermissionsExt;
    if std::fs::metadata(folder).is_ok_and(|known| known.permissions().mode() & 0o077 != 0) {
        let _ = std::fs::set_permissions(folder, Permissions::from_mode(0o700));
    }
}

#[cfg(not(unix))]
pub(super) fn shut_others_out(_folder: &Path) {}

/// Whether the link at `link` in `folder` may be followed. Linux itself does not follow those that may not
/// (`fs.protected_symlinks`), but says where they lead.
#[cfg(unix)]
pub(super) fn may_follow(link: &Path, folder: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let (Ok(link), Ok(around)) = (link.symlink_metadata(), folder.metadata()) else { return false };
    // A new file belongs to the user of this process.
    let own = || Some(tempfile::tempfile_in(folder).ok()?.metadata().ok()?.uid());
    is_trusted(link.uid(), (around.uid(), around.mode()), own)
}

#[cfg(not(unix))]
pub(super) fn may_follow(_link: &Path, _folder: &Path) -> bool {
    true
}

/// Whether a link with this owner is followed in a folder with this owner and mode: where everybody may write, it must
/// belong to the user, whose number is `own`, or to the folder's owner.
#[cfg(unix)]
fn is_trusted(owner: u32, (around, mode): (u32, u32), own: impl FnOnce() -> Option<u32>) -> bool {
    const STICKY_AND_WRITABLE: u32 = 0o1002;
    mode & STICKY_AND_WRITABLE != STICKY_AND_WRITABLE || owner == around || own() == Some(owner)
}

#[cfg(all(test, unix))]
#[allow(clippy::unwrap_used, reason = "a panic is how a test fails")]
mod tests {
    use std::io::Write;
    use std::os::unix::fs::PermissionsExt;
    use std::path::PathBuf;

    use super::super::{persist, temporary_beside, write_atomic_private, write_atomic_with};
    use super::*;

    fn mode(path: &Path) -> u32 {
        path.metadata().unwrap().permissions().mode() & 0o777
    }

    fn files(folder: &Path) -> Vec<PathBuf> {
        std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect()
    }

    #[test]
    fn only_its_owner_reads_a_file_that_is_being_written() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("p.chladni");
        // Those who could read the old file can read the new one, but not what may never become it.
        for old in [None, Some(0o644), Some(0o640), Some(0o600), Some(0o666)] {
            if let Some(old) = old {
                std::fs::write(&path, "old").unwrap();
                std::fs::set_permissions(&path, Permissions::from_mode(old)).unwrap();
            }
            write_atomic_with(&path, |file| {
                file.write_all(b"new")?;
                file.flush()?;
                let drafts: Vec<_> =
                    files(folder.path()).into_iter().filter(|found| *found != path).collect();
                assert_eq!(drafts.iter().map(|draft| mode(draft)).collect::<Vec<_>>(), [0o600]);
                Ok(())
            })
            .unwrap();
            let made = folder.path().join("plain");
            std::fs::write(&made, "").unwrap();
            assert_eq!(mode(&path), old.unwrap_or(mode(&made)), "{old:?}");
            std::fs::remove_file(made).unwrap();
            assert_eq!(files(folder.path()), std::slice::from_ref(&path), "nothing lies beside it");
        }
    }

    #[test]
    fn a_film_is_private_until_it_is_complete() {
        let folder = tempfile::tempdir().unwrap();
        let (path, made) = (folder.path().join("film.mp4"), folder.path().join("plain"));
        std::fs::write(&made, "").unwrap();
        let file = temporary_beside(&path, ".mp4").unwrap();
        assert_eq!(mode(file.path()), 0o600);
        persist(file, &path).unwrap();
        assert_eq!(mode(&path), mode(&made));
    }

    #[test]
    fn links_of_others_are_not_trusted_where_everybody_writes() {
        let is_trusted = |owner, mode| is_trusted(owner, (0, mode), || Some(7));
        assert!(is_trusted(7, 0o41777) && is_trusted(0, 0o41777) && !is_trusted(8, 0o41777));
        assert!(is_trusted(8, 0o40755) && is_trusted(8, 0o40777) && is_trusted(8, 0o41775));
    }

    #[test]
    fn what_is_private_from_the_first_stays_so() {
        let folder = private_folder("p", &std::env::temp_dir()).unwrap();
        assert_eq!(mode(folder.path()), 0o700);
        let path = folder.path().join("copy");
        for _ in 0..2 {
            write_atomic_private(&path, b"new").unwrap();
            assert_eq!(mode(&path), 0o600);
        }
    }
}
