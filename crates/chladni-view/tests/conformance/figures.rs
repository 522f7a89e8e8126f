//! Figures drawn by both backends, in every look.

use super::*;

/// A lumpy sphere that casts shadows on itself.
pub fn lumps(rings: u32) -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
    let (mut positions, triangles) = sphere(rings);
    for p in &mut positions {
        let r = 0.8 * (1.0 + 0.3 * (5.0 * p[0]).sin() * (4.0 * p[1] + 1.0).cos() * (3.0 * p[2]).cos());
        *p = p.map(|c| c * r);
    }
    (positions, triangles)
}

/// A shape on a device, with all that it can be painted with.
pub struct Model {
    pub device: Device,
    pub topology: Topology,
    pub buffers: ItemBuffers,
    pub values: VertexPaint,
    pub colors: VertexPaint,
    pub skin: Skin,
    pub ring: BrushRing,
    pub rest: RestShape,
    pub camera: Camera,
    pub triangles: Vec<[u32; 3]>,
}

impl Model {
    pub fn new(device: &Device, rings: u32) -> Self {
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
    pub fn strewn(&self, count: usize) -> Vec<Grain> {
        let grain = |i: usize| {
            let corners = self.triangles[i * 7919 % self.triangles.len()];
            let (u, v) = (i as f32 * 0.618_034 % 1.0, i as f32 * 0.754_878 % 1.0);
            let weights = [1.0 - u.sqrt(), u.sqrt() * (1.0 - v), u.sqrt() * v];
            Grain { corners, weights, lift: 0.01 * (i % 5) as f32 }
        };
        (0..count).map(grain).collect()
    }

    pub fn figure(&self) -> Figure<'_> {
        Figure::new(&self.topology, &self.buffers, 1)
    }

    pub fn draw(&self, width: u32, height: u32, cells: &[Cell<'_>]) -> Picture {
        self.draw_in(&Surroundings::default(), width, height, cells)
    }

    pub fn draw_in(&self, around: &Surroundings, width: u32, height: u32, cells: &[Cell<'_>]) -> Picture {
        let canvas = Canvas::new(&self.device, width, height).unwrap();
        let mut renderer = Renderer::new(&self.device);
        renderer.surround(around).unwrap();
        // Twice: nothing of the first may stay.
        (0..2).for_each(|_| renderer.draw(&canvas, cells).unwrap());
        canvas.read(&self.device).unwrap()
    }

    /// Three pictures one after the other, the last of which has the trails of the first two.
    pub fn finish(&self, [width, height]: [u32; 2], cells: &[Cell<'_>], finish: &Finish) -> Picture {
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
    pub fn surroundings(&self, behind: bool) -> Surroundings {
        let wave = |x: f32| (128.0 + 110.0 * (x * std::f32::consts::TAU).sin()) as u8;
        let texel = |i: u32| {
            let (u, v) = ((i % 128) as f32 / 128.0, (i / 128) as f32 / 64.0);
            // A picture behind ends at its edges; a panorama continues around, and ends at its poles.
            let stretch = if behind { 0.6 } else { 1.0 };
            [wave(2.0 * stretch * u), wave(0.6 * v + 0.2), wave(stretch * u + 0.5), 255]
        };
        let rgba = (0..128 * 64).flat_map(texel).collect();
        let picture = Picture { width: 128, height: 64, rgba };
        let panorama = Panorama::decode(&picture.to_png().unwrap()).unwrap();
        Surroundings::new(&self.device, Some(&picture).filter(|_| behind), Some(&panorama)).unwrap()
    }

    pub fn answering(&self, answer: Answer) -> Figure<'_> {
        Figure { paint: Paint::Answer(&self.rest, answer), ..self.figure() }
    }

    pub fn cell<'a>(&self, figures: &'a [Figure<'a>], [width, height]: [u32; 2]) -> Cell<'a> {
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
pub type Drawn = fn(&Model, [u32; 2]) -> Picture;

pub const LOOKS: [(&str, Drawn); 29] = [
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
    ("colors", |m, size| {
        let figures = [Figure { paint: Paint::Colors(&m.colors), ..m.figure() }];
        m.draw(size[0], size[1], &[m.cell(&figures, size)])
    }),
    ("colors and wires", |m, size| {
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
    ("near and far out of focus, on a floor", |m, size| {
        let [near, far] = [[0.7, -0.2, 0.9], [-0.8, 0.2, -0.9]].map(|[x, y, z]| {
            let mut model = chladni_view::IDENTITY;
            (0..3).for_each(|axis| model[axis][axis] = 0.6);
            model[3] = [x, y, z, 1.0];
            Figure { model, material: Material::PORCELAIN, ..m.figure() }
        });
        let figures = [m.figure(), near, far];
        let floor = Some(Floor { color: [90, 60, 50], shadow: 0.8, at: [0.0, -0.9, 0.0], radius: 0.8 });
        let background = Background { floor, ..Background::SLATE };
        let camera = Camera { reach: 1.6, ..m.camera };
        let finish = Finish { blur: 0.7, focus: 0.2, ..Finish::NOTHING };
        m.finish(size, &[Cell { background, camera, ..m.cell(&figures, size) }], &finish)
    }),
    ("out of focus on nothing, parallel lines, glow", |m, size| {
        let figures = [m.figure()];
        let camera = Camera { projection: Projection::Orthographic, ..m.camera };
        let cell = Cell { camera, background: Background::TRANSPARENT, ..m.cell(&figures, size) };
        let finish = Finish { blur: 1.0, focus: -0.5, bloom: 0.6, bloom_from: 0.5, ..Finish::NOTHING };
        m.finish(size, &[cell], &finish)
    }),
    ("gallery out of focus", |m, size| {
        let figure = m.figure();
        let area = Rect::of_size(size[0], size[1]);
        let placed = layout::grid(area, 2, 3, 3, 5).into_iter().map(|cell| (cell, &figure));
        let cells = Cell::gallery(area, Background::SLATE, m.camera, Lights::STAGE, placed);
        m.finish(size, &cells, &Finish { blur: 1.0, focus: 0.6, ..Finish::NOTHING })
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
