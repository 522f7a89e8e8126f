//! A shape that dances in the colors that it brings.

use super::*;

/// The window on a red ball, or one without colors, whose own are chosen; and the folder of its files.
fn enter_on(is_red: bool) -> (Window, tempfile::TempDir) {
    let folder = tempfile::tempdir().unwrap();
    let folders = folders(folder.path());
    let settings = folders.settings.clone().unwrap();
    let look =
        "look = \"\"\nmaterial = \"clay\"\nlights = \"studio\"\nbackground = \"white\"\npalette = \"own\"\n";
    std::fs::write(settings, format!("harmonics = 24\n[music]\n{look}")).unwrap();
    // So many vertices that the gallery shows fewer of them.
    let mut mesh = chladni_mesh::samples::icosphere(5);
    if is_red {
        mesh.appearance.colors = Some(vec![[0.7, 0.0, 0.0, 1.0]; mesh.positions.len()]);
    }
    let ball = folder.path().join("ball.ply");
    chladni_mesh::save_mesh(&mesh, &ball).unwrap();
    (enter(Opening { folders, files: vec![ball], ..Opening::default() }), folder)
}

/// How many pixels of a dance in the gallery are red.
fn red_pixels(window: &mut Window) -> usize {
    let (picture, dance) = (window.render().unwrap(), control(window, "dance/1").rect());
    let inside = |x: u32, y: u32| dance.contains(Pos2::new(x as f32, y as f32));
    let is_red = |[r, g, b, _]: [u8; 4]| r > 40 && i32::from(r) > 2 * i32::from(g.max(b));
    picture.enumerate_pixels().filter(|(x, y, pixel)| inside(*x, *y) && is_red(pixel.0)).count()
}

#[test]
fn the_gallery_shows_them_and_the_drawer_says_where_there_are_none() {
    let missing = "has no colors of its own";
    let (mut window, _folder) = enter_on(true);
    window.run_steps(5);
    assert!(red_pixels(&mut window) > 500);
    click(&mut window, "drawer/look");
    assert!(shows(&window, "Own colors") && !shows(&window, missing));
    screenshot(&mut window, "music-own-colors.png");

    let (mut window, folder) = enter_on(false);
    window.run_steps(5);
    assert_eq!(red_pixels(&mut window), 0);
    click(&mut window, "drawer/look");
    assert!(shows(&window, missing));
    assert!(
        std::fs::read_to_string(folder.path().join("settings.toml")).unwrap().contains("palette = \"own\"")
    );
}
