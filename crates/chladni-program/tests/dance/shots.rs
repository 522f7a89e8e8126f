//! Shots that the camera chooses.

use crate::run;
use crate::strobing::frames;

/// The shares of the upper and the lower row, and of the left and the right column, that the figure covers: without a
/// background, what is opaque is the figure.
fn cut_off(picture: &chladni_view::Picture) -> [f32; 4] {
    let (width, height) = (picture.width, picture.height);
    let opaque = |x: u32, y: u32| f32::from(u8::from(picture.pixel(x, y).unwrap()[3] > 200));
    let row = |y: u32| (0..width).map(|x| opaque(x, y)).sum::<f32>() / width as f32;
    let column = |x: u32| (0..height).map(|y| opaque(x, y)).sum::<f32>() / height as f32;
    [row(0), row(height - 1), column(0), column(width - 1)]
}

/// The share of an edge that a tip covers at most.
const TIP: f32 = 0.1;

#[test]
fn a_figure_stays_in_the_picture() {
    let strong = ["--form", "half-mask", "--gain", "1.5"];
    for (name, more) in
        [("sample:octopus", &[][..]), ("sample:bell", &[][..]), ("sample:octopus", &strong[..])]
    {
        let folder = tempfile::tempdir().unwrap();
        let dance = ["dance", name, "sample:tune", "--frames", folder.path().to_str().unwrap()];
        let seen = ["--background", "transparent", "--size", "128x96", "--fps", "6", "-k", "96"];
        assert_eq!(run(&[&dance[..], &seen, more].concat()), 0);
        let pictures = frames(folder.path());
        let opaque = |p: &chladni_view::Picture| p.rgba.chunks_exact(4).any(|pixel| pixel[3] > 200);
        assert!(pictures.iter().all(opaque), "{name}: an empty picture");
        let shares: Vec<[f32; 4]> = pictures.iter().map(cut_off).collect();
        let cut = |edge: usize| shares.iter().filter(|shares| shares[edge] > 0.0).count();
        let most = |edge: usize| shares.iter().map(|shares| shares[edge]).fold(0.0, f32::max);
        for (edge, side, bound) in [(0, "above", 0.06), (2, "on the left", 0.2), (3, "on the right", 0.2)] {
            assert!(
                cut(edge) * 10 <= pictures.len() && most(edge) < bound,
                "{name}: cut off {side} in {}, {} of it",
                cut(edge),
                most(edge)
            );
        }
        // From near, whatever does not fit is cut off below. Seen as a whole, all of the figure is in the picture,
        // except parts that sink farther than there is room for, as the tip of the bell's clapper does.
        let below = shares.iter().filter(|shares| shares[1] > TIP).count();
        assert!(below * 10 <= 4 * pictures.len(), "{name}: cut off below in {below} of {}", pictures.len());
    }
}
