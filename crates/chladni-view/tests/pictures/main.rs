//! Pixels that must be there.
#![allow(
    clippy::unwrap_used,
    clippy::print_stderr,
    reason = "a panic is how a test fails, and a skipped one says so"
)]

mod marks;
mod one_sample;
#[path = "../shapes/mod.rs"]
mod shapes;

use chladni_view::{
    Background, Camera, Canvas, Cell, ColorMap, Device, Figure, ItemBuffers, Lights, Picture, PictureRequest,
    PictureShape, Rect, Renderer, Samples, Scale, Style, Topology, View, ViewError, Wire, render_picture,
    render_picture_with, render_placed, smooth_normals,
};
use shapes::{gpu, on_each_device, sphere};

fn transparent(
    device: &Device,
    (width, height): (u32, u32),
    shapes: &[PictureShape<'_>],
    from: Camera,
) -> Picture {
    let style = Style { background: Background::TRANSPARENT, ..Style::default() };
    render_picture(device, &PictureRequest { shapes, width, height, from, style }).unwrap()
}

/// Left, top, right, bottom (inclusive) of what is covered.
fn silhouette(picture: &Picture) -> [u32; 4] {
    let mut bounds = [u32::MAX, u32::MAX, 0, 0];
    for y in 0..picture.height {
        for x in 0..picture.width {
            if picture.pixel(x, y).unwrap()[3] > 127 {
                bounds = [bounds[0].min(x), bounds[1].min(y), bounds[2].max(x), bounds[3].max(y)];
            }
        }
    }
    bounds
}

#[test]
fn a_fitted_shape_fills_its_frame_and_stays_inside() {
    on_each_device(|device| {
        let (mut positions, triangles) = sphere(24);
        for p in &mut positions {
            // An odd place and size: the fit must not depend on them.
            *p = [100.0 + 7.0 * p[0], -40.0 + 7.0 * p[1], 3.0 + 7.0 * p[2]];
        }
        let mut camera = Camera::looking(View::ThreeQuarter);
        camera.fit(positions.iter().copied(), 320.0 / 200.0, 0.9);
        let shape = PictureShape { positions: &positions, triangles: &triangles, ..Default::default() };
        let picture = transparent(device, (320, 200), &[shape], camera);
        let [left, top, right, bottom] = silhouette(&picture);
        // 90 % of 200 rows, from row 10 to row 190, and the same across, in the middle.
        assert!(top.abs_diff(10) <= 1 && bottom.abs_diff(189) <= 1, "{top} {bottom}");
        assert!(left.abs_diff(70) <= 2 && right.abs_diff(249) <= 2, "{left} {right}");
        // The area of the disc, within 2 %.
        let covered = picture.rgba.chunks(4).filter(|pixel| pixel[3] > 127).count() as f64;
        let disc = std::f64::consts::PI * 90.0 * 90.0;
        assert!((covered / disc - 1.0).abs() < 0.02, "{covered} {disc}");
    });
}

#[test]
fn edges_are_smooth_and_light_comes_from_above_left() {
    on_each_device(|device| {
        let (positions, triangles) = sphere(32);
        let shape = PictureShape { positions: &positions, triangles: &triangles, ..Default::default() };
        let camera = {
            let mut camera = Camera::default();
            camera.fit(positions.iter().copied(), 1.0, 0.9);
            camera
        };
        let picture = transparent(device, (200, 200), &[shape], camera);
        let partial = picture.rgba.chunks(4).filter(|pixel| pixel[3] > 0 && pixel[3] < 255).count();
        assert!(partial > 150, "{partial} pixels of the outline are partly covered");
        let light = |x, y| picture.pixel(x, y).unwrap()[..3].iter().map(|c| u32::from(*c)).sum::<u32>();
        assert!(light(65, 60) > light(140, 150) + 60);
    });
}

#[test]
fn each_item_is_drawn_in_its_own_cell_from_one_set_of_buffers() {
    on_each_device(|device| {
        let (positions, triangles) = sphere(12);
        let n = positions.len();
        let topology = Topology::new(device, n, &triangles).unwrap();
        let buffers = ItemBuffers::new(device, n, 3);
        let normals = smooth_normals(&positions, &triangles);
        for (item, size) in [1.0_f32, 0.6, 0.3].into_iter().enumerate() {
            let scaled: Vec<[f32; 3]> = positions.iter().map(|p| p.map(|c| c * size)).collect();
            buffers.write(device, item, &scaled, &normals).unwrap();
        }
        let mut camera = Camera::default();
        camera.fit(positions.iter().copied(), 1.0, 0.9);
        let figures: Vec<Figure<'_>> = (0..3).map(|item| Figure::new(&topology, &buffers, item)).collect();
        let cells: Vec<Cell<'_>> = chladni_view::layout::grid(Rect::of_size(300, 100), 1, 3, 0, 3)
            .into_iter()
            .zip(&figures)
            .map(|(viewport, figure)| Cell {
                viewport,
                camera,
                lights: Lights::STUDIO,
                background: Background::TRANSPARENT,
                figures: std::slice::from_ref(figure),
                markers: &[],
            })
            .collect();
        let canvas = Canvas::new(device, 300, 100).unwrap();
        let mut renderer = Renderer::new(device);
        // Twice: nothing of the first frame may stay.
        for _ in 0..2 {
            renderer.draw(&canvas, &cells).unwrap();
        }
        let picture = canvas.read(device).unwrap();
        let width = |cell: u32| {
            (100 * cell..100 * (cell + 1)).filter(|x| picture.pixel(*x, 50).unwrap()[3] > 127).count()
        };
        let widths = [width(0), width(1), width(2)];
        for (found, wanted) in widths.into_iter().zip([90, 53, 26]) {
            assert!(found.abs_diff(wanted) <= 3, "{widths:?}");
        }
    });
}

#[test]
fn a_heat_map_shows_the_colors_of_its_legend() {
    on_each_device(|device| {
        let (positions, triangles) = sphere(24);
        let values: Vec<f32> = positions.iter().map(|p| if p[0] < 0.0 { 0.0 } else { 1.0 }).collect();
        let scale = Scale { map: ColorMap::Viridis, low: 0.0, high: 1.0 };
        let mut camera = Camera::default();
        camera.fit(positions.iter().copied(), 1.0, 0.9);
        let shape = PictureShape {
            positions: &positions,
            triangles: &triangles,
            values: Some((&values, scale)),
            ..Default::default()
        };
        let picture = transparent(device, (100, 100), &[shape], camera);
        for (x, t) in [(30, 0.0), (70, 1.0)] {
            let (found, legend) = (picture.pixel(x, 45).unwrap(), ColorMap::Viridis.color(t));
            // Light only darkens a heat map, and gently: the hue stays.
            for i in 0..3 {
                let (found, legend) = (f32::from(found[i]), f32::from(legend[i]));
                assert!(found <= legend + 12.0 && found >= 0.7 * legend - 12.0, "{found} {legend} at {x}");
            }
        }
    });
}

#[test]
fn a_ghost_is_seen_through() {
    on_each_device(|device| {
        let (positions, triangles) = sphere(24);
        let ghost: Vec<[f32; 3]> = positions.iter().map(|p| p.map(|x| 2.0 * x)).collect();
        let mut camera = Camera::looking(View::Front);
        camera.fit(ghost.iter().copied(), 1.0, 0.9);
        let alone = PictureShape { positions: &positions, triangles: &triangles, ..Default::default() };
        let haunted = PictureShape { ghost: Some(&ghost), ..alone };
        let drawn = |shape| {
            let style = Style { background: Background::TRANSPARENT, ..Style::default() };
            let request = PictureRequest { shapes: &[shape], width: 100, height: 100, from: camera, style };
            let placed = [(Rect::of_size(100, 100), camera)];
            render_placed(&mut Renderer::new(device), &request, &placed).unwrap()
        };
        let (before, after) = (drawn(alone), drawn(haunted));
        let at = |picture: &Picture, x| picture.pixel(x, 50).unwrap();
        // Beyond both, on the ghost alone, and on both: there the shape is still what is seen most.
        assert_eq!([at(&before, 1)[3], at(&after, 1)[3], at(&before, 15)[3]], [0; 3]);
        assert!((60..230).contains(&at(&after, 15)[3]), "{:?}", at(&after, 15));
        let (bare, covered) = (at(&before, 50), at(&after, 50));
        assert_eq!((bare[3], covered[3]), (255, 255));
        assert!(covered[0] < bare[0] && covered[0] > 90, "{bare:?} {covered:?}");
    });
}

#[test]
fn every_target_format_shows_the_same_colors() {
    let Some(gpu) = gpu() else { return };
    let (positions, triangles) = sphere(16);
    let topology = Topology::new(&gpu, positions.len(), &triangles).unwrap();
    let buffers = ItemBuffers::new(&gpu, positions.len(), 1);
    buffers.write(&gpu, 0, &positions, &smooth_normals(&positions, &triangles)).unwrap();
    let mut camera = Camera::default();
    camera.fit(positions.iter().copied(), 1.0, 0.9);
    let plain = Figure::new(&topology, &buffers, 0);
    let cell = Cell {
        viewport: Rect::of_size(64, 64),
        camera,
        lights: Lights::STUDIO,
        background: Background::SLATE,
        figures: &[plain],
        markers: &[],
    };
    // Edges so wide that they cover every face: where they are thin or translucent, encodings mix differently.
    let wire = Wire { color: [120, 60, 200], opacity: 1.0, width_px: 99.0 };
    let wired = [Figure { wire: Some(wire), ..plain }];
    use wgpu::TextureFormat::{Bgra8Unorm, Bgra8UnormSrgb, Rgba8Unorm, Rgba8UnormSrgb};
    for cell in [cell, Cell { figures: &wired, ..cell }] {
        let pictures = [Rgba8Unorm, Bgra8Unorm, Rgba8UnormSrgb, Bgra8UnormSrgb].map(|format| {
            let canvas = Canvas::with_format(&gpu, 64, 64, format, Samples::Four).unwrap();
            Renderer::with_format(&gpu, format).draw(&canvas, &[cell]).unwrap();
            canvas.read(&gpu).unwrap()
        });
        for other in &pictures[1..] {
            // Inside and outside; the resolve of an edge may differ between the encodings.
            for (x, y) in [(32, 32), (20, 24), (44, 40), (2, 2), (60, 3)] {
                let (a, b) = (pictures[0].pixel(x, y).unwrap(), other.pixel(x, y).unwrap());
                assert!(a.iter().zip(b).all(|(a, b)| a.abs_diff(b) <= 3), "{a:?} {b:?}");
            }
        }
    }
    let wrong = Canvas::with_format(&gpu, 64, 64, Bgra8Unorm, Samples::Four).unwrap();
    assert!(matches!(Renderer::new(&gpu).draw(&wrong, &[cell]), Err(ViewError::Shape(_))));
}

#[test]
fn back_faces_are_seen_and_tinted() {
    on_each_device(|device| {
        let positions = [[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [0.0, 1.0, 0.0]];
        let shape = |triangles| PictureShape { positions: &positions, triangles, ..Default::default() };
        let camera = Camera::default();
        let front = transparent(device, (50, 50), &[shape(&[[0, 1, 2]])], camera);
        let back = transparent(device, (50, 50), &[shape(&[[0, 2, 1]])], camera);
        let (front, back) = (front.pixel(25, 28).unwrap(), back.pixel(25, 28).unwrap());
        assert_eq!((front[3], back[3]), (255, 255));
        assert!(back[1] < front[1] && back[1] > front[1] / 3, "{front:?} {back:?}");
    });
}

#[test]
fn what_does_not_fit_is_an_error() {
    on_each_device(|device| {
        let shape = |triangles| PictureShape { positions: &[[0.0; 3]; 3], triangles, ..Default::default() };
        let mut renderer = Renderer::new(device);
        let mut ask = |shape, width| {
            let request = PictureRequest {
                shapes: &[shape],
                width,
                height: 8,
                from: Camera::looking(View::ThreeQuarter),
                style: Style::default(),
            };
            render_picture_with(&mut renderer, &request)
        };
        assert!(matches!(ask(shape(&[[0, 1, 3]]), 8), Err(ViewError::Shape(_))));
        assert!(matches!(ask(shape(&[]), 0), Err(ViewError::Size { .. })));
        assert!(matches!(ask(shape(&[]), 1 << 20), Err(ViewError::Size { .. })));
        let short = PictureShape { normals: Some(&[[0.0; 3]; 2]), ..shape(&[]) };
        assert!(matches!(ask(short, 8), Err(ViewError::Shape(_))));
        // No triangle, no extent, no number: a picture of the background all the same.
        assert!(ask(shape(&[]), 8).is_ok());
        assert!(ask(shape(&[[0, 1, 2]]), 8).is_ok());
        assert!(ask(PictureShape::default(), 8).is_ok());
        let broken = [[f32::NAN, 0.0, 0.0], [f32::INFINITY; 3], [0.0; 3]];
        assert!(ask(PictureShape { positions: &broken, ..shape(&[[0, 1, 2]]) }, 8).is_ok());
        if let Some(gpu) = device.gpu() {
            gpu.check().unwrap();
        }
    });
}

#[test]
fn a_device_that_is_gone_is_an_error_and_no_panic() {
    let Some(gpu) = gpu() else { return };
    let mut renderer = Renderer::new(&gpu);
    let canvas = Canvas::new(&gpu, 16, 16).unwrap();
    gpu.device.destroy();
    let drawn = renderer.draw(&canvas, &[]).and_then(|_| canvas.read(&gpu));
    assert!(matches!(drawn, Err(ViewError::Device(_))), "{drawn:?}");
}

#[test]
fn png_files_come_back_as_they_were() {
    let mut picture = Picture::filled(7, 5, [10, 200, 30, 255]);
    for opaque in [true, false] {
        if !opaque {
            picture.rgba[3] = 17;
        }
        let bytes = picture.to_png().unwrap();
        assert_eq!(Picture::decode(&bytes).unwrap(), picture);
        assert!(Picture::decode(&bytes[..bytes.len() / 2]).is_err());
    }
    assert!(matches!(Picture::decode(b"no picture"), Err(ViewError::Image(_))));
}

#[test]
fn pasting_cuts_off_what_hangs_over_and_respects_alpha() {
    let mut sheet = Picture::filled(4, 4, [0, 0, 0, 255]);
    sheet.paste(&Picture::filled(3, 3, [255, 255, 255, 128]), 2, 3);
    assert_eq!(sheet.pixel(1, 3), Some([0, 0, 0, 255]));
    assert_eq!(sheet.pixel(3, 3), Some([128, 128, 128, 255]));
    sheet.paste(&Picture::filled(1, 1, [9; 4]), 9, 9);
    assert_eq!(sheet.halved().pixel(1, 1), Some([64, 64, 64, 255]));
}
