//! Copies on a disk that is full, then read-only, and each time freed again.

use std::io::Write;

use chladni_caricature::Action;
use chladni_task::{Needs, other_program};

use super::tests::{changed, copies, found, tick_until};
use super::*;

/// The small disk on which the child works.
const DISK: &str = "CHLADNI_TEST_SMALL_DISK";

fn run(script: &str, disk: &Path) -> bool {
    let output = other_program("sh", Needs::Files).args(["-ec", script]).env(DISK, disk).output();
    if let Ok(output) = &output {
        println!("{}", String::from_utf8_lossy(&output.stdout));
        println!("{}", String::from_utf8_lossy(&output.stderr));
    }
    output.is_ok_and(|output| output.status.success())
}

#[test]
fn a_disk_that_is_full_or_read_only_is_said_once_and_the_copy_follows_when_it_is_not() {
    let disk = tempfile::tempdir().unwrap();
    let mount = format!("mount -t tmpfs -o size=64k tmpfs \"${DISK}\"");
    // In a view of the file system of its own.
    let apart = |script: &str| run(&format!("exec unshare -rm sh -ec '{script}'"), disk.path());
    if !apart(&format!("{mount}\nmount --bind \"${DISK}\" \"${DISK}\"")) {
        return println!("skipped: no disk can be mounted");
    }
    let name = std::thread::current().name().unwrap().rsplit_once("::").unwrap().0.to_owned();
    let program = std::env::current_exe().unwrap();
    let child = format!("\"{}\" --exact {name}::keeps_copies_on_a_small_disk --ignored", program.display());
    assert!(apart(&format!("{mount}\n{child}")));
}

fn refused(autosave: &mut Autosave, history: &History, advice: &str) {
    let said = tick_until(autosave, history, |message| message.is_some()).unwrap();
    assert!(said.contains(advice), "{said}");
    for _ in 0..5 {
        assert_eq!(tick_until(autosave, history, |_| true), None, "said once");
    }
}

/// The child of the test above.
#[test]
#[ignore = "run by a_disk_that_is_full_or_read_only_is_said_once_and_the_copy_follows_when_it_is_not"]
fn keeps_copies_on_a_small_disk() {
    let Some(disk) = std::env::var_os(DISK).map(PathBuf::from) else { return };
    let folder = disk.join("recovery");
    let mut history = changed();
    let mut autosave = Autosave::start(&folder).unwrap();
    let filler = disk.join("filler");
    let mut full = std::fs::File::create(&filler).unwrap();
    while full.write_all(&[0; 4096]).is_ok() {}
    drop(full);
    refused(&mut autosave, &history, "the disk is full: make room");
    std::fs::remove_file(filler).unwrap();
    tick_until(&mut autosave, &history, |_| copies(&folder) > 0);

    // Over the disk, on which a file is open.
    let read_only = format!("mount --bind \"${DISK}\" \"${DISK}\"\nmount -o remount,bind,ro \"${DISK}\"");
    assert!(run(&read_only, &disk));
    history.apply(&Action::SetHarmonics(9), None).unwrap();
    refused(&mut autosave, &history, "the disk is read-only: write to another one");
    assert!(run(&format!("umount -l \"${DISK}\""), &disk));
    tick_until(&mut autosave, &history, |_| true);
    drop(autosave);
    assert_eq!(found(&folder)[0].project.harmonics, 9);
}
