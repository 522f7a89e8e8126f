//! Shapes that dance in the colors that they bring.

use std::path::Path;
use std::process::Command;

use chladni_caricature::{Layer, Project, ShapeSource, Template};
use chladni_music::Looks;
use chladni_view::Picture;

use crate::looks::{frame, show};
use crate::{ball, run};

/// The first frame of a film without light of any color, seen from the front.
fn picture(mesh: &Path, more: &[&str]) -> Picture {
    let frames = mesh.with_file_name("frames");
    let [mesh, out] = [mesh, &frames].map(|path| path.to_str().unwrap());
    let dance = ["dance", mesh, "sample:tune", "-k", "16", "--frames", out, "--duration", "0.03"];
    let look =
        ["--look", "plain", "--lights", "studio", "--background", "night", "--up", "y", "--front", "z"];
    assert_eq!(run(&[&dance[..], &look, &["--size", "96x96", "--draw", "cpu"], more].concat()), 0);
    let bytes = std::fs::read(frames.join("frame-00000.png")).unwrap();
    std::fs::remove_dir_all(&frames).unwrap();
    Picture::decode(&bytes).unwrap()
}

/// How many pixels have a color, and where they are across, in [0, 1], in the mean.
fn seen(picture: &Picture, is: impl Fn([u8; 3]) -> bool) -> (usize, f64) {
    let pixels = picture.rgba.as_chunks::<4>().0.iter().enumerate();
    let columns: Vec<f64> = pixels
        .filter(|(_, [r, g, b, _])| is([*r, *g, *b]))
        .map(|(i, _)| (i as f64 % f64::from(picture.width)) / f64::from(picture.width))
        .collect();
    (columns.len(), columns.iter().sum::<f64>() / columns.len().max(1) as f64)
}

fn is_red([r, g, b]: [u8; 3]) -> bool {
    r > 40 && i32::from(r) > 2 * i32::from(g.max(b))
}

fn is_blue([r, g, b]: [u8; 3]) -> bool {
    b > 40 && i32::from(b) > 2 * i32::from(r.max(g))
}

/// A ball whose left is red and whose right is blue.
fn painted(folder: &Path) -> std::path::PathBuf {
    let path = folder.join("painted.ply");
    let mut mesh = chladni_mesh::samples::icosphere(4);
    let color = |p: &[f64; 3]| if p[0] < 0.0 { [0.8, 0.0, 0.0, 1.0] } else { [0.0, 0.0, 0.8, 1.0] };
    mesh.appearance.colors = Some(mesh.positions.iter().map(color).collect());
    chladni_mesh::save_mesh(&mesh, &path).unwrap();
    path
}

/// The same by an image of two pixels.
fn textured(folder: &Path) -> std::path::PathBuf {
    let mesh = chladni_mesh::samples::icosphere(4);
    let skin = Picture { width: 2, height: 1, rgba: vec![230, 0, 0, 255, 0, 0, 230, 255] };
    std::fs::write(folder.join("skin.png"), skin.to_png().unwrap()).unwrap();
    std::fs::write(folder.join("skin.mtl"), "newmtl skin\nmap_Kd skin.png\n").unwrap();
    let across = |p: &[f64; 3]| if p[0] < 0.0 { 0.25 } else { 0.75 };
    let text = chladni_testdata::textured_obj(&mesh.positions, &mesh.triangles, "skin.mtl", across);
    let path = folder.join("textured.obj");
    std::fs::write(&path, text).unwrap();
    path
}

#[test]
fn a_film_shows_the_colors_and_the_texture_that_a_shape_brings() {
    let folder = tempfile::tempdir().unwrap();
    for mesh in [painted(folder.path()), textured(folder.path())] {
        let own = picture(&mesh, &["--palette", "own"]);
        let ((red, left), (blue, right)) = (seen(&own, is_red), seen(&own, is_blue));
        assert!(red > 500 && blue > 500, "{}: {red} red and {blue} blue pixels", mesh.display());
        assert!(left < 0.45 && right > 0.55, "{}: {left}, {right}", mesh.display());
        // Unless they are asked for, the look's own are shown.
        let of_look = picture(&mesh, &[]);
        assert_eq!([seen(&of_look, is_red).0, seen(&of_look, is_blue).0], [0, 0]);
        assert_eq!(picture(&mesh, &["--palette", "own", "--allow-flashes"]).rgba, own.rgba);
    }
}

#[test]
fn no_film_replaces_a_texture_of_the_shape_or_of_a_template() {
    let folder = tempfile::tempdir().unwrap();
    let (mesh, skin) = (textured(folder.path()), folder.path().join("skin.png"));
    let project = folder.path().join("like.chladni");
    let mut like = Project::new(ShapeSource::Sample("octopus".into()), 16);
    like.push(Layer::new("like", Template::File(mesh.clone()))).unwrap();
    like.save(&project).unwrap();
    let before = std::fs::read(&skin).unwrap();
    for body in [&mesh, &project] {
        let [body, out] = [body, &skin].map(|path| path.to_str().unwrap());
        let dance = ["dance", body, "sample:tune", "-k", "16", "--duration", "0.03", "--size", "64x64"];
        assert_eq!(run(&[&dance[..], &["--draw", "cpu", "-o", out]].concat()), 2, "{body}");
        assert!(std::fs::read(&skin).unwrap() == before, "{body}");
    }
}

#[test]
fn a_shape_without_colors_has_those_of_the_look_and_the_command_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let mesh = folder.path().join("ball.obj");
    ball(&mesh);
    let film = |palette: &[&str]| {
        let out = folder.path().join("frames");
        let output = Command::new(env!("CARGO_BIN_EXE_chladni"))
            .args(["dance", mesh.to_str().unwrap(), "sample:tune", "-k", "16", "--duration", "0.03"])
            .args(["--size", "64x64", "--draw", "cpu", "--frames", out.to_str().unwrap()])
            .args(palette)
            .output()
            .unwrap();
        let picture = std::fs::read(out.join("frame-00000.png")).unwrap();
        std::fs::remove_dir_all(&out).unwrap();
        (picture, String::from_utf8_lossy(&output.stderr).contains("no colors of its own"))
    };
    let (plain, said) = film(&[]);
    assert!(!said);
    assert_eq!(film(&["--palette", "own"]), (plain, true));
}

#[test]
fn shows_keep_that_a_shape_has_its_own_colors_under_any_look() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::rename(painted(folder.path()), folder.path().join("ball.ply")).unwrap();
    let frame = |look: &str, on_stage: Option<&str>, own: bool, more: &[&str]| {
        let mut show = show(look, on_stage);
        show.body.iter_mut().for_each(|body| body.path = "ball.ply".into());
        if own {
            show.looks = Some(Looks { look: look.into(), palette: "own".into(), ..Looks::default() });
        }
        frame(folder.path(), &show, "0.4", more)
    };
    let own = frame("ember", None, true, &[]);
    assert_ne!(own, frame("ember", None, false, &[]));
    assert_eq!(own, frame("ember", None, false, &["--palette", "own"]));
    assert_eq!(frame("ember", Some("contour"), true, &[]), frame("contour", None, true, &[]));
    assert_ne!(frame("ember", Some("contour"), true, &[]), frame("ember", Some("contour"), false, &[]));
    // Another palette takes their place.
    assert_eq!(
        frame("ember", None, true, &["--palette", "dusk"]),
        frame("ember", None, false, &["--palette", "dusk"])
    );
}
