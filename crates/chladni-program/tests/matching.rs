//! `chladni match` as a user would run it.

#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

use std::path::Path;
use std::process::{Command, Output};

use chladni_testdata::shared;

fn chladni(arguments: &[&Path]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_chladni")).arg("--quiet").args(arguments).output().unwrap()
}

/// Exit code 2 and one line that says `why`.
fn refused(output: &Output, why: &str) {
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{said}");
    let errors: Vec<&str> = said.lines().filter(|line| line.starts_with("chladni: ")).collect();
    assert!(errors.len() == 1 && errors[0].contains(why), "{said}");
}

/// Nose, eyes, ears, chin, crown and nape of face.obj and lion.off.
const MAN_LION: &str = "# man lion
2867 4756
6714 8297
9957 838
16591 5346
16586 3411
10694 4598
12032 1388
6170 2388
";

#[test]
fn a_man_and_a_lion_are_mapped_by_eight_landmarks() {
    let (Some(man), Some(lion)) = (shared("meshes/heads/face.obj"), shared("meshes/animals/lion.off")) else {
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let (landmarks, out) = (folder.path().join("pairs.txt"), folder.path().join("m.npz"));
    let run = |text: &str| {
        std::fs::write(&landmarks, text).unwrap();
        let [a, b, c, d] = ["--method", "map", "--landmarks", "--json"].map(Path::new);
        chladni(&[Path::new("match"), &man, &lion, a, b, c, &landmarks, Path::new("-o"), &out, d])
    };
    refused(&run("2867 4756\n6714 8297\n"), "needs three or more");
    refused(&run("2867 4756\n6714 x\n"), "line 2");
    refused(&run("2867 4756\n6714 99999999\n9957 838\n"), "vertex 99999999 of the template does not exist");
    assert!(!out.exists());

    let done = run(MAN_LION);
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    let report: serde_json::Value = serde_json::from_slice(&done.stdout).unwrap();
    let number = |key: &str| report[key].as_f64().unwrap_or_else(|| panic!("{key} in {report}"));
    assert!(number("seconds") > 0.0 && number("median_distance") < number("p95_distance"));
    assert!(number("coverage") > 0.8, "{report}");
    assert!(number("flipped_triangles") < 0.02 * number("triangles"), "{report}");
    assert_eq!(report["near_tie"], false);

    let archive = std::fs::read(&out).unwrap();
    for name in ["triangle", "barycentric", "point", "confidence", "similarity"] {
        let entry = format!("{name}.npy");
        assert!(archive.windows(entry.len()).any(|bytes| bytes == entry.as_bytes()), "{entry}");
    }
}
