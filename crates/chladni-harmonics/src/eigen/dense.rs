//! All eigenpairs of a small operator at once.

use std::sync::mpsc::{self, RecvTimeoutError};
use std::time::Duration;

use chladni_task::Task;
use faer::linalg::triangular_solve::{solve_lower_triangular_in_place, solve_upper_triangular_in_place};
use faer::{Mat, Par, Side};

use super::{Solved, Wanted, certify, cluster_end};
use crate::platform::{HAS_THREADS, split};
use crate::symmetric_eigen::symmetric_eigen;
use crate::threads::on_threads;
use crate::{Basis, HarmonicsError, Operator, Pencil, SolveProfile, SymmetricSparse, memory};

/// Up to this many vertices a dense solve takes less than a second.
const LONG: usize = 1000;
/// Between two looks whether it was cancelled.
const LOOK: Duration = Duration::from_millis(50);

/// Solves M^-½ S M^-½, `zeros` eigenvalues of which are 0, as a dense matrix. All pairs are computed,
/// therefore none can be missed.
pub(super) fn solve(
    pencil: Pencil,
    zeros: usize,
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
    let (mut eigenvalues, coordinates) = interruptible(symmetric, par, task)?
        .ok_or_else(|| HarmonicsError::not_certified("the dense solver failed"))?;
    task.check()?;
    let coordinates = root.untransformed(coordinates, par);
    eigenvalues[..zeros].fill(0.0);
    let cluster_end = cluster_end(&eigenvalues, wanted.harmonics);
    let keep = wanted.kept(cluster_end);
    eigenvalues.truncate(keep);
    let mut vectors = vec![0.0; n * keep];
    for (k, h) in vectors.chunks_exact_mut(n).enumerate() {
        for v in 0..n {
            h[v] = coordinates[(v, k)];
        }
    }
    let certificate = certify(pencil, zeros, &eigenvalues, &vectors, Some(true));
    let basis = Basis { eigenvalues, vectors: vectors.into(), mass: pencil.mass.to_vec(), certificate };
    Ok(Solved {
        basis,
        cuts_cluster: keep < cluster_end,
        fell_back_to_dense: false,
        short_of_memory: None,
        profile: SolveProfile::default(),
    })
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
