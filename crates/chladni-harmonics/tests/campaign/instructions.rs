//! Results on processors with different vector instructions. `CHLADNI_RESULTS=FILE` writes cases and results to FILE, or
//! compares with what another processor wrote there (`scripts/instructions`).
//!
//! The cases come from the file, too: sines and powers, of which they are made, are rounded as a processor's library does.

use std::fs::File;
use std::io::{BufRead, BufReader, BufWriter, Write};
use std::path::Path;

use chladni_harmonics::{Laplacian, SymmetricSparse};
use chladni_mesh::TriMesh;
use chladni_testdata::setting;
use serde::{Deserialize, Serialize};

use crate::cases::{Case, Found, Problem};

/// The bound: what eigenvalues may differ by, as a share of their own and of the largest of the matrix, and
/// how far a vector may leave the space of the other's group, as a share of its length.
const EIGENVALUE: f64 = 1e-9;
const ROUNDING: f64 = 2e-13;
const SPACE: f64 = 1e-6;
/// A group of eigenvalues ends where the next is farther by this share of itself and this share of the largest:
/// vectors of closer ones are mixed by the errors above.
const GAP: [f64; 2] = [1e-3, 1e-6];

/// A case as one line of the file.
#[derive(Serialize, Deserialize)]
struct Record {
    title: String,
    problem: Given,
    harmonics: usize,
    whole_clusters: bool,
    /// The largest eigenvalue of the matrix.
    largest: f64,
    /// `None` if it was refused.
    solved: Option<Solved>,
}

#[derive(Serialize, Deserialize)]
enum Given {
    Mesh { positions: Vec<[f64; 3]>, triangles: Vec<[u32; 3]>, laplacian: Laplacian },
    Pencil { entries: Vec<Entry>, mass: Vec<f64> },
    Consistent { rows: usize, stiffness: Vec<Entry>, mass: Vec<Entry> },
}

/// Row, column and value.
type Entry = (usize, usize, f64);

#[derive(Serialize, Deserialize)]
struct Solved {
    eigenvalues: Vec<f64>,
    vectors: Vec<f64>,
    mass: Vec<f64>,
    cuts_cluster: bool,
    is_certified: bool,
}

/// The greatest deviations, each as a share of its bound.
#[derive(Default)]
struct Deviation {
    eigenvalue: f64,
    space: f64,
}

#[test]
fn other_instructions_give_the_same_results() {
    let Some(file) = std::env::var_os("CHLADNI_RESULTS") else {
        println!("skipped: scripts/instructions compares processors");
        return;
    };
    let file = Path::new(&file);
    println!("solving with {}", instructions());
    if file.exists() { compare(file) } else { write(file) }
}

fn instructions() -> &'static str {
    #[cfg(target_arch = "x86_64")]
    {
        if is_x86_feature_detected!("avx512f") {
            return "AVX-512";
        }
        if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
            return "AVX2";
        }
    }
    if cfg!(target_arch = "aarch64") { "NEON" } else { "the instructions that every processor has" }
}

fn write(path: &Path) {
    let mut file = BufWriter::new(File::create(path).unwrap());
    for seed in 2_000_000..2_000_000 + setting("CHLADNI_CASES", 50) {
        let case = Case::of(seed);
        // A case that is no pencil is refused by the solver as well.
        let largest = case.problem.pencil().ok().and_then(|known| known.spectrum.last().copied());
        let record = Record {
            title: format!("case {seed}, {}", case.title()),
            problem: Given::of(&case.problem),
            harmonics: case.harmonics,
            whole_clusters: case.whole_clusters,
            largest: largest.unwrap_or(0.0),
            solved: case.solve(1).ok().map(Solved::of),
        };
        serde_json::to_writer(&mut file, &record).unwrap();
        file.write_all(b"\n").unwrap();
    }
    file.flush().unwrap();
}

#[allow(clippy::print_stdout, reason = "prints what it measured")]
fn compare(path: &Path) {
    let (mut greatest, mut cases, mut certified) = (Deviation::default(), 0, 0);
    let mut differing = Vec::new();
    for line in BufReader::new(File::open(path).unwrap()).lines() {
        let record: Record = serde_json::from_str(&line.unwrap()).unwrap();
        cases += 1;
        let here = record.case().solve(1).ok().map(Solved::of);
        let (here, there) = match (here, &record.solved) {
            (Some(here), Some(there)) => (here, there),
            (None, None) => continue,
            _ => {
                differing.push(format!("{}: refused by one processor only", record.title));
                continue;
            }
        };
        // Nothing bounds the errors of others.
        if !here.is_certified || !there.is_certified {
            continue;
        }
        certified += 1;
        if (here.eigenvalues.len(), here.cuts_cluster) != (there.eigenvalues.len(), there.cuts_cluster) {
            let counts = [here.eigenvalues.len(), there.eigenvalues.len()];
            differing.push(format!("{}: {counts:?} eigenvalues, or only one cuts a group", record.title));
            continue;
        }
        let deviation = there.deviation(&here, record.largest);
        if !deviation.is_within_bound() {
            differing.push(format!("{}: {}", record.title, deviation.in_words()));
        }
        greatest.eigenvalue = greatest.eigenvalue.max(deviation.eigenvalue);
        greatest.space = greatest.space.max(deviation.space);
    }
    println!("{cases} cases, {certified} certified on both processors: {}", greatest.in_words());
    assert!(certified > 0);
    assert!(differing.is_empty(), "{} differ:\n{}", differing.len(), differing.join("\n"));
}

impl Record {
    fn case(&self) -> Case {
        let problem = match &self.problem {
            Given::Mesh { positions, triangles, laplacian } => {
                let (positions, triangles) = (positions.clone(), triangles.clone());
                Problem::Mesh(TriMesh { positions, triangles, ..TriMesh::default() }, *laplacian)
            }
            Given::Pencil { entries, mass } => Problem::Pencil {
                stiffness: sparse(mass.len(), entries),
                mass: mass.clone(),
                known: Vec::new(),
            },
            Given::Consistent { rows, stiffness, mass } => Problem::Consistent {
                stiffness: sparse(*rows, stiffness),
                mass: sparse(*rows, mass),
                known: Vec::new(),
            },
        };
        let (harmonics, whole_clusters) = (self.harmonics, self.whole_clusters);
        Case { seed: 0, family: "recorded", problem, harmonics, whole_clusters }
    }
}

impl Given {
    fn of(problem: &Problem) -> Self {
        match problem {
            Problem::Mesh(mesh, laplacian) => Self::Mesh {
                positions: mesh.positions.clone(),
                triangles: mesh.triangles.clone(),
                laplacian: *laplacian,
            },
            Problem::Pencil { stiffness, mass, .. } => {
                Self::Pencil { entries: entries(mass.len(), stiffness), mass: mass.clone() }
            }
            Problem::Consistent { stiffness, mass, .. } => {
                let rows = stiffness.size();
                Self::Consistent { rows, stiffness: entries(rows, stiffness), mass: entries(rows, mass) }
            }
        }
    }
}

fn sparse(rows: usize, entries: &[Entry]) -> SymmetricSparse {
    SymmetricSparse::from_entries(rows, entries.iter().copied()).unwrap()
}

/// The lower triangle.
fn entries(rows: usize, matrix: &SymmetricSparse) -> Vec<Entry> {
    let lower = |j: usize| matrix.column(j).filter(move |(i, _)| *i >= j);
    (0..rows).flat_map(|j| lower(j).map(move |(i, value)| (i, j, value))).collect()
}

impl Solved {
    fn of(Found { basis, cuts_cluster }: Found) -> Self {
        let is_certified = basis.certificate.is_precise();
        let vectors = basis.vectors.to_vec();
        Self { eigenvalues: basis.eigenvalues, vectors, mass: basis.mass, cuts_cluster, is_certified }
    }

    fn vector(&self, k: usize) -> &[f64] {
        &self.vectors[k * self.mass.len()..][..self.mass.len()]
    }

    /// How far `other` is from this.
    fn deviation(&self, other: &Self, largest: f64) -> Deviation {
        let pairs = self.eigenvalues.iter().zip(&other.eigenvalues);
        let share = |(a, b): (&f64, &f64)| (a - b).abs() / (EIGENVALUE * a.abs() + ROUNDING * largest);
        let spaces = self.groups(largest).into_iter().map(|group| self.distance(other, group) / SPACE);
        Deviation { eigenvalue: greatest(pairs.map(share)), space: greatest(spaces) }
    }

    /// The groups of eigenvalues that are far from others, but for the last, which K may cut.
    fn groups(&self, largest: f64) -> Vec<std::ops::Range<usize>> {
        let is_end = |k: &usize| {
            let (below, above) = (self.eigenvalues[*k - 1], self.eigenvalues[*k]);
            above - below > GAP[0] * above + GAP[1] * largest
        };
        let ends: Vec<usize> = (1..self.eigenvalues.len()).filter(is_end).collect();
        let starts = std::iter::once(0).chain(ends.iter().copied());
        starts.zip(ends.iter().copied()).map(|(start, end)| start..end).collect()
    }

    /// The largest ‖h − B Bᵀ M h‖ of a group's vectors h of `other`, where B are those of this; lengths are M's.
    fn distance(&self, other: &Self, group: std::ops::Range<usize>) -> f64 {
        let weighted = |a: &[f64], b: &[f64]| -> f64 {
            a.iter().zip(b).zip(&self.mass).map(|((a, b), mass)| a * b * mass).sum()
        };
        greatest(group.clone().map(|k| {
            let mut rest = other.vector(k).to_vec();
            for b in group.clone().map(|j| self.vector(j)) {
                let share = weighted(b, &rest);
                rest.iter_mut().zip(b).for_each(|(rest, b)| *rest -= share * b);
            }
            weighted(&rest, &rest).sqrt()
        }))
    }
}

impl Deviation {
    fn is_within_bound(&self) -> bool {
        self.eigenvalue <= 1.0 && self.space <= 1.0
    }

    fn in_words(&self) -> String {
        let Self { eigenvalue, space } = self;
        format!("eigenvalues differ by up to {eigenvalue:.1e} of the bound, spaces by {:.1e}", space * SPACE)
    }
}

/// The greatest of the values; not a number if one is none.
fn greatest(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(0.0, |a, b| if b > a || b.is_nan() { b } else { a })
}
