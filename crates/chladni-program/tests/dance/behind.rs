//! A film that stands behind the dance.

use std::process::Command;

use crate::run;
use crate::strobing::{ball, frames};

/// The brightness along the uppermost row.
fn row(picture: &chladni_view::Picture) -> Vec<i32> {
    (0..picture.width).map(|x| i32::from(picture.pixel(x, 0).unwrap()[1])).collect()
}

fn mean(differences: impl Iterator<Item = i32>) -> f64 {
    let (sum, count) = differences.fold((0_i32, 0_i32), |(sum, count), d| (sum + d.abs(), count + 1));
    f64::from(sum) / f64::from(count.max(1))
}

#[test]
fn it_is_as_sharp_in_the_first_frame_as_later() {
    if !chladni_view::ffmpeg_is_there() {
        return println!("skipped: no ffmpeg");
    }
    let folder = tempfile::tempdir().unwrap();
    let [mesh, film, out] = ["ball.obj", "stripes.mkv", "frames"].map(|name| folder.path().join(name));
    ball(&mesh);
    // Stripes of a pixel, in a film that is wider than the window shows it.
    let made = Command::new("ffmpeg")
        .args(["-loglevel", "error", "-f", "lavfi", "-i", "color=black:s=1920x64:r=25:d=0.2"])
        .args(["-vf", "geq=lum=16+219*mod(X\\,2):cb=128:cr=128", "-c:v", "ffv1"])
        .arg(&film)
        .status();
    assert!(made.unwrap().success());
    let [mesh, film, out_name] = [&mesh, &film, &out].map(|path| path.to_str().unwrap());
    let dance = ["dance", mesh, "sample:tune", "-k", "16", "--fps", "25", "--duration", "0.12"];
    let drawn = ["--size", "1920x64", "--draw", "cpu", "--picture", film, "--frames", out_name];
    assert_eq!(run(&[&dance[..], &drawn].concat()), 0);
    let rows: Vec<Vec<i32>> = frames(&out).iter().map(row).collect();
    let contrast = mean(rows[2].windows(2).map(|pair| pair[1] - pair[0]));
    assert!(contrast > 10.0, "no stripes: {contrast}");
    let off = mean(rows[0].iter().zip(&rows[2]).map(|(first, third)| first - third));
    assert!(off < 0.1 * contrast, "{off} of {contrast}");
}
