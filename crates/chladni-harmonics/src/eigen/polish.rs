//! A last step of inverse iteration for the lowest pairs, with a shift below the spectrum.

use rayon::prelude::*;

use super::problem::{Problem, Profile};
use super::tall::{BLOCK, Blocks, Small, overlaps, subtract_products};
use super::window::Pairs;
use crate::ldlt::{Factor, Row, Workspace};
use crate::platform::Instant;

/// The number of rows of the new pairs that one thread computes at a time.
const ROWS: usize = 4096;

/// The pairs after one step of (A − σI)⁻¹ with σ < 0 and a Rayleigh–Ritz projection.
///
/// A shift inside the spectrum leaves errors of the size of rounding times ‖A‖. They are rough (they
/// consist of high harmonics) and can be much larger than the smallest eigenvalues. Below the spectrum A −
/// σI is positive definite, its factor is accurate, and a rough error shrinks by the ratio of λ to the
/// error's own, large eigenvalue. If that factorization fails, the pairs are returned unchanged. `factor`
/// is used only for its memory. Idle threads help; the result does not depend on them.
pub(super) fn polish(problem: &Problem, pairs: Pairs, mut factor: Factor, profile: &mut Profile) -> Pairs {
    let Some(&lowest) = pairs.values.first() else { return pairs };
    let sigma = -0.5 * lowest;
    let start = Instant::now();
    let factored = problem.factor(&mut factor, sigma, &mut Workspace::default());
    profile.factor += start.elapsed().as_secs_f64();
    profile.factored += 1;
    if factored.is_err() {
        return pairs;
    }
    let start = Instant::now();
    let mut images = pairs.blocks.clone();
    images.par_iter_mut().with_max_len(1).for_each(|image| {
        problem.solve(&factor, image);
        problem.remove_constants(true, image);
    });
    profile.solve += start.elapsed().as_secs_f64();
    profile.solved_columns += (BLOCK * images.iter().count()) as u64;
    let start = Instant::now();
    let polished = project(problem, &pairs, &images, sigma);
    profile.vectors += start.elapsed().as_secs_f64();
    polished.unwrap_or(pairs)
}

/// Ritz pairs of OP = (A − σI)⁻¹ in the span of `pairs`, given their `images` under it: with
/// XᵀOP X z = θ XᵀX z, λ = σ + 1/θ and the vector OP X z / θ.
fn project(problem: &Problem, pairs: &Pairs, images: &Blocks, sigma: f64) -> Option<Pairs> {
    let count = pairs.values.len();
    let (xs, ys): (Vec<&[Row]>, Vec<&[Row]>) = (pairs.blocks.iter().collect(), images.iter().collect());
    let symmetric = |products: &[Small]| {
        let entry = |i: usize, j: usize| products[i / BLOCK * ys.len() + j / BLOCK][i % BLOCK][j % BLOCK];
        faer::Mat::from_fn(count, count, |i, j| 0.5 * (entry(i, j) + entry(j, i)))
    };
    // XᵀX is 1 up to small errors, whose squares are negligible: its inverse root is (3 − XᵀX) / 2.
    let side_by_side =
        |with: &[&[Row]]| -> Vec<Small> { xs.par_iter().flat_map_iter(|x| overlaps(&[x], with)).collect() };
    let gram = symmetric(&side_by_side(&xs));
    let root =
        faer::Mat::from_fn(count, count, |i, j| 1.5 * f64::from(u8::from(i == j)) - 0.5 * gram[(i, j)]);
    let projected = &root * symmetric(&side_by_side(&ys)) * &root;
    let (thetas, z) = crate::symmetric_eigen::symmetric_eigen(&projected, faer::Par::Seq)?;
    let z = root * z;
    if thetas.iter().any(|theta| theta.is_nan() || *theta <= 0.0) {
        return None;
    }
    // θ ascends as λ descends.
    let column = |pair: usize| count - 1 - pair;
    let mut coefficients: Vec<Small> = vec![[[0.0; 8]; BLOCK]; ys.len() * ys.len()];
    for pair in 0..count {
        for i in 0..count {
            // Negative, because the kernel subtracts.
            coefficients[i / BLOCK * ys.len() + pair / BLOCK][i % BLOCK][pair % BLOCK] =
                -z[(i, column(pair))] / thetas[column(pair)];
        }
    }
    let mut blocks = Blocks::zeroed(problem.matrix.size(), ys.len());
    let mut parts: Vec<Vec<&mut [Row]>> = Vec::new();
    for block in blocks.iter_mut() {
        for (part, rows) in block.chunks_mut(ROWS).enumerate() {
            if part == parts.len() {
                parts.push(Vec::new());
            }
            parts[part].push(rows);
        }
    }
    parts.par_iter_mut().enumerate().for_each(|(part, rows)| {
        let range = part * ROWS..part * ROWS + rows[0].len();
        let ys: Vec<&[Row]> = ys.iter().map(|y| &y[range.clone()]).collect();
        subtract_products(rows, &ys, &coefficients);
    });
    let values = (0..count).map(|pair| sigma + thetas[column(pair)].recip()).collect();
    Some(Pairs { values, blocks })
}
