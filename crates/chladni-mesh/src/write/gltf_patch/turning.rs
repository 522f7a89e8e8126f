//! How normals turn with a surface, and where they point in the coordinates of a node's mesh.

use crate::TriMesh;
use crate::read::gltf_matrix::Matrix;
use crate::surface::vec3::{Vec3, add, cross, dot, length, scaled, unit};
use crate::surface::{places, seamless_triangles};
use crate::write::MorphTarget;
use crate::write::glb::smooth_normals;

/// Smooth normals of the whole shape: at rest and with each target at 1.
pub(super) struct Shape {
    pub rest: Vec<Vec3>,
    pub turned: Vec<Vec<Vec3>>,
}

impl Shape {
    pub fn of(mesh: &TriMesh, targets: &[MorphTarget]) -> Self {
        let place = places(&mesh.positions);
        let triangles = seamless_triangles(mesh, &place);
        let normals = |positions: &[Vec3]| smooth_normals(&place, positions, &triangles);
        let moved = |target: &MorphTarget| -> Vec<Vec3> {
            mesh.positions.iter().zip(&target.displacements).map(|(p, d)| add(*p, *d)).collect()
        };
        Self {
            rest: normals(&mesh.positions),
            turned: targets.iter().map(|target| normals(&moved(target))).collect(),
        }
    }
}

/// `normal` by the shortest turn that brings `from` to `to`, both unit.
pub(super) fn turned_along(normal: Vec3, from: Vec3, to: Vec3) -> Vec3 {
    let (axis, cosine) = (cross(from, to), dot(from, to));
    if cosine < -0.999 {
        return scaled(normal, -1.0);
    }
    let once = cross(axis, normal);
    add(add(normal, once), scaled(cross(axis, once), 1.0 / (1.0 + cosine)))
}

/// From the scene to the coordinates of a node's mesh.
pub(super) struct Local {
    columns: [Vec3; 3],
    inverse_rows: [Vec3; 3],
}

impl Local {
    /// `None` where the node makes its mesh flat.
    pub fn of([a, b, c, _]: &Matrix) -> Option<Self> {
        let columns = [a, b, c].map(|column| [column[0], column[1], column[2]]);
        let [a, b, c] = columns;
        let volume = dot(a, cross(b, c));
        let size = length(a) * length(b) * length(c);
        let rows = [cross(b, c), cross(c, a), cross(a, b)].map(|row| scaled(row, 1.0 / volume));
        (volume.abs() > 1e-12 * size).then_some(Self { columns, inverse_rows: rows })
    }

    /// A displacement of the scene in the mesh.
    pub fn offset(&self, d: Vec3) -> Vec3 {
        self.inverse_rows.map(|row| dot(row, d))
    }

    /// The direction in the scene of a normal of the mesh.
    pub fn normal_there(&self, n: Vec3) -> Vec3 {
        (0..3).fold([0.0; 3], |sum, i| add(sum, scaled(self.inverse_rows[i], n[i])))
    }

    /// The unit normal of the mesh with this direction in the scene; zero stays zero.
    pub fn normal_here(&self, n: Vec3) -> Vec3 {
        unit(self.columns.map(|column| dot(column, n)))
    }
}
