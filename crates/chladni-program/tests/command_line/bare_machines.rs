//! Machines that lack a graphics driver, a desktop, a display, MPI or memory.

use std::process::Command;

use super::{OCTAHEDRON, Run, cache, text};

/// Where no Vulkan driver is, the processor draws, and `--draw gpu` says what is missing.
#[cfg(target_os = "linux")]
#[test]
fn pictures_and_films_need_no_driver() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    std::fs::write(at("mesh.obj"), OCTAHEDRON).unwrap();
    let run = |line: &str| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_chladni"));
        for variable in ["VK_DRIVER_FILES", "VK_ICD_FILENAMES"] {
            command.env(variable, "/nonexistent");
        }
        command
            .env("CHLADNI_CACHE", cache())
            .current_dir(folder.path())
            .args(line.split(' '))
            .output()
            .unwrap()
    };
    let picture = |name: &str| chladni_view::Picture::decode(&std::fs::read(at(name)).unwrap()).unwrap();
    for line in [
        "caricature mesh.obj mesh.obj -k 4 --mu 0.5 -o out.obj --render out.png --size 200x100",
        "caricature mesh.obj mesh.obj -k 4 --mu 0.5 -o out.obj --render sheet.png --size 200x100 --show before,region",
        "match mesh.obj --method ellipsoid --render match.png",
        "symmetry sample:head -k 8 --render symmetry.png",
        "dance sample:octopus sample:tune -k 16 --frames frames --size 96x96 --fps 10 --duration 0.3 --gallery 6",
        "basis sample:octopus -k 4 -o basis.npz",
    ] {
        let output = run(line);
        assert!(output.status.success(), "{line}: {}", String::from_utf8_lossy(&output.stderr));
    }
    for name in ["out.png", "sheet.png", "match.png", "symmetry.png", "frames/frame-00002.png"] {
        let picture = picture(name);
        let first = picture.pixel(0, 0);
        let drawn = (0..picture.width).filter(|x| picture.pixel(*x, picture.height / 2) != first).count();
        assert!(drawn > 10, "{name} is empty");
    }
    let refused = run("match mesh.obj --method ellipsoid --render no.png --draw gpu");
    let message = String::from_utf8_lossy(&refused.stderr).into_owned();
    assert!(!refused.status.success() && message.contains("no graphics adapter"), "{message}");
    assert!(!at("no.png").exists());
    let refused =
        run("dance sample:octopus sample:tune --frames no --draw cpu --synthesis gpu --duration 0.1 -k 16");
    let message = String::from_utf8_lossy(&refused.stderr).into_owned();
    assert!(refused.status.code() == Some(2) && message.contains("--synthesis gpu"), "{message}");
}

#[cfg(target_os = "linux")]
#[test]
fn a_picture_made_without_a_session_comes_with_no_complaint() {
    let folder = tempfile::tempdir().unwrap();
    let (mesh, picture) = (folder.path().join("mesh.obj"), folder.path().join("picture.png"));
    std::fs::write(&mesh, OCTAHEDRON).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_chladni"));
    command.env_remove("XDG_RUNTIME_DIR").env_remove("WAYLAND_DISPLAY");
    command.args(["match", text(&mesh), "--method", "ellipsoid", "--quiet", "--render", text(&picture)]);
    let output = command.output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    // Our own warning, that an octahedron has no up, may be there.
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(message.lines().all(|line| line.starts_with("warning: ")), "{message}");
    assert!(picture.exists());
}

#[cfg(target_os = "linux")]
#[test]
fn without_a_display_one_line_says_so() {
    let mut command = Command::new(env!("CARGO_BIN_EXE_chladni"));
    for name in ["DISPLAY", "WAYLAND_DISPLAY", "WAYLAND_SOCKET"] {
        command.env_remove(name);
    }
    let output = command.output().unwrap();
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1));
    assert!(message.lines().count() == 1 && message.contains("there is no display"), "{message}");
}

#[test]
fn without_mpi_one_line_says_what_to_install() {
    let output = Command::new(env!("CARGO_BIN_EXE_chladni"))
        .args([
            "--quiet",
            "basis",
            "sample:ring",
            "-k",
            "10",
            "--engine",
            "slepc",
            "--ranks",
            "1",
            "--no-cache",
        ])
        .env("PATH", "")
        .output()
        .unwrap();
    Run { output }.refused("scripts/setup --mpi");
}

#[test]
fn without_ffmpeg_each_command_says_what_it_makes_without_it() {
    let folder = tempfile::tempdir().unwrap();
    let (film, mesh) = (folder.path().join("film.mp4"), folder.path().join("mesh.obj"));
    std::fs::write(&mesh, OCTAHEDRON).unwrap();
    for (arguments, others) in [
        (&["dance", "sample:octopus", "sample:tune", "-o"][..], Some(".glb")),
        (&["caricature", text(&mesh), "ellipsoid", "--turntable"], Some(".gif")),
        (&["open", "sample:octopus", "-o"], None),
    ] {
        let mut command = Command::new(env!("CARGO_BIN_EXE_chladni"));
        let output = command.args(arguments).arg(&film).env("PATH", "").output().unwrap();
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(1), "{message}");
        assert!(message.contains("film.mp4: ffmpeg is not on the PATH: install it"), "{message}");
        assert_eq!(message.contains("need none"), others.is_some(), "{message}");
        assert!(others.is_none_or(|others| message.contains(others)), "{message}");
    }
}

/// The shell's own limit is noticed before it ends the program.
#[cfg(target_os = "linux")]
#[test]
fn harmonics_that_would_pass_the_limit_of_the_shell_are_refused() {
    use std::fmt::Write;
    let folder = tempfile::tempdir().unwrap();
    let mesh = folder.path().join("sheet.obj");
    // 160,000 vertices, which take 866 MB.
    let side = 400;
    let mut sheet = String::new();
    for at in 0..side * side {
        writeln!(sheet, "v {} {} 0", at % side, at / side).unwrap();
    }
    for at in (1..side * (side - 1)).filter(|at| at % side != 0) {
        writeln!(sheet, "f {} {} {} {}", at, at + 1, at + side + 1, at + side).unwrap();
    }
    std::fs::write(&mesh, sheet).unwrap();
    let output = Command::new("sh")
        .args(["-c", "ulimit -v 614400; exec \"$@\"", "sh", env!("CARGO_BIN_EXE_chladni"), "basis"])
        .args([text(&mesh), "-k", "64", "--no-cache", "--threads", "1"])
        .env("RAYON_NUM_THREADS", "1")
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(said.contains("it takes at least about ") && said.contains("may be used"), "{said}");
}

/// `scripts/rust` takes the first Rust that is as new as Cargo.toml asks for: a distribution's, else rustup's own.
#[cfg(target_os = "linux")]
#[test]
fn the_scripts_take_a_rust_that_is_new_enough() {
    use std::os::unix::fs::PermissionsExt;
    let folder = tempfile::tempdir().unwrap();
    let (usual, home) = (folder.path().join("usual"), folder.path().join("home"));
    let put = |bin: &std::path::Path, version: &str| {
        std::fs::create_dir_all(bin).unwrap();
        let cargo = bin.join("cargo");
        std::fs::write(&cargo, format!("#!/bin/sh\necho 'cargo {version} (abc 2025-01-01)'\n")).unwrap();
        std::fs::set_permissions(&cargo, std::fs::Permissions::from_mode(0o755)).unwrap();
    };
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scripts/rust");
    let taken = || {
        let output = Command::new("bash")
            .args(["-euo", "pipefail", "-c", ". \"$0\"; new_rust && command -v cargo", script])
            .env_clear()
            .env("PATH", format!("{}:/usr/bin:/bin", usual.display()))
            .env("HOME", &home)
            .output()
            .unwrap();
        String::from_utf8(output.stdout).unwrap().trim().to_owned()
    };
    put(&usual, "1.85.0");
    assert_eq!(taken(), "");
    let own = home.join(".cargo/bin");
    put(&own, env!("CARGO_PKG_RUST_VERSION"));
    assert_eq!(taken(), text(&own.join("cargo")));
    for newer in ["1.100.0-nightly", "2.0.0"] {
        put(&usual, newer);
        assert_eq!(taken(), text(&usual.join("cargo")), "{newer}");
    }
}
