//! The processor beside the graphics device that this machine has: the same pictures, level for level.
//!
//! `cargo run --release -p chladni-view --example twins [FOLDER]` prints a table and writes pictures of both
//! where a folder is named; a second word is the one effect that is drawn, beside the bare shape. `bench/draw/run` writes the table into BENCHMARKS.md.
#![allow(clippy::print_stdout, reason = "it reports to a terminal")]

mod measured;

use std::time::Instant;

use chladni_view::{
    Answer, Background, Camera, Canvas, Cell, Curve, Device, Draw, Figure, Finish, Floor, ItemBuffers,
    Lights, Look, Material, NodalLines, Paint, Picture, Rect, Renderer, RestShape, Samples, Topology, View,
    ViewError, layout, smooth_normals,
};
use measured::{bumpy, cpu_ms};

/// A scene to draw: numbers of items and of vertices in each.
struct Scene {
    name: &'static str,
    items: usize,
    vertices: usize,
    size: [u32; 2],
}

const SCENES: [Scene; 3] = [
    Scene { name: "gallery", items: 12, vertices: 17_100, size: [1280, 720] },
    Scene { name: "one shape", items: 1, vertices: 50_000, size: [1280, 800] },
    Scene { name: "large shape", items: 1, vertices: 134_000, size: [1280, 800] },
];

/// Frames drawn of each.
const FRAMES: usize = 21;

/// Milliseconds of each frame, in order; those of all threads together, on average; the last picture.
fn measure(device: &Device, scene: &Scene, look: &Look) -> Result<(Vec<f64>, f64, Picture), ViewError> {
    let (positions, triangles) = bumpy(scene.vertices);
    let normals = smooth_normals(&positions, &triangles);
    let topology = Topology::new(device, positions.len(), &triangles)?;
    // The last item is the lag of the others.
    let buffers = ItemBuffers::new(device, positions.len(), scene.items + 1);
    (0..=scene.items).try_for_each(|item| buffers.write(device, item, &positions, &normals))?;
    let still: Vec<[f32; 3]> = positions.iter().map(|p| p.map(|c| c * (1.0 + 0.3 * p[1]))).collect();
    let flat = vec![0.0; still.len()];
    let rest = RestShape::new(device, &still, &flat, &flat)?;
    let paint = look.answer.map_or(Paint::Material, |answer| Paint::Answer(&rest, answer));
    let lag = Some(scene.items);
    let figure =
        |item| Figure { material: look.material, paint, lag, ..Figure::new(&topology, &buffers, item) };
    let figures: Vec<Figure<'_>> = (0..scene.items).map(figure).collect();
    let area = Rect::of_size(scene.size[0], scene.size[1]);
    let viewports = layout::arranged(area, scene.items, 1.0, 0);
    let mut camera = Camera::looking(View::ThreeQuarter);
    camera.fit(positions.iter().copied(), viewports[0].aspect(), 0.88);
    let mut renderer = Renderer::new(device);
    let canvas = Canvas::with_samples(device, area.width, area.height, Samples::Four)?;
    let (mut times, mut cpu) = (Vec::new(), 0.0);
    for frame in 0..FRAMES + 2 {
        let turned = Camera { yaw_rad: camera.yaw_rad + 0.02 * frame as f32, ..camera };
        let placed = viewports.iter().copied().zip(&figures);
        let cells: Vec<Cell<'_>> = Cell::gallery(area, look.background, turned, look.lights, placed);
        // The first two compile and fill caches.
        if frame == 2 {
            times.clear();
            cpu = cpu_ms();
        }
        let start = Instant::now();
        renderer.draw_finished(&canvas, &cells, &look.finish, frame as f64 / 30.0)?;
        if let Some(gpu) = device.gpu() {
            let done = gpu.device.poll(wgpu::PollType::wait_indefinitely());
            done.map_err(|error| ViewError::Device(error.to_string()))?;
        }
        times.push(1e3 * start.elapsed().as_secs_f64());
    }
    let cpu = (cpu_ms() - cpu) / FRAMES as f64;
    times.sort_by(f64::total_cmp);
    Ok((times, cpu, canvas.read(device)?))
}

/// The least work in a frame of a scene: its vertices, triangles, and pixels that show a surface.
fn counts(device: &Device, scene: &Scene) -> Result<[usize; 3], ViewError> {
    let look = Look { background: Background::TRANSPARENT, ..bare(0.0) };
    let (.., picture) = measure(device, scene, &look)?;
    let (positions, triangles) = bumpy(scene.vertices);
    let shaded = picture.rgba.chunks_exact(4).filter(|pixel| pixel[3] > 0).count();
    Ok([scene.items * positions.len(), scene.items * triangles.len(), shaded])
}

/// Clay under the lights of the stage.
fn bare(shadow: f32) -> Look {
    Look { material: Material::CLAY, lights: Lights { shadow, ..Lights::STAGE }, ..Look::PLAIN }
}

/// One effect each beside the bare look, then two whole ones.
fn effects() -> [(&'static str, Look); 11] {
    let look = bare(0.7);
    let lights = Lights { horizon: [0.5; 3], strips: 1.0, curve: Curve::Filmic, ..look.lights };
    let mut floor = look.background;
    floor.floor = Some(Floor { color: [60; 3], shadow: 0.8, at: [0.0, -0.5, 0.0], radius: 0.5 });
    let finish = |finish| Look { finish, ..look };
    [
        ("palette", Look { answer: Some(Answer { glow: 0.3, ..Answer::MOVED }), ..look }),
        ("palette by speed and phase", {
            Look { answer: Some(Answer { glow: 0.3, haste: 1.0, phase: 1.0, ..Answer::MOVED }), ..look }
        }),
        ("palette and nodal lines", {
            let lines = NodalLines { opacity: 1.0, ..NodalLines::NONE };
            Look { answer: Some(Answer { glow: 0.3, lines, ..Answer::MOVED }), ..look }
        }),
        ("studio of lines, film's curve", Look { lights, ..look }),
        ("floor", Look { background: floor, ..look }),
        ("depth of field", finish(Finish { blur: 0.6, ..Finish::NOTHING })),
        ("glow", finish(Finish { bloom: 1.0, bloom_from: 0.5, ..Finish::NOTHING })),
        ("trails", finish(Finish { trail_secs: 0.2, trail_growth: 0.2, ..Finish::NOTHING })),
        ("rim and grain", finish(Finish { vignette: 0.3, grain: 0.03, ..Finish::NOTHING })),
        ("the look aurora", Look::AURORA),
        ("the look neon", Look::NEON),
    ]
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (folder, only) = (std::env::args().nth(1), std::env::args().nth(2));
    let mut devices = vec![Device::open(Draw::Cpu)?];
    devices.extend(Device::open(Draw::Gpu).ok());
    for device in &devices {
        println!("{}", device.description());
    }
    let columns: Vec<&str> = devices.iter().map(|_| "ms a frame").collect();
    for scene in &SCENES {
        let [vertices, triangles, pixels] = counts(&devices[0], scene)?;
        let [width, height] = scene.size;
        let name = scene.name;
        println!(
            "counts: {name}, {vertices} vertices, {triangles} triangles, {pixels} of {width}x{height} pixels"
        );
    }
    println!("| scene | with | {} |", columns.join(" | "));
    let plain = [("no shadow", bare(0.0)), ("shadow", bare(0.7))];
    let of = |scene| plain.map(|(what, look)| (scene, what, look));
    let with_effects = effects().map(|(what, look)| (&SCENES[1], what, look));
    let is_asked = |scene: &Scene, what| {
        only.as_ref().is_none_or(|only| scene.name == "one shape" && (what == "shadow" || what == *only))
    };
    let all = SCENES.iter().flat_map(of).chain(with_effects);
    for (scene, what, look) in all.filter(|(scene, what, _)| is_asked(scene, *what)) {
        let mut line = format!("| {} {} x {} | {what}", scene.name, scene.items, scene.vertices);
        let mut first = None;
        for (device, who) in devices.iter().zip(["processor", "device"]) {
            let (times, cpu, picture) = measure(device, scene, &look)?;
            let median = times[times.len() / 2];
            let ratio = median / *first.get_or_insert(median);
            line += &format!(" | {median:.1}, best {:.1}, processor {cpu:.0}, {ratio:.1} times", times[0]);
            if let Some(folder) = &folder {
                let path = format!("{folder}/{}-{what}-{who}.png", scene.name);
                std::fs::write(path, picture.to_png()?)?;
            }
        }
        println!("{line} |");
    }
    Ok(())
}
