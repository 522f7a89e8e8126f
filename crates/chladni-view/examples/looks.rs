//! A contact sheet of all looks on the octopus, bent by waves: `looks PICTURE.png [COLUMNS]`.

use chladni_mesh::samples;
use chladni_mesh::surface::vec3::single;
use chladni_view::{
    Camera, Canvas, Cell, Device, Draw, Figure, Floor, ItemBuffers, Look, Mood, Paint, Picture, Rect,
    Renderer, RestShape, Topology, bends, smooth_normals,
};

const SIZE: [u32; 2] = [480, 360];
/// How far waves bend the shape.
const FAR: f32 = 0.18;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let path = arguments.next().ok_or("usage: looks PICTURE.png [COLUMNS]")?;
    let columns: u32 = arguments.next().map_or(Ok(4), |count| count.parse())?;
    let device = Device::open(Draw::Auto)?;
    let mesh = samples::sample("octopus").ok_or("the octopus is missing")?;
    let rest = single(&mesh.positions);
    let axis = |i: usize| {
        let all = rest.iter().map(|p| p[i]);
        (all.clone().fold(f32::INFINITY, f32::min), all.fold(f32::NEG_INFINITY, f32::max))
    };
    let [(left, right), (bottom, top), (back, front)] = [0, 1, 2].map(axis);
    let height = top - bottom;
    let along: Vec<f32> = rest.iter().map(|p| (p[1] - bottom) / height).collect();
    let far = FAR * height;
    let wave = |at: f32, phase: f32| (6.0 * at / height + phase).sin();
    let bent: Vec<[f32; 3]> = rest
        .iter()
        .map(|&[x, y, z]| {
            let share = far * (0.35 + 0.65 * ((x * x + z * z).sqrt() / (0.5 * height)).min(1.0));
            [x + share * wave(y, 0.4), y + 0.8 * share * wave(x, 1.3), z + share * wave(x + y, 2.0)]
        })
        .collect();
    let normals = smooth_normals(&rest, &mesh.triangles);
    let bends = bends(&rest, &mesh.triangles);
    // It came from where waves a little earlier had bent it.
    let lagging: Vec<[f32; 3]> = rest
        .iter()
        .map(|&[x, y, z]| {
            let share = 0.6 * far * wave(0.4 * y + 0.7 * x, 2.6);
            [x + 0.5 * share, y + share, z + share]
        })
        .collect();
    let topology = Topology::new(&device, rest.len(), &mesh.triangles)?;
    let buffers = ItemBuffers::new(&device, rest.len(), 2);
    buffers.write(&device, 0, &bent, &smooth_normals(&bent, &mesh.triangles))?;
    buffers.write(&device, 1, &lagging, &normals)?;
    let still = RestShape::new(&device, &rest, &along, &bends)?;
    let mut camera = Camera { pitch_rad: 0.14, yaw_rad: 0.3, ..Camera::default() };
    camera.fit(bent.iter().copied(), SIZE[0] as f32 / SIZE[1] as f32, 0.86);
    let (canvas, mut renderer) = (Canvas::new(&device, SIZE[0], SIZE[1])?, Renderer::new(&device));
    let rows = (Look::PRESETS.len() as u32).div_ceil(columns);
    let mut sheet = Picture::filled(columns * SIZE[0], rows * SIZE[1], [0, 0, 0, 255]);
    for (i, (_, look)) in (0u32..).zip(Look::PRESETS) {
        let mood = Mood {
            levels: [0.7; 2],
            timbre: 0.4,
            sides: 0.1,
            key_turns: 0.0,
            beats: 3.2,
            certainty: 1.0,
            accent: 0.6,
        };
        let mut look = look.answering(&mood).scaled(1.4 * far);
        let at = [0.5 * (left + right), bottom, 0.5 * (back + front)];
        let radius = 0.5 * (right - left).max(front - back);
        look.background.floor = look.background.floor.map(|floor| Floor { at, radius, ..floor });
        let paint = look.answer.map_or(Paint::Material, |answer| Paint::Answer(&still, answer));
        let figure = Figure { lag: Some(1), ..Figure::new(&topology, &buffers, 0) };
        let figures = [Figure { material: look.material, paint, ..figure }];
        for frame in 0..3 {
            let yaw_rad = camera.yaw_rad + 0.04 * frame as f32;
            let cell = Cell {
                viewport: Rect::of_size(SIZE[0], SIZE[1]),
                camera: Camera { yaw_rad, ..camera },
                lights: look.lights,
                background: look.background,
                figures: &figures,
                markers: &[],
            };
            renderer.draw_finished(&canvas, &[cell], &look.finish, f64::from(frame) / 30.0)?;
        }
        sheet.paste(&canvas.read(&device)?, i % columns * SIZE[0], i / columns * SIZE[1]);
    }
    std::fs::write(path, sheet.to_png()?)?;
    Ok(())
}
