//! Who neighbours whom on the operator vertices of a body.

use chladni_harmonics::Body;
use rayon::prelude::*;

use crate::vector::{Vec3, add, cross, norm, scale, sub};

/// The triangles of a body and, for every vertex, the triangles around it.
#[derive(Clone, Debug)]
pub struct Surface {
    /// Rest positions x(v), N, working frame.
    pub positions: Vec<Vec3>,
    /// Triangles over operator vertices, as in the body.
    pub triangles: Vec<[u32; 3]>,
    start: Vec<u32>,
    around: Vec<u32>,
}

impl Surface {
    /// The surface of `body` at rest.
    pub fn new(body: &Body) -> Self {
        Self::of(body.positions.clone(), body.triangles.clone())
    }

    /// The surface of `triangles`, each over indices below `positions.len()`; a triangle with
    /// an index beyond is dropped from the neighbourhoods.
    pub(crate) fn of(positions: Vec<Vec3>, triangles: Vec<[u32; 3]>) -> Self {
        let n = positions.len();
        let mut start = vec![0_u32; n + 1];
        let valid = |t: &[u32; 3]| t.iter().all(|v| (*v as usize) < n);
        for t in triangles.iter().filter(|t| valid(t)) {
            t.iter().for_each(|v| start[*v as usize + 1] += 1);
        }
        for v in 0..n {
            start[v + 1] += start[v];
        }
        let mut next = start.clone();
        let mut around = vec![0; start[n] as usize];
        for (i, t) in triangles.iter().enumerate().filter(|(_, t)| valid(t)) {
            for v in t {
                let slot = &mut next[*v as usize];
                around[*slot as usize] = i as u32;
                *slot += 1;
            }
        }
        Self { positions, triangles, start, around }
    }

    /// N, the number of operator vertices.
    pub fn vertices(&self) -> usize {
        self.positions.len()
    }

    /// The triangles that use vertex `v`; none where there is no such vertex.
    pub fn triangles_around(&self, v: u32) -> &[u32] {
        let bounds = (self.start.get(v as usize), self.start.get(v as usize + 1));
        match bounds {
            (Some(&a), Some(&b)) => &self.around[a as usize..b as usize],
            _ => &[],
        }
    }

    /// Unit vertex normals, area-weighted, of this surface with its vertices at `positions` (N).
    /// Zero where the triangles around a vertex have no area or cancel.
    pub fn normals(&self, positions: &[Vec3]) -> Vec<Vec3> {
        let faces: Vec<Vec3> = self.triangles.par_iter().map(|t| area_normal(positions, *t)).collect();
        (0..self.vertices())
            .into_par_iter()
            .map(|v| {
                let around = self.triangles_around(v as u32);
                let sum = around.iter().fold([0.0; 3], |sum, t| add(sum, faces[*t as usize]));
                let length = norm(sum);
                if length > 0.0 { scale(sum, 1.0 / length) } else { [0.0; 3] }
            })
            .collect()
    }
}

/// (b − a) × (c − a): the normal of a triangle, as long as twice its area; zero where an index
/// is out of range.
pub(crate) fn area_normal(positions: &[Vec3], triangle: [u32; 3]) -> Vec3 {
    let [Some(&a), Some(&b), Some(&c)] = triangle.map(|v| positions.get(v as usize)) else {
        return [0.0; 3];
    };
    cross(sub(b, a), sub(c, a))
}
