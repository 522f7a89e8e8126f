//! Evens out a displacement where it would fold the surface: its mean stays, its folds go.

use chladni_mesh::surface::Rows;
use chladni_mesh::surface::vec3::{Vec3, add, scaled, sub};
use rayon::prelude::*;

use crate::Surface;

/// Takes `sweeps` steps of each vertex's displacement toward the mean of its neighbors', whole steps at the corners
/// of the `folded` triangles and shorter ones in `rings` rings around them.
pub(super) fn level(
    surface: &Surface,
    neighbors: &Rows,
    folded: &[u32],
    rings: usize,
    sweeps: usize,
    displacement: &mut [Vec3],
) {
    let mut weight = vec![0.0_f64; surface.vertices()];
    let mut front: Vec<u32> = folded.iter().flat_map(|t| surface.triangles[*t as usize]).collect();
    front.sort_unstable();
    front.dedup();
    let mut active = Vec::new();
    for ring in 0..=rings {
        front.iter().for_each(|v| weight[*v as usize] = 1.0 - ring as f64 / (rings + 1) as f64);
        let mut next: Vec<u32> = front.iter().flat_map(|v| neighbors.row(*v as usize)).copied().collect();
        next.retain(|v| weight[*v as usize] == 0.0);
        next.sort_unstable();
        next.dedup();
        active.append(&mut front);
        front = next;
    }
    for _ in 0..sweeps {
        let leveled = |v: &u32| {
            let (own, ring) = (displacement[*v as usize], neighbors.row(*v as usize));
            let sum = ring.iter().fold([0.0; 3], |sum, w| add(sum, displacement[*w as usize]));
            let mean = if ring.is_empty() { own } else { scaled(sum, 1.0 / ring.len() as f64) };
            add(own, scaled(sub(mean, own), weight[*v as usize]))
        };
        let new: Vec<Vec3> = active.par_iter().with_min_len(512).map(leveled).collect();
        for (v, u) in active.iter().zip(new) {
            displacement[*v as usize] = u;
        }
    }
}
