//! A shape that dances in the colors that it brings.

use super::*;

/// The window on a ball, with its own colors chosen, which are red or none.
fn enter_on_ball(folder: &Path, is_red: bool) -> Window {
    let folders = folders(folder);
    let settings = folders.settings.clone().unwrap();
    let look =
        "look = \"\"\nmaterial = \"clay\"\nlights = \"studio\"\nbackground = \"white\"\npalette = \"own\"\n";
    // On a slow machine the autopilot would take the stage before the gallery is looked at.
    std::fs::write(settings, format!("harmonics = 24\n[music]\nleans_back = false\n{look}")).unwrap();
    // So many vertices that the gallery shows fewer of them.
    let mut mesh = chladni_mesh::samples::icosphere(5);
    mesh.appearance.colors = is_red.then(|| vec![[0.7, 0.0, 0.0, 1.0]; mesh.positions.len()]);
    let ball = folder.join("ball.ply");
    chladni_mesh::save_mesh(&mesh, &ball).unwrap();
    // A mesh alone would be exaggerated.
    let [_, song] = ball_and_song(folder);
    enter(Opening { folders, files: vec![ball, song], ..Opening::default() })
}

#[test]
fn the_gallery_shows_the_colors_that_a_shape_brings() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = enter_on_ball(folder.path(), true);
    window.run_steps(5);
    let (picture, dance) = (window.render().unwrap(), control(&window, "dance/1").rect());
    let inside = |x: u32, y: u32| dance.contains(Pos2::new(x as f32, y as f32));
    let is_red = |[r, g, b, _]: [u8; 4]| r > 40 && i32::from(r) > 2 * i32::from(g.max(b));
    let red = picture.enumerate_pixels().filter(|(x, y, pixel)| inside(*x, *y) && is_red(pixel.0)).count();
    assert!(red > 500, "{red} red pixels");
}

#[test]
fn the_drawer_says_where_a_shape_brings_no_colors() {
    for is_red in [true, false] {
        let folder = tempfile::tempdir().unwrap();
        let mut window = enter_on_ball(folder.path(), is_red);
        click(&mut window, "drawer/look");
        let says_so = window.query_by_label_contains("no colors of its own").is_some();
        assert_eq!(says_so, !is_red);
    }
}
