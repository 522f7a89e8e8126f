//! Pictures, drawings and sheets.

use super::*;

/// The picture that `line` writes.
fn drawn(desk: &Desk, line: &str) -> chladni_view::Picture {
    let output = desk.run(&format!("{line} --render out.png"));
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{line}: {said}");
    chladni_view::Picture::decode(&std::fs::read(desk.path("out.png")).unwrap()).unwrap()
}

fn is_red([r, g, b, _]: [u8; 4]) -> bool {
    r > 90 && u16::from(r) > 2 * u16::from(g.max(b))
}

/// Rows and columns of the left half that something red covers.
fn covered(picture: &chladni_view::Picture) -> [usize; 2] {
    let half = picture.width / 2;
    let red = |x: u32, y: u32| is_red(picture.pixel(x, y).unwrap());
    let rows = (0..picture.height).filter(|y| (0..half).any(|x| red(x, *y))).count();
    let columns = (0..half).filter(|x| (0..picture.height).any(|y| red(*x, y))).count();
    [rows, columns]
}

#[test]
fn a_picture_keeps_colors_stands_as_told_and_uses_its_format() {
    let desk = Desk::new();
    // Thin, long along z, and red.
    let mut stick = samples::icosphere(3);
    for p in &mut stick.positions {
        *p = [0.4 * p[0], 0.3 * p[1], 3.0 * p[2] + 0.3 * p[0] * p[0]];
    }
    stick.appearance.colors = Some(vec![[0.8, 0.02, 0.02, 1.0]; stick.positions.len()]);
    save_mesh(&stick, &desk.path("stick.ply")).unwrap();
    let line = "caricature stick.ply self:scale=0.9 -k 8 -o out.ply --view 0,0 --size 640x480";
    let upright = drawn(&desk, &format!("{line} --up z"));
    let [rows, columns] = covered(&upright);
    assert!(rows > 380 && columns < 120, "{rows} rows, {columns} columns");
    let red = (0..640).flat_map(|x| (0..480).map(move |y| (x, y)));
    let red = red.filter(|(x, y)| is_red(upright.pixel(*x, *y).unwrap())).count();
    assert!(red > 5000, "{red} red pixels");
    let exported = std::fs::read(desk.path("out.ply")).unwrap();

    // It lies, so that the format's width is used: above each other.
    let lying = drawn(&desk, &format!("{line} --up y --front x"));
    let [rows, columns] = covered(&lying);
    assert!(rows < 400 && columns > 250, "{rows} rows, {columns} columns");
    assert_eq!(std::fs::read(desk.path("out.ply")).unwrap(), exported, "files keep their axes");

    let refused = desk.refused(&format!("{line} --up y --front -y --render out.png"));
    assert!(refused.contains("--up y and --front -y lie on one line"), "{refused}");
    assert!(desk.refused(&format!("{line} --up w")).contains("is no direction"));
}

#[test]
fn doubts_about_how_a_shape_stands_are_said_once() {
    let desk = Desk::new();
    save_mesh(&samples::sample("ring").unwrap(), &desk.path("ring.ply")).unwrap();
    let line = "caricature ring.ply ellipsoid -k 8 --size 32x32 --render out.png --turntable out.gif --turn-secs 0.1";
    let output = desk.run(line);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{said}");
    assert_eq!(said.matches("in doubt").count(), 1, "{said}");
}

#[test]
fn panels_and_turntables_show_the_colors_or_the_texture_of_the_shape() {
    let desk = Desk::new();
    let mut mesh = lump(1.0);
    let text = chladni_testdata::textured_obj(&mesh.positions, &mesh.triangles, "skin.mtl", |_| 0.5);
    std::fs::write(desk.path("textured.obj"), text).unwrap();
    std::fs::write(desk.path("skin.mtl"), "newmtl skin\nmap_Kd skin.png\n").unwrap();
    let skin = chladni_view::Picture::filled(2, 2, [230, 0, 0, 255]).to_png().unwrap();
    std::fs::write(desk.path("skin.png"), skin).unwrap();
    mesh.appearance.colors = Some(vec![[0.8, 0.02, 0.02, 1.0]; mesh.positions.len()]);
    save_mesh(&mesh, &desk.path("colored.ply")).unwrap();
    // Red pixels of a square of 100 pixels.
    let red = |picture: &chladni_view::Picture, row: u32, column: u32| {
        let pixels = (0..100).flat_map(|y| (0..100).map(move |x| (100 * column + x, 100 * row + y)));
        pixels.filter(|(x, y)| is_red(picture.pixel(*x, *y).unwrap())).count()
    };
    for (shape, film) in [("textured.obj", "turning"), ("colored.ply", "turned")] {
        let line = format!("caricature {shape} ellipsoid -k 16 --region 13,0,0,2");
        let plain = red(&drawn(&desk, &format!("{line} --size 200x100")), 0, 0);
        assert!(plain > 200, "{shape}: {plain}");
        let show = "--size 600x200 --sweep=-0.3,-0.6 --show before,after,coordinate,steps,region";
        let sheet = drawn(&desk, &format!("{line} {show}"));
        for (row, column) in (0..2).flat_map(|row| (0..6).map(move |column| (row, column))) {
            let found = red(&sheet, row, column);
            // The last is a heat map.
            let expected = if column == 5 { 0..1 } else { plain / 3..3 * plain };
            assert!(expected.contains(&found), "{shape}, {row}, {column}: {found}, {plain}");
        }
        desk.ok(&format!("{line} --turntable {film} --turn-secs 0.1 --size 100x100"));
        let frame = std::fs::read(desk.path(film).join("frame-00000.png")).unwrap();
        let found = red(&chladni_view::Picture::decode(&frame).unwrap(), 0, 0);
        assert!(found > plain / 5, "{shape}: {found}, {plain}");
    }
}

#[test]
fn a_picture_that_fails_does_not_take_the_mesh_with_it() {
    let desk = Desk::new();
    // A folder in the place of the first frame.
    std::fs::create_dir_all(desk.path("turn/frame-00000.png")).unwrap();
    for out in ["out.ply", "out.obj"] {
        let film = "--turntable turn --turn-secs 0.1 --size 64x64 --ink";
        let run = desk.run(&format!("caricature shape.obj ellipsoid -k 16 -o {out} {film}"));
        assert!(!run.status.success());
        assert_eq!(desk.mesh(out).triangles.len(), desk.mesh("shape.obj").triangles.len());
    }
}

#[test]
fn a_picture_shows_the_panels_asked_for_in_a_row_for_each_mu() {
    let desk = Desk::new();
    desk.ok(
        "caricature shape.obj ellipsoid -o out.ply --harmonics 32 --region 13,0,0,2 --render p.png --size 1400x400 \
         --show painted,region,coordinate,normal,distance,rest,after --sweep=-0.3,-3",
    );
    let bytes = std::fs::read(desk.path("p.png")).unwrap();
    let picture = chladni_view::Picture::decode(&bytes).unwrap();
    assert_eq!((picture.width, picture.height), (1400, 400));
    let panel = |row: u32, column: u32| -> Vec<[u8; 4]> {
        let pixels = (0..200).flat_map(|y| (0..200).map(move |x| (x, y)));
        pixels.map(|(x, y)| picture.pixel(200 * column + x, 200 * row + y).unwrap()).collect()
    };
    // χ01 and χ lie on the shape, which μ does not change; the results differ, from row to row and
    // from model to model.
    for column in 0..2 {
        assert!(panel(0, column) == panel(1, column));
    }
    for column in 2..7 {
        assert!(panel(0, column) != panel(1, column));
    }
    for (a, b) in [(0, 1), (2, 3), (3, 4), (2, 4)] {
        assert!(panel(1, a) != panel(1, b));
    }
    // The shape at rest is there as dark dots.
    let (dotted, plain) = (panel(1, 5), panel(1, 6));
    let is_darker =
        |(with, without): &(&[u8; 4], &[u8; 4])| (0..3).all(|c| with[c].saturating_add(15) < without[c]);
    assert!(dotted.iter().zip(&plain).filter(is_darker).count() > 10);
}

#[test]
fn a_row_of_a_sweep_is_what_its_mu_alone_gives_and_is_described() {
    let desk = Desk::new();
    let mut rough = lump(1.0);
    rough.positions.iter_mut().for_each(|p| p[2] += 0.2 * (8.0 * p[1]).sin());
    save_mesh(&rough, &desk.path("rough.obj")).unwrap();
    let line = "caricature shape.obj rough.obj --match icp -k 32 --size 320x160 --show after";
    let alone = desk.ok(&format!("{line} --mu 1 --render alone.png"));
    let swept = desk.ok(&format!("{line} --sweep=1 --render swept.png"));
    let read = |name: &str| std::fs::read(desk.path(name)).unwrap();
    assert!(read("alone.png") == read("swept.png"), "the scale curve is that of the default μ");
    let moves = alone.lines().find_map(|said| said.strip_prefix("caricature: ")).unwrap();
    assert!(swept.contains(&format!("μ = 1: {moves}")) && !swept.contains("caricature: "), "{swept}");
    // The mesh is of another μ.
    let written = desk.ok(&format!("{line} --sweep=1 --render swept.png -o out.ply"));
    assert!(written.contains(&format!("μ = 1: {moves}")) && written.contains("caricature: "), "{written}");
}

#[test]
fn a_picture_is_drawn_in_ink_as_svg_or_png_and_options_of_ink_are_checked() {
    let desk = Desk::new();
    let line = "caricature shape.obj ellipsoid -o out.ply -k 32 --mu -1 --size 320x160";
    let read = |name: &str| std::fs::read(desk.path(name)).unwrap();
    desk.ok(&format!("{line} --render both.svg"));
    let svg = String::from_utf8(read("both.svg")).unwrap();
    assert!(svg.starts_with("<svg ") && svg.contains("width=\"320\"") && svg.contains("<g id=\"contours\""));
    desk.ok(&format!("{line} --render again.svg --ink"));
    assert_eq!(read("again.svg"), read("both.svg"));
    desk.ok(&format!("{line} --render ink.png --ink --ink-colors #800000,#ffffff --ink-hatching 0"));
    let picture = chladni_view::Picture::decode(&read("ink.png")).unwrap();
    assert_eq!((picture.width, picture.height, picture.pixel(0, 0)), (320, 160, Some([255; 4])));
    // Nothing but shades between the ink and the paper, and both of them.
    assert!(picture.rgba.chunks(4).all(|p| p[1] == p[2] && p[0] >= p[1]));
    assert!(picture.rgba.chunks(4).any(|p| p[1] < 60));
    desk.ok(&format!("{line} --render tones.svg --ink-tones 3"));
    let tones = String::from_utf8(read("tones.svg")).unwrap();
    assert!(tones.contains("<g id=\"tones\"") && !svg.contains("tones"));
    // Before and after, three tones each, of which the lightest is the paper.
    assert_eq!(tones.matches("evenodd").count(), 4);
    desk.ok(&format!("{line} --turntable turn.gif --turn-secs 0.2 --ink-tones 2"));
    desk.ok("caricature shape.obj ellipsoid -k 32 --turntable plain.gif --turn-secs 0.1 --size 64x64");
    assert!(read("turn.gif").starts_with(b"GIF89a") && read("plain.gif").starts_with(b"GIF89a"));
    // Before and after have lines of one width, or of widths that follow the exaggeration.
    desk.ok(&format!("{line} --render wide.svg --show after,coordinate --ink-exaggeration"));
    assert_ne!(read("wide.svg"), read("both.svg"));
    let turning = format!("{line} --turn-secs 0.1 --turntable");
    desk.ok(&format!("{turning} even.gif --ink"));
    desk.ok(&format!("{turning} wide.gif --ink-exaggeration"));
    assert_ne!(read("wide.gif"), read("even.gif"));
    for (options, said) in [
        ("--render x.svg --show painted", "ink draws shapes alone"),
        ("--render x.svg --ink-colors red,blue", "write two colors"),
        ("--render x.png --ink-hatching 2", "from 0 to 1"),
        ("--render x.jpg", "a picture ends in .png or .svg"),
        ("--render x.svg --ink-tones 5", "5"),
        ("--turntable x.jpg", "film"),
        ("--render x.png --turntable ./x.png", "two results"),
        ("--ink", "--render"),
    ] {
        let message = desk.refused(&format!("{line} {options}"));
        assert!(message.contains(said), "{options}: {message}");
        assert!(!desk.path("x.svg").exists());
    }
}

#[test]
fn a_gallery_is_drawn_bred_and_one_of_it_becomes_a_mesh() {
    let desk = Desk::new();
    let gallery = "caricature shape.obj --gallery -k 48 --seed 3";
    let line = format!("{gallery} --size 320x240");
    let first = desk.ok(&format!("{line} -o first.png"));
    assert_eq!(first.lines().count(), 13, "{first}");
    assert_eq!(first, desk.ok(&format!("{line} -o other.png")).replace("other", "first"));
    let bred = desk.ok(&format!("{line} --choose 2,5 --lock model -o bred.png"));
    assert_ne!(first.lines().next(), bred.lines().next());
    for name in ["first.png", "bred.png"] {
        let picture = chladni_view::Picture::decode(&std::fs::read(desk.path(name)).unwrap()).unwrap();
        assert_eq!((picture.width, picture.height), (320, 240));
    }
    let single = desk.ok(&format!("{gallery} --choose 2,5 --lock model --variant 7 -o seventh.ply"));
    assert!(bred.contains(single.lines().next().unwrap()), "{single}");
    assert!(largest(&desk.mesh("seventh.ply").positions, &desk.mesh("shape.obj").positions) > 0.01);
    desk.ok(&format!("{gallery} --surprise -o surprise.glb"));
    assert!(desk.refused(&format!("{line} --choose 13 -o x.png")).contains("from 1 to 12"));
    // Unless a seed is given, it is 1, as in the window and on the page.
    let variant = |seed: &str| {
        desk.ok(&format!("caricature shape.obj --gallery -k 48 {seed} --variant 1 -o first.ply"));
        desk.mesh("first.ply").positions
    };
    assert_eq!(variant(""), variant("--seed 1"));
    assert!(desk.refused(&format!("{line} -o x.obj")).contains(".png"));
    assert!(desk.refused(&format!("{line} --lock nose -o x.png")).contains("templates"));
}

#[test]
fn a_picture_may_show_the_template_as_a_ghost() {
    let desk = Desk::new();
    let line = "caricature shape.obj ellipsoid --harmonics 32 --mu -1 --render p.png --size 400x200";
    desk.ok(&format!("{line} --show after,ghost"));
    let picture = chladni_view::Picture::decode(&std::fs::read(desk.path("p.png")).unwrap()).unwrap();
    // The ghost is bluish: red gives way to blue, where the shape was warm clay.
    let warm = |column: u32| {
        let pixels = (0..200).flat_map(|y| (0..200).map(move |x| (200 * column + x, y)));
        pixels.map(|(x, y)| picture.pixel(x, y).unwrap()).filter(|p| p[0] > p[2] + 25).count()
    };
    assert!(warm(0) > 4000 && warm(1) < warm(0) / 2, "{} {}", warm(0), warm(1));
    let said = desk.refused("caricature shape.obj ellipsoid --harmonics 32 --render p.svg --show ghost");
    assert!(said.contains("ghost"), "{said}");
}

/// A lump with a texture, `anna.obj` and `anna.png`, in a folder of the desk; the texture's bytes.
fn textured(desk: &Desk, folder: &str) -> Vec<u8> {
    let mesh = lump(1.0);
    let text = chladni_testdata::textured_obj(&mesh.positions, &mesh.triangles, "anna.mtl", |_| 0.5);
    let at = |name: &str| desk.path(folder).join(name);
    std::fs::create_dir_all(desk.path(folder)).unwrap();
    std::fs::write(at("anna.obj"), text).unwrap();
    std::fs::write(at("anna.mtl"), "newmtl skin\nmap_Kd anna.png\nmap_Bump bumps.png\n").unwrap();
    let skin = chladni_view::Picture::filled(2, 2, [200, 90, 60, 255]).to_png().unwrap();
    for name in ["anna.png", "bumps.png"] {
        std::fs::write(at(name), &skin).unwrap();
    }
    skin
}

#[test]
fn a_picture_replaces_no_texture_of_a_mesh_that_is_read() {
    let desk = Desk::new();
    let skin = textured(&desk, ".");
    for line in [
        "caricature anna.obj ellipsoid -k 16 --render anna.png",
        "caricature anna.obj ellipsoid -k 16 --render bumps.png",
        "caricature anna.obj ellipsoid -k 16 --turntable anna.png --turn-secs 0.1",
        "caricature shape.obj anna.obj -k 16 --match same --render anna.png",
        "caricature anna.obj --gallery -k 16 -o anna.png",
        "match anna.obj shape.obj --method same --render anna.png",
        "match shape.obj anna.obj --method same --render anna.png",
        "parts anna.obj --render anna.png",
        "parts anna.obj --level 0.3 --render anna.png",
        "symmetry anna.obj -k 16 --render anna.png",
    ] {
        let said = desk.refused(line);
        assert!(said.contains("is read, too, and would be replaced"), "{line}: {said}");
        for name in ["anna.png", "bumps.png"] {
            assert!(std::fs::read(desk.path(name)).unwrap() == skin, "{line}");
        }
    }
    // A picture of another name, and one of an earlier run, are none of its textures.
    for _ in 0..2 {
        desk.ok("caricature anna.obj ellipsoid -k 16 --render wild.png --size 64x32");
    }
}

#[test]
fn a_picture_and_a_texture_of_one_name_are_two_files() {
    let desk = Desk::new();
    let skin = textured(&desk, "scans");
    std::fs::create_dir(desk.path("out")).unwrap();
    let line = "caricature scans/anna.obj ellipsoid -k 16 -o out/anna.obj --render out/anna.png --size 64x32";
    for _ in 0..2 {
        desk.ok(line);
        let picture = std::fs::read(desk.path("out/anna.png")).unwrap();
        let picture = chladni_view::Picture::decode(&picture).unwrap();
        assert_eq!((picture.width, picture.height), (64, 32));
        let result = desk.mesh("out/anna.obj");
        assert!(*result.base_color_texture().unwrap().bytes == *skin, "the texture is what it was");
    }
}

#[test]
fn what_no_picture_can_show_is_refused_before_a_mesh_is_written() {
    let desk = Desk::new();
    for (options, why) in [
        ("--render x.svg --show after,rest", "ink draws shapes alone"),
        ("--render x.png --ink --show ghost", "ink draws shapes alone"),
        ("--render x.png --ink-tones 3 --show painted", "ink draws shapes alone"),
        ("--render x.svg --show region", "ink draws shapes alone"),
        ("--render x.png --sweep=-500", "-100 to 100"),
        ("--render x.png --sweep=-1,nan", "-100 to 100"),
    ] {
        let said = desk.refused(&format!("caricature shape.obj ellipsoid -k 16 -o out.ply {options}"));
        assert!(said.contains(why), "{options}: {said}");
        assert!(!desk.path("out.ply").exists(), "{options}");
    }
}
