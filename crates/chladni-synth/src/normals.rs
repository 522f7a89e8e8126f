//! Area-weighted normals of rest shapes, and the rings from which every frame computes its own.

use chladni_mesh::surface::{STAND_IN_NORMAL, vertex_normals};

use crate::SynthError;

/// The triangles around each vertex: for a triangle (v, a, b), rotated to begin with v, the pair (a, b).
#[derive(Debug)]
pub(crate) struct Rings {
    /// N+1 offsets into `pairs`.
    pub offsets: Vec<u32>,
    pub pairs: Vec<[u32; 2]>,
}

impl Rings {
    /// Triangles with repeated corners have no area and are skipped.
    pub fn new(vertices: usize, triangles: &[[u32; 3]]) -> Result<Self, SynthError> {
        check_corners(vertices, triangles)?;
        if u32::try_from(3 * triangles.len()).is_err() {
            return Err(SynthError::TooLarge { items: 1, vertices });
        }
        let proper = || triangles.iter().filter(|[a, b, c]| a != b && b != c && c != a);
        let mut offsets = vec![0_u32; vertices + 1];
        proper().flatten().for_each(|&v| offsets[v as usize + 1] += 1);
        for v in 0..vertices {
            offsets[v + 1] += offsets[v];
        }
        let mut next = offsets.clone();
        let mut pairs = vec![[0; 2]; offsets[vertices] as usize];
        for &[a, b, c] in proper() {
            for (v, pair) in [(a, [b, c]), (b, [c, a]), (c, [a, b])] {
                pairs[next[v as usize] as usize] = pair;
                next[v as usize] += 1;
            }
        }
        Ok(Self { offsets, pairs })
    }

    /// The pairs around vertex `v`.
    pub fn around(&self, v: usize) -> &[[u32; 2]] {
        &self.pairs[self.offsets[v] as usize..self.offsets[v + 1] as usize]
    }
}

/// Area-weighted unit normals n(v) of N positions: the direction of Σ (a − v) × (b − v) over the triangles
/// (v, a, b) around v.
///
/// A vertex whose triangles have no area gets [`STAND_IN_NORMAL`]: all normals have unit length.
///
/// # Errors
/// A triangle that refers to a vertex that does not exist.
pub fn area_weighted_normals(
    positions: &[[f64; 3]],
    triangles: &[[u32; 3]],
) -> Result<Vec<[f64; 3]>, SynthError> {
    check_corners(positions.len(), triangles)?;
    let mut normals = vertex_normals(positions, triangles);
    normals.iter_mut().filter(|n| **n == [0.0; 3]).for_each(|n| *n = STAND_IN_NORMAL);
    Ok(normals)
}

fn check_corners(vertices: usize, triangles: &[[u32; 3]]) -> Result<(), SynthError> {
    for (triangle, t) in triangles.iter().enumerate() {
        if let Some(&vertex) = t.iter().find(|&&v| v as usize >= vertices) {
            return Err(SynthError::TriangleCorner { triangle, vertex, vertices });
        }
    }
    Ok(())
}
