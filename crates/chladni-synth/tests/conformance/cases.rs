//! Random shapes and frames from seeds.

use std::f64::consts::TAU;

use chladni_synth::{Coefficients, Item, Residual, Term};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::reference::Shape;

/// A bumpy torus of `rings × sides` vertices, with a few extra triangles (a fin, a collapsed one) and a
/// random basis of `harmonics` columns of very different scales.
pub fn shape(seed: u64, rings: u32, sides: u32, harmonics: usize) -> Shape {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut positions = Vec::new();
    for i in 0..rings {
        for j in 0..sides {
            let (u, v) = (TAU * f64::from(i) / f64::from(rings), TAU * f64::from(j) / f64::from(sides));
            let r = 0.3 + 0.05 * rng.random_range(-1.0..1.0);
            let d = 0.6 + r * v.cos();
            positions.push([d * u.cos(), d * u.sin(), r * v.sin()]);
        }
    }
    let at = |i: u32, j: u32| (i % rings) * sides + j % sides;
    let mut triangles = Vec::new();
    for i in 0..rings {
        for j in 0..sides {
            triangles.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
            triangles.push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
        }
    }
    triangles.push([at(0, 0), at(1, 1), at(rings / 2, 0)]);
    triangles.push([at(0, 0), at(1, 1), at(1, 1)]);
    let mut basis = Vec::new();
    for k in 0..harmonics {
        let size = 10.0_f64.powf(rng.random_range(-2.0..1.0));
        // One harmonic is zero everywhere, as in a badly scaled input.
        let size = if k == 3 { 0.0 } else { size };
        basis.extend((0..positions.len()).map(|_| size * rng.random_range(-1.0..1.0)));
    }
    Shape { positions, triangles, basis }
}

/// `count` items of one to three terms in all forms: with and without masks (one of them all zero),
/// residuals, gains of zero, short and sparse coefficients. Some items have no term.
pub fn items(seed: u64, shape: &Shape, count: usize) -> Vec<Item> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let n = shape.vertices();
    (0..count)
        .map(|_| {
            let terms = if rng.random_bool(0.1) { 0 } else { rng.random_range(1..=3) };
            Item { terms: (0..terms).map(|_| term(&mut rng, n, shape.harmonics())).collect() }
        })
        .collect()
}

fn term(rng: &mut ChaCha8Rng, n: usize, harmonics: usize) -> Term {
    let len = if rng.random_bool(0.5) { harmonics } else { rng.random_range(0..=harmonics) };
    let size = 0.3 / (1.0 + len as f32).sqrt();
    let sparse = if rng.random_bool(0.3) { 0.9 } else { 0.05 };
    let vector = rng.random_bool(0.5);
    let mut value = |silence: f64| {
        let c = rng.random_range(-size..size);
        if rng.random_bool(silence) { 0.0 } else { c }
    };
    let coefficients = if vector {
        Coefficients::Vector((0..len).map(|_| std::array::from_fn(|_| value(sparse))).collect())
    } else {
        Coefficients::Normal((0..len).map(|_| value(sparse)).collect())
    };
    let residual = rng.random_bool(0.5).then(|| {
        if vector {
            Residual::Vector((0..n).map(|_| std::array::from_fn(|_| rng.random_range(-0.1..0.1))).collect())
        } else {
            Residual::Normal((0..n).map(|_| rng.random_range(-0.1..0.1)).collect())
        }
    });
    let residual_gain = if rng.random_bool(0.3) { 0.0 } else { rng.random_range(-2.0..2.0) };
    let mask = rng.random_bool(0.5).then(|| {
        let empty = rng.random_bool(0.2);
        (0..n).map(|_| if empty { 0.0 } else { rng.random_range(0.0..1.0) }).collect()
    });
    Term { coefficients, residual, residual_gain, mask }
}
