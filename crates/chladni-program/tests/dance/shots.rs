//! Shots that the camera chooses.

use crate::run;
use crate::strobing::frames;

#[test]
fn the_upper_end_of_a_figure_stays_in_the_picture() {
    for name in ["sample:octopus", "sample:bell"] {
        let folder = tempfile::tempdir().unwrap();
        let dance = ["dance", name, "sample:tune", "--frames", folder.path().to_str().unwrap()];
        // Without a background, what is opaque is the figure.
        let seen = ["--background", "transparent", "--size", "128x96"];
        let moments = ["--fps", "10", "--duration", "12", "-k", "96"];
        assert_eq!(run(&[&dance[..], &seen, &moments].concat()), 0);
        let pictures = frames(folder.path());
        let shares = pictures.iter().map(|picture| {
            let opaque = |row: &[u8]| row.chunks_exact(4).filter(|pixel| pixel[3] > 200).count();
            let width = 4 * picture.width as usize;
            assert!(opaque(&picture.rgba) > 0, "{name}: an empty picture");
            opaque(&picture.rgba[..width]) as f32 / picture.width as f32
        });
        let cut = shares.clone().filter(|share| *share > 0.0).count();
        let most = shares.fold(0.0, f32::max);
        assert!(cut * 10 <= pictures.len() && most < 0.06, "{name}: cut off in {cut}, {most} of the width");
    }
}
