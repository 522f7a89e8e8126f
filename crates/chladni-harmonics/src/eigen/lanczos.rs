//! Block Lanczos on (A − σI)⁻¹: the eigenpairs of A nearest to one shift.

use chladni_task::Task;

use super::krylov::{Krylov, subtract_projections};
use super::orthonormal::{Dependence, orthonormalize};
use super::problem::{Problem, Profile};
use super::tall::{BLOCK, Small};
use super::window::{Pairs, Stopped, Window};
use crate::ldlt::{Factor, Row, Workspace};
use crate::platform::Instant;

/// The factor by which one more block reduces the residuals at the ends of a window (measured between 3.6 and
/// 4.2).
const GAIN: f64 = 3.8;
/// Up to this many vertices a step is cheaper than an eigenproblem in the space.
const SMALL: usize = 5000;

/// Finds pairs around `shift`, given its `factor`, orthogonal to the pairs in `locked`.
pub(super) fn run(
    problem: &Problem,
    factor: &Factor,
    shift: f64,
    window: &Window,
    locked: &[&Pairs],
    seed: u64,
    careful: bool,
    profile: &mut Profile,
    task: &Task,
) -> Result<Pairs, Stopped> {
    let n = problem.matrix.size();
    let locked: Vec<&[Row]> = locked.iter().flat_map(|p| p.blocks.iter()).collect();
    // Convergence takes about twice as many vectors as pairs, plus 16 blocks. A check costs a dense solve,
    // which is more than a step or two on a small mesh.
    let twice = (window.expected * 2).div_ceil(BLOCK);
    let mut look_at = twice + if n > SMALL { 12 } else { 15 };
    let mut krylov = Krylov::new(n > SMALL && !careful, twice + 16);
    let mut next = random_block(n, seed);
    problem.remove_constants(window.from_zero, &mut next);
    for _ in 0..2 {
        subtract_projections(&mut next, &locked);
        let Ok(_) = orthonormalize(&mut next, &[0.0; 8]) else {
            return Err(Stopped::BadShift);
        };
    }
    krylov.begin(problem, &next);
    drop(next);
    loop {
        task.check()?;
        let start = Instant::now();
        let image = krylov.extend(problem);
        problem.solve(factor, image);
        profile.solve += start.elapsed().as_secs_f64();
        profile.solved_columns += BLOCK as u64;
        let start = Instant::now();
        problem.remove_constants(window.from_zero, image);
        let sizes = krylov.orthogonalize(problem, &locked, profile).ok_or(Stopped::BadShift)?;
        let (basis, image) = krylov.split();
        let upper = match orthonormalize(image, &sizes.map(|size| RANK * size)) {
            Ok(upper) => upper,
            Err(Dependence::Spoiled) => return Err(Stopped::BadShift),
            Err(Dependence::Found) => {
                // The space has become invariant in some direction: continue with a new random one.
                let seed = seed.wrapping_add(basis.len() as u64).rotate_left(17);
                let all: Vec<&[Row]> = locked.iter().copied().chain(basis).collect();
                fill_up(problem, window, image, &sizes, &all, seed).ok_or(Stopped::Exhausted)?
            }
        };
        krylov.below.push(upper);
        profile.orthogonalize += start.elapsed().as_secs_f64();
        let m = krylov.len() * BLOCK;
        if m + 2 * BLOCK > n || m > 8 * window.expected + 60 * BLOCK {
            return Err(Stopped::Exhausted);
        }
        if krylov.len() < look_at {
            continue;
        }
        let start = Instant::now();
        let ritz = krylov.ritz(shift).ok_or(Stopped::BadShift)?;
        let chosen = ritz.converged(window, problem, shift);
        profile.project += start.elapsed().as_secs_f64();
        let chosen = match chosen {
            Ok(chosen) => chosen,
            Err(excess) => {
                look_at += ((excess.ln() / GAIN.ln()).ceil() as usize).clamp(1, 6);
                continue;
            }
        };
        let start = Instant::now();
        let pairs = krylov.vectors(problem, &ritz, chosen);
        profile.vectors += start.elapsed().as_secs_f64();
        krylov.give_back(problem);
        return Ok(pairs);
    }
}

/// The remainder of a column of OP V outside the space is only rounding if it is smaller than the column by
/// this factor.
const RANK: f64 = 1e-11;

/// The smallest step away from an eigenvalue, as a share of the largest diagonal value; pivots below 1e-15 of
/// that count as zero.
const LEAST_NUDGE: f64 = 4e-15;

/// Replaces X by Q of X = Q R, column by column. A column that depends on others or is only rounding is
/// replaced by a random one orthogonal to all others, with zeros in R. `None` if no direction is left.
fn fill_up(
    problem: &Problem,
    window: &Window,
    x: &mut [Row],
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
    let column = |x: &[Row], j: usize| x.iter().map(|row| row[j]).collect::<Vec<f64>>();
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

/// Uniform random numbers in [-½, ½) by SplitMix64; the same for every number of threads.
fn random_block(n: usize, seed: u64) -> Vec<Row> {
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

/// Factors A − σI, moving the shift by small steps as long as it lies on an eigenvalue.
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
    // A smaller step would be lost in rounding.
    let nudge = nudge.abs().max(LEAST_NUDGE * problem.largest).copysign(nudge);
    for attempt in 0..8 {
        if problem.factor(factor, *shift, workspace).is_ok() {
            done = true;
            break;
        }
        *shift += nudge * f64::from(attempt + 1);
    }
    profile.factor += start.elapsed().as_secs_f64();
    profile.factored += 1;
    done
}
