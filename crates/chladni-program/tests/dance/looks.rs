//! Looks that come on stage while a show goes on.

use std::path::Path;

use chladni_music::{Action, FileRef, GalleryShape, Instrument, LoggedAction, Looks, Moment, Show, SongRef};

use crate::{ball, run};

/// A show in the look `own`; what is on stage gets another one after 0.2 s.
pub fn show(own: &str, on_stage: Option<&str>) -> Show {
    let shape = GalleryShape { eigenvalues: (0..16).map(f64::from).collect(), bands: 32 };
    let instrument = Instrument::new(1, 6, shape).unwrap();
    let file = |path: &str| FileRef { path: path.to_owned(), blake3: None };
    let at = |at_secs, action| LoggedAction { moment: Moment { at_secs, at_beat: 0.0 }, action };
    let look = on_stage.map(|look| at(0.2, Action::SetLook { look: look.to_owned() }));
    Show {
        body: Some(file("ball.obj")),
        songs: vec![SongRef::of(file("sample:tune"))],
        looks: Some(Looks { look: own.to_owned(), ..Looks::default() }),
        actions: [at(0.0, Action::Perform { item: 0 })].into_iter().chain(look).collect(),
        ..Show::of(&instrument)
    }
}

/// One frame at `start` seconds.
pub fn frame(folder: &Path, show: &Show, start: &str, more: &[&str]) -> Vec<u8> {
    ball(&folder.join("ball.obj"));
    let (file, frames) = (folder.join("a.show.json"), folder.join("frames"));
    show.save(&file).unwrap();
    let [file, out] = [&file, &frames].map(|path| path.to_str().unwrap());
    let dance = ["dance", "--show", file, "--frames", out, "--start", start, "--duration", "0.03"];
    let small = ["--size", "96x54", "--draw", "cpu"];
    assert_eq!(run(&[&dance[..], &small, more].concat()), 0);
    let bytes = std::fs::read(frames.join("frame-00000.png")).unwrap();
    std::fs::remove_dir_all(&frames).unwrap();
    bytes
}

#[test]
fn a_show_repeats_the_looks_that_came_on_stage() {
    let folder = tempfile::tempdir().unwrap();
    let frame = |show: &Show, start, more: &[&str]| frame(folder.path(), show, start, more);
    let (ember, contour) = (show("ember", None), show("contour", None));
    let changing = show("ember", Some("contour"));
    assert_ne!(frame(&ember, "0.4", &[]), frame(&contour, "0.4", &[]));
    assert_eq!(frame(&changing, "0.1", &[]), frame(&ember, "0.1", &[]));
    assert_eq!(frame(&changing, "0.4", &[]), frame(&contour, "0.4", &[]));
    // A film that asks for a look has that one throughout.
    assert_eq!(frame(&changing, "0.4", &["--look", "ember"]), frame(&ember, "0.4", &[]));
    // One that asks for a blur, which a show may name, too, has it in every look.
    let soft = |name| {
        let mut show = show(name, None);
        show.looks.iter_mut().for_each(|looks| looks.blur_percent = Some(90));
        show
    };
    assert_ne!(frame(&contour, "0.4", &["--blur", "90"]), frame(&contour, "0.4", &[]));
    assert_eq!(frame(&contour, "0.4", &["--blur", "90"]), frame(&soft("contour"), "0.4", &[]));
    assert_eq!(frame(&contour, "0.4", &["--blur", "0"]), frame(&contour, "0.4", &[]));
    assert_eq!(frame(&changing, "0.4", &["--blur", "90"]), frame(&contour, "0.4", &["--blur", "90"]));
    // A look of another version leaves the show's own.
    assert_eq!(frame(&show("ember", Some("dawn of 2031")), "0.4", &[]), frame(&ember, "0.4", &[]));
}

#[test]
fn a_transparent_background_needs_no_picture_of_the_show() {
    let folder = tempfile::tempdir().unwrap();
    let picture = folder.path().join("text.png");
    std::fs::write(&picture, "no picture").unwrap();
    let (plain, mut pictured) = (show("ember", None), show("ember", None));
    let named = picture.to_str().unwrap().to_owned();
    pictured.looks.iter_mut().for_each(|looks| looks.picture.clone_from(&named));
    let frame = |show: &Show| frame(folder.path(), show, "0.1", &["--background", "transparent"]);
    assert_eq!(frame(&pictured), frame(&plain));
}

#[test]
fn what_is_left_out_is_missing_in_every_look() {
    let folder = tempfile::tempdir().unwrap();
    let frame = |show: &Show, more: &[&str]| frame(folder.path(), show, "0.4", more);
    let without = ["--without", "trails,corners"];
    let calm = |mut show: Show| {
        let left_out = ["trails", "corners"].map(str::to_owned).to_vec();
        show.looks.iter_mut().for_each(|looks| looks.without.clone_from(&left_out));
        show
    };
    let (ember, contour) = (show("ember", None), show("contour", None));
    // The first frame of a film has no trails yet.
    for left_out in ["glow", "corners"] {
        assert_ne!(frame(&contour, &["--without", left_out]), frame(&contour, &[]), "{left_out}");
    }
    assert_eq!(frame(&calm(contour.clone()), &[]), frame(&contour, &without));
    // A look that comes on stage, or that the film asks for, lacks it, too.
    let changing = show("ember", Some("contour"));
    assert_eq!(frame(&changing, &without), frame(&contour, &without));
    assert_eq!(frame(&calm(changing.clone()), &[]), frame(&contour, &without));
    assert_eq!(frame(&calm(changing), &["--look", "ember"]), frame(&ember, &without));
}

#[test]
fn a_part_of_a_film_has_the_grain_of_the_whole_one() {
    let folder = tempfile::tempdir().unwrap();
    ball(&folder.path().join("ball.obj"));
    let file = folder.path().join("a.show.json");
    show("noir", None).save(&file).unwrap();
    let picture = |start: &str, secs: &str, number: usize| {
        let frames = folder.path().join(start);
        let [file, out] = [&file, &frames].map(|path| path.to_str().unwrap());
        let dance = ["dance", "--show", file, "--frames", out, "--start", start, "--duration", secs];
        let small = ["--fps", "8", "--size", "96x54", "--draw", "cpu", "--allow-flashes"];
        assert_eq!(run(&[&dance[..], &small].concat()), 0);
        std::fs::read(frames.join(format!("frame-{number:05}.png"))).unwrap()
    };
    assert!(picture("0", "0.75", 4) == picture("0.5", "0.25", 0));
}
