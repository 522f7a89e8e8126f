//! `chladni dance` and `chladni symmetry` as a script runs them.
#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

#[path = "../archive/mod.rs"]
mod archive;
mod behind;
mod looks;
#[cfg(unix)]
mod odd_names;
mod own_colors;
mod shots;
mod shows;
mod strobing;

use std::path::Path;

use chladni_mesh::{load_mesh, samples, save_mesh};
use chladni_program::work::{Aside, film};
use chladni_sound::{Song, WavSample, write_wav};

use strobing::{ball, luminances, strobe, strobing_film};

fn run(arguments: &[&str]) -> u8 {
    chladni_program::cli::run(["chladni", "--quiet"].iter().chain(arguments))
}

fn array(path: &Path, name: &str) -> (Vec<u64>, Vec<f64>) {
    let archive::Array { shape, values } = archive::array(path, name).unwrap();
    (shape, values)
}

/// The warnings with which a film is made.
fn warnings_of(film: film::Film) -> Vec<String> {
    let task = chladni_task::Task::new();
    let aside = Aside::new(&task);
    film::make(film, &aside).map(drop).unwrap();
    aside.warnings().iter().map(ToString::to_string).collect()
}

#[test]
fn a_click_moves_the_shape_within_one_frame_and_repeats_bit_for_bit() {
    let folder = tempfile::tempdir().unwrap();
    let wav = folder.path().join("clicks.wav");
    let rate_hz = 44_100;
    let mut left = vec![0.0f32; 4 * rate_hz as usize];
    (1..4).for_each(|secs| left[secs * rate_hz as usize] = 0.9);
    write_wav(&wav, &Song { rate_hz, right: left.clone(), left }, WavSample::Int16).unwrap();
    let film = |name: &str| {
        let npz = folder.path().join(name);
        let arguments = ["dance", "sample:octopus", wav.to_str().unwrap(), "-k", "24", "--coefficients"];
        assert_eq!(run(&[&arguments[..], &[npz.to_str().unwrap()]].concat()), 0);
        npz
    };
    let npz = film("a.npz");
    let (shape, coefficients) = array(&npz, "coefficients");
    let (_, times_secs) = array(&npz, "times_secs");
    assert_eq!(shape, [120, 24, 3]);
    let moved: Vec<f64> = coefficients.chunks(72).map(|c| c.iter().map(|x| x * x).sum()).collect();
    for secs in 1..4 {
        let near = (0..120).filter(|&f| (times_secs[f] - f64::from(secs)).abs() < 0.4);
        let peak = near.max_by(|&a, &b| moved[a].total_cmp(&moved[b])).unwrap();
        assert!((times_secs[peak] - f64::from(secs)).abs() <= 1.0 / 30.0 + 1e-9, "{}", times_secs[peak]);
    }
    assert_eq!(coefficients, array(&film("b.npz"), "coefficients").1);
}

#[test]
fn a_dance_becomes_a_glb_with_its_sound_beside_it() {
    let folder = tempfile::tempdir().unwrap();
    let glb = folder.path().join("dance.glb");
    let dance = |more: &[&str]| {
        let out = glb.to_str().unwrap();
        let first = ["dance", "sample:octopus", "sample:tune", "-k", "24", "--duration", "1", "-o", out];
        run(&[&first[..], more].concat())
    };
    assert_eq!(dance(&["--gallery", "6"]), 2);
    assert_eq!(dance(&["--targets", "0"]), 2);
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    assert_eq!(dance(&["--targets", "5"]), 0);
    let octopus = samples::sample("octopus").unwrap();
    let read = load_mesh(&glb).unwrap().mesh;
    assert_eq!(read.triangles, octopus.triangles);
    let text = String::from_utf8_lossy(&std::fs::read(&glb).unwrap()).into_owned();
    assert_eq!(text.matches("harmonic ").count(), 5);
    assert!(text.contains(r#""offset"]"#));
    let sound = Song::open(&folder.path().join("dance.wav")).unwrap();
    assert!((sound.duration_secs() - 1.0).abs() < 0.01, "{}", sound.duration_secs());
    // An animation without its sound was not finished.
    std::fs::remove_file(folder.path().join("dance.wav")).unwrap();
    assert_eq!(dance(&["--targets", "5", "--resume"]), 0);
    assert!(folder.path().join("dance.wav").is_file());
    // The sound would replace the song.
    let song = folder.path().join("dance.wav");
    let before = std::fs::read(&song).unwrap();
    let [song_name, out] = [&song, &glb].map(|path| path.to_str().unwrap());
    assert_eq!(run(&["dance", "sample:octopus", song_name, "-k", "24", "-o", out]), 2);
    assert!(std::fs::read(&song).unwrap() == before);
}

#[test]
fn no_file_of_a_film_replaces_one_that_it_reads() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    save_mesh(&samples::sample("octopus").unwrap(), &path("hero.glb")).unwrap();
    std::fs::create_dir(path("film")).unwrap();
    write_wav(&path("film/sound.wav"), &chladni_sound::sample_tune(), WavSample::Int16).unwrap();
    for picture in ["wall.png", "film/frame-00000.png"] {
        image::RgbaImage::new(4, 4).save(path(picture)).unwrap();
    }
    let project = chladni_caricature::Project::new(chladni_mesh::ShapeSource::File(path("hero.glb")), 24);
    project.save(&path("hero.chladni")).unwrap();
    let before = bytes_below(folder.path());
    let refused = |body: &str, song: &str, more: &[&str]| {
        let named =
            |name: &str| if name.contains(':') { name.to_owned() } else { path(name).display().to_string() };
        let more =
            more.iter().map(|more| if more.starts_with('-') { (*more).to_owned() } else { named(more) });
        let arguments = ["dance".to_owned(), named(body), named(song), "-k".into(), "24".into()];
        let arguments: Vec<String> = arguments.into_iter().chain(more).collect();
        assert_eq!(run(&arguments.iter().map(String::as_str).collect::<Vec<_>>()), 2, "{arguments:?}");
        assert!(bytes_below(folder.path()) == before, "{arguments:?}");
    };
    let (octopus, tune) = ("sample:octopus", "sample:tune");
    refused("hero.glb", tune, &["-o", "hero.glb"]);
    refused("hero.chladni", tune, &["-o", "hero.glb"]);
    refused(octopus, "film/sound.wav", &["--frames", "film"]);
    refused(octopus, "film/sound.wav", &["--coefficients", "film/sound.wav"]);
    refused(octopus, tune, &["--picture", "wall.png", "-o", "wall.png"]);
    refused(octopus, tune, &["--picture", "film/frame-00000.png", "--frames", "film"]);
    refused(octopus, tune, &["-o", "twice.glb", "--coefficients", "./twice.glb"]);
    // Nor is there any work for what cannot be written.
    refused(octopus, tune, &["--frames", "wall.png"]);
    refused(octopus, tune, &["--frames", "missing/film"]);
    refused(octopus, tune, &["-o", "film.gif", "--fps=60"]);
}

/// Every file below a folder, with its bytes.
fn bytes_below(folder: &Path) -> std::collections::BTreeMap<std::path::PathBuf, Vec<u8>> {
    let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    entries
        .flat_map(|path| match path.is_dir() {
            true => bytes_below(&path),
            false => [(path.clone(), std::fs::read(&path).unwrap())].into(),
        })
        .collect()
}

#[test]
fn frames_on_a_pipe_are_those_of_the_film_and_ffmpeg_reads_them() {
    use std::process::{Command, Stdio};
    if !chladni_view::ffmpeg_is_there() {
        return println!("skipped: no ffmpeg");
    }
    let folder = tempfile::tempdir().unwrap();
    let dance = ["--quiet", "dance", "sample:octopus", "sample:tune", "-k", "24", "--duration", "0.5"];
    let film = ["--start", "6", "--fps", "24", "--size", "96x64", "--draw", "cpu"];
    let frames = folder.path().join("film");
    let arguments = [&dance[1..], &film, &["--frames", frames.to_str().unwrap()]].concat();
    assert_eq!(run(&arguments), 0);
    let pixels = |path: &Path| chladni_view::Picture::decode(&std::fs::read(path).unwrap()).unwrap().rgba;
    let raw = ["-f", "rawvideo", "-pixel_format", "rgba", "-video_size", "96x64", "-framerate", "24"];
    for (format, input, tolerance) in [("rgba", &raw[..], 0), ("y4m", &[][..], 4)] {
        let program = env!("CARGO_BIN_EXE_chladni");
        let mut dancing = Command::new(program)
            .args(dance)
            .args(film)
            .args(["-o", "-", "--format", format])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let read = folder.path().join(format);
        std::fs::create_dir(&read).unwrap();
        // As docs/stage.md has it.
        let colors = ["-vf", "setparams=colorspace=bt709", "-pix_fmt", "rgba"];
        let ended = Command::new("ffmpeg")
            .args(["-nostdin", "-loglevel", "error"])
            .args(input)
            .args(["-i", "pipe:0"])
            .args(if format == "y4m" { &colors[..] } else { &[] })
            .arg(read.join("%d.png"))
            .stdin(dancing.stdout.take().unwrap())
            .status()
            .unwrap();
        assert!(ended.success() && dancing.wait().unwrap().success(), "{format}");
        assert_eq!(std::fs::read_dir(&read).unwrap().count(), 12, "{format}");
        for frame in 0..12 {
            let drawn = pixels(&frames.join(format!("frame-{frame:05}.png")));
            let seen = pixels(&read.join(format!("{}.png", frame + 1)));
            let off = drawn.iter().zip(&seen).map(|(a, b)| a.abs_diff(*b)).max().unwrap();
            assert!(drawn.len() == seen.len() && off <= tolerance, "{format}, frame {frame}: {off}");
        }
    }
    assert_eq!(run(&[&dance[1..], &["-o", "-", "--json"]].concat()), 2);
}

#[test]
fn pieces_of_a_film_are_the_film_bit_for_bit() {
    let folder = tempfile::tempdir().unwrap();
    let [mesh, wav] = ["ball.obj", "tone.wav"].map(|name| folder.path().join(name));
    ball(&mesh);
    let tone = |n: i32| {
        let t = f64::from(n) / 44_100.0;
        ((0.4 + 0.3 * (5.0 * t).sin()) * (1400.0 * t).sin()) as f32
    };
    let left: Vec<f32> = (0..4 * 44_100).map(tone).collect();
    write_wav(&wav, &Song { rate_hz: 44_100, right: left.clone(), left }, WavSample::Int16).unwrap();
    // The last piece begins after the two seconds that are drawn before it.
    let film = [mesh.to_str().unwrap(), wav.to_str().unwrap(), "-k", "24", "--fps", "12"];
    let drawn = ["--size", "64x48", "--draw", "cpu"];
    let frames = |name: &str, more: &[&str]| {
        let out = folder.path().join(name);
        let arguments = [&["dance"], &film[..], &drawn, &["--frames", out.to_str().unwrap()], more].concat();
        assert_eq!(run(&arguments), 0);
        out
    };
    let read =
        |folder: &Path, frame: usize| std::fs::read(folder.join(format!("frame-{frame:05}.png"))).unwrap();
    let whole = frames("whole", &[]);
    for piece in ["3/3", "0..16", "2/3"] {
        frames("pieces", &["--piece", piece]);
    }
    let pieces = folder.path().join("pieces");
    assert_eq!(std::fs::read_dir(&pieces).unwrap().count(), 48 + 1);
    for frame in 0..48 {
        assert!(read(&whole, frame) == read(&pieces, frame), "frame {frame}");
    }
    assert!(read(&whole, 40) != read(&whole, 41), "nothing moves");
    assert!(
        std::fs::read(whole.join("sound.wav")).unwrap() == std::fs::read(pieces.join("sound.wav")).unwrap()
    );
    // Existing frames stay, missing ones are made.
    std::fs::write(pieces.join("frame-00033.png"), "kept").unwrap();
    std::fs::remove_file(pieces.join("frame-00034.png")).unwrap();
    frames("pieces", &["--piece", "3/3", "--resume"]);
    assert_eq!(read(&pieces, 33), b"kept");
    assert!(read(&pieces, 34) == read(&whole, 34) && read(&pieces, 47) == read(&whole, 47));
    frames("pieces", &["--piece", "3/3", "--resume"]);
    // Trails are of the pictures before, whether flashes are limited or not.
    let neon = ["--look", "neon", "--allow-flashes"];
    let whole = frames("neon", &neon);
    for piece in ["3/3", "2/3"] {
        frames("neon-pieces", &[&neon[..], &["--piece", piece]].concat());
    }
    for frame in 16..48 {
        assert!(read(&whole, frame) == read(&folder.path().join("neon-pieces"), frame), "frame {frame}");
    }
    // The same on a pipe, where grains of sand depend on all that was before.
    let raw = |more: &[&str]| {
        let arguments = [&["--quiet", "dance"], &film[..], &drawn, &["--sand", "-o", "-"], more].concat();
        let output =
            std::process::Command::new(env!("CARGO_BIN_EXE_chladni")).args(arguments).output().unwrap();
        assert!(output.status.success());
        output.stdout
    };
    let joined = [raw(&["--piece", "0..30"]), raw(&["--piece", "30..48"])].concat();
    assert!(joined.len() == 48 * 64 * 48 * 4 && joined == raw(&[]));
}

#[test]
fn a_report_is_about_the_frames_that_were_made() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let report = |more: &[&str]| -> serde_json::Value {
        let film = ["--quiet", "dance", "sample:octopus", "sample:tune", "-k", "16", "--duration", "1"];
        let drawn = ["--fps", "10", "--size", "64x48", "--draw", "cpu", "--json"];
        let arguments = [&film[..], &drawn, more].concat();
        let output =
            std::process::Command::new(env!("CARGO_BIN_EXE_chladni")).args(arguments).output().unwrap();
        assert!(output.status.success(), "{output:?}");
        serde_json::from_slice(&output.stdout).unwrap()
    };
    let part = report(&["--frames", &path("frames"), "--piece", "0..3"]);
    assert_eq!((part["frames"].as_u64(), part["film_secs"].as_f64()), (Some(3), Some(0.3)));
    // A film that is there stays, which is reported.
    std::fs::write(path("film.gif"), "kept").unwrap();
    let none = report(&["-o", &path("film.gif"), "--resume"]);
    assert_eq!((none["frames"].as_u64(), none["times_real_time"].as_f64()), (Some(0), Some(0.0)));
    assert_eq!(std::fs::read(path("film.gif")).unwrap(), b"kept");
}

#[test]
fn frames_that_are_all_there_are_not_said_to_be_written() {
    let folder = tempfile::tempdir().unwrap();
    let frames = folder.path().join("frames");
    let made = || {
        let film = ["--quiet", "dance", "sample:octopus", "sample:tune", "-k", "16", "--duration", "0.2"];
        let drawn = ["--fps", "5", "--size", "64x48", "--draw", "cpu", "--resume", "--frames"];
        let output = std::process::Command::new(env!("CARGO_BIN_EXE_chladni"))
            .args([&film[..], &drawn].concat())
            .arg(&frames)
            .output()
            .unwrap();
        [output.stdout, output.stderr].map(|said| String::from_utf8(said).unwrap())
    };
    let [wrote, said] = made();
    assert!(wrote.starts_with("wrote ") && said.contains("1 frame in"), "{wrote}{said}");
    let [wrote, said] = made();
    assert!(wrote.is_empty() && said.contains("frames is there already"), "{wrote}{said}");
}

#[test]
fn a_folder_of_pictures_may_have_any_name() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["2024.05.01", "take.png", "take.mp4"] {
        let frames = folder.path().join(name);
        let film = ["dance", "sample:octopus", "sample:tune", "-k", "16", "--duration", "0.2", "--fps", "10"];
        let drawn = ["--size", "64x48", "--draw", "cpu", "--frames", frames.to_str().unwrap()];
        assert_eq!(run(&[&film[..], &drawn].concat()), 0, "{name}");
        let names = ["frame-00000.png", "frame-00001.png", "sound.wav"];
        assert!(bytes_below(&frames).keys().eq(&names.map(|name| frames.join(name))), "{name}");
    }
}

#[test]
fn a_gallery_is_no_animation_which_is_said_before_any_work() {
    let folder = tempfile::tempdir().unwrap();
    let output = film::Output::to(folder.path().join("film.glb"));
    let gallery = film::Beginning { gallery: Some(6), ..film::Beginning::default() };
    let film = film::Film::new("nowhere.obj".into(), "sample:tune".into(), gallery, output);
    let why = film::make(film, &Aside::new(&chladni_task::Task::new())).map(drop).unwrap_err().to_string();
    assert!(why.contains("one dance"), "{why}");
}

#[test]
fn an_animation_takes_looks_that_feel_speed() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("film.glb");
    let look = chladni_music::Action::SetLook { look: "spark".into() };
    let beginning = film::Beginning { changes: vec![look], ..film::Beginning::default() };
    let output = film::Output::to(path.clone());
    let mut film = film::Film::new("sample:octopus".into(), "sample:tune".into(), beginning, output);
    (film.harmonics, film.duration_secs) = (Some(24), Some(0.5));
    film::make(film, &Aside::new(&chladni_task::Task::new())).map(drop).unwrap();
    assert!(path.exists());
}

#[test]
fn a_dance_of_a_gltf_file_says_what_its_glb_lacks() {
    let folder = tempfile::tempdir().unwrap();
    let hero = folder.path().join("hero.glb");
    save_mesh(&samples::sample("octopus").unwrap(), &hero).unwrap();
    let output = film::Output::to(folder.path().join("film.glb"));
    let body = hero.display().to_string();
    let mut film = film::Film::new(body, "sample:tune".into(), film::Beginning::default(), output);
    (film.harmonics, film.duration_secs) = (Some(24), Some(0.5));
    let warnings = warnings_of(film);
    assert!(warnings.iter().any(|warning| warning.contains("are left out of the GLB")), "{warnings:?}");
}

#[test]
fn bad_input_is_refused_with_code_2() {
    let folder = tempfile::tempdir().unwrap();
    let gif = folder.path().join("x.gif");
    let gif = gif.to_str().unwrap();
    for arguments in [
        &["dance", "nowhere.obj", "sample:tune", "-o", gif][..],
        &["dance", "sample:octopus", "nowhere.ogg", "-o", gif],
        &["dance", "sample:octopus", "sample:tune", "-o", gif, "--preset", "nowhere.toml"],
        &["dance", "sample:octopus", "sample:tune", "-o", "x.avi"],
        &["dance", "sample:octopus", "sample:tune"],
        &["dance", "sample:octopus", "sample:tune", "-o", gif, "--piece", "1/2"],
        &["dance", "sample:octopus", "sample:tune", "-o", "x.mp4", "--piece", "3/2"],
        &[
            "dance",
            "sample:octopus",
            "sample:tune",
            "-k",
            "8",
            "--duration",
            "1",
            "-o",
            "-",
            "--piece",
            "20..31",
        ],
        &["dance", "sample:octopus", "sample:tune", "-o", gif, "--start", "-1"],
        &["symmetry", "nowhere.obj"],
    ] {
        assert_eq!(run(arguments), 2, "{arguments:?}");
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[test]
fn the_same_seed_song_and_actions_give_the_same_frames() {
    let folder = tempfile::tempdir().unwrap();
    let frames = |name: &str| {
        let out = strobing_film(folder.path(), name, &["--duration", "1"]);
        let mut files: Vec<_> = std::fs::read_dir(out).unwrap().map(|entry| entry.unwrap().path()).collect();
        files.sort();
        files.iter().map(|path| std::fs::read(path).unwrap()).collect::<Vec<_>>()
    };
    let first = frames("first");
    assert!(first.len() > 30 && first[3] != first[9]);
    assert!(first == frames("second"), "frames differ between two runs on one device");
}

#[test]
fn the_layers_of_a_caricature_dance_along() {
    let folder = tempfile::tempdir().unwrap();
    let [mesh, project, wav] =
        ["ball.obj", "wild.chladni", "strobe.wav"].map(|name| folder.path().join(name));
    ball(&mesh);
    strobe(&wav);
    let [mesh, path, wav] = [&mesh, &project, &wav].map(|path| path.to_str().unwrap());
    assert_eq!(run(&["project", "new", mesh, "-o", path, "--harmonics", "24"]), 0);
    assert_eq!(run(&["project", "add-layer", path, "--template", "self:scale=0.5", "--mu", "-2"]), 0);
    // Without gain only the voice is left: the ball grows with the bass.
    let film = |name: &str, mesh: &str| {
        let out = folder.path().join(name);
        let fixed =
            ["--gain", "0", "-k", "24", "--size", "64x64", "--duration", "1", "--background", "white"];
        let frames = ["dance", mesh, wav, "--frames", out.to_str().unwrap(), "--lights", "studio"];
        assert_eq!(run(&[&frames[..], &fixed].concat()), 0);
        luminances(&out)
    };
    let (still, moved) = (film("still", mesh), film("moved", path));
    let differences = still.iter().zip(&moved).map(|(a, b)| (a - b).abs());
    let largest = differences.fold(0.0, f32::max);
    assert!(largest > 0.03, "the layer changes the picture by {largest}");

    // The recording holds the mapping's own movement, with layers or without.
    for form in ["filter", "modal", "half-mask"] {
        let record = |name: &str, mesh: &str| {
            let out = folder.path().join(name);
            let rest = ["-k", "24", "--duration", "0.5", "--form", form, "--coefficients"];
            assert_eq!(run(&[&["dance", mesh, wav][..], &rest, &[out.to_str().unwrap()]].concat()), 0);
            out
        };
        let (plain, voiced) = (record("plain.npz", mesh), record("voiced.npz", path));
        assert_eq!(array(&plain, "coefficients"), array(&voiced, "coefficients"));
        let right = |path: &Path| archive::array(path, "coefficients_right").is_some();
        assert_eq!((right(&plain), right(&voiced)), (form == "half-mask", form == "half-mask"));
    }
}

/// As in the window.
#[test]
fn a_project_dances_with_its_own_number_of_harmonics() {
    let folder = tempfile::tempdir().unwrap();
    let [mesh, project] = ["ball.obj", "ball.chladni"].map(|name| folder.path().join(name));
    ball(&mesh);
    let [mesh, project] = [&mesh, &project].map(|path| path.to_str().unwrap());
    assert_eq!(run(&["project", "new", mesh, "-o", project, "--harmonics", "12"]), 0);
    let record = |more: &[&str]| {
        let out = folder.path().join("dance.npz");
        let usual =
            ["dance", project, "sample:tune", "--duration", "0.2", "--coefficients", out.to_str().unwrap()];
        assert_eq!(run(&[&usual[..], more].concat()), 0);
        array(&out, "coefficients")
    };
    assert_eq!(record(&[]), record(&["-k", "12"]));
    assert_ne!(record(&[]), record(&["-k", "20"]));
}

/// A film drawn from the device's own buffers shows what one drawn from the processor's shows.
#[test]
fn films_deformed_on_cpu_and_gpu_agree() {
    let gpu = match chladni_view::Gpu::headless() {
        Err(chladni_view::ViewError::NoAdapter(_)) => return,
        gpu => gpu.unwrap(),
    };
    let device = gpu.device.adapter_info().name;
    let folder = tempfile::tempdir().unwrap();
    let film = |synthesis: &str| {
        let frames = folder.path().join(synthesis);
        let arguments = ["dance", "sample:octopus", "sample:tune", "-k", "32", "--size", "192x108"];
        let rest = [
            "--start",
            "6",
            "--duration",
            "0.2",
            "--gallery",
            "6",
            "--synthesis",
            synthesis,
            "--draw",
            "gpu",
        ];
        let out = ["--frames", frames.to_str().unwrap(), "--json"];
        let done = std::process::Command::new(env!("CARGO_BIN_EXE_chladni"))
            .args([&arguments[..], &rest[..], &out[..]].concat())
            .output()
            .unwrap();
        assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
        // The device that deformed: a GPU that gave up would be compared with the processor in vain.
        let report: serde_json::Value = serde_json::from_slice(&done.stdout).unwrap();
        let by = report["synthesis"].as_str().unwrap();
        assert_eq!(by.starts_with(&device), synthesis == "gpu", "{by}");
        (0..6).map(move |i| {
            let png = std::fs::read(frames.join(format!("frame-{i:05}.png"))).unwrap();
            chladni_view::Picture::decode(&png).unwrap()
        })
    };
    let mut first: Option<chladni_view::Picture> = None;
    for (cpu, gpu) in film("cpu").zip(film("gpu")) {
        let differ = cpu.rgba.iter().zip(&gpu.rgba).filter(|(a, b)| a.abs_diff(**b) > 8).count();
        assert!(differ < cpu.rgba.len() / 500, "{differ} channels differ");
        // They dance: the frames are not all the same.
        let moved = first.as_ref().is_none_or(|first| first.rgba != cpu.rgba);
        assert!(moved);
        first.get_or_insert(cpu);
    }
}

#[test]
fn knobs_switches_and_choices_are_set_by_their_names() {
    let folder = tempfile::tempdir().unwrap();
    let [mesh, wav] = ["ball.obj", "strobe.wav"].map(|name| folder.path().join(name));
    ball(&mesh);
    strobe(&wav);
    let [mesh, wav] = [&mesh, &wav].map(|path| path.to_str().unwrap());
    let moved = |name: &str, more: &[&str]| {
        let out = folder.path().join(name);
        let rest = ["-k", "24", "--duration", "0.5", "--coefficients", out.to_str().unwrap()];
        assert_eq!(run(&[&["dance", mesh, wav][..], &rest, more].concat()), 0);
        array(&out, "coefficients").1
    };
    let plain = moved("plain.npz", &["--form", "filter"]);
    assert!(plain.iter().any(|c| *c != 0.0));
    assert_eq!(plain, moved("named.npz", &["--set", "form=filter", "--set", "decay=0.2"]));
    assert_ne!(plain, moved("decay.npz", &["--form", "filter", "--set", "decay=0.9"]));
    let few = moved("few.npz", &["--form", "filter", "--set", "harmonics=4"]);
    assert!(few.chunks(3).enumerate().all(|(i, c)| i % 24 < 4 || c == [0.0; 3]));
    // One µ for all is heard by either name.
    let by_name = moved("by-name.npz", &["--form", "filter", "--set", "stereo-mu=1"]);
    assert_eq!(by_name, moved("mu.npz", &["--form", "filter", "--mu", "1"]));
    let own = ["--form", "filter", "--set", "own-mu=on", "--set", "stereo-mu=1"];
    assert_ne!(by_name, moved("own.npz", &own));
    for bad in ["volume=1", "decay", "form=7"] {
        let out = folder.path().join("bad.npz");
        let rest = ["--set", bad, "--coefficients", out.to_str().unwrap()];
        assert_eq!(run(&[&["dance", mesh, wav][..], &rest].concat()), 2, "{bad}");
    }
}

#[test]
fn a_film_that_is_cancelled_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let output = film::Output { width: 64, height: 64, ..film::Output::to(folder.path().join("film.gif")) };
    let show = chladni_music::Show::from_text("format_version = 1\nseed = 1\nsize = 6\n").unwrap();
    let song = ("sample:tune".to_owned(), chladni_music::BeatReading::default());
    let film = film::Film::of_show(show, "sample:octopus".into(), vec![song], output);
    let task = chladni_task::Task::new();
    task.cancel();
    assert!(film::make(film, &Aside::new(&task)).is_err_and(|error| error.is_cancelled()));
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[test]
fn a_gallery_is_written_as_presets_that_can_be_played() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let dance = |npz: &str, more: &[&str]| {
        let npz = path(npz);
        let words = [
            "dance",
            "sample:octopus",
            "sample:tune",
            "-k",
            "24",
            "--start",
            "2",
            "--duration",
            "0.2",
            "--coefficients",
        ];
        assert_eq!(run(&[&words[..], &[npz.to_str().unwrap()], more].concat()), 0, "{more:?}");
        array(&npz, "coefficients").1
    };
    let (gallery, direct) = (path("gallery"), path("direct"));
    dance("a.npz", &["--gallery", "6", "--presets", gallery.to_str().unwrap()]);
    assert_eq!(std::fs::read_dir(&gallery).unwrap().count(), 6);
    dance("b.npz", &["--preset", gallery.join("item-06.toml").to_str().unwrap()]);
    // Without a gallery the first item is the direct mapping, which was loaded into its place.
    let played = dance("c.npz", &["--presets", direct.to_str().unwrap()]);
    let again = dance("d.npz", &["--preset", direct.join("item-01.toml").to_str().unwrap()]);
    assert!(played.iter().zip(&again).all(|(a, b)| (a - b).abs() < 1e-6 * (1.0 + a.abs())));
    assert!(played.iter().any(|c| *c != 0.0));
    // They do not replace the one that is danced, and those of a part of a film would be of another moment.
    let before = bytes_below(folder.path());
    let [item, gallery, direct, npz] = [&gallery.join("item-06.toml"), &gallery, &direct, &path("e.npz")]
        .map(|path| path.to_str().unwrap().to_owned());
    for more in
        [["--preset", &item, "--presets", &gallery], ["--presets", &direct, "--piece", "1/2"]].map(Vec::from)
    {
        let words = ["dance", "sample:octopus", "sample:tune", "-k", "24", "--duration", "0.2"];
        let arguments = [&words[..], &["--coefficients", &npz], &more].concat();
        assert_eq!(run(&arguments), 2, "{more:?}");
    }
    let resumed = ["dance", "sample:octopus", "sample:tune", "--frames", &gallery, "--resume"];
    assert_eq!(run(&[&resumed[..], &["--presets", &direct]].concat()), 2);
    // Arrays go into a file that says so.
    assert_eq!(run(&["dance", "sample:octopus", "sample:tune", "--coefficients", &format!("{npz}.txt")]), 2);
    assert!(bytes_below(folder.path()) == before);
}
