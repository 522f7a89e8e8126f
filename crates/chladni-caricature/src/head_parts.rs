//! The named parts of a head, found through a match with the sample template.

use chladni_match::{Match, MatchReport, MatchSettings, match_shapes};
use chladni_mesh::TriMesh;
use chladni_mesh::samples::{HEAD_PARTS, head_parts, sample};
use chladni_task::Task;

use crate::{CaricatureError, Painted};

/// For each vertex of a head the part on which it lies.
#[derive(Clone, Debug)]
pub struct HeadParts {
    /// An index of [`HEAD_PARTS`] for each of the n file vertices.
    pub part: Vec<u8>,
    /// How far to trust it, in [0, 1], n: the match's confidence.
    pub confidence: Vec<f64>,
    /// How well the shape matches a head.
    pub report: MatchReport,
}

/// The misfit of heads, scans and statues among them, to the sample template is at most 0.34, that of an animal's head
/// 0.41; plates, rings, whole bodies, and heads whose faces look inward have 0.45 and more.
const NO_HEAD: f64 = 0.45;

impl HeadParts {
    /// Matches `shape` with the sample template, whose parts are known, and carries them over: each vertex
    /// takes the part of most corners of the triangle that it is matched with. If the shape is not a head,
    /// the report has warnings or a large distance.
    ///
    /// # Errors
    /// A shape that cannot be matched; [`CaricatureError::Cancelled`].
    pub fn of(shape: &TriMesh, task: &Task) -> Result<Self, CaricatureError> {
        let template = sample("template").ok_or_else(|| failed("is missing"))?;
        let found = match_shapes(shape, &template, &MatchSettings::default(), task);
        task.check()?;
        Self::of_match(&found.map_err(|error| failed(error.to_string()))?, &template)
    }

    /// The same where the shape is matched with `template`, the sample template, already.
    ///
    /// # Errors
    /// A match without triangles.
    pub fn of_match(found: &Match, template: &TriMesh) -> Result<Self, CaricatureError> {
        let known = head_parts("template", template).ok_or_else(|| failed("has no parts"))?;
        let on = found.correspondence.on_template.as_ref().ok_or_else(|| failed("has no triangles"))?;
        let part = on.iter().map(|on| {
            let corners = template.triangles.get(on.triangle as usize).copied().unwrap_or_default();
            let mut votes = [0.0; HEAD_PARTS.len()];
            for (v, w) in corners.iter().zip(on.weights) {
                if let Some(vote) = known.get(*v as usize).and_then(|part| votes.get_mut(usize::from(*part)))
                {
                    *vote += w;
                }
            }
            (0..votes.len()).max_by(|a, b| votes[*a].total_cmp(&votes[*b])).unwrap_or(0) as u8
        });
        let (part, confidence) = (part.collect(), found.correspondence.confidence.clone());
        let mut report = found.report.clone();
        if let Some(misfit) = report.misfit.filter(|misfit| *misfit > NO_HEAD) {
            report.warnings.push(format!(
                "it hardly looks like a head whose faces look outward (misfit {misfit:.2}, heads have less than {NO_HEAD}): \
                 names of parts may mean nothing"
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
        let known = head_parts("head", &head).unwrap();
        let found = HeadParts::of(&head, &Task::new()).unwrap();
        let overlaps = overlaps(&found.part, &known);
        let mean = overlaps.iter().sum::<f64>() / overlaps.len() as f64;
        assert!(mean > 0.8 && overlaps.iter().all(|o| *o > 0.6), "{mean}: {overlaps:?}");
        println!("mean {mean:.3}: {overlaps:.3?}");
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
        assert!(!doubts(&head));
        assert!(doubts(&inward));
        assert!(doubts(&sample("ring").unwrap()));
    }
}
