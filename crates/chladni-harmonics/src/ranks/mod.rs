//! Harmonics of meshes that are too large for one machine: the operator is built and the basis certified
//! here; in between, SLEPc solves on the ranks of MPI (docs/scale.md).
//!
//! The ranks run a small Python program, because slepc4py is packaged for every system that has MPI, while
//! bindings of our own would tie the build to one version of four C libraries. The program is part of this
//! crate.

mod launch;
mod pairs;
mod petsc;

use std::fs;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use chladni_mesh::TriMesh;
use chladni_task::{Task, private_folder};
use serde::{Deserialize, Serialize};

use crate::build::file_triangles;
use crate::eigen::{certify, check_certificate, largest_group};
use crate::operator::Domain;
use crate::values::{Keep, check_folder};
use crate::{Basis, BasisSettings, Body, BuildReport, HarmonicsError, Operator, canonical, memory};
use launch::Launcher;
use pairs::Pairs;
use petsc::ScaledOperator;

/// The program that every rank runs.
const WORKER: &str = include_str!("worker.py");
/// Its two ways to solve, and their common part.
const METHODS: [(&str, &str); 3] = [
    ("factored.py", include_str!("factored.py")),
    ("iterated.py", include_str!("iterated.py")),
    ("ritz.py", include_str!("ritz.py")),
];
/// The share of themselves by which the last eigenvalue of the ranks and the next are apart.
const GAP: f64 = 1e-6;
/// A larger number of ranks is taken for a typing error.
const MOST: usize = 65_536;
/// The largest number of ranks per core without other hosts; with more, the machine would only switch
/// between them.
const MOST_PER_CORE: usize = 8;

/// How the ranks solve (A − σI) y = x, on which all of SLEPc's work rests.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InnerSolver {
    /// With factors by MUMPS, whose inertia counts eigenvalues.
    Factors {
        /// The number of groups of equal size into which the ranks are split. Each group has its own factor
        /// and its own part of the spectrum: faster, but with as many times the memory. 1 keeps a single
        /// factor, spread over all ranks.
        groups: usize,
    },
    /// With conjugate gradients and algebraic multigrid, for meshes whose factors do not fit on all ranks
    /// together. Nothing is counted: a second search, orthogonal to the pairs found, takes its place.
    Iterated,
}

/// Where and how SLEPc solves.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Ranks {
    /// The number of MPI processes, one core each.
    pub count: usize,
    /// How (A − σI) y = x is solved.
    pub inner: InnerSolver,
    /// A host file of MPI; `None` for this machine alone.
    pub hosts: Option<PathBuf>,
    /// The folder for the operator and the vectors, which all hosts must see under this name; `None` for
    /// [`BasisSettings::default_scratch`]. Files there are private and removed afterwards.
    pub scratch: Option<PathBuf>,
}

/// A report on how the ranks solved.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct RanksReport {
    /// The number of MPI processes.
    pub ranks: usize,
    /// The number of groups, each with its own factor; 0 without factors.
    pub groups: usize,
    /// The program whose factors counted the eigenvalues; `None` without factors. (The residuals and scalar
    /// products of the certificate are measured here.)
    pub counted_by: Option<&'static str>,
    /// Without factors, how often pairs were searched for; the last search found none that was missing.
    pub searches: usize,
    /// Each shift (in working units) and the number of eigenvalues below it, from the inertia of its
    /// factor.
    pub counts: Vec<(f64, usize)>,
    /// The peak memory of each rank, in bytes.
    pub peak_bytes: Vec<u64>,
    /// The number of values in a factor, over all ranks; 0 without factors, like the next one.
    pub factor_entries: f64,
    /// The number of additions and multiplications in one factorization.
    pub factor_flops: f64,
    /// Seconds of rank 0: reading, counting, solving, polishing.
    pub seconds: RanksSeconds,
}

/// Wall-clock seconds of rank 0.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RanksSeconds {
    /// Reading the operator from disk.
    pub read: f64,
    /// Finding the bounds of the requested part of the spectrum, or searching again for missing pairs.
    pub count: f64,
    /// Krylov–Schur in all slices.
    pub solve: f64,
    /// Inverse iteration of all vectors, and writing them.
    pub polish: f64,
}

/// The settings that the ranks read.
#[derive(Serialize)]
struct Settings {
    harmonics: usize,
    zeros: usize,
    weyl: f64,
    gap: f64,
    groups: usize,
}

impl Ranks {
    /// `count` ranks with one factor, on this machine.
    pub fn here(count: usize) -> Self {
        Self { count, inner: InnerSolver::Factors { groups: 1 }, hosts: None, scratch: None }
    }

    /// Checks the settings before any work.
    ///
    /// # Errors
    /// [`HarmonicsError::NoRanks`] for no ranks or absurdly many, for groups that do not divide them, and
    /// for files that do not exist.
    pub fn check(&self) -> Result<(), HarmonicsError> {
        let refused = |reason: String| Err(HarmonicsError::NoRanks { reason });
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        let most = if self.hosts.is_some() { MOST } else { MOST_PER_CORE * cores };
        if !(1..=most).contains(&self.count) {
            let of = if self.hosts.is_some() { "" } else { " without a file of hosts" };
            return refused(format!("{} ranks: from 1 to {most} are possible{of}", self.count));
        }
        if let InnerSolver::Factors { groups } = self.inner
            && (groups == 0 || !self.count.is_multiple_of(groups))
        {
            return refused(format!("{} ranks cannot be split into {groups} equal groups", self.count));
        }
        if let Some(hosts) = self.hosts.as_ref().filter(|hosts| !hosts.is_file()) {
            return refused(format!("{}: there is no such file of hosts", hosts.display()));
        }
        if let Some(scratch) = self.scratch.as_ref().filter(|scratch| !scratch.is_dir()) {
            return refused(format!("{}: there is no such folder", scratch.display()));
        }
        Ok(())
    }
}

impl Body {
    /// A body from `mesh` with harmonics of its `operator`, solved by SLEPc on `ranks`. Nothing is cached.
    ///
    /// The certificate is measured here, except that eigenvalues are counted with the factors that MUMPS
    /// computed at the bounds of all slices, and not at all with [`InnerSolver::Iterated`]. K is at most half
    /// of N.
    ///
    /// # Errors
    /// [`HarmonicsError::NoRanks`] if MPI or slepc4py is missing or the requested ranks are impossible,
    /// [`HarmonicsError::NoScratch`] if their folder has no room, [`HarmonicsError::RanksFailed`] if the ranks fail, and
    /// the errors of [`Body::build`].
    pub fn solve_on_ranks(
        mesh: &TriMesh,
        operator: &Operator,
        settings: &BasisSettings,
        ranks: &Ranks,
        task: &Task,
    ) -> Result<(Self, BuildReport, RanksReport), HarmonicsError> {
        let start = Instant::now();
        ranks.check()?;
        operator.check_belongs_to(mesh)?;
        let vertices = operator.vertices();
        let without_area = operator.without_area;
        let (asked, harmonics) = (settings.harmonics, settings.clamped(vertices)?);
        if harmonics * 2 > vertices || ranks.count > vertices {
            let reason = "ranks are for large meshes: ask for at most half of all harmonics, and no more ranks than vertices";
            return Err(HarmonicsError::TooMany { harmonics, vertices, reason: reason.into() });
        }
        let settings = BasisSettings { harmonics, ..settings.clone() };
        let keep = memory::room_for_harmonics(vertices, 1, &settings)?;
        let cover = operator.cover;
        let short_of_memory = keep.short_of(1, 1, vertices, harmonics);
        let mut report =
            BuildReport { asked, vertices, without_area, cover, short_of_memory, ..BuildReport::default() };
        let (mut basis, of_ranks) = solve(operator, &settings, ranks, keep, task)?;
        canonical::choose(&mut basis, &operator.positions, &operator.stiffness, task)?;
        let whole = basis.harmonics();
        if !settings.whole_clusters && whole > harmonics {
            basis.truncate(harmonics);
            report.cuts_cluster = true;
        }
        report.cuts_cluster |= basis.harmonics() < operator.components();
        basis.certificate.laplacian = operator.laplacian;
        report.seconds.solve = start.elapsed().as_secs_f64();
        report.seconds.total = report.seconds.solve;
        let Domain { frame, positions, operator_vertex, .. } = operator.domain();
        let triangles = file_triangles(mesh, &operator_vertex);
        let body = Self { frame, positions, triangles, operator_vertex, basis: Arc::new(basis) };
        Ok((body, report, of_ranks))
    }
}

/// K pairs, or more if K would cut a group of equal eigenvalues; and a report on how they were found.
fn solve(
    operator: &Operator,
    settings: &BasisSettings,
    ranks: &Ranks,
    keep: Keep,
    task: &Task,
) -> Result<(Basis, RanksReport), HarmonicsError> {
    let harmonics = settings.harmonics;
    let folder = folder_of(ranks).map_err(|error| unwritten(&error))?;
    let worker = folder.path().join("worker.py");
    for (name, text) in METHODS.into_iter().chain([("worker.py", WORKER)]) {
        fs::write(folder.path().join(name), text).map_err(|error| unwritten(&error))?;
    }
    let launcher = Launcher::find(&worker)?;
    let zeros = operator.components();
    let groups = match ranks.inner {
        InnerSolver::Factors { groups } => groups,
        InnerSolver::Iterated => 0,
    };
    let pairs = if harmonics > zeros {
        let is_shared = keep == Keep::Folder(&scratch_of(ranks));
        let entries = operator.stiffness.values.len();
        check_room(folder.path(), bytes_of(operator.vertices(), entries, harmonics, is_shared))?;
        task.stage("writing the operator", 0);
        let for_ranks = Settings {
            harmonics,
            zeros,
            weyl: 4.0 * std::f64::consts::PI / operator.mass.iter().sum::<f64>(),
            gap: GAP,
            groups,
        };
        write_problem(folder.path(), operator, &for_ranks)?;
        launcher.run(ranks, &worker, folder.path(), task)?;
        task.stage("reading the harmonics", 0);
        Pairs::read(folder.path(), ranks.count, operator.vertices(), zeros, keep, settings, task)?
    } else {
        let count = constants(zeros, settings);
        let vectors = memory::vectors(operator.vertices(), count, keep, memory::free(settings))?;
        Pairs { vectors, ..Pairs::default() }
    };
    drop(folder);
    task.check()?;
    task.stage("certificate", 0);
    let counts_match = (groups > 0).then(|| pairs.counts_match(zeros));
    let mut eigenvalues = vec![0.0; constants(zeros, settings)];
    eigenvalues.extend(&pairs.eigenvalues);
    if !eigenvalues.is_sorted() {
        return Err(HarmonicsError::not_certified("the slices of the ranks overlap"));
    }
    if eigenvalues.len() < harmonics {
        return Err(HarmonicsError::not_certified(format!(
            "the ranks found {} pairs of {harmonics}",
            eigenvalues.len()
        )));
    }
    let mut vectors = pairs.vectors;
    eigenvalues.truncate(vectors.len() / operator.vertices());
    to_harmonics(&mut vectors, operator);
    let certificate = certify(operator.pencil(), zeros, &eigenvalues, &vectors, counts_match);
    check_certificate(&certificate)?;
    let report = RanksReport {
        ranks: ranks.count,
        groups,
        counted_by: (groups > 0).then_some("MUMPS"),
        searches: pairs.searches,
        counts: pairs.counts,
        peak_bytes: pairs.peak_bytes,
        factor_entries: pairs.factor[0],
        factor_flops: pairs.factor[1],
        seconds: pairs.seconds,
    };
    Ok((Basis { eigenvalues, vectors, mass: operator.mass.clone(), certificate }, report))
}

/// How many of the constants of `zeros` components, which are one group of equal eigenvalues, are made.
fn constants(zeros: usize, settings: &BasisSettings) -> usize {
    if zeros <= largest_group(settings) { zeros } else { settings.harmonics }
}

fn unwritten(error: &std::io::Error) -> HarmonicsError {
    HarmonicsError::RanksFailed { reason: format!("the operator cannot be handed to the ranks: {error}") }
}

/// The folder that holds what the ranks read and write.
fn scratch_of(ranks: &Ranks) -> PathBuf {
    ranks.scratch.clone().unwrap_or_else(BasisSettings::default_scratch)
}

/// What the ranks read and write, for the owner's eyes alone.
fn folder_of(ranks: &Ranks) -> std::io::Result<tempfile::TempDir> {
    private_folder(".chladni-ranks-", &fs::canonicalize(scratch_of(ranks))?)
}

/// The bytes of what the ranks read and write, and of the basis if it `is_shared`: kept in the same folder. The ranks write
/// all that they find, up to a quarter more than K and a few (`SPARE` and `FEW` in factored.py).
fn bytes_of(vertices: usize, entries: usize, harmonics: usize, is_shared: bool) -> u64 {
    let (vertices, harmonics) = (vertices as u64, harmonics as u64);
    let found = harmonics + harmonics / 4 + 16;
    let columns = found + if is_shared { harmonics } else { 0 };
    let vectors = 8_u64.saturating_mul(vertices).saturating_mul(columns);
    vectors.saturating_add(12 * entries as u64 + 16 * vertices)
}

/// Refuses a folder without room for `bytes`: the ranks would find out after hours.
fn check_room(folder: &Path, bytes: u64) -> Result<(), HarmonicsError> {
    check_folder(folder, bytes).map_err(|error| {
        let reason = format!("{} with the operator: {error}", memory::size(bytes));
        HarmonicsError::NoScratch { folder: folder.to_owned(), reason }
    })
}

fn write_problem(folder: &Path, operator: &Operator, settings: &Settings) -> Result<(), HarmonicsError> {
    let scaled = ScaledOperator::of(operator.pencil())?;
    let write = || {
        let mut file = BufWriter::with_capacity(1 << 20, fs::File::create(folder.join("operator.petsc"))?);
        scaled.write(&mut file)?;
        file.flush()?;
        if settings.groups == 0 {
            let roots = operator.mass.iter().flat_map(|a| a.sqrt().to_le_bytes());
            fs::write(folder.join("root_mass.f64"), roots.collect::<Vec<u8>>())?;
            let numbers = operator.component.iter().flat_map(|c| c.to_le_bytes());
            fs::write(folder.join("component.u32"), numbers.collect::<Vec<u8>>())?;
        }
        fs::write(folder.join("settings.json"), serde_json::to_vec(settings)?)
    };
    write().map_err(|error: std::io::Error| unwritten(&error))
}

/// Converts X to H = M^-½ X, in place, and removes the components along the constants of the connected
/// components, which fill the first columns.
fn to_harmonics(vectors: &mut [f64], operator: &Operator) {
    let (n, zeros) = (operator.vertices(), operator.components());
    let mut area = vec![0.0; zeros];
    operator.component.iter().zip(&operator.mass).for_each(|(c, a)| area[*c as usize] += a);
    for (k, column) in vectors.chunks_exact_mut(n).enumerate() {
        if let Some(area) = area.get(k) {
            for (h, _) in column.iter_mut().zip(&operator.component).filter(|(_, c)| **c as usize == k) {
                *h = area.sqrt().recip();
            }
            continue;
        }
        let mut mean = vec![0.0; zeros];
        for (v, h) in column.iter_mut().enumerate() {
            let root = operator.mass[v].sqrt();
            mean[operator.component[v] as usize] += *h * root;
            *h /= root;
        }
        mean.iter_mut().zip(&area).for_each(|(mean, area)| *mean /= area);
        column.iter_mut().zip(&operator.component).for_each(|(h, c)| *h -= mean[*c as usize]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_many_pieces_no_more_constants_are_made_than_our_own_solver_makes() {
        let of = |harmonics, whole_clusters| {
            constants(1000, &BasisSettings { whole_clusters, ..BasisSettings::new(harmonics) })
        };
        assert_eq!([of(1, false), of(371, false), of(372, false)], [1, 371, 1000]);
        assert_eq!(of(1, true), 1000);
        let tight = Some(10_000);
        assert!(memory::vectors(100, 5, Keep::Memory, tight).is_ok());
        let refused = memory::vectors(100, 1000, Keep::Memory, tight);
        assert!(matches!(refused, Err(HarmonicsError::TooMany { harmonics: 1000, .. })));
    }

    #[test]
    fn what_cannot_be_is_refused_before_any_work() {
        let refused = |ranks: Ranks| ranks.check().unwrap_err().to_string();
        assert!(refused(Ranks::here(0)).contains("0 ranks: from 1 to"));
        assert!(refused(Ranks::here(1_000_000)).contains("without a file of hosts"));
        let split = |groups| Ranks { inner: InnerSolver::Factors { groups }, ..Ranks::here(4) };
        assert!(refused(split(3)).contains("4 ranks cannot be split into 3"));
        assert!(refused(split(0)).contains("into 0"));
        let nowhere = Some(PathBuf::from("/no/such/place"));
        assert!(refused(Ranks { hosts: nowhere.clone(), ..Ranks::here(1) }).contains("/no/such/place"));
        assert!(refused(Ranks { scratch: nowhere, ..Ranks::here(1) }).contains("no such folder"));
        assert!(split(2).check().is_ok());
    }

    #[test]
    fn a_folder_without_room_is_refused_before_any_work() {
        assert_eq!(bytes_of(10, 70, 4, false), 1680 + 840 + 160);
        assert_eq!(bytes_of(10, 70, 4, true), 2000 + 840 + 160);
        assert_eq!(bytes_of(1 << 50, 70, 1 << 30, false), u64::MAX);
        let folder = tempfile::tempdir().unwrap();
        assert!(check_room(folder.path(), 1 << 20).is_ok());
        if cfg!(target_os = "linux") {
            let refused = check_room(folder.path(), 1 << 60).unwrap_err();
            assert!(matches!(refused, HarmonicsError::NoScratch { .. }));
            assert!(refused.to_string().contains("GB with the operator"), "{refused}");
        }
        assert_eq!(scratch_of(&Ranks::here(1)), BasisSettings::default_scratch());
    }
}
