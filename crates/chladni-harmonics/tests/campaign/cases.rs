//! The cases: a family, a problem, and the number of harmonics to solve for.

use chladni_harmonics::{
    Basis, BasisSettings, Body, BuildReport, HarmonicsError, Laplacian, Operator, Pencil, SymmetricSparse,
};
use chladni_mesh::TriMesh;
use chladni_task::Task;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::spectrum::spectrum;
use crate::{meshes, pencils};

pub struct Case {
    pub family: &'static str,
    pub problem: Problem,
    pub harmonics: usize,
    pub whole_clusters: bool,
}

pub enum Problem {
    Mesh(TriMesh),
    Pencil { stiffness: SymmetricSparse, mass: Vec<f64>, known: Option<Vec<f64>> },
}

/// A pencil, and its known spectrum.
pub struct Known {
    pub stiffness: SymmetricSparse,
    pub mass: Vec<f64>,
    /// The number of zero eigenvalues, if the solver knows them beforehand.
    pub zeros: usize,
    /// All eigenvalues, ascending.
    pub spectrum: Vec<f64>,
}

/// The result of the solver.
#[derive(Debug, PartialEq)]
pub struct Found {
    pub basis: Basis,
    pub cuts_cluster: bool,
}

impl Case {
    /// The case of a seed; the same seed gives the same case.
    pub fn of(seed: u64) -> Self {
        let rng = &mut ChaCha8Rng::seed_from_u64(seed);
        // One case in eight is large enough to be solved by slices.
        let most = if rng.random_bool(0.125) { 900 } else { 150 };
        let (family, problem) = match seed % 10 {
            0 => ("multiple eigenvalues", pencils::multiple(rng, most)),
            1 => ("clusters", pencils::clustered(rng, most)),
            2 => ("graded spectra", pencils::graded(rng, most)),
            3 => ("duplicated parts", pencils::duplicated(rng, most)),
            4 => ("graphs", pencils::graph(rng, most)),
            5 => ("graded meshes", Problem::Mesh(meshes::graded(rng, most))),
            6 => ("slivers", Problem::Mesh(meshes::slivers(rng, most))),
            7 => ("disconnected meshes", Problem::Mesh(meshes::disconnected(rng, most))),
            8 => ("non-manifold meshes", Problem::Mesh(meshes::crowded(rng, most))),
            _ => ("tiny and huge meshes", Problem::Mesh(meshes::far_scaled(rng, most))),
        };
        let n = problem.vertices();
        // Any K for small problems; for large ones mostly those that are solved by slices.
        let share = if n <= 300 { 1.0 } else { 0.34 };
        let harmonics = match rng.random_range(0..8) {
            0 => n,
            1..4 => rng.random_range(1..=n.min(12)),
            _ => rng.random_range(1..=(share * n as f64).ceil() as usize),
        };
        let harmonics = if n > 300 { harmonics.min(n * 2 / 5) } else { harmonics };
        Self { family, problem, harmonics, whole_clusters: rng.random_bool(0.25) }
    }

    pub fn title(&self) -> String {
        format!("{} of {} vertices, K = {}", self.family, self.problem.vertices(), self.harmonics)
    }

    pub fn solve(&self, threads: usize) -> Result<Found, HarmonicsError> {
        let settings = BasisSettings {
            threads: Some(threads),
            whole_clusters: self.whole_clusters,
            ..BasisSettings::new(self.harmonics)
        };
        let found =
            |(basis, report): (Basis, BuildReport)| Found { basis, cuts_cluster: report.cuts_cluster };
        match &self.problem {
            Problem::Mesh(mesh) => {
                let (body, report) = Body::load_or_build(mesh, &settings, None, &Task::new())?;
                Ok(found((std::sync::Arc::unwrap_or_clone(body.basis), report)))
            }
            Problem::Pencil { stiffness, mass, .. } => {
                Pencil::new(stiffness, mass)?.solve(&settings, &Task::new()).map(found)
            }
        }
    }
}

impl Problem {
    /// N, before welding.
    fn vertices(&self) -> usize {
        match self {
            Self::Mesh(mesh) => mesh.positions.len(),
            Self::Pencil { mass, .. } => mass.len(),
        }
    }

    pub fn pencil(&self) -> Result<Known, HarmonicsError> {
        match self {
            Self::Mesh(mesh) => {
                let operator = Operator::with(mesh, Laplacian::Delaunay)?;
                let zeros = operator.components();
                let spectrum = spectrum(&operator.stiffness, &operator.mass);
                Ok(Known { stiffness: operator.stiffness, mass: operator.mass, zeros, spectrum })
            }
            Self::Pencil { stiffness, mass, known } => {
                let spectrum = known.clone().unwrap_or_else(|| spectrum(stiffness, mass));
                Ok(Known { stiffness: stiffness.clone(), mass: mass.clone(), zeros: 0, spectrum })
            }
        }
    }
}
