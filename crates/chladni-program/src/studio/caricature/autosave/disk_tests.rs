//! Copies on a disk that is full, then read-only, and each time freed again.

use std::io::Write;

use chladni_caricature::Action;
use chladni_task::{Needs, other_program};
use chladni_testdata::{CHILDS_FOLDER, childs_folder, ignored_test, in_shell, on_a_small_disk};

use super::tests::{changed, copies, found, tick_until};
use super::*;

fn run(script: &str, disk: &Path) -> bool {
    let output = other_program("sh", Needs::Files).args(["-ec", script]).env(CHILDS_FOLDER, disk).output();
    if let Ok(output) = &output {
        println!("{}", String::from_utf8_lossy(&output.stdout));
        println!("{}", String::from_utf8_lossy(&output.stderr));
    }
    output.is_ok_and(|output| output.status.success())
}

#[test]
fn a_disk_that_is_full_or_read_only_is_said_once_and_the_copy_follows_when_it_is_not() {
    on_a_small_disk(64, &in_shell(&ignored_test("keeps_copies_on_a_small_disk")));
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
    let Some(disk) = childs_folder() else { return };
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
    let read_only = format!(
        "mount --bind \"${CHILDS_FOLDER}\" \"${CHILDS_FOLDER}\"\nmount -o remount,bind,ro \"${CHILDS_FOLDER}\""
    );
    assert!(run(&read_only, &disk));
    history.apply(&Action::SetHarmonics(9), None).unwrap();
    refused(&mut autosave, &history, "the disk is read-only: write to another one");
    assert!(run(&format!("umount -l \"${CHILDS_FOLDER}\""), &disk));
    tick_until(&mut autosave, &history, |_| true);
    drop(autosave);
    assert_eq!(found(&folder)[0].project.harmonics, 9);
}
