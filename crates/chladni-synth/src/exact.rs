//! The one formula in double precision, straight from the basis: for exports and as the reference.

use rayon::prelude::*;

use crate::normals::area_weighted_normals;
use crate::plan::check_term;
use crate::{Coefficients, Item, Residual, SynthError};

/// Vertices per task.
const CHUNK: usize = 1024;

/// x' − x of one item, N values, given the parts of a body.
pub(crate) fn displacements(
    positions: &[[f64; 3]],
    triangles: &[[u32; 3]],
    basis: &[f64],
    item: &Item,
) -> Result<Vec<[f64; 3]>, SynthError> {
    let vertices = positions.len();
    let harmonics = basis.len().checked_div(vertices).unwrap_or(0);
    for (term, t) in item.terms.iter().enumerate() {
        check_term(t, vertices, harmonics).map_err(|e| e.at(0, term))?;
    }
    let normal_form = item.terms.iter().any(|t| matches!(t.coefficients, Coefficients::Normal(_)));
    let normals = if normal_form { area_weighted_normals(positions, triangles)? } else { Vec::new() };

    let mut sum = vec![[0.0; 3]; vertices];
    sum.par_chunks_mut(CHUNK).enumerate().for_each(|(chunk, sum)| {
        let first = chunk * CHUNK;
        let mut signal = vec![[0.0_f64; 3]; sum.len()];
        for term in &item.terms {
            signal.fill([0.0; 3]);
            let gain = f64::from(term.residual_gain);
            let harmonic = |k: usize| &basis[k * vertices + first..][..sum.len()];
            match &term.coefficients {
                Coefficients::Vector(c) => {
                    for (k, c) in c.iter().enumerate().filter(|(_, c)| **c != [0.0; 3]) {
                        let c = c.map(f64::from);
                        signal.iter_mut().zip(harmonic(k)).for_each(|(s, h)| {
                            (0..3).for_each(|i| s[i] += h * c[i]);
                        });
                    }
                    if let (Some(Residual::Vector(r)), true) = (&term.residual, gain != 0.0) {
                        signal.iter_mut().zip(&r[first..]).for_each(|(s, r)| {
                            (0..3).for_each(|i| s[i] += f64::from(r[i]) * gain);
                        });
                    }
                }
                Coefficients::Normal(c) => {
                    for (k, &c) in c.iter().enumerate().filter(|(_, c)| **c != 0.0) {
                        let c = f64::from(c);
                        signal.iter_mut().zip(harmonic(k)).for_each(|(s, h)| s[0] += h * c);
                    }
                    if let (Some(Residual::Normal(r)), true) = (&term.residual, gain != 0.0) {
                        signal.iter_mut().zip(&r[first..]).for_each(|(s, r)| s[0] += f64::from(*r) * gain);
                    }
                    signal.iter_mut().zip(&normals[first..]).for_each(|(s, n)| *s = n.map(|n| s[0] * n));
                }
            }
            for (i, (sum, s)) in sum.iter_mut().zip(&signal).enumerate() {
                let mask = term.mask.as_ref().map_or(1.0, |m| f64::from(m[first + i]));
                (0..3).for_each(|c| sum[c] += mask * s[c]);
            }
        }
    });
    Ok(sum)
}
