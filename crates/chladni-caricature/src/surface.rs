//! The operator vertices of a body as a surface to walk and paint on.

use chladni_harmonics::Body;
use chladni_mesh::{Frame, Rows, vertex_triangles};
use rayon::prelude::*;

use crate::vector::{Vec3, add, cross, norm, scale, sub};

/// The triangles of a body and, for every vertex, the triangles around it.
#[derive(Clone, Debug)]
pub struct Surface {
    /// Rest positions x(v), N, working frame.
    pub positions: Vec<Vec3>,
    /// Triangles over operator vertices, as in the body.
    pub triangles: Vec<[u32; 3]>,
    /// The similarity between file and working frame.
    pub frame: Frame,
    around: Rows,
}

impl Surface {
    /// The surface of `body` at rest.
    pub fn new(body: &Body) -> Self {
        Self::of(body.positions.clone(), body.triangles.clone(), body.frame)
    }

    /// The surface of `triangles`, whose indices must lie below `positions.len()`.
    pub(crate) fn of(positions: Vec<Vec3>, triangles: Vec<[u32; 3]>, frame: Frame) -> Self {
        let around = vertex_triangles(positions.len(), &triangles);
        Self { positions, triangles, frame, around }
    }

    /// N, the number of operator vertices.
    pub fn vertices(&self) -> usize {
        self.positions.len()
    }

    /// The triangles that use vertex `v` < N.
    pub(crate) fn triangles_around(&self, v: u32) -> &[u32] {
        self.around.row(v as usize)
    }

    /// The operator vertices' positions in the coordinates of the file, N.
    pub fn file_positions(&self) -> Vec<Vec3> {
        self.positions.iter().map(|p| self.frame.to_file(*p)).collect()
    }

    /// Unit vertex normals, area-weighted, of this surface with its vertices at `positions` (N).
    /// Zero where the triangles around a vertex have no area or cancel.
    pub fn normals(&self, positions: &[Vec3]) -> Vec<Vec3> {
        let faces: Vec<Vec3> = self.triangles.par_iter().map(|t| area_normal(positions, *t)).collect();
        (0..self.vertices())
            .into_par_iter()
            .map(|v| {
                let around = self.triangles_around(v as u32);
                let sum = around.iter().fold([0.0; 3], |sum, t| add(sum, faces[*t as usize]));
                let length = norm(sum);
                if length > 0.0 { scale(sum, 1.0 / length) } else { [0.0; 3] }
            })
            .collect()
    }
}

/// (b − a) × (c − a): the normal of a triangle, as long as twice its area.
pub(crate) fn area_normal(positions: &[Vec3], triangle: [u32; 3]) -> Vec3 {
    let [a, b, c] = triangle.map(|v| positions[v as usize]);
    cross(sub(b, a), sub(c, a))
}
