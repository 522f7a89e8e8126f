//! The named parts of a head, found through two heads whose parts are known: the sample template, matched with it, and the
//! head of the sliders that is most like it.

use chladni_match::{Match, MatchReport, MatchSettings, Scaling, Similarity, match_shapes};
use chladni_mesh::TriMesh;
use chladni_mesh::samples::{
    FitPoint, HEAD_PARTS, fitted_portrait, head_borders, head_part_within, head_parts, sample,
};
use chladni_mesh::surface::vec3::{length, sub};
use chladni_mesh::surface::vertex_areas;
use chladni_task::Task;

use crate::{CaricatureError, Painted};

/// For each vertex of a head the part on which it lies.
#[derive(Clone, Debug)]
pub struct HeadParts {
    /// An index of [`HEAD_PARTS`] for each of the n file vertices.
    pub part: Vec<u8>,
    /// How far to trust it, in [0, 1], n: the match's confidence, times the share of the two heads that name the part,
    /// weighted by how near they are, times the share of the surface on which both name the same.
    pub confidence: Vec<f64>,
    /// How well the shape matches a head.
    pub report: MatchReport,
}

impl HeadParts {
    /// The misfit of heads, scans and statues among them, to the sample template is at most 0.34, that of an animal's head
    /// 0.41; plates, rings and whole bodies have 0.45 and more.
    pub const MOST_MISFIT: f64 = 0.45;

    /// Those of a sample head by its `name`, which is modeled of them: all are sure, and nothing is matched. `None` of
    /// other samples.
    pub fn known(name: &str, shape: &TriMesh) -> Option<Self> {
        let part = head_parts(name, &shape.positions)?;
        let confidence = vec![1.0; part.len()];
        let report = MatchReport { coverage: 1.0, mean_confidence: 1.0, ..MatchReport::default() };
        Some(Self { part, confidence, report })
    }

    /// Matches `shape` with the sample template and goes on as [`HeadParts::of_match`]. If the shape is not a head, the
    /// report has warnings or a large distance, and confidence is low.
    ///
    /// # Errors
    /// A shape that cannot be matched; [`CaricatureError::Cancelled`].
    pub fn of(shape: &TriMesh, task: &Task) -> Result<Self, CaricatureError> {
        let template = sample("template").ok_or_else(|| failed("is missing"))?;
        let found = match_shapes(shape, &template, &MatchSettings::default(), task);
        task.check()?;
        Self::of_match(shape, &found.map_err(failed_match)?)
    }

    /// The parts where the shape is matched with the sample template already. The match says about where each part is; so
    /// the sliders of the sample `portrait` can be fitted, and the two heads vote.
    ///
    /// # Errors
    /// A match that says nothing of where the head is.
    pub fn of_match(shape: &TriMesh, found: &Match) -> Result<Self, CaricatureError> {
        let on = &found.correspondence;
        let of_template = head_borders("template", &on.point).ok_or_else(|| failed("has no parts"))?;
        let areas = vertex_areas(&shape.positions, &shape.triangles);
        let parts = of_template.iter().map(head_part_within);
        let weights: Vec<f64> = parts
            .zip(&areas)
            .zip(&on.confidence)
            .map(|((part, area), trust)| area * trust * counts(part))
            .collect();
        // Of the head alone: a neck with shoulders would shift it.
        let pose = Similarity::fit(&shape.positions, &on.point, Some(&weights), Scaling::Free);
        let pose = pose.map_err(failed_match)?;
        let points = shape.positions.iter().zip(&weights).zip(&of_template);
        let points: Vec<FitPoint> = points
            .map(|((p, weight), borders)| FitPoint { at: pose.apply(*p), weight: *weight, borders: *borders })
            .collect();
        let fitted = fitted_portrait(&points);
        // Distances in units of half a head's height, as the sliders have them.
        let scale = on.similarity.scale;
        let moved = shape.positions.iter().zip(&on.target).map(|(p, q)| length(sub(*p, *q)) / scale);
        let votes = moved.zip(&fitted.distance).zip(of_template.iter().zip(&fitted.borders));
        let votes = votes.map(|((moved, distance), (of_template, of_fitted))| {
            // The nearest point is nearer than that which corresponds.
            voted([(moved, of_template), (2.0 * distance, of_fitted)])
        });
        let (part, share): (Vec<u8>, Vec<f64>) = votes.unzip();
        let agreement = agreement(&of_template, &fitted.borders, &areas);
        let confidence =
            share.iter().zip(&on.confidence).map(|(share, trust)| agreement * share * trust).collect();
        let mut report = found.report.clone();
        if let Some(misfit) = report.misfit.filter(|misfit| *misfit > Self::MOST_MISFIT) {
            report.warnings.push(format!(
                "it hardly looks like a head (misfit {misfit:.2}, heads have less than {}): names of parts may mean \
                 nothing",
                Self::MOST_MISFIT
            ));
        }
        Ok(Self { part, confidence, report })
    }

    /// How many vertices a part of this number has, and the mean of their confidence; `None` where it has none.
    pub fn extent(&self, part: usize) -> (usize, Option<f64>) {
        let own = self.part.iter().zip(&self.confidence).filter(|(p, _)| usize::from(**p) == part);
        let (vertices, sum) = own.fold((0_u32, 0.0), |(n, sum), (_, c)| (n + 1, sum + c));
        (vertices as usize, (vertices > 0).then(|| sum / f64::from(vertices)))
    }

    /// χ01 of the parts called `names`; `operator_vertex` are those of the n file vertices.
    ///
    /// # Errors
    /// A name that is none of [`HEAD_PARTS`]; another shape's vertices.
    pub fn painted(
        &self,
        operator_vertex: &[Option<u32>],
        names: &[String],
    ) -> Result<Painted, CaricatureError> {
        let wanted = names.iter().map(|name| {
            let unknown =
                || CaricatureError::syntax("part", name, format!("must be one of {}", HEAD_PARTS.join(", ")));
            HEAD_PARTS.iter().position(|part| part == name).ok_or_else(unknown)
        });
        let wanted: Vec<usize> = wanted.collect::<Result<_, _>>()?;
        if self.part.len() != operator_vertex.len() {
            let (found, expected) = (self.part.len(), operator_vertex.len());
            return Err(CaricatureError::VertexCount { what: "the parts", found, expected });
        }
        let value = |part: &u8| f32::from(u8::from(wanted.contains(&usize::from(*part))));
        Ok(Painted::of_file(self.part.iter().map(value), operator_vertex))
    }
}

/// How much a vertex on a part counts where the sliders are fitted: features lie on the face, and the neck may go on as
/// shoulders.
fn counts(part: u8) -> f64 {
    match HEAD_PARTS.get(usize::from(part)) {
        Some(&"neck") | None => 0.0,
        Some(&"crown") => 1.0,
        Some(_) => 3.0,
    }
}

/// The part of a vertex, and its share of the votes, from how far the vertex is from two heads and from the borders on each.
///
/// Borders are averaged (Rohlfing & Maurer, "Shape-based averaging", IEEE Transactions on Image Processing, 2007), and a
/// head counts by the inverse square of the distance (locally weighted voting; Artaechevarria, Muñoz-Barrutia &
/// Ortiz-de-Solórzano, "Combination strategies in multi-atlas image segmentation", IEEE Transactions on Medical Imaging,
/// 2009). A vertex that is far from both hardly belongs to a head.
fn voted(heads: [(f64, &[f64; HEAD_PARTS.len()]); 2]) -> (u8, f64) {
    /// Below this distance heads are equally near.
    const NEAR: f64 = 0.008;
    /// One more vote, for none of the parts, is that of a head so far away.
    const FAR: f64 = 0.15;
    let weights = heads.map(|(distance, _)| 1.0 / (distance * distance + NEAR * NEAR));
    let total: f64 = weights.iter().sum();
    let mean = std::array::from_fn(|part| {
        heads.iter().zip(weights).map(|((_, borders), w)| w * borders[part]).sum::<f64>() / total
    });
    let part = head_part_within(&mean);
    let for_it = heads.iter().zip(weights).filter(|((_, borders), _)| head_part_within(borders) == part);
    let votes: f64 = for_it.map(|(_, w)| w).sum();
    (part, votes / (total + 1.0 / (FAR * FAR)))
}

/// The share of the area on which two heads name the same part.
fn agreement(one: &[[f64; HEAD_PARTS.len()]], other: &[[f64; HEAD_PARTS.len()]], areas: &[f64]) -> f64 {
    let pairs = one.iter().zip(other).zip(areas);
    let same = pairs.filter(|((a, b), _)| head_part_within(a) == head_part_within(b));
    same.map(|(_, area)| area).sum::<f64>() / areas.iter().sum::<f64>().max(f64::MIN_POSITIVE)
}

fn failed_match(error: chladni_match::MatchError) -> CaricatureError {
    failed(error.to_string())
}

fn failed(why: impl Into<String>) -> CaricatureError {
    CaricatureError::Template { template: "sample:template".into(), why: why.into() }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Intersection over union of each part, over vertices.
    fn overlaps(found: &[u8], known: &[u8]) -> [f64; HEAD_PARTS.len()] {
        std::array::from_fn(|part| {
            let pairs =
                || found.iter().zip(known).map(|(a, b)| (usize::from(*a) == part, usize::from(*b) == part));
            let both = pairs().filter(|(a, b)| *a && *b).count();
            both as f64 / pairs().filter(|(a, b)| *a || *b).count().max(1) as f64
        })
    }

    #[test]
    fn the_parts_of_a_head_of_character_are_found() {
        let head = sample("head").unwrap();
        let known = head_parts("head", &head.positions).unwrap();
        assert_eq!(HeadParts::known("head", &head).unwrap().part, known);
        assert!(HeadParts::known("octopus", &head).is_none());
        let found = HeadParts::of(&head, &Task::new()).unwrap();
        let overlaps = overlaps(&found.part, &known);
        let mean = overlaps.iter().sum::<f64>() / overlaps.len() as f64;
        assert!(mean > 0.85 && overlaps.iter().all(|o| *o > 0.75), "{mean}: {overlaps:?}");
        println!("mean {mean:.3}: {overlaps:.3?}");
    }

    #[test]
    fn a_childs_small_brow_and_jaw_are_found_and_an_octopus_has_no_sure_parts() {
        let name = "portrait?age=-1.00";
        let child = sample(name).unwrap();
        let known = head_parts(name, &child.positions).unwrap();
        let found = HeadParts::of(&child, &Task::new()).unwrap();
        let overlaps = overlaps(&found.part, &known);
        assert!(overlaps.iter().all(|o| *o > 0.75), "{overlaps:?}");
        let sure = |found: &HeadParts| found.confidence.iter().sum::<f64>() / found.confidence.len() as f64;
        let octopus = HeadParts::of(&sample("octopus").unwrap(), &Task::new()).unwrap();
        assert!(sure(&found) > 0.8 && sure(&octopus) < 0.3, "{} {}", sure(&found), sure(&octopus));
    }

    #[test]
    fn two_heads_vote_by_their_nearness() {
        let borders = |part: usize, by: f64| std::array::from_fn(|i| if i == part { -by } else { by });
        let (nose, brow) = (borders(0, 0.1), borders(1, 0.1));
        let (part, sure) = voted([(0.01, &nose), (0.1, &brow)]);
        assert!(part == 0 && sure > 0.9, "{part} {sure}");
        // A tie is unsure, and what is far from both more so, even where they agree.
        assert!(voted([(0.01, &nose), (0.01, &brow)]).1 < 0.51);
        let far = voted([(0.3, &nose), (0.3, &nose)]).1;
        assert!(far < 0.4, "{far}");
        assert!((agreement(&[nose, nose], &[nose, brow], &[3.0, 1.0]) - 0.75).abs() < 1e-12);
    }

    #[test]
    fn a_part_is_as_sure_as_its_vertices_are_on_average() {
        let report = HeadParts::of(&sample("head").unwrap(), &Task::new()).unwrap().report;
        let found = HeadParts { part: vec![2, 0, 2, 2], confidence: vec![0.5, 0.1, 1.0, 0.0], report };
        assert_eq!((found.extent(2), found.extent(0)), ((3, Some(0.5)), (1, Some(0.1))));
        assert_eq!(found.extent(1), (0, None));
    }

    #[test]
    fn what_is_no_head_is_said_to_be_none() {
        let doubts = |mesh: &TriMesh| {
            let found = HeadParts::of(mesh, &Task::new()).unwrap();
            found.report.warnings.iter().any(|warning| warning.contains("hardly looks like a head"))
        };
        let head = sample("head").unwrap();
        // Mirrored with its winding kept: its faces look inward.
        let inward = TriMesh {
            positions: head.positions.iter().map(|p| [-p[0], p[1], p[2]]).collect(),
            ..head.clone()
        };
        assert!(!doubts(&head) && !doubts(&inward));
        assert!(doubts(&sample("ring").unwrap()));
    }
}
