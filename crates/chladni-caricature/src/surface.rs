//! The operator vertices of a body as a surface to walk and paint on.

use chladni_harmonics::Body;
use chladni_mesh::Frame;
use chladni_mesh::surface::{Rows, vertex_normals_around, vertex_triangles};

use chladni_mesh::surface::vec3::Vec3;

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
        vertex_normals_around(positions, &self.triangles, &self.around)
    }
}
