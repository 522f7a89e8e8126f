//! The cases: a family, a problem, and the number of harmonics to solve for.

use chladni_harmonics::{
    Basis, BasisSettings, Body, BuildReport, Certificate, ConsistentPencil, HarmonicsError, Laplacian,
    Operator, Pencil, SymmetricSparse,
};
use chladni_mesh::TriMesh;
use chladni_task::Task;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::spectrum::spectrum;
use crate::{meshes, pencils};

pub struct Case {
    pub seed: u64,
    pub family: &'static str,
    pub problem: Problem,
    pub harmonics: usize,
    pub whole_clusters: bool,
}

pub enum Problem {
    Mesh(TriMesh, Laplacian),
    /// S, the diagonal of M, and the spectrum.
    Pencil {
        stiffness: SymmetricSparse,
        mass: Vec<f64>,
        known: Vec<f64>,
    },
    /// S, an M that is not diagonal, and the spectrum.
    Consistent {
        stiffness: SymmetricSparse,
        mass: SymmetricSparse,
        known: Vec<f64>,
    },
}

/// A pencil, and its known spectrum.
pub struct Known {
    pub stiffness: SymmetricSparse,
    pub mass: SymmetricSparse,
    /// The number of zero eigenvalues, if the solver knows them beforehand.
    pub zeros: usize,
    /// All eigenvalues, ascending.
    pub spectrum: Vec<f64>,
    /// That of a mesh.
    pub operator: Option<Operator>,
}

/// The result of the solver.
#[derive(Debug)]
pub struct Found {
    pub basis: Basis,
    pub cuts_cluster: bool,
}

/// The number of families.
pub const FAMILIES: u64 = 12;

impl Case {
    /// The case of a seed; the same seed gives the same case.
    pub fn of(seed: u64) -> Self {
        Self::in_family(seed % FAMILIES, seed)
    }

    pub fn in_family(family: u64, seed: u64) -> Self {
        let rng = &mut ChaCha8Rng::seed_from_u64(seed);
        // One case in eight is large enough to be solved by slices.
        let most = if rng.random_bool(0.125) { 900 } else { 150 };
        let surface = |mesh| Problem::Mesh(mesh, Laplacian::Delaunay);
        let (family, problem) = match family {
            0 => ("multiple eigenvalues", pencils::multiple(rng, most)),
            1 => ("clusters", pencils::clustered(rng, most)),
            2 => ("graded spectra", pencils::graded(rng, most)),
            3 => ("duplicated parts", pencils::duplicated(rng, most)),
            4 => ("graphs", pencils::graph(rng, most)),
            5 => ("graded meshes", surface(meshes::graded(rng, most))),
            6 => ("slivers", surface(meshes::slivers(rng, most))),
            7 => ("disconnected meshes", surface(meshes::disconnected(rng, most))),
            8 => ("non-manifold meshes", surface(meshes::crowded(rng, most))),
            9 => ("tiny and huge meshes", surface(meshes::far_scaled(rng, most))),
            10 => ("consistent masses", pencils::consistent(rng, most)),
            _ => ("plain cotangents", Problem::Mesh(meshes::plain(rng, most), Laplacian::Cotangent)),
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
        Self { seed, family, problem, harmonics, whole_clusters: rng.random_bool(0.25) }
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
            Problem::Mesh(mesh, laplacian) => {
                let settings = BasisSettings { laplacian: *laplacian, ..settings };
                let (body, report) = Body::load_or_build(mesh, &settings, None, &Task::new())?;
                Ok(found((std::sync::Arc::unwrap_or_clone(body.basis), report)))
            }
            Problem::Pencil { stiffness, mass, .. } => {
                Pencil::new(stiffness, mass)?.solve(&settings, &Task::new()).map(found)
            }
            Problem::Consistent { stiffness, mass, .. } => {
                let pencil = ConsistentPencil::new(stiffness, mass)?;
                let (pairs, report) = pencil.solve(&settings, &Task::new())?;
                let (eigenvalues, vectors) = (pairs.eigenvalues, pairs.vectors.into());
                let mass = mass.diagonal();
                let basis = Basis { eigenvalues, vectors, mass, certificate: pairs.certificate };
                Ok(found((basis, report)))
            }
        }
    }
}

impl Problem {
    /// N, before welding.
    fn vertices(&self) -> usize {
        match self {
            Self::Mesh(mesh, _) => mesh.positions.len(),
            Self::Pencil { mass, .. } => mass.len(),
            Self::Consistent { mass, .. } => mass.size(),
        }
    }

    pub fn pencil(&self) -> Result<Known, HarmonicsError> {
        let (stiffness, mass, spectrum) = match self {
            Self::Mesh(mesh, laplacian) => {
                let operator = Operator::with(mesh, *laplacian)?;
                let spectrum = spectrum(&operator.stiffness, &operator.mass);
                let (stiffness, mass) = (operator.stiffness.clone(), diagonal(&operator.mass)?);
                let (zeros, operator) = (operator.components(), Some(operator));
                return Ok(Known { stiffness, mass, zeros, spectrum, operator });
            }
            Self::Pencil { stiffness, mass, known } => (stiffness, diagonal(mass)?, known),
            Self::Consistent { stiffness, mass, known } => (stiffness, mass.clone(), known),
        };
        Ok(Known { stiffness: stiffness.clone(), mass, zeros: 0, spectrum: spectrum.clone(), operator: None })
    }
}

/// The matrix with these values on its diagonal.
pub fn diagonal(values: &[f64]) -> Result<SymmetricSparse, HarmonicsError> {
    SymmetricSparse::from_entries(values.len(), values.iter().enumerate().map(|(v, m)| (v, v, *m)))
}

impl Found {
    /// All of it, in bits: as numbers, 0 and -0 would be equal.
    pub fn bits(&self) -> (Vec<u64>, (Laplacian, Option<bool>, bool)) {
        let Self { basis: Basis { eigenvalues, vectors, mass, certificate }, cuts_cluster } = self;
        let Certificate { laplacian, inertia_counts_match, max_relative_residual, max_orthogonality_error } =
            certificate;
        let errors = [*max_relative_residual, *max_orthogonality_error];
        let numbers = eigenvalues.iter().chain(&**vectors).chain(mass).chain(&errors);
        (numbers.map(|x| x.to_bits()).collect(), (*laplacian, *inertia_counts_match, *cuts_cluster))
    }
}
