//! Room for triangles that would fold, and the rest of the surface follows.

use chladni_harmonics::HeatStep;
use chladni_mesh::surface::vec3::{Vec3, add, cross, dot, scaled, sub};
use chladni_mesh::surface::{corners, doubled_area_normal};
use rayon::prelude::*;

use super::PIECE;
use crate::Surface;

/// A triangle gets room if the smaller stretch of its plane is below this (negative: folded) …
const LEAST_STRETCH: f64 = 0.15;
/// … and it is given this much.
const AIM: f64 = 0.6;
/// More than 1, because the neighbors take some of the room back.
const OVERSHOOT: f64 = 1.5;

/// Moves the surface, which `displacement` moves, so that folded triangles open again: their gradients, projected on
/// those that do not fold, are put together by one screened Poisson equation (M + tS) w = t ∇·(P(J) − J), whose
/// matrix is that of the heat step of length t, `time`. The solution fades out at a distance of √t.
pub(super) fn unfold(
    surface: &Surface,
    base: &[Vec3],
    step: &HeatStep,
    time: f64,
    mass: &[f64],
    displacement: &mut [Vec3],
) {
    let room = |t: &[u32; 3]| Some((*t, room(corners(base, t), corners(displacement, t))?));
    let rooms: Vec<Vec<_>> =
        surface.triangles.par_chunks(PIECE).map(|ts| ts.iter().filter_map(room).collect()).collect();
    if rooms.iter().all(Vec::is_empty) {
        return;
    }
    let mut load = vec![[0.0; 3]; displacement.len()];
    for (t, forces) in rooms.into_iter().flatten() {
        for (v, f) in t.into_iter().zip(forces) {
            load[v as usize] = add(load[v as usize], f);
        }
    }
    let solve = |c: usize| {
        let signal: Vec<f32> = load.iter().zip(mass).map(|(l, a)| (time * l[c] / a) as f32).collect();
        step.apply(&signal)
    };
    let moved: Vec<Vec<f64>> = (0..3).into_par_iter().map(solve).collect();
    displacement.par_iter_mut().enumerate().for_each(|(v, u)| {
        (0..3).for_each(|c| u[c] += OVERSHOOT * moved[c][v]);
    });
}

/// A ∇φ_i · (P(J) − J) for the corners of a triangle, where J is the gradient of its deformation in the plane of its
/// rest; `None` where it needs no room or has no area.
fn room([a, b, c]: [Vec3; 3], [ua, ub, uc]: [Vec3; 3]) -> Option<[Vec3; 3]> {
    let (e, f) = (sub(b, a), sub(c, a));
    let normal = doubled_area_normal([a, b, c]);
    let (doubled, l) = (dot(normal, normal).sqrt(), dot(e, e).sqrt());
    // A sliver has no gradient.
    if doubled.is_nan() || doubled <= 1e-9 * dot(f, f).max(l * l) {
        return None;
    }
    let (right, height) = (scaled(e, 1.0 / l), doubled / l);
    let up = scaled(cross(normal, right), 1.0 / doubled);
    let along = dot(f, right);
    let of_right = scaled(add(e, sub(ub, ua)), 1.0 / l);
    let of_up = scaled(sub(add(f, sub(uc, ua)), scaled(of_right, along)), 1.0 / height);
    let (p, q, r, s) = (dot(of_right, right), dot(of_up, right), dot(of_right, up), dot(of_up, up));
    // J is the sum of a turned scaling and a turned reflection, whose sizes are half the sum and half the difference
    // of the signed singular values.
    let (turn, flip) = ([0.5 * (p + s), 0.5 * (r - q)], [0.5 * (p - s), 0.5 * (r + q)]);
    let (whole, part) = (turn[0].hypot(turn[1]), flip[0].hypot(flip[1]));
    if whole - part >= LEAST_STRETCH {
        return None;
    }
    let (large, small) = ((whole + part).max(AIM), AIM);
    let sized =
        |v: [f64; 2], old: f64, new: f64| if old > 1e-12 { v.map(|x| x * new / old) } else { [new, 0.0] };
    let turned = sized(turn, whole, 0.5 * (large + small));
    let flipped = sized(flip, part, 0.5 * (large - small));
    let (t, g) = ([turned[0] - turn[0], turned[1] - turn[1]], [flipped[0] - flip[0], flipped[1] - flip[1]]);
    let more_right = add(scaled(right, t[0] + g[0]), scaled(up, t[1] + g[1]));
    let more_up = add(scaled(right, g[1] - t[1]), scaled(up, t[0] - g[0]));
    let area = 0.5 * doubled;
    let of_c = scaled(more_up, area / height);
    let of_b = sub(scaled(more_right, area / l), scaled(of_c, along / l));
    Some([scaled(add(of_b, of_c), -1.0), of_b, of_c])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_triangle_that_turned_over_is_pushed_open_and_one_that_only_moved_is_left_alone() {
        let rest = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.3, 1.0, 0.0]];
        assert_eq!(room(rest, [[0.3, -2.0, 1.0]; 3]), None);
        assert_eq!(room(rest, [[0.0; 3], [0.0, 0.0, 3.0], [0.0; 3]]), None, "steep is not folded");
        let over = room(rest, [[0.0; 3], [0.0; 3], [0.0, -1.5, 0.0]]).unwrap();
        assert!(over[2][1] > 0.0 && over[0][1] < 0.0, "{over:?}");
        let sum = over.iter().fold([0.0; 3], |s, f| add(s, *f));
        assert!(dot(sum, sum).sqrt() < 1e-12, "it moves nothing as a whole");
        let sliver = [[0.0; 3], [1.0, 0.0, 0.0], [0.5, 1e-12, 0.0]];
        assert_eq!(room(sliver, [[0.0; 3], [0.0; 3], [0.0, -1.0, 0.0]]), None);
    }
}
