//! Tests that replace any single system call by a fault, or crash between any two.

use std::cell::RefCell;
use std::fs::{File, Permissions};
use std::io::{self, ErrorKind, Read, Write};
use std::path::{Path, PathBuf};

use tempfile::{NamedTempFile, PersistError};

use super::advice::DISK_FAILED;
use super::system::{Disk, System};
use super::{Draft, Readers, add, advised, create, finish, finish_new, make_folders, replace};

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Call {
    Create,
    Write,
    SetPermissions,
    Sync,
    Rename,
    MakeFolder,
    SyncFolder,
}

type Refusal = fn() -> io::Error;

/// The fault that replaces a call.
#[derive(Clone, Copy, Debug)]
enum Fault {
    Error(Refusal),
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
            Some((_, Fault::Error(error))) => Err(error()),
            due => Ok(due.map(|(_, fault)| fault)),
        }
    }

    /// The file must be complete before it gets its name.
    fn named(&self, file: &NamedTempFile) -> io::Result<()> {
        let mut bytes = Vec::new();
        file.reopen()?.read_to_end(&mut bytes)?;
        assert_eq!(bytes, new_text());
        self.called(Call::Rename).map(drop)
    }
}

impl System for Faulty {
    fn create(&self, path: &Path, mode: u32) -> io::Result<File> {
        self.called(Call::Create)?;
        Disk.create(path, mode)
    }

    fn write(&self, file: &mut File, bytes: &[u8]) -> io::Result<usize> {
        let short = self.called(Call::Write)?.is_some();
        Disk.write(file, if short { &bytes[..bytes.len() / 2] } else { bytes })
    }

    fn set_permissions(&self, file: &File, wanted: Permissions) -> io::Result<()> {
        self.called(Call::SetPermissions)?;
        Disk.set_permissions(file, wanted)
    }

    fn sync(&self, file: &File) -> io::Result<()> {
        self.called(Call::Sync)?;
        Disk.sync(file)
    }

    fn rename(&self, file: NamedTempFile, path: &Path) -> io::Result<()> {
        self.named(&file)?;
        Disk.rename(file, path)
    }

    fn rename_new(&self, file: NamedTempFile, path: &Path) -> Result<(), PersistError> {
        match self.named(&file) {
            Ok(()) => Disk.rename_new(file, path),
            Err(error) => Err(PersistError { error, file }),
        }
    }

    fn make_folder(&self, path: &Path) -> io::Result<()> {
        self.called(Call::MakeFolder)?;
        Disk.make_folder(path)
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
    let write = |file: &mut io::BufWriter<Draft<'_>>| {
        new_text().chunks(50_000).try_for_each(|part| file.write_all(part))
    };
    replace(system, &system.path, Readers::Usual, write)
}

fn save_private(system: &Faulty) -> io::Result<()> {
    replace(system, &system.path, Readers::Owner, |file| file.write_all(&new_text()))
}

fn save_new(system: &Faulty) -> io::Result<()> {
    add(system, &system.path, &new_text())
}

/// A complete file as another program may have written it.
fn complete(system: &Faulty) -> io::Result<NamedTempFile> {
    let mut file = create(system, &system.path, ".mp4").map_err(advised)?;
    Draft { file: file.as_file_mut(), system }.write_all(&new_text()).map_err(advised)?;
    Ok(file)
}

fn keep(system: &Faulty) -> io::Result<()> {
    finish(system, complete(system)?, &system.path, Readers::Usual)
}

fn keep_new(system: &Faulty) -> io::Result<()> {
    let names = [system.path.clone(), system.path.with_extension("2")];
    let name = finish_new(system, complete(system)?, names.into_iter())?;
    assert_eq!(name, system.path);
    Ok(())
}

type Save = fn(&Faulty) -> io::Result<()>;

/// Every way to save a file, with whether it replaces one.
const SAVES: [(Save, bool); 8] = [
    (save, true),
    (save, false),
    (save_private, true),
    (save_private, false),
    (keep, true),
    (keep, false),
    (save_new, false),
    (keep_new, false),
];

fn put_old(path: &Path, replaces: bool) -> Option<Vec<u8>> {
    let _ = std::fs::remove_file(path);
    replaces.then(|| {
        std::fs::write(path, "old").unwrap();
        b"old".to_vec()
    })
}

#[test]
fn a_crash_between_any_two_calls_leaves_the_old_file_or_the_new_one_and_both_last() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("p.chladni");
    for (save, replaces) in SAVES {
        let old = put_old(&path, replaces);
        let system = Faulty::new(&path, None);
        save(&system).unwrap();
        let calls = system.calls.take();
        // The bytes are on the disk before the name is, and the name is on the disk when the function
        // returns.
        let (before, last) = calls.split_at(calls.len() - 3);
        assert_eq!(last, [Call::Sync, Call::Rename, Call::SyncFolder]);
        assert!(before[0] == Call::Create && before.contains(&Call::Write), "{calls:?}");
        let left = system.left.take();
        let renamed = calls.len() - 1;
        assert!(left[..renamed].iter().all(|found| *found == old));
        assert_eq!(left[renamed].as_deref(), Some(&new_text()[..]));
        assert_eq!(content(&path), Some(new_text()));
    }
}

/// Errors of the system, with what is advised where they are met.
const ERRORS: [(Refusal, &str); 6] = [
    (|| ErrorKind::StorageFull.into(), "make room"),
    (|| ErrorKind::QuotaExceeded.into(), "make room"),
    (|| ErrorKind::ReadOnlyFilesystem.into(), "write to another"),
    (|| ErrorKind::PermissionDenied.into(), "folder of your own"),
    (|| ErrorKind::CrossesDevices.into(), "write to another"),
    (|| io::Error::from_raw_os_error(DISK_FAILED[0]), "the disk failed: write to another"),
];

#[test]
fn a_fault_in_any_call_keeps_the_old_file_and_says_what_to_do() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("p.chladni");
    for (save, replaces) in SAVES {
        put_old(&path, replaces);
        let probe = Faulty::new(&path, None);
        save(&probe).unwrap();
        for (number, call) in probe.calls.take().into_iter().enumerate() {
            for (error, advice) in ERRORS {
                let old = put_old(&path, replaces);
                let system = Faulty::new(&path, Some((number, Fault::Error(error))));
                let found = save(&system).unwrap_err();
                assert_eq!(found.kind(), error().kind(), "{call:?}");
                let (expected, advice) = match call {
                    Call::SyncFolder => (Some(new_text()), "the new file is in place"),
                    _ => (old, advice),
                };
                assert!(found.to_string().contains(advice), "{call:?}: {found}");
                let files = usize::from(expected.is_some());
                assert_eq!(content(&path), expected, "{call:?}, {found}");
                assert_eq!(
                    std::fs::read_dir(folder.path()).unwrap().count(),
                    files,
                    "nothing lies beside it"
                );
            }
        }
    }
}

#[test]
fn a_short_write_and_a_signal_change_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("p.chladni");
    for (save, replaces) in SAVES {
        put_old(&path, replaces);
        let probe = Faulty::new(&path, None);
        save(&probe).unwrap();
        let calls = probe.calls.take();
        let writes = calls.iter().enumerate().filter(|(_, call)| **call == Call::Write);
        for number in writes.map(|(number, _)| number) {
            for fault in [Fault::Short, Fault::Error(|| ErrorKind::Interrupted.into())] {
                put_old(&path, replaces);
                let system = Faulty::new(&path, Some((number, fault)));
                save(&system).unwrap();
                assert_eq!(content(&path), Some(new_text()), "call {number}, {fault:?}");
            }
        }
    }
}

#[test]
fn a_name_that_is_taken_costs_nothing_and_the_next_one_is_given() {
    let folder = tempfile::tempdir().unwrap();
    let names = ["set.mp4", "set (2).mp4", "set (3).mp4"].map(|name| folder.path().join(name));
    std::fs::write(&names[0], "old").unwrap();
    let system = Faulty::new(&names[0], None);
    let kept = || finish_new(&system, complete(&system).unwrap(), names.clone().into_iter());
    assert_eq!(kept().unwrap(), names[1]);
    assert_eq!(kept().unwrap(), names[2]);
    assert_eq!(kept().unwrap_err().kind(), ErrorKind::AlreadyExists);
    assert_eq!(content(&names[0]).unwrap(), b"old");
    assert!(names[1..].iter().all(|name| content(name) == Some(new_text())));
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 3, "drafts are gone");
}

#[test]
fn a_fault_while_folders_are_made_says_what_to_do_and_is_mended_by_trying_again() {
    let probe = Faulty::new(Path::new(""), None);
    let home = tempfile::tempdir().unwrap();
    make_folders(&probe, &home.path().join("probe/b")).unwrap();
    let calls = probe.calls.take();
    assert_eq!(calls, [Call::MakeFolder, Call::SyncFolder].repeat(2));
    for (number, call) in calls.into_iter().enumerate() {
        for (at, (error, advice)) in ERRORS.into_iter().enumerate() {
            let new = home.path().join(format!("{number}-{at}/b"));
            let system = Faulty::new(Path::new(""), Some((number, Fault::Error(error))));
            let said = make_folders(&system, &new).map_err(advised).unwrap_err().to_string();
            assert!(said.contains(advice), "{call:?}: {said}");
            make_folders(&Disk, &new).unwrap();
            assert!(new.is_dir());
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
