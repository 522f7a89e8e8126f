//! An eye: the socket, the ball with its iris, and two lids with their crease.

use super::Face;
use crate::samples::field::{carve, common, ellipsoid, join, rod, sphere, turned};
use crate::surface::vec3::{Vec3, length};

/// The middle of the ball, and its radius.
fn ball(f: &Face) -> (Vec3, f64) {
    let r = 0.148 * (1.0 + 0.20 * f.eyes.clamp(-1.0, 1.5));
    ([0.268 + 0.035 * f.spacing, 0.0, 0.572 - 0.5 * (r - 0.148)], r)
}

fn socket(p: Vec3, f: &Face) -> f64 {
    let ([x, y, _], r) = ball(f);
    ellipsoid(p, [x + 0.005, y + 0.012, 0.775], [0.19 + 0.6 * (r - 0.148), 0.115 + 0.6 * (r - 0.148), 0.13])
}

/// Where the eye is.
pub fn place(p: Vec3, f: &Face) -> f64 {
    let (center, r) = ball(f);
    socket(p, f).min(sphere(p, center, r + 0.035))
}

/// The eye in the face `d`.
pub fn add(d: f64, p: Vec3, f: &Face) -> f64 {
    let (center, r) = ball(f);
    let far = sphere(p, center, 0.45);
    if far > 0.1 {
        return d;
    }
    let size = r / 0.148;
    let q = turned(p, center, 2, 0.07).map(|x| x / size);
    let old = f.age.max(0.0);
    // The opening: a lens between two arcs; old lids hang.
    let top = 0.190 - 0.012 * old;
    let opening = common(
        rod(q, [0.0, -0.118, 0.0], [0.0, -0.118, 1.0], top, top),
        rod(q, [0.0, 0.142, 0.0], [0.0, 0.142, 1.0], 0.196, 0.196),
        0.02,
    );
    let lid = 0.148 + 0.034;
    let lids = carve(length(q) - lid, opening, 0.028) * size;
    // The fold above the upper lid, and the bag below.
    let arc = |middle: f64, radius: f64, shell: f64| {
        let across = f64::hypot(q[0], q[1] - middle) - radius;
        let side = (q[0].abs() - 0.15).max(0.0);
        (across * across + (length(q) - shell).powi(2) + side * side).sqrt()
    };
    let upper = if q[1] > 0.0 && q[2] > 0.0 { (arc(-0.118, 0.240, 0.190) - 0.007) * size } else { 1.0 };
    let bag = if q[1] < 0.0 { (arc(0.142, 0.252, 0.158) - 0.005 - 0.033 * old) * size } else { 1.0 };
    let iris = (length([q[0] + 0.004, q[1] - 0.006, q[2] - 0.176]) - 0.062) * size;
    let ball = carve((length(q) - 0.148) * size, iris, 0.016);
    let pupil = (length([q[0] + 0.004, q[1] - 0.006, q[2] - 0.118]) - 0.019) * size;
    let ball = join(ball, pupil, 0.008);
    let mut d = carve(d, socket(p, f), 0.10);
    d = join(d, lids, 0.045);
    d = join(d, bag, 0.06);
    d = carve(d, upper, 0.035);
    // The caruncle, where the lids meet beside the nose.
    let corner = (length([q[0] + 0.132, q[1] + 0.012, q[2] - 0.095]) - 0.018) * size;
    join(join(d, ball, 0.02), corner, 0.02)
}
