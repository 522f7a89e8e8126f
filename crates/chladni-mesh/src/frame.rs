//! The working frame: centered, uniformly scaled into [-1, 1]³.

use crate::TriMesh;
use crate::surface::vec3::{cross, sub};
use crate::surface::{has_flat_triangle, is_collapsed, weld};

/// The similarity between a file's coordinates and the working frame:
/// `working = (file − center) · scale`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// Area-weighted centroid, in file units.
    pub center: [f64; 3],
    /// Working units per file unit; positive and finite.
    pub scale: f64,
}

impl Frame {
    /// The frame of `mesh`: its area-weighted centroid goes to the origin and its farthest coordinate to ±1.
    /// A mesh without extent keeps scale 1. Triangles without area that [`weld`] leaves out do not count.
    pub fn of(mesh: &TriMesh) -> Self {
        // Most meshes have no triangle without area, and all of theirs count.
        if has_flat_triangle(&mesh.positions, &mesh.triangles) {
            return Self::of_welded(mesh, &weld(mesh).operator_vertex);
        }
        Self::of_those(mesh, |t| !is_collapsed(&mesh.positions, t))
    }

    /// As [`of`](Self::of), for a mesh that is welded already: `operator_vertex` is that of its [`weld`].
    ///
    /// # Panics
    /// If a triangle names a vertex that is not there.
    pub fn of_welded(mesh: &TriMesh, operator_vertex: &[Option<u32>]) -> Self {
        Self::of_those(mesh, |t| {
            !is_collapsed(&mesh.positions, t) && operator_vertex[t[0] as usize].is_some()
        })
    }

    /// The frame of the triangles that count.
    fn of_those(mesh: &TriMesh, counts: impl Fn(&&[u32; 3]) -> bool + Copy) -> Self {
        let triangles = || mesh.triangles.iter().filter(counts);
        // Offsets from a vertex of the surface keep the sums accurate where the mesh lies far from the origin.
        let first = triangles().flatten().min();
        let Some(&origin) = first.and_then(|v| mesh.positions.get(*v as usize)) else {
            return Self { center: [0.0; 3], scale: 1.0 };
        };
        let at = |v: u32| sub(mesh.positions[v as usize], origin);
        let mut area = 0.0;
        let mut moment = [0.0; 3];
        for &[a, b, c] in triangles() {
            let (pa, pb, pc) = (at(a), at(b), at(c));
            let n = cross(sub(pb, pa), sub(pc, pa));
            let twice_area = n[0].hypot(n[1]).hypot(n[2]);
            area += twice_area;
            for i in 0..3 {
                moment[i] += twice_area * (pa[i] + pb[i] + pc[i]) / 3.0;
            }
        }
        let center: [f64; 3] =
            std::array::from_fn(|i| origin[i] + if area > 0.0 { moment[i] / area } else { 0.0 });
        let mut extent = 0.0_f64;
        for &v in triangles().flatten() {
            for i in 0..3 {
                extent = extent.max((mesh.positions[v as usize][i] - center[i]).abs());
            }
        }
        let scale = 1.0 / extent;
        Self { center, scale: if scale.is_finite() && scale > 0.0 { scale } else { 1.0 } }
    }

    /// A point of the file in the working frame.
    pub fn to_working(&self, point: [f64; 3]) -> [f64; 3] {
        std::array::from_fn(|i| (point[i] - self.center[i]) * self.scale)
    }

    /// A point of the working frame in the file's coordinates.
    pub fn to_file(&self, point: [f64; 3]) -> [f64; 3] {
        std::array::from_fn(|i| point[i] / self.scale + self.center[i])
    }

    /// A displacement (no center) of the working frame in the file's units.
    pub fn displacement_to_file(&self, displacement: [f64; 3]) -> [f64; 3] {
        displacement.map(|d| d / self.scale)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples;

    #[test]
    fn what_no_triangle_uses_does_not_count() {
        let mesh = samples::icosphere(1);
        let frame = Frame::of(&mesh);
        let mut with_more = mesh.clone();
        with_more.positions.insert(0, [1e20, 0.0, 0.0]);
        with_more.triangles.iter_mut().flatten().for_each(|v| *v += 1);
        assert_eq!(Frame::of(&with_more), frame);
        with_more.triangles.insert(0, [0; 3]);
        with_more.triangles.insert(0, [0, 1, 0]);
        assert_eq!(Frame::of(&with_more), frame, "triangles of one place");
        let empty = TriMesh { positions: vec![[1.0; 3]], ..TriMesh::default() };
        assert_eq!(Frame::of(&empty), Frame { center: [0.0; 3], scale: 1.0 });
    }
}
