//! An octopus.

use super::field::{carve, ellipsoid, join, rod, sphere, turned};
use super::surface_nets::{Grid, surface};
use crate::TriMesh;
use crate::surface::vec3::{Vec3, length, sub};

/// Rods that an arm is made of.
const JOINTS: usize = 18;
/// Rods that share a ball.
const STRETCH: usize = 3;
/// Width of the seams between arms and body.
const SEAM: f64 = 0.16;

/// One arm: its rods' ends and radii, and balls around all of them and around each few neighbors.
struct Arm {
    joints: [(Vec3, f64); JOINTS + 1],
    whole: Ball,
    stretches: [Ball; JOINTS / STRETCH],
}

/// Around some rods: at least as near as they are.
#[derive(Clone, Copy)]
struct Ball {
    center: Vec3,
    radius: f64,
}

impl Ball {
    fn around(joints: &[(Vec3, f64)]) -> Self {
        let center = joints[joints.len() / 2].0;
        let radius = joints.iter().map(|(p, r)| length(sub(*p, center)) + r).fold(0.0, f64::max);
        Self { center, radius }
    }

    fn distance(&self, p: Vec3) -> f64 {
        length(sub(p, self.center)) - self.radius
    }
}

/// A body, two eyes and eight arms, four on either side of the mirror x = 0. It looks along +z,
/// y is up.
pub(crate) fn octopus() -> TriMesh {
    let arms = arms();
    let grid = Grid {
        center: [0.0, 0.3, 0.0],
        low: [-2.3, -1.2, -2.3],
        high: [2.3, 1.9, 2.3],
        cell: 0.042,
        growth: 0.0,
    };
    surface(|p| solid(p, &arms), &grid)
}

/// Those at x > 0, from the front to the back.
fn arms() -> [Arm; 4] {
    // Direction from straight ahead, length, and how far it sways to either side, in radians.
    [(0.38, 2.0, 0.40), (1.12, 2.15, 0.45), (1.88, 2.1, 0.35), (2.62, 2.0, 0.25)]
        .map(|(heading, long, sway)| arm(heading, long, sway))
}

/// For each vertex 0 on the body, or the number of the arm that is nearest: odd at x > 0, even at x < 0.
pub(crate) fn limbs(mesh: &TriMesh) -> Vec<u8> {
    let arms = arms();
    let limb = |p: &Vec3| {
        let [x, y, z] = *p;
        let sides = [[x, y, z], [-x, y, z]];
        let all = arms.iter().flat_map(|arm| sides.map(|p| arm.distance(p, f64::INFINITY)));
        let body = sides.map(body).into_iter().fold(f64::INFINITY, f64::min);
        let nearest = all.zip(1..).fold((body, 0), |least, arm| if arm.0 < least.0 { arm } else { least });
        nearest.1
    };
    mesh.positions.iter().map(limb).collect()
}

/// Mantle, head and the eye at x > 0, with the seams between them.
fn body(p: Vec3) -> f64 {
    let mantle = ellipsoid(turned(p, [0.0, 0.95, -0.20], 0, 0.38), [0.0; 3], [0.62, 0.80, 0.64]);
    let head = ellipsoid(p, [0.0, 0.12, 0.02], [0.46, 0.42, 0.44]);
    join(join(mantle, head, 0.30), rod(p, [0.20, 0.26, 0.22], [0.31, 0.32, 0.37], 0.19, 0.19), 0.08)
}

/// The half at x ≥ 0; arms of the other half reach into it.
fn solid(p: Vec3, arms: &[Arm; 4]) -> f64 {
    let mirrored = [-p[0], p[1], p[2]];
    let mut d = body(p);
    for (arm, p) in arms.iter().flat_map(|arm| [(arm, p), (arm, mirrored)]) {
        // A seam ends where the arm is this much farther away.
        d = join(d, arm.distance(p, d + SEAM), SEAM);
    }
    // Pupils: hollows in the eyes.
    carve(d, sphere(p, [0.36, 0.335, 0.57], 0.08), 0.04)
}

/// An arm that leaves the body, sinks to the ground, sways along it and curls up at its tip.
fn arm(heading: f64, long: f64, sway: f64) -> Arm {
    let step = long / JOINTS as f64;
    let mut p = [0.16 * heading.sin(), -0.12, 0.16 * heading.cos()];
    let mut joints = [(p, 0.0); JOINTS + 1];
    for (i, joint) in joints.iter_mut().enumerate() {
        let t = i as f64 / JOINTS as f64;
        *joint = (p, 0.20 * (1.0 - t).powf(0.8) + 0.062);
        let sink = -0.75 * (1.0 - 2.2 * t).max(0.0);
        let rise = sink + 3.1 * ((t - 0.5) / 0.5).max(0.0).powf(1.5);
        let turn = heading + sway * (4.6 * t).sin();
        let ((s, c), (up, along)) = (turn.sin_cos(), rise.sin_cos());
        p = [p[0] + step * along * s, p[1] + step * up, p[2] + step * along * c];
    }
    let stretches = std::array::from_fn(|i| Ball::around(&joints[i * STRETCH..=(i + 1) * STRETCH]));
    Arm { joints, whole: Ball::around(&joints), stretches }
}

impl Arm {
    /// Or `most`, where the arm is farther away.
    fn distance(&self, p: Vec3, most: f64) -> f64 {
        // Far away the ball around the arm is near enough.
        let outside = self.whole.distance(p);
        if outside >= most {
            return most;
        }
        if outside > 0.2 {
            return outside;
        }
        let mut nearest = most;
        for (i, ball) in self.stretches.iter().enumerate() {
            if ball.distance(p) < nearest {
                let rods = self.joints[i * STRETCH..=(i + 1) * STRETCH].windows(2);
                let rods = rods.map(|pair| rod(p, pair[0].0, pair[1].0, pair[0].1, pair[1].1));
                nearest = rods.fold(nearest, f64::min);
            }
        }
        nearest
    }
}
