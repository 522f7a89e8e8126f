//! Meshes with known spectra, generated in code.
#![allow(dead_code, reason = "each test file uses some of them")]

use std::collections::HashMap;

use chladni_mesh::TriMesh;

pub fn mesh(positions: Vec<[f64; 3]>, triangles: Vec<[u32; 3]>) -> TriMesh {
    TriMesh { positions, triangles, ..TriMesh::default() }
}

/// The unit sphere as an icosahedron subdivided `levels` times: 10·4^levels + 2 vertices.
pub fn icosphere(levels: u32) -> TriMesh {
    let t = (1.0 + 5.0_f64.sqrt()) / 2.0;
    let mut positions: Vec<[f64; 3]> = Vec::new();
    for (a, b) in [(-1.0, t), (1.0, t), (-1.0, -t), (1.0, -t)] {
        positions.push([a, b, 0.0]);
    }
    for (a, b) in [(-1.0, t), (1.0, t), (-1.0, -t), (1.0, -t)] {
        positions.push([0.0, a, b]);
    }
    for (a, b) in [(t, -1.0), (t, 1.0), (-t, -1.0), (-t, 1.0)] {
        positions.push([a, 0.0, b]);
    }
    let mut triangles = vec![
        [0, 11, 5],
        [0, 5, 1],
        [0, 1, 7],
        [0, 7, 10],
        [0, 10, 11],
        [1, 5, 9],
        [5, 11, 4],
        [11, 10, 2],
        [10, 7, 6],
        [7, 1, 8],
        [3, 9, 4],
        [3, 4, 2],
        [3, 2, 6],
        [3, 6, 8],
        [3, 8, 9],
        [4, 9, 5],
        [2, 4, 11],
        [6, 2, 10],
        [8, 6, 7],
        [9, 8, 1_u32],
    ];
    for _ in 0..levels {
        let mut middle: HashMap<(u32, u32), u32> = HashMap::new();
        let mut finer = Vec::with_capacity(triangles.len() * 4);
        for t in triangles {
            let m: [u32; 3] = std::array::from_fn(|i| {
                let (a, b) = (t[i], t[(i + 1) % 3]);
                *middle.entry((a.min(b), a.max(b))).or_insert_with(|| {
                    let (p, q) = (positions[a as usize], positions[b as usize]);
                    positions.push(std::array::from_fn(|x| (p[x] + q[x]) / 2.0));
                    positions.len() as u32 - 1
                })
            });
            finer.extend([[t[0], m[0], m[2]], [m[0], t[1], m[1]], [m[2], m[1], t[2]], m]);
        }
        triangles = finer;
    }
    for p in &mut positions {
        let length = p.iter().map(|x| x * x).sum::<f64>().sqrt();
        *p = p.map(|x| x / length);
    }
    mesh(positions, triangles)
}

/// The unit square, as cells × cells squares of two triangles each.
pub fn square(cells: u32) -> TriMesh {
    let side = cells + 1;
    let positions = (0..side * side)
        .map(|v| [f64::from(v % side) / f64::from(cells), f64::from(v / side) / f64::from(cells), 0.0])
        .collect();
    let triangles = (0..cells * cells)
        .flat_map(|c| {
            let v = c / cells * side + c % cells;
            [[v, v + 1, v + side], [v + 1, v + side + 1, v + side]]
        })
        .collect();
    mesh(positions, triangles)
}

/// Meshes side by side, each moved by its index times `offset`.
pub fn beside(parts: &[TriMesh], offset: [f64; 3]) -> TriMesh {
    let mut all = TriMesh::default();
    for (number, part) in parts.iter().enumerate() {
        let first = all.positions.len() as u32;
        let moved = |p: &[f64; 3]| std::array::from_fn(|i| p[i] + offset[i] * number as f64);
        all.positions.extend(part.positions.iter().map(moved));
        all.triangles.extend(part.triangles.iter().map(|t| t.map(|v| v + first)));
    }
    all
}

/// `mesh` scaled about the origin.
pub fn scaled(mesh: &TriMesh, factor: f64) -> TriMesh {
    TriMesh { positions: mesh.positions.iter().map(|p| p.map(|x| x * factor)).collect(), ..mesh.clone() }
}
