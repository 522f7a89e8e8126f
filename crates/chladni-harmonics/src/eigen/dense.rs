//! All eigenpairs of a small operator at once.

use std::sync::mpsc::{self, RecvTimeoutError};
use std::time::Duration;

use chladni_task::Task;
use faer::linalg::triangular_solve::{solve_lower_triangular_in_place, solve_upper_triangular_in_place};
use faer::{Mat, Par, Side};

use super::assemble::check_certificate;
use super::plan::inertia;
use super::problem::Problem;
use super::{Solved, Wanted, certify, cluster_end};
use crate::platform::{HAS_THREADS, split};
use crate::symmetric_eigen::symmetric_eigen;
use crate::threads::on_threads;
use crate::{Basis, HarmonicsError, Operator, Pencil, SolveProfile, SymmetricSparse, memory};

/// Up to this many vertices a dense solve takes less than a second.
const LONG: usize = 1000;
/// Between two looks whether it was cancelled.
const LOOK: Duration = Duration::from_millis(50);

/// Solves M^-½ S M^-½, `zeros` eigenvalues of which are 0, as a dense matrix. All pairs are computed, but each only to a
/// share of the largest eigenvalue: beside a huge one, small ones may be lost. `problem` is that of `pencil`, and counts.
pub(super) fn solve(
    pencil: Pencil,
    zeros: usize,
    problem: &Problem,
    wanted: Wanted,
    task: &Task,
) -> Result<Solved, HarmonicsError> {
    let n = pencil.mass.len();
    if let Some(free) = wanted.free {
        memory::check_dense(n, wanted.harmonics, free)?;
    }
    let par = split();
    let root = Root::of(pencil)?;
    let symmetric = root.symmetrized(pencil, par);
    let (mut all, coordinates) = interruptible(symmetric, par, task)?
        .ok_or_else(|| HarmonicsError::not_certified("the dense solver failed"))?;
    task.check()?;
    let coordinates = root.untransformed(coordinates, par);
    all[..zeros].fill(0.0);
    let cluster_end = cluster_end(&all, wanted.harmonics);
    let keep = wanted.kept(cluster_end);
    let eigenvalues = all[..keep].to_vec();
    let mut vectors = vec![0.0; n * keep];
    for (k, h) in vectors.chunks_exact_mut(n).enumerate() {
        for v in 0..n {
            h[v] = coordinates[(v, k)];
        }
    }
    let mut certificate = certify(pencil, zeros, &eigenvalues, &vectors, None);
    // Pairs that slices would not return may be of no eigenvalue at all: their number says nothing.
    if check_certificate(&certificate).is_ok() {
        certificate.inertia_counts_match = counts_match(problem, &all, cluster_end);
    }
    let basis = Basis { eigenvalues, vectors: vectors.into(), mass: pencil.mass.to_vec(), certificate };
    Ok(Solved {
        basis,
        cuts_cluster: keep < cluster_end,
        fell_back_to_dense: false,
        short_of_memory: None,
        profile: SolveProfile::default(),
    })
}

/// Whether a factorization, as between slices, counts as many eigenvalues as there are `values` below the gap in front of
/// number `end`. `None` if it does not, but rounding may be the reason.
fn counts_match(problem: &Problem, values: &[f64], end: usize) -> Option<bool> {
    // Without a gap above them, these are as many as there are rows, and there cannot be more.
    let Some(&[below, above]) = values.get(end.saturating_sub(1)..=end) else { return Some(true) };
    let (lambda, count) = inertia(problem, 0.5 * (below + above), &mut SolveProfile::default()).ok()?;
    let room = (lambda - below).min(above - lambda);
    if count == end { Some(true) } else { (room > problem.resolved()).then_some(false) }
}

/// Eigenvalues and eigenvectors.
type DensePairs = (Vec<f64>, Mat<f64>);

/// All eigenpairs of `matrix`. The dense solver cannot be stopped, so a large problem runs on a thread of its own,
/// which a cancelled task leaves behind.
fn interruptible(matrix: Mat<f64>, par: Par, task: &Task) -> Result<Option<DensePairs>, HarmonicsError> {
    if !HAS_THREADS || matrix.nrows() <= LONG {
        return Ok(symmetric_eigen(&matrix, par));
    }
    let threads = rayon::current_num_threads();
    let (done, waiting) = mpsc::channel();
    let worker = move || {
        let solved = on_threads(Some(threads), || symmetric_eigen(&matrix, par));
        // Nobody may be waiting any more.
        let _ = done.send(solved);
    };
    std::thread::Builder::new().spawn(worker).map_err(|e| HarmonicsError::Threads(e.to_string()))?;
    loop {
        task.check()?;
        match waiting.recv_timeout(LOOK) {
            Ok(solved) => return solved,
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => return Ok(None),
        }
    }
}

/// The factor G of M = G Gᵀ.
enum Root {
    /// √M, for a diagonal M.
    Diagonal(Vec<f64>),
    /// A lower triangular matrix.
    Cholesky(Mat<f64>),
}

impl Root {
    fn of(pencil: Pencil) -> Result<Self, HarmonicsError> {
        let Some(consistent) = pencil.consistent else {
            return Ok(Self::Diagonal(pencil.mass.iter().map(|a| a.sqrt()).collect()));
        };
        match full(consistent).llt(Side::Lower) {
            Ok(factored) => Ok(Self::Cholesky(factored.L().to_owned())),
            Err(_) => Err(HarmonicsError::bad_pencil("M is not positive definite")),
        }
    }

    /// G⁻¹ S G⁻ᵀ.
    fn symmetrized(&self, pencil: Pencil, par: Par) -> Mat<f64> {
        match self {
            Self::Diagonal(_) => symmetrized(pencil),
            Self::Cholesky(lower) => {
                let mut matrix = full(pencil.stiffness);
                solve_lower_triangular_in_place(lower.as_ref(), matrix.as_mut(), par);
                let mut matrix = matrix.transpose().to_owned();
                solve_lower_triangular_in_place(lower.as_ref(), matrix.as_mut(), par);
                matrix
            }
        }
    }

    /// G⁻ᵀ X.
    fn untransformed(&self, mut vectors: Mat<f64>, par: Par) -> Mat<f64> {
        match self {
            Self::Diagonal(root) => {
                for column in vectors.col_iter_mut() {
                    column.iter_mut().zip(root).for_each(|(x, root)| *x /= root);
                }
            }
            Self::Cholesky(lower) => {
                solve_upper_triangular_in_place(lower.transpose(), vectors.as_mut(), par);
            }
        }
        vectors
    }
}

fn full(matrix: &SymmetricSparse) -> Mat<f64> {
    let n = matrix.size();
    let mut full = Mat::<f64>::zeros(n, n);
    for j in 0..n {
        for (i, value) in matrix.column(j) {
            full[(i, j)] = value;
        }
    }
    full
}

/// M^-½ S M^-½ for a diagonal M.
pub(super) fn symmetrized(pencil: Pencil) -> Mat<f64> {
    let n = pencil.mass.len();
    let scale: Vec<f64> = pencil.mass.iter().map(|a| a.sqrt().recip()).collect();
    let mut matrix = Mat::<f64>::zeros(n, n);
    for j in 0..n {
        for (i, value) in pencil.stiffness.column(j) {
            matrix[(i, j)] = value * scale[i] * scale[j];
        }
    }
    matrix
}

impl Operator {
    /// All eigenvalues, ascending, by a dense solver: a reference for small meshes.
    ///
    /// # Errors
    /// The dense solver failed, or the matrix does not fit into memory.
    pub fn dense_eigenvalues(&self) -> Result<Vec<f64>, HarmonicsError> {
        let n = self.vertices();
        if let Some(free) = memory::available() {
            memory::check_dense(n, n, free)?;
        }
        let matrix = symmetrized(self.pencil());
        let (values, _) = symmetric_eigen(&matrix, Par::Seq)
            .ok_or_else(|| HarmonicsError::not_certified("the dense solver failed"))?;
        Ok(values)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::values::Keep;

    const BEADS: usize = 200;

    /// Equal springs between neighbors in a row of beads.
    fn row_of_springs() -> SymmetricSparse {
        let spring = |v: usize| [(v, v, 1.0), (v - 1, v - 1, 1.0), (v, v - 1, -1.0)];
        SymmetricSparse::from_entries(BEADS, (1..BEADS).flat_map(spring)).unwrap()
    }

    #[test]
    fn what_is_too_rough_is_not_stated_to_be_complete() {
        let stiffness = row_of_springs();
        for (decades, counted) in [(2.0, Some(true)), (14.0, None)] {
            let spread = |v: usize| decades * (0.618_033_988_749_895 * v as f64).fract() - 0.5 * decades;
            let mass: Vec<f64> = (0..BEADS).map(|v| 10_f64.powf(spread(v))).collect();
            let pencil = Pencil::new(&stiffness, &mass).unwrap();
            for harmonics in [120, BEADS] {
                let wanted = Wanted {
                    harmonics,
                    whole_clusters: false,
                    most: BEADS,
                    free: None,
                    keep: Keep::Memory,
                    scratch: None,
                    frugal: false,
                    at_once: 1,
                };
                let solved = solve(pencil, 1, &Problem::of(pencil), wanted, &Task::new()).unwrap();
                let certificate = solved.basis.certificate;
                assert_eq!(certificate.inertia_counts_match, counted, "{decades}: {certificate:?}");
            }
        }
    }

    #[test]
    fn a_missing_value_is_counted_and_what_rounding_blurs_is_not() {
        let (stiffness, mass) = (row_of_springs(), vec![1.0; BEADS]);
        let problem = Problem::of(Pencil::new(&stiffness, &mass).unwrap());
        let wave = |k: usize| 2.0 - 2.0 * (std::f64::consts::PI * k as f64 / BEADS as f64).cos();
        let exact: Vec<f64> = (0..BEADS).map(wave).collect();
        for end in [1, 3, BEADS - 1, BEADS] {
            assert_eq!(counts_match(&problem, &exact, end), Some(true), "{end}");
        }
        let mut fewer = exact.clone();
        fewer.remove(2);
        assert_eq!(counts_match(&problem, &fewer, 5), Some(false));
        // There are no such eigenvalues, but rounding alone could hide them.
        let lost: Vec<f64> = [0.0, 1e-16, 2e-16, 3e-16].into_iter().chain(exact).collect();
        assert_eq!(counts_match(&problem, &lost, 3), None);
    }
}
