//! Who touches whom.

/// Rows of varying length in one array: row `v` is `items[starts[v]..starts[v + 1]]`.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Rows {
    /// One more entry than there are rows, ascending from 0.
    pub starts: Vec<u32>,
    /// All rows, one after the other.
    pub items: Vec<u32>,
}

impl Rows {
    /// Number of rows.
    pub fn len(&self) -> usize {
        self.starts.len().saturating_sub(1)
    }

    /// Whether there is no row.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Row `v`, which must be less than [`len`](Self::len).
    pub fn row(&self, v: usize) -> &[u32] {
        &self.items[self.starts[v] as usize..self.starts[v + 1] as usize]
    }
}

/// For each of `vertex_count` vertices the triangles that use it, ascending.
pub fn vertex_triangles(vertex_count: usize, triangles: &[[u32; 3]]) -> Rows {
    vertex_faces(vertex_count, triangles.iter().map(|t| &t[..]))
}

/// For each of `vertex_count` vertices the faces that use it, ascending, each once.
pub(crate) fn vertex_faces<'a>(vertex_count: usize, faces: impl Iterator<Item = &'a [u32]> + Clone) -> Rows {
    let mut last_face = vec![u32::MAX; vertex_count];
    let mut starts = vec![0_u32; vertex_count + 1];
    for (face, f) in faces.clone().zip(0_u32..) {
        for &v in face {
            if std::mem::replace(&mut last_face[v as usize], f) != f {
                starts[v as usize + 1] += 1;
            }
        }
    }
    for v in 0..vertex_count {
        starts[v + 1] += starts[v];
    }
    last_face.fill(u32::MAX);
    let mut next = starts.clone();
    let mut items = vec![0; starts[vertex_count] as usize];
    for (face, f) in faces.zip(0_u32..) {
        for &v in face {
            if std::mem::replace(&mut last_face[v as usize], f) != f {
                items[next[v as usize] as usize] = f;
                next[v as usize] += 1;
            }
        }
    }
    Rows { starts, items }
}

/// For each of `vertex_count` vertices those that share an edge with it, ascending, each once.
pub fn vertex_neighbors(vertex_count: usize, triangles: &[[u32; 3]]) -> Rows {
    let around = vertex_triangles(vertex_count, triangles);
    let mut rows = Rows { starts: Vec::with_capacity(vertex_count + 1), items: Vec::new() };
    rows.starts.push(0);
    let mut ring = Vec::new();
    for v in 0..vertex_count {
        ring.clear();
        for &t in around.row(v) {
            ring.extend(triangles[t as usize].iter().filter(|&&w| w as usize != v));
        }
        ring.sort_unstable();
        ring.dedup();
        rows.items.extend_from_slice(&ring);
        rows.starts.push(rows.items.len() as u32);
    }
    rows
}

/// One side of one face.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct HalfEdge {
    /// The edge's vertices, the lesser first.
    pub ends: [u32; 2],
    /// The face it belongs to.
    pub face: u32,
    /// Whether the face runs from the lesser to the greater vertex.
    pub forward: bool,
}

/// All half-edges with two different ends, sorted so that those of one edge lie together.
pub(crate) fn sorted_half_edges<'a>(faces: impl Iterator<Item = &'a [u32]>) -> Vec<HalfEdge> {
    use rayon::slice::ParallelSliceMut;
    let mut sides = Vec::new();
    for (corners, face) in faces.zip(0_u32..) {
        let next = corners.iter().cycle().skip(1);
        for (&a, &b) in corners.iter().zip(next) {
            if a != b {
                sides.push(HalfEdge { ends: [a.min(b), a.max(b)], face, forward: a < b });
            }
        }
    }
    sides.par_sort_unstable();
    sides
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_triangles_touch_along_an_edge() {
        let pair = [[0, 1, 2], [2, 1, 3]];
        let rows = vertex_neighbors(4, &pair);
        assert_eq!(rows.row(0), [1, 2]);
        assert_eq!(rows.row(1), [0, 2, 3]);
        let around = vertex_triangles(5, &pair);
        assert_eq!(around.row(2), [0, 1]);
        assert_eq!(around.row(4), [0_u32; 0]);
    }
}
