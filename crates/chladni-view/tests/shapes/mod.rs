//! Shapes and a device for the tests of drawing.

#![allow(dead_code, reason = "each test uses some of them")]

use chladni_view::{Device, Gpu, ViewError};

/// A device, or `None` with a printed line where this machine cannot draw at all.
pub fn gpu() -> Option<Gpu> {
    match Gpu::headless() {
        Ok(gpu) => Some(gpu),
        Err(ViewError::NoAdapter(reason)) => {
            eprintln!("skipped: no graphics adapter ({reason})");
            None
        }
        Err(error) => panic!("{error}"),
    }
}

/// Runs a test by the processor and, where a graphics device is there, by that.
pub fn on_each_device(test: impl Fn(&Device)) {
    test(&Device::Processor);
    gpu().iter().for_each(|gpu| test(&gpu.into()));
}

/// A unit sphere of `rings` × 2·`rings` quads, poles on y, wound outwards.
pub fn sphere(rings: u32) -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
    use std::f32::consts::{PI, TAU};
    let columns = 2 * rings;
    let mut positions = Vec::new();
    for i in 0..=rings {
        let (sin, cos) = (PI * i as f32 / rings as f32).sin_cos();
        for j in 0..columns {
            let (s, c) = (TAU * j as f32 / columns as f32).sin_cos();
            positions.push([sin * s, cos, sin * c]);
        }
    }
    let mut triangles = Vec::new();
    for i in 0..rings {
        for j in 0..columns {
            let (a, b) = (i * columns + j, i * columns + (j + 1) % columns);
            let (c, d) = (a + columns, b + columns);
            triangles.push([a, c, b]);
            triangles.push([b, c, d]);
        }
    }
    (positions, triangles)
}
