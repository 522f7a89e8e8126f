//! Tests that run in a process of their own, some of them on a disk that is soon full.

use std::path::PathBuf;
use std::process::Command;

/// Names the folder in which a child works.
pub const CHILDS_FOLDER: &str = "CHLADNI_TEST_FOLDER";

/// The folder in which a child works; `None` in the run of all tests, which passes over it.
pub fn childs_folder() -> Option<PathBuf> {
    std::env::var_os(CHILDS_FOLDER).map(PathBuf::from)
}

/// The words of a command that runs the ignored test `name`, which stands beside the test that asks, in a process of its
/// own.
///
/// # Panics
/// Outside a test.
pub fn ignored_test(name: &str) -> Vec<String> {
    let program = std::env::current_exe().expect("a test program");
    let thread = std::thread::current();
    let module = thread.name().expect("the name of a test").rsplit_once("::");
    let name = module.map_or_else(|| name.to_owned(), |(module, _)| format!("{module}::{name}"));
    let program = program.to_str().expect("a path in Unicode").to_owned();
    vec![program, "--exact".to_owned(), name, "--ignored".to_owned(), "--test-threads=1".to_owned()]
}

/// Runs a script of the shell with a disk of so many KiB at `$CHLADNI_TEST_FOLDER`, in a view of the file system of its own;
/// prints a line where the system allows none.
///
/// # Panics
/// Where the script fails.
#[allow(clippy::print_stderr, reason = "a skipped test must say so")]
pub fn on_a_small_disk(kib: u32, script: &str) {
    let folder = tempfile::tempdir().expect("a folder to mount it at");
    let mount = format!("mount -t tmpfs -o size={kib}k tmpfs \"${CHILDS_FOLDER}\"");
    let run = |script: &str| {
        let mut shell = Command::new("unshare");
        shell.args(["-rm", "sh", "-ec", script]).env(CHILDS_FOLDER, folder.path()).output()
    };
    if !run(&mount).is_ok_and(|output| output.status.success()) {
        return eprintln!("skipped: no disk can be mounted");
    }
    let output = run(&format!("{mount}\n{script}")).expect("it ran before");
    let said =
        [output.stdout, output.stderr].map(|said| String::from_utf8_lossy(&said).into_owned()).concat();
    assert!(output.status.success(), "{said}");
}

/// The words of a command as a line of a script.
pub fn in_shell(words: &[String]) -> String {
    words.iter().map(|word| format!("'{word}'")).collect::<Vec<_>>().join(" ")
}
