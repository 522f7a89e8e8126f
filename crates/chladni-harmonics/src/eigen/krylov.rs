//! The Krylov space that block Lanczos builds, and the eigenpairs in it.

use std::ops::Range;

use faer::{Mat, Par};

use super::problem::{Problem, Profile};
use super::tall::{BLOCK, Blocks, Small, overlaps, subtract_products};
use super::window::{Pairs, Reach, Window};
use crate::ldlt::Row;
use crate::symmetric_eigen::symmetric_eigen;

/// The numbers of blocks at which Ritz vectors are selected, when about that many have converged, and how
/// many blocks of them to select.
const SELECTIONS: [usize; 4] = [10, 18, 30, 45];
const SELECTED: usize = 2;
/// Selecting pays if at least this share of the steps remains.
const WORTH: f64 = 0.3;
/// The largest number of steps between full reorthogonalizations.
const LONGEST_PERIOD: usize = 6;
/// Overlaps between blocks at which to reorthogonalize less often, more often, and at which to give up.
const SLIGHT: f64 = 3e-11;
const GRAVE: f64 = 1e-9;
const LOST: f64 = 1e-5;

/// An orthonormal basis V of blocks and the block tridiagonal T = Vᵀ OP V.
#[derive(Default)]
pub(super) struct Krylov {
    space: Vec<Blocks>,
    /// How many of the blocks in `space` belong to V; the block after them comes next.
    blocks: usize,
    /// V_jᵀ OP V_j.
    diagonal: Vec<Small>,
    /// The triangular factor of the part of OP V_j outside V_0 … V_j.
    pub below: Vec<Small>,
    /// Whether Ritz vectors are selected; otherwise every second step reorthogonalizes fully.
    selects: bool,
    /// The expected number of blocks.
    expected: usize,
    /// Ritz vectors of the largest |θ|, along which orthogonality is lost first.
    selected: Vec<Blocks>,
    /// The number of blocks at the last full reorthogonalization of the newest two.
    swept_at: usize,
    /// The number of steps until the next one.
    period: usize,
}

/// Eigenpairs of T.
pub(super) struct Ritz {
    /// Approximations of eigenvalues of A, ascending.
    values: Vec<f64>,
    /// For each, the index of its eigenvector of T, and its θ = 1 / (λ − σ).
    from: Vec<(usize, f64)>,
    /// For each, ‖A x − λ x‖ after the free purification step (see [`Krylov::vectors`]).
    residuals: Vec<f64>,
    coordinates: Mat<f64>,
    /// R · last block of coordinates: the part of each vector that lies in the next block.
    leaving: Mat<f64>,
}

impl Krylov {
    pub fn new(selects: bool, expected: usize) -> Self {
        Self { selects, expected, ..Self::default() }
    }

    /// An empty space, whose first block will be `first`.
    pub fn begin(&mut self, problem: &Problem, first: &[Row]) {
        self.space.push(problem.spare_blocks());
        self.split().1.copy_from_slice(first);
    }

    /// The number of blocks in V.
    pub fn len(&self) -> usize {
        self.blocks
    }

    /// The blocks of V, and the one that comes next.
    pub fn split(&mut self) -> (Vec<&[Row]>, &mut [Row]) {
        let blocks = self.space.iter_mut().flat_map(Blocks::iter_mut).take(self.blocks + 1);
        let mut blocks: Vec<&mut [Row]> = blocks.collect();
        let next = blocks.pop().unwrap_or_default();
        (blocks.into_iter().map(|block| &*block).collect(), next)
    }

    /// Appends the next block to V, and puts a copy of it in the place after it.
    pub fn extend(&mut self, problem: &Problem) -> &mut [Row] {
        self.blocks += 1;
        if self.space.iter().flat_map(Blocks::iter).count() == self.blocks {
            self.space.push(problem.spare_blocks());
        }
        let (basis, next) = self.split();
        if let Some(last) = basis.last() {
            next.copy_from_slice(last);
        }
        next
    }

    /// Orthogonalizes the next block = OP · (last block) against the space, keeping the coefficients of the
    /// last block as the next diagonal block of T. Returns the length of each column inside the space, or
    /// `None` if orthogonality has been lost.
    ///
    /// In exact arithmetic only the last two blocks have a component to remove. Rounding reintroduces the
    /// older ones, growing by θ in each step along the Ritz vectors of the largest θ in magnitude. Every
    /// second step therefore orthogonalizes against those (selective orthogonalization, Parlett & Scott
    /// 1979), or against the whole space. The latter is done as rarely as the measured loss permits: T and
    /// its eigenvalues are accurate while the loss is below the root of the rounding unit (Simon 1984).
    /// Both treat the newest two blocks together, to read the space only once.
    pub fn orthogonalize(
        &mut self,
        problem: &Problem,
        locked: &[&[Row]],
        profile: &mut Profile,
    ) -> Option<Row> {
        // The overlaps and the terms subtracted, block by block.
        let products = |pairs: usize| (4 * problem.matrix.size() * BLOCK * BLOCK * pairs) as u64;
        let blocks = self.blocks;
        let mut basis: Vec<&mut [Row]> =
            self.space.iter_mut().flat_map(Blocks::iter_mut).take(blocks + 1).collect();
        let image = basis.pop()?;
        let recent: Vec<&[Row]> = basis[blocks.saturating_sub(2)..].iter().map(|block| &**block).collect();
        let coefficients = overlaps(&recent, &[image]);
        subtract_products(&mut [&mut *image], &recent, &coefficients);
        self.diagonal.extend(coefficients.last());
        profile.orthogonalize_flops += products(recent.len());
        if blocks.is_multiple_of(2)
            && let Some((last, older)) = basis.split_last_mut()
        {
            let whole = blocks >= self.swept_at + self.period;
            let space: Vec<&[Row]> = if whole {
                locked.iter().copied().chain(older.iter().map(|block| &**block)).collect()
            } else {
                self.selected.iter().flat_map(Blocks::iter).collect()
            };
            profile.orthogonalize_flops += products(2 * space.len());
            let rest = overlaps(&space, &[&**last, &*image]);
            subtract_products(&mut [&mut **last, image], &space, &rest);
            if whole {
                let of_last = rest.iter().step_by(2).flat_map(|c| c.as_flattened());
                let loss = of_last.fold(0.0_f64, |most, c| most.max(c.abs()));
                self.swept_at = blocks;
                self.period = match loss {
                    // Newly converged Ritz vectors make the loss grow faster than before.
                    _ if self.selected.is_empty() => 2,
                    ..SLIGHT => (self.period + 2).min(LONGEST_PERIOD),
                    ..GRAVE => self.period,
                    ..LOST => (self.period - 2).max(2),
                    _ => return None,
                };
            }
        }
        // New blocks are kept orthogonal to them from now on, but the newest block is not yet.
        if self.selects
            && SELECTIONS.contains(&blocks)
            && blocks as f64 <= (1.0 - WORTH) * self.expected as f64
        {
            self.select(problem)?;
            profile.orthogonalize_flops += products(blocks * SELECTED);
        }
        Some(column_sizes(&coefficients))
    }

    /// Selects more Ritz vectors: those with the largest |θ| that are not selected yet.
    fn select(&mut self, problem: &Problem) -> Option<()> {
        let (thetas, coordinates) = symmetric_eigen(&self.projected(), Par::Seq)?;
        let mut order: Vec<usize> = (0..thetas.len()).collect();
        order.sort_by(|&a, &b| thetas[b].abs().total_cmp(&thetas[a].abs()));
        let order = &order[self.selected.len() * SELECTED * BLOCK..];
        let basis: Vec<&[Row]> = self.space.iter().flat_map(Blocks::iter).take(self.blocks).collect();
        let more =
            combine(problem, &basis, SELECTED * BLOCK, |row, column| coordinates[(row, order[column])]);
        self.selected.push(more);
        Some(())
    }

    pub fn give_back(self, problem: &Problem) {
        problem.give_back(self.space);
    }

    /// Computes T.
    fn projected(&self) -> Mat<f64> {
        let blocks = self.blocks;
        let mut t = Mat::<f64>::zeros(blocks * BLOCK, blocks * BLOCK);
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
        t
    }

    pub fn ritz(&self, shift: f64) -> Option<Ritz> {
        let blocks = self.blocks;
        let m = blocks * BLOCK;
        let (thetas, coordinates) = symmetric_eigen(&self.projected(), Par::Seq)?;
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

    /// The chosen Ritz vectors, improved by one step of inverse iteration that needs no solve: by the
    /// Lanczos relation OP V s / θ = V s + V_next R s_last / θ (Ericsson & Ruhe 1980).
    pub fn vectors(&self, problem: &Problem, ritz: &Ritz, chosen: Range<usize>) -> Pairs {
        let basis: Vec<&[Row]> = self.space.iter().flat_map(Blocks::iter).take(self.blocks + 1).collect();
        let scales: Vec<f64> = ritz.from[chosen.clone()]
            .iter()
            .map(|&(j, theta)| {
                let extra: f64 = (0..BLOCK).map(|i| (ritz.leaving[(i, j)] / theta).powi(2)).sum();
                1.0 / (1.0 + extra).sqrt()
            })
            .collect();
        let inside = self.blocks * BLOCK;
        let blocks = combine(problem, &basis, chosen.len(), |row, column| {
            let (j, theta) = ritz.from[chosen.start + column];
            scales[column]
                * if row < inside {
                    ritz.coordinates[(row, j)]
                } else {
                    ritz.leaving[(row - inside, j)] / theta
                }
        });
        Pairs { values: ritz.values[chosen].to_vec(), blocks }
    }
}

/// `count` combinations of the vectors in `basis`, given the coefficient of each vector.
fn combine(
    problem: &Problem,
    basis: &[&[Row]],
    count: usize,
    coefficient: impl Fn(usize, usize) -> f64,
) -> Blocks {
    if count == 0 {
        return Blocks::default();
    }
    let groups = count.div_ceil(BLOCK);
    let mut coefficients = vec![[[0.0; 8]; BLOCK]; basis.len() * groups];
    for (block, c) in coefficients.chunks_exact_mut(groups).enumerate() {
        for column in 0..count {
            for i in 0..BLOCK {
                // Negative, because the kernel subtracts.
                c[column / BLOCK][i][column % BLOCK] = -coefficient(block * BLOCK + i, column);
            }
        }
    }
    let mut blocks = Blocks::zeroed(problem.matrix.size(), groups);
    let mut views: Vec<&mut [Row]> = blocks.iter_mut().collect();
    subtract_products(&mut views, basis, &coefficients);
    blocks
}

impl Ritz {
    /// The pairs to keep, once all pairs of the window have converged: those from the shift outward, on
    /// each side up to the first that has not converged. Before that, an error: the factor by which the
    /// worst pair of the window exceeds its tolerance.
    pub fn converged(&self, window: &Window, problem: &Problem, shift: f64) -> Result<Range<usize>, f64> {
        let excess = |i: usize| self.residuals[i] / problem.tolerance(self.values[i], shift, window);
        let good = |i: usize| excess(i) <= 1.0;
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
        if above < needed_above || below < needed_below {
            let needed = split.saturating_sub(needed_below)..(split + needed_above).min(self.values.len());
            return Err(needed.map(excess).fold(1.0, f64::max));
        }
        // A few pairs beyond the window give a choice of gaps to cut at; more would only cost time.
        let keep = |found: usize, needed: usize| found.min(needed + 3);
        Ok(split - keep(below, needed_below)..split + keep(above, needed_above))
    }
}

pub(super) fn subtract_projections(x: &mut [Row], onto: &[&[Row]]) {
    if !onto.is_empty() {
        let coefficients = overlaps(onto, &[x]);
        subtract_products(&mut [x], onto, &coefficients);
    }
}

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
