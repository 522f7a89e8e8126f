//! The cache where it is hard to keep one: a full disk, a read-only one, and another process that works in it.

#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "a panic is how a test fails, and a skipped one says so"
)]

mod shapes;

use std::path::{Path, PathBuf};
use std::process::Command;

use chladni_harmonics::{BasisCache, BasisSettings, Body, BuildReport};
use chladni_task::Task;
use chladni_testdata::{CHILDS_FOLDER, childs_folder, ignored_test, in_shell, on_a_small_disk};

/// Its entry has some 12 KB, one of many harmonics 200 KB.
const FEW: usize = 8;
const MANY: usize = 150;

fn build(folder: &Path, harmonics: usize) -> (Body, BuildReport) {
    let settings = BasisSettings { threads: Some(1), ..BasisSettings::new(harmonics) };
    let cache = BasisCache::new(folder);
    Body::load_or_build(&shapes::icosphere(2), &settings, Some(&cache), &Task::new()).unwrap()
}

/// Files that a run has left besides entries.
fn besides_entries(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    entries.filter(|path| path.extension().is_none_or(|ending| ending != "basis")).collect()
}

#[test]
fn a_full_disk_costs_the_entry_and_nothing_else() {
    on_a_small_disk(64, &in_shell(&ignored_test("fills_the_disk")));
}

#[test]
#[ignore = "run by a_full_disk_costs_the_entry_and_nothing_else"]
fn fills_the_disk() {
    let Some(folder) = childs_folder() else { return };
    assert!(build(&folder, FEW).1.cache_warning.is_none());
    let (body, report) = build(&folder, MANY);
    assert_eq!(body.basis.harmonics(), MANY);
    let warning = report.cache_warning.unwrap();
    assert!(!report.cached && warning.contains("the disk is full: make room"), "{warning}");
    assert!(besides_entries(&folder).is_empty());
    assert!(build(&folder, FEW).1.cached, "what was there is still used");
}

#[test]
fn a_cache_that_is_read_only_is_read() {
    let [first, then] = ["writes_an_entry", "reads_only"].map(|test| in_shell(&ignored_test(test)));
    on_a_small_disk(64, &format!("{first}\nmount -o remount,bind,ro \"${CHILDS_FOLDER}\"\n{then}"));
}

#[test]
#[ignore = "run by a_cache_that_is_read_only_is_read"]
fn writes_an_entry() {
    let Some(folder) = childs_folder() else { return };
    assert!(build(&folder, FEW).1.cache_warning.is_none());
}

#[test]
#[ignore = "run by a_cache_that_is_read_only_is_read"]
fn reads_only() {
    let Some(folder) = childs_folder() else { return };
    assert!(build(&folder, FEW).1.cached);
    let (body, report) = build(&folder, FEW + 1);
    assert_eq!(body.basis.harmonics(), FEW + 1);
    let warning = report.cache_warning.unwrap();
    assert!(!report.cached && warning.contains("the disk is read-only"), "{warning}");
}

/// Its folder may be read but not written, as in a home that somebody else has set up. Everything is allowed to root, which
/// therefore runs the child as nobody.
#[cfg(unix)]
#[test]
fn a_cache_in_a_folder_of_somebody_else_is_read() {
    use std::os::unix::fs::PermissionsExt;
    let home = tempfile::tempdir().unwrap();
    let folder = home.path().join("cache");
    let let_in =
        |path: &Path, mode| std::fs::set_permissions(path, std::fs::Permissions::from_mode(mode)).unwrap();
    assert!(build(&folder, FEW).1.cache_warning.is_none());
    let_in(home.path(), 0o755);
    let_in(&folder, 0o555);
    let before = besides_entries(&folder);
    let mut words = ignored_test("reads_as_another_user");
    if std::fs::write(folder.join("root"), "").is_ok() {
        std::fs::remove_file(folder.join("root")).unwrap();
        let nobody = ["setpriv", "--reuid=65534", "--regid=65534", "--clear-groups", "--"].map(str::to_owned);
        let lists = Command::new(&nobody[0]).args(&nobody[1..]).args([&words[0], "--list"]).output();
        if !lists.is_ok_and(|output| output.status.success()) {
            return println!("skipped: nobody may not run the test");
        }
        words = [&nobody[..], &words].concat();
    }
    let output = Command::new(&words[0]).args(&words[1..]).env(CHILDS_FOLDER, &folder).output().unwrap();
    let_in(&folder, 0o755);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stdout));
    assert_eq!(besides_entries(&folder), before);
}

#[test]
#[ignore = "run by a_cache_in_a_folder_of_somebody_else_is_read"]
fn reads_as_another_user() {
    let Some(folder) = childs_folder() else { return };
    let (_, report) = build(&folder, FEW);
    assert!(report.cached && report.cache_warning.is_none(), "{report:?}");
    let (body, report) = build(&folder, FEW + 1);
    assert_eq!(body.basis.harmonics(), FEW + 1);
    let warning = report.cache_warning.unwrap();
    assert!(!report.cached && warning.contains("write to a folder of your own"), "{warning}");
}

#[test]
fn an_entry_of_another_version_is_solved_again() {
    let folder = tempfile::tempdir().unwrap();
    let (fresh, _) = build(folder.path(), FEW);
    let entry = std::fs::read_dir(folder.path()).unwrap().next().unwrap().unwrap().path();
    let ours = std::fs::read(&entry).unwrap();
    // Whole, with a checksum that is right, by a program whose layout has another number.
    let mut theirs = ours[..ours.len() - 32].to_vec();
    theirs[15] += 1;
    theirs.extend_from_slice(blake3::hash(&theirs).as_bytes());
    std::fs::write(&entry, theirs).unwrap();
    let (body, report) = build(folder.path(), FEW);
    assert!(!report.cached && report.cache_warning.is_some());
    assert_eq!(body.basis, fresh.basis);
    assert_eq!(std::fs::read(&entry).unwrap(), ours);
    // Solvers of other versions name their entries otherwise, and those stay for them.
    let other = folder.path().join(format!("{}.basis", "0".repeat(64)));
    std::fs::write(&other, "theirs").unwrap();
    assert!(build(folder.path(), FEW).1.cached && other.exists());
}

#[test]
fn two_processes_share_a_folder() {
    let folder = tempfile::tempdir().unwrap();
    let start = || {
        let words = ignored_test("works_beside_another");
        let mut command = Command::new(&words[0]);
        command.args(&words[1..]).env(CHILDS_FOLDER, folder.path()).spawn().unwrap()
    };
    for mut process in [start(), start()] {
        assert!(process.wait().unwrap().success());
    }
    assert!(besides_entries(folder.path()).is_empty());
}

#[test]
#[ignore = "run by two_processes_share_a_folder"]
fn works_beside_another() {
    let Some(folder) = childs_folder() else { return };
    let alone = tempfile::tempdir().unwrap();
    let right: Vec<_> = (1..6).map(|k| build(alone.path(), k).0.basis).collect();
    for round in 0..60 {
        let k = 1 + round % 5;
        let (body, report) = build(&folder, k);
        assert!(report.cache_warning.is_none(), "{report:?}");
        assert_eq!(body.basis, right[k - 1]);
        if round % 7 == 0 {
            // Somebody clears it; the other may have been quicker.
            let entries = std::fs::read_dir(&folder).unwrap().filter_map(Result::ok);
            entries
                .filter(|entry| entry.path().extension().is_some_and(|ending| ending == "basis"))
                .for_each(|entry| drop(std::fs::remove_file(entry.path())));
        }
    }
}
