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
    whole_triangles: usize,
}

impl Surface {
    /// The surface of `body` at rest.
    pub fn new(body: &Body) -> Self {
        Self::of(body.positions.clone(), body.triangles.clone(), body.frame)
    }

    /// The surface of `triangles`, whose indices must lie below `positions.len()`.
    pub(crate) fn of(positions: Vec<Vec3>, triangles: Vec<[u32; 3]>, frame: Frame) -> Self {
        let around = vertex_triangles(positions.len(), &triangles);
        let whole_triangles = triangles.iter().filter(|[a, b, c]| a != b && b != c && c != a).count();
        Self { positions, triangles, frame, around, whole_triangles }
    }

    /// N, the number of operator vertices.
    pub fn vertices(&self) -> usize {
        self.positions.len()
    }

    /// The number of triangles with three different corners: others, such as those of faces that the file has twice,
    /// neither fold nor cross.
    pub fn whole_triangles(&self) -> usize {
        self.whole_triangles
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

#[cfg(test)]
mod tests {
    use crate::Surface;
    use crate::fixture::icosphere;

    #[test]
    fn collapsed_backs_are_no_whole_triangles() {
        let (positions, mut triangles) = icosphere(1);
        let backs: Vec<[u32; 3]> = triangles.iter().map(|[a, ..]| [*a; 3]).collect();
        triangles.extend(backs);
        let frame = chladni_mesh::Frame { center: [0.0; 3], scale: 1.0 };
        let surface = Surface::of(positions, triangles, frame);
        assert_eq!((surface.triangles.len(), surface.whole_triangles()), (160, 80));
    }
}
