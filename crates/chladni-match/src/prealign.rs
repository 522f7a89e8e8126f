//! Where a template lies on a shape, from any pose and size.

use chladni_task::Task;
use glam::{DMat3, DQuat, DVec3};
use rayon::prelude::*;

use crate::eigen::symmetric_eigen;
use crate::icp::{Pair, Schedule, misfit, refine};
use crate::samples::{Sample, spread};
use crate::similarity::fit_pairs;
use crate::surface::Surface;
use crate::{MatchError, Scaling, Similarity};

/// The pose that fits best and how clear that is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Pose {
    /// Template to shape, both in surface coordinates.
    pub similarity: Similarity,
    /// Misfit in [0, 1]; 0 is perfect.
    pub misfit: f64,
    /// Misfit of the best pose that is turned by at least 20° or otherwise clearly different.
    pub runner_up: Option<f64>,
}

/// One pass of the search: how many candidates enter, and how they are refined and judged.
struct Sieve {
    keep: usize,
    schedule: Schedule,
    judge: (usize, f64),
}

const fn schedule(samples: usize, iterations: usize, first: f64, last: f64, point_weight: f64) -> Schedule {
    Schedule { samples, iterations, reach: (first, last), point_weight, scaling: Scaling::Free }
}

/// Candidates are thinned out as the look at each gets closer.
const SIEVES: [Sieve; 3] = [
    Sieve { keep: 160, schedule: schedule(150, 8, 0.15, 0.06, 0.3), judge: (250, 0.05) },
    Sieve { keep: 24, schedule: schedule(600, 15, 0.06, 0.03, 0.05), judge: (1000, 0.03) },
    Sieve { keep: 5, schedule: schedule(3000, 40, 0.03, 0.02, 0.01), judge: (3000, 0.03) },
];

/// Samples drawn of each surface.
const SAMPLES: usize = 3000;

/// Searches all rotations at several sizes; with three landmarks or more, they give the start.
pub(crate) fn prealign(
    shape: &Surface,
    template: &Surface,
    landmarks: &[(DVec3, DVec3)],
    seed: u64,
    task: &Task,
) -> Result<Pose, MatchError> {
    let shape_samples = spread(shape, SAMPLES, seed);
    let template_samples = spread(template, SAMPLES, seed ^ 0x5eed);
    let pair = Pair {
        shape,
        template,
        shape_samples: &shape_samples,
        template_samples: &template_samples,
        landmarks,
    };
    if landmarks.len() >= 3 {
        let start = fit_pairs(landmarks.iter().map(|(p, q)| (*q, *p, 1.0)), Scaling::Free)?;
        return Ok(settle(&pair, start));
    }
    let mut candidates = hypotheses(shape, template, &shape_samples, &template_samples);
    let mut scored = judge(&pair, &candidates, 100, 0.1, task)?;
    for sieve in &SIEVES {
        scored.truncate(sieve.keep);
        let stage = task.stage("aligning", scored.len() as u64);
        candidates = scored
            .par_iter()
            .map(|(pose, _)| {
                task.check()?;
                let refined = refine(&pair, *pose, &sieve.schedule);
                stage.advance(1);
                Ok(refined)
            })
            .collect::<Result<_, MatchError>>()?;
        scored = distinct(judge(&pair, &candidates, sieve.judge.0, sieve.judge.1, task)?);
    }
    let &(similarity, misfit) = scored.first().ok_or(MatchError::Degenerate)?;
    Ok(Pose { similarity, misfit, runner_up: scored.get(1).map(|s| s.1) })
}

/// The last sieve alone, for a start that is known.
fn settle(pair: &Pair, start: Similarity) -> Pose {
    let sieve = &SIEVES[SIEVES.len() - 1];
    let similarity = refine(pair, start, &sieve.schedule);
    Pose { similarity, misfit: misfit(pair, &similarity, sieve.judge.0, sieve.judge.1), runner_up: None }
}

/// Poses with their misfits, best first.
fn judge(
    pair: &Pair,
    poses: &[Similarity],
    samples: usize,
    c: f64,
    task: &Task,
) -> Result<Vec<(Similarity, f64)>, MatchError> {
    let mut scored = poses
        .par_iter()
        .map(|pose| {
            task.check()?;
            Ok((*pose, misfit(pair, pose, samples, c)))
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

/// Starting poses: principal axes in their 24 orders and signs, the files' own axes, and an even
/// covering of all rotations; centroid on centroid, at the size the spreads tell and around it.
fn hypotheses(
    shape: &Surface,
    template: &Surface,
    shape_samples: &[Sample],
    template_samples: &[Sample],
) -> Vec<Similarity> {
    let spread_of = |samples: &[Sample]| {
        let sum: f64 = samples.iter().map(|s| s.point.length_squared()).sum();
        (sum / samples.len().max(1) as f64).sqrt()
    };
    let size = spread_of(shape_samples) / spread_of(template_samples).max(1e-9);
    let axes = |surface: &Surface| {
        let (_, e) = symmetric_eigen(surface.second_moments());
        let (a, b) = (DVec3::from_array(e[0]), DVec3::from_array(e[1]));
        DMat3::from_cols(a, b, a.cross(b))
    };
    let (to, from) = (axes(shape), axes(template).transpose());
    let mut rotations: Vec<DMat3> = cube_rotations().iter().map(|r| to * *r * from).collect();
    rotations.push(DMat3::IDENTITY);
    rotations.extend((0..ROTATIONS).map(|i| DMat3::from_quat(super_fibonacci(i, ROTATIONS))));
    let mut poses = Vec::with_capacity(3 * rotations.len());
    for factor in [1.0, 0.7, 1.4] {
        // Centroids are the origins of both surfaces.
        poses.extend(rotations.iter().map(|r| Similarity::new(size * factor, *r, DVec3::ZERO)));
    }
    poses
}

/// Rotations in the covering: neighbours are about 30° apart.
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
