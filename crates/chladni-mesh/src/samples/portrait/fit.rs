//! The sliders that make a head most like a given one.
//!
//! A model whose few parameters are fitted to a surface, as in Blanz & Vetter, "A morphable model for the synthesis of 3D
//! faces" (SIGGRAPH 1999), here an implicit one: its distance is small at each point of the surface, in the robust least
//! squares of Gauss and Newton.

use rayon::prelude::*;

use super::{Face, SLIDERS};
use crate::samples::field::gradient;
use crate::samples::head_parts::PARTS;
use crate::surface::solve_small;
use crate::surface::vec3::{Vec3, dot, length, scaled, sub};

/// The sliders, then logarithm of a scale, turns about x, y and z in radians, and a shift.
const UNKNOWNS: usize = SLIDERS.len() + 7;
type Row = [f64; UNKNOWNS];

/// The head of the sliders that is most like a surface, and where the surface lies on it.
#[derive(Clone, Debug, PartialEq)]
pub struct FittedPortrait {
    /// In the order of [`SLIDERS`], each in [−1, 1].
    pub sliders: [f64; SLIDERS.len()],
    /// For each of the n points about how far it is from the borders of that head's parts, as
    /// [`head_borders`](crate::samples::head_borders) says.
    pub borders: Vec<[f64; PARTS.len()]>,
    /// How far each of the n points is from that head, in units of half a head's height, ≥ 0.
    pub distance: Vec<f64>,
}

/// A point to which the sliders are fitted.
#[derive(Clone, Copy, Debug)]
pub struct FitPoint {
    /// Where it is, with the surface in about the pose and size of a sample head.
    pub at: Vec3,
    /// How much it counts, ≥ 0: 0 beside the head, as on shoulders.
    pub weight: f64,
    /// About how far it is from the borders of each part, as [`head_borders`](crate::samples::head_borders) says: it keeps
    /// eyes on eyes where the surface alone would let them slide.
    pub borders: [f64; PARTS.len()],
}

/// Fits the sliders, and a pose near the given one, to `points` of a surface. Some may be of other things, and of the head
/// some may lack.
pub fn fitted_portrait(points: &[FitPoint]) -> FittedPortrait {
    /// Points whose distance counts.
    const POINTS: usize = 2500;
    /// How far off a point counts a quarter, from the first step to the last.
    const REACH: [f64; 10] = [0.08, 0.08, 0.07, 0.06, 0.05, 0.04, 0.04, 0.04, 0.04, 0.04];
    /// How much the borders of features count beside the distance, likewise.
    const BORDERS: [f64; 10] = [1.0, 1.0, 1.0, 0.7, 0.5, 0.3, 0.2, 0.1, 0.1, 0.1];
    let counted: Vec<FitPoint> = points.iter().copied().filter(|point| point.weight > 0.0).collect();
    let stride = (counted.len() / POINTS).max(1);
    let used: Vec<FitPoint> = counted.into_iter().skip(stride / 2).step_by(stride).collect();
    let mut x = [0.0; UNKNOWNS];
    for (reach, features) in REACH.into_iter().zip(BORDERS) {
        x = step(&x, &used, reach, features);
    }
    let (face, pose) = (face(&x), Pose::of(&x));
    let laid = |point: &FitPoint| {
        let p = pose.at(point.at);
        let on = onto(&face, p);
        // A socket is a hollow: from before it, the way to the surface leads out as well as in.
        (face.borders_seen(p, on), length(sub(p, on)))
    };
    let (borders, distance) = points.par_iter().map(laid).unzip();
    FittedPortrait { sliders: sliders(&x), borders, distance }
}

fn sliders(x: &Row) -> [f64; SLIDERS.len()] {
    std::array::from_fn(|i| x[i].clamp(-1.0, 1.0))
}

fn face(x: &Row) -> Face {
    Face::of(sliders(x))
}

fn at(face: &Face, [x, y, z]: Vec3) -> f64 {
    face.solid([x.abs(), y, z])
}

/// The point of the head near `p`: steps of Newton along the slope of the distance.
fn onto(face: &Face, mut p: Vec3) -> Vec3 {
    for _ in 0..4 {
        let slope = gradient(&|p| at(face, p), p, 1e-3);
        let d = at(face, p) / dot(slope, slope).max(0.25);
        p = std::array::from_fn(|i| p[i] - (d * slope[i]).clamp(-0.1, 0.1));
    }
    p
}

/// From the surface to the head.
struct Pose {
    rows: [Vec3; 3],
    shift: Vec3,
}

impl Pose {
    fn of(x: &Row) -> Self {
        let [log_scale, a, b, c, shift @ ..] = [0, 1, 2, 3, 4, 5, 6].map(|i| x[SLIDERS.len() + i]);
        let ((sa, ca), (sb, cb), (sc, cc)) = (a.sin_cos(), b.sin_cos(), c.sin_cos());
        let rows = [
            [cb * cc, sa * sb * cc - ca * sc, ca * sb * cc + sa * sc],
            [cb * sc, sa * sb * sc + ca * cc, ca * sb * sc - sa * cc],
            [-sb, sa * cb, ca * cb],
        ];
        Self { rows: rows.map(|row| scaled(row, log_scale.exp())), shift }
    }

    fn at(&self, p: Vec3) -> Vec3 {
        std::array::from_fn(|i| dot(self.rows[i], p) + self.shift[i])
    }
}

/// Features by the numbers of their parts: nose, eyes, mouth and ears.
const FEATURES: [usize; 4] = [0, 2, 3, 7];

/// The residuals of a point: its distance, and by how much its distances from the borders of features are others.
fn residuals(face: &Face, pose: &Pose, point: &FitPoint) -> [f64; 1 + FEATURES.len()] {
    let p = pose.at(point.at);
    let borders = face.borders(p);
    std::array::from_fn(|i| match i {
        0 => at(face, p),
        _ => borders[FEATURES[i - 1]] - point.borders[FEATURES[i - 1]],
    })
}

/// One step of Gauss and Newton from `x`, in which a distance of `reach` counts a quarter.
fn step(x: &Row, used: &[FitPoint], reach: f64, features: f64) -> Row {
    /// A slider at its end costs this as a mean squared distance: little beside a feature that is there.
    const PRIOR: f64 = 5e-6;
    const STEP: f64 = 0.01;
    /// Borders farther than this say little.
    const NEAR: f64 = 0.15;
    let moved: Vec<(Face, Pose, f64)> = (0..UNKNOWNS)
        .map(|i| {
            // Inward at the ends, where a slider stops.
            let by = if x[i] > 0.5 { -STEP } else { STEP };
            let mut y = *x;
            y[i] += by;
            (face(&y), Pose::of(&y), by)
        })
        .collect();
    let (here, pose) = (face(x), Pose::of(x));
    let total = used.iter().map(|point| point.weight).sum::<f64>().max(f64::MIN_POSITIVE);
    let equations = |point: &FitPoint| {
        let r = residuals(&here, &pose, point);
        let slopes: Vec<[f64; 1 + FEATURES.len()]> = moved
            .iter()
            .map(|(face, pose, by)| {
                let there = residuals(face, pose, point);
                std::array::from_fn(|k| (there[k] - r[k]) / by)
            })
            .collect();
        let weights: [f64; 1 + FEATURES.len()] = std::array::from_fn(|k| {
            let counts = match k {
                0 => 1.0,
                _ if point.borders[FEATURES[k - 1]].abs() < NEAR => features,
                _ => 0.0,
            };
            counts * point.weight / total * (reach * reach / (reach * reach + r[k] * r[k])).powi(2)
        });
        (weights, r, slopes)
    };
    let rows: Vec<_> = used.par_iter().map(equations).collect();
    let (mut matrix, mut right) = ([[0.0; UNKNOWNS]; UNKNOWNS], [0.0; UNKNOWNS]);
    for (weights, r, slopes) in rows {
        for k in (0..weights.len()).filter(|k| weights[*k] > 0.0) {
            for i in 0..UNKNOWNS {
                right[i] -= weights[k] * r[k] * slopes[i][k];
                for j in 0..UNKNOWNS {
                    matrix[i][j] += weights[k] * slopes[i][k] * slopes[j][k];
                }
            }
        }
    }
    for i in 0..UNKNOWNS {
        matrix[i][i] += PRIOR;
        if i < SLIDERS.len() {
            right[i] -= PRIOR * x[i];
        }
    }
    let Some(change) = solve_small(matrix, right) else { return *x };
    std::array::from_fn(|i| {
        let y = x[i] + change[i].clamp(-0.5, 0.5);
        if i < SLIDERS.len() { y.clamp(-1.0, 1.0) } else { y }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples::{head_borders, head_part_within, head_parts, sample};

    #[test]
    fn the_sliders_of_a_head_are_found_from_another_pose() {
        let name = "portrait?width=0.40,jaw=-0.60,nose=-0.50";
        let head = sample(name).unwrap();
        let borders = head_borders(name, &head.positions).unwrap();
        let moved = |[x, y, z]: Vec3| [1.03 * x + 0.01, 1.03 * y + 0.02 * z, 1.03 * z - 0.02 * y];
        let point =
            |(p, borders): (&Vec3, _)| FitPoint { at: moved(*p), weight: f64::from(p[1] > -1.0), borders };
        let points: Vec<FitPoint> = head.positions.iter().zip(borders).map(point).collect();
        let fitted = fitted_portrait(&points);
        let found =
            |slider: &str| fitted.sliders[SLIDERS.iter().position(|(name, _)| *name == slider).unwrap()];
        for (slider, value) in [("width", 0.4), ("jaw", -0.6), ("nose", -0.5), ("eyes", 0.0)] {
            assert!((found(slider) - value).abs() < 0.2, "{slider}: {}", found(slider));
        }
        let known = head_parts(name, &head.positions).unwrap();
        let same = known.iter().zip(&fitted.borders).filter(|(a, b)| **a == head_part_within(b)).count();
        assert!(same * 100 > known.len() * 98, "{same} of {}", known.len());
        let mut distance = fitted.distance.clone();
        distance.sort_by(f64::total_cmp);
        assert!(distance[distance.len() / 2] < 0.01);
    }
}
