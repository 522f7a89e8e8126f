//! The fold meter: triangles that a displacement turns over, and how far μ can go before that happens.

use rayon::prelude::*;

use crate::Surface;
use chladni_mesh::surface::vec3::{Vec3, cross, dot, sub};
use chladni_mesh::surface::{corners, doubled_area_normal};

/// Triangles below this share of the largest area have no reliable normal.
const NEGLIGIBLE_AREA: f64 = 1e-12;

/// Triangles per task.
const PIECE: usize = 4096;

/// The triangles whose normal points backward, ⟨N, N'⟩ < 0, when vertices move from `base` to
/// `moved` (N each), ascending. Triangles without area in `base` are not counted.
///
/// A part that a layer truly rotates by more than 90° counts as folded too.
pub fn flipped_triangles(surface: &Surface, base: &[Vec3], moved: &[Vec3]) -> Vec<u32> {
    // In one pass: which are turned over, and how large the largest is.
    let pieces: Vec<(f64, Vec<(u32, f64)>)> = surface
        .triangles
        .par_chunks(PIECE)
        .enumerate()
        .map(|(piece, triangles)| {
            let (mut largest, mut turned) = (0.0_f64, Vec::new());
            for (i, t) in triangles.iter().enumerate() {
                let before = doubled_area_normal(corners(base, t));
                let square = dot(before, before);
                largest = largest.max(square);
                if dot(before, doubled_area_normal(corners(moved, t))) < 0.0 {
                    turned.push(((piece * PIECE + i) as u32, square));
                }
            }
            (largest, turned)
        })
        .collect();
    let largest = pieces.iter().map(|piece| piece.0).fold(0.0, f64::max);
    let smallest = negligible(largest);
    let turned = pieces.into_iter().flat_map(|piece| piece.1);
    turned.filter(|(_, square)| *square > smallest).map(|(triangle, _)| triangle).collect()
}

/// The largest |s| with the sign of `direction` at which no more than `allowed` triangles of `base` +
/// s·`displacement` are folded; `None` if more never fold.
///
/// ⟨N, N(s)⟩ is a quadratic in s for each triangle, so its first root is known in closed form
/// and nothing is searched.
pub fn furthest(
    surface: &Surface,
    base: &[Vec3],
    displacement: &[Vec3],
    direction: f64,
    allowed: usize,
) -> Option<f64> {
    let smallest = smallest_square(surface, base);
    let sign = if direction < 0.0 { -1.0 } else { 1.0 };
    let mut roots: Vec<f64> = surface
        .triangles
        .par_iter()
        .filter_map(|t| first_fold(base, displacement, *t, sign, smallest))
        .collect();
    if roots.len() <= allowed {
        return None;
    }
    let (_, root, _) = roots.select_nth_unstable_by(allowed, f64::total_cmp);
    Some(sign * *root)
}

/// The smallest s > 0 at which the triangle, moved by sign·s·d, has ⟨N, N(s)⟩ = 0.
fn first_fold(base: &[Vec3], d: &[Vec3], t: [u32; 3], sign: f64, smallest: f64) -> Option<f64> {
    let [a, b, c] = t.map(|v| v as usize);
    let (e, f) = (sub(base[b], base[a]), sub(base[c], base[a]));
    let (u, w) = (sub(d[b], d[a]), sub(d[c], d[a]));
    let normal = cross(e, f);
    let c0 = dot(normal, normal);
    if c0 <= smallest {
        return None;
    }
    let c1 = sign * (dot(normal, cross(e, w)) + dot(normal, cross(u, f)));
    let c2 = dot(normal, cross(u, w));
    // In 1/s the quadratic c0/s² + c1/s + c2 has its largest root at the first fold, and stays
    // well behaved where c2 vanishes.
    let discriminant = c1 * c1 - 4.0 * c0 * c2;
    if discriminant < 0.0 {
        return None;
    }
    let inverse = (-c1 + discriminant.sqrt()) / (2.0 * c0);
    (inverse > 0.0).then(|| 1.0 / inverse).filter(|s| s.is_finite())
}

/// (2A)² below which a triangle of `base` is ignored.
fn smallest_square(surface: &Surface, base: &[Vec3]) -> f64 {
    let squares = surface.triangles.par_iter().map(|t| {
        let n = doubled_area_normal(corners(base, t));
        dot(n, n)
    });
    negligible(squares.reduce(|| 0.0, f64::max))
}

/// (2A)² of a triangle that is negligible beside one of `largest_square`.
fn negligible(largest_square: f64) -> f64 {
    largest_square * NEGLIGIBLE_AREA * NEGLIGIBLE_AREA
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::base_and_target;
    use chladni_mesh::surface::vec3::{add, scaled};

    #[test]
    fn the_furthest_mu_is_where_the_first_triangle_turns() {
        let (_, surface, base, target) = base_and_target();
        let x = &base.positions;
        let d: Vec<Vec3> = target.points.iter().zip(x).map(|(r, x)| sub(*r, *x)).collect();
        let at = |s: f64| -> Vec<Vec3> { x.iter().zip(&d).map(|(x, d)| add(*x, scaled(*d, s))).collect() };
        for direction in [-1.0, 1.0] {
            for allowed in [0, 3] {
                let s = furthest(&surface, x, &d, direction, allowed).unwrap();
                assert!(s * direction > 0.0);
                assert!(flipped_triangles(&surface, x, &at(s * (1.0 - 1e-9))).len() <= allowed);
                assert!(flipped_triangles(&surface, x, &at(s * (1.0 + 1e-9))).len() > allowed);
            }
        }
    }

    #[test]
    fn one_sliver_does_not_end_it_where_a_share_may_fold() {
        let (_, surface, base, target) = base_and_target();
        let x = &base.positions;
        let mut d: Vec<Vec3> = target.points.iter().zip(x).map(|(r, x)| sub(*r, *x)).collect();
        let smooth = furthest(&surface, x, &d, -1.0, 0).unwrap();
        // One vertex that is out of place by far.
        d[17] = scaled(x[17], -30.0);
        let allowed = (0.01 * surface.triangles.len() as f64) as usize;
        let (first, most) =
            (furthest(&surface, x, &d, 1.0, 0).unwrap(), furthest(&surface, x, &d, 1.0, allowed).unwrap());
        assert!(first < 0.1 && most > 5.0 * first, "{first}, {most}, {smooth}");
    }

    #[test]
    fn nothing_folds_where_nothing_moves() {
        let (_, surface, base, _) = base_and_target();
        let still = vec![[0.0; 3]; base.positions.len()];
        assert_eq!(furthest(&surface, &base.positions, &still, -1.0, 0), None);
        let shift = vec![[0.3, 0.1, 0.2]; base.positions.len()];
        assert_eq!(furthest(&surface, &base.positions, &shift, 1.0, 0), None);
        assert!(flipped_triangles(&surface, &base.positions, &base.positions).is_empty());
        let mirrored: Vec<Vec3> = base.positions.iter().map(|p| [-p[0], p[1], p[2]]).collect();
        assert!(!flipped_triangles(&surface, &base.positions, &mirrored).is_empty());
    }
}
