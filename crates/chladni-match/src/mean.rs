//! The mean of several shapes, at each vertex of the first.

use chladni_mesh::TriMesh;
use chladni_task::Task;

use crate::infill::rest_off_surface;
use crate::{
    Correspondence, Match, MatchError, MatchReport, MatchSettings, Similarity, infilled, match_shapes,
};

/// The mean of a shape and of others that are matched with it one after the other.
///
/// Each of the others is brought to the first by the similarity between paired points, weighted by
/// confidence, for every matching method. Each vertex of the first is then averaged with its points on all
/// of them. Where a match is not trusted, the difference is filled in from its surroundings ([`infilled`]). A vertex that no
/// triangle uses, and that has no partner, stays where it is.
pub struct MeanShape<'a> {
    first: &'a TriMesh,
    sum: Vec<[f64; 3]>,
    shapes: usize,
}

impl<'a> MeanShape<'a> {
    /// The mean of `first` alone.
    pub fn of(first: &'a TriMesh) -> Self {
        Self { first, sum: first.positions.clone(), shapes: 1 }
    }

    /// Adds `other`, which is matched as `settings` say (landmarks are pairs of the first shape and
    /// `other`). Returns the report on the match.
    ///
    /// # Errors
    /// Those of [`match_shapes`]; the mean is then unchanged.
    pub fn add(
        &mut self,
        other: &TriMesh,
        settings: &MatchSettings,
        task: &Task,
    ) -> Result<MatchReport, MatchError> {
        let Match { correspondence, report } = match_shapes(self.first, other, settings, task)?;
        let Correspondence { point, confidence, .. } = correspondence;
        let similarity = Similarity::fit(&point, &self.first.positions, Some(&confidence), settings.scaling)?;
        let moved = point.into_iter().map(|p| similarity.apply(p)).collect();
        let direct = Correspondence::direct(moved, confidence);
        let mut target = infilled(self.first, &direct)?.map_or(direct.target, |filled| filled.target);
        rest_off_surface(self.first, &direct.confidence, &mut target);
        for (sum, point) in self.sum.iter_mut().flatten().zip(target.iter().flatten()) {
            *sum += point;
        }
        self.shapes += 1;
        Ok(report)
    }

    /// The positions of the first shape's vertices in the mean, in the coordinates of the first shape.
    pub fn positions(&self) -> Vec<[f64; 3]> {
        let share = 1.0 / self.shapes as f64;
        self.sum.iter().map(|sum| sum.map(|x| x * share)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Method, Scaling};
    use chladni_mesh::samples::{sample, torus};
    use chladni_mesh::surface::TriangleTree;

    #[test]
    fn stretched_and_squeezed_average_to_what_was_neither() {
        let plain = torus(0.4, 24, 12);
        let stretched = |by: f64, pose: &dyn Fn([f64; 3]) -> [f64; 3]| {
            let positions = plain.positions.iter().map(|[x, y, z]| pose([by * x, *y, *z])).collect();
            TriMesh { positions, ..plain.clone() }
        };
        let first = stretched(1.1, &|p| p);
        let turned = stretched(0.9, &|[x, y, z]| [y + 3.0, -x, z - 1.0]);
        let settings =
            MatchSettings { method: Method::Same, scaling: Scaling::Rigid, ..MatchSettings::default() };
        let mut mean = MeanShape::of(&first);
        assert_eq!(mean.positions(), first.positions);
        mean.add(&turned, &settings, &Task::new()).unwrap();
        let refused = mean.add(&torus(0.4, 20, 10), &settings, &Task::new());
        assert!(matches!(refused, Err(MatchError::VertexCountsDiffer { .. })));
        for (found, known) in mean.positions().iter().flatten().zip(plain.positions.iter().flatten()) {
            assert!((found - known).abs() < 1e-9, "{found} {known}");
        }
    }

    #[test]
    fn a_vertex_off_the_surface_stays_where_it_is() {
        let mut first = torus(0.4, 24, 12);
        let other = TriMesh {
            positions: first.positions.iter().map(|[x, y, z]| [1.1 * x, *y, *z]).collect(),
            ..first.clone()
        };
        first.positions.push([5.0, 6.0, 7.0]);
        let settings = MatchSettings { method: Method::Icp, ..MatchSettings::default() };
        let mut mean = MeanShape::of(&first);
        mean.add(&other, &settings, &Task::new()).unwrap();
        assert_eq!(mean.positions().last(), Some(&[5.0, 6.0, 7.0]));
        assert_ne!(mean.positions()[0], first.positions[0]);
    }

    /// Separate meshes, whose width is linear in its slider: the mean of broad and narrow is the plain
    /// head.
    #[test]
    fn the_mean_of_a_broad_and_a_narrow_head_is_the_plain_one() {
        let head = |name: &str| sample(name).unwrap();
        let (broad, narrow) = (head("portrait?width=1"), head("portrait?width=-1"));
        let plain = head("portrait");
        let tree = TriangleTree::new(&plain.positions, &plain.triangles);
        let settings = MatchSettings { scaling: Scaling::Rigid, ..MatchSettings::default() };
        let mut mean = MeanShape::of(&broad);
        mean.add(&narrow, &settings, &Task::new()).unwrap();
        let off = |positions: &[[f64; 3]]| {
            let far = |p: &[f64; 3]| tree.closest(*p, f64::INFINITY).unwrap().distance_squared.sqrt();
            positions.iter().map(far).sum::<f64>() / positions.len() as f64
        };
        let (left, before) = (off(&mean.positions()), off(&broad.positions));
        println!("off by {:.3} of what the broad head is", left / before);
        assert!(left < 0.1 * before, "{left} of {before}");
    }
}
