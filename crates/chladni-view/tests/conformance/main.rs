//! The processor and the graphics device draw the same pictures.
#![allow(
    clippy::unwrap_used,
    clippy::print_stderr,
    reason = "a panic is how a test fails, and a skipped one says so"
)]

mod figures;
mod lookup;
#[path = "../shapes/mod.rs"]
mod shapes;

use chladni_view::{
    Answer, Background, BrushRing, Camera, Canvas, Cell, ColorMap, Curve, Device, Figure, Finish, Floor, Gpu,
    Gradient, Grain, Grains, ItemBuffers, Lights, Look, Marker, Material, Mood, NodalLines, Paint, Palette,
    Panorama, Picture, Projection, Rect, Renderer, RestShape, Scale, Skin, Surroundings, Topology,
    VertexPaint, View, ViewError, Wire, layout, smooth_normals,
};
use figures::{LOOKS, Model};
use shapes::{gpu, sphere};

/// Pixels that differ by more than `limit` from every pixel around the same place in `other`.
fn misplaced(picture: &Picture, other: &Picture, limit: u8) -> usize {
    let (width, height) = (picture.width as i32, picture.height as i32);
    let at = |p: &Picture, x: i32, y: i32| {
        p.pixel(x.clamp(0, width - 1) as u32, y.clamp(0, height - 1) as u32).unwrap()
    };
    let all = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    all.filter(|&(x, y)| {
        let here = at(picture, x, y);
        // Each channel within what is around, give or take: an edge may lie a pixel off.
        let around: Vec<[u8; 4]> = (-1..=1)
            .flat_map(|dy| (-1..=1).map(move |dx| (dx, dy)))
            .map(|(dx, dy)| at(other, x + dx, y + dy))
            .collect();
        (0..4).any(|k| {
            let low = around.iter().map(|p| p[k]).min().unwrap().saturating_sub(limit);
            let high = around.iter().map(|p| p[k]).max().unwrap().saturating_add(limit);
            !(low..=high).contains(&here[k])
        })
    })
    .count()
}

/// The picture's colors times their alpha, as both backends draw them and as they look when the picture is laid over
/// something. [`Canvas::read`] divides them by alpha, which multiplies their rounding errors: at an alpha of 3 by 85.
fn premultiplied(mut picture: Picture) -> Picture {
    for pixel in picture.rgba.as_chunks_mut::<4>().0 {
        let alpha = u32::from(pixel[3]);
        for channel in &mut pixel[..3] {
            *channel = ((u32::from(*channel) * alpha + 127) / 255) as u8;
        }
    }
    picture
}

#[test]
fn every_look_is_the_same_at_every_size() {
    let Some(gpu) = gpu() else { return };
    let devices = [Device::Processor, Device::from(&gpu)];
    let folder = std::env::var_os("CHLADNI_PICTURES").map(std::path::PathBuf::from);
    for (rings, sizes) in [(40, vec![[240, 200], [97, 61]]), (7, vec![[200, 160], [48, 40]])] {
        let models = devices.each_ref().map(|device| Model::new(device, rings));
        for size in sizes {
            for (name, look) in LOOKS {
                let [mine, theirs] = models.each_ref().map(|model| look(model, size));
                if let Some(folder) = &folder {
                    let mut both = Picture::filled(2 * size[0], size[1], [255, 255, 255, 255]);
                    both.paste(&mine, 0, 0);
                    both.paste(&theirs, size[0], 0);
                    let file = folder.join(format!("{name} {rings} {}x{}.png", size[0], size[1]));
                    std::fs::write(file, both.to_png().unwrap()).unwrap();
                }
                let [mine, theirs] = [mine, theirs].map(premultiplied);
                let differences: Vec<u8> =
                    mine.rgba.iter().zip(&theirs.rgba).map(|(a, b)| a.abs_diff(*b)).collect();
                let mean = differences.iter().map(|d| f64::from(*d)).sum::<f64>() / differences.len() as f64;
                let off = misplaced(&mine, &theirs, 20);
                let pixels = (size[0] * size[1]) as usize;
                eprintln!("{name}, {rings} rings, {size:?}: {mean:.3} of 255, {off} of {pixels} off");
                assert!(mean <= 1.5, "{name}, {rings} rings, {size:?}: {mean} of 255 on average");
                assert!(off <= 2 + pixels / 500, "{name}, {rings} rings, {size:?}: {off} pixels of {pixels}");
            }
        }
    }
}

#[test]
fn threads_change_no_bit() {
    let model = Model::new(&Device::Processor, 30);
    for (name, look) in LOOKS {
        let pictures = [1, 2, 4].map(|threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| look(&model, [230, 170]))
        });
        assert!(pictures[0] == pictures[1] && pictures[0] == pictures[2], "{name}");
    }
}

/// Draws `triangles` over `positions` alone on a transparent ground.
fn alone(
    positions: &[[f32; 3]],
    triangles: &[[u32; 3]],
    camera: Camera,
    [width, height]: [u32; 2],
) -> Picture {
    let device = Device::Processor;
    let topology = Topology::new(&device, positions.len(), triangles).unwrap();
    let buffers = ItemBuffers::new(&device, positions.len(), 1);
    buffers.write(&device, 0, positions, &smooth_normals(positions, triangles)).unwrap();
    let figures = [Figure::new(&topology, &buffers, 0)];
    let cell = Cell {
        viewport: Rect::of_size(width, height),
        camera,
        lights: Lights::STUDIO,
        background: Background::TRANSPARENT,
        figures: &figures,
        markers: &[],
    };
    let canvas = Canvas::new(&device, width, height).unwrap();
    Renderer::new(&device).draw(&canvas, &[cell]).unwrap();
    canvas.read(&device).unwrap()
}

fn covered(picture: &Picture) -> usize {
    picture.rgba.chunks(4).filter(|pixel| pixel[3] == 255).count()
}

#[test]
fn nasty_shapes_are_drawn_as_far_as_they_go() {
    let camera = Camera::default();
    let square = [[-0.5, -0.5, 0.0], [0.5, -0.5, 0.0], [0.5, 0.5, 0.0], [-0.5, 0.5, 0.0]];
    let whole = covered(&alone(&square, &[[0, 1, 2], [0, 2, 3]], camera, [64, 64]));
    assert!(whole > 400);
    // Beside a good square: no number, infinite, without area, behind the eye, through it, huge.
    let mut positions = square.to_vec();
    positions.extend([
        [f32::NAN, 0.0, 0.0],
        [f32::INFINITY, 0.0, 0.0],
        [f32::MAX, f32::MIN, f32::MAX],
        [0.1, 0.1, 50.0],
        [0.2, 0.1, 50.0],
        [0.1, 0.2, 60.0],
    ]);
    let broken =
        [[0, 1, 2], [0, 2, 3], [0, 1, 4], [1, 2, 5], [3, 2, 6], [0, 0, 1], [1, 1, 1], [7, 8, 9], [6, 6, 6]];
    let drawn = covered(&alone(&positions, &broken, camera, [64, 64]));
    assert!(drawn >= whole, "{drawn} of {whole}");
    // A floor that goes through the eye and to the horizon: the lower half, except what is too near.
    let floor = [[-1e4, -0.5, -1e4], [1e4, -0.5, -1e4], [1e4, -0.5, 1e4], [-1e4, -0.5, 1e4]];
    let far = Camera { reach: 1e3, ..camera };
    let picture = alone(&floor, &[[0, 1, 2], [0, 2, 3]], far, [64, 64]);
    assert!(picture.pixel(32, 40).unwrap()[3] == 255 && picture.pixel(32, 20).unwrap()[3] == 0);
    // One pixel, and a row of them.
    assert_eq!(covered(&alone(&square, &[[0, 1, 2], [0, 2, 3]], camera, [1, 1])), 0);
    let near = Camera { distance: 1.0, ..camera };
    assert_eq!(covered(&alone(&square, &[[0, 1, 2], [0, 2, 3]], near, [1, 1])), 1);
    // A quarter of a pixel on either side of the middle: one sample each.
    let row = alone(&square, &[[0, 1, 2], [0, 2, 3]], camera, [300, 1]);
    assert_eq!([149, 150].map(|x| row.pixel(x, 0).unwrap()[3]), [64, 64]);
}

/// Each of twelve cells of one pixel is drawn as it is alone.
#[test]
fn a_gallery_of_single_pixels() {
    shapes::on_each_device(|device| {
        let model = Model::new(device, 7);
        let figures = [model.figure()];
        let cell = |i: usize, viewport| {
            let camera = Camera { yaw_rad: i as f32, distance: 0.4 * model.camera.distance, ..model.camera };
            // The map of shadows is as fine as all cells leave room for.
            let lights = Lights { shadow: 0.0, ..Lights::STUDIO };
            Cell { viewport, camera, lights, ..model.cell(&figures, [1, 1]) }
        };
        let places = layout::grid(Rect::of_size(4, 3), 3, 4, 0, 12);
        let cells: Vec<Cell<'_>> = places.iter().enumerate().map(|(i, at)| cell(i, *at)).collect();
        let together = model.draw(4, 3, &cells);
        let mut colors = std::collections::HashSet::new();
        for (i, at) in places.iter().enumerate() {
            assert_eq!([at.width, at.height], [1, 1]);
            let here = together.pixel(at.x, at.y).unwrap();
            let alone = model.draw(1, 1, &[cell(i, Rect::of_size(1, 1))]).pixel(0, 0).unwrap();
            let off = here.iter().zip(alone).map(|(a, b)| a.abs_diff(b)).max().unwrap();
            assert!(off <= 1, "cell {i} on {device:?}: {here:?} together, {alone:?} alone");
            colors.insert(here);
        }
        assert!(colors.len() >= 8, "they show different sides: {colors:?}");
    });
}

/// A fine grid of one plane, seen from askew: not a pixel inside is missing or drawn twice.
#[test]
fn what_is_watertight_has_no_holes() {
    let side = 90_u32;
    let positions: Vec<[f32; 3]> = (0..side * side)
        .map(|i| [(i % side) as f32, (i / side) as f32].map(|c| 2.2 * c / (side - 1) as f32 - 1.1))
        .map(|[x, y]| [x + 0.003 * (40.0 * y).sin(), y, 0.0])
        .collect();
    let quads = (0..side - 1).flat_map(|y| (0..side - 1).map(move |x| y * side + x));
    let triangles: Vec<[u32; 3]> =
        quads.flat_map(|i| [[i, i + 1, i + side + 1], [i, i + side + 1, i + side]]).collect();
    let camera = Camera { yaw_rad: 0.4, pitch_rad: 0.3, distance: 2.2, ..Camera::default() };
    let picture = alone(&positions, &triangles, camera, [300, 300]);
    // From the middle of the picture to its edge it is all sheet.
    let inside = (100..200).flat_map(|y| (100..200).map(move |x| (x, y)));
    assert!(inside.into_iter().all(|(x, y)| picture.pixel(x, y).unwrap()[3] == 255));
}

#[test]
fn two_million_triangles_and_a_picture_of_8k() {
    let (positions, triangles) = sphere(710);
    assert!(triangles.len() > 2_000_000);
    let mut camera = Camera::default();
    camera.fit(positions.iter().copied(), 1.0, 0.9);
    let small = alone(&positions, &triangles, camera, [200, 200]);
    let disc = std::f64::consts::PI * 90.0 * 90.0;
    assert!((covered(&small) as f64 / disc - 1.0).abs() < 0.03, "{}", covered(&small));
    let square = [[-0.5, -0.5, 0.0], [0.5, -0.5, 0.0], [0.5, 0.5, 0.0], [-0.5, 0.5, 0.0]];
    let triangles = [[0, 1, 2], [0, 2, 3]];
    let small = covered(&alone(&square, &triangles, Camera::default(), [960, 540])) as f64;
    let large = covered(&alone(&square, &triangles, Camera::default(), [7680, 4320])) as f64;
    assert!((large / (64.0 * small) - 1.0).abs() < 0.02, "{large} {small}");
}

#[test]
fn what_does_not_fit_is_an_error() {
    let device = Device::Processor;
    assert!(matches!(Canvas::new(&device, 0, 5), Err(ViewError::Size { .. })));
    assert!(matches!(Canvas::new(&device, 1 << 20, 5), Err(ViewError::Size { .. })));
    let canvas = Canvas::new(&device, 8, 8).unwrap();
    assert!(canvas.view().is_err());
    let model = Model::new(&device, 4);
    let cell = Cell { viewport: Rect { x: 4, y: 0, width: 8, height: 8 }, ..model.cell(&[], [8, 8]) };
    assert!(matches!(Renderer::new(&device).draw(&canvas, &[cell]), Err(ViewError::Shape(_))));
    let Some(gpu) = gpu() else { return };
    // Buffers of one device cannot be drawn by the other, and an error says so.
    let figures = [model.figure()];
    let cell = model.cell(&figures, [8, 8]);
    let theirs = Canvas::new(&gpu, 8, 8).unwrap();
    assert!(matches!(Renderer::new(&gpu).draw(&theirs, &[cell]), Err(ViewError::Shape(_))));
    assert!(matches!(Renderer::new(&gpu).draw(&canvas, &[]), Err(ViewError::Shape(_))));
    assert!(matches!(model.buffers.write(&gpu, 0, &[], &[]), Err(ViewError::Shape(_))));
}

#[test]
fn a_rest_of_another_shape_is_refused() {
    let model = Model::new(&Device::Processor, 7);
    let rest = RestShape::new(&Device::Processor, &[[0.0; 3]], &[0.0], &[0.0]).unwrap();
    let figures = [Figure { paint: Paint::Answer(&rest, Answer::MOVED), ..model.figure() }];
    let canvas = Canvas::new(&Device::Processor, 20, 20).unwrap();
    let drawn = Renderer::new(&Device::Processor).draw(&canvas, &[model.cell(&figures, [20, 20])]);
    assert!(matches!(drawn, Err(ViewError::Shape(_))));
    assert!(matches!(RestShape::new(&Device::Processor, &[[0.0; 3]], &[0.0], &[]), Err(ViewError::Shape(_))));
}

/// Without an item that says where a figure was lately, speed colors nothing; and an item that is not there is refused.
#[test]
fn what_is_not_known_to_move_has_no_speed() {
    let model = Model::new(&Device::Processor, 12);
    let draw = |answer, lag| {
        let figures = [Figure { lag, ..model.answering(answer) }];
        model.draw(60, 50, &[model.cell(&figures, [60, 50])])
    };
    let still = Answer { travel: 0.0, ..Answer::MOVED };
    let fast = Answer { haste: 5.0, spark: 3.0, ..still };
    assert_eq!(draw(fast, None), draw(still, None));
    assert_ne!(draw(fast, Some(0)), draw(still, Some(0)));
    let figures = [Figure { lag: Some(2), ..model.answering(fast) }];
    let canvas = Canvas::new(&Device::Processor, 20, 20).unwrap();
    let drawn = Renderer::new(&Device::Processor).draw(&canvas, &[model.cell(&figures, [20, 20])]);
    assert!(matches!(drawn, Err(ViewError::Shape(_))));
}

/// Bright surfaces glow, the corners are darker, and a picture long after another shows no trail of it.
#[test]
fn a_finish_does_what_it_says() {
    let model = Model::new(&Device::Processor, 30);
    let size = [160, 160];
    let figures = [model.figure()];
    let cell = Cell { background: Background::plain([90; 3]), ..model.cell(&figures, size) };
    let canvas = Canvas::new(&Device::Processor, size[0], size[1]).unwrap();
    let mut renderer = Renderer::new(&Device::Processor);
    let mut picture = |finish: &Finish, at_secs: f64| {
        renderer.draw_finished(&canvas, &[cell], finish, at_secs).unwrap();
        canvas.read(&Device::Processor).unwrap()
    };
    let bare = picture(&Finish::NOTHING, 0.0);
    let light = |picture: &Picture| picture.rgba.iter().map(|c| u64::from(*c)).sum::<u64>();
    let bloom = picture(&Finish { bloom: 1.0, bloom_from: 0.3, ..Finish::NOTHING }, 0.0);
    assert!(light(&bloom) > light(&bare));
    let rim = picture(&Finish { vignette: 1.0, ..Finish::NOTHING }, 0.0);
    assert!(rim.pixel(1, 1).unwrap()[0] < 20 && rim.pixel(80, 80) == bare.pixel(80, 80));
    let grain = Finish { grain: 0.2, ..Finish::NOTHING };
    assert_eq!(picture(&grain, 1.01), picture(&grain, 1.02));
    assert_ne!(picture(&grain, 1.01), picture(&grain, 1.06));
    let trail = Finish { trail_secs: 0.2, ..Finish::NOTHING };
    picture(&trail, 2.0);
    assert_eq!(picture(&trail, 9.0), bare);
}

/// A camera that moves takes its trails along; one that cuts leaves them behind.
#[test]
fn there_are_no_trails_across_a_cut() {
    shapes::on_each_device(|device| {
        let model = Model::new(device, 12);
        let figures = [model.figure()];
        let trail = Finish { trail_secs: 0.2, ..Finish::NOTHING };
        // Nor in the picture after the one that is cut to.
        let after = |first: Camera, then: Camera| {
            let canvas = Canvas::new(device, 80, 60).unwrap();
            let mut renderer = Renderer::new(device);
            for (camera, at_secs) in [(first, 1.0), (then, 1.04), (then, 1.08)] {
                let cell = Cell { camera, ..model.cell(&figures, [80, 60]) };
                renderer.draw_finished(&canvas, &[cell], &trail, at_secs).unwrap();
            }
            canvas.read(device).unwrap()
        };
        let here = model.camera;
        let alone = after(here, here);
        let nearer = |share: f32| Camera { distance: share * here.distance, ..here };
        assert!(after(nearer(0.6), here) == alone, "a cut");
        assert!(
            after(Camera { yaw_rad: here.yaw_rad + 1.0, ..here }, here) == alone,
            "a cut to another side"
        );
        assert!(after(nearer(0.95), here) != alone, "a push-in");
    });
}

/// A sheet that faces the viewer stays as it is in focus and is softened out of it, and a lens that sees everything sharp
/// changes no bit.
#[test]
fn what_is_in_focus_stays_as_it_is() {
    let device = Device::Processor;
    let size = [256, 192];
    let side = 24_u32;
    let positions: Vec<[f32; 3]> = (0..side * side)
        .map(|i| [i % side, i / side].map(|c| c as f32 / (side - 1) as f32 - 0.5))
        .map(|[x, y]| [1.4 * x, 1.4 * y, 0.0])
        .collect();
    let triangles: Vec<[u32; 3]> = (0..side * (side - 1))
        .filter(|i| i % side != side - 1)
        .flat_map(|i| [[i, i + 1, i + side], [i + 1, i + side + 1, i + side]])
        .collect();
    let topology = Topology::new(&device, positions.len(), &triangles).unwrap();
    let buffers = ItemBuffers::new(&device, positions.len(), 1);
    buffers.write(&device, 0, &positions, &smooth_normals(&positions, &triangles)).unwrap();
    let colors = VertexPaint::new(&device, positions.len());
    let checks: Vec<[u8; 4]> = (0..side * side)
        .map(|i| if (i % side + i / side).is_multiple_of(2) { [240; 4] } else { [20, 40, 60, 255] })
        .collect();
    colors.write_colors(&device, &checks).unwrap();
    let figures = [Figure { paint: Paint::Colors(&colors), ..Figure::new(&topology, &buffers, 0) }];
    let cell = Cell {
        viewport: Rect::of_size(size[0], size[1]),
        camera: Camera { reach: 1.0, ..Camera::default() },
        lights: Lights::STUDIO,
        background: Background::PAPER,
        figures: &figures,
        markers: &[],
    };
    let canvas = Canvas::new(&device, size[0], size[1]).unwrap();
    let mut renderer = Renderer::new(&device);
    let mut picture = |blur: f32, focus: f32| {
        renderer.draw_finished(&canvas, &[cell], &Finish { blur, focus, ..Finish::NOTHING }, 0.0).unwrap();
        canvas.read(&device).unwrap()
    };
    let bare = picture(0.0, 0.0);
    // The sheet's own pixels, away from its edge.
    let inside = |picture: &Picture| -> Vec<[u8; 4]> {
        (60..130)
            .flat_map(|y| (95..160).map(move |x| (x, y)))
            .map(|(x, y)| picture.pixel(x, y).unwrap())
            .collect()
    };
    let contrast = |picture: &Picture| -> u32 {
        inside(picture).windows(2).map(|pair| u32::from(pair[0][0].abs_diff(pair[1][0]))).sum()
    };
    assert_eq!(inside(&picture(1.0, 0.0)), inside(&bare));
    assert_eq!(inside(&picture(1.0, 0.15)), inside(&bare));
    // Behind the focus, and before it.
    assert!(contrast(&picture(1.0, 0.4)) < contrast(&bare));
    assert!(2 * contrast(&picture(1.0, 0.8)) < contrast(&bare));
    assert!(2 * contrast(&picture(1.0, -0.8)) < contrast(&bare));
    assert_eq!(picture(0.0, 1.0), bare);
}

/// A sheet that faces the viewer, drawn alone.
fn sheets(device: &Device, positions: &[[f32; 3]], triangles: &[[u32; 3]], opacity: f32) -> Picture {
    let size = [96, 80];
    let topology = Topology::new(device, positions.len(), triangles).unwrap();
    let buffers = ItemBuffers::new(device, positions.len(), 1);
    buffers.write(device, 0, positions, &vec![[0.0, 0.0, 1.0]; positions.len()]).unwrap();
    let figures = [Figure { opacity, ..Figure::new(&topology, &buffers, 0) }];
    let cell = Cell {
        viewport: Rect::of_size(size[0], size[1]),
        camera: Camera::default(),
        lights: Lights { shadow: 0.0, ..Lights::STUDIO },
        background: Background::TRANSPARENT,
        figures: &figures,
        markers: &[],
    };
    let canvas = Canvas::new(device, size[0], size[1]).unwrap();
    Renderer::new(device).draw(&canvas, &[cell]).unwrap();
    canvas.read(device).unwrap()
}

/// A square of this middle.
fn square([x, y, z]: [f32; 3]) -> [[f32; 3]; 4] {
    [[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]].map(|[dx, dy]| [x + dx, y + dy, z])
}

#[test]
fn of_surfaces_in_one_place_the_first_is_seen() {
    shapes::on_each_device(|device| {
        let model = Model::new(device, 12);
        let size = [120, 100];
        let draw = |figures: &[Figure<'_>]| model.draw(size[0], size[1], &[model.cell(figures, size)]);
        let ghost = Figure { opacity: 0.5, ..model.figure() };
        let dark = Figure { material: Material::DARK, ..ghost };
        for first in [model.figure(), ghost] {
            let off = misplaced(&draw(&[first, dark]), &draw(&[first]), 20);
            let opacity = first.opacity;
            assert!(off <= 2, "a ghost of a shape of opacity {opacity} on {device:?}: {off} pixels");
        }
        // As programs write faces that have two sides.
        let (corners, fronts) = (square([0.0; 3]), [[0, 1, 2], [0, 2, 3]]);
        let backs = [[0, 2, 1], [0, 3, 2]];
        let both = [fronts, backs].concat();
        for (opacity, first) in [(1.0, fronts), (0.5, backs)] {
            let draw = |triangles: &[[u32; 3]]| sheets(device, &corners, triangles, opacity);
            assert!(draw(&both) == draw(&first), "an opacity of {opacity} on {device:?}");
        }
    });
}

#[test]
fn of_the_parts_of_a_ghost_the_nearest_is_seen_in_any_order() {
    shapes::on_each_device(|device| {
        let corners = [square([0.0, 0.0, 0.2]), square([0.3, 0.1, -0.2])].concat();
        let (near, far) = ([[0, 1, 2], [0, 2, 3]], [[4, 5, 6], [4, 6, 7]]);
        let draw = |triangles: &[[u32; 3]]| sheets(device, &corners, triangles, 0.5);
        let ordered = draw(&[near, far].concat());
        assert!(ordered == draw(&[far, near].concat()), "{device:?}");
        assert_eq!(ordered.pixel(48, 40), draw(&near).pixel(48, 40), "{device:?}");
        assert_ne!(ordered, draw(&near), "the far one is seen beside it");
    });
}

#[test]
fn markers_that_are_seen_lie_over_hidden_ones_in_any_order() {
    shapes::on_each_device(|device| {
        let model = Model::new(device, 12);
        let figures = [model.figure()];
        let marker = |position, color| Marker { position, radius_px: 7.0, color };
        let seen = marker([0.0, 0.0, 1.3], [255, 0, 0, 255]);
        let hidden = marker([0.0, 0.1, 0.0], [0, 120, 0, 255]);
        let draw = |markers: &[Marker]| {
            let cell = Cell { camera: Camera::default(), markers, ..model.cell(&figures, [120, 100]) };
            model.draw(120, 100, &[cell])
        };
        assert!(draw(&[seen, hidden]) == draw(&[hidden, seen]), "{device:?}");
        assert_ne!(draw(&[seen, hidden]), draw(&[seen]), "{device:?}");
    });
}

/// Rounding makes the pixels of one of these sizes a little longer than high.
#[test]
fn a_picture_behind_is_as_sharp_on_both() {
    let Some(gpu) = gpu() else { return };
    let checkers = (0..1000 * 700).flat_map(|i| {
        let light = (i % 1000 / 25 + i / 1000 / 25) % 2 == 0;
        if light { [230, 220, 200, 255] } else { [30, 40, 60, 255] }
    });
    let behind = Picture { width: 1000, height: 700, rgba: checkers.collect() };
    for size in [[240, 168], [500, 350]] {
        let [mine, theirs] = [Device::Processor, Device::from(&gpu)].map(|device| {
            let around = Surroundings::new(&device, Some(&behind), None).unwrap();
            let model = Model::new(&device, 4);
            model.draw_in(&around, size[0], size[1], &[model.cell(&[], size)])
        });
        let differences = mine.rgba.iter().zip(&theirs.rgba).map(|(a, b)| u64::from(a.abs_diff(*b)));
        let mean = differences.sum::<u64>() as f64 / mine.rgba.len() as f64;
        assert!(mean <= 1.5, "{size:?}: {mean} of 255 on average");
    }
}
