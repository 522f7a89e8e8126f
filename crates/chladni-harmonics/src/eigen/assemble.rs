//! Checks the joined pairs and writes them as a basis.

use chladni_task::Task;
use rayon::prelude::*;

use super::Wanted;
use super::columns::write_columns;
use super::found::{Entry, Found};
use super::join::Known;
use super::problem::Problem;
use super::tall::{BLOCK, Small, overlaps, subtract_products, upper_overlaps};
use crate::ldlt::Row;
use crate::{Basis, Certificate, HarmonicsError, Laplacian, Pencil};

/// A larger residual is an error.
const MAX_RELATIVE_RESIDUAL: f64 = 1e-7;
const MAX_ORTHOGONALITY_ERROR: f64 = 1e-7;
/// Overlaps between neighboring slices above this are removed.
const OVERLAP: f64 = 0.2 * Certificate::ORTHOGONALITY;

/// Measurements of the pairs of one slice.
struct Measured {
    /// Largest ‖S h − λ M h‖ / ‖S h‖.
    relative: f64,
    /// Largest ‖A x − λ x‖.
    absolute: f64,
    /// Largest |xᵀy − δ| within the slice and with the slice below.
    overlap: f64,
    low: f64,
    high: f64,
}

/// The first of the known pairs as a certified basis: as many as are wanted.
pub(super) fn assemble(
    problem: &Problem,
    pencil: Pencil,
    mut slices: Vec<Found>,
    known: &Known,
    wanted: Wanted,
    task: &Task,
) -> Result<Basis, HarmonicsError> {
    let keep = wanted.harmonics;
    let zeros = problem.zeros.min(keep);
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
    let shared = separate_neighbors(&mut slices, &ranges);
    task.check()?;
    let measured: Vec<Option<Measured>> = slices
        .par_iter()
        .zip(&ranges)
        .zip(shared)
        .map(|((found, own), shared)| measure(problem, found, own, shared))
        .collect();
    let certificate = certificate(&measured);
    check_certificate(&certificate)?;
    task.check()?;
    let n = pencil.mass.len();
    let mut vectors = wanted.vectors(n, keep)?;
    let (constant, mut rest) = vectors.split_at_mut(n * zeros);
    constant.fill(problem.area.sqrt().recip());
    // The row of each vertex, and 1/√a.
    let mut places = vec![(0_u32, 0.0_f64); n];
    for (i, (&old, root)) in problem.symbolic.old.iter().zip(&problem.root_mass).enumerate() {
        places[old as usize] = (i as u32, root.recip());
    }
    let mut jobs = Vec::with_capacity(slices.len());
    for (found, own) in slices.into_iter().zip(&ranges) {
        let (out, after) = rest.split_at_mut(n * own.len());
        rest = after;
        jobs.push((found, *own, out));
    }
    // Each slice is freed as soon as it is written: the vectors are in memory only once.
    jobs.into_par_iter()
        .with_max_len(1)
        .for_each(|(found, own, out)| write(problem, found, own, &places, out));
    let mut eigenvalues = vec![0.0; zeros];
    eigenvalues.extend(entries.iter().map(|e| e.value));
    Ok(Basis { eigenvalues, vectors, mass: pencil.mass.to_vec(), certificate })
}

/// Refuses pairs whose errors are too large to return them, or that are not as many as were counted.
pub(crate) fn check_certificate(certificate: &Certificate) -> Result<(), HarmonicsError> {
    if certificate.inertia_counts_match == Some(false) {
        return Err(HarmonicsError::not_certified("the counts of eigenvalues do not agree"));
    }
    let Certificate { max_relative_residual: residual, max_orthogonality_error: overlap, .. } = *certificate;
    // NaN is not small.
    if residual <= MAX_RELATIVE_RESIDUAL && overlap <= MAX_ORTHOGONALITY_ERROR {
        return Ok(());
    }
    Err(HarmonicsError::not_certified(format!(
        "the relative residual is {residual:.1e} and the orthogonality error {overlap:.1e}"
    )))
}

/// Writes the pairs of one slice as columns of `out`.
fn write(problem: &Problem, mut found: Found, own: &[Entry], places: &[(u32, f64)], out: &mut [f64]) {
    found
        .runs
        .iter_mut()
        .flat_map(|pairs| pairs.blocks.iter_mut())
        .for_each(|block| problem.untransform(block));
    let mut columns: Vec<Option<&mut [f64]>> = out.chunks_exact_mut(places.len()).map(Some).collect();
    for (block, used) in used_blocks(&found, own) {
        let mut outs = used.map(|column| columns[column?].take());
        write_columns(block, places, &mut outs);
    }
}

/// The blocks of a slice that hold any of the `own` pairs; for each of their columns the index in `own`, if
/// it is one of them.
fn used_blocks<'a>(found: &'a Found, own: &[Entry]) -> Vec<(&'a [Row], [Option<usize>; BLOCK])> {
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
                blocks.push((block, columns));
            }
        }
    }
    blocks
}

/// Vectors of two slices can overlap if eigenvalues on both sides of a cut are nearly equal. The vectors of
/// the upper slice are then orthogonalized against those of the lower one. Returns the remaining overlap of
/// each slice with the slice below.
fn separate_neighbors(slices: &mut [Found], ranges: &[&[Entry]]) -> Vec<f64> {
    let with_lower = |slices: &[Found], s: usize| {
        if s == 0 { 0.0 } else { largest_overlap(&slices[s - 1], ranges[s - 1], &slices[s], ranges[s]) }
    };
    let mut shared: Vec<f64> = (0..slices.len()).into_par_iter().map(|s| with_lower(slices, s)).collect();
    for s in 1..slices.len() {
        if shared[s] <= OVERLAP {
            continue;
        }
        let (lower, upper) = slices.split_at_mut(s);
        let lower_blocks = used_blocks(&lower[s - 1], ranges[s - 1]);
        for block in upper[0].runs.iter_mut().flat_map(|pairs| pairs.blocks.iter_mut()) {
            for (against, columns) in &lower_blocks {
                let mut overlap = overlaps(&[against], &[&*block]);
                overlap.iter_mut().for_each(|c| keep_rows(c, columns));
                subtract_products(&mut [&mut *block], &[against], &overlap);
            }
        }
        shared[s] = with_lower(slices, s);
    }
    shared
}

/// Clears the coefficients of columns that are not in use.
fn keep_rows(c: &mut Small, columns: &[Option<usize>; BLOCK]) {
    for (row, column) in c.iter_mut().zip(columns) {
        if column.is_none() {
            *row = [0.0; 8];
        }
    }
}

fn largest_overlap(lower: &Found, lower_own: &[Entry], upper: &Found, upper_own: &[Entry]) -> f64 {
    deviation(&used_blocks(lower, lower_own), &used_blocks(upper, upper_own), false)
}

/// Blocks, and for each of their columns the index of its pair, if it is in use.
type Used<'a> = [(&'a [Row], [Option<usize>; BLOCK])];

/// The largest |xᵀy| over the used columns x of `a` and y of `b`, minus 1 on the diagonal if the two are
/// the `same`.
fn deviation(a: &Used, b: &Used, same: bool) -> f64 {
    let (left, right): (Vec<&[Row]>, Vec<&[Row]>) =
        (a.iter().map(|u| u.0).collect(), b.iter().map(|u| u.0).collect());
    let products = if same { upper_overlaps(&left) } else { overlaps(&left, &right) };
    let mut largest = 0.0_f64;
    for (at, (rows, products)) in a.iter().zip(products.chunks_exact(b.len().max(1))).enumerate() {
        for (columns, product) in b.iter().zip(products).skip(if same { at } else { 0 }) {
            for (x, row) in rows.1.iter().zip(product).filter_map(|(x, row)| Some(((*x)?, row))) {
                for (y, value) in columns.1.iter().zip(row).filter_map(|(y, value)| Some(((*y)?, value))) {
                    let error = (value - f64::from(u8::from(same && x == y))).abs();
                    // NaN must not count as small.
                    largest = if error.is_nan() { f64::INFINITY } else { largest.max(error) };
                }
            }
        }
    }
    largest
}

fn measure(problem: &Problem, found: &Found, own: &[Entry], shared: f64) -> Option<Measured> {
    let (first, last) = (own.first()?, own.last()?);
    let blocks = used_blocks(found, own);
    let (mut relative, mut absolute) = (0.0_f64, 0.0_f64);
    for (block, columns) in &blocks {
        let values = columns.map(|column| column.map_or(0.0, |i| own[i].value));
        let [plain, weighted, image] = problem.residuals(block, &values);
        for j in (0..BLOCK).filter(|&j| columns[j].is_some()) {
            absolute = absolute.max(plain[j].sqrt());
            let share = (weighted[j] / image[j]).sqrt();
            relative = if share.is_nan() { f64::INFINITY } else { relative.max(share) };
        }
    }
    let overlap = shared.max(deviation(&blocks, &blocks, true));
    Some(Measured { relative, absolute, overlap, low: first.value, high: last.value })
}

/// The certificate of all slices. Inertia counts agree by construction of [`Known`]. Overlaps within a
/// slice and with its neighbor are measured. Those between other slices, and with the constant of λ = 0,
/// are bounded: |xᵀy| ≤ (‖r_x‖ + ‖r_y‖) / |λ_x − λ_y| for a symmetric A.
fn certificate(measured: &[Option<Measured>]) -> Certificate {
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
        if *s > 0 {
            overlap = overlap.max(m.absolute / m.low);
        }
    }
    Certificate {
        laplacian: Laplacian::default(),
        inertia_counts_match: Some(true),
        max_relative_residual: relative,
        max_orthogonality_error: overlap,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pairs_that_are_wrong_missing_or_unmeasured_are_refused() {
        let rough = Certificate {
            laplacian: Laplacian::default(),
            inertia_counts_match: None,
            max_relative_residual: 9e-8,
            max_orthogonality_error: 9e-8,
        };
        assert!(check_certificate(&rough).is_ok());
        for refused in [
            Certificate { inertia_counts_match: Some(false), ..rough },
            Certificate { max_relative_residual: 2e-7, ..rough },
            Certificate { max_relative_residual: f64::NAN, ..rough },
            Certificate { max_orthogonality_error: 2e-7, ..rough },
        ] {
            let error = check_certificate(&refused).unwrap_err();
            assert!(matches!(error, HarmonicsError::NotCertified { .. }), "{error}");
        }
    }
}
