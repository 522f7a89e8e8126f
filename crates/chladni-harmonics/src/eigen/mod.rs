//! The K smallest eigenpairs of S h = λ M h.

mod assemble;
mod certify;
mod columns;
mod components;
mod dense;
mod found;
mod given;
mod join;
mod krylov;
mod lanczos;
mod metric;
mod orthonormal;
mod plan;
mod polish;
mod problem;
mod slicing;
mod tall;
mod window;

use std::path::Path;

use chladni_task::{Stage, Task};

#[cfg(not(target_family = "wasm"))]
pub(crate) use assemble::check_certificate;
use components::Kind;
pub(crate) use given::solve as solve_given;
use problem::{Problem, ZEROS};

use crate::basis::larger;
use crate::ldlt::Symbolic;
use crate::memory::Room;
use crate::platform::Instant;
use crate::threads::on_threads;
use crate::values::{Keep, Values};
use crate::{
    Basis, BasisSettings, Certificate, HarmonicsError, Laplacian, Operator, Pencil, ShortOfMemory,
    SolveProfile, canonical, memory,
};

/// Up to this many vertices a dense solve is faster than slices.
const DENSE: usize = 300;
/// Up to this many vertices a dense solve is used if a large share of all pairs is wanted.
const DENSE_SHARE: usize = 4000;
/// A dense solve of more vertices would hold four matrices of 3 GB.
const DENSE_MOST: usize = 20_000;
/// Up to twice K and this many pairs, a group of equal eigenvalues is solved as a whole although K cuts it, so
/// that geometry can choose among its vectors. The spheres of a thousand harmonics have groups of 63.
const SPARE: usize = 256;
/// The number of columns of M H in memory at once when all scalar products are measured.
const COLUMNS: usize = 32;
/// Two eigenvalues that agree to this relative tolerance count as one multiple eigenvalue.
pub(crate) const CLUSTER: f64 = 1e-7;

/// Eigenpairs and the facts that must be reported about them.
pub(crate) struct Solved {
    pub basis: Basis,
    pub cuts_cluster: bool,
    /// Whether the slices could not be certified, and everything was solved as a dense matrix instead.
    pub fell_back_to_dense: bool,
    pub short_of_memory: Option<ShortOfMemory>,
    pub profile: SolveProfile,
}

/// The result that a part of a solve must return, and within which means.
#[derive(Clone, Copy)]
struct Wanted<'a> {
    harmonics: usize,
    /// Whether to extend K to the end of a group of equal eigenvalues that it would cut.
    whole_clusters: bool,
    /// A group that reaches beyond this many pairs is cut at K after all.
    most: usize,
    /// Bytes that there are for the vectors, if the system says.
    free: Option<u64>,
    /// Where the vectors are kept.
    keep: Keep<'a>,
    /// Where they may be kept if memory is short.
    scratch: Option<&'a Path>,
    /// Whether to compute factors again rather than keep them.
    frugal: bool,
    /// How many slices may be solved at once, on however many threads.
    at_once: usize,
}

impl Wanted<'_> {
    /// An array of zeros for vectors of `n` values.
    fn vectors(self, n: usize, count: usize) -> Result<Values, HarmonicsError> {
        memory::vectors(n, count, self.keep, self.free)
    }

    /// What of this there is room for, where factors of `symbolic` are larger than those of a surface.
    fn fitted(self, symbolic: &Symbolic) -> Result<Self, HarmonicsError> {
        let Some(free) = self.free else { return Ok(self) };
        let room = Room { slices: self.at_once, keep: self.keep, frugal: self.frugal };
        let (n, kept) = (symbolic.size(), kept_factors(plan::slices(self.harmonics)));
        let bytes = symbolic.bytes();
        let room = memory::room_for_factors(room, self.scratch, n, self.harmonics, kept, bytes, free)?;
        Ok(Self { at_once: room.slices, keep: room.keep, frugal: room.frugal, ..self })
    }

    /// Runs `solve` for `n` vertices on the threads of `fitting`, for which there is room, and reports how that differs.
    fn on_fewer(
        self,
        fitting: Self,
        n: usize,
        solve: impl FnOnce() -> Result<Solved, HarmonicsError> + Send,
    ) -> Result<Solved, HarmonicsError> {
        // Each thread solves a slice.
        let solved =
            if fitting.at_once < self.at_once { on_threads(Some(fitting.at_once), solve)? } else { solve() };
        let solved = solved?;
        // There may be even less room once the size of the factors is known.
        let later = solved.short_of_memory.map(|short| ShortOfMemory { of_slices: self.at_once, ..short });
        let short_of_memory =
            later.or_else(|| fitting.keep.short_of(fitting.at_once, self.at_once, n, self.harmonics));
        Ok(Solved { short_of_memory, ..solved })
    }

    /// How many pairs to keep where the group of the K-th ends after `end`.
    fn kept(self, end: usize) -> usize {
        if self.whole_clusters && end <= self.most { end } else { self.harmonics }
    }
}

/// How many factors a plan of this many slices has at its end.
fn kept_factors(planned: usize) -> usize {
    if planned <= plan::KEPT { planned } else { 0 }
}

/// A group of equal eigenvalues that reaches beyond this many pairs is cut at K.
pub(crate) fn largest_group(settings: &BasisSettings) -> usize {
    if settings.whole_clusters {
        usize::MAX
    } else {
        settings.harmonics.saturating_mul(2).saturating_add(SPARE)
    }
}

/// Runs `solve` where and with as many slices at once as memory allows for `vertices`. It is asked for whole
/// groups of equal eigenvalues.
fn where_it_fits(
    vertices: usize,
    planned: usize,
    settings: &BasisSettings,
    solve: impl FnOnce(Wanted) -> Result<Solved, HarmonicsError> + Send,
) -> Result<Solved, HarmonicsError> {
    let slices = rayon::current_num_threads().min(planned);
    let Room { slices: fitting, keep, frugal } =
        memory::room_for_solve(vertices, slices, kept_factors(planned), settings)?;
    let whole = Wanted {
        harmonics: settings.harmonics,
        whole_clusters: true,
        most: largest_group(settings),
        free: memory::free(settings),
        keep: Keep::Memory,
        scratch: settings.scratch.as_deref(),
        frugal: false,
        at_once: slices,
    };
    let fitting = Wanted { keep, frugal, at_once: fitting.max(1), ..whole };
    whole.on_fewer(fitting, vertices, || solve(fitting))
}

/// Solves for the first pairs of `operator`. [`canonical`] chooses among equally good ones; for
/// that, a group of equal eigenvalues that K cuts is solved as a whole.
pub(crate) fn solve(
    operator: &Operator,
    settings: &BasisSettings,
    task: &Task,
) -> Result<Solved, HarmonicsError> {
    let (n, harmonics) = (operator.vertices(), settings.harmonics);
    if harmonics == 0 || harmonics > n {
        return Err(HarmonicsError::BadHarmonicCount { harmonics, vertices: n });
    }
    task.check()?;
    let pencil = operator.pencil();
    let planned = plan::slices(harmonics.saturating_sub(ZEROS));
    let mut solved = where_it_fits(n, planned, settings, |wanted| {
        let solved = if operator.components() > 1 {
            components::solve(pencil, &operator.component, Kind::Surface, wanted, task)
        } else {
            let stage = task.stage("harmonics", harmonics as u64);
            solve_connected(pencil, ZEROS, None, wanted, &stage, task)
        };
        or_dense(solved, pencil, operator.components(), wanted, task)
    })?;
    canonical::choose(&mut solved.basis, &operator.positions, &operator.stiffness, task)?;
    if !settings.whole_clusters && solved.basis.harmonics() > harmonics {
        solved.basis.truncate(harmonics);
        solved.cuts_cluster = true;
    }
    solved.basis.certificate.laplacian = operator.laplacian;
    Ok(solved)
}

/// The last resort if slices could not be certified: a dense solve, if affordable.
fn or_dense(
    solved: Result<Solved, HarmonicsError>,
    pencil: Pencil,
    zeros: usize,
    wanted: Wanted,
    task: &Task,
) -> Result<Solved, HarmonicsError> {
    match solved {
        Err(HarmonicsError::NotCertified { .. }) if pencil.mass.len() <= DENSE_SHARE => {
            let problem = Problem::of(pencil).given(pencil)?;
            let solved = dense::solve(pencil, zeros, &problem, wanted, task)?;
            Ok(Solved { fell_back_to_dense: true, ..solved })
        }
        solved => solved,
    }
}

/// Solves for the first pairs of a connected surface, or of a given pencil without `zeros`.
/// `problem` is built if it is not given. The stage counts pairs.
fn solve_connected(
    pencil: Pencil,
    zeros: usize,
    problem: Option<Problem>,
    wanted: Wanted,
    stage: &Stage,
    task: &Task,
) -> Result<Solved, HarmonicsError> {
    let (n, harmonics) = (pencil.mass.len(), wanted.harmonics);
    task.check()?;
    if harmonics == 1 && zeros == ZEROS {
        stage.advance(1);
        return Ok(constant(pencil));
    }
    let is_dense = n <= DENSE || (n <= DENSE_SHARE && harmonics * 3 > n) || harmonics * 2 > n;
    if is_dense && n > DENSE_MOST {
        let reason = "half of all and more take a dense solver, which is for at most 20000 vertices";
        return Err(HarmonicsError::TooMany { harmonics, vertices: n, reason: reason.into() });
    }
    let start = Instant::now();
    let problem = problem.unwrap_or_else(|| Problem::of(pencil));
    let analyze = start.elapsed().as_secs_f64();
    if is_dense {
        let solved = dense::solve(pencil, zeros, &problem, wanted, task)?;
        // If slivers make the largest eigenvalues huge, slices are more accurate for the lowest ones.
        if n > DENSE || harmonics * 2 > n || solved.basis.certificate.is_precise() {
            stage.advance(harmonics as u64);
            return Ok(solved);
        }
    }
    let fitting = wanted.fitted(&problem.symbolic)?;
    let solve = || slicing::solve(&problem, pencil, fitting, stage, task);
    let mut solved = wanted.on_fewer(fitting, n, solve)?;
    solved.profile.analyze = analyze;
    Ok(solved)
}

/// The pair with λ = 0 of a connected surface: h = 1 / √area.
fn constant(pencil: Pencil) -> Solved {
    let vectors = vec![pencil.mass.iter().sum::<f64>().sqrt().recip(); pencil.mass.len()];
    let certificate = certify(pencil, ZEROS, &[0.0], &vectors, Some(true));
    let basis =
        Basis { eigenvalues: vec![0.0], vectors: vectors.into(), mass: pencil.mass.to_vec(), certificate };
    Solved {
        basis,
        cuts_cluster: false,
        fell_back_to_dense: false,
        short_of_memory: None,
        profile: SolveProfile::default(),
    }
}

/// The first position at or after K where neighboring `values` differ, or the end of `values`.
pub(crate) fn cluster_end(values: &[f64], harmonics: usize) -> usize {
    let is_gap = |k: &usize| values[*k] - values[*k - 1] > CLUSTER * values[*k];
    (harmonics..values.len()).find(is_gap).unwrap_or(values.len())
}

/// Certifies pairs of `pencil`, the first `zeros` of which have λ = 0, by measuring them.
pub(crate) fn certify(
    pencil: Pencil,
    zeros: usize,
    eigenvalues: &[f64],
    vectors: &[f64],
    inertia: Option<bool>,
) -> Certificate {
    use faer::MatRef;
    let (n, k) = (pencil.mass.len(), eigenvalues.len());
    let mut residual = 0.0_f64;
    for (j, &lambda) in eigenvalues.iter().enumerate().skip(zeros) {
        let h = &vectors[j * n..(j + 1) * n];
        let s = pencil.stiffness.times(h);
        let norm = s.iter().map(|x| x * x).sum::<f64>().sqrt();
        let weighted = pencil.mass_times(h);
        let error: f64 = s.iter().zip(weighted).map(|(s, m)| (s - lambda * m).powi(2)).sum();
        residual = larger(residual, error.sqrt() / norm);
    }
    let h = MatRef::from_column_major_slice(vectors, n, k);
    let mut orthogonality = 0.0_f64;
    // A few columns of M H at a time: all of them would need as much memory as H.
    for (number, columns) in vectors.chunks(COLUMNS * n.max(1)).enumerate() {
        let weighted: Vec<f64> = columns.chunks_exact(n.max(1)).flat_map(|h| pencil.mass_times(h)).collect();
        let gram = h.transpose() * MatRef::from_column_major_slice(&weighted, n, weighted.len() / n.max(1));
        for j in 0..gram.ncols() {
            for i in 0..k {
                let unit = f64::from(u8::from(i == number * COLUMNS + j));
                orthogonality = larger(orthogonality, (gram[(i, j)] - unit).abs());
            }
        }
    }
    Certificate {
        laplacian: Laplacian::default(),
        inertia_counts_match: inertia,
        max_relative_residual: residual,
        max_orthogonality_error: orthogonality,
    }
}
