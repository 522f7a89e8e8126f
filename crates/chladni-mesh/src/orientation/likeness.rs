//! How much a shape looks like a human head, from each side: the plain sample head is fitted to it in its
//! mirror plane.

use std::sync::OnceLock;

use rayon::prelude::*;

use super::cloud::Cloud;
use crate::samples::coarse_template;
use crate::surface::Bounds;
use crate::surface::vec3::{Vec3, add, dot, scaled, sub};

/// The pose of the sample head.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Likeness {
    pub up: Vec3,
    pub front: Vec3,
    /// Mean distance and disagreement of normals, as a share of the head's height.
    pub misfit: f64,
}

/// Points of the plain head, of height 1 about its middle, without the cut of its neck.
struct Model {
    points: Vec<Vec3>,
    normals: Vec<Vec3>,
}

/// For each pass: how many of the best poses it refines, its steps, and the model's points.
const LOOKS: [(usize, usize, usize); 3] = [(usize::MAX, 5, 120), (20, 16, 300), (8, 12, 1000)];
const MOST_POINTS: usize = 1000;
/// Directions of up that are tried.
const TURNS: usize = 18;

fn model() -> Option<&'static Model> {
    static MODEL: OnceLock<Option<Model>> = OnceLock::new();
    MODEL
        .get_or_init(|| {
            let head = coarse_template();
            let cloud = Cloud::of(&head.positions, &head.triangles, 3 * MOST_POINTS)?;
            let (bottom, top) = cloud.span([0.0, 1.0, 0.0]);
            let neck = bottom + 0.12 * (top - bottom);
            let kept = || cloud.points.iter().zip(&cloud.normals).filter(|(p, _)| p[1] > neck);
            let Bounds { low, high } = Bounds::of(kept().map(|(p, _)| *p));
            let (middle, height) = (scaled(add(low, high), 0.5), high[1] - low[1]);
            // Neighbors in the list are neighbors on the head, so take every n-th.
            let count = kept().count();
            let stride = (0.618 * count as f64) as usize | 1;
            let kept: Vec<(Vec3, Vec3)> =
                kept().map(|(p, n)| (scaled(sub(*p, middle), 1.0 / height), *n)).collect();
            let picked = (0..MOST_POINTS.min(count)).map(|i| kept[i * stride % count]);
            let (points, normals) = picked.unzip();
            Some(Model { points, normals })
        })
        .as_ref()
}

/// A similarity of the mirror plane: a turn, perhaps a reflection, a scale and a shift.
#[derive(Clone, Copy)]
struct Pose {
    cos: f64,
    sin: f64,
    /// −1 where front and back are exchanged.
    flip: f64,
    scale: f64,
    shift: [f64; 2],
}

impl Pose {
    fn turn(&self, [y, z]: [f64; 2]) -> [f64; 2] {
        [self.cos * y - self.sin * self.flip * z, self.sin * y + self.cos * self.flip * z]
    }
}

/// The mirror plane: its normal, two directions in it, and its distance from the origin.
struct Plane<'a> {
    cloud: &'a Cloud,
    normal: Vec3,
    axes: [Vec3; 2],
    offset: f64,
    size: f64,
}

/// The best poses of a head in a shape whose mirror plane is given, best first.
pub(super) fn likenesses(cloud: &Cloud, normal: Vec3, offset: f64) -> Vec<Likeness> {
    let Some(model) = model() else { return Vec::new() };
    let (e1, e2) = super::evidence::across(normal);
    let extent = |axis: Vec3| {
        let (low, high) = cloud.span(axis);
        high - low
    };
    let size = [normal, e1, e2].map(extent).into_iter().fold(0.0, f64::max);
    let plane = Plane { cloud, normal, axes: [e1, e2], offset, size };
    let mut starts = Vec::new();
    for turn in 0..TURNS {
        for flip in [1.0, -1.0] {
            starts.extend([0.45, 0.65, 0.95].map(|scale| plane.start(turn, flip, scale * size)));
        }
    }
    let mut poses: Vec<(f64, Pose)> = starts.into_iter().map(|start| (0.0, start)).collect();
    for (best, rounds, count) in LOOKS {
        poses.truncate(best);
        poses.par_iter_mut().for_each(|(misfit, pose)| {
            *pose = (0..rounds).fold(*pose, |pose, _| plane.closer(model, pose, count));
            *misfit = plane.misfit(model, pose, count);
        });
        poses.sort_by(|a, b| a.0.total_cmp(&b.0));
    }
    let likeness = |(misfit, pose): (f64, Pose)| {
        let in_space = |[y, z]: [f64; 2]| add(scaled(e1, y), scaled(e2, z));
        Likeness { up: in_space(pose.turn([1.0, 0.0])), front: in_space(pose.turn([0.0, 1.0])), misfit }
    };
    poses.into_iter().map(likeness).collect()
}

impl Plane<'_> {
    /// A head of this scale whose crown touches the shape's highest point.
    fn start(&self, turn: usize, flip: f64, scale: f64) -> Pose {
        let (sin, cos) = (turn as f64 * std::f64::consts::TAU / TURNS as f64).sin_cos();
        let pose = Pose { cos, sin, flip, scale, shift: [0.0; 2] };
        let (up, front) = (pose.turn([1.0, 0.0]), pose.turn([0.0, 1.0]));
        let along = |p: &Vec3, d: [f64; 2]| dot(*p, self.axes[0]) * d[0] + dot(*p, self.axes[1]) * d[1];
        let top = self.cloud.vertices.iter().map(|p| along(p, up)).fold(f64::NEG_INFINITY, f64::max);
        let slab = self.cloud.points.iter().filter(|p| along(p, up) > top - scale).map(|p| along(p, front));
        let (low, high) = slab.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(x), b.max(x)));
        let middle = if low > high { 0.0 } else { 0.5 * (low + high) };
        let shift = std::array::from_fn(|i| up[i] * (top - 0.5 * scale) + front[i] * middle);
        Pose { shift, ..pose }
    }

    /// A point of the model and its normal on the shape.
    fn placed(&self, pose: &Pose, p: Vec3, n: Vec3) -> (Vec3, Vec3) {
        let [y, z] = pose.turn([p[1], p[2]]);
        let at = [y * pose.scale + pose.shift[0], z * pose.scale + pose.shift[1]];
        let across = p[0] * pose.scale + self.offset;
        let [ny, nz] = pose.turn([n[1], n[2]]);
        let space = |x: f64, [y, z]: [f64; 2]| {
            add(scaled(self.normal, x), add(scaled(self.axes[0], y), scaled(self.axes[1], z)))
        };
        (space(across, at), space(n[0], [ny, nz]))
    }

    /// One step of iterated closest points over the similarities of the plane.
    fn closer(&self, model: &Model, pose: Pose, count: usize) -> Pose {
        let mut pairs: Vec<(f64, Vec3, Vec3)> = Vec::with_capacity(count);
        let tried = count.min(model.points.len());
        for (p, n) in model.points.iter().zip(&model.normals).take(count) {
            let (at, normal) = self.placed(&pose, *p, *n);
            let (i, distance) = self.cloud.nearest(at);
            if dot(self.cloud.normals[i], normal) > 0.3 {
                let q = self.cloud.points[i];
                let flat = [dot(q, self.normal) - self.offset, dot(q, self.axes[0]), dot(q, self.axes[1])];
                pairs.push((distance, *p, flat));
            }
        }
        pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
        pairs.truncate(tried * 4 / 5);
        if pairs.len() < 20 {
            return pose;
        }
        let share = 1.0 / pairs.len() as f64;
        let mean = |of: fn(&(f64, Vec3, Vec3)) -> Vec3| {
            pairs.iter().fold([0.0; 3], |sum, pair| add(sum, scaled(of(pair), share)))
        };
        let (p_mean, q_mean) = (mean(|pair| pair.1), mean(|pair| pair.2));
        let (mut c, mut spread, mut across) = ([[0.0; 2]; 2], 0.0, 0.0);
        for (_, p, q) in &pairs {
            let a = [p[1] - p_mean[1], p[2] - p_mean[2]];
            let b = [q[1] - q_mean[1], q[2] - q_mean[2]];
            for i in 0..2 {
                (0..2).for_each(|j| c[i][j] += b[i] * a[j]);
            }
            spread += a[0] * a[0] + a[1] * a[1] + p[0] * p[0];
            across += p[0] * q[0];
        }
        // The turn that maximizes the trace of its transpose with c, in closed form.
        let f = pose.flip;
        let (x, y) = (c[0][0] + f * c[1][1], c[1][0] - f * c[0][1]);
        let best = x.hypot(y).max(f64::MIN_POSITIVE);
        let scale =
            ((best + across) / spread.max(f64::MIN_POSITIVE)).clamp(0.25 * self.size, 1.2 * self.size);
        let turned = Pose { cos: x / best, sin: y / best, scale, ..pose };
        let [py, pz] = turned.turn([p_mean[1], p_mean[2]]);
        Pose { shift: [q_mean[1] - scale * py, q_mean[2] - scale * pz], ..turned }
    }

    fn misfit(&self, model: &Model, pose: &Pose, count: usize) -> f64 {
        let of = |(p, n): (&Vec3, &Vec3)| {
            let (at, normal) = self.placed(pose, *p, *n);
            let (i, distance) = self.cloud.nearest(at);
            let agreement = dot(self.cloud.normals[i], normal);
            (distance / pose.scale).min(0.25) + 0.08 * (1.0 - agreement)
        };
        let all = model.points.iter().zip(&model.normals).take(count);
        all.map(of).sum::<f64>() / count.min(model.points.len()).max(1) as f64
    }
}
