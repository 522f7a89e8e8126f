//! Matches two meshes: computes a correspondence and its report.

use chladni_mesh::TriMesh;
use chladni_mesh::surface::Closest;
use chladni_task::Task;
use glam::DVec3;
use rayon::prelude::*;

use crate::bend::bend;
use crate::crossmap::{CrossMap, crossmap};
use crate::landmarks::{self, Landmark, Pinned};
use crate::partners::{Partners, in_template};
use crate::prealign::prealign;
use crate::project::{self, confidence};
use crate::settle::settle;
use crate::similarity::fit_pairs_at;
use crate::surface::UnitSurface;
use crate::unfold::unfold;
use crate::{Correspondence, MatchError, MatchReport, Scaling, Side, Similarity, same_connectivity};

/// How template points are found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Method {
    /// Vertex i ↔ vertex i.
    Same,
    /// The closest point after the similarity that fits best.
    Icp,
    /// The closest point after the shape has been bent onto the template.
    #[default]
    Fit,
    /// A map through a sphere, determined by three or more landmarks: for shapes that are too different for
    /// closest points.
    Map,
}

/// The choice of what to match, and how.
#[derive(Clone, Debug, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
#[serde(default)]
pub struct MatchSettings {
    /// How template points are found.
    pub method: Method,
    /// Pairs of vertices that belong together; three or more determine the alignment.
    pub landmarks: Vec<Landmark>,
    /// Seed of all sampling.
    pub seed: u64,
    /// Whether the size of the template is fitted to that of the shape, or kept. If it is kept, a
    /// difference in size counts as a feature.
    pub scaling: Scaling,
}

/// A correspondence and its quality.
#[derive(Clone, Debug, PartialEq)]
pub struct Match {
    /// For each vertex of the shape, a point of the template.
    pub correspondence: Correspondence,
    /// How good the correspondence is.
    pub report: MatchReport,
}

/// Matches a shape with a template mesh.
///
/// # Errors
/// A mesh without a surface, landmarks that are not on a surface, a method that fails on these meshes, or a
/// cancelled task.
pub fn match_shapes(
    shape: &TriMesh,
    template: &TriMesh,
    settings: &MatchSettings,
    task: &Task,
) -> Result<Match, MatchError> {
    // Vertices that belong together one by one do so whichever way the faces look.
    let surface = |mesh: &TriMesh, side| match settings.method {
        Method::Same => UnitSurface::new(mesh, side),
        _ => UnitSurface::facing_outward(mesh, side),
    };
    let (s, t) = (surface(shape, Side::Shape)?, surface(template, Side::Template)?);
    let pinned = landmarks::pin(&settings.landmarks, &s, &t)?;
    let pairs = landmarks::points(&pinned, &s, &t);
    // In surface coordinates, both diagonals are 1.
    let sizes = t.diagonal / s.diagonal;
    let scale = (settings.scaling == Scaling::Rigid).then_some(sizes);
    let align = || prealign(&s, &t, &pairs, scale, settings.seed, task);
    let (correspondence, pose, residual, warnings) = match settings.method {
        Method::Same => (same_connectivity(shape, template, settings.scaling)?, None, Vec::new(), Vec::new()),
        Method::Icp => {
            let pose = align()?;
            let Landed { at, trust, residual } =
                closest_points(&s, &Partners::none(&t), &pose.similarity, &s.points, None)?;
            let found = project::correspondence(shape, &s, template, &t, &at, &trust, &pose.similarity)?;
            (found, Some(pose), residual, Vec::new())
        }
        Method::Fit => {
            let pose = align()?;
            let (Landed { at, trust, residual }, similarity) =
                fit(&s, &t, &pinned, pose.similarity, (scale, settings.seed), task)?;
            let found = project::correspondence(shape, &s, template, &t, &at, &trust, &similarity)?;
            (found, Some(pose), residual, Vec::new())
        }
        Method::Map => {
            let CrossMap { at, confidence, pose, warnings } = crossmap(&s, &t, &pinned, scale, task)?;
            let found = project::correspondence(shape, &s, template, &t, &at, &confidence, &pose)?;
            (found, None, Vec::new(), warnings)
        }
    };
    let mut report = MatchReport::of(&s, Some(&t), &correspondence, pose.as_ref(), residual);
    // Without bending, points crowd wherever two shapes differ; what the other methods stretch, they are meant to.
    if settings.method == Method::Fit {
        let squeezed = report.squeezed();
        report.warnings.extend(squeezed);
    }
    report.warnings.extend(turned_faces(&s, Side::Shape));
    report.warnings.extend(turned_faces(&t, Side::Template));
    report.warnings.extend(warnings);
    report.warnings.extend(scale.and_then(unlike_sizes));
    report.warnings.extend(landmarks::doubts(&pairs));
    Ok(Match { correspondence, report })
}

/// The warning about faces that were turned.
fn turned_faces(surface: &UnitSurface, side: Side) -> Option<String> {
    let (turned, all) = (surface.turned.iter().filter(|turned| **turned).count(), surface.turned.len());
    (turned > 0).then(|| {
        format!(
            "{turned} of {all} faces of the {side} look inward or against their neighbors: they were turned for the match"
        )
    })
}

/// The warning about a template that keeps its own size, which is `times` that of the shape.
fn unlike_sizes(times: f64) -> Option<String> {
    let (times, than) = if times < 1.0 { (1.0 / times, "smaller") } else { (times, "larger") };
    (times > 3.0).then(|| {
        format!(
            "the template is {times:.1} times {than} than the shape and keeps its size: are both in one unit?"
        )
    })
}

/// For each vertex of the shape's surface its point on the template.
struct Landed {
    at: Vec<Closest>,
    /// The confidence in each point, in [0, 1].
    trust: Vec<f64>,
    /// The distance to each point that bending has left, in shape diagonals.
    residual: Vec<f64>,
}

/// Bends the shape onto the template, starting from `pose`.
///
/// The alignment by closest points suppresses differences: shapes that differ much end up with one side on
/// top of each other and all of the difference on the other side. The pairs found by bending give a better
/// similarity. If it differs from the one that bending started from, the shape is bent again from there. The similarity
/// between the two surfaces is the last one.
fn fit(
    shape: &UnitSurface,
    template: &UnitSurface,
    pinned: &[Pinned],
    mut pose: Similarity,
    (scale, seed): (Option<f64>, u64),
    task: &Task,
) -> Result<(Landed, Similarity), MatchError> {
    /// The rounds at most, as their stages are called: bending takes most of the time, and each has a bar of its own.
    const ROUNDS: [&str; 3] = ["bending", "bending again", "bending once more"];
    /// A change of the similarity that moves the template by less than this share of the diagonal needs no
    /// further round.
    const STILL: f64 = 0.01;
    let mut round = 0;
    loop {
        let bent = bend(shape, template, &pose, pinned, seed, (ROUNDS[round], task))?;
        let partners = Partners::by_vote(shape, template, &pose, &bent);
        let settled = settle(shape, &partners, &pose, bent, task)?;
        let landed = closest_points(shape, &partners, &pose, &settled, Some((pinned, task)))?;
        let (again, moved) = between_pairs(shape, template, pinned, &landed, scale, &pose);
        if moved < STILL || round + 1 == ROUNDS.len() {
            return Ok((landed, again));
        }
        (pose, round) = (again, round + 1);
    }
}

/// The similarity between the pairs, weighted by area and confidence, where landmarks together get half the
/// weight of all others; and how far it moves the template from `pose`. It is `pose` itself if too few
/// pairs are trusted to determine a similarity.
fn between_pairs(
    shape: &UnitSurface,
    template: &UnitSurface,
    pinned: &[Pinned],
    Landed { at, trust, .. }: &Landed,
    scale: Option<f64>,
    pose: &Similarity,
) -> (Similarity, f64) {
    let place = |at: &Closest| DVec3::from_array(at.point);
    let weights = || shape.areas.iter().zip(trust).map(|(area, trust)| area * trust);
    let total: f64 = weights().sum();
    let pairs = at.iter().zip(&shape.points).zip(weights()).map(|((a, b), w)| (place(a), *b, w));
    let share = 0.5 * total / pinned.len().max(1) as f64;
    let landmarks =
        pinned.iter().map(|l| (template.points[l.template as usize], shape.points[l.shape as usize], share));
    let Ok(again) = fit_pairs_at(pairs.clone().chain(landmarks), scale) else { return (*pose, 0.0) };
    let squares: f64 = pairs.map(|(a, _, w)| w * again.at(a).distance_squared(pose.at(a))).sum();
    (again, (squares / total).sqrt())
}

/// For each fitted vertex, the closest point of the aligned template. If `unfolding` is set, folds are removed as far as
/// possible.
fn closest_points(
    shape: &UnitSurface,
    partners: &Partners,
    pose: &Similarity,
    laid: &[DVec3],
    unfolding: Option<(&[Pinned], &Task)>,
) -> Result<Landed, MatchError> {
    let template = partners.template;
    let (laid, looking) = in_template(shape, pose, laid);
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
    let (trust, residual) = at
        .par_iter()
        .zip(laid.par_iter().zip(&looking))
        .map(|(at, (p, normal))| {
            let distance_squared = DVec3::from_array(at.point).distance_squared(*p);
            let trust = confidence(template, &Closest { distance_squared, ..*at }, *normal, pose.scale);
            (trust, distance_squared.sqrt() * pose.scale)
        })
        .unzip();
    Ok(Landed { at, trust, residual })
}
