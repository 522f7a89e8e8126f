//! Which component of the template each component of the shape belongs to, so that lips do not
//! land on teeth.

use glam::DVec3;
use rayon::prelude::*;

use crate::Similarity;
use crate::bend::vertex_normals;
use crate::bvh::{Bvh, SurfacePoint};
use crate::project::nearest_facing;
use crate::surface::Surface;

/// Another component must be this much nearer than the partner.
const NEARER: f64 = 0.3;

/// A template whose components know the shape's.
pub(crate) struct Partners<'a> {
    pub template: &'a Surface,
    /// For each component of the shape the tree of its partner; empty where the template is one piece.
    trees: Vec<Option<Tree>>,
}

struct Tree {
    component: u32,
    /// The template's triangle of each of the tree's.
    triangle: Vec<u32>,
    bvh: Bvh,
}

impl<'a> Partners<'a> {
    /// Every point of the template is anybody's.
    pub fn none(template: &'a Surface) -> Self {
        Self { template, trees: Vec::new() }
    }

    /// The component that most of a component's area has nearest to it, where that is at least
    /// half, with the shape's vertices where they are `laid` in its own coordinates.
    pub fn by_vote(shape: &Surface, template: &'a Surface, pose: &Similarity, laid: &[DVec3]) -> Self {
        let pieces = template.components();
        if pieces == 1 {
            return Self::none(template);
        }
        let (laid, looking) = in_template(shape, pose, laid);
        let landed: Vec<Option<u32>> = laid
            .par_iter()
            .zip(&looking)
            .map(|(p, n)| Some(template.component_of(nearest_facing(template, *p, *n)?.triangle)))
            .collect();
        let mut votes = std::collections::HashMap::<(u32, u32), f64>::new();
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
        let mut of_piece = vec![Vec::new(); pieces];
        for t in 0..template.triangles.len() as u32 {
            of_piece[template.component_of(t) as usize].push(t);
        }
        let tree = |component: u32| {
            let triangle = of_piece[component as usize].clone();
            let triangles: Vec<_> = triangle.iter().map(|t| template.triangles[*t as usize]).collect();
            Tree { component, triangle, bvh: Bvh::new(&template.points, &triangles) }
        };
        Self { template, trees: partner.into_iter().map(|p| p.map(tree)).collect() }
    }

    /// The nearest facing point of the template for a vertex of the shape's component `of`: its
    /// partner's, unless something else is much nearer.
    pub fn nearest(&self, of: u32, position: DVec3, normal: DVec3) -> Option<SurfacePoint> {
        let any = nearest_facing(self.template, position, normal)?;
        let Some(Some(tree)) = self.trees.get(of as usize) else { return Some(any) };
        if self.template.component_of(any.triangle) == tree.component {
            return Some(any);
        }
        let own = tree
            .bvh
            .closest(position, any.distance_squared.sqrt() / NEARER)
            .map(|at| SurfacePoint { triangle: tree.triangle[at.triangle as usize], ..at });
        Some(own.filter(|at| self.template.smooth_normal(at).dot(normal) > 0.0).unwrap_or(any))
    }
}

/// The shape's vertices, as they are `laid`, and the ways they look, in the template's coordinates.
pub(crate) fn in_template(shape: &Surface, pose: &Similarity, laid: &[DVec3]) -> (Vec<DVec3>, Vec<DVec3>) {
    let back = pose.inverse();
    let turn = back.rotation_matrix();
    let normals = vertex_normals(laid, &shape.triangles);
    (laid.iter().map(|p| back.at(*p)).collect(), normals.into_iter().map(|n| turn * n).collect())
}
