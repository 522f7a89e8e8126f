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
        let bend = f64::from(patch.steepness(corners.map(|v| normals[v as usize]))) * patch.area / 3.0;
        // Of a triangle that is too small for single precision the gradient may be infinite.
        if bend.is_finite() {
            corners.iter().for_each(|&v| bends[v as usize] += bend);
        }
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

#[cfg(test)]
mod tests {
    use chladni_harmonics::BasisSettings;
    use chladni_mesh::{TriMesh, samples};
    use chladni_task::Task;

    use super::*;
    use crate::dancer::box_diagonal;
    use crate::probes::rest_normals;

    fn mask(mesh: &TriMesh, k: usize) -> (Body, Arc<[f32]>) {
        let body = Body::build(mesh, &BasisSettings::new(k), &Task::new()).unwrap();
        let mask = swelling(&body, &rest_normals(&body), box_diagonal(&body.positions));
        (body, mask)
    }

    #[test]
    fn a_plane_moves_wholly_and_a_ball_as_far_as_its_radius_says() {
        let (_, plate) = mask(&samples::sample("plate").unwrap(), 32);
        assert!(plate.iter().all(|x| *x == 1.0));
        // ‖∇n‖ of a ball is √2 over its radius, which is its diagonal over 2 √3.
        let wanted = 1.0 / (1.0 + (2.0 * 6f64.sqrt() * RADIUS).powi(2)) as f32;
        for fineness in [3, 4] {
            let (_, ball) = mask(&samples::icosphere(fineness), 32);
            assert!(ball.iter().all(|x| (x / wanted - 1.0).abs() < 0.03), "{wanted}, {ball:?}");
        }
    }

    #[test]
    fn thin_arms_move_less_than_the_head_with_any_number_of_harmonics() {
        for k in [24, 96] {
            let (body, mask) = mask(&samples::sample("octopus").unwrap(), k);
            let highest =
                (0..mask.len()).max_by(|&a, &b| body.positions[a][1].total_cmp(&body.positions[b][1]));
            let widest =
                (0..mask.len()).max_by(|&a, &b| body.positions[a][0].total_cmp(&body.positions[b][0]));
            let [head, arm] = [highest, widest].map(|v| mask[v.unwrap()]);
            assert!(mask.iter().all(|x| *x > 0.0 && *x <= 1.0) && head > 3.0 * arm, "{k}: {head}, {arm}");
        }
    }
}
