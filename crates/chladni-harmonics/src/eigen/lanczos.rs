//! Block Lanczos on (A − σI)⁻¹: the eigenpairs of A nearest to one shift.

use std::time::Instant;

use chladni_task::{Cancelled, Task};
use faer::{Mat, Par};

use super::dense::symmetric_eigen;

use super::problem::{Problem, Profile};
use super::tall::{BLOCK, Block, Dependence, Small, orthonormalize, overlaps, subtract_products};
use crate::ldlt::{Factor, Row, Workspace};

/// How far a run must go on one side of its shift.
#[derive(Clone, Copy, Debug)]
pub(super) enum Reach {
    /// Everything up to this eigenvalue, and the first pair beyond it, must converge.
    Beyond(f64),
    /// This many pairs must converge.
    Count(usize),
}

/// What one run has to find around its shift.
#[derive(Clone, Copy, Debug)]
pub(super) struct Window {
    pub below: Reach,
    pub above: Reach,
    /// Zero lies in the window: its eigenvectors, which are known, are kept out of the space.
    pub from_zero: bool,
    /// How wide the window is in λ.
    pub width: f64,
    /// How many pairs are expected, which only decides when to look first.
    pub expected: usize,
}

/// Converged pairs nearest to a shift, none left out on either side as far as Lanczos can tell.
#[derive(Debug, Default)]
pub(super) struct Pairs {
    /// Eigenvalues, ascending.
    pub values: Vec<f64>,
    /// Their orthonormal vectors, BLOCK to a block in the order of `values`; the last block
    /// is filled up with zeros.
    pub blocks: Vec<Block>,
}

/// Why a run stopped without its pairs.
#[derive(Debug)]
pub(super) enum Stopped {
    Cancelled,
    /// The shift is too close to an eigenvalue, or the factorization lost its precision.
    BadShift,
    /// The space was used up before the window had converged.
    Exhausted,
}

impl From<Cancelled> for Stopped {
    fn from(_: Cancelled) -> Self {
        Self::Cancelled
    }
}

/// Pairs around `shift`, given its `factor`, orthogonal to the pairs in `locked`.
pub(super) fn run(
    problem: &Problem,
    factor: &Factor,
    shift: f64,
    window: &Window,
    locked: &[&Pairs],
    seed: u64,
    profile: &mut Profile,
    task: &Task,
) -> Result<Pairs, Stopped> {
    let n = problem.matrix.size();
    let locked: Vec<&[Row]> = locked.iter().flat_map(|p| p.blocks.iter().map(Vec::as_slice)).collect();
    let mut krylov = Krylov { basis: Vec::new(), diagonal: Vec::new(), below: Vec::new() };
    let mut next = random_block(n, seed);
    problem.remove_constants(window.from_zero, &mut next);
    for _ in 0..2 {
        subtract_projections(&mut next, &locked);
        let Ok(_) = orthonormalize(&mut next, &[0.0; 8]) else {
            return Err(Stopped::BadShift);
        };
    }
    loop {
        task.check()?;
        let start = Instant::now();
        let mut image = problem.spare_block();
        image.copy_from_slice(&next);
        factor.solve(&problem.symbolic, &mut image);
        profile.solve += start.elapsed().as_secs_f64();
        profile.solved_columns += BLOCK as u64;
        let start = Instant::now();
        krylov.basis.push(next);
        problem.remove_constants(window.from_zero, &mut image);
        let sizes = krylov.orthogonalize(&mut image, &locked, profile);
        let upper = match orthonormalize(&mut image, &sizes.map(|size| RANK * size)) {
            Ok(upper) => upper,
            Err(Dependence::Spoiled) => return Err(Stopped::BadShift),
            Err(Dependence::Found) => {
                // The space has become invariant in some direction: go on with a new one.
                let seed = seed.wrapping_add(krylov.basis.len() as u64).rotate_left(17);
                let all: Vec<&[Row]> =
                    locked.iter().copied().chain(krylov.basis.iter().map(Vec::as_slice)).collect();
                fill_up(problem, window, &mut image, &sizes, &all, seed).ok_or(Stopped::Exhausted)?
            }
        };
        krylov.below.push(upper);
        profile.orthogonalize += start.elapsed().as_secs_f64();
        next = image;
        let m = krylov.basis.len() * BLOCK;
        if m + 2 * BLOCK > n || m > 8 * window.expected + 60 * BLOCK {
            return Err(Stopped::Exhausted);
        }
        // Convergence comes at about twice the pairs and 14 blocks; looking costs a dense solve.
        if m < window.expected * 2 + 12 * BLOCK || !krylov.basis.len().is_multiple_of(2) {
            continue;
        }
        let start = Instant::now();
        let ritz = krylov.ritz(shift).ok_or(Stopped::BadShift)?;
        let chosen = ritz.converged(window, problem, shift);
        profile.project += start.elapsed().as_secs_f64();
        if let Some(chosen) = chosen {
            let start = Instant::now();
            let pairs = krylov.vectors(problem, &ritz, chosen, &next);
            profile.vectors += start.elapsed().as_secs_f64();
            krylov.basis.push(next);
            problem.give_back(krylov.basis);
            return Ok(pairs);
        }
    }
}

fn subtract_projections(x: &mut [Row], onto: &[&[Row]]) {
    if !onto.is_empty() {
        let coefficients = overlaps(onto, &[x]);
        subtract_products(&mut [x], onto, &coefficients);
    }
}

/// What is left of a column of OP V outside the space is rounding where it is this much
/// smaller than the column was.
const RANK: f64 = 1e-11;

/// The length of each column of OP V inside the space.
fn column_sizes(coefficients: &[Small]) -> Row {
    let mut sizes = [0.0; 8];
    for c in coefficients.as_flattened() {
        for (size, c) in sizes.iter_mut().zip(c) {
            *size += c * c;
        }
    }
    sizes.map(f64::sqrt)
}

/// X ← Q of X = Q R one column after the other; a column that depends on others or is nothing
/// but rounding becomes a random one orthogonal to all, with nothing of it in R. `None` where
/// no other direction is left.
fn fill_up(
    problem: &Problem,
    window: &Window,
    x: &mut Block,
    sizes: &Row,
    space: &[&[Row]],
    seed: u64,
) -> Option<Small> {
    let mut r = [[0.0; 8]; BLOCK];
    let mut fresh = random_block(x.len(), seed);
    problem.remove_constants(window.from_zero, &mut fresh);
    for _ in 0..2 {
        subtract_projections(&mut fresh, space);
    }
    subtract_projections(x, space);
    let column = |x: &Block, j: usize| x.iter().map(|row| row[j]).collect::<Vec<f64>>();
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let mut done: Vec<Vec<f64>> = Vec::with_capacity(BLOCK);
    for j in 0..BLOCK {
        let mut own = column(x, j);
        let limit = RANK * sizes[j] + 1e-9 * dot(&own, &own).sqrt();
        for _ in 0..2 {
            for (i, q) in done.iter().enumerate() {
                let overlap = dot(q, &own);
                r[i][j] += overlap;
                own.iter_mut().zip(q).for_each(|(x, q)| *x -= overlap * q);
            }
        }
        let mut length = dot(&own, &own).sqrt();
        if length > limit {
            r[j][j] = length;
        } else {
            own = column(&fresh, j);
            for _ in 0..2 {
                for q in &done {
                    let overlap = dot(q, &own);
                    own.iter_mut().zip(q).for_each(|(x, q)| *x -= overlap * q);
                }
            }
            length = dot(&own, &own).sqrt();
            if length.is_nan() || length <= 1e-8 {
                return None;
            }
        }
        own.iter_mut().for_each(|x| *x /= length);
        x.iter_mut().zip(&own).for_each(|(row, value)| row[j] = *value);
        done.push(own);
    }
    Some(r)
}

/// Uniform in [-½, ½) by SplitMix64, the same for every number of threads.
fn random_block(n: usize, seed: u64) -> Block {
    let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ 0x1405_7b7e_f767_814f;
    let mut random = || {
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = state;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    };
    (0..n).map(|_| std::array::from_fn(|_| random())).collect()
}

/// An orthonormal basis V of blocks and the block tridiagonal T = Vᵀ OP V.
struct Krylov {
    basis: Vec<Block>,
    /// V_jᵀ OP V_j.
    diagonal: Vec<Small>,
    /// The triangular factor of what OP V_j has outside V_0 … V_j.
    below: Vec<Small>,
}

/// Eigenpairs of T.
struct Ritz {
    /// Approximations of eigenvalues of A, ascending.
    values: Vec<f64>,
    /// Which eigenvector of T each belongs to, and its θ = 1 / (λ − σ).
    from: Vec<(usize, f64)>,
    /// ‖A x − λ x‖ of each after the free purification step (see [`Krylov::vectors`]).
    residuals: Vec<f64>,
    coordinates: Mat<f64>,
    /// R · last block of coordinates: what each leaves in the next block.
    leaving: Mat<f64>,
}

impl Krylov {
    /// Takes out of `image` = OP · (last block) what lies in the space, keeping the last
    /// block's share as the next diagonal block of T. Returns the length of each column inside.
    ///
    /// In exact arithmetic the last two blocks are all there is to take out. Rounding brings
    /// the older ones back, by little in one step, so that every second step takes them out of
    /// this block and the one before it together, for one reading of the space.
    fn orthogonalize(&mut self, image: &mut [Row], locked: &[&[Row]], profile: &mut Profile) -> Row {
        let recent: Vec<&[Row]> = self.basis.iter().rev().take(2).rev().map(Vec::as_slice).collect();
        let coefficients = overlaps(&recent, &[image]);
        subtract_products(&mut [image], &recent, &coefficients);
        self.diagonal.extend(coefficients.last());
        // Overlaps and what is subtracted, block by block.
        let products = |pairs: usize| (4 * image.len() * BLOCK * BLOCK * pairs) as u64;
        profile.orthogonalize_flops += products(recent.len());
        if self.basis.len().is_multiple_of(2)
            && let Some((last, older)) = self.basis.split_last_mut()
        {
            let space: Vec<&[Row]> = locked.iter().copied().chain(older.iter().map(Vec::as_slice)).collect();
            profile.orthogonalize_flops += products(2 * space.len());
            let rest = overlaps(&space, &[last, image]);
            subtract_products(&mut [last, image], &space, &rest);
        }
        column_sizes(&coefficients)
    }

    fn ritz(&self, shift: f64) -> Option<Ritz> {
        let blocks = self.basis.len();
        let m = blocks * BLOCK;
        let mut t = Mat::<f64>::zeros(m, m);
        for block in 0..blocks {
            let first = block * BLOCK;
            for i in 0..BLOCK {
                for j in 0..BLOCK {
                    let d = &self.diagonal[block];
                    t[(first + i, first + j)] = 0.5 * (d[i][j] + d[j][i]);
                    if block + 1 < blocks {
                        let value = self.below[block][i][j];
                        t[(first + BLOCK + i, first + j)] = value;
                        t[(first + j, first + BLOCK + i)] = value;
                    }
                }
            }
        }
        let (thetas, coordinates) = symmetric_eigen(&t, Par::Seq)?;
        let last = &self.below[blocks - 1];
        let mut leaving = Mat::<f64>::zeros(BLOCK, m);
        for j in 0..m {
            for i in 0..BLOCK {
                leaving[(i, j)] = (i..BLOCK).map(|k| last[i][k] * coordinates[(m - BLOCK + k, j)]).sum();
            }
        }
        let mut order: Vec<(f64, usize, f64)> = (0..m)
            .map(|j| (thetas[j], j))
            .filter(|(theta, _)| *theta != 0.0)
            .map(|(theta, j)| (shift + 1.0 / theta, j, theta))
            .collect();
        order.sort_by(|a, b| a.0.total_cmp(&b.0));
        let residual = |j: usize, theta: f64| {
            (0..BLOCK).map(|i| leaving[(i, j)].powi(2)).sum::<f64>().sqrt() / (theta * theta)
        };
        Some(Ritz {
            values: order.iter().map(|e| e.0).collect(),
            from: order.iter().map(|e| (e.1, e.2)).collect(),
            residuals: order.iter().map(|e| residual(e.1, e.2)).collect(),
            coordinates,
            leaving,
        })
    }

    /// The chosen Ritz vectors with one step of inverse iteration that costs no solve: by the
    /// Lanczos relation OP V s / θ = V s + V_next R s_last / θ (Ericsson & Ruhe 1980).
    fn vectors(&self, problem: &Problem, ritz: &Ritz, chosen: std::ops::Range<usize>, next: &Block) -> Pairs {
        let chosen: Vec<usize> = chosen.collect();
        let groups: Vec<&[usize]> = chosen.chunks(BLOCK).collect();
        let mut basis: Vec<&[Row]> = self.basis.iter().map(Vec::as_slice).collect();
        basis.push(next);
        let mut coefficients = vec![[[0.0; 8]; BLOCK]; basis.len() * groups.len()];
        for (g, group) in groups.iter().enumerate() {
            for (column, &pair) in group.iter().enumerate() {
                let (j, theta) = ritz.from[pair];
                let extra: f64 = (0..BLOCK).map(|i| (ritz.leaving[(i, j)] / theta).powi(2)).sum();
                // Minus, because the kernel subtracts.
                let scale = -1.0 / (1.0 + extra).sqrt();
                for (block, c) in coefficients.chunks_exact_mut(groups.len()).enumerate() {
                    for i in 0..BLOCK {
                        c[g][i][column] = scale
                            * if block < self.basis.len() {
                                ritz.coordinates[(block * BLOCK + i, j)]
                            } else {
                                ritz.leaving[(i, j)] / theta
                            };
                    }
                }
            }
        }
        let mut blocks: Vec<Block> = groups.iter().map(|_| problem.spare_block()).collect();
        blocks.iter_mut().for_each(|block| block.fill([0.0; 8]));
        let mut views: Vec<&mut [Row]> = blocks.iter_mut().map(Vec::as_mut_slice).collect();
        subtract_products(&mut views, &basis, &coefficients);
        Pairs { values: chosen.iter().map(|&p| ritz.values[p]).collect(), blocks }
    }
}

impl Ritz {
    /// The pairs to keep, once all that the window asks for has converged: those from the shift
    /// outwards, on each side up to the first that has not.
    fn converged(&self, window: &Window, problem: &Problem, shift: f64) -> Option<std::ops::Range<usize>> {
        let good = |i: usize| self.residuals[i] <= problem.tolerance(self.values[i], shift, window);
        let split = self.values.partition_point(|l| *l < shift);
        let above = (split..self.values.len()).take_while(|&i| good(i)).count();
        let below = (0..split).rev().take_while(|&i| self.values[i] > 0.0 && good(i)).count();
        let needed_above = match window.above {
            Reach::Count(count) => count,
            Reach::Beyond(end) => self.values[split..].partition_point(|l| *l <= end) + 1,
        };
        let needed_below = match window.below {
            Reach::Count(count) => count,
            Reach::Beyond(end) => split - self.values[..split].partition_point(|l| *l < end) + 1,
        };
        // A few beyond the window give a choice of gaps to cut at; more would only cost time.
        let keep = |found: usize, needed: usize| found.min(needed + 3);
        (above >= needed_above && below >= needed_below)
            .then(|| split - keep(below, needed_below)..split + keep(above, needed_above))
    }
}

/// Factors A − σI, moving the shift by small steps while it sits on an eigenvalue.
pub(super) fn factor_near(
    problem: &Problem,
    shift: &mut f64,
    nudge: f64,
    factor: &mut Factor,
    workspace: &mut Workspace,
    profile: &mut Profile,
) -> bool {
    let start = Instant::now();
    let mut done = false;
    for attempt in 0..8 {
        if factor.compute(&problem.symbolic, &problem.matrix, *shift, workspace).is_ok() {
            done = true;
            break;
        }
        *shift += nudge * f64::from(attempt + 1);
    }
    profile.factor += start.elapsed().as_secs_f64();
    profile.factored += 1;
    done
}
