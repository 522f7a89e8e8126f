//! The mesh as its file holds it.

/// A triangle mesh in the file's own units and vertex order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TriMesh {
    /// n positions, in the order of the file; finite.
    pub positions: Vec<[f64; 3]>,
    /// m triangles of vertex indices < n; polygons are triangulated as a fan from their first corner.
    pub triangles: Vec<[u32; 3]>,
    /// All that is seen but not felt: polygons, UVs, materials, colours.
    pub appearance: Appearance,
}

/// What a file says about the look of a mesh, kept for the export.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Appearance {
    /// One linear-light RGBA colour per vertex, each channel in [0, 1].
    pub colors: Option<Vec<[f32; 4]>>,
}
