//! The quality of a correspondence.

use chladni_mesh::TriMesh;
use glam::DVec3;

use crate::prealign::Pose;
use crate::surface::UnitSurface;
use crate::unfold::turned_over;
use crate::{Correspondence, MatchError, Side};

/// Measures of the quality of a correspondence. Distances are shares of the diagonal of the shape's
/// bounding box.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct MatchReport {
    /// Median distance between the aligned template and the shape's vertices, after the similarity and
    /// before any bending: a measure of how different the two are.
    pub median_distance: f64,
    /// The distance that 5 % of the vertices exceed.
    pub p95_distance: f64,
    /// Median distance that is left between the shape's vertices and their points on the aligned template, after the shape
    /// was bent onto it ([`Method::Fit`](crate::Method::Fit)) or without bending ([`Method::Icp`](crate::Method::Icp)): how
    /// close it came. `None` if the method looks for no closest points.
    pub residual_median: Option<f64>,
    /// The remaining distance that 5 % of the vertices exceed; `None` like `residual_median`.
    pub residual_p95: Option<f64>,
    /// Share of the shape's area whose confidence is at least ½.
    pub coverage: f64,
    /// Number of triangles of the shape whose image on the template is turned over, without those that the shape itself
    /// folds over.
    pub flipped_triangles: usize,
    /// Number of triangles of the shape that have a normal to compare.
    pub triangles: usize,
    /// Median over the triangles of the largest singular value of their maps divided by the smallest: 1 for a similarity,
    /// larger the more they are stretched.
    pub stretch: f64,
    /// Number of triangles of the shape for which that ratio is above 5.
    pub strongly_stretched: usize,
    /// Area-weighted mean confidence.
    pub mean_confidence: f64,
    /// Whether a clearly different pose fits nearly as well.
    pub near_tie: bool,
    /// Misfit of the best pose, in [0, 1]; `None` if no pose was searched.
    pub misfit: Option<f64>,
    /// Misfit of the best clearly different pose; `None` if there is none.
    pub runner_up_misfit: Option<f64>,
    /// Problems that the user should know of, one sentence each.
    pub warnings: Vec<String>,
}

/// The [warning](MatchReport::warnings) of a [near tie](MatchReport::near_tie).
pub const NEAR_TIE: &str =
    "another pose of the template fits nearly as well: check that it is not turned round";

/// A near tie: the runner-up's misfit exceeds the best one by less than this share of itself.
const TIE: f64 = 0.1;
/// Also a near tie: the runner-up fits this well. Which of two perfect fits is better is chance.
const PERFECT: f64 = 0.003;
/// σ_max/σ_min above which a triangle is strongly stretched.
const STRONG: f64 = 5.0;
/// The share of strongly stretched triangles above which the template is taken to lack something. Of heads on heads at
/// most 3.1 % are, of busts on heads, whose chest is squeezed onto the neck, more than 6 %.
const SQUEEZED: f64 = 0.05;

impl MatchReport {
    /// The report on a correspondence that was made without a template mesh.
    ///
    /// # Errors
    /// A shape without a surface, or a correspondence with another number of vertices.
    pub fn without_template(shape: &TriMesh, found: &Correspondence) -> Result<Self, MatchError> {
        if shape.positions.len() != found.vertices() {
            return Err(MatchError::LengthsDiffer {
                what: "vertices of the shape and of the correspondence",
                left: shape.positions.len(),
                right: found.vertices(),
            });
        }
        Ok(Self::of(&UnitSurface::new(shape, Side::Shape)?, None, found, None, Vec::new()))
    }

    /// `residual` is the distance that is left at each point of the surface, in shape diagonals; it may be empty.
    pub(crate) fn of(
        shape: &UnitSurface,
        template: Option<&UnitSurface>,
        found: &Correspondence,
        pose: Option<&Pose>,
        residual: Vec<f64>,
    ) -> Self {
        let mut target = vec![DVec3::ZERO; shape.points.len()];
        let mut trust = vec![0.0; shape.points.len()];
        for (v, point) in shape.point_of_vertex.iter().enumerate() {
            if let Some(p) = point {
                target[*p as usize] = shape.in_frame(found.target[v]);
                trust[*p as usize] = found.confidence[v];
            }
        }
        let distance = target.iter().zip(&shape.points).map(|(t, p)| t.distance(*p)).collect();
        let (median_distance, p95_distance) = median_and_p95(distance).unwrap_or_default();
        let (residual_median, residual_p95) = median_and_p95(residual).unzip();
        // The sum of nothing is -0, which would be printed.
        let covered =
            shape.areas.iter().zip(&trust).filter(|(_, c)| **c >= 0.5).map(|(a, _)| a).sum::<f64>() + 0.0;
        let mean_confidence = shape.areas.iter().zip(&trust).map(|(a, c)| a * c).sum::<f64>() / shape.area();
        let distortion = Distortion::of(shape, template, found, &target);
        let near_tie = pose.is_some_and(|p| {
            p.runner_up.is_some_and(|second| second <= PERFECT || second - p.misfit <= TIE * second)
        });
        let mut report = Self {
            median_distance,
            p95_distance,
            residual_median,
            residual_p95,
            coverage: covered / shape.area(),
            flipped_triangles: distortion.flipped,
            triangles: shape.triangles.len(),
            stretch: distortion.stretch,
            strongly_stretched: distortion.strongly_stretched,
            mean_confidence,
            near_tie,
            misfit: pose.map(|p| p.misfit),
            runner_up_misfit: pose.and_then(|p| p.runner_up),
            warnings: Vec::new(),
        };
        report.warn();
        report
    }

    /// The warning where bending squeezed a part of the shape that the template does not have.
    pub(crate) fn squeezed(&self) -> Option<String> {
        // Of few triangles a single one would be a large share.
        const ENOUGH: usize = 1000;
        let Self { strongly_stretched, triangles, .. } = self;
        let many = *strongly_stretched as f64 > SQUEEZED * *triangles as f64;
        (many && *triangles >= ENOUGH).then(|| {
            format!(
                "{strongly_stretched} of {triangles} triangles are stretched more than fivefold on the template: it may \
                 lack a part of the shape, such as a bust"
            )
        })
    }

    fn warn(&mut self) {
        if self.near_tie {
            self.warnings.push(NEAR_TIE.into());
        }
        if self.coverage < 0.5 {
            self.warnings.push(format!(
                "only {:.0} % of the shape has a trustworthy point on the template",
                100.0 * self.coverage
            ));
        }
        if self.flipped_triangles as f64 > 0.05 * self.triangles as f64 {
            self.warnings.push(format!(
                "{} of {} triangles are turned over on the template",
                self.flipped_triangles, self.triangles
            ));
        }
    }
}

/// The values that half and 5 % of all exceed; `None` if there are none.
fn median_and_p95(mut values: Vec<f64>) -> Option<(f64, f64)> {
    values.sort_by(f64::total_cmp);
    let last = values.len().checked_sub(1)?;
    let at = |share: f64| values[(last as f64 * share).round() as usize];
    Some((at(0.5), at(0.95)))
}

struct Distortion {
    flipped: usize,
    stretch: f64,
    strongly_stretched: usize,
}

impl Distortion {
    /// Compares each triangle of the shape with its image.
    fn of(
        shape: &UnitSurface,
        template: Option<&UnitSurface>,
        found: &Correspondence,
        target: &[DVec3],
    ) -> Self {
        let turn = found.similarity.rotation_matrix();
        // The template's smooth normal at each welded vertex, in the shape's frame.
        let mut facing = vec![None; shape.points.len()];
        if let (Some(on), Some(template)) = (&found.on_template, template) {
            let mut surface_triangle = std::collections::HashMap::new();
            for (i, t) in (0_u32..).zip(&template.file_triangle) {
                surface_triangle.insert(*t, i);
            }
            for (v, point) in shape.point_of_vertex.iter().enumerate() {
                if let (Some(p), Some(&t)) = (point, surface_triangle.get(&on[v].triangle)) {
                    let at = template.of_file(t, on[v].weights);
                    facing[*p as usize] = Some(turn * template.smooth_normal(&at));
                }
            }
        }
        let mut flipped = 0;
        let mut ratios = Vec::with_capacity(shape.triangles.len());
        for (t, corners) in shape.triangles.iter().enumerate() {
            let [a, b, c] = corners.map(|v| shape.points[v as usize]);
            let [x, y, z] = corners.map(|v| target[v as usize]);
            let up: DVec3 = corners.iter().filter_map(|v| facing[*v as usize]).sum();
            flipped += usize::from(if up == DVec3::ZERO {
                turned_over([x, y, z], shape.triangle_normals[t])
            } else {
                turned_over([x, y, z], up) && !shape.is_turned_over(t)
            });
            ratios.push(stretch([a, b, c], [x, y, z]));
        }
        ratios.sort_by(f64::total_cmp);
        let strongly_stretched = ratios.len() - ratios.partition_point(|ratio| *ratio <= STRONG);
        Self { flipped, stretch: ratios[ratios.len() / 2], strongly_stretched }
    }
}

/// σ_max/σ_min of the linear map between two triangles, at most 1e6.
pub(crate) fn stretch([a, b, c]: [DVec3; 3], [x, y, z]: [DVec3; 3]) -> f64 {
    let e1 = b - a;
    let length = e1.length();
    let u = e1 / length;
    let e2 = c - a;
    let along = e2.dot(u);
    let up = (e2 - u * along).length();
    // Columns of the Jacobian along u and across it.
    let j1 = (y - x) / length;
    let j2 = ((z - x) - j1 * along) / up;
    let (p, q, r) = (j1.length_squared(), j1.dot(j2), j2.length_squared());
    let mean = 0.5 * (p + r);
    let spread = (0.25 * (p - r).powi(2) + q * q).sqrt();
    let ratio = ((mean + spread) / (mean - spread).max(0.0)).sqrt();
    if ratio.is_finite() { ratio.min(1e6) } else { 1e6 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_template_that_lacks_a_part_is_warned_of() {
        let of = |strongly_stretched, triangles| {
            MatchReport { strongly_stretched, triangles, ..MatchReport::default() }.squeezed()
        };
        // A bust on the template, which ends at the neck; then two heads on it.
        let warning = of(1482, 16_719).unwrap();
        assert!(warning.starts_with("1482 of 16719 triangles are stretched"), "{warning}");
        assert_eq!([of(6, 100_224), of(189, 10_540), of(1, 12), of(0, 0)], [None, None, None, None]);
    }
}
