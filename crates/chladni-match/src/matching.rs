//! The way from two meshes to a correspondence and its report.

use chladni_mesh::TriMesh;
use chladni_task::Task;
use glam::DVec3;
use rayon::prelude::*;

use crate::bend::{bend, vertex_normals};
use crate::crossmap::{CrossMap, crossmap};
use crate::landmarks::{self, Landmark};
use crate::prealign::{Pose, prealign};
use crate::project::{self, confidence, nearest_facing};
use crate::settle::settle;
use crate::surface::Surface;
use crate::{Correspondence, MatchError, Report, Side, same_connectivity};

/// How template points are found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Method {
    /// Vertex i ↔ vertex i.
    Same,
    /// The closest point after the best similarity.
    Icp,
    /// The closest point after the shape was bent onto the template.
    #[default]
    Fit,
    /// A map through a sphere, led by three or more landmarks: for shapes too different for
    /// closest points.
    Map,
}

/// What is asked for.
#[derive(Clone, Debug, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
pub struct Settings {
    /// How template points are found.
    pub method: Method,
    /// Pairs that belong together; three or more lead the alignment.
    pub landmarks: Vec<Landmark>,
    /// Seed of all sampling.
    pub seed: u64,
}

/// A correspondence and how good it is.
#[derive(Clone, Debug, PartialEq)]
pub struct Match {
    /// For each vertex of the shape a point of the template.
    pub correspondence: Correspondence,
    /// How good it is.
    pub report: Report,
}

/// Matches a shape with a template mesh.
///
/// # Errors
/// Meshes without a surface, landmarks that are not on it, a cancelled task.
pub fn match_shapes(
    shape: &TriMesh,
    template: &TriMesh,
    settings: &Settings,
    task: &Task,
) -> Result<Match, MatchError> {
    let s = Surface::new(shape, Side::Shape)?;
    let t = Surface::new(template, Side::Template)?;
    let pinned = landmarks::pin(&settings.landmarks, &s, &t)?;
    let pairs = landmarks::points(&pinned, &s, &t);
    let align = || prealign(&s, &t, &pairs, settings.seed, task);
    let (correspondence, pose, warnings) = match settings.method {
        Method::Same => (same_connectivity(shape, template)?, None, Vec::new()),
        Method::Icp => {
            let pose = align()?;
            (closest_points(shape, &s, template, &t, &pose, &s.points)?, Some(pose), Vec::new())
        }
        Method::Fit => {
            let pose = align()?;
            let bent = bend(&s, &t, &pose.similarity, &pinned, settings.seed, task)?;
            let settled = settle(&s, &t, &pose.similarity, bent, task)?;
            (closest_points(shape, &s, template, &t, &pose, &settled)?, Some(pose), Vec::new())
        }
        Method::Map => {
            let CrossMap { at, confidence, pose, warnings } = crossmap(&s, &t, &pinned, task)?;
            (project::correspondence(shape, &s, template, &t, &at, &confidence, &pose)?, None, warnings)
        }
    };
    let mut report = Report::of(&s, Some(&t), &correspondence, pose.as_ref());
    report.warnings.extend(warnings);
    report.warnings.extend(landmarks::doubts(&pairs));
    Ok(Match { correspondence, report })
}

/// The closest point of the aligned template for each vertex, seen from where it was laid.
fn closest_points(
    shape_mesh: &TriMesh,
    shape: &Surface,
    template_mesh: &TriMesh,
    template: &Surface,
    pose: &Pose,
    laid: &[DVec3],
) -> Result<Correspondence, MatchError> {
    let back = pose.similarity.inverse();
    let turn = back.rotation_matrix();
    let (at, trust): (Vec<_>, Vec<_>) = laid
        .par_iter()
        .zip(vertex_normals(laid, &shape.triangles))
        .map(|(p, n)| {
            let normal = turn * n;
            let at =
                nearest_facing(template, back.at(*p), normal).ok_or(MatchError::NoSurface(Side::Template))?;
            Ok((at, confidence(template, &at, normal, pose.similarity.scale)))
        })
        .collect::<Result<Vec<_>, MatchError>>()?
        .into_iter()
        .unzip();
    project::correspondence(shape_mesh, shape, template_mesh, template, &at, &trust, &pose.similarity)
}
