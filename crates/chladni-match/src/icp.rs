//! Iterative closest points: refines the similarity that aligns a template with a shape.
//!
//! Symmetric point-to-plane residuals (Rusinkiewicz, *A Symmetric Objective Function for ICP*, SIGGRAPH
//! 2019), samples of both surfaces, and Geman–McClure weights w = c⁴/(c² + d²)², which suppress pairs that
//! are farther apart than a few c.

use glam::{DMat3, DQuat, DVec3};
use rayon::prelude::*;

use crate::Similarity;
use crate::field::Field;
use crate::relief::{Correlation, RADIUS, Relief};
use crate::samples::Sample;
use crate::surface::UnitSurface;
use chladni_mesh::surface::solve_small;

/// A surface to align, its samples, and its coarse lookup.
pub(crate) struct Sampled<'a> {
    pub surface: &'a UnitSurface,
    pub samples: Vec<Sample>,
    pub field: Field,
    pub relief: Relief,
}

/// The point found near a query: position, normal, squared distance.
struct Near {
    point: DVec3,
    normal: DVec3,
    distance_squared: f64,
}

impl Sampled<'_> {
    fn first(&self, count: usize) -> &[Sample] {
        &self.samples[..count.min(self.samples.len())]
    }

    /// The nearest point within `reach` that is not on an open edge.
    fn near(&self, query: DVec3, reach: f64, look: Look) -> Option<Near> {
        match look {
            Look::Coarse => {
                let (_, s) = self.field.near(query)?;
                let distance_squared = s.point.distance_squared(query);
                (distance_squared < reach * reach).then_some(Near {
                    point: s.point,
                    normal: s.normal,
                    distance_squared,
                })
            }
            Look::Exact => {
                // The nearest point is not farther than any sample; this bound prunes most boxes.
                let bound = self.field.near(query).map(|(_, s)| s.point.distance(query) + 1e-9);
                let at = self.surface.closest(query, bound.map_or(reach, |b| b.min(reach)))?;
                (!self.surface.on_boundary(&at.on)).then(|| Near {
                    point: DVec3::from_array(at.point),
                    normal: self.surface.smooth_normal(&at.on),
                    distance_squared: at.distance_squared,
                })
            }
        }
    }
}

/// The two surfaces to align.
pub(crate) struct Pair<'a> {
    pub shape: Sampled<'a>,
    pub template: Sampled<'a>,
    /// Landmarks as (shape point, template point), each in its surface's own coordinates.
    pub landmarks: &'a [(DVec3, DVec3)],
    /// The scale s of every pose, if it is not fitted.
    pub scale: Option<f64>,
}

/// How precisely the nearest point is found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Look {
    /// A sample nearby, from the [`Field`].
    Coarse,
    /// The nearest point of the surface.
    Exact,
}

/// The parameters of one run of ICP.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Schedule {
    /// The number of samples of each surface.
    pub samples: usize,
    /// The largest number of iterations.
    pub iterations: usize,
    /// c at the first and at the last iteration, in shape diagonals.
    pub reach: (f64, f64),
    /// Weight of the point-to-point part of the residual.
    pub point_weight: f64,
    pub look: Look,
}

/// A template point (in template coordinates), the shape point that it is drawn to, and both normals.
struct Link {
    q: DVec3,
    p: DVec3,
    normal_q: DVec3,
    normal_p: DVec3,
}

/// Normals farther apart than this belong to different sides (cos 70°).
const NORMAL_LIMIT: f64 = 0.34;

fn links(pair: &Pair, pose: &Similarity, schedule: &Schedule, c: f64) -> Vec<Link> {
    let back = pose.inverse();
    let r = pose.rotation_matrix();
    let reach = 4.0 * c;
    let facing = |l: &Link| l.normal_q.dot(l.normal_p) > NORMAL_LIMIT;
    let from_shape = pair.shape.first(schedule.samples).par_iter().with_min_len(64).filter_map(|s| {
        let at = pair.template.near(back.at(s.point), reach * back.scale, schedule.look)?;
        Some(Link { q: at.point, p: s.point, normal_q: r * at.normal, normal_p: s.normal })
    });
    let from_template = pair.template.first(schedule.samples).par_iter().with_min_len(64).filter_map(|s| {
        let at = pair.shape.near(pose.at(s.point), reach, schedule.look)?;
        Some(Link { q: s.point, p: at.point, normal_q: r * s.normal, normal_p: at.normal })
    });
    from_shape.chain(from_template).filter(facing).collect()
}

/// The normal equations of the rows n·(Tq − p) and, with `point_weight`, of the rows Tq − p.
struct System {
    matrix: [[f64; 7]; 7],
    right: [f64; 7],
}

impl System {
    /// Adds `w` (direction · (δ of x) + residual)², where δ = ω×x + t + σx.
    fn add(&mut self, x: DVec3, direction: DVec3, residual: f64, w: f64) {
        let turn = x.cross(direction);
        let row = [turn.x, turn.y, turn.z, direction.x, direction.y, direction.z, x.dot(direction)];
        for i in 0..7 {
            self.right[i] -= w * row[i] * residual;
            for j in 0..7 {
                self.matrix[i][j] += w * row[i] * row[j];
            }
        }
    }

    fn add_link(&mut self, x: DVec3, p: DVec3, normal: DVec3, plane: f64, point: f64) {
        self.add(x, normal, (x - p).dot(normal), plane);
        for axis in DVec3::AXES {
            self.add(x, axis, (x - p).dot(axis), point);
        }
    }
}

/// Refines `pose` (template to shape coordinates). Returns it unchanged if nothing is near.
pub(crate) fn refine(pair: &Pair, mut pose: Similarity, schedule: &Schedule) -> Similarity {
    let (first, last) = schedule.reach;
    for step in 0..schedule.iterations {
        let along = step as f64 / (schedule.iterations.max(2) - 1) as f64;
        let c = first * (last / first).powf((along * 1.5).min(1.0));
        let Some((next, moved)) = improve(pair, &pose, schedule, c) else { return pose };
        pose = next;
        if moved < 1e-9 && c <= last * 1.001 {
            break;
        }
    }
    pose
}

/// One Gauss–Newton step, and how far it moves points at unit distance.
fn improve(pair: &Pair, pose: &Similarity, schedule: &Schedule, c: f64) -> Option<(Similarity, f64)> {
    let links = links(pair, pose, schedule, c);
    if links.len() + pair.landmarks.len() < 4 {
        return None;
    }
    // Rotation and scale are about the centroid of the linked points.
    let center = links.iter().map(|l| l.p).sum::<DVec3>() / links.len().max(1) as f64;
    let mut system = System { matrix: [[0.0; 7]; 7], right: [0.0; 7] };
    let mut total = 0.0;
    for link in &links {
        let q = pose.at(link.q);
        let d2 = q.distance_squared(link.p);
        let w = (c * c / (c * c + d2)).powi(2);
        let normal = (link.normal_p + link.normal_q).normalize_or(link.normal_p);
        system.add_link(q - center, link.p - center, normal, w, w * schedule.point_weight);
        total += w;
    }
    for (p, q) in pair.landmarks {
        let w = (total * 0.5 / pair.landmarks.len() as f64).max(1e-3);
        system.add_link(pose.at(*q) - center, *p - center, DVec3::ZERO, 0.0, w);
    }
    if pair.scale.is_some() {
        (0..7).for_each(|i| (system.matrix[i][6], system.matrix[6][i]) = (0.0, 0.0));
        (system.matrix[6][6], system.right[6]) = (1.0, 0.0);
    }
    let size = (system.matrix[3][3] + system.matrix[4][4] + system.matrix[5][5]).max(1e-12);
    for i in 0..7 {
        system.matrix[i][i] += size * 1e-9;
    }
    let x = solve_small(system.matrix, system.right)?;
    let mut turn = DVec3::new(x[0], x[1], x[2]);
    turn *= (0.5 / turn.length()).min(1.0); // no more than half a radian at once
    let shift = DVec3::new(x[3], x[4], x[5]);
    let growth = x[6].clamp(-0.25, 0.25);
    let rotation = DMat3::from_quat(DQuat::from_scaled_axis(turn));
    let scale = growth.exp();
    let about = Similarity::new(scale, rotation, center + shift - rotation * center * scale);
    let moved = turn.length() + shift.length() + growth.abs();
    let next = orthonormal(&pose.then(&about));
    (moved.is_finite() && next.scale > 1e-6 && next.scale < 1e6).then_some((next, moved))
}

/// Removes the rounding errors of many products from R.
fn orthonormal(pose: &Similarity) -> Similarity {
    let q = DQuat::from_mat3(&pose.rotation_matrix()).normalize();
    Similarity::new(pose.scale, DMat3::from_quat(q), DVec3::from_array(pose.translation))
}

/// How badly a pose fits, in [0, 1]: the mean of d²/(c² + d²) over samples of both surfaces, where d² also
/// measures how far the normals disagree, times 1 − ρ, where ρ ≥ 0 is the correlation between the reliefs
/// of the two surfaces. 0 is a perfect fit.
pub(crate) fn misfit(pair: &Pair, pose: &Similarity, samples: usize, c: f64, look: Look) -> f64 {
    let back = pose.inverse();
    let r = pose.rotation_matrix();
    let mut relief = Correlation::default();
    let mut mean = |from: &Sampled, onto: &Sampled, pose: &Similarity, turn: DMat3, unit: f64| {
        let around =
            |surface: &Sampled| if std::ptr::eq(surface, &pair.shape) { RADIUS } else { RADIUS * back.scale };
        let mut cost = 0.0;
        for (i, s) in from.first(samples).iter().enumerate() {
            let near = onto.near(pose.at(s.point), 5.0 * c / unit, look);
            let Some((near, j)) = near.and_then(|near| {
                let (j, _) = onto.field.near(near.point)?;
                Some((near, j))
            }) else {
                cost += 1.0;
                continue;
            };
            let cos = (turn * s.normal).dot(near.normal);
            // Opposite normals cost as much as a distance of 2 c.
            let d2 = near.distance_squared * unit * unit + c * c * 2.0 * (1.0 - cos).max(0.0);
            cost += d2 / (c * c + d2);
            if cos > NORMAL_LIMIT {
                relief.add(from.relief.height(i, around(from)), onto.relief.height(j, around(onto)));
            }
        }
        cost / from.first(samples).len().max(1) as f64
    };
    let forth = mean(&pair.shape, &pair.template, &back, r.transpose(), pose.scale);
    let home = mean(&pair.template, &pair.shape, pose, r, 1.0);
    // A template that covers more than the shape can only be near it in part; the shape's own samples
    // therefore count more.
    (0.65 * forth + 0.35 * home) * (1.0 - relief.value().max(0.0))
}
