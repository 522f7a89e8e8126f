//! Checking the joined pairs and writing them out as a basis.

use chladni_task::Task;
use rayon::prelude::*;

use super::fix_sign;
use super::join::{Entry, Known};
use super::lanczos::{BLOCK, W};
use super::problem::Problem;
use super::slicing::{Found, not_certified};
use super::tall::{Small, overlaps, residuals, subtract_products};
use crate::ldlt::Row;
use crate::{Basis, Certificate, HarmonicsError, Operator};

/// Limits that a basis must keep to be handed out.
const MAX_RELATIVE_RESIDUAL: f64 = 1e-7;
const MAX_ORTHOGONALITY_ERROR: f64 = 1e-7;
/// Overlaps between neighbouring slices above this are taken out.
const OVERLAP: f64 = 1e-10;

/// What was measured of one slice's pairs.
struct Measured {
    /// Largest ‖S h − λ M h‖ / ‖S h‖.
    relative: f64,
    /// Largest ‖A x − λ x‖.
    absolute: f64,
    /// Largest |xᵀy − δ| within the slice and to the one below.
    overlap: f64,
    low: f64,
    high: f64,
}

/// The first `keep` pairs as a certified basis.
pub(super) fn assemble(
    problem: &Problem,
    operator: &Operator,
    mut slices: Vec<Found>,
    known: &Known,
    keep: usize,
    task: &Task,
) -> Result<Basis, HarmonicsError> {
    let zeros = problem.components().min(keep);
    let entries = &known.entries[..keep - zeros];
    let ranges: Vec<&[Entry]> = {
        let mut rest = entries;
        (0..slices.len())
            .map(|s| {
                let (own, after) = rest.split_at(rest.partition_point(|e| e.slice == s));
                rest = after;
                own
            })
            .collect()
    };
    separate_neighbors(&mut slices, &ranges);
    task.check()?;
    let measured: Vec<Option<Measured>> =
        (0..slices.len()).into_par_iter().map(|s| measure(problem, &slices, &ranges, s)).collect();
    let certificate = certificate(problem, &measured);
    if certificate.max_relative_residual > MAX_RELATIVE_RESIDUAL
        || certificate.max_orthogonality_error > MAX_ORTHOGONALITY_ERROR
    {
        return Err(not_certified(format!(
            "the relative residual is {:.1e} and the orthogonality error {:.1e}",
            certificate.max_relative_residual, certificate.max_orthogonality_error
        )));
    }
    task.check()?;
    let n = operator.vertices();
    let mut vectors = vec![0.0; n * keep];
    let (constants, mut rest) = vectors.split_at_mut(n * zeros);
    for (c, h) in constants.chunks_exact_mut(n).enumerate() {
        h.iter_mut().zip(problem.constant(operator, c)).for_each(|(h, value)| *h = value);
    }
    let mut new = vec![0_u32; n];
    for (i, &old) in problem.symbolic.old.iter().enumerate() {
        new[old as usize] = i as u32;
    }
    let mut jobs = Vec::with_capacity(slices.len());
    for (found, own) in slices.into_iter().zip(&ranges) {
        let (out, after) = rest.split_at_mut(n * own.len());
        rest = after;
        jobs.push((found, *own, out));
    }
    // Each slice is given up as soon as it is written: the vectors are in memory once.
    jobs.into_par_iter()
        .with_max_len(1)
        .for_each(|(found, own, out)| write(&found, own, &new, &operator.mass, out));
    let mut eigenvalues = vec![0.0; zeros];
    eigenvalues.extend(entries.iter().map(|e| e.value));
    Ok(Basis { eigenvalues, vectors, mass: operator.mass.clone(), certificate })
}

fn write(found: &Found, own: &[Entry], new: &[u32], mass: &[f64], out: &mut [f64]) {
    const ROWS: usize = 32;
    let n = new.len();
    if own.is_empty() {
        return;
    }
    let sources: Vec<(&[Row<W>], usize)> = own
        .iter()
        .map(|e| (found.runs[e.run].blocks[e.column / BLOCK].as_slice(), e.column % BLOCK))
        .collect();
    for first in (0..n).step_by(ROWS) {
        let end = (first + ROWS).min(n);
        for (h, (block, column)) in out.chunks_exact_mut(n).zip(&sources) {
            for v in first..end {
                h[v] = block[new[v] as usize][column / 8][column % 8] / mass[v].sqrt();
            }
        }
    }
    out.chunks_exact_mut(n).for_each(fix_sign);
}

/// The blocks of a slice that hold any of `own`, with the column of `own` in each place.
fn used_blocks<'a>(found: &'a Found, own: &[Entry]) -> Vec<(&'a [Row<W>], [Option<usize>; BLOCK])> {
    let mut blocks = Vec::new();
    for (run, pairs) in found.runs.iter().enumerate() {
        for (number, block) in pairs.blocks.iter().enumerate() {
            let mut columns = [None; BLOCK];
            for (i, e) in own.iter().enumerate() {
                if e.run == run && e.column / BLOCK == number {
                    columns[e.column % BLOCK] = Some(i);
                }
            }
            if columns.iter().any(Option::is_some) {
                blocks.push((block.as_slice(), columns));
            }
        }
    }
    blocks
}

/// Vectors of two slices can overlap where eigenvalues on both sides of a cut are nearly equal;
/// the upper slice's are then made orthogonal to the lower one's.
fn separate_neighbors(slices: &mut [Found], ranges: &[&[Entry]]) {
    let offending: Vec<bool> = (0..slices.len())
        .into_par_iter()
        .map(|s| s > 0 && largest_overlap(&slices[s - 1], ranges[s - 1], &slices[s], ranges[s]) > OVERLAP)
        .collect();
    for s in (1..slices.len()).filter(|&s| offending[s]) {
        let (lower, upper) = slices.split_at_mut(s);
        let lower_blocks = used_blocks(&lower[s - 1], ranges[s - 1]);
        for pairs in &mut upper[0].runs {
            for block in &mut pairs.blocks {
                for (against, columns) in &lower_blocks {
                    let mut overlap = overlaps(&[*against], block);
                    for c in &mut overlap {
                        keep_rows(c, columns);
                    }
                    subtract_products(block, &[*against], &overlap);
                }
            }
        }
    }
}

/// Clears the coefficients of columns that are not among those in use.
fn keep_rows(c: &mut Small<W>, columns: &[Option<usize>; BLOCK]) {
    for (row, column) in c.iter_mut().zip(columns) {
        if column.is_none() {
            *row = [[0.0; 8]; W];
        }
    }
}

fn largest_overlap(lower: &Found, lower_own: &[Entry], upper: &Found, upper_own: &[Entry]) -> f64 {
    let lower = used_blocks(lower, lower_own);
    let mut largest = 0.0_f64;
    for (block, columns) in used_blocks(upper, upper_own) {
        for (against, rows) in &lower {
            largest = largest.max(deviation(against, rows, block, &columns, false));
        }
    }
    largest
}

/// Largest |xᵀy| (less 1 where x is y) over the used columns of two blocks.
fn deviation(
    a: &[Row<W>],
    rows: &[Option<usize>; BLOCK],
    b: &[Row<W>],
    columns: &[Option<usize>; BLOCK],
    same: bool,
) -> f64 {
    let Some(overlap) = overlaps(&[a], b).pop() else { return 0.0 };
    let mut largest = 0.0_f64;
    for (i, _) in rows.iter().enumerate().filter(|(_, r)| r.is_some()) {
        for (j, _) in columns.iter().enumerate().filter(|(_, c)| c.is_some()) {
            let exact = f64::from(u8::from(same && i == j));
            let error = (overlap[i][j / 8][j % 8] - exact).abs();
            // NaN must not pass for small.
            largest = if error.is_nan() { f64::INFINITY } else { largest.max(error) };
        }
    }
    largest
}

fn measure(problem: &Problem, slices: &[Found], ranges: &[&[Entry]], s: usize) -> Option<Measured> {
    let own = ranges[s];
    let (first, last) = (own.first()?, own.last()?);
    let blocks = used_blocks(&slices[s], own);
    let (mut relative, mut absolute, mut overlap) = (0.0_f64, 0.0_f64, 0.0_f64);
    for (number, (block, columns)) in blocks.iter().enumerate() {
        let mut values = [[0.0; 8]; W];
        for (j, column) in columns.iter().enumerate() {
            values[j / 8][j % 8] = column.map_or(0.0, |i| own[i].value);
        }
        let [plain, weighted, image] = residuals(&problem.matrix, block, &values, &problem.mass);
        for (j, _) in columns.iter().enumerate().filter(|(_, c)| c.is_some()) {
            let at = |x: &Row<W>| x[j / 8][j % 8];
            absolute = absolute.max(at(&plain).sqrt());
            let share = (at(&weighted) / at(&image)).sqrt();
            relative = if share.is_nan() { f64::INFINITY } else { relative.max(share) };
        }
        for (other, (against, rows)) in blocks.iter().enumerate().take(number + 1) {
            overlap = overlap.max(deviation(against, rows, block, columns, other == number));
        }
    }
    if s > 0 {
        overlap = overlap.max(largest_overlap(&slices[s - 1], ranges[s - 1], &slices[s], own));
    }
    Some(Measured { relative, absolute, overlap, low: first.value, high: last.value })
}

/// Inertia counts agree by construction of [`Known`]. Overlaps within a slice and with its
/// neighbour are measured; further apart, and with the constants of λ = 0, they are bounded:
/// |xᵀy| ≤ (‖r_x‖ + ‖r_y‖) / |λ_x − λ_y| for a symmetric A.
fn certificate(problem: &Problem, measured: &[Option<Measured>]) -> Certificate {
    let mut relative = 0.0_f64;
    let mut overlap = 0.0_f64;
    let present: Vec<(usize, &Measured)> =
        measured.iter().enumerate().filter_map(|(s, m)| Some((s, m.as_ref()?))).collect();
    for (i, (s, m)) in present.iter().enumerate() {
        relative = relative.max(m.relative);
        overlap = overlap.max(m.overlap);
        for (lower, l) in &present[..i] {
            if lower + 1 < *s {
                overlap = overlap.max((m.absolute + l.absolute) / (m.low - l.high));
            }
        }
        if *s > 0 && problem.components() > 0 {
            overlap = overlap.max(m.absolute / m.low);
        }
    }
    Certificate {
        inertia_counts_match: true,
        max_relative_residual: relative,
        max_orthogonality_error: overlap,
    }
}
