//! Moves every head and animal by random similarities and matches it with its original. Prints a line per
//! mesh and one for all. Fails if fewer than 99 % of the poses are recovered to 1e-5 of the diagonal.
//!
//! Usage: `poses [POSES_PER_MESH] [icp|fit] [MESH …]`, with names as in `meshes/` of the shared data.
#![allow(clippy::print_stdout, reason = "a program")]

use std::time::Instant;

use chladni_match::{Match, MatchSettings, Method, Similarity, match_shapes};
use chladni_mesh::{TriMesh, load_mesh};
use chladni_task::Task;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Ten of them: with 20 poses each, 200.
const MESHES: [&str; 10] = [
    "heads/igea.ply",
    "heads/decimated-max.obj",
    "heads/demosthenes-low-res.obj",
    "heads/face.obj",
    "heads/target.obj",
    "animals/lion.off",
    "animals/goathead.obj",
    "animals/spot.obj",
    "animals/koala.obj",
    "shapes/armadillo.obj",
];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let poses: usize = arguments.next().map_or(Ok(20), |n| n.parse())?;
    let method = match arguments.next().as_deref() {
        None | Some("icp") => Method::Icp,
        Some("fit") => Method::Fit,
        Some(other) => return Err(format!("{other}: expected icp or fit").into()),
    };
    let named: Vec<String> = arguments.collect();
    let meshes = if named.is_empty() { MESHES.map(String::from).to_vec() } else { named };
    println!("| mesh | vertices | recovered | worst pose | worst point | near ties | median s |");
    println!("|---|---|---|---|---|---|---|");
    let (mut good, mut all) = (0, 0);
    for (index, name) in meshes.iter().enumerate() {
        let Some(path) = chladni_testdata::shared(&format!("meshes/{name}")) else { continue };
        let mesh = load_mesh(&path)?.mesh;
        let mut row = Row::default();
        for pose in 0..poses {
            let mut rng = ChaCha8Rng::seed_from_u64((index * 1000 + pose) as u64);
            row.add(&mesh, &random_similarity(&mesh, &mut rng), method, pose as u64)?;
        }
        row.seconds.sort_by(f64::total_cmp);
        println!(
            "| {name} | {} | {} of {poses} | {:.1e} | {:.1e} | {} | {:.2} |",
            mesh.positions.len(),
            row.recovered,
            row.worst_pose,
            row.worst_point,
            row.near_ties,
            row.seconds.get(poses / 2).copied().unwrap_or(0.0),
        );
        good += row.recovered;
        all += poses;
    }
    println!("{good} of {all} recovered");
    if good * 100 >= all * 99 { Ok(()) } else { Err("fewer than 99 % of the poses were recovered".into()) }
}

#[derive(Default)]
struct Row {
    recovered: usize,
    /// Largest distance between a vertex and the place where its pose puts it, as a share of the diagonal.
    worst_pose: f64,
    /// The same for the template point that the vertex got.
    worst_point: f64,
    near_ties: usize,
    seconds: Vec<f64>,
}

impl Row {
    /// A pose is recovered if every vertex returns to its place within 1e-5 of the diagonal.
    fn add(
        &mut self,
        mesh: &TriMesh,
        moved: &Similarity,
        method: Method,
        seed: u64,
    ) -> Result<(), Box<dyn std::error::Error>> {
        let mut template = mesh.clone();
        template.positions.iter_mut().for_each(|p| *p = moved.apply(*p));
        let settings = MatchSettings { method, seed, ..MatchSettings::default() };
        let start = Instant::now();
        let Match { correspondence: found, report } = match_shapes(mesh, &template, &settings, &Task::new())?;
        self.seconds.push(start.elapsed().as_secs_f64());
        let diagonal = diagonal(mesh);
        let (mut pose, mut point) = (0.0_f64, 0.0_f64);
        for (v, p) in mesh.positions.iter().enumerate() {
            pose = pose.max(distance(&found.similarity.apply(template.positions[v]), p) / diagonal);
            point = point.max(distance(&found.target[v], p) / diagonal);
        }
        self.recovered += usize::from(pose.max(point) <= 1e-5);
        self.near_ties += usize::from(report.near_tie);
        self.worst_pose = self.worst_pose.max(pose);
        self.worst_point = self.worst_point.max(point);
        Ok(())
    }
}

/// Any rotation, a size between a hundredth and a hundred times, a place up to ten diagonals off.
fn random_similarity(mesh: &TriMesh, rng: &mut ChaCha8Rng) -> Similarity {
    let q = loop {
        let q: [f64; 4] = std::array::from_fn(|_| rng.random_range(-1.0..1.0));
        let length = q.iter().map(|x| x * x).sum::<f64>().sqrt();
        if (0.1..1.0).contains(&length) {
            break q.map(|x| x / length);
        }
    };
    let [w, x, y, z] = q;
    let rotation = [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
        [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
        [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
    ];
    let scale = 10.0_f64.powf(rng.random_range(-2.0..2.0));
    let reach = 10.0 * diagonal(mesh) * scale;
    let translation = std::array::from_fn(|_| rng.random_range(-reach..reach));
    Similarity { scale, rotation, translation }
}

fn distance(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt()
}

fn diagonal(mesh: &TriMesh) -> f64 {
    let bound = |pick: fn(f64, f64) -> f64, start: f64| -> [f64; 3] {
        std::array::from_fn(|i| mesh.positions.iter().map(|p| p[i]).fold(start, pick))
    };
    distance(&bound(f64::min, f64::INFINITY), &bound(f64::max, f64::NEG_INFINITY))
}
