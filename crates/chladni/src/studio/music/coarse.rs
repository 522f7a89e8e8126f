//! Fewer triangles over some of the same vertices, for small pictures on slow devices.

use std::collections::{HashMap, HashSet};

use chladni_view::{Gpu, Topology, smooth_normals};

/// Such triangles on the device.
pub struct Coarse {
    pub topology: Topology,
    pub triangles: Vec<[u32; 3]>,
    /// How many vertices they name.
    pub vertices: usize,
}

impl Coarse {
    /// Of a shape that has `all` vertices.
    pub fn new(gpu: &Gpu, all: usize, triangles: Vec<[u32; 3]>) -> Result<Self, String> {
        let named: HashSet<u32> = triangles.iter().flatten().copied().collect();
        let topology = Topology::new(gpu, all, &triangles).map_err(|error| error.to_string())?;
        Ok(Self { topology, triangles, vertices: named.len() })
    }
}

/// Triangles that name about `wanted` of the vertices, each for a cluster of neighbours that face
/// the same way (vertex clustering: Rossignac and Borrel 1993). What is drawn through them moves
/// exactly as the whole shape does.
pub fn triangles(positions: &[[f32; 3]], triangles: &[[u32; 3]], wanted: usize) -> Vec<[u32; 3]> {
    let normals = smooth_normals(positions, triangles);
    let (mut low, mut high) = ([f32::MAX; 3], [f32::MIN; 3]);
    for p in positions {
        for i in 0..3 {
            (low[i], high[i]) = (low[i].min(p[i]), high[i].max(p[i]));
        }
    }
    let diagonal = (0..3).map(|i| (high[i] - low[i]).powi(2)).sum::<f32>().sqrt();
    if !(diagonal > 0.0 && diagonal.is_finite()) || positions.len() <= wanted {
        return triangles.to_vec();
    }
    let clusters = |size: f32| {
        let mut clusters: HashMap<[i32; 4], Vec<u32>> = HashMap::new();
        for (v, (p, n)) in positions.iter().zip(&normals).enumerate() {
            let facing = (0..3).map(|i| i32::from(n[i] > 0.0) << i).sum();
            let at = |i: usize| ((p[i] - low[i]) / size) as i32;
            clusters.entry([at(0), at(1), at(2), facing]).or_default().push(v as u32);
        }
        clusters
    };
    // Their number goes with the inverse square of their size.
    let mut size = diagonal / (wanted as f32).sqrt();
    for _ in 0..5 {
        size *= (clusters(size).len() as f32 / wanted.max(1) as f32).sqrt().clamp(0.25, 4.0);
    }
    let mut stands_for: Vec<u32> = (0..positions.len() as u32).collect();
    for members in clusters(size).values() {
        let middle = nearest_to_mean(positions, members);
        members.iter().for_each(|&v| stands_for[v as usize] = middle);
    }
    let mut seen = HashSet::new();
    let mut coarse = Vec::new();
    for triangle in triangles {
        let [a, b, c] = triangle.map(|v| stands_for.get(v as usize).copied().unwrap_or(v));
        let mut key = [a, b, c];
        key.sort_unstable();
        if a != b && b != c && c != a && seen.insert(key) {
            coarse.push([a, b, c]);
        }
    }
    coarse
}

fn nearest_to_mean(positions: &[[f32; 3]], members: &[u32]) -> u32 {
    let at = |v: u32| positions[v as usize];
    let mean = |i: usize| members.iter().map(|&v| at(v)[i]).sum::<f32>() / members.len() as f32;
    let mean = [mean(0), mean(1), mean(2)];
    let far = |v: u32| (0..3).map(|i| (at(v)[i] - mean[i]).powi(2)).sum::<f32>();
    // Ties go to the first: members come in the order of the vertices.
    members.iter().copied().min_by(|&a, &b| far(a).total_cmp(&far(b))).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use chladni_mesh::samples;

    #[test]
    fn a_coarse_shape_names_fewer_vertices_and_keeps_its_area() {
        let mesh = samples::sample("octopus").expect("it is there");
        let positions: Vec<[f32; 3]> = mesh.positions.iter().map(|p| p.map(|c| c as f32)).collect();
        let area = |triangles: &[[u32; 3]]| -> f32 {
            let corner = |v: u32| positions[v as usize];
            triangles
                .iter()
                .map(|t| {
                    let [a, b, c] = t.map(corner);
                    let edge = |p: [f32; 3]| [p[0] - a[0], p[1] - a[1], p[2] - a[2]];
                    let (u, v) = (edge(b), edge(c));
                    let cross = |i: usize, j: usize| u[i] * v[j] - u[j] * v[i];
                    0.5 * (cross(0, 1).powi(2) + cross(1, 2).powi(2) + cross(2, 0).powi(2)).sqrt()
                })
                .sum()
        };
        let coarse = triangles(&positions, &mesh.triangles, 4000);
        let named: HashSet<u32> = coarse.iter().flatten().copied().collect();
        assert!((3000..5000).contains(&named.len()), "{} vertices", named.len());
        let share = area(&coarse) / area(&mesh.triangles);
        assert!((0.93..1.02).contains(&share), "{share}");
        assert_eq!(coarse, triangles(&positions, &mesh.triangles, 4000));
        assert_eq!(triangles(&positions, &mesh.triangles, 1 << 20), mesh.triangles);
        assert!(triangles(&[], &[], 10).is_empty());
    }
}
