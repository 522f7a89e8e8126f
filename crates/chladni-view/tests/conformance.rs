//! The processor and the graphics device draw the same pictures.
#![allow(
    clippy::unwrap_used,
    clippy::print_stderr,
    reason = "a panic is how a test fails, and a skipped one says so"
)]

mod shapes;

use chladni_view::{
    Answer, Background, BrushRing, Camera, Canvas, Cell, ColorMap, Curve, Device, Figure, Finish, Floor,
    Gradient, Grain, Grains, ItemBuffers, Lights, Look, Marker, Material, Mood, NodalLines, Paint, Palette,
    Panorama, Picture, Projection, Rect, Renderer, RestShape, Scale, Skin, Surroundings, Topology,
    VertexPaint, View, ViewError, Wire, layout, smooth_normals,
};
use shapes::{gpu, sphere};

/// A lumpy sphere that casts shadows on itself.
fn lumps(rings: u32) -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
    let (mut positions, triangles) = sphere(rings);
    for p in &mut positions {
        let r = 0.8 * (1.0 + 0.3 * (5.0 * p[0]).sin() * (4.0 * p[1] + 1.0).cos() * (3.0 * p[2]).cos());
        *p = p.map(|c| c * r);
    }
    (positions, triangles)
}

/// A shape on a device, with all that it can be painted with.
struct Model {
    device: Device,
    topology: Topology,
    buffers: ItemBuffers,
    values: VertexPaint,
    colors: VertexPaint,
    skin: Skin,
    ring: BrushRing,
    rest: RestShape,
    camera: Camera,
    triangles: Vec<[u32; 3]>,
}

impl Model {
    fn new(device: &Device, rings: u32) -> Self {
        let (positions, triangles) = lumps(rings);
        let n = positions.len();
        let corner_uvs: Vec<[f32; 2]> = triangles
            .iter()
            .flatten()
            .map(|v| positions[*v as usize])
            .map(|[x, y, _]| [0.5 + 1.2 * x, 0.5 + 0.7 * y])
            .collect();
        let topology = Topology::with_uvs(device, n, &triangles, &corner_uvs).unwrap();
        // The second of two items is drawn: offsets count.
        let buffers = ItemBuffers::new(device, n, 2);
        buffers.write(device, 1, &positions, &smooth_normals(&positions, &triangles)).unwrap();
        let (values, colors) = (VertexPaint::new(device, n), VertexPaint::new(device, n));
        let heat: Vec<f32> = positions.iter().map(|p| (3.0 * p[0]).sin() * p[1]).collect();
        values.write_values(device, &heat).unwrap();
        let bytes =
            |p: &[f32; 3]| [p[0], p[1], p[2], 1.0].map(|c| (127.0 + 120.0 * c).clamp(0.0, 255.0) as u8);
        colors.write_colors(device, &positions.iter().map(bytes).collect::<Vec<_>>()).unwrap();
        // Waves that repeat, and no edges: how sharply a slanted image is filtered is the driver's own.
        let wave = |i: u32| (128.0 + 100.0 * (i as f32 * std::f32::consts::TAU / 64.0).sin()) as u8;
        let waves: Vec<u8> = (0..64 * 64).flat_map(|i| [wave(i % 64), wave(i / 64 + 16), 90, 255]).collect();
        let skin = Skin::new(device, 64, 64, &waves).unwrap();
        let mut ring = BrushRing::new(device, n, [255, 0, 255]);
        let from = |v: usize| {
            positions[v].iter().zip([0.2, 0.1, 1.0]).map(|(a, b)| (a - b).powi(2)).sum::<f32>().sqrt()
        };
        let near = |t: &&[u32; 3]| t.iter().any(|v| from(*v as usize) < 0.6);
        let under: Vec<[u32; 3]> = triangles.iter().filter(near).copied().collect();
        ring.lay(device, 0.45, (0..n).map(|v| (v as u32, from(v))), &under).unwrap();
        // It has moved by waves.
        let still: Vec<[f32; 3]> =
            positions.iter().map(|p| p.map(|c| c * (1.0 + 0.1 * (4.0 * p[1]).sin()))).collect();
        let heights: Vec<f32> = positions.iter().map(|p| 0.5 + 0.5 * p[1]).collect();
        let bends: Vec<f32> = positions.iter().map(|p| (5.0 * p[2]).sin()).collect();
        let rest = RestShape::new(device, &still, &heights, &bends).unwrap();
        // Lately it was elsewhere.
        let lagging: Vec<[f32; 3]> =
            still.iter().map(|p| p.map(|c| c * (1.0 + 0.1 * (3.0 * p[0] + 1.0).cos()))).collect();
        buffers.write(device, 0, &lagging, &smooth_normals(&lagging, &triangles)).unwrap();
        let mut camera = Camera::looking(View::ThreeQuarter);
        camera.fit(positions.iter().copied(), 1.0, 0.85);
        Self {
            device: device.clone(),
            topology,
            buffers,
            values,
            colors,
            skin,
            ring,
            rest,
            camera,
            triangles,
        }
    }

    /// Grains here and there, some of which fly.
    fn strewn(&self, count: usize) -> Vec<Grain> {
        let grain = |i: usize| {
            let corners = self.triangles[i * 7919 % self.triangles.len()];
            let (u, v) = (i as f32 * 0.618_034 % 1.0, i as f32 * 0.754_878 % 1.0);
            let weights = [1.0 - u.sqrt(), u.sqrt() * (1.0 - v), u.sqrt() * v];
            Grain { corners, weights, lift: 0.01 * (i % 5) as f32 }
        };
        (0..count).map(grain).collect()
    }

    fn figure(&self) -> Figure<'_> {
        Figure::new(&self.topology, &self.buffers, 1)
    }

    fn draw(&self, width: u32, height: u32, cells: &[Cell<'_>]) -> Picture {
        self.draw_in(&Surroundings::default(), width, height, cells)
    }

    fn draw_in(&self, around: &Surroundings, width: u32, height: u32, cells: &[Cell<'_>]) -> Picture {
        let canvas = Canvas::new(&self.device, width, height).unwrap();
        let mut renderer = Renderer::new(&self.device);
        renderer.surround(around).unwrap();
        // Twice: nothing of the first may stay.
        (0..2).for_each(|_| renderer.draw(&canvas, cells).unwrap());
        canvas.read(&self.device).unwrap()
    }

    /// Three pictures one after the other, the last of which has the trails of the first two.
    fn finish(&self, [width, height]: [u32; 2], cells: &[Cell<'_>], finish: &Finish) -> Picture {
        let canvas = Canvas::new(&self.device, width, height).unwrap();
        let mut renderer = Renderer::new(&self.device);
        let mut cells = cells.to_vec();
        for frame in 0..3 {
            cells.iter_mut().for_each(|cell| cell.camera.yaw_rad += 0.15);
            renderer.draw_finished(&canvas, &cells, finish, f64::from(frame) / 25.0).unwrap();
        }
        canvas.read(&self.device).unwrap()
    }

    /// Soft waves of color, twice as wide as high.
    fn surroundings(&self, behind: bool) -> Surroundings {
        let wave = |x: f32| (128.0 + 110.0 * (x * std::f32::consts::TAU).sin()) as u8;
        let texel = |i: u32| {
            let (u, v) = ((i % 128) as f32 / 128.0, (i / 128) as f32 / 64.0);
            [wave(2.0 * u), wave(v + 0.2), wave(u + 0.5), 255]
        };
        let rgba = (0..128 * 64).flat_map(texel).collect();
        let picture = Picture { width: 128, height: 64, rgba };
        let panorama = Panorama::decode(&picture.to_png().unwrap()).unwrap();
        Surroundings::new(&self.device, Some(&picture).filter(|_| behind), Some(&panorama)).unwrap()
    }

    fn answering(&self, answer: Answer) -> Figure<'_> {
        Figure { paint: Paint::Answer(&self.rest, answer), ..self.figure() }
    }

    fn cell<'a>(&self, figures: &'a [Figure<'a>], [width, height]: [u32; 2]) -> Cell<'a> {
        Cell {
            viewport: Rect::of_size(width, height),
            camera: self.camera,
            lights: Lights::STUDIO,
            background: Background::PAPER,
            figures,
            markers: &[],
        }
    }
}

/// How a picture is made of a model.
type Drawn = fn(&Model, [u32; 2]) -> Picture;

const LOOKS: [(&str, Drawn); 25] = [
    ("clay", |m, size| m.draw(size[0], size[1], &[m.cell(&[m.figure()], size)])),
    ("pearl under dramatic light", |m, size| {
        let figures = [Figure { material: Material::PEARL, ..m.figure() }];
        let cell = Cell { lights: Lights::DRAMATIC, background: Background::NIGHT, ..m.cell(&figures, size) };
        m.draw(size[0], size[1], &[cell])
    }),
    ("bronze without shadows, transparent", |m, size| {
        let figures = [Figure { material: Material::BRONZE, ..m.figure() }];
        let lights = Lights { shadow: 0.0, ..Lights::STAGE };
        let cell = Cell { lights, background: Background::TRANSPARENT, ..m.cell(&figures, size) };
        m.draw(size[0], size[1], &[cell])
    }),
    ("porcelain, parallel lines", |m, size| {
        let figures = [Figure { material: Material::PORCELAIN, ..m.figure() }];
        let camera = Camera { projection: Projection::Orthographic, ..m.camera };
        m.draw(size[0], size[1], &[Cell { camera, lights: Lights::SOFT, ..m.cell(&figures, size) }])
    }),
    ("heat map", |m, size| {
        let scale = Scale { map: ColorMap::BlueRed, low: -0.5, high: 0.5 };
        let figures = [Figure { paint: Paint::Values(&m.values, scale), ..m.figure() }];
        m.draw(size[0], size[1], &[m.cell(&figures, size)])
    }),
    ("colours and wires", |m, size| {
        let wire = Some(Wire { opacity: 0.8, ..Wire::default() });
        let figures = [Figure { paint: Paint::Colors(&m.colors), wire, ..m.figure() }];
        m.draw(size[0], size[1], &[m.cell(&figures, size)])
    }),
    ("skin", |m, size| {
        let figures = [Figure { paint: Paint::Skin(&m.skin), ..m.figure() }];
        m.draw(size[0], size[1], &[m.cell(&figures, size)])
    }),
    ("brush and markers", |m, size| {
        let figures = [Figure { brush: Some(&m.ring), ..m.figure() }];
        let marker = |position, color| Marker { position, radius_px: 7.0, color };
        let markers = [
            marker([0.0, 0.0, 0.9], [255, 0, 0, 255]),
            marker([0.0, 0.3, -0.9], [0, 120, 0, 255]),
            marker([0.9, 0.2, 0.2], [0, 0, 255, 160]),
        ];
        m.draw(size[0], size[1], &[Cell { markers: &markers, ..m.cell(&figures, size) }])
    }),
    ("grains of many pixels, lifted, under shadows", |m, size| {
        let grains = m.strewn(400);
        let sand = Grains { grains: &grains, radius: 0.03, color: [230, 210, 160] };
        let figures = [Figure { grains: Some(sand), material: Material::DARK, ..m.figure() }];
        m.draw(size[0], size[1], &[m.cell(&figures, size)])
    }),
    ("grains of less than a pixel, parallel lines", |m, size| {
        let grains = m.strewn(5_000);
        let sand = Grains { grains: &grains, radius: 0.004, color: [255, 250, 240] };
        let mut aside = chladni_view::IDENTITY;
        aside[3] = [0.3, 0.1, -0.2, 1.0];
        let figures = [Figure { grains: Some(sand), model: aside, ..m.figure() }];
        let camera = Camera { projection: Projection::Orthographic, ..m.camera };
        m.draw(size[0], size[1], &[Cell { camera, lights: Lights::STAGE, ..m.cell(&figures, size) }])
    }),
    ("two figures through each other, one translucent behind", |m, size| {
        let mut moved = chladni_view::IDENTITY;
        moved[3] = [0.55, 0.3, 0.2, 1.0];
        let mut aside = chladni_view::IDENTITY;
        aside[3] = [-0.6, 0.2, 0.3, 1.0];
        let figures = [
            m.figure(),
            Figure { model: moved, material: Material::DARK, ..m.figure() },
            Figure { model: aside, material: Material::PORCELAIN, opacity: 0.4, ..m.figure() },
        ];
        m.draw(size[0], size[1], &[m.cell(&figures, size)])
    }),
    ("from within, through the near plane", |m, size| {
        let camera = Camera { distance: 0.7, ..m.camera };
        m.draw(size[0], size[1], &[Cell { camera, ..m.cell(&[m.figure()], size) }])
    }),
    ("far away and turned", |m, size| {
        let camera = Camera { distance: 40.0, yaw_rad: 2.5, pitch_rad: -1.2, ..m.camera };
        m.draw(size[0], size[1], &[Cell { camera, ..m.cell(&[m.figure()], size) }])
    }),
    ("palette by movement", |m, size| {
        let answer = Answer { travel: 6.0, glow: 3.0, saturation: 0.7, ..Answer::MOVED };
        let material = Material { glow: 0.1, edge: [40, 90, 200], ..Material::CLAY };
        let figures = [Figure { material, ..m.answering(answer) }];
        m.draw(size[0], size[1], &[m.cell(&figures, size)])
    }),
    ("circle by sign and along, with wires", |m, size| {
        let answer = Answer { palette: Palette::Prism, span: 1.7, swing: 3.0, offset: -0.4, ..Answer::MOVED };
        let wire = Some(Wire { opacity: 0.8, ..Wire::default() });
        let figures = [Figure { wire, ..m.answering(answer) }];
        m.draw(size[0], size[1], &[m.cell(&figures, size)])
    }),
    ("palette by bend and speed, with its sparks", |m, size| {
        let answer = Answer { crease: 0.3, haste: 5.0, spark: 4.0, travel: 0.0, ..Answer::MOVED };
        let figures = [Figure { lag: Some(0), ..m.answering(answer) }];
        m.draw(size[0], size[1], &[m.cell(&figures, size)])
    }),
    ("circle by phase", |m, size| {
        let answer = Answer { palette: Palette::Prism, phase: 1.0, travel: 0.0, ..Answer::MOVED };
        let figures = [Figure { lag: Some(0), ..m.answering(Answer { farthest: 0.2, ..answer }) }];
        m.draw(size[0], size[1], &[m.cell(&figures, size)])
    }),
    ("nodal lines", |m, size| {
        let lines = NodalLines { color: [255, 240, 200], opacity: 0.9, width: 4.0 };
        let figures = [m.answering(Answer { lines, travel: 2.0, farthest: 0.2, ..Answer::MOVED })];
        m.draw(size[0], size[1], &[m.cell(&figures, size)])
    }),
    ("mirror in a studio of lines, as film, on a floor", |m, size| {
        let material = Material { roughness: 0.1, ..Material::BRONZE };
        let figures = [Figure { material, ..m.figure() }];
        let lights = Lights { horizon: [1.0, 0.5, 0.3], strips: 1.2, curve: Curve::Filmic, ..Lights::STUDIO };
        let floor = Some(Floor { color: [90, 60, 50], shadow: 0.8, at: [0.0, -0.9, 0.0], radius: 0.8 });
        let background = Background { gradient: Gradient::Upright, floor, ..Background::SLATE };
        m.draw(size[0], size[1], &[Cell { lights, background, ..m.cell(&figures, size) }])
    }),
    ("clay in a panorama, before a picture", |m, size| {
        let around = m.surroundings(true);
        let floor = Some(Floor { color: [90, 60, 50], shadow: 0.8, at: [0.0, -0.9, 0.0], radius: 0.8 });
        let figures = [m.figure()];
        let cell = Cell { background: Background { floor, ..Background::NIGHT }, ..m.cell(&figures, size) };
        m.draw_in(&around, size[0], size[1], &[cell])
    }),
    ("a mirror of pearl in a panorama", |m, size| {
        let material = Material { roughness: 0.2, metal: 0.8, ..Material::PEARL };
        let figures = [Figure { material, ..m.figure() }];
        m.draw_in(&m.surroundings(false), size[0], size[1], &[m.cell(&figures, size)])
    }),
    ("glow, rim and grain", |m, size| {
        let figures = [m.figure()];
        let cell = Cell {
            background: Background { gradient: Gradient::Halo, ..Background::NIGHT },
            ..m.cell(&figures, size)
        };
        let finish = Finish { bloom: 1.0, bloom_from: 0.4, vignette: 0.5, grain: 0.1, ..Finish::NOTHING };
        m.finish(size, &[cell], &finish)
    }),
    ("trails on nothing", |m, size| {
        let figures = [m.figure()];
        let cell = Cell { background: Background::TRANSPARENT, ..m.cell(&figures, size) };
        let finish = Finish { trail_secs: 0.1, trail_growth: 2.0, ..Finish::NOTHING };
        m.finish(size, &[cell], &finish)
    }),
    ("a whole look", |m, size| {
        let heard = Mood { levels: [0.9, 0.1], ..Mood::default() };
        let look = Look::DUSK.answering(&heard).scaled(0.2);
        let figures = [Figure { material: look.material, ..m.answering(look.answer.unwrap()) }];
        let (lights, background) = (look.lights, look.background);
        m.finish(size, &[Cell { lights, background, ..m.cell(&figures, size) }], &look.finish)
    }),
    ("gallery", |m, size| {
        let figure = m.figure();
        let area = Rect::of_size(size[0], size[1]);
        let placed = layout::grid(area, 2, 3, 3, 5).into_iter().map(|cell| (cell, &figure));
        let mut cells = Cell::gallery(area, Background::SLATE, m.camera, Lights::STAGE, placed);
        for (i, cell) in cells.iter_mut().enumerate() {
            cell.camera.yaw_rad += i as f32;
        }
        m.draw(size[0], size[1], &cells)
    }),
];

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
    // A floor that goes through the eye and to the horizon: the lower half, but for what is too near.
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
    // What one device holds the other does not draw, and says so.
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

/// What glows is brighter around, the corners are darker, and a picture long after another has no trail of it.
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
