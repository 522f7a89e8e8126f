//! A shape prepared for drawing: everything that does not depend on the point of view.

use chladni_mesh::surface::vec3::{Vec3, add, cross, dot, scaled, single, sub};
use chladni_mesh::surface::{
    Principal, Rows, Tensor, averaged, averaged_curvature, averaging_passes, facing_outward, vertex_areas,
    vertex_gradients, vertex_neighbors, vertex_triangles,
};
use rayon::prelude::*;

use crate::{PickTree, ViewError};

/// A shape with its normals, curvatures, and directions of hatching.
pub struct Plate {
    pub(super) positions: Vec<Vec3>,
    pub(super) triangles: Vec<[u32; 3]>,
    pub(super) around: Rows,
    /// Averaged, unit, outward.
    pub(super) normals: Vec<Vec3>,
    pub(super) tensors: Vec<Tensor>,
    pub(super) principal: Vec<Principal>,
    /// D κ along its own direction, for each of the two principal curvatures.
    pub(super) slopes: [Vec<f64>; 2],
    /// Curvatures without sign, averaged far: where hatching goes.
    pub(super) grain: Vec<Tensor>,
    /// Each edge and the vertex across from it, for each of its triangles, in order.
    pub(super) edges: Vec<([u32; 2], u32)>,
    /// √(A / π), the diameter of the ball with as much surface.
    pub(super) size: f64,
    /// A factor of each vertex' line width.
    pub(super) weights: Option<Vec<f32>>,
    pub(super) single: Vec<[f32; 3]>,
    pub(super) tree: PickTree,
}

/// How far hatching directions are averaged, as a share of the size.
const GRAIN: f64 = 0.03;

impl Plate {
    /// How far curvatures are averaged, as a share of the shape's size, where nothing else is said.
    pub const SMOOTHING: f64 = 0.01;

    /// Makes the shape with these vertices and triangles ready. Coincident vertices should be one, or seams are drawn.
    ///
    /// `smoothing` ≥ 0 is the standard deviation, as a share of the size √(A/π), over which normals and curvatures are
    /// averaged: 0 follows every grain of a scan. Where a mesh is finer than about a sixth of that, less.
    ///
    /// # Errors
    /// [`ViewError::Shape`] where a triangle names a vertex that is not there, a coordinate is not finite, or
    /// there is no area.
    pub fn new(positions: &[Vec3], triangles: &[[u32; 3]], smoothing: f64) -> Result<Self, ViewError> {
        let n = positions.len();
        if triangles.iter().flatten().any(|v| *v as usize >= n) {
            return Err(ViewError::Shape(format!("a triangle names a vertex beyond the {n} that are there")));
        }
        let areas = vertex_areas(positions, triangles);
        let area: f64 = areas.iter().sum();
        let finite = positions.iter().flatten().all(|x| x.is_finite()) && area.is_finite();
        if !finite || area <= 0.0 {
            return Err(ViewError::Shape("a drawing needs a surface with finite coordinates".into()));
        }
        let outward = outward(positions, triangles);
        let triangles = &outward[..];
        let size = (area / std::f64::consts::PI).sqrt();
        let around = vertex_triangles(n, triangles);
        let neighbors = vertex_neighbors(n, triangles);
        let passes = averaging_passes(&areas, smoothing);
        let (normals, tensors) =
            averaged_curvature(positions, triangles, &areas, &around, &neighbors, passes);
        let of = |tensors: &[Tensor]| -> Vec<Principal> {
            tensors.par_iter().zip(&normals).map(|(t, n)| Principal::of(*t, *n)).collect()
        };
        let principal = of(&tensors);
        let slope = |i: usize| {
            let values: Vec<f64> = principal.iter().map(|p| p.values[i]).collect();
            let gradients = vertex_gradients(positions, triangles, &values, &around);
            gradients.iter().zip(&principal).map(|(g, p)| dot(*g, p.directions[i])).collect()
        };
        let slopes = [slope(0), slope(1)];
        let grain = principal.iter().map(Principal::magnitude).collect();
        let grain = averaged(grain, &neighbors, &areas, averaging_passes(&areas, GRAIN));
        let single = single(positions);
        let tree = PickTree::new(&single, triangles);
        let edges = edges(triangles);
        Ok(Self {
            positions: positions.to_vec(),
            triangles: outward,
            around,
            normals,
            tensors,
            principal,
            slopes,
            grain,
            edges,
            size,
            weights: None,
            single,
            tree,
        })
    }

    /// Lines at each vertex are `weights` times as wide, such as by how far it is exaggerated.
    ///
    /// # Errors
    /// [`ViewError::Shape`] where there is not one for each vertex.
    pub fn weighted(mut self, weights: Vec<f32>) -> Result<Self, ViewError> {
        if weights.len() != self.positions.len() {
            let (w, n) = (weights.len(), self.positions.len());
            return Err(ViewError::Shape(format!("{w} line weights for {n} vertices")));
        }
        self.weights = Some(weights);
        Ok(self)
    }
}

/// `triangles`, those that face inward turned round: on them furrows would be edges.
fn outward(positions: &[Vec3], triangles: &[[u32; 3]]) -> Vec<[u32; 3]> {
    let mut outward = facing_outward(positions, triangles);
    // A relief has no inside, but a side that bulges.
    if volume(positions, &outward) < 0.0 {
        outward.iter_mut().for_each(|t| t.swap(1, 2));
    }
    outward
}

/// Six times the volume of the cone from the surface to the mean of its vertices.
fn volume(positions: &[Vec3], triangles: &[[u32; 3]]) -> f64 {
    let middle = scaled(positions.iter().fold([0.0; 3], |sum, p| add(sum, *p)), 1.0 / positions.len() as f64);
    let wedge = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|v| sub(positions[v as usize], middle));
        dot(a, cross(b, c))
    };
    triangles.iter().map(wedge).sum()
}

fn edges(triangles: &[[u32; 3]]) -> Vec<([u32; 2], u32)> {
    let sides = |&[a, b, c]: &[u32; 3]| [([a, b], c), ([b, c], a), ([c, a], b)];
    let ordered = |([a, b], c): ([u32; 2], u32)| ([a.min(b), a.max(b)], c);
    let all = triangles.iter().flat_map(sides).map(ordered);
    let mut edges: Vec<([u32; 2], u32)> = all.filter(|([a, b], _)| a < b).collect();
    edges.par_sort_unstable();
    edges
}
