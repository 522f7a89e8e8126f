//! A shape with fewer triangles, for pictures so small that nobody sees the difference: vertices that lie in one
//! cell of a grid and face the same way become one of them (Rossignac and Borrel 1993). The desktop simplifies with
//! `meshopt`, whose C++ needs a compiler that a page's build does not have.

use std::collections::{HashMap, HashSet};

/// A cell, and the octant that its vertices face.
type Place = ([i32; 3], u8);

/// Triangles over about `wanted` of the vertices; `None` where that saves little.
pub fn coarse(
    positions: &[[f32; 3]],
    normals: &[[f32; 3]],
    triangles: &[[u32; 3]],
    wanted: usize,
) -> Option<Vec<[u32; 3]>> {
    if wanted == 0 || positions.len() < 2 * wanted {
        return None;
    }
    let mut edge = first_edge(positions, wanted);
    let mut places = places(positions, normals, edge);
    for _ in 0..3 {
        let found = places.iter().collect::<HashSet<_>>().len();
        edge *= (found as f32 / wanted as f32).sqrt();
        places = self::places(positions, normals, edge);
    }
    let stands_for = representatives(positions, &places);
    let mut seen = HashSet::new();
    let kept = triangles.iter().map(|corners| corners.map(|v| stands_for[v as usize])).filter(|corners| {
        let [a, b, c] = *corners;
        let mut sorted = *corners;
        sorted.sort_unstable();
        a != b && b != c && c != a && seen.insert(sorted)
    });
    Some(kept.collect())
}

/// Cells of this edge would be about as many as `wanted`, if the surface were that of the bounding box.
fn first_edge(positions: &[[f32; 3]], wanted: usize) -> f32 {
    let (mut low, mut high) = ([f32::MAX; 3], [f32::MIN; 3]);
    for p in positions {
        for i in 0..3 {
            (low[i], high[i]) = (low[i].min(p[i]), high[i].max(p[i]));
        }
    }
    let [x, y, z] = std::array::from_fn(|i| (high[i] - low[i]).max(1e-6));
    (2.0 * (x * y + y * z + z * x) / wanted as f32).sqrt()
}

fn places(positions: &[[f32; 3]], normals: &[[f32; 3]], edge: f32) -> Vec<Place> {
    let octant = |n: &[f32; 3]| (0..3).map(|i| u8::from(n[i] > 0.0) << i).sum();
    let cell = |p: &[f32; 3]| p.map(|c| (c / edge).floor() as i32);
    positions.iter().zip(normals).map(|(p, n)| (cell(p), octant(n))).collect()
}

/// For each vertex the one that stands for its place: that nearest to the mean of all there.
fn representatives(positions: &[[f32; 3]], places: &[Place]) -> Vec<u32> {
    let mut sums: HashMap<Place, ([f32; 3], f32)> = HashMap::new();
    for (p, place) in positions.iter().zip(places) {
        let (sum, count) = sums.entry(*place).or_default();
        (0..3).for_each(|i| sum[i] += p[i]);
        *count += 1.0;
    }
    let mut nearest: HashMap<Place, (f32, u32)> = HashMap::new();
    for (v, (p, place)) in (0..).zip(positions.iter().zip(places)) {
        let (sum, count) = sums[place];
        let distance = (0..3).map(|i| (p[i] - sum[i] / count).powi(2)).sum::<f32>();
        let best = nearest.entry(*place).or_insert((distance, v));
        if distance < best.0 {
            *best = (distance, v);
        }
    }
    places.iter().map(|place| nearest[place].1).collect()
}
