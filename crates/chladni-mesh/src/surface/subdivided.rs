//! Finer triangles on the same surface.

use std::collections::HashMap;

use super::vec3::{Vec3, add};

/// Every triangle cut in four at the middles of its edges, which are added to `positions`.
///
/// # Panics
/// If a triangle names a vertex that is not there.
pub fn subdivided(positions: &mut Vec<Vec3>, triangles: &[[u32; 3]]) -> Vec<[u32; 3]> {
    let mut middles = HashMap::new();
    let mut finer = Vec::with_capacity(4 * triangles.len());
    for &[a, b, c] in triangles {
        let [ab, bc, ca] = [[a, b], [b, c], [c, a]].map(|[p, q]| {
            *middles.entry([p.min(q), p.max(q)]).or_insert_with(|| {
                let (p, q) = (positions[p as usize], positions[q as usize]);
                positions.push(add(p, q).map(|x| 0.5 * x));
                positions.len() as u32 - 1
            })
        });
        finer.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
    }
    finer
}
