//! Points spread evenly over a surface.

use glam::DVec3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::surface::UnitSurface;

/// A point of a surface and the normal there.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sample {
    pub point: DVec3,
    pub normal: DVec3,
}

/// `count` points, stratified by area along the list of triangles.
pub(crate) fn spread(surface: &UnitSurface, count: usize, seed: u64) -> Vec<Sample> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let step = surface.area() / count as f64;
    let mut samples = Vec::with_capacity(count);
    let mut before = 0.0;
    for (t, area) in surface.triangle_areas.iter().enumerate() {
        while samples.len() < count {
            let at = (samples.len() as f64 + 0.5) * step;
            if at > before + area {
                break;
            }
            let (u, v): (f64, f64) = (rng.random(), rng.random());
            let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
            let [a, b, c] = surface.triangles[t].map(|v| v as usize);
            let p = &surface.points;
            let n = &surface.normals;
            let normal = n[a] * (1.0 - u - v) + n[b] * u + n[c] * v;
            samples.push(Sample {
                point: p[a] * (1.0 - u - v) + p[b] * u + p[c] * v,
                normal: normal.try_normalize().unwrap_or(surface.triangle_normals[t]),
            });
        }
        before += area;
    }
    // The file's order runs along the surface. Shuffled, every prefix of the list is a fair sample.
    for i in (1..samples.len()).rev() {
        samples.swap(i, rng.random_range(0..=i));
    }
    samples
}
