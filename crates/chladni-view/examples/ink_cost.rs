//! Where the time of a drawing in ink goes: `cargo run --release -p chladni-view --example ink_cost [MESH …]`, of the
//! sample head where no mesh is named, on 900×900 pixels.
#![allow(clippy::print_stdout, reason = "it reports to a terminal")]

use std::error::Error;
use std::path::Path;
use std::time::Instant;

use chladni_mesh::{load_mesh, samples, weld};
use chladni_view::ink::{Drawing, Ink, Plate};
use chladni_view::{Camera, Rect, View};

fn main() -> Result<(), Box<dyn Error>> {
    let mut meshes = Vec::new();
    for path in std::env::args().skip(1) {
        let mesh = load_mesh(Path::new(&path))?.mesh;
        meshes.push((path, mesh));
    }
    if meshes.is_empty() {
        meshes.extend(samples::sample("head").map(|mesh| ("sample:head".to_owned(), mesh)));
    }
    println!("milliseconds: shape made ready, lines, lines and hatching, picture");
    for (name, mesh) in meshes {
        let shape = weld(&mesh);
        let mut camera = Camera::looking(View::ThreeQuarter);
        camera.fit(shape.positions.iter().map(|p| p.map(|x| x as f32)), 1.0, 0.9);
        let (ink, cell) = (Ink::default(), Rect::of_size(900, 900));
        let mut drawing = Drawing::new(900, 900, &ink)?;
        let mut times = [0.0; 4];
        let mut timed = |i: usize, from: Instant| times[i] = from.elapsed().as_secs_f64() * 1e3;
        let start = Instant::now();
        let plate = Plate::new(&shape.positions, &shape.triangles, Plate::SMOOTHING)?;
        timed(0, start);
        let start = Instant::now();
        let lines = plate.outlines(&ink, &camera, cell).len();
        timed(1, start);
        let start = Instant::now();
        drawing.strokes = plate.strokes(&ink, &camera, cell);
        timed(2, start);
        let start = Instant::now();
        drawing.to_picture();
        timed(3, start);
        let (n, strokes, [ready, outlines, all, picture]) =
            (shape.positions.len(), drawing.strokes.len(), times);
        println!(
            "{name}: {n} vertices, {lines} lines, {strokes} strokes: {ready:.0}, {outlines:.0}, {all:.0}, {picture:.0}"
        );
    }
    Ok(())
}
