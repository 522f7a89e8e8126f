//! A bumpy sphere of any number of vertices, and smooth functions on it in place of a basis.

use std::f64::consts::{PI, TAU};

use rayon::prelude::*;

/// A closed surface of exactly `vertices` (at least 8) vertices and 2n − 4 triangles: rings
/// between two poles, zipped together.
pub fn bumpy_sphere(vertices: usize) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
    let sizes = ring_sizes(vertices.max(8) - 2);
    let mut positions = vec![point(0.0, 0.0)];
    let mut triangles = Vec::new();
    let mut previous = 0..1_u32;
    for (i, &size) in sizes.iter().enumerate() {
        let theta = PI * (i + 1) as f64 / (sizes.len() + 1) as f64;
        let first = positions.len() as u32;
        positions.extend((0..size).map(|j| point(theta, TAU * j as f64 / size as f64)));
        let ring = first..positions.len() as u32;
        zip(previous, ring.clone(), &mut triangles);
        previous = ring;
    }
    let pole = positions.len() as u32;
    positions.push(point(PI, 0.0));
    zip(previous, pole..pole + 1, &mut triangles);
    (positions, triangles)
}

/// Vertices of each ring, in proportion to its length; `total` in all.
fn ring_sizes(total: usize) -> Vec<usize> {
    let rings = (((total as f64) * PI).sqrt() / 2.0).round().max(1.0) as usize;
    let length = |i: usize| (PI * (i + 1) as f64 / (rings + 1) as f64).sin();
    let lengths: f64 = (0..rings).map(length).sum();
    let (mut sizes, mut given, mut due) = (Vec::new(), 0, 0.0);
    for i in 0..rings {
        due += length(i) / lengths * total as f64;
        let size = if i + 1 == rings { total.saturating_sub(given) } else { due.round() as usize - given };
        sizes.push(size.max(3));
        given += size.max(3);
    }
    // Rings of at least three can overshoot; the widest gives it back.
    let widest = rings / 2;
    sizes[widest] = (sizes[widest] + total).saturating_sub(sizes.iter().sum());
    sizes
}

/// Triangles between two rings, always closing the shorter gap in angle.
fn zip(above: std::ops::Range<u32>, below: std::ops::Range<u32>, triangles: &mut Vec<[u32; 3]>) {
    let (a, b) = (above.len() as u32, below.len() as u32);
    let at = |ring: &std::ops::Range<u32>, i: u32| ring.start + i % ring.len() as u32;
    let (mut i, mut j) = (0, 0);
    let (steps_a, steps_b) = (if a > 1 { a } else { 0 }, if b > 1 { b } else { 0 });
    while i < steps_a || j < steps_b {
        let along_above = j == steps_b
            || (i < steps_a && u64::from(i + 1) * u64::from(b) <= u64::from(j + 1) * u64::from(a));
        if along_above {
            triangles.push([at(&above, i), at(&below, j), at(&above, i + 1)]);
            i += 1;
        } else {
            triangles.push([at(&above, i), at(&below, j), at(&below, j + 1)]);
            j += 1;
        }
    }
}

fn point(theta: f64, phi: f64) -> [f64; 3] {
    let r = 0.9 + 0.08 * (5.0 * theta).sin() * (4.0 * phi).cos();
    [r * theta.sin() * phi.cos(), r * theta.cos(), r * theta.sin() * phi.sin()]
}

/// N×K column-major waves, finer as k grows: harmonic k is cos(|d_k| d_k·x + k) for K
/// directions d_k. Not orthonormal, which changes no timing.
pub fn waves(positions: &[[f64; 3]], harmonics: usize) -> Vec<f64> {
    let mut basis = vec![0.0; positions.len() * harmonics];
    basis.par_chunks_mut(positions.len().max(1)).enumerate().for_each(|(k, h)| {
        let k = k as f64;
        let (turn, tilt) = (2.399_963 * k, (0.618_034 * k).fract() * 2.0 - 1.0);
        let flat = (1.0 - tilt * tilt).sqrt();
        let d = [flat * turn.cos(), tilt, flat * turn.sin()].map(|d| d * k.sqrt());
        for (h, x) in h.iter_mut().zip(positions) {
            *h = (d[0] * x[0] + d[1] * x[1] + d[2] * x[2] + k).cos();
        }
    });
    basis
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spheres_are_closed_and_have_the_vertices_asked_for() {
        for n in [8, 9, 31, 622, 766, 2108, 4695, 30059] {
            let (positions, triangles) = bumpy_sphere(n);
            assert_eq!(positions.len(), n);
            assert_eq!(triangles.len(), 2 * n - 4);
            let mut edges: Vec<[u32; 2]> =
                triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]).collect();
            edges.sort_unstable();
            let count = edges.len();
            edges.dedup();
            assert_eq!(edges.len(), count, "each half-edge once");
            assert!(edges.iter().all(|&[a, b]| edges.binary_search(&[b, a]).is_ok()), "and its opposite");
        }
    }
}
