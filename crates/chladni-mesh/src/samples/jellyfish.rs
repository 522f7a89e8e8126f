//! A jellyfish.

use super::field::{carve, ellipsoid, join, rod};
use super::surface_nets::{Grid, surface};
use crate::TriMesh;
use crate::surface::vec3::{Vec3, length, sub};

/// Rods that a tentacle is made of.
const JOINTS: usize = 16;

/// A strand of rods that hangs down, and a ball around it.
struct Strand {
    joints: [(Vec3, f64); JOINTS + 1],
    center: Vec3,
    reach: f64,
}

/// An umbrella, tentacles from its rim and frilled arms from its middle.
pub(crate) fn jellyfish() -> TriMesh {
    // Of the half at x ≥ 0: heading from straight ahead, length, phase of its waves.
    let tentacles =
        [(0.26, 1.55, 0.3), (0.85, 1.75, 1.7), (1.45, 1.5, 2.9), (2.1, 1.8, 4.0), (2.78, 1.6, 5.1)].map(
            |(heading, long, phase)| strand(heading, (0.80, -0.04), long, (0.064, 0.044), (0.085, phase)),
        );
    let arms = [(0.95, 1.25, 0.9), (2.2, 1.35, 2.2)]
        .map(|(heading, long, phase)| strand(heading, (0.24, 0.22), long, (0.115, 0.055), (0.08, phase)));
    let grid = Grid {
        center: [0.0, 0.0, 0.0],
        low: [-1.25, -2.1, -1.25],
        high: [1.25, 1.15, 1.25],
        cell: 0.0385,
        growth: 0.0,
    };
    surface(|p| solid(p, &tentacles, &arms), &grid)
}

fn solid(p: Vec3, tentacles: &[Strand], arms: &[Strand]) -> f64 {
    let mirrored = [-p[0], p[1], p[2]];
    let around = p[0].atan2(p[2]);
    // The rim is scalloped between the tentacles, and the umbrella ribbed a little above it.
    let scallop = 0.5 + 0.5 * (16.0 * around).cos();
    let low = ((0.35 - p[1]) / 0.5).clamp(0.0, 1.0);
    let ribbed = 1.0 + 0.025 * scallop * low;
    let q = [p[0] / ribbed, p[1], p[2] / ribbed];
    let umbrella = ellipsoid(q, [0.0, 0.02, 0.0], [0.95, 0.86, 0.95]);
    let below = p[1] + 0.16 + 0.05 * scallop;
    let hollow = ellipsoid(p, [0.0, -0.20, 0.0], [0.80, 0.70, 0.80]);
    let mut d = carve(carve(umbrella, below, 0.10), hollow, 0.08);
    for tentacle in tentacles {
        d = join(d, tentacle.distance(p).min(tentacle.distance(mirrored)), 0.07);
    }
    let stalk = rod(p, [0.0, 0.50, 0.0], [0.0, 0.25, 0.0], 0.24, 0.20);
    d = join(d, stalk, 0.20);
    for arm in arms {
        d = join(d, join(arm.distance(p), arm.distance(mirrored), 0.08), 0.12);
    }
    d
}

/// A strand in direction `heading` that leaves at a radius and height, with the radii of its ends, and waves.
fn strand(
    heading: f64,
    (radius, height): (f64, f64),
    long: f64,
    (thick, thin): (f64, f64),
    (sway, phase): (f64, f64),
) -> Strand {
    let joint = |i: usize| {
        let t = i as f64 / JOINTS as f64;
        // It flares, and waves the more the farther down, along and across its direction.
        let out = radius + 0.10 * t + sway * t.sqrt() * (phase + 7.0 * t).sin();
        let turn = heading + 0.9 * sway * t * (2.0 * phase + 6.0 * t).cos() / radius.max(0.3);
        let (s, c) = turn.sin_cos();
        ([out * s, height - long * t, out * c], thick + (thin - thick) * t)
    };
    let joints: [(Vec3, f64); JOINTS + 1] = std::array::from_fn(joint);
    let center = joints[JOINTS / 2].0;
    let reach = joints.iter().map(|(p, r)| length(sub(*p, center)) + r).fold(0.0, f64::max);
    Strand { joints, center, reach }
}

impl Strand {
    fn distance(&self, p: Vec3) -> f64 {
        // Far away the ball around it is near enough.
        let outside = length(sub(p, self.center)) - self.reach;
        if outside > 0.2 {
            return outside;
        }
        let rods = self.joints.windows(2).map(|pair| rod(p, pair[0].0, pair[1].0, pair[0].1, pair[1].1));
        rods.fold(f64::INFINITY, f64::min)
    }
}
