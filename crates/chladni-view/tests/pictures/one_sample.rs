//! One sample a pixel is a quicker drawing of the same picture.

use chladni_view::{
    Background, Camera, Canvas, Cell, Figure, ItemBuffers, Lights, Rect, Renderer, Samples, Topology,
    smooth_normals,
};

use super::shapes::{gpu, sphere};

#[test]
fn one_sample_looks_like_four_and_its_edges_are_smooth() {
    let Some(gpu) = gpu() else { return };
    let (positions, triangles) = sphere(24);
    let topology = Topology::new(&gpu, positions.len(), &triangles).unwrap();
    let buffers = ItemBuffers::new(&gpu, positions.len(), 1);
    buffers.write(&gpu, 0, &positions, &smooth_normals(&positions, &triangles)).unwrap();
    let mut camera = Camera::default();
    camera.fit(positions.iter().copied(), 1.0, 0.8);
    let figure = Figure::new(&topology, &buffers, 0);
    let cell = Cell {
        viewport: Rect::of_size(200, 200),
        camera,
        lights: Lights::STAGE,
        background: Background::NIGHT,
        figures: &[figure],
        markers: &[],
    };
    let mut renderer = Renderer::new(&gpu);
    let [four, one] = [Samples::Four, Samples::One].map(|samples| {
        let canvas = Canvas::with_samples(&gpu, 200, 200, samples).unwrap();
        renderer.draw(&canvas, &[cell]).unwrap();
        canvas.read(&gpu).unwrap()
    });
    let apart = |a: &[u8], b: &[u8]| (0..4).map(|i| a[i].abs_diff(b[i])).max().unwrap();
    let differ =
        |limit| four.rgba.chunks(4).zip(one.rgba.chunks(4)).filter(|(a, b)| apart(a, b) > limit).count();
    // The outline has about 500 pixels; smoothing cannot guess the shade of each.
    assert!(differ(12) < 500 && differ(90) < 25, "{} {}", differ(12), differ(90));
    // Between night and the lit side there are pixels of neither.
    let row: Vec<u8> = (0..200).map(|x| one.pixel(x, 40).unwrap()[0]).collect();
    let lit = row.iter().copied().max().unwrap();
    assert!(row.iter().any(|c| (lit / 4..lit / 4 * 3).contains(c)), "{row:?}");
}

/// Closed, open, inside out and half turned over: with one sample the same walls are in front.
#[test]
fn one_sample_shows_the_sides_that_four_show() {
    let Some(gpu) = gpu() else { return };
    let (positions, triangles) = closed_sphere(16);
    // Without its front half (z > 0), only the inside of the other half is seen.
    let half: Vec<[u32; 3]> = triangles
        .iter()
        .copied()
        .filter(|t| t.iter().map(|v| positions[*v as usize][2]).sum::<f32>() < 0.0)
        .collect();
    let inverted: Vec<[u32; 3]> = triangles.iter().map(|&[a, b, c]| [a, c, b]).collect();
    // As a large exaggeration does: one half goes through the other, and farther.
    let turned: Vec<[f32; 3]> =
        positions.iter().map(|p| if p[2] > 0.0 { *p } else { [p[0], p[1], -1.5 * p[2]] }).collect();
    let mut camera = Camera::default();
    camera.fit(positions.iter().copied(), 1.0, 0.6);
    for (what, positions, triangles) in [
        ("closed", &positions, &triangles),
        ("open", &positions, &half),
        ("inside out", &positions, &inverted),
        ("turned over", &turned, &triangles),
    ] {
        let topology = Topology::new(&gpu, positions.len(), triangles).unwrap();
        let buffers = ItemBuffers::new(&gpu, positions.len(), 1);
        buffers.write(&gpu, 0, positions, &smooth_normals(positions, triangles)).unwrap();
        // Of bare colors: lights of one side only, and no shadows, whose edges differ.
        let cell = Cell {
            viewport: Rect::of_size(100, 100),
            camera,
            lights: Lights { shadow: 0.0, ..Lights::STUDIO },
            background: Background::TRANSPARENT,
            figures: &[Figure::new(&topology, &buffers, 0)],
            markers: &[],
        };
        let mut renderer = Renderer::new(&gpu);
        let [four, one] = [Samples::Four, Samples::One].map(|samples| {
            let canvas = Canvas::with_samples(&gpu, 100, 100, samples).unwrap();
            renderer.draw(&canvas, &[cell]).unwrap();
            canvas.read(&gpu).unwrap().rgba
        });
        let covered = four.chunks(4).filter(|p| p[3] > 127).count();
        let apart = |(a, b): (&[u8], &[u8])| (0..4).any(|i| a[i].abs_diff(b[i]) > 24);
        let differ = four.chunks(4).zip(one.chunks(4)).filter(|pair| apart(*pair)).count();
        assert!(covered > 2000 && differ < covered / 12, "{what}: {differ} of {covered}");
    }
}

/// The sphere with one vertex a pole, so that every edge belongs to two triangles.
fn closed_sphere(rings: u32) -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
    let (positions, triangles) = sphere(rings);
    let (columns, last) = (2 * rings, 2 * rings * rings);
    let merged = |v: u32| if v < columns { 0 } else { v.min(last) };
    let mut triangles: Vec<[u32; 3]> = triangles.into_iter().map(|t| t.map(merged)).collect();
    triangles.retain(|[a, b, c]| a != b && b != c && c != a);
    (positions, triangles)
}
