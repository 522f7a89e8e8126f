//! Finds the component of the template that belongs to each component of the shape. It keeps lips from
//! being matched with teeth.

use std::collections::HashMap;

use chladni_mesh::surface::{Closest, SurfacePoint, TriangleTree};
use glam::DVec3;
use rayon::prelude::*;

use crate::Similarity;
use crate::project::nearest_facing;
use crate::surface::{UnitSurface, triangle_tree};

/// A point of another component is used if its distance is below this share of the distance to the partner.
const NEARER: f64 = 0.3;

/// A template, with the partners of the shape's components.
pub(crate) struct Partners<'a> {
    pub template: &'a UnitSurface,
    /// For each component of the shape its partner; empty if the template has one component.
    partner: Vec<Option<u32>>,
    /// The template's components that are partners of some component.
    trees: HashMap<u32, Tree>,
}

struct Tree {
    /// For each triangle of the tree, the template's triangle.
    triangle: Vec<u32>,
    tree: TriangleTree,
}

impl<'a> Partners<'a> {
    /// Without partners: every vertex may be matched with all of the template.
    pub fn none(template: &'a UnitSurface) -> Self {
        Self { template, partner: Vec::new(), trees: HashMap::new() }
    }

    /// The partner of each component is the component of the template that is nearest to most of its area,
    /// if that is at least half. `laid` holds the positions of the shape's vertices, in the shape's
    /// coordinates.
    pub fn by_vote(
        shape: &UnitSurface,
        template: &'a UnitSurface,
        pose: &Similarity,
        laid: &[DVec3],
    ) -> Self {
        let pieces = template.components();
        if pieces == 1 {
            return Self::none(template);
        }
        let (laid, looking) = in_template(shape, pose, laid);
        let landed: Vec<Option<u32>> = laid
            .par_iter()
            .zip(&looking)
            .map(|(p, n)| Some(template.component_of(nearest_facing(template, *p, *n)?.on.triangle)))
            .collect();
        let mut votes = HashMap::<(u32, u32), f64>::new();
        let mut total = vec![0.0; shape.components()];
        for (v, piece) in landed.iter().enumerate() {
            if let Some(piece) = piece {
                *votes.entry((shape.component[v], *piece)).or_default() += shape.areas[v];
                total[shape.component[v] as usize] += shape.areas[v];
            }
        }
        let mut partner = vec![None; total.len()];
        for ((from, to), area) in votes {
            if area > 0.5 * total[from as usize] {
                partner[from as usize] = Some(to);
            }
        }
        let mut triangles: HashMap<u32, Vec<u32>> =
            partner.iter().flatten().map(|c| (*c, Vec::new())).collect();
        for t in 0..template.triangles.len() as u32 {
            if let Some(list) = triangles.get_mut(&template.component_of(t)) {
                list.push(t);
            }
        }
        let tree = |(component, triangle): (u32, Vec<u32>)| {
            let corners: Vec<_> = triangle.iter().map(|t| template.triangles[*t as usize]).collect();
            (component, Tree { tree: triangle_tree(&template.points, &corners), triangle })
        };
        Self { template, partner, trees: triangles.into_iter().map(tree).collect() }
    }

    /// The nearest facing point of the template for a vertex of the shape's component `of`: a point of its
    /// partner, unless something else is much nearer.
    pub fn nearest(&self, of: u32, position: DVec3, normal: DVec3) -> Option<Closest> {
        let any = nearest_facing(self.template, position, normal)?;
        let Some(Some(partner)) = self.partner.get(of as usize) else { return Some(any) };
        let Some(tree) = self.trees.get(partner) else { return Some(any) };
        if self.template.component_of(any.on.triangle) == *partner {
            return Some(any);
        }
        let own = tree.tree.closest(position.to_array(), any.distance_squared.sqrt() / NEARER).map(|at| {
            Closest { on: SurfacePoint { triangle: tree.triangle[at.on.triangle as usize], ..at.on }, ..at }
        });
        Some(own.filter(|at| self.template.smooth_normal(&at.on).dot(normal) > 0.0).unwrap_or(any))
    }
}

/// The shape's fitted vertices `laid` and their normals, in the coordinates of the template.
pub(crate) fn in_template(
    shape: &UnitSurface,
    pose: &Similarity,
    laid: &[DVec3],
) -> (Vec<DVec3>, Vec<DVec3>) {
    let back = pose.inverse();
    let turn = back.rotation_matrix();
    let normals = shape.normals_at(laid);
    (laid.iter().map(|p| back.at(*p)).collect(), normals.into_iter().map(|n| turn * n).collect())
}

#[cfg(test)]
mod tests {
    use chladni_mesh::{TriMesh, samples};

    use super::*;
    use crate::Side;

    /// Two spheres, one inside the other.
    fn nested(outer: f64, inner: f64) -> UnitSurface {
        let ball = samples::icosphere(3);
        let n = ball.positions.len() as u32;
        let mesh = TriMesh {
            positions: [outer, inner]
                .iter()
                .flat_map(|r| ball.positions.iter().map(move |p| p.map(|x| r * x)))
                .collect(),
            triangles: [0, n]
                .iter()
                .flat_map(|k| ball.triangles.iter().map(move |t| t.map(|v| v + k)))
                .collect(),
            ..TriMesh::default()
        };
        UnitSurface::new(&mesh, Side::Template).unwrap()
    }

    #[test]
    fn a_dent_stays_on_the_skin_it_belongs_to() {
        let template = nested(1.0, 0.9);
        // The outer skin of the shape, with a dent on one side that brings it nearer to the inner skin.
        let shape = nested(1.0, 0.9);
        let dent = |p: &DVec3| if p.x > 0.1 { *p * 0.93 } else { *p };
        let laid: Vec<DVec3> = shape.points.iter().map(dent).collect();
        let outer = shape.component[0];
        let dented = |v: &usize| shape.component[*v] == outer && shape.points[*v].x > 0.1;
        let landed = |partners: &Partners, v: usize| {
            let at = partners.nearest(outer, laid[v], shape.normals[v]).unwrap();
            template.component_of(at.on.triangle)
        };
        let (none, voted) =
            (Partners::none(&template), Partners::by_vote(&shape, &template, &Similarity::IDENTITY, &laid));
        let mut tested = 0;
        for v in (0..laid.len()).filter(dented) {
            assert_ne!(landed(&none, v), outer);
            assert_eq!(landed(&voted, v), outer);
            tested += 1;
        }
        assert!(tested > 100);
    }
}
