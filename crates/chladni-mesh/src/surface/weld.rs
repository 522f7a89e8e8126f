//! Coincident vertices merged, for the operator only.

use std::collections::HashMap;

use super::leave_out_flat;
use crate::TriMesh;

/// The operator's view of a mesh: exactly equal positions are one vertex, and only vertices
/// that a triangle uses are there. The file's own vertices are reached through
/// [`operator_vertex`](Self::operator_vertex).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Weld {
    /// N positions, each different, in the order in which the file first names them.
    pub positions: Vec<[f64; 3]>,
    /// Triangles of indices < N with three different corners, in the order of the file. A
    /// triangle that names one position twice has neither area nor a normal and is left out, and so are connected
    /// components without area.
    pub triangles: Vec<[u32; 3]>,
    /// For each of the mesh's n vertices its operator vertex, `None` where no triangle in
    /// [`triangles`](Self::triangles) uses its position.
    pub operator_vertex: Vec<Option<u32>>,
    /// The number of components that were left out, since they have no area; 0 where none has.
    pub without_area: usize,
}

/// Merges exactly equal positions of `mesh` (0 equals −0) and drops unused vertices.
///
/// A mesh without duplicate, unreferenced or collapsed parts comes back as it is, in its order.
pub fn weld(mesh: &TriMesh) -> Weld {
    let place = places(&mesh.positions);
    let distinct = |[a, b, c]: &[u32; 3]| {
        let (a, b, c) = (place[*a as usize], place[*b as usize], place[*c as usize]);
        (a != b && b != c && c != a).then_some([a, b, c])
    };
    let mut triangles: Vec<[u32; 3]> = mesh.triangles.iter().filter_map(distinct).collect();
    let without_area = leave_out_flat(&mesh.positions, &mut triangles);
    let mut used = vec![false; mesh.positions.len()];
    for &v in triangles.iter().flatten() {
        used[v as usize] = true;
    }
    // A position is identified by its first vertex, so one pass in file order numbers all of them.
    let mut row = vec![u32::MAX; mesh.positions.len()];
    let mut positions = Vec::new();
    for (v, &p) in mesh.positions.iter().enumerate() {
        if used[v] {
            row[v] = positions.len() as u32;
            positions.push(p);
        }
    }
    for v in triangles.iter_mut().flatten() {
        *v = row[*v as usize];
    }
    let operator_vertex = place.iter().map(|&v| used[v as usize].then(|| row[v as usize])).collect();
    Weld { positions, triangles, operator_vertex, without_area }
}

/// For each vertex the first vertex with exactly the same position (0 equals −0).
pub fn places(positions: &[[f64; 3]]) -> Vec<u32> {
    let mut first = HashMap::with_capacity(positions.len());
    // Adding 0.0 turns −0 into 0.
    let key = |p: &[f64; 3]| p.map(|x| (x + 0.0).to_bits());
    positions.iter().zip(0_u32..).map(|(p, v)| *first.entry(key(p)).or_insert(v)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seams_close_and_unused_vertices_go() {
        let mesh = TriMesh {
            positions: vec![
                [9.0; 3],
                [0.0, 0.0, 0.0],
                [1.0, 0.0, 0.0],
                [0.0, 1.0, 0.0],
                [1.0, -0.0, 0.0],
                [1.0, 1.0, 0.0],
            ],
            // The last triangle collapses: vertices 2 and 4 coincide.
            triangles: vec![[1, 2, 3], [3, 4, 5], [2, 4, 5]],
            ..TriMesh::default()
        };
        let welded = weld(&mesh);
        assert_eq!(welded.triangles, [[0, 1, 2], [2, 1, 3]]);
        assert_eq!(
            welded.positions,
            [mesh.positions[1], mesh.positions[2], mesh.positions[3], mesh.positions[5]]
        );
        assert_eq!(welded.operator_vertex, [None, Some(0), Some(1), Some(2), Some(1), Some(3)]);
    }
}
