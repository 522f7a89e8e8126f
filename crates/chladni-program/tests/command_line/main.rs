//! The built program, run as a user would: on its own samples always, on real files where they are there.

#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

mod bare_machines;
mod refusals;

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// A cache of this test program's own.
fn cache() -> &'static Path {
    static CACHE: std::sync::LazyLock<tempfile::TempDir> =
        std::sync::LazyLock::new(|| tempfile::tempdir().unwrap());
    CACHE.path()
}

/// One run of the program, with a cache of its own so that no test sees another's work.
struct Run {
    output: Output,
}

impl Run {
    fn of(arguments: &[&str]) -> Self {
        let output = Command::new(env!("CARGO_BIN_EXE_chladni"))
            .args(arguments)
            .env("CHLADNI_CACHE", cache())
            .output()
            .expect("the program was built for this test");
        Self { output }
    }

    fn code(&self) -> i32 {
        self.output.status.code().unwrap_or(-1)
    }

    fn stdout(&self) -> String {
        String::from_utf8_lossy(&self.output.stdout).into_owned()
    }

    fn stderr(&self) -> String {
        String::from_utf8_lossy(&self.output.stderr).into_owned()
    }

    fn succeeded(self) -> Self {
        assert_eq!(self.code(), 0, "{}", self.stderr());
        self
    }

    fn json(&self) -> serde_json::Value {
        serde_json::from_str(&self.stdout()).expect("--json prints JSON")
    }

    /// Bad input ends with code 2 and exactly one line that names the file.
    fn refused(&self, name: &str) {
        assert_eq!(self.code(), 2, "{name}: {}", self.stderr());
        let errors: Vec<String> =
            self.stderr().lines().filter(|line| line.starts_with("chladni: ")).map(str::to_owned).collect();
        assert_eq!(errors.len(), 1, "{name}: {}", self.stderr());
        assert!(errors[0].contains(name), "{name}: {}", errors[0]);
        assert!(!self.stderr().contains("panicked"), "{name}: {}", self.stderr());
    }

    /// Either it works, perhaps with warnings, or it is refused in one line; it never panics.
    fn works_or_is_refused(&self, name: &str) {
        match self.code() {
            0 => assert!(!self.stderr().contains("panicked"), "{name}: {}", self.stderr()),
            _ => self.refused(name),
        }
    }
}

fn text(path: &Path) -> &str {
    path.to_str().expect("test paths are plain")
}

fn files_below(folder: &Path) -> Vec<PathBuf> {
    let mut files: Vec<PathBuf> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.is_file())
        .collect();
    files.sort();
    files
}

fn nothing_half_written(folder: &Path) {
    for path in files_below(folder) {
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        assert!(!name.starts_with(".chladni-"), "left behind: {name}");
    }
}

#[test]
fn info_counts_a_sample() {
    let json = Run::of(&["info", "sample:head", "--json"]).succeeded().json();
    assert!(json["vertices"].as_u64().unwrap() > 5_000);
    assert_eq!(json["components"], 1);
    assert_eq!(json["boundary_loops"], 0);
    assert_eq!(json["nonmanifold_edges"], 0);
    assert_eq!(json["genus"], 0);
}

#[test]
fn info_gives_the_reason_for_a_stance_in_doubt_as_text_and_as_json() {
    let json = Run::of(&["info", "sample:ring", "--json"]).succeeded().json();
    assert_eq!(json["stands"]["in_doubt"], true);
    let because = json["stands"]["because"].as_str().unwrap();
    let said = Run::of(&["info", "sample:ring"]).succeeded().stdout();
    assert!(said.contains(&format!("(because {because}, but in doubt)")), "{said}");
}

#[test]
fn a_project_of_one_harmonic_says_so_in_the_singular() {
    let folder = tempfile::tempdir().unwrap();
    let project = folder.path().join("p.chladni");
    Run::of(&["project", "new", "sample:bell", "-k", "1", "-o", text(&project)]).succeeded();
    let shown = Run::of(&["project", "show", text(&project)]).succeeded().stdout();
    assert!(shown.contains(", 1 harmonic of the "), "{shown}");
}

#[test]
fn a_caricature_with_mu_zero_is_the_shape_itself() {
    let folder = tempfile::tempdir().unwrap();
    let shape = folder.path().join("shape.obj");
    std::fs::write(&shape, OCTAHEDRON).unwrap();
    let out = folder.path().join("out.obj");
    Run::of(&[
        "caricature",
        text(&shape),
        "self:scale=0.5",
        "--mu",
        "0",
        "--harmonics",
        "4",
        "-o",
        text(&out),
    ])
    .succeeded();
    assert_eq!(vertex_lines(&shape), vertex_lines(&out));
    nothing_half_written(folder.path());
}

#[test]
fn a_caricature_of_the_sample_moves_it_and_keeps_its_connectivity() {
    let folder = tempfile::tempdir().unwrap();
    let (plain, wild) = (folder.path().join("plain.obj"), folder.path().join("wild.obj"));
    let common = ["--harmonics", "48", "--quiet"];
    for (mu, out) in [("0", &plain), ("-1.5", &wild)] {
        let mut arguments = vec!["caricature", "sample:head", "ellipsoid", "--mu", mu, "-o", text(out)];
        arguments.extend(common);
        Run::of(&arguments).succeeded();
    }
    let (plain, wild) = (vertex_lines(&plain), vertex_lines(&wild));
    assert_eq!(plain.len(), wild.len());
    let moved = plain.iter().zip(&wild).filter(|(a, b)| a != b).count();
    assert!(moved > plain.len() / 2, "{moved} of {}", plain.len());
}

/// A sheet of 17 × 17 vertices whose every other column of triangles is a billionth wide, which the plain cotangents of
/// the papers do not bear.
fn slivers() -> String {
    let n = 16;
    let vertex = |i: usize, j: usize| {
        let (x, y) = (i as f64 / 16.0, j as f64 / 16.0);
        let beside = if i.is_multiple_of(2) { x } else { x - 1.0 / 16.0 + 1e-9 };
        format!("v {beside} {y} {}\n", 0.3 * (5.0 * x).sin() * y)
    };
    let square = |i: usize, j: usize| {
        let [a, b, c, d] = [(i, j), (i + 1, j), (i, j + 1), (i + 1, j + 1)].map(|(i, j)| i * (n + 1) + j + 1);
        format!("f {a} {b} {c}\nf {c} {b} {d}\n")
    };
    let vertices = (0..=n).flat_map(|i| (0..=n).map(move |j| vertex(i, j)));
    let squares = (0..n).flat_map(|i| (0..n).map(move |j| square(i, j)));
    vertices.chain(squares).collect()
}

#[test]
fn imprecise_harmonics_are_told_by_every_command_that_uses_them() {
    let folder = tempfile::tempdir().unwrap();
    let (shape, out) = (folder.path().join("slivers.obj"), folder.path().join("out.obj"));
    std::fs::write(&shape, slivers()).unwrap();
    let shape = text(&shape);
    let caricature =
        ["caricature", shape, "self:scale=0.5", "--harmonics", "20", "--paper", "--quiet", "-o", text(&out)];
    for arguments in [
        &caricature[..],
        &["basis", shape, "-k", "20", "--paper"],
        &["symmetry", shape, "--harmonics", "20", "--paper"],
    ] {
        let run = Run::of(arguments).succeeded();
        assert!(run.stderr().contains("solve their equation to"), "{}: {}", arguments[0], run.stderr());
    }
}

#[test]
fn harmonics_are_exported_for_numpy_and_cached() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("basis.npz");
    let json =
        Run::of(&["basis", "sample:octopus", "-k", "24", "-o", text(&out), "--json"]).succeeded().json();
    assert_eq!(json["harmonics"], 24);
    assert_eq!(json["inertia_counts_match"], true);
    assert!(json["max_relative_residual"].as_f64().unwrap() < 1e-8);
    assert_eq!(&std::fs::read(&out).unwrap()[..2], b"PK", "an .npz is a zip archive");
    let again =
        Run::of(&["basis", "sample:octopus", "-k", "24", "-o", text(&out), "--json"]).succeeded().json();
    assert_eq!(again["cached"], true);
    assert!(again["cover"].is_null(), "no Laplacian was made");
    Run::of(&["basis", "sample:octopus", "-k", "24", "--threads", "1025"]).refused("at most 1024");
    assert_eq!(json["cover"]["sheets"], 1, "the octopus is closed");
}

#[test]
fn a_small_mesh_gets_all_the_harmonics_it_has_unless_more_are_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let shape = folder.path().join("small.obj");
    std::fs::write(&shape, OCTAHEDRON).unwrap();
    let run = Run::of(&["basis", text(&shape), "--json"]).succeeded();
    assert_eq!(run.json()["harmonics"], 6);
    let said = run.stderr();
    assert!(said.contains("small.obj: has 6 vertices; 6 harmonics instead of 256"), "{said}");
    Run::of(&["basis", text(&shape), "-k", "7"]).refused("small.obj");
}

#[test]
fn harmonics_that_do_not_fit_in_memory_are_kept_on_disk_and_written_in_parts() {
    let folder = tempfile::tempdir().unwrap();
    let [whole, parts] = [folder.path().join("whole"), folder.path().join("parts")];
    let slash = |path: &Path| format!("{}/", text(path));
    let solve = |out: &str, more: &[&str]| {
        let usual = ["basis", "sample:octopus", "-k", "200", "--no-cache", "--threads", "2", "-o", out];
        Run::of(&[&usual[..], more].concat())
    };
    solve(&slash(&whole), &[]).succeeded();
    let short = ["--memory", "0.1", "--scratch", text(folder.path())];
    let said = solve(&slash(&parts), &short).succeeded().stderr();
    assert!(said.contains("memory is short") && said.contains(text(folder.path())), "{said}");
    for name in ["eigenvalues", "eigenvectors", "mass", "operator_vertex"] {
        let read = |folder: &Path| std::fs::read(folder.join(format!("{name}.npy"))).unwrap();
        assert!(read(&whole) == read(&parts), "{name}");
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 2, "nothing is left in the scratch folder");
    let refused = solve(&slash(&parts), &["--memory", "0.01"]);
    assert_eq!(refused.code(), 2);
    let said = refused.stderr();
    assert!(said.contains("it takes at least about ") && said.contains("10.0 MB may be used"), "{said}");
    assert_eq!(solve(&slash(&parts), &["--memory", "-1"]).code(), 2);
    let missing = folder.path().join("none");
    assert_eq!(solve(&slash(&parts), &["--memory", "0.1", "--scratch", text(&missing)]).code(), 2);
    assert_eq!(solve(&slash(&missing.join("deeper")), &[]).code(), 2);
}

#[test]
fn a_shape_dances_into_frames_and_wav() {
    let folder = tempfile::tempdir().unwrap();
    let frames = folder.path().join("frames");
    Run::of(&[
        "dance",
        "sample:octopus",
        "sample:tune",
        "--frames",
        text(&frames),
        "--size",
        "96x96",
        "--fps",
        "10",
        "--duration",
        "0.6",
        "-k",
        "16",
    ])
    .succeeded();
    let files = files_below(&frames);
    let count =
        |extension: &str| files.iter().filter(|f| f.extension().is_some_and(|e| e == extension)).count();
    assert_eq!(count("png"), 6);
    assert_eq!(count("wav"), 1);
}

#[test]
fn frames_of_an_earlier_film_are_not_passed_over() {
    let folder = tempfile::tempdir().unwrap();
    let film = |secs: &str| {
        let dance = ["dance", "sample:plate", "sample:tune", "-k", "16", "--size", "32x24", "--fps", "10"];
        Run::of(&[&dance[..], &["--duration", secs, "--frames", text(folder.path())]].concat()).succeeded()
    };
    assert!(!film("0.5").stderr().contains("earlier film"));
    assert!(film("0.2").stderr().contains("frame-00002.png and those after it are of an earlier film"));
}

#[cfg(unix)]
#[test]
fn a_film_that_is_asked_to_end_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let film = folder.path().join("film.gif");
    let mut child = Command::new(env!("CARGO_BIN_EXE_chladni"))
        .args(["dance", "sample:octopus", "sample:tune", "-k", "16", "--size", "640x480", "-o", text(&film)])
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    // As soon as there is something to leave.
    while std::fs::read_dir(folder.path()).unwrap().next().is_none() {
        assert!(child.try_wait().unwrap().is_none(), "the film was never begun");
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    // The shell has a kill of its own, on machines without that program, too.
    let end = format!("kill -TERM {}", child.id());
    assert!(Command::new("sh").args(["-c", &end]).status().unwrap().success());
    let output = child.wait_with_output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(said.contains("cancelled") || film.exists(), "{said}");
    let left = files_below(folder.path());
    assert!(left.iter().all(|path| *path == film), "{left:?}");
}

#[test]
fn a_reader_who_has_had_enough_stops_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("b.npz");
    let mut child = Command::new(env!("CARGO_BIN_EXE_chladni"))
        .args(["basis", "sample:octopus", "-k", "4", "--no-cache", "-o", text(&out)])
        .stdout(std::process::Stdio::piped())
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(out.exists());
}

#[test]
fn a_part_of_a_spectrum_is_that_of_the_whole_song() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("softer.wav");
    // After three seconds 20 dB softer.
    let mut song = chladni_sound::sample_tune();
    let loud = 3 * song.rate_hz as usize;
    for side in [&mut song.left, &mut song.right] {
        side.iter_mut().skip(loud).for_each(|sample| *sample *= 0.1);
    }
    chladni_sound::write_wav(&path, &song, chladni_sound::WavSample::Float32).unwrap();
    let frames = |more: &[&str]| {
        let spectrum = ["--quiet", "spectrum", text(&path), "--json", "--bands", "24"];
        let json = Run::of(&[&spectrum[..], more].concat()).succeeded().json();
        json["frames"].as_array().unwrap().clone()
    };
    let (whole, part) = (frames(&[]), frames(&["--start", "16", "--duration", "2"]));
    assert_eq!(part.len(), 40);
    let mut loudest = 0.0f64;
    // Twenty frames a second.
    for (whole, part) in whole[320..].iter().zip(&part) {
        assert_eq!(whole["time_secs"], part["time_secs"]);
        for side in ["mid", "side"] {
            let numbers = |frame: &serde_json::Value| -> Vec<f64> {
                frame[side].as_array().unwrap().iter().map(|level| level.as_f64().unwrap()).collect()
            };
            for (whole, part) in numbers(whole).into_iter().zip(numbers(part)) {
                assert!((whole - part).abs() < 1e-3, "{whole} and {part}");
                loudest = loudest.max(part);
            }
        }
    }
    assert!(loudest > 0.1, "{loudest}");
    // However many are shown.
    let seldom = frames(&["--start", "16", "--duration", "2", "--fps", "5"]);
    assert!(seldom.iter().eq(part.iter().step_by(4)));
}

fn vertex_lines(path: &Path) -> Vec<String> {
    std::fs::read_to_string(path)
        .unwrap()
        .lines()
        .filter(|line| line.starts_with("v "))
        .map(str::to_owned)
        .collect()
}

const OCTAHEDRON: &str = "v 1 0 0\nv -1 0 0\nv 0 1.25 0\nv 0 -1 0\nv 0 0 1.1\nv 0 0 -1\n\
    f 1 3 5\nf 3 2 5\nf 2 4 5\nf 4 1 5\nf 3 1 6\nf 2 3 6\nf 4 2 6\nf 1 4 6\n";

#[test]
fn the_page_of_controls_is_the_one_in_the_documentation() {
    let printed = Run::of(&["controls"]).succeeded().stdout();
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/controls.md");
    assert_eq!(std::fs::read_to_string(page).unwrap(), printed, "chladni controls > docs/controls.md");
}
