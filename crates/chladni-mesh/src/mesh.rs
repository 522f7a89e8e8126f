//! The mesh as its file holds it.

use crate::{Appearance, Texture};

/// A triangle mesh in the file's own units and vertex order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TriMesh {
    /// n positions, in the order of the file; finite.
    pub positions: Vec<[f64; 3]>,
    /// m triangles of vertex indices < n, those of a polygon one after the other. A polygon is divided into a fan from its
    /// first corner unless [`Appearance::divided`] says otherwise.
    pub triangles: Vec<[u32; 3]>,
    /// Polygons, UVs, materials and colors: they affect only the look.
    pub appearance: Appearance,
}

impl TriMesh {
    /// Number of faces as the file stores them: polygons where it has any, else triangles.
    pub fn face_count(&self) -> usize {
        self.appearance.polygons.as_ref().map_or(self.triangles.len(), |polygons| polygons.len())
    }

    /// The corners of face `f` as the file stores it; `f` < [`face_count`](Self::face_count).
    pub fn face(&self, f: usize) -> &[u32] {
        self.appearance.polygons.as_ref().map_or_else(|| &self.triangles[f][..], |polygons| polygons.row(f))
    }

    /// Where the corners of face `f` begin in the list of all faces' corners.
    pub fn first_corner(&self, f: usize) -> usize {
        self.appearance.polygons.as_ref().map_or(3 * f, |polygons| polygons.starts[f] as usize)
    }

    /// For each triangle its face and, of that face's corners, the three it uses.
    pub(crate) fn triangle_corners(&self) -> impl Iterator<Item = (usize, [usize; 3])> {
        (0..self.face_count()).flat_map(move |f| {
            let divided = self.appearance.divided.get(&(f as u32));
            (2..self.face(f).len()).map(move |second| {
                let corners = divided.and_then(|triangles| triangles.get(second - 2));
                (f, corners.map_or([0, second - 1, second], |corners| corners.map(|c| c as usize)))
            })
        })
    }

    /// Texture coordinates of each triangle's corners, v upward; `None` where the mesh has none.
    /// Corners without any are at (0, 0).
    pub fn triangle_uvs(&self) -> Option<Vec<[[f32; 2]; 3]>> {
        let uvs = self.appearance.uvs.as_ref()?;
        let at = |corner: usize| {
            let point = uvs.corners.get(corner).and_then(|&i| uvs.points.get(i as usize));
            point.map_or([0.0; 2], |p| p.map(|x| x as f32))
        };
        let triangle = |(f, corners): (usize, [usize; 3])| corners.map(|c| at(self.first_corner(f) + c));
        Some(self.triangle_corners().map(triangle).collect())
    }

    /// For each triangle its index in [`Appearance::materials`].
    pub fn triangle_materials(&self) -> Vec<Option<u32>> {
        let material = |f: usize| self.appearance.face_materials.get(f).copied().flatten();
        self.triangle_corners().map(|(f, _)| material(f)).collect()
    }

    /// The base color texture of the first material that has one.
    pub fn base_color_texture(&self) -> Option<&Texture> {
        self.appearance.materials.iter().find_map(|material| material.base_color_texture.as_ref())
    }
}
