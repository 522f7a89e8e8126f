//! The last step onto the template, at full resolution: displacements smoothed by the cotangent Laplacian
//! of the shape.

use crate::bend::pulls;
use crate::laplacian::Laplacian;
use crate::partners::Partners;
use crate::surface::UnitSurface;
use crate::{MatchError, Similarity};
use chladni_task::Task;
use glam::DVec3;

/// Draws the bent shape onto the aligned template, smoothing over shorter and shorter lengths (shares of
/// the diagonal). Parts that the template lacks stay where bending put them.
pub(crate) fn settle(
    shape: &UnitSurface,
    partners: &Partners,
    pose: &Similarity,
    mut bent: Vec<DVec3>,
    task: &Task,
) -> Result<Vec<DVec3>, MatchError> {
    const LENGTHS: [f64; 3] = [0.02, 0.01, 0.006];
    let all: Vec<u32> = (0..bent.len() as u32).collect();
    let laplacian = Laplacian::new(&shape.points, &shape.triangles);
    let stage = task.stage("settling", LENGTHS.len() as u64);
    for length in LENGTHS {
        task.check()?;
        let normals = shape.normals_at(&bent);
        let mut w = vec![0.0; bent.len()];
        let mut b = vec![DVec3::ZERO; bent.len()];
        for pull in pulls(shape, partners, pose, &all, &bent, &normals, 0.03) {
            let v = pull.vertex as usize;
            w[v] = shape.areas[v] * pull.weight;
            b[v] = (pull.to - bent[v]) * w[v];
        }
        // A small weight everywhere keeps loose components in place.
        for v in 0..bent.len() {
            w[v] += 1e-3 * shape.areas[v];
        }
        let moved = laplacian.solve(&w, length * length, &b, vec![DVec3::ZERO; b.len()], 1e-3);
        for (y, d) in bent.iter_mut().zip(&moved) {
            if d.is_finite() {
                *y += *d;
            }
        }
        stage.advance(1);
    }
    Ok(bent)
}
