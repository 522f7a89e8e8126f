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
    let mut starts = vec![0_u32; vertex_count + 1];
    for corners in triangles {
        for v in distinct(corners) {
            starts[v as usize + 1] += 1;
        }
    }
    for v in 0..vertex_count {
        starts[v + 1] += starts[v];
    }
    let mut next = starts.clone();
    let mut items = vec![0; starts[vertex_count] as usize];
    for (corners, t) in triangles.iter().zip(0_u32..) {
        for v in distinct(corners) {
            items[next[v as usize] as usize] = t;
            next[v as usize] += 1;
        }
    }
    Rows { starts, items }
}

/// The corners of a triangle, each named once.
fn distinct(&[a, b, c]: &[u32; 3]) -> impl Iterator<Item = u32> {
    [Some(a), (b != a).then_some(b), (c != a && c != b).then_some(c)].into_iter().flatten()
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

/// For each triangle its neighbour across the edges (0,1), (1,2), (2,0): `None` where the edge
/// is a boundary or where more than two triangles meet.
pub fn triangle_neighbors(triangles: &[[u32; 3]]) -> Vec<[Option<u32>; 3]> {
    let mut neighbors = vec![[None; 3]; triangles.len()];
    let sides = sorted_half_edges(triangles);
    for edge in sides.chunk_by(|a, b| a.ends == b.ends) {
        if let [a, b] = edge {
            neighbors[a.triangle as usize][a.side as usize] = Some(b.triangle);
            neighbors[b.triangle as usize][b.side as usize] = Some(a.triangle);
        }
    }
    neighbors
}

/// One side of one triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct HalfEdge {
    /// The edge's vertices, the lesser first.
    pub ends: [u32; 2],
    /// The triangle it belongs to.
    pub triangle: u32,
    /// Which side of the triangle: from corner `side` to the next.
    pub side: u8,
    /// Whether the triangle runs from the lesser to the greater vertex.
    pub forward: bool,
}

/// All half-edges with two different ends, sorted so that those of one edge lie together.
pub(crate) fn sorted_half_edges(triangles: &[[u32; 3]]) -> Vec<HalfEdge> {
    use rayon::slice::ParallelSliceMut;
    let mut sides = Vec::with_capacity(3 * triangles.len());
    for (corners, triangle) in triangles.iter().zip(0_u32..) {
        for side in 0..3_u8 {
            let (a, b) = (corners[side as usize], corners[(side as usize + 1) % 3]);
            if a != b {
                let ends = [a.min(b), a.max(b)];
                sides.push(HalfEdge { ends, triangle, side, forward: a < b });
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
    fn two_triangles_and_a_third_on_their_edge() {
        let pair = [[0, 1, 2], [2, 1, 3]];
        assert_eq!(triangle_neighbors(&pair), [[None, Some(1), None], [Some(0), None, None]]);
        let rows = vertex_neighbors(4, &pair);
        assert_eq!(rows.row(0), [1, 2]);
        assert_eq!(rows.row(1), [0, 2, 3]);
        let around = vertex_triangles(5, &pair);
        assert_eq!(around.row(2), [0, 1]);
        assert_eq!(around.row(4), [0_u32; 0]);
        let fan = [[0, 1, 2], [2, 1, 3], [1, 2, 4]];
        assert!(triangle_neighbors(&fan).iter().flatten().all(Option::is_none));
    }
}
