//! Projects positions near a template onto its surface.

use chladni_mesh::TriMesh;
use chladni_mesh::surface::{Closest, SurfacePoint};
use glam::DVec3;
use rayon::prelude::*;

use crate::surface::UnitSurface;
use crate::{Correspondence, MatchError, Side, Similarity};

/// Residual, as a share of the shape's diagonal, at which the confidence has fallen to 1/e.
pub(crate) const CONFIDENCE_REACH: f64 = 0.05;

/// The nearest point of the template whose normal points the same way as `normal`; the nearest point of all
/// if there is none close by.
///
/// The opposite side of a thin sheet (an ear, a lip) may be nearer than the right side. If the nearest
/// point faces away, the query is therefore moved outward along its own normal, once.
pub(crate) fn nearest_facing(template: &UnitSurface, position: DVec3, normal: DVec3) -> Option<Closest> {
    let at = template.closest(position, f64::INFINITY)?;
    if template.smooth_normal(&at.on).dot(normal) > 0.0 {
        return Some(at);
    }
    let reach = 2.0 * at.distance_squared.sqrt() + 0.01;
    let better = template.closest(position + normal * reach, 1.5 * reach).filter(|other| {
        template.smooth_normal(&other.on).dot(normal) > 0.3
            && DVec3::from_array(other.point).distance(position) < 2.0 * reach
    });
    Some(better.map_or(at, |other| Closest {
        distance_squared: DVec3::from_array(other.point).distance_squared(position),
        ..other
    }))
}

/// The confidence in a point, in [0, 1]: high if it is near, faces the same way, and does not lie at an
/// open edge.
pub(crate) fn confidence(template: &UnitSurface, at: &Closest, normal: DVec3, scale: f64) -> f64 {
    let distance = at.distance_squared.sqrt() * scale;
    let near = (-(distance / CONFIDENCE_REACH).powi(2)).exp();
    let facing = template.smooth_normal(&at.on).dot(normal).max(0.0);
    let edge = if template.on_boundary(&at.on) { 0.25 } else { 1.0 };
    // Rounding may push the product of two unit normals above 1.
    (near * facing * edge).min(1.0)
}

/// Makes a correspondence from one template point per welded vertex.
///
/// Vertices that no triangle uses get the closest point of the aligned template.
pub(crate) fn correspondence(
    shape_mesh: &TriMesh,
    shape: &UnitSurface,
    template_mesh: &TriMesh,
    template: &UnitSurface,
    at: &[Closest],
    confidence: &[f64],
    pose: &Similarity,
) -> Result<Correspondence, MatchError> {
    let similarity = to_file(shape, template, pose);
    let back = pose.inverse();
    let (on_template, confidence) = shape_mesh
        .positions
        .par_iter()
        .zip(&shape.point_of_vertex)
        .map(|(p, used)| {
            let (at, confidence) = match used {
                Some(v) => (at[*v as usize].on, confidence[*v as usize]),
                None => {
                    let at = template
                        .closest(back.at(shape.in_frame(*p)), f64::INFINITY)
                        .ok_or(MatchError::NoSurface(Side::Template))?;
                    (at.on, 0.0)
                }
            };
            Ok((template.in_file(&at), confidence))
        })
        .collect::<Result<(Vec<SurfacePoint>, Vec<f64>), MatchError>>()?;
    Ok(Correspondence::on_mesh(template_mesh, on_template, confidence, similarity))
}

/// Converts a pose between surface coordinates to file coordinates.
pub(crate) fn to_file(shape: &UnitSurface, template: &UnitSurface, pose: &Similarity) -> Similarity {
    let enter =
        Similarity::new(1.0 / template.diagonal, glam::DMat3::IDENTITY, -template.center / template.diagonal);
    let leave = Similarity::new(shape.diagonal, glam::DMat3::IDENTITY, shape.center);
    enter.then(pose).then(&leave)
}
