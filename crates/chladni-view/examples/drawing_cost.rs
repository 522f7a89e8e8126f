//! Where the time of drawing goes on this machine's adapter: shapes of several sizes on 1280×720,
//! with and without background and shadows, with one sample a pixel and four.
//!
//! `cargo run --release -p chladni-view --example drawing_cost [FOLDER]` writes pictures where a folder is
//! named. "cpu" is the processor time of all threads (Linux), which other programs disturb least.
#![allow(clippy::print_stdout, reason = "it reports to a terminal")]

mod measured;

use std::time::Instant;

use chladni_view::{
    Background, Camera, Canvas, Cell, Figure, Gpu, ItemBuffers, Lights, Rect, Renderer, Samples, Topology,
    View, ViewError, layout, smooth_normals,
};
use measured::{bumpy, cpu_ms};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = std::env::args().nth(1);
    let gpu = Gpu::headless()?;
    let mut renderer = Renderer::new(&gpu);
    println!("{}", gpu.description());
    for (vertices, items) in [(600, 1), (20_000, 1), (2_000, 12), (5_000, 12), (50_000, 12)] {
        let (positions, triangles) = bumpy(vertices);
        let normals = smooth_normals(&positions, &triangles);
        let topology = Topology::new(&gpu, positions.len(), &triangles)?;
        let buffers = ItemBuffers::new(&gpu, positions.len(), items);
        (0..items).try_for_each(|item| buffers.write(&gpu, item, &positions, &normals))?;
        let figures: Vec<Figure<'_>> =
            (0..items).map(|item| Figure::new(&topology, &buffers, item)).collect();
        let area = Rect::of_size(1280, 720);
        let viewports = layout::arranged(area, items, 1.0, 0);
        let mut camera = Camera::looking(View::ThreeQuarter);
        camera.fit(positions.iter().copied(), viewports[0].aspect(), 0.88);
        for samples in [Samples::One, Samples::Four] {
            let canvas = Canvas::with_samples(&gpu, area.width, area.height, samples)?;
            for (what, shadow, background) in [
                ("bare", 0.0, Background::TRANSPARENT),
                ("background", 0.0, Background::NIGHT),
                ("shadow", 0.8, Background::NIGHT),
            ] {
                let lights = Lights { shadow, ..Lights::STAGE };
                let placed = viewports.iter().copied().zip(&figures);
                let cells = Cell::gallery(area, background, camera, lights, placed);
                let mut draw = || -> Result<(), ViewError> {
                    renderer.draw(&canvas, &cells)?;
                    let done = gpu.device.poll(wgpu::PollType::wait_indefinitely());
                    done.map(|_| ()).map_err(|error| ViewError::Device(error.to_string()))
                };
                // Compiles.
                (0..2).try_for_each(|_| draw())?;
                let (begin, cpu, mut times) = (Instant::now(), cpu_ms(), Vec::new());
                while times.len() < 3 || begin.elapsed().as_secs_f64() < 0.8 {
                    let start = Instant::now();
                    draw()?;
                    times.push(1e3 * start.elapsed().as_secs_f64());
                }
                let cpu = (cpu_ms() - cpu) / times.len() as f64;
                times.sort_by(f64::total_cmp);
                let (median, count) = (times[times.len() / 2], samples.count());
                println!(
                    "{items:>2} x {vertices:>6} vertices  {count} samples  {what:<10} {median:>7.1} ms {cpu:>7.1} cpu"
                );
                if let Some(folder) = &folder {
                    let path = format!("{folder}/{vertices}x{items}-{what}-{count}.png");
                    std::fs::write(path, canvas.read(&gpu)?.to_png()?)?;
                }
            }
        }
    }
    Ok(())
}
