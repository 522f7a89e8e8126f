//! From two meshes to a correspondence and its report.

use chladni_mesh::TriMesh;
use chladni_mesh::surface::Closest;
use chladni_task::Task;
use glam::DVec3;
use rayon::prelude::*;

use crate::bend::bend;
use crate::crossmap::{CrossMap, crossmap};
use crate::landmarks::{self, Landmark, Pinned};
use crate::partners::{Partners, in_template};
use crate::prealign::{Pose, prealign};
use crate::project::{self, confidence};
use crate::settle::settle;
use crate::surface::UnitSurface;
use crate::unfold::unfold;
use crate::{Correspondence, MatchError, MatchReport, Scaling, Side, same_connectivity};

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
#[serde(default)]
pub struct MatchSettings {
    /// How template points are found.
    pub method: Method,
    /// Pairs that belong together; three or more lead the alignment.
    pub landmarks: Vec<Landmark>,
    /// Seed of all sampling.
    pub seed: u64,
    /// Whether the template's size is fitted to the shape's, or kept, so that a difference in size counts as
    /// a feature.
    pub scaling: Scaling,
}

/// A correspondence and how good it is.
#[derive(Clone, Debug, PartialEq)]
pub struct Match {
    /// For each vertex of the shape a point of the template.
    pub correspondence: Correspondence,
    /// How good it is.
    pub report: MatchReport,
}

/// Matches a shape with a template mesh.
///
/// # Errors
/// Meshes without a surface, landmarks that are not on it, a cancelled task.
pub fn match_shapes(
    shape: &TriMesh,
    template: &TriMesh,
    settings: &MatchSettings,
    task: &Task,
) -> Result<Match, MatchError> {
    let s = UnitSurface::new(shape, Side::Shape)?;
    let t = UnitSurface::new(template, Side::Template)?;
    let pinned = landmarks::pin(&settings.landmarks, &s, &t)?;
    let pairs = landmarks::points(&pinned, &s, &t);
    // In surface coordinates both have a diagonal of 1.
    let sizes = t.diagonal / s.diagonal;
    let scale = (settings.scaling == Scaling::Rigid).then_some(sizes);
    let align = || prealign(&s, &t, &pairs, scale, settings.seed, task);
    let (correspondence, pose, warnings) = match settings.method {
        Method::Same => (same_connectivity(shape, template, settings.scaling)?, None, Vec::new()),
        Method::Icp => {
            let pose = align()?;
            (
                closest_points(shape, &s, template, &Partners::none(&t), &pose, &s.points, None)?,
                Some(pose),
                Vec::new(),
            )
        }
        Method::Fit => {
            let pose = align()?;
            let bent = bend(&s, &t, &pose.similarity, &pinned, settings.seed, task)?;
            let partners = Partners::by_vote(&s, &t, &pose.similarity, &bent);
            let settled = settle(&s, &partners, &pose.similarity, bent, task)?;
            let found =
                closest_points(shape, &s, template, &partners, &pose, &settled, Some((&pinned, task)))?;
            (found, Some(pose), Vec::new())
        }
        Method::Map => {
            let CrossMap { at, confidence, pose, warnings } = crossmap(&s, &t, &pinned, scale, task)?;
            (project::correspondence(shape, &s, template, &t, &at, &confidence, &pose)?, None, warnings)
        }
    };
    let mut report = MatchReport::of(&s, Some(&t), &correspondence, pose.as_ref());
    report.warnings.extend(warnings);
    report.warnings.extend(scale.and_then(unlike_sizes));
    report.warnings.extend(landmarks::doubts(&pairs));
    Ok(Match { correspondence, report })
}

/// The warning about a template that is kept at its own size, `times` that of the shape.
fn unlike_sizes(times: f64) -> Option<String> {
    let (times, than) = if times < 1.0 { (1.0 / times, "smaller") } else { (times, "larger") };
    (times > 3.0).then(|| {
        format!(
            "the template is {times:.1} times {than} than the shape and keeps its size: are both in one unit?"
        )
    })
}

/// The closest point of the aligned template for each fitted vertex; with folds removed as far as possible if
/// `unfolded` is set.
fn closest_points(
    shape_mesh: &TriMesh,
    shape: &UnitSurface,
    template_mesh: &TriMesh,
    partners: &Partners,
    pose: &Pose,
    laid: &[DVec3],
    unfolding: Option<(&[Pinned], &Task)>,
) -> Result<Correspondence, MatchError> {
    let template = partners.template;
    let (laid, looking) = in_template(shape, &pose.similarity, laid);
    let nearest = |((p, normal), of): ((&DVec3, &DVec3), &u32)| {
        partners.nearest(*of, *p, *normal).ok_or(MatchError::NoSurface(Side::Template))
    };
    let mut at = laid
        .par_iter()
        .zip(&looking)
        .zip(&shape.component)
        .map(nearest)
        .collect::<Result<Vec<_>, MatchError>>()?;
    if let Some((pinned, task)) = unfolding {
        let fixed: Vec<u32> = pinned.iter().map(|l| l.shape).collect();
        unfold(shape, partners, &mut at, &fixed, task)?;
    }
    let trust: Vec<f64> = at
        .par_iter()
        .zip(laid.par_iter().zip(&looking))
        .map(|(at, (p, normal))| {
            let distance_squared = DVec3::from_array(at.point).distance_squared(*p);
            confidence(template, &Closest { distance_squared, ..*at }, *normal, pose.similarity.scale)
        })
        .collect();
    project::correspondence(shape_mesh, shape, template_mesh, template, &at, &trust, &pose.similarity)
}
