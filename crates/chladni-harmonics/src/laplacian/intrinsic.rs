//! Angles, weights and areas of triangles that are given only by their side lengths.

use super::cover::{Cover, next};

/// Area of a triangle with these side lengths, and the cotangent of the angle opposite to each side. A
/// triangle that rounding has flattened gets a tiny positive area; one whose corners lie in one place has none, and no
/// weight.
pub(super) fn cotangents(length: [f64; 3]) -> (f64, [f64; 3]) {
    let mut sorted = length;
    sorted.sort_by(|a, b| b.total_cmp(a));
    let [a, b, c] = sorted;
    if a == 0.0 {
        return (0.0, [0.0; 3]);
    }
    // Kahan's stable form of Heron's formula.
    let product = (a + (b + c)) * (c - (a - b)) * (c + (a - b)) * (a + (b - c));
    let area = (0.25 * product.max(0.0).sqrt()).max(1e-14 * a * a);
    let square = length.map(|l| l * l);
    let cotangent =
        std::array::from_fn(|i| (square[(i + 1) % 3] + square[(i + 2) % 3] - square[i]) / (4.0 * area));
    (area, cotangent)
}

/// Area · ∇φ of the hat function φ of each corner of a triangle with these side lengths, in the plane of
/// the triangle: half of the opposite side, rotated by 90°.
pub(crate) fn hat_slopes(length: [f64; 3]) -> [[f64; 2]; 3] {
    let [along, _, back] = length;
    let x = (along * along + back * back - length[1] * length[1]) / (2.0 * along);
    let y = 2.0 * cotangents(length).0 / along;
    // Corners at (0, 0), (along, 0) and (x, y).
    [[-0.5 * y, 0.5 * (x - along)], [0.5 * y, -0.5 * x], [0.0, 0.5 * along]]
}

/// (cot β + cot β') / 2 of every edge between two different vertices, times `share`. On a Delaunay cover
/// only rounding makes them negative; negative values are clamped to 0.
pub(super) fn cotangent_weights(cover: &Cover, share: f64) -> Vec<(u32, u32, f64)> {
    let cotangent: Vec<f64> = cover.length.as_chunks::<3>().0.iter().flat_map(|l| cotangents(*l).1).collect();
    let mut edges = Vec::with_capacity(cover.tail.len() / 2);
    for h in 0..cover.tail.len() {
        let twin = cover.twin[h] as usize;
        let (u, v) = (cover.tail[h], cover.tail[next(h as u32) as usize]);
        // An intrinsic edge may lead from a vertex to itself; it contributes nothing.
        if h < twin && u != v {
            let weight = 0.5 * (cotangent[h] + cotangent[twin]) * share;
            edges.push((u, v, weight.max(0.0)));
        }
    }
    edges
}

/// The mixed Voronoi area (Meyer et al. 2003) of each vertex, times `share`. All are positive, and they sum
/// to the area of the surface.
pub(super) fn mixed_voronoi_areas(cover: &Cover, vertices: usize, share: f64) -> Vec<f64> {
    let mut mass = vec![0.0; vertices];
    for (f, length) in cover.length.as_chunks::<3>().0.iter().enumerate() {
        let (area, cotangent) = cotangents(*length);
        let parts = mixed_voronoi_parts(length.map(|l| l * l), area, cotangent);
        for (i, part) in parts.into_iter().enumerate() {
            mass[cover.tail[3 * f + i] as usize] += part * share;
        }
    }
    mass
}

/// The share of a triangle's area that each corner gets. Corner i lies between sides i and i − 1 and
/// opposite to side i + 1.
pub(super) fn mixed_voronoi_parts(square: [f64; 3], area: f64, cotangent: [f64; 3]) -> [f64; 3] {
    let obtuse = cotangent.iter().position(|c| *c < 0.0);
    std::array::from_fn(|i| {
        let (next, previous) = ((i + 1) % 3, (i + 2) % 3);
        match obtuse {
            None => (square[i] * cotangent[i] + square[previous] * cotangent[previous]) / 8.0,
            Some(o) if o == next => area / 2.0,
            Some(_) => area / 4.0,
        }
    })
}
