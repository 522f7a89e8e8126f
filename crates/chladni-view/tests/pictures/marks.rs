//! Pictures of things on a surface: wires, colors, skins, brushes, markers.

use std::cell::RefCell;

use chladni_view::{
    Background, BrushRing, Camera, Canvas, Cell, Device, Figure, ItemBuffers, Lights, Marker, Material,
    Paint, Picture, Rect, Renderer, Skin, Topology, VertexPaint, Wire, smooth_normals,
};

use super::shapes::{on_each_device, sphere};

/// A sphere that is drawn again and again.
struct Model {
    device: Device,
    positions: Vec<[f32; 3]>,
    triangles: Vec<[u32; 3]>,
    topology: Topology,
    buffers: ItemBuffers,
    renderer: RefCell<Renderer>,
}

impl Model {
    fn new(device: &Device) -> Self {
        let (positions, triangles) = sphere(10);
        let n = positions.len();
        let uvs: Vec<[f32; 2]> = triangles
            .iter()
            .flatten()
            .map(|v| positions[*v as usize])
            .map(|p| [0.5 + 0.5 * p[0], 0.5 + 0.5 * p[1]])
            .collect();
        let topology = Topology::with_uvs(device, n, &triangles, &uvs).unwrap();
        let buffers = ItemBuffers::new(device, n, 2);
        // Item 1 is the one drawn: offsets count in every path.
        buffers.write(device, 1, &positions, &smooth_normals(&positions, &triangles)).unwrap();
        let renderer = RefCell::new(Renderer::new(device));
        Self { device: device.clone(), positions, triangles, topology, buffers, renderer }
    }

    fn plain(&self) -> Figure<'_> {
        Figure { material: Material::PORCELAIN, ..Figure::new(&self.topology, &self.buffers, 1) }
    }

    fn draw(&self, figure: Figure<'_>, markers: &[Marker]) -> Picture {
        let mut camera = Camera::default();
        camera.fit(self.positions.iter().copied(), 1.0, 0.9);
        let canvas = Canvas::new(&self.device, 120, 120).unwrap();
        let cell = Cell {
            viewport: Rect::of_size(120, 120),
            camera,
            lights: Lights::SOFT,
            background: Background::TRANSPARENT,
            figures: &[figure],
            markers,
        };
        self.renderer.borrow_mut().draw(&canvas, &[cell]).unwrap();
        canvas.read(&self.device).unwrap()
    }
}

fn differing(a: &Picture, b: &Picture) -> usize {
    let differs = |a: &[u8], b: &[u8]| a.iter().zip(b).any(|(a, b)| a.abs_diff(*b) > 20);
    a.rgba.chunks(4).zip(b.rgba.chunks(4)).filter(|(a, b)| differs(a, b)).count()
}

#[test]
fn wires_and_colors_leave_their_marks() {
    on_each_device(|device| {
        let model = Model::new(device);
        let (plain, n) = (model.plain(), model.positions.len());
        let bare = model.draw(plain, &[]);
        let wired = model.draw(Figure { wire: Some(Wire { opacity: 1.0, ..Wire::default() }), ..plain }, &[]);
        assert!(differing(&bare, &wired) > 400);
        assert!(differing(&bare, &wired) < 8000, "a wire is not a fill");

        let colors = VertexPaint::new(&model.device, n);
        colors.write_colors(&model.device, &vec![[0, 255, 0, 255]; n]).unwrap();
        let painted = Figure { paint: Paint::Colors(&colors), ..plain };
        let green = model.draw(painted, &[]).pixel(60, 60).unwrap();
        assert!(green[1] > 2 * green[0] && green[1] > 2 * green[2], "{green:?}");
        let both = Figure { wire: Some(Wire { width_px: 0.1, ..Wire::default() }), ..painted };
        let green = model.draw(both, &[]).pixel(62, 57).unwrap();
        assert!(green[1] > 2 * green[0] && green[1] > 2 * green[2], "{green:?}");
    });
}

#[test]
fn a_skin_is_seen_the_right_way_up() {
    on_each_device(|device| {
        let model = Model::new(device);
        // Red above, blue below.
        let mut pixels = [[255, 0, 0, 255]; 64];
        pixels[32..].fill([0, 0, 255, 255]);
        let skin = Skin::new(&model.device, 8, 8, pixels.as_flattened()).unwrap();
        let skinned = model.draw(Figure { paint: Paint::Skin(&skin), ..model.plain() }, &[]);
        let (above, below) = (skinned.pixel(60, 35).unwrap(), skinned.pixel(60, 85).unwrap());
        assert!(above[0] > 2 * above[2] && below[2] > 2 * below[0], "{above:?} {below:?}");
    });
}

/// A ring lies on the triangles that it is laid on, on their near side, and nowhere else.
#[test]
fn the_ring_of_a_brush_lies_where_it_is_laid() {
    on_each_device(|device| {
        let model = Model::new(device);
        let Model { positions, triangles, .. } = &model;
        let (plain, n) = (model.plain(), positions.len());
        let bare = model.draw(plain, &[]);
        let mut ring = BrushRing::new(device, n, [255, 0, 255]);
        let reach = |v: usize| {
            let [x, y, z] = positions[v];
            (v as u32, (x * x + y * y + (z - 1.0) * (z - 1.0)).sqrt())
        };
        let half: Vec<[u32; 3]> =
            triangles.iter().copied().filter(|t| t.iter().any(|v| reach(*v as usize).1 < 0.4)).collect();
        ring.lay(device, 0.4, (0..n).map(reach), &half).unwrap();
        let brushed = model.draw(Figure { brush: Some(&ring), ..plain }, &[]);
        assert!((30..2500).contains(&differing(&bare, &brushed)));
        let pink = |x| {
            let [r, g, b, _] = brushed.pixel(x, 60).unwrap();
            i32::from(r) + i32::from(b) - 2 * i32::from(g)
        };
        // 0.4 of the sphere's radius from its middle, of 0.9 of half the picture.
        let along: Vec<i32> = (60..120).map(pink).collect();
        let strongest = (0..60).max_by_key(|i| along[*i]).unwrap();
        assert!((18..27).contains(&strongest), "the ring is {strongest} pixels from the middle");
        let far_side: Vec<[u32; 3]> =
            triangles.iter().copied().filter(|t| t.iter().all(|v| positions[*v as usize][2] < 0.0)).collect();
        ring.lay(device, 0.4, (0..n).map(reach), &far_side).unwrap();
        assert_eq!(differing(&bare, &model.draw(Figure { brush: Some(&ring), ..plain }, &[])), 0);
        ring.lift();
        assert_eq!(differing(&bare, &model.draw(Figure { brush: Some(&ring), ..plain }, &[])), 0);
        assert!(ring.lay(device, 0.4, [(n as u32, 0.0)].into_iter(), &[]).is_err());
        assert!(ring.lay(device, 0.4, [].into_iter(), &[[0, 1, n as u32]]).is_err());
    });
}

#[test]
fn markers_are_hidden_by_what_is_before_them() {
    on_each_device(|device| {
        let model = Model::new(device);
        let marker = |z| Marker { position: [0.0, 0.0, z], radius_px: 6.0, color: [255, 0, 0, 255] };
        let in_front = model.draw(model.plain(), &[marker(1.0)]).pixel(60, 60).unwrap();
        assert!(in_front[0] > 200 && in_front[1] < 60, "{in_front:?}");
        let behind = model.draw(model.plain(), &[marker(-1.0)]).pixel(60, 60).unwrap();
        assert!(behind[1] > 100 && behind[0] > behind[1], "{behind:?}");
    });
}
