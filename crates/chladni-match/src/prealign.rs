//! Finds the pose of a template on a shape, from any initial pose and size.

use chladni_mesh::symmetric_eigen;
use chladni_task::Task;
use glam::{DMat3, DQuat, DVec3};
use rayon::prelude::*;

use crate::field::Field;
use crate::icp::{Look, Pair, Sampled, Schedule, misfit, refine};
use crate::relief::Relief;
use crate::samples::{Sample, spread};
use crate::similarity::fit_pairs_at;
use crate::surface::UnitSurface;
use crate::{MatchError, Similarity};

/// The pose that fits best, and how clearly it does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Pose {
    /// Template to shape, both in surface coordinates.
    pub similarity: Similarity,
    /// Misfit in [0, 1]; 0 is perfect.
    pub misfit: f64,
    /// Misfit of the best among the poses that differ clearly, for example by a turn of at least 20°.
    pub runner_up: Option<f64>,
}

/// One pass of the search: how many candidates enter, and how they are refined and judged.
struct Sieve {
    keep: usize,
    schedule: Schedule,
    /// Samples and c of the misfit.
    judge: (usize, f64),
}

const fn sieve(
    keep: usize,
    look: Look,
    samples: usize,
    iterations: usize,
    reach: (f64, f64),
    point_weight: f64,
    judge: (usize, f64),
) -> Sieve {
    let schedule = Schedule { samples, iterations, reach, point_weight, look };
    Sieve { keep, schedule, judge }
}

/// The fewer candidates remain, the more precisely each is tested.
const SIEVES: [Sieve; 4] = [
    sieve(600, Look::Coarse, 150, 6, (0.15, 0.08), 0.3, (250, 0.06)),
    sieve(100, Look::Coarse, 500, 12, (0.08, 0.04), 0.2, (600, 0.04)),
    sieve(16, Look::Exact, 600, 12, (0.05, 0.03), 0.05, (1500, 0.03)),
    sieve(3, Look::Exact, 2000, 40, (0.03, 0.02), 0.01, (3000, 0.03)),
];

/// The number of samples of each surface.
const SAMPLES: usize = 3000;

/// Searches all rotations, at several places and, unless `scale` gives the size, at several sizes. Three
/// landmarks or more determine the start instead.
pub(crate) fn prealign(
    shape: &UnitSurface,
    template: &UnitSurface,
    landmarks: &[(DVec3, DVec3)],
    scale: Option<f64>,
    seed: u64,
    task: &Task,
) -> Result<Pose, MatchError> {
    let sampled = |surface, seed| {
        let samples = spread(surface, SAMPLES, seed);
        let (field, relief) = (Field::new(&samples), Relief::new(&samples));
        Sampled { surface, samples, field, relief }
    };
    let (sampled_shape, sampled_template) = (sampled(shape, seed), sampled(template, seed ^ 0x5eed));
    let pair = Pair { shape: sampled_shape, template: sampled_template, landmarks, scale };
    if landmarks.len() >= 3 {
        let start = fit_pairs_at(landmarks.iter().map(|(p, q)| (*q, *p, 1.0)), scale)?;
        return Ok(settle(&pair, start));
    }
    let mut scored = judge(&pair, &hypotheses(&pair), (150, 0.1), Look::Coarse, task)?;
    for sieve in &SIEVES {
        scored.truncate(sieve.keep);
        let stage = task.stage("aligning", scored.len() as u64);
        let candidates = scored
            .par_iter()
            .map(|(pose, _)| {
                task.check()?;
                let refined = refine(&pair, *pose, &sieve.schedule);
                stage.advance(1);
                Ok(refined)
            })
            .collect::<Result<Vec<_>, MatchError>>()?;
        scored = distinct(judge(&pair, &candidates, sieve.judge, sieve.schedule.look, task)?);
    }
    let &(similarity, misfit) = scored.first().ok_or(MatchError::Degenerate)?;
    Ok(Pose { similarity, misfit, runner_up: scored.get(1).map(|s| s.1) })
}

/// Runs only the last sieve, from a known start.
fn settle(pair: &Pair, start: Similarity) -> Pose {
    let Sieve { schedule, judge: (samples, c), .. } = &SIEVES[SIEVES.len() - 1];
    let similarity = refine(pair, start, schedule);
    Pose { similarity, misfit: misfit(pair, &similarity, *samples, *c, schedule.look), runner_up: None }
}

/// Poses with their misfits, best first.
fn judge(
    pair: &Pair,
    poses: &[Similarity],
    (samples, c): (usize, f64),
    look: Look,
    task: &Task,
) -> Result<Vec<(Similarity, f64)>, MatchError> {
    let mut scored = poses
        .par_iter()
        .map(|pose| {
            task.check()?;
            Ok((*pose, misfit(pair, pose, samples, c, look)))
        })
        .collect::<Result<Vec<_>, MatchError>>()?;
    scored.sort_by(|a, b| a.1.total_cmp(&b.1));
    Ok(scored)
}

/// Drops each pose that is nearly the same as a better one.
fn distinct(scored: Vec<(Similarity, f64)>) -> Vec<(Similarity, f64)> {
    let mut kept: Vec<(Similarity, f64)> = Vec::new();
    for (pose, score) in scored {
        let same = kept.iter().any(|(other, _)| {
            let turn = DQuat::from_mat3(&pose.rotation_matrix())
                .angle_between(DQuat::from_mat3(&other.rotation_matrix()));
            let shift = DVec3::from_array(pose.translation).distance(DVec3::from_array(other.translation));
            turn < 20_f64.to_radians() && shift < 0.15 && (pose.scale / other.scale).ln().abs() < 0.2
        });
        if !same {
            kept.push((pose, score));
        }
    }
    kept
}

/// Starting poses. The rotations are those of the principal axes in their 24 orders and signs, of the
/// files' own axes, and of an even covering of all rotations. Each is tried with the centroids on each
/// other, at the size that follows from the spreads and at sizes near it. For templates that show more or
/// less than the shape, it is also tried with the centroid of one surface on places all over the other.
fn hypotheses(pair: &Pair) -> Vec<Similarity> {
    let spread_of = |samples: &[Sample]| {
        let sum: f64 = samples.iter().map(|s| s.point.length_squared()).sum();
        (sum / samples.len().max(1) as f64).sqrt()
    };
    let usual = || spread_of(&pair.shape.samples) / spread_of(&pair.template.samples).max(1e-9);
    let (size, centered, placed): (_, &[f64], &[f64]) = match pair.scale {
        Some(scale) => (scale, &[1.0], &[1.0]),
        None => (usual(), &[1.0, 0.8, 1.25], &[1.4, 2.0]),
    };
    let axes = |surface: &UnitSurface| {
        let (_, e) = symmetric_eigen(surface.second_moments());
        let (a, b) = (DVec3::from_array(e[0]), DVec3::from_array(e[1]));
        DMat3::from_cols(a, b, a.cross(b))
    };
    let (to, from) = (axes(pair.shape.surface), axes(pair.template.surface).transpose());
    let mut rotations: Vec<DMat3> = cube_rotations().iter().map(|r| to * *r * from).collect();
    rotations.push(DMat3::IDENTITY);
    rotations.extend((0..ROTATIONS).map(|i| DMat3::from_quat(super_fibonacci(i, ROTATIONS))));
    let mut poses = Vec::new();
    // The centroids are the origins of both surfaces.
    for factor in centered {
        poses.extend(rotations.iter().map(|r| Similarity::new(size * factor, *r, DVec3::ZERO)));
    }
    let on_template = places(&pair.template.samples);
    let on_shape = places(&pair.shape.samples);
    for r in &rotations {
        for factor in placed {
            let scale = size * factor;
            poses.extend(on_template.iter().map(|q| Similarity::new(scale, *r, *r * *q * -scale)));
            poses.extend(on_shape.iter().map(|p| Similarity::new(size / factor, *r, *p)));
        }
    }
    poses
}

/// Points between the centroid and places spread over the surface, farthest first.
fn places(samples: &[Sample]) -> Vec<DVec3> {
    const PLACES: usize = 8;
    let mut chosen: Vec<DVec3> = Vec::with_capacity(PLACES);
    let mut distance: Vec<f64> = samples.iter().map(|s| s.point.length_squared()).collect();
    while chosen.len() < PLACES {
        let Some((i, _)) = distance.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1)) else { break };
        let point = samples[i].point;
        for (d, s) in distance.iter_mut().zip(samples) {
            *d = d.min(s.point.distance_squared(point));
        }
        chosen.push(point);
    }
    chosen.into_iter().map(|p| p * 0.6).collect()
}

/// Number of rotations in the covering; neighboring ones are about 30° apart.
const ROTATIONS: usize = 500;

/// Point i of n of an even covering of the rotations (Alexa, *Super-Fibonacci Spirals*, CVPR 2022).
fn super_fibonacci(i: usize, n: usize) -> DQuat {
    const PSI: f64 = 1.533_751_168_755_204_2;
    let s = i as f64 + 0.5;
    let (r, big_r) = ((s / n as f64).sqrt(), (1.0 - s / n as f64).sqrt());
    let alpha = std::f64::consts::TAU * s / std::f64::consts::SQRT_2;
    let beta = std::f64::consts::TAU * s / PSI;
    DQuat::from_xyzw(r * alpha.sin(), r * alpha.cos(), big_r * beta.sin(), big_r * beta.cos()).normalize()
}

/// The 24 rotations of a cube.
fn cube_rotations() -> Vec<DMat3> {
    let mut rotations = Vec::with_capacity(24);
    for i in 0..3 {
        for j in (0..3).filter(|j| *j != i) {
            for (s, t) in [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)] {
                let (a, b) = (DVec3::AXES[i] * s, DVec3::AXES[j] * t);
                rotations.push(DMat3::from_cols(a, b, a.cross(b)));
            }
        }
    }
    rotations
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_covering_leaves_no_rotation_far_away() {
        let covering: Vec<DQuat> = (0..ROTATIONS).map(|i| super_fibonacci(i, ROTATIONS)).collect();
        let worst = (0..2000)
            .map(|i| super_fibonacci(i, 2000) * DQuat::from_rotation_x(0.37))
            .map(|q| covering.iter().map(|c| c.dot(q).abs()).fold(0.0, f64::max))
            .fold(1.0, f64::min);
        let degrees = 2.0 * worst.min(1.0).acos().to_degrees();
        assert!(degrees < 35.0, "{degrees}");
        assert_eq!(cube_rotations().len(), 24);
    }
}
