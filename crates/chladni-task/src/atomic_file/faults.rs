//! Tests that replace any single system call by a fault, or crash between any two.

use std::cell::RefCell;
use std::fs::File;
use std::io::{self, ErrorKind, Read, Write};
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

use super::system::{Disk, System};
use super::{Readers, advised, make_folders, replace};

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Call {
    Create,
    Write,
    Sync,
    Rename,
    SyncFolder,
}

/// The fault that replaces a call.
#[derive(Clone, Copy, Debug)]
enum Fault {
    Error(ErrorKind),
    /// Only half of the bytes are written.
    Short,
}

/// A disk that records the calls it gets, and fails once.
#[derive(Debug)]
struct Faulty {
    path: PathBuf,
    /// The number of the call that fails, and how.
    fails: Option<(usize, Fault)>,
    calls: RefCell<Vec<Call>>,
    /// The file's content at `path` before each call: what a crash at that moment would leave.
    left: RefCell<Vec<Option<Vec<u8>>>>,
}

impl Faulty {
    fn new(path: &Path, fails: Option<(usize, Fault)>) -> Self {
        Self { path: path.to_owned(), fails, calls: RefCell::default(), left: RefCell::default() }
    }

    /// Counts a call. Returns the fault that is due at it, if any.
    fn called(&self, call: Call) -> io::Result<Option<Fault>> {
        let mut calls = self.calls.borrow_mut();
        let number = calls.len();
        calls.push(call);
        self.left.borrow_mut().push(content(&self.path));
        match self.fails.filter(|(at, _)| *at == number) {
            Some((_, Fault::Error(kind))) => Err(kind.into()),
            due => Ok(due.map(|(_, fault)| fault)),
        }
    }
}

impl System for Faulty {
    fn create(&self, builder: &tempfile::Builder<'_, '_>, folder: &Path) -> io::Result<NamedTempFile> {
        self.called(Call::Create)?;
        Disk.create(builder, folder)
    }

    fn write(&self, file: &mut File, bytes: &[u8]) -> io::Result<usize> {
        let short = self.called(Call::Write)?.is_some();
        Disk.write(file, if short { &bytes[..bytes.len() / 2] } else { bytes })
    }

    fn sync(&self, file: &File) -> io::Result<()> {
        self.called(Call::Sync)?;
        Disk.sync(file)
    }

    fn rename(&self, file: NamedTempFile, path: &Path) -> io::Result<()> {
        // The file must be complete before it gets its name.
        let mut bytes = Vec::new();
        file.reopen()?.read_to_end(&mut bytes)?;
        assert_eq!(bytes, new_text());
        self.called(Call::Rename)?;
        Disk.rename(file, path)
    }

    fn sync_folder(&self, folder: &Path) -> io::Result<()> {
        self.called(Call::SyncFolder)?;
        Disk.sync_folder(folder)
    }
}

fn content(path: &Path) -> Option<Vec<u8>> {
    std::fs::read(path).ok()
}

/// More than is written by a single call.
fn new_text() -> Vec<u8> {
    (0..200_000_u32).map(|i| (i * 7) as u8).collect()
}

/// Writes a file in several pieces.
fn save(system: &Faulty) -> io::Result<()> {
    let write = |file: &mut io::BufWriter<super::Draft<'_>>| {
        new_text().chunks(50_000).try_for_each(|part| file.write_all(part))
    };
    replace(system, &system.path, Readers::Usual, write).map_err(advised)
}

#[test]
fn a_crash_between_any_two_calls_leaves_the_old_file_or_the_new_one_and_both_last() {
    let folder = tempfile::tempdir().unwrap();
    for old in [None, Some(b"old".to_vec())] {
        let path = folder.path().join(format!("p{}", old.is_some()));
        if let Some(old) = &old {
            std::fs::write(&path, old).unwrap();
        }
        let system = Faulty::new(&path, None);
        save(&system).unwrap();
        let calls = system.calls.take();
        let (writes, around): (Vec<Call>, Vec<Call>) = calls.iter().partition(|call| **call == Call::Write);
        assert!(writes.len() > 1, "{calls:?}");
        // The bytes are on the disk before the name is, and the name is on the disk when the function
        // returns.
        assert_eq!(around, [Call::Create, Call::Sync, Call::Rename, Call::SyncFolder]);
        assert!(calls[1..=writes.len()].iter().all(|call| *call == Call::Write), "{calls:?}");
        let left = system.left.take();
        let renamed = calls.iter().position(|call| *call == Call::SyncFolder).unwrap();
        assert!(left[..renamed].iter().all(|found| *found == old));
        assert_eq!(left[renamed].as_deref(), Some(&new_text()[..]));
        assert_eq!(content(&path), Some(new_text()));
    }
}

#[test]
fn a_fault_in_any_call_keeps_the_old_file_and_says_what_to_do() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("p.chladni");
    let probe = Faulty::new(&path, None);
    save(&probe).unwrap();
    let calls = probe.calls.take();
    let kinds = [
        (ErrorKind::StorageFull, "make room"),
        (ErrorKind::QuotaExceeded, "make room"),
        (ErrorKind::ReadOnlyFilesystem, "write to another"),
        (ErrorKind::PermissionDenied, "folder of your own"),
        (ErrorKind::Other, ""),
    ];
    for (number, call) in calls.into_iter().enumerate() {
        for (kind, advice) in kinds {
            std::fs::write(&path, "old").unwrap();
            let system = Faulty::new(&path, Some((number, Fault::Error(kind))));
            let error = save(&system).unwrap_err();
            assert_eq!(error.kind(), kind, "{call:?}");
            assert!(error.to_string().contains(advice), "{call:?}: {error}");
            let expected = if call == Call::SyncFolder { new_text() } else { b"old".to_vec() };
            assert_eq!(content(&path), Some(expected), "{call:?}, {kind}");
            assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1, "nothing lies beside it");
        }
    }
}

#[test]
fn a_short_write_and_a_signal_change_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("p.chladni");
    for number in 1..4 {
        for fault in [Fault::Short, Fault::Error(ErrorKind::Interrupted)] {
            let system = Faulty::new(&path, Some((number, fault)));
            save(&system).unwrap();
            assert_eq!(content(&path), Some(new_text()), "call {number}, {fault:?}");
            std::fs::remove_file(&path).unwrap();
        }
    }
}

/// A disk that records which folders are flushed.
#[derive(Debug, Default)]
struct Flushed(RefCell<Vec<PathBuf>>);

impl System for Flushed {
    fn sync_folder(&self, folder: &Path) -> io::Result<()> {
        self.0.borrow_mut().push(folder.to_owned());
        Disk.sync_folder(folder)
    }
}

#[test]
fn a_new_folder_is_flushed_where_it_is_new_from_the_uppermost_down() {
    let home = tempfile::tempdir().unwrap();
    let (above, new) = (home.path().join("a"), home.path().join("a/b"));
    let disk = Flushed::default();
    make_folders(&disk, &new).unwrap();
    assert!(new.is_dir());
    assert_eq!(disk.0.take(), [home.path(), &above]);
    make_folders(&disk, &new).unwrap();
    make_folders(&disk, &new.join("c")).unwrap();
    assert_eq!(disk.0.take(), [new.as_path()]);
    std::fs::write(home.path().join("file"), "").unwrap();
    assert!(make_folders(&disk, &home.path().join("file")).is_err());
    assert!(make_folders(&disk, &home.path().join("file/d")).is_err());
    assert!(disk.0.take().is_empty());
}
