//! Bad arguments and damaged files: each is refused in one line.

use std::path::Path;

use chladni_program::cli;
use chladni_testdata::shared;

use super::{OCTAHEDRON, Run, files_below, text};

#[test]
fn bad_arguments_end_with_code_2() {
    let folder = tempfile::tempdir().unwrap();
    let lie = folder.path().join("lie.ply");
    std::fs::write(&lie, "Dear reader, this is not a mesh.\n").unwrap();
    let nan = folder.path().join("nan.obj");
    std::fs::write(&nan, OCTAHEDRON.replace("v 1 0 0", "v nan 0 0")).unwrap();
    let range = folder.path().join("range.obj");
    std::fs::write(&range, OCTAHEDRON.replace("f 1 3 5", "f 1 3 99")).unwrap();
    let missing = folder.path().join("missing.obj");
    for path in [&lie, &nan, &range, &missing, &folder.path().to_owned()] {
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        Run::of(&["info", text(path)]).refused(&name);
        Run::of(&["basis", text(path), "-k", "4", "-o", text(&folder.path().join("b.npz"))]).refused(&name);
    }
    let good = folder.path().join("good.obj");
    std::fs::write(&good, OCTAHEDRON).unwrap();
    let out = folder.path().join("b.npz");
    assert_eq!(Run::of(&["basis", text(&good), "-k", "6000", "-o", text(&out)]).code(), 2);
    assert!(!out.exists());
    assert_eq!(Run::of(&["no-such-command"]).code(), 2);
    assert_eq!(Run::of(&["caricature", text(&good), "ellipsoid", "--mu", "wild", "-o", "x.obj"]).code(), 2);
    let silent = folder.path().join("not-there.wav");
    Run::of(&["dance", text(&good), text(&silent), "--frames", text(folder.path()), "-k", "4"])
        .refused("not-there.wav");
}

#[test]
fn the_fuzzer_starts_from_command_lines_that_are_understood() {
    let seeds = files_below(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz/seeds/arguments"));
    assert!(!seeds.is_empty());
    for path in seeds {
        // One names a file by what is no Unicode.
        let bytes = std::fs::read(&path).unwrap();
        let line = String::from_utf8_lossy(&bytes);
        let understood = cli::understand(std::iter::once("chladni").chain(line.lines()));
        assert!(understood.is_ok(), "{}: {understood:?}", path.display());
    }
}

#[test]
fn every_nasty_file_works_or_is_refused_in_one_line() {
    let Some(meshes) = shared("meshes") else { return };
    let folder = tempfile::tempdir().unwrap();
    for path in files_below(&meshes.join("nasty")).into_iter().chain(files_below(&meshes.join("formats"))) {
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        if [".mtl", ".jpg"].iter().any(|other| name.ends_with(other)) {
            continue;
        }
        Run::of(&["info", text(&path), "--json"]).works_or_is_refused(&name);
        // A truncated copy of the same file.
        let bytes = std::fs::read(&path).unwrap();
        let cut = folder.path().join(&name);
        std::fs::write(&cut, &bytes[..bytes.len() * 2 / 3]).unwrap();
        Run::of(&["info", text(&cut), "--json"]).works_or_is_refused(&name);
    }
}

#[test]
fn small_nasty_meshes_get_a_basis_or_a_reason() {
    let Some(meshes) = shared("meshes/nasty") else { return };
    let folder = tempfile::tempdir().unwrap();
    for name in
        ["fan3.obj", "hourglass_ico.obj", "moebius.obj", "platonic_shelf.obj", "soup.stl", "multibody.stl"]
    {
        let out = folder.path().join("basis.npz");
        let run = Run::of(&["basis", text(&meshes.join(name)), "-k", "3", "-o", text(&out), "--no-cache"]);
        run.works_or_is_refused(name);
        assert_eq!(run.code(), 0, "{name}: {}", run.stderr());
    }
}

#[test]
fn empty_songs_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let mesh = folder.path().join("mesh.obj");
    std::fs::write(&mesh, OCTAHEDRON).unwrap();
    for name in ["empty.wav", "empty.ogg"] {
        let Some(song) = shared(&format!("audio/{name}")) else { return };
        Run::of(&["dance", text(&mesh), text(&song), "--frames", text(&folder.path().join("f")), "-k", "4"])
            .refused(name);
        assert!(!folder.path().join("f").exists(), "{name}: nothing is written for a song without sound");
    }
}

#[test]
fn wrong_arguments_are_told_in_one_line() {
    for (arguments, part) in [
        (&["basis"][..], "<MESH>"),
        (&["basis", "a.obj", "--harmonic", "3"], "--harmonics"),
        (&["basis", "a.obj", "-k", "many"], "many"),
        (&["sing"], "sing"),
        (&["open", "-o", "set.txt"], "set.txt"),
        (&["open", "-o", "no/such/folder/set.mp4"], "set.mp4"),
        (&["open", "song.wav", "-o", "set.mp4", "--format", "y4m"], "--format"),
        (&["open", "song.wav", "-o", "-", "--measure", "3"], "standard output"),
        (&["dance", "--show", "a.toml", "--seed", "2", "-o", "a.gif"], "--seed"),
        (&["dance", "sample:cat", "sample:tune", "-o", "-", "--resume"], "--resume is for files"),
    ] {
        let run = Run::of(arguments);
        run.refused(part);
        assert_eq!(run.stderr().lines().count(), 1, "{}", run.stderr());
    }
    Run::of(&["--help"]).succeeded();
    Run::of(&["--version"]).succeeded();
}

#[cfg(unix)]
#[test]
fn names_that_are_not_unicode_are_understood_or_named() {
    use std::ffi::OsStr;
    use std::os::unix::ffi::OsStrExt;
    let understood = |line: &str| {
        let odd = OsStr::from_bytes(b"caf\xe9.obj");
        let arguments = line.split(' ').map(|word| if word == "ODD" { odd } else { OsStr::new(word) });
        cli::understand(arguments)
    };
    for line in [
        "chladni beats ODD",
        "chladni spectrum ODD --json",
        "chladni symmetry ODD",
        "chladni caricature ODD ellipsoid -o wild.obj",
        "chladni project new ODD -o me.chladni",
    ] {
        understood(line).unwrap();
    }
    for line in ["chladni dance ODD song.wav -o a.gif", "chladni caricature sample:head ODD -o wild.obj"] {
        let why = understood(line).unwrap_err().to_string();
        assert!(why.starts_with("caf\u{fffd}.obj: "), "{why}");
    }
}

#[cfg(unix)]
#[test]
fn what_never_ends_is_refused_before_it_is_read() {
    let folder = tempfile::tempdir().unwrap();
    let (mesh, out) = (folder.path().join("mesh.obj"), folder.path().join("out.npz"));
    std::fs::write(&mesh, OCTAHEDRON).unwrap();
    let (mesh, out, zero) = (text(&mesh), text(&out), "/dev/zero");
    for arguments in [
        &["info", zero][..],
        &["beats", zero],
        &["dance", mesh, zero, "--frames", out, "-k", "4"],
        &["match", mesh, mesh, "--landmarks", zero, "-o", out],
        &["caricature", "--recipe", zero, "-o", out],
    ] {
        Run::of(arguments).refused(zero);
    }
}

#[test]
fn nothing_that_is_read_is_replaced_and_no_array_is_called_a_mesh() {
    let folder = tempfile::tempdir().unwrap();
    let [shape, other] = ["shape.obj", "other.obj"].map(|name| folder.path().join(name));
    for path in [&shape, &other] {
        chladni_mesh::save_mesh(&chladni_mesh::samples::icosphere(2), path).unwrap();
    }
    let before = std::fs::read(&shape).unwrap();
    let [shape_name, other_name] = [text(&shape), text(&other)];
    for arguments in [
        &["basis", shape_name, "-k", "8", "-o", shape_name][..],
        &["parts", shape_name, "--level", "0.3", "-o", shape_name],
        &["match", shape_name, other_name, "-o", shape_name],
        &["caricature", shape_name, "ellipsoid", "-o", shape_name],
        &["caricature", other_name, shape_name, "-o", shape_name],
        &["mean", other_name, shape_name, "-o", shape_name],
        &["transfer", other_name, other_name, shape_name, "-o", shape_name],
    ] {
        Run::of(arguments).refused("shape.obj");
        assert!(std::fs::read(&shape).unwrap() == before, "{arguments:?}");
    }
    // A project's own shape and template, and masks.
    let [project, mask] = ["p.chladni", "mask.npy"].map(|name| folder.path().join(name));
    let [project_name, mask_name] = [text(&project), text(&mask)];
    Run::of(&["project", "new", shape_name, "-k", "8", "-o", project_name]).succeeded();
    Run::of(&["project", "add-layer", project_name, "--template", other_name]).succeeded();
    Run::of(&["mask", shape_name, "--curved", "bumps", "-o", mask_name]).succeeded();
    let kept = [&shape, &other, &mask].map(|path| std::fs::read(path).unwrap());
    for (arguments, name) in [
        (&["caricature", "--recipe", project_name, "-o", shape_name][..], "shape.obj"),
        (&["caricature", "--recipe", project_name, "-o", other_name], "other.obj"),
        (&["caricature", "sample:bell", "ellipsoid", "--mask", shape_name, "-o", shape_name], "shape.obj"),
        (&["mask", project_name, "-o", shape_name], "shape.obj"),
        (&["mask", shape_name, "--mask", mask_name, "-o", mask_name], "mask.npy"),
    ] {
        Run::of(arguments).refused(name);
        assert!(kept == [&shape, &other, &mask].map(|path| std::fs::read(path).unwrap()), "{arguments:?}");
    }
    // A batch into the folder of its template, and one whose pictures cannot be.
    let shapes = folder.path().join("shapes");
    std::fs::create_dir(&shapes).unwrap();
    chladni_mesh::save_mesh(&chladni_mesh::samples::icosphere(2), &shapes.join("other.obj")).unwrap();
    let batch = ["caricature", "--recipe", project_name, "--batch", text(&shapes), "-o", text(folder.path())];
    Run::of(&batch).refused("other.obj");
    assert!(std::fs::read(&other).unwrap() == kept[1]);
    let [results, drawn] = ["results", "drawn"].map(|name| folder.path().join(name));
    let pictures = ["--render", text(&drawn), "--up", "y", "--front", "-y"];
    let batch = ["caricature", "--recipe", project_name, "--batch", text(&shapes), "-o", text(&results)];
    Run::of(&[&batch[..], &pictures].concat()).refused("front");
    assert!(!results.exists());
    for option in [&["--model", "normal"][..], &["--mu", "-2"], &["--no-clamp"], &["--scale-curve", "broad"]]
    {
        let gallery = ["caricature", shape_name, "--gallery", "-o", "never.png"];
        Run::of(&[&gallery[..], option].concat()).refused(option[0]);
    }
    let unknown = text(&folder.path().join("mean.abc")).to_owned();
    Run::of(&["mean", shape_name, other_name, "-o", &unknown]).refused("mean.abc");
    Run::of(&["match", shape_name, "ellipsoid"]).refused("--method ellipsoid");
}

#[test]
fn settings_are_refused_by_name_by_value_and_by_range() {
    for (setting, why) in [
        ("foo=1", "no knob or switch is called foo"),
        ("blur=0.4", "blur has an option of its own: --blur"),
        ("volume=0.5", "volume belongs to the window"),
        ("decay=abc", "decay is a number from 0"),
        ("decay=99", "decay is a number from 0"),
        ("harmonics=-20", "harmonics is a number from 0 (all)"),
        ("harmonics=1e9", "harmonics is a number from 0 (all)"),
        ("form=zzz", "form has no value called zzz"),
        ("nothing", "expected NAME=VALUE"),
    ] {
        Run::of(&["dance", "sample:cat", "sample:tune", "--set", setting, "-o", "never.mp4"]).refused(why);
    }
    let transparent = ["--picture", "never.png", "--background", "transparent", "-o", "never.gif"];
    Run::of(&[&["dance", "sample:cat", "sample:tune"][..], &transparent].concat())
        .refused("leave out --background transparent");
    for (option, value) in [("--format", "y4m"), ("--targets", "5")] {
        Run::of(&["dance", "sample:cat", "sample:tune", option, value, "-o", "never.mp4"]).refused(option);
    }
}

#[test]
fn options_of_pictures_are_refused_for_a_dance_without_any() {
    for option in [
        &["--look", "neon"][..],
        &["--blur", "0"],
        &["--without", "glow"],
        &["--yaw", "10"],
        &["--size", "64x64"],
        &["--samples", "4"],
        &["--synthesis", "cpu"],
        &["--picture", "never.png"],
        &["--titles"],
        &["--rest"],
        &["--flash-fields"],
    ] {
        for output in [["-o", "never.glb"], ["--coefficients", "never.npz"]] {
            let dance = ["dance", "sample:cat", "sample:tune"];
            Run::of(&[&dance[..], &output, option].concat())
                .refused(&format!("{} is for a picture", option[0]));
        }
    }
}

#[test]
fn options_of_a_picture_of_parts_are_refused_without_one() {
    for (option, value) in [("--size", "64x64"), ("--view", "0,0"), ("--up", "z"), ("--front", "z")] {
        for level in [&["--level", "0.3"][..], &[]] {
            let parts = ["parts", "sample:head", option, value];
            Run::of(&[&parts[..], level].concat()).refused(&format!("{option} is for a picture"));
        }
    }
}

#[test]
fn numbers_below_zero_are_refused_by_their_own_ranges() {
    let dance = ["dance", "sample:cat", "sample:tune", "-o", "never.gif"];
    for (option, why) in [("--gain", "--gain: "), ("--mu", "--mu: "), ("--start", "must not be negative")] {
        Run::of(&[&dance[..], &[option, "-1"]].concat()).refused(why);
    }
    Run::of(&["spectrum", "sample:tune", "--json", "--start", "-1"]).refused("must not be negative");
    Run::of(&["parts", "sample:head", "--level", "-0.5"]).refused("a number from 0 to 1");
    let drawn = ["caricature", "sample:bell", "ellipsoid", "-o", "never.obj", "--render", "never.svg"];
    Run::of(&[&drawn[..], &["--ink-detail", "-1"]].concat()).refused("a number from 0 to 10");
    // A whole number is none, and `--` would not make it one.
    let run = Run::of(&["basis", "sample:bell", "-k", "-3"]);
    run.refused("-3");
    assert!(!run.stderr().contains("tip"), "{}", run.stderr());
}

#[test]
fn a_preset_of_version_1_says_what_it_lacks() {
    let folder = tempfile::tempdir().unwrap();
    let [preset, gif] = ["old.toml", "never.gif"].map(|name| folder.path().join(name));
    let mapping = "transfer = [0.5]\namplification = [0.5]\nstereo_mu = 0.0\ngain = 1.0\n";
    let old = format!("format_version = 1\nname = \"x\"\nseed = 1\n[mapping]\n{mapping}");
    std::fs::write(&preset, old).unwrap();
    // Without its song nothing is filmed.
    let run = Run::of(&["dance", "sample:bell", "nowhere.ogg", "--preset", text(&preset), "-o", text(&gif)]);
    run.refused("nowhere.ogg");
    assert!(run.stderr().contains("is a preset of version 1"), "{}", run.stderr());
}

#[test]
fn what_stands_in_the_place_of_something_else_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let [project, file, gif] = ["p.chladni", "file", "never.gif"].map(|name| folder.path().join(name));
    let [project, file, gif] = [&project, &file, &gif].map(|path| text(path));
    Run::of(&["project", "new", "sample:bell", "-k", "8", "-o", project]).succeeded();
    Run::of(&["dance", "--show", project, "-o", gif]).refused("is a caricature: give it as MESH");
    Run::of(&["dance", "sample:cat", "sample:tune", "--preset", project, "-o", gif])
        .refused("is a caricature: give it as MESH");
    Run::of(&["dance", "sample:tune", "sample:bell", "-o", gif])
        .refused("sample:tune: is a song, not a shape");
    Run::of(&["info", "sample:tune"]).refused("sample:tune: is a song, not a shape");
    Run::of(&["dance", "sample:bell", "sample:head", "-o", gif])
        .refused("sample:head: is a shape, not a song; sample:tune is one");
    Run::of(&["dance", "sample:cat", "sample:tune", "-o", "never.mkv"]).refused("for a folder use --frames");
    std::fs::write(file, "").unwrap();
    Run::of(&["demo", "-o", file]).refused("is a file");
}

#[test]
fn a_song_that_contradicts_what_its_decoder_asserts_is_refused_in_one_line() {
    let folder = tempfile::tempdir().unwrap();
    let song = folder.path().join("asserted.ogg");
    // A lattice in 32 dimensions, of which the reader of Ogg asserts in 32 bits that 2^32 is more than four.
    let words = [(0x0056_4342, 24), (32, 16), (4, 24), (0, 1), (0, 1), (1, 5), (1, 5), (1, 5), (1, 5)];
    let book = [&words[..], &[(1, 4), (0, 32), (0, 32), (0, 4), (0, 1), (0, 1)]].concat();
    std::fs::write(&song, chladni_testdata::vorbis_of_books(1, &book)).unwrap();
    let gif = folder.path().join("x.gif");
    let [song, gif] = [&song, &gif].map(|path| path.to_str().unwrap());
    let run = Run::of(&["--quiet", "dance", "sample:octopus", song, "-o", gif]);
    run.refused("asserted.ogg");
    assert_eq!(run.stderr().lines().count(), 1, "{}", run.stderr());
}
