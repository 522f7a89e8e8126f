//! Vertex stages look up their data in textures where a device has no storage, as in WebGL2.

use super::*;

/// A device that lends as little as WebGL2 does.
fn without_storage() -> Option<Gpu> {
    match Gpu::headless_within(wgpu::Limits::downlevel_webgl2_defaults()) {
        Ok(gpu) => Some(gpu),
        Err(ViewError::NoAdapter(reason)) => {
            eprintln!("skipped: no graphics adapter ({reason})");
            None
        }
        Err(error) => panic!("{error}"),
    }
}

#[test]
fn textures_serve_as_storage_does() {
    let (Some(rich), Some(poor)) = (gpu(), without_storage()) else { return };
    let devices = [Device::from(&rich), Device::from(&poor)];
    // Several rows of a texture, and a part of one. (Mesa 22.3 draws the wires of the coarse one for minutes at the larger size.)
    for (rings, size) in [(40, [240, 200]), (7, [200, 160])] {
        let models = devices.each_ref().map(|device| Model::new(device, rings));
        for (name, look) in LOOKS {
            let [storage, textures] = models.each_ref().map(|model| look(model, size));
            let apart: Vec<f64> =
                storage.rgba.iter().zip(&textures.rgba).map(|(a, b)| f64::from(a.abs_diff(*b))).collect();
            let mean = apart.iter().sum::<f64>() / apart.len() as f64;
            let off = misplaced(&storage, &textures, 20);
            eprintln!("{name}, {rings} rings: {mean:.4} of 255, {off} off");
            // Places out of focus use other depths of a pixel, which shows along outlines.
            let (most, few) = if name.contains("out of focus") { (1.0, 240) } else { (0.0, 0) };
            assert!(mean <= most && off <= few, "{name}, {rings} rings: {mean} of 255, {off} pixels");
        }
    }
}

#[test]
fn what_no_texture_holds_is_an_error() {
    let limits = wgpu::Limits { max_texture_dimension_2d: 512, ..wgpu::Limits::downlevel_webgl2_defaults() };
    let Some(_) = gpu() else { return };
    let device = Device::from(&Gpu::headless_within(limits).unwrap());
    // 512 rows of 2048 numbers are fewer than the corners of 2 · 300 · 600 triangles.
    let model = Model::new(&device, 300);
    let figures = [Figure { wire: Some(Wire::default()), ..model.figure() }];
    let canvas = Canvas::new(&device, 20, 20).unwrap();
    let drawn = Renderer::new(&device).draw(&canvas, &[model.cell(&figures, [20, 20])]);
    assert!(matches!(drawn, Err(ViewError::Shape(_))), "{drawn:?}");
}
