//! The formula in double precision, directly from the basis: for exports and as the reference.

use chladni_harmonics::Body;

use crate::normals::area_weighted_normals;
use crate::plan::check_term;
use crate::{Coefficients, Item, Residual, SynthError};

/// x' − x of one item, N values in the working frame.
pub(crate) fn displacements(body: &Body, item: &Item) -> Result<Vec<[f64; 3]>, SynthError> {
    let (vertices, harmonics) = (body.positions.len(), body.basis.harmonics());
    for (term, t) in item.terms.iter().enumerate() {
        check_term(t, vertices, harmonics).map_err(|e| e.at(0, term))?;
    }
    let normal_form = item.terms.iter().any(|t| matches!(t.coefficients, Coefficients::Normal(_)));
    let normals =
        if normal_form { area_weighted_normals(&body.positions, &body.triangles)? } else { Vec::new() };
    let mut sum = vec![[0.0; 3]; vertices];
    for term in &item.terms {
        let gain = f64::from(term.residual_gain);
        let residual = term.residual.as_ref().filter(|_| gain != 0.0);
        let mask = |v: usize| term.mask.as_ref().map_or(1.0, |m| f64::from(m[v]));
        match &term.coefficients {
            Coefficients::Vector(c) => {
                let c: Vec<[f64; 3]> = c.iter().map(|c| c.map(f64::from)).collect();
                body.basis.synthesize_each(&c, &mut sum, |v, mut signal, sum| {
                    if let Some(Residual::Vector(r)) = residual {
                        (0..3).for_each(|i| signal[i] += f64::from(r[v][i]) * gain);
                    }
                    let mask = mask(v);
                    (0..3).for_each(|i| sum[i] += mask * signal[i]);
                });
            }
            Coefficients::Normal(c) => {
                let c: Vec<[f64; 1]> = c.iter().map(|c| [f64::from(*c)]).collect();
                body.basis.synthesize_each(&c, &mut sum, |v, [mut signal], sum| {
                    if let Some(Residual::Normal(r)) = residual {
                        signal += f64::from(r[v]) * gain;
                    }
                    let mask = mask(v);
                    (0..3).for_each(|i| sum[i] += mask * (signal * normals[v][i]));
                });
            }
        }
    }
    Ok(sum)
}
