//! usage: trees MESH. Prints a table: building a tree over a mesh and asking it for closest points, by our tree of boxes and by
//! parry's BVH, both in double precision on one thread, alternating in one run; medians of seven.

use std::hint::black_box;
use std::time::Instant;

use chladni_mesh::surface::TriangleTree;
use parry3d_f64::math::Vector;
use parry3d_f64::query::PointQuery;
use parry3d_f64::shape::TriMesh;

const REPEATS: usize = 7;
const QUERIES: usize = 20_000;

fn timed<T>(times: &mut Vec<f64>, work: impl FnOnce() -> T) -> T {
    let start = Instant::now();
    let made = black_box(work());
    times.push(start.elapsed().as_secs_f64());
    made
}

fn median(mut times: Vec<f64>) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}

/// Points that a fixed rule spreads: near the surface, or anywhere in the box around it.
fn queries(positions: &[[f64; 3]], near: bool) -> Vec<[f64; 3]> {
    let low: [f64; 3] = std::array::from_fn(|c| positions.iter().map(|p| p[c]).fold(f64::INFINITY, f64::min));
    let high: [f64; 3] =
        std::array::from_fn(|c| positions.iter().map(|p| p[c]).fold(-f64::INFINITY, f64::max));
    let spread = |i: usize, c: usize| (i as f64 * [0.754_877_666, 0.569_840_290, 0.430_159_709][c]).fract();
    let at = |i: usize| {
        let vertex = positions[i * 7919 % positions.len()];
        std::array::from_fn(|c| {
            let room = high[c] - low[c];
            if near { vertex[c] + 0.02 * room * (spread(i, c) - 0.5) } else { low[c] + room * spread(i, c) }
        })
    };
    (0..QUERIES).map(at).collect()
}

fn main() {
    let path = std::env::args().nth(1).expect("usage: trees MESH");
    let mesh = chladni_mesh::load_mesh(path.as_ref()).expect("a mesh that can be read").mesh;
    let (positions, triangles) = (&mesh.positions, &mesh.triangles);
    let vector = |p: &[f64; 3]| Vector::new(p[0], p[1], p[2]);
    let (mut ours, mut theirs) = (Vec::new(), Vec::new());
    let mut trees = None;
    for _ in 0..REPEATS {
        let tree = timed(&mut ours, || TriangleTree::new(positions, triangles));
        let peer = timed(&mut theirs, || {
            TriMesh::new(positions.iter().map(vector).collect(), triangles.clone()).expect("triangles")
        });
        trees = Some((tree, peer));
    }
    let (tree, peer) = trees.expect("at least one repeat");
    println!(
        "{} vertices, {} triangles; milliseconds, for {QUERIES} points where points are asked for.\n",
        positions.len(),
        triangles.len()
    );
    println!("| what | ours | parry | times |\n|---|---|---|---|");
    row("building", ours, theirs);
    for (what, near) in
        [("closest, from within 1 % of the surface", true), ("closest, from anywhere in the box", false)]
    {
        let asked = queries(positions, near);
        let (mut ours, mut theirs) = (Vec::new(), Vec::new());
        for _ in 0..REPEATS {
            let a: Vec<f64> = timed(&mut ours, || {
                asked
                    .iter()
                    .map(|q| tree.closest(*q, f64::INFINITY).expect("a point").distance_squared.sqrt())
                    .collect()
            });
            let b: Vec<f64> = timed(&mut theirs, || {
                asked.iter().map(|q| peer.distance_to_local_point(vector(q), false)).collect()
            });
            let apart = a.iter().zip(&b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(apart < 1e-9, "the two disagree by {apart:e}");
        }
        row(what, ours, theirs);
    }
}

fn row(what: &str, ours: Vec<f64>, theirs: Vec<f64>) {
    let (a, b) = (1e3 * median(ours), 1e3 * median(theirs));
    println!("| {what} | {a:.1} | {b:.1} | {:.2} |", b / a);
}
