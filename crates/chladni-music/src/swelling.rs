//! How far each place may swell along its normal.

use std::sync::Arc;

use chladni_harmonics::Body;

use crate::steepness::Patch;

/// The radius of a limb that moves half as far as a plane, as a share of the diagonal.
const RADIUS: f64 = 0.18;
/// How far curvature is spread over the surface, as a share of the diagonal, where the harmonics are fine enough for it.
const SPREAD: f64 = 0.04;
/// The part of the finest harmonic that is left of the curvature.
const LEAST_PART: f64 = 0.05;

/// The mask of movements along the normal, in (0, 1], N values: 1 / (1 + (κ · [`RADIUS`])²), where κ is ‖∇n‖ around a
/// vertex. A movement u along the normal swells a limb of radius 1 / κ by the share κ u: without the mask, thin ends would
/// turn inside out before the rest has moved at all.
///
/// κ is spread as a measure, so that an edge counts alike however finely it is divided.
pub(crate) fn swelling(body: &Body, normals: &[[f32; 3]], diagonal: f32) -> Arc<[f32]> {
    let basis = &*body.basis;
    let mut bends = vec![0.0f64; body.positions.len()];
    for &corners in &body.triangles {
        let Some(patch) = Patch::of(&body.positions, corners) else { continue };
        let bend = patch.steepness(corners.map(|v| normals[v as usize])) * patch.area() / 3.0;
        corners.iter().for_each(|&v| bends[v as usize] += f64::from(bend));
    }
    let curvature: Vec<f64> = bends
        .iter()
        .zip(&basis.mass)
        .map(|(bend, mass)| if *mass > 0.0 { bend / mass } else { 0.0 })
        .collect();
    let diagonal = f64::from(diagonal);
    let finest = basis.eigenvalues.last().copied().unwrap_or(0.0);
    let time =
        (0.5 * (SPREAD * diagonal).powi(2)).max(if finest > 0.0 { -LEAST_PART.ln() / finest } else { 0.0 });
    let mut spectrum = basis.transform(&curvature);
    spectrum.iter_mut().zip(&basis.eigenvalues).for_each(|(c, lambda)| *c *= (-lambda * time).exp());
    let smooth = basis.synthesize(&spectrum);
    smooth.iter().map(|k| (1.0 / (1.0 + (k.max(0.0) * RADIUS * diagonal).powi(2))) as f32).collect()
}
