//! Pencils with prescribed spectra.

use std::f64::consts::PI;

use chladni_harmonics::SymmetricSparse;
use rand::RngExt;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;

use crate::cases::Problem;

/// The largest value of L beside its diagonal in [`consistent`]: xᵀM⁻¹x is then at most 4 xᵀD⁻¹x, where D is the diagonal of M.
const BESIDE: f64 = 0.4;

/// A random size: small sizes are as likely as sizes ten times as large.
pub fn size(rng: &mut ChaCha8Rng, least: usize, most: usize) -> usize {
    let least = if most > 300 { 310 } else { least };
    ((least as f64).ln() + rng.random::<f64>() * (most as f64 / least as f64).ln()).exp().round() as usize
}

/// A few different eigenvalues, each with a high multiplicity; 0 may be one of them.
pub fn multiple(rng: &mut ChaCha8Rng, most: usize) -> Problem {
    let n = size(rng, 2, most);
    let levels: Vec<f64> = (0..rng.random_range(1..9)).map(|_| rng.random_range(0.0..10.0)).collect();
    let lowest = if rng.random_bool(0.5) { 0.0 } else { levels[0] };
    let spectrum = (0..n).map(|_| match rng.random_range(0..=levels.len()) {
        0 => lowest,
        at => levels[at - 1],
    });
    let spectrum: Vec<f64> = spectrum.collect();
    rotated(rng, spectrum)
}

/// Eigenvalues in clusters, from barely distinguishable to indistinguishable.
pub fn clustered(rng: &mut ChaCha8Rng, most: usize) -> Problem {
    let n = size(rng, 3, most);
    let centers: Vec<f64> = (0..rng.random_range(1..7)).map(|_| rng.random_range(0.1..10.0)).collect();
    let width = 10_f64.powf(rng.random_range(-14.0..-2.0));
    let near = |rng: &mut ChaCha8Rng| {
        centers[rng.random_range(0..centers.len())] * (1.0 + width * rng.random_range(-1.0..1.0))
    };
    let spectrum: Vec<f64> = (0..n).map(|_| near(rng)).collect();
    rotated(rng, spectrum)
}

/// Eigenvalues that span up to ten orders of magnitude.
pub fn graded(rng: &mut ChaCha8Rng, most: usize) -> Problem {
    let n = size(rng, 2, most);
    let decades = rng.random_range(1.0..10.0);
    let spectrum: Vec<f64> = (0..n).map(|_| 10_f64.powf(-decades * rng.random::<f64>())).collect();
    rotated(rng, spectrum)
}

/// M^½ Q Λ Qᵀ M^½, where Q is a product of rotations of neighboring rows; the rows are shuffled.
fn rotated(rng: &mut ChaCha8Rng, mut spectrum: Vec<f64>) -> Problem {
    let n = spectrum.len();
    let mut a = vec![vec![0.0; n]; n];
    spectrum.iter().enumerate().for_each(|(i, value)| a[i][i] = *value);
    let sweeps = rng.random_range(1..5);
    let reach = (2 * sweeps + 2).min(n);
    for sweep in 0..sweeps {
        for i in (sweep % 2..n.saturating_sub(1)).step_by(2) {
            let (s, c) = rng.random_range(0.0..2.0 * PI).sin_cos();
            let near = i.saturating_sub(reach)..(i + 2 + reach).min(n);
            for j in near.clone() {
                let (x, y) = (a[i][j], a[i + 1][j]);
                (a[i][j], a[i + 1][j]) = (c * x - s * y, s * x + c * y);
            }
            for row in &mut a[near] {
                let (x, y) = (row[i], row[i + 1]);
                (row[i], row[i + 1]) = (c * x - s * y, s * x + c * y);
            }
        }
    }
    let scale = 10_f64.powf(rng.random_range(-12.0..12.0));
    let spread = if rng.random_bool(0.5) { 0.0 } else { rng.random_range(0.0..6.0) };
    let mass: Vec<f64> = (0..n).map(|_| 10_f64.powf(spread * rng.random_range(-1.0..1.0))).collect();
    let mut place: Vec<usize> = (0..n).collect();
    place.shuffle(rng);
    let mut entries = Vec::new();
    for i in 0..n {
        for j in i.saturating_sub(2 * reach)..=i {
            let value = 0.5 * (a[i][j] + a[j][i]);
            if value != 0.0 || i == j {
                let (p, q) = (place[i], place[j]);
                entries.push((p, q, value * scale * (mass[p] * mass[q]).sqrt()));
            }
        }
    }
    spectrum.iter_mut().for_each(|value| *value *= scale);
    spectrum.sort_by(f64::total_cmp);
    let stiffness = SymmetricSparse::from_entries(n, entries).unwrap();
    Problem::Pencil { stiffness, mass, known: spectrum }
}

/// Equal components, which share every eigenvalue, with their rows in random order.
pub fn duplicated(rng: &mut ChaCha8Rng, most: usize) -> Problem {
    // Where slices are to meet them, each is large enough for some.
    let largest = if most > 300 { most / 2 } else { most.min(60) };
    let part = match rng.random_range(0..3) {
        0 => multiple(rng, largest),
        1 => graded(rng, largest),
        _ => graph(rng, largest),
    };
    let Problem::Pencil { stiffness, mass, known } = part else { return part };
    let n = mass.len();
    let copies = rng.random_range(2..=(most / n).clamp(2, 40));
    let mut place: Vec<usize> = (0..n * copies).collect();
    place.shuffle(rng);
    let mut all_mass = vec![0.0; n * copies];
    let mut entries = Vec::new();
    for copy in 0..copies {
        for j in 0..n {
            all_mass[place[copy * n + j]] = mass[j];
            let lower = stiffness.column(j).filter(|(i, _)| *i >= j);
            entries.extend(lower.map(|(i, value)| (place[copy * n + i], place[copy * n + j], value)));
        }
    }
    let stiffness = SymmetricSparse::from_entries(n * copies, entries).unwrap();
    let known = known.into_iter().flat_map(|value| vec![value; copies]).collect();
    Problem::Pencil { stiffness, mass: all_mass, known }
}

/// A pencil whose M is not diagonal: B S Bᵀ and B M Bᵀ of another, where B is D^½ L D^-½ with the diagonal D of M, and L is 1
/// on its diagonal and at most [`BESIDE`] below; its spectrum stays.
pub fn consistent(rng: &mut ChaCha8Rng, most: usize) -> Problem {
    let other = match rng.random_range(0..4) {
        0 => multiple(rng, most),
        1 => clustered(rng, most),
        2 => graded(rng, most),
        _ => graph(rng, most),
    };
    let Problem::Pencil { stiffness, mass, known } = other else { return other };
    let n = mass.len();
    // Some are 0, so that parts may stay apart.
    let beside = |v: usize, rng: &mut ChaCha8Rng| match v {
        _ if v == 0 || v == n || rng.random_bool(0.3) => 0.0,
        _ => rng.random_range(-BESIDE..BESIDE) * (mass[v] / mass[v - 1]).sqrt(),
    };
    let beside: &Vec<f64> = &(0..=n).map(|v| beside(v, rng)).collect();
    let congruent = |matrix: &SymmetricSparse| {
        let entries = (0..n).flat_map(|j| {
            let spread = move |(i, value): (usize, f64)| {
                let (down, right) = (beside[i + 1], beside[j + 1]);
                [
                    (i, j, value),
                    (i + 1, j, down * value),
                    (i, j + 1, right * value),
                    (i + 1, j + 1, down * right * value),
                ]
            };
            matrix.column(j).flat_map(spread).filter(|(i, j, value)| j <= i && *i < n && *value != 0.0)
        });
        SymmetricSparse::from_entries(n, entries.collect::<Vec<_>>()).unwrap()
    };
    let mass = SymmetricSparse::from_entries(n, mass.iter().enumerate().map(|(v, m)| (v, v, *m))).unwrap();
    Problem::Consistent { stiffness: congruent(&stiffness), mass: congruent(&mass), known }
}

/// Graphs whose spectra are known: complete, star, ring, hypercube, torus of a grid.
pub fn graph(rng: &mut ChaCha8Rng, most: usize) -> Problem {
    let n = size(rng, 3, most).max(3);
    let ring = |n: usize, i: usize| 2.0 - 2.0 * (2.0 * PI * i as f64 / n as f64).cos();
    let (edges, known): (Vec<(usize, usize)>, Vec<f64>) = match rng.random_range(0..5) {
        0 => {
            let n = n.min(200);
            let edges = (0..n).flat_map(|i| (0..i).map(move |j| (i, j))).collect();
            (edges, (0..n).map(|i| if i == 0 { 0.0 } else { n as f64 }).collect())
        }
        1 => {
            let value = |i: usize| {
                if i == 0 {
                    0.0
                } else if i + 1 == n {
                    n as f64
                } else {
                    1.0
                }
            };
            ((1..n).map(|i| (0, i)).collect(), (0..n).map(value).collect())
        }
        2 => ((0..n).map(|i| (i, (i + 1) % n)).collect(), (0..n).map(|i| ring(n, i)).collect()),
        3 => {
            let dimensions = n.ilog2();
            let corner = |i: usize| (0..dimensions).map(move |d| (i, i ^ (1 << d))).filter(|(i, j)| i < j);
            let edges = (0..1 << dimensions).flat_map(corner).collect();
            (edges, (0..1_usize << dimensions).map(|i| 2.0 * f64::from(i.count_ones())).collect())
        }
        _ => {
            let wide = ((n as f64).sqrt() as usize).max(3);
            let at = |x: usize, y: usize| x % wide + wide * (y % wide);
            let all = (0..wide).flat_map(|y| (0..wide).map(move |x| (x, y)));
            let edges = all.clone().flat_map(|(x, y)| [(at(x, y), at(x + 1, y)), (at(x, y), at(x, y + 1))]);
            (edges.collect(), all.map(|(x, y)| ring(wide, x) + ring(wide, y)).collect())
        }
    };
    let mut known = known;
    known.sort_by(f64::total_cmp);
    let n = known.len();
    let entries = edges.into_iter().flat_map(|(i, j)| [(i, i, 1.0), (j, j, 1.0), (i, j, -1.0)]);
    let stiffness = SymmetricSparse::from_entries(n, entries).unwrap();
    Problem::Pencil { stiffness, mass: vec![1.0; n], known }
}
