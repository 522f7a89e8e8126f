//! Evidence from a surface about how it stands, each kind on its own scale.

use super::cloud::Cloud;
use crate::surface::vec3::{Vec3, cross, dot, length, scaled, unit};

/// The area on which the shape would rest in one direction.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Base {
    /// Area that touches the ground, as a share of the shape's outline seen from there.
    pub contact: f64,
    /// Area of the convex hull of what touches the ground, as a share of the same; 0 where it would topple.
    pub support: f64,
}

impl Base {
    /// Large where feet or a cut stand flat on the ground, in [0, 1].
    pub fn firmness(self) -> f64 {
        (self.contact * self.support / 0.08).sqrt().min(1.0)
    }
}

/// The base with `down` to the ground.
pub(super) fn base(cloud: &Cloud, down: Vec3) -> Base {
    let ground = cloud.span(down).1;
    let (a, b) = across(down);
    let flat = |p: &Vec3| [dot(*p, a), dot(*p, b)];
    let touching = cloud.points.iter().zip(&cloud.normals);
    let touching =
        touching.filter(|(p, n)| dot(**p, down) > ground - 0.008 && dot(**n, down) > 0.9).count() as f64;
    let outline = hull(cloud.vertices.iter().map(flat).collect());
    let standing = cloud.vertices.iter().filter(|p| dot(**p, down) > ground - 0.012);
    let standing = hull(standing.map(flat).collect());
    let whole = area(&outline).max(f64::MIN_POSITIVE);
    let steady = standing.len() > 2 && is_inside(&standing, [0.0; 2]);
    Base {
        contact: touching / cloud.points.len() as f64 * cloud.area / whole,
        support: if steady { area(&standing) / whole } else { 0.0 },
    }
}

/// Where a shape is open, as the outward direction and the share of its outline that is missing; `None` where it is
/// closed except for slits and eyes.
pub(super) fn opening(cloud: &Cloud) -> Option<(Vec3, f64)> {
    let size = length(cloud.opening);
    let direction = unit(cloud.opening);
    let (a, b) = across(direction);
    let outline = area(&hull(cloud.vertices.iter().map(|p| [dot(*p, a), dot(*p, b)]).collect()));
    let share = size / outline.max(f64::MIN_POSITIVE);
    (share > 0.1).then_some((direction, share))
}

/// Whether a shape that is open in this direction is shallower than it is wide, as masks are.
pub(super) fn is_shallow(cloud: &Cloud, direction: Vec3) -> bool {
    let (low, high) = cloud.span(direction);
    high - low < 0.9 * length(cloud.opening).sqrt()
}

/// How far toward `front` and `up` the detailed places lie, as shares of the shape's length in that
/// direction. The edges of the base are left out.
pub(super) fn detail(cloud: &Cloud, roughness: &[f64], up: Vec3, front: Vec3) -> (f64, f64) {
    let (bottom, top) = cloud.span(up);
    let ground = bottom + 0.1 * (top - bottom);
    let (mut count, mut weight) = (0.0, 0.0);
    let (mut mean, mut rough) = ([0.0; 2], [0.0; 2]);
    for (p, r) in cloud.points.iter().zip(roughness) {
        let at = [dot(*p, front), dot(*p, up)];
        if at[1] > ground {
            count += 1.0;
            weight += r;
            for i in 0..2 {
                mean[i] += at[i];
                rough[i] += r * at[i];
            }
        }
    }
    let (near, far) = cloud.span(front);
    let length = [far - near, top - bottom];
    let [front, up] = std::array::from_fn(|i| {
        (rough[i] / f64::max(weight, f64::MIN_POSITIVE) - mean[i] / f64::max(count, 1.0))
            / length[i].max(f64::MIN_POSITIVE)
    });
    (front, up)
}

/// How far toward `front` the weight of a solid lies from the middle of its feet, as a share of its length: heads are
/// heavy, and tails are not. Of an open surface only a hint.
pub(super) fn weight(cloud: &Cloud, up: Vec3, front: Vec3) -> f64 {
    let (bottom, top) = cloud.span(up);
    let ground = bottom + 0.06 * (top - bottom);
    let feet = cloud.vertices.iter().filter(|p| dot(**p, up) < ground).map(|p| dot(*p, front));
    let (heel, toe) = feet.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(x), b.max(x)));
    let (back, nose) = cloud.span(front);
    // By Gauss: the integrals of 1 and x over a solid, from its surface.
    let (mut volume, mut moment) = (0.0, 0.0);
    for (p, n) in cloud.points.iter().zip(&cloud.normals) {
        let (x, n) = (dot(*p, front), dot(*n, front));
        volume += x * n;
        moment += 0.5 * x * x * n;
    }
    let center = moment / volume;
    let ahead = (center - 0.5 * (heel + toe)) / (nose - back).max(f64::MIN_POSITIVE);
    if ahead.is_finite() { ahead } else { 0.0 }
}

/// Two directions perpendicular to `direction` and each other.
pub(super) fn across(direction: Vec3) -> (Vec3, Vec3) {
    let least = (0..3).min_by(|i, j| direction[*i].abs().total_cmp(&direction[*j].abs())).unwrap_or(0);
    let mut other = [0.0; 3];
    other[least] = 1.0;
    let a = unit(cross(direction, other));
    (a, cross(direction, a))
}

/// `v` turned about the unit vector `axis`.
pub(super) fn rotated(v: Vec3, axis: Vec3, angle_rad: f64) -> Vec3 {
    let (sin, cos) = angle_rad.sin_cos();
    let (side, along) = (cross(axis, v), scaled(axis, dot(axis, v) * (1.0 - cos)));
    std::array::from_fn(|i| v[i] * cos + side[i] * sin + along[i])
}

fn turn(o: [f64; 2], a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - o[0]) * (b[1] - o[1]) - (a[1] - o[1]) * (b[0] - o[0])
}

/// The convex hull, counter-clockwise (Andrew's monotone chain).
fn hull(mut points: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    points.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    points.dedup();
    if points.len() < 3 {
        return points;
    }
    let half = |points: &mut dyn Iterator<Item = [f64; 2]>| {
        let mut chain: Vec<[f64; 2]> = Vec::new();
        for p in points {
            while let [.., a, b] = chain[..]
                && turn(a, b, p) <= 0.0
            {
                chain.pop();
            }
            chain.push(p);
        }
        chain.pop();
        chain
    };
    let mut whole = half(&mut points.iter().copied());
    whole.extend(half(&mut points.iter().rev().copied()));
    whole
}

fn area(polygon: &[[f64; 2]]) -> f64 {
    let next = polygon.iter().cycle().skip(1);
    0.5 * polygon.iter().zip(next).map(|(a, b)| a[0] * b[1] - a[1] * b[0]).sum::<f64>()
}

fn is_inside(polygon: &[[f64; 2]], p: [f64; 2]) -> bool {
    let next = polygon.iter().cycle().skip(1);
    polygon.iter().zip(next).all(|(a, b)| turn(*a, *b, p) > 0.0)
}
