//! Which vertices, edges and triangles touch.

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

/// For each of `vertex_count` vertices whether an edge at it has one triangle only.
pub fn boundary_vertices(vertex_count: usize, triangles: &[[u32; 3]]) -> Vec<bool> {
    let sides = sorted_half_edges(triangles.iter().map(|t| &t[..]));
    let mut on_boundary = vec![false; vertex_count];
    for edge in sides.chunk_by(|a, b| a.ends == b.ends) {
        if let [only] = edge {
            only.ends.into_iter().for_each(|v| on_boundary[v as usize] = true);
        }
    }
    on_boundary
}

/// For each of `vertex_count` vertices its connected component, numbered from 0 in order of appearance. A
/// vertex that no triangle uses is a component of its own.
pub fn components(vertex_count: usize, triangles: &[[u32; 3]]) -> Vec<u32> {
    let mut pieces = Pieces::new(vertex_count);
    for &[a, b, c] in triangles {
        pieces.join(a, b);
        pieces.join(b, c);
    }
    let mut count = 0;
    let mut number = vec![0; vertex_count];
    for v in 0..vertex_count as u32 {
        // The root is the smallest member, so it is numbered before the others.
        let root = pieces.root(v);
        if root == v {
            number[v as usize] = count;
            count += 1;
        } else {
            number[v as usize] = number[root as usize];
        }
    }
    number
}

/// Disjoint sets (union by index, path halving).
pub(crate) struct Pieces {
    parent: Vec<u32>,
}

impl Pieces {
    pub fn new(count: usize) -> Self {
        Self { parent: (0..count as u32).collect() }
    }

    /// The least member of the set of `v`.
    pub fn root(&mut self, mut v: u32) -> u32 {
        while self.parent[v as usize] != v {
            let grandparent = self.parent[self.parent[v as usize] as usize];
            self.parent[v as usize] = grandparent;
            v = grandparent;
        }
        v
    }

    pub fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.root(a), self.root(b));
        self.parent[a.max(b) as usize] = a.min(b);
    }
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

    #[test]
    fn pieces_are_numbered_as_they_appear_and_an_open_edge_is_a_boundary() {
        let tetrahedron = [[0, 2, 1], [0, 1, 4], [0, 4, 2], [1, 2, 4]];
        let mut both = tetrahedron.to_vec();
        both.push([3, 5, 6]);
        assert_eq!(components(8, &both), [0, 0, 0, 1, 0, 1, 1, 2]);
        let open = [false, false, false, true, false, true, true, false];
        assert_eq!(boundary_vertices(8, &both), open);
    }
}
