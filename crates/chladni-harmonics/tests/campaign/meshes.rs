//! Meshes that are hard for an eigensolver.

use chladni_mesh::{TriMesh, samples};
use rand::seq::SliceRandom;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::pencils::size;
use crate::shapes;

/// The largest ratio of widths in a graded mesh is ten to this.
const MOST_DECADES: f64 = 8.0;

/// A curved sheet whose column and row widths span up to eight orders of magnitude.
pub fn graded(rng: &mut ChaCha8Rng, most: usize) -> TriMesh {
    let columns = ((size(rng, 9, most) as f64).sqrt().ceil() as usize).max(3);
    let decades = if rng.random_bool(0.25) { MOST_DECADES } else { rng.random_range(0.0..MOST_DECADES) };
    let across = if rng.random_bool(0.5) { decades } else { 0.0 };
    let (xs, ys) = (places(columns, decades), places(columns, across));
    let bend = rng.random_range(0.0..0.5);
    let sheet = shapes::square(columns as u32 - 1);
    let positions = (0..columns * columns)
        .map(|v| {
            let (x, y) = (xs[v % columns], ys[v / columns]);
            [x, y, bend * x * x]
        })
        .collect();
    TriMesh { positions, ..sheet }
}

/// The places of at least three columns, whose widths fall by `decades` orders of magnitude from the first to the last.
fn places(columns: usize, decades: f64) -> Vec<f64> {
    let width = |i: usize| 10_f64.powf(-decades * i as f64 / (columns - 2) as f64);
    let add = |at: &mut f64, i: usize| {
        *at += width(i);
        Some(*at)
    };
    std::iter::once(0.0).chain((0..columns - 1).scan(0.0, add)).collect()
}

/// A sound mesh with some vertices moved almost onto a neighbor or a line.
pub fn slivers(rng: &mut ChaCha8Rng, most: usize) -> TriMesh {
    let mut mesh = sound(rng, most);
    let thin = 10_f64.powf(rng.random_range(-9.0..-1.0));
    let share = rng.random_range(0.05..1.0);
    for t in mesh.triangles.clone() {
        if rng.random_bool(share) {
            let [a, b, c] = t.map(|v| mesh.positions[v as usize]);
            let along = if rng.random_bool(0.5) { 0.0 } else { rng.random_range(0.2..0.8) };
            mesh.positions[t[2] as usize] = std::array::from_fn(|i| {
                let foot = a[i] + along * (b[i] - a[i]);
                foot + thin * (c[i] - foot)
            });
        }
    }
    mesh
}

/// Components of many sizes, some of them equal.
pub fn disconnected(rng: &mut ChaCha8Rng, most: usize) -> TriMesh {
    // Where slices are to meet them, each is large enough for some.
    let largest = if most > 300 { most / 2 } else { most.min(100) };
    let kinds: Vec<TriMesh> = (0..rng.random_range(1..4)).map(|_| sound(rng, largest)).collect();
    let mut parts: Vec<TriMesh> = Vec::new();
    let mut left = most;
    while parts.len() < 2 || rng.random_bool(0.8) {
        let part = &kinds[rng.random_range(0..kinds.len())];
        if part.positions.len() > left && parts.len() > 1 {
            break;
        }
        left = left.saturating_sub(part.positions.len());
        let smaller = if rng.random_bool(0.6) { 1.0 } else { 10_f64.powf(rng.random_range(-4.0..0.0)) };
        parts.push(shapes::scaled(part, smaller));
    }
    shapes::beside(&parts, [3.0, 0.0, 0.0])
}

/// Random triangles on few points: edges with many triangles, bodies that share a vertex.
pub fn crowded(rng: &mut ChaCha8Rng, most: usize) -> TriMesh {
    let n = size(rng, 4, most.min(400)) as u32;
    let mut point = || std::array::from_fn(|_| rng.random_range(-1.0..1.0));
    let positions: Vec<[f64; 3]> = (0..n).map(|_| point()).collect();
    let mut order: Vec<u32> = (0..n).collect();
    order.shuffle(rng);
    // A strip through all points, and triangles at random.
    let mut triangles: Vec<[u32; 3]> = order.windows(3).map(|w| [w[0], w[1], w[2]]).collect();
    for _ in 0..rng.random_range(0..n) {
        let t = std::array::from_fn(|_| rng.random_range(0..n));
        triangles.push(t);
    }
    triangles.retain(|t| rng.random_bool(0.9) || t[0] == order[0]);
    shapes::mesh(positions, triangles)
}

/// Any of the other meshes, scaled by 10⁻¹² or 10¹².
pub fn far_scaled(rng: &mut ChaCha8Rng, most: usize) -> TriMesh {
    let mesh = match rng.random_range(0..4) {
        0 => graded(rng, most),
        1 => disconnected(rng, most),
        2 => crowded(rng, most),
        _ => sound(rng, most),
    };
    shapes::scaled(&mesh, if rng.random_bool(0.5) { 1e12 } else { 1e-12 })
}

/// Meshes that the papers' Laplacian has weights for: at most two triangles at an edge, and none without area.
pub fn plain(rng: &mut ChaCha8Rng, most: usize) -> TriMesh {
    match rng.random_range(0..4) {
        0 => graded(rng, most),
        1 => disconnected(rng, most),
        2 => slivers(rng, most),
        _ => sound(rng, most),
    }
}

fn sound(rng: &mut ChaCha8Rng, most: usize) -> TriMesh {
    let n = size(rng, 9, most);
    let side = (n as f64).sqrt().ceil() as u32;
    match rng.random_range(0..5) {
        0 => shapes::icosphere([42, 162, 300].iter().filter(|most| n > **most).count() as u32),
        1 => samples::torus(0.4, side + 2, side),
        2 => shapes::square(side.max(2)),
        3 => samples::uv_sphere(side, side),
        _ => {
            let mut mesh = shapes::square(side.max(2));
            for p in &mut mesh.positions {
                p.iter_mut().for_each(|x| *x += 0.3 / f64::from(side) * rng.random_range(-1.0..1.0));
            }
            mesh
        }
    }
}

#[test]
fn the_widths_of_graded_meshes_reach_eight_orders_of_magnitude() {
    let ratio = |places: &[f64]| {
        let n = places.len();
        (places[1] - places[0]) / (places[n - 1] - places[n - 2])
    };
    for columns in 3..31 {
        let reached = ratio(&places(columns, MOST_DECADES));
        assert!((reached / 1e8 - 1.0).abs() < 1e-6, "{columns} columns: {reached:e}");
    }
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let widths = |mesh: TriMesh| {
        let row = mesh.positions.iter().take_while(|p| p[1] == 0.0).map(|p| p[0]);
        ratio(&row.collect::<Vec<_>>())
    };
    let reached = (0..80).filter(|_| widths(graded(&mut rng, 150)) > 0.99e8).count();
    assert!(reached >= 10, "{reached} of 80");
}
